// VTK's volume mappers and its depth buffer, in a library that only benchmarks load.
#include <algorithm>
#include <vtkActor.h>
#include <vtkAutoInit.h>
#include <vtkCamera.h>
#include <vtkCellArray.h>
#include <vtkColorTransferFunction.h>
#include <vtkFixedPointVolumeRayCastMapper.h>
#include <vtkFloatArray.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkOpenGLGPUVolumeRayCastMapper.h>
#include <vtkPiecewiseFunction.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkShortArray.h>
#include <vtkUnsignedCharArray.h>
#include <vtkVolume.h>
#include <vtkVolumeProperty.h>

#include "apps/bench/depth_images.h"
#include "apps/bench/measure.h"
#include "apps/bench/render.h"

VTK_MODULE_INIT(vtkRenderingVolumeOpenGL2)

using namespace trephine::bench;

extern "C" bool trephine_render_peer(const RenderPeerRequest& request, vtkRenderWindow* window,
                                     RenderPeerAnswer& answer) {
  vtkNew<vtkShortArray> scalars;
  scalars->SetArray(request.voxels, static_cast<vtkIdType>(request.size) * request.size * request.size, 1);
  vtkNew<vtkImageData> image;
  image->SetDimensions(request.size, request.size, request.size);
  image->SetSpacing(request.spacing, request.spacing, request.spacing);
  image->SetOrigin(request.origin);
  image->GetPointData()->SetScalars(scalars);
  vtkNew<vtkColorTransferFunction> white;
  white->AddRGBPoint(-32768, 1, 1, 1);
  white->AddRGBPoint(32767, 1, 1, 1);
  vtkNew<vtkPiecewiseFunction> opacity;
  opacity->AddPoint(request.ramp[0] - 1, 0);
  for (int i = 0; i < request.ramp_count; ++i)
    opacity->AddPoint(request.ramp[2 * i], request.ramp[2 * i + 1]);
  vtkNew<vtkVolumeProperty> property;
  property->SetColor(white);
  property->SetScalarOpacity(opacity);
  property->SetScalarOpacityUnitDistance(1);
  property->SetInterpolationTypeToLinear();
  property->ShadeOff();
  vtkNew<vtkVolume> volume;
  volume->SetProperty(property);
  vtkNew<vtkFixedPointVolumeRayCastMapper> software;
  vtkNew<vtkOpenGLGPUVolumeRayCastMapper> graphics;
  if (request.is_on_gpu) {
    graphics->SetInputData(image);
    graphics->AutoAdjustSampleDistancesOff();
    graphics->SetSampleDistance(static_cast<float>(request.step));
    graphics->UseJitteringOff();
    volume->SetMapper(graphics);
  } else {
    software->SetInputData(image);
    software->AutoAdjustSampleDistancesOff();
    software->SetSampleDistance(static_cast<float>(request.step));
    software->SetInteractiveSampleDistance(static_cast<float>(request.step));
    software->SetImageSampleDistance(1);
    software->SetNumberOfThreads(request.threads);
    volume->SetMapper(software);
  }
  vtkNew<vtkRenderer> renderer;
  renderer->SetBackground(0, 0, 0);
  renderer->AddVolume(volume);
  vtkCamera* camera = renderer->GetActiveCamera();
  camera->SetPosition(request.camera_position);
  camera->SetFocalPoint(request.aim);
  camera->SetViewUp(request.up);
  camera->SetViewAngle(request.view_angle);
  renderer->ResetCameraClippingRange();
  window->AddRenderer(renderer);
  const auto draw = [&] {
    const auto begin = Clock::now();
    window->Render();
    window->WaitForCompletion();
    return 1e3 * seconds_since(begin);
  };
  draw();
  answer.frame_ms = answer.changed_ms = 1e300;
  constexpr int k_runs = 4;
  std::int16_t& voxel =
      request
          .voxels[request.changed[0] +
                  static_cast<std::ptrdiff_t>(request.size) *
                      (request.changed[1] + static_cast<std::ptrdiff_t>(request.size) * request.changed[2])];
  const std::int16_t kept = voxel;
  for (int run = 0; run < k_runs; ++run) {
    answer.frame_ms = std::min(answer.frame_ms, draw());
    voxel = static_cast<std::int16_t>(voxel + 1);
    scalars->Modified();
    image->Modified();
    answer.changed_ms = std::min(answer.changed_ms, draw());
  }
  voxel = kept;
  const int* size = window->GetSize();
  vtkNew<vtkUnsignedCharArray> pixels;
  window->GetPixelData(0, 0, size[0] - 1, size[1] - 1, 0, pixels);
  answer.greys.clear();
  for (vtkIdType i = 0; i < pixels->GetNumberOfTuples(); ++i) answer.greys.push_back(pixels->GetValue(3 * i));
  window->RemoveRenderer(renderer);
  return true;
}

extern "C" bool trephine_draw_peer(const DrawPeerRequest& request, vtkRenderWindow* window,
                                   DrawPeerResult& answer) {
  vtkNew<vtkFloatArray> places;
  places->SetNumberOfComponents(3);
  places->SetArray(const_cast<float*>(request.vertices), 3 * request.vertex_count, 1);
  vtkNew<vtkPoints> points;
  points->SetData(places);
  vtkNew<vtkCellArray> cells;
  cells->AllocateExact(request.triangle_count, 3 * request.triangle_count);
  for (long t = 0; t < request.triangle_count; ++t) {
    const vtkIdType corners[3] = {request.triangles[3 * t], request.triangles[3 * t + 1],
                                  request.triangles[3 * t + 2]};
    cells->InsertNextCell(3, corners);
  }
  vtkNew<vtkPolyData> data;
  data->SetPoints(points);
  data->SetPolys(cells);
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputData(data);
  vtkNew<vtkActor> actor;
  actor->SetMapper(mapper);
  vtkNew<vtkRenderer> renderer;
  renderer->AddActor(actor);
  window->SetMultiSamples(0);
  window->AddRenderer(renderer);
  vtkCamera* camera = renderer->GetActiveCamera();
  camera->ParallelProjectionOn();
  camera->SetParallelScale(0.5 * request.edge);
  constexpr double k_near = 1e-3;  // mm
  const int* size = window->GetSize();
  vtkNew<vtkFloatArray> depths;
  answer.draw_ms = answer.read_ms = 1e300;
  for (int round = 0; round <= request.rounds; ++round) {
    double draw_ms = 0, read_ms = 0;
    for (int face = 0; face < 6; ++face) {
      const int axis = face / 2;
      double at[3], up[3] = {0, 0, 0};
      for (int a = 0; a < 3; ++a) at[a] = request.middle[a];
      at[axis] += (face % 2 == 0 ? 0.5 : -0.5) * request.edge;
      up[(axis + 1) % 3] = 1;
      camera->SetPosition(at);
      camera->SetFocalPoint(request.middle);
      camera->SetViewUp(up);
      camera->SetClippingRange(k_near, request.edge);
      auto begin = Clock::now();
      window->Render();
      window->WaitForCompletion();
      draw_ms += 1e3 * seconds_since(begin);
      begin = Clock::now();
      window->GetZbufferData(0, 0, size[0] - 1, size[1] - 1, depths);
      read_ms += 1e3 * seconds_since(begin);
      if (round > 0) continue;
      // Up in the picture is along axis (axis + 1) % 3; viewed from the high face, right is opposite to axis
      // (axis + 2) % 3.
      const bool is_high = face % 2 == 0;
      const int pixels = size[0];
      float* const image = request.depths + static_cast<std::ptrdiff_t>(2 * axis + is_high) * pixels * pixels;
      for (int up_pixel = 0; up_pixel < pixels; ++up_pixel)
        for (int right_pixel = 0; right_pixel < pixels; ++right_pixel) {
          const int row = is_high ? pixels - 1 - right_pixel : right_pixel;
          const double depth = depths->GetValue(static_cast<vtkIdType>(up_pixel) * pixels + right_pixel);
          image[static_cast<std::ptrdiff_t>(row) * pixels + up_pixel] =
              static_cast<float>(depth < 1 ? k_near + depth * (request.edge - k_near) : request.edge);
        }
    }
    if (round == 0) {
      answer.first_ms = draw_ms + read_ms;
      continue;
    }
    answer.draw_ms = std::min(answer.draw_ms, draw_ms);
    answer.read_ms = std::min(answer.read_ms, read_ms);
  }
  window->RemoveRenderer(renderer);
  return true;
}
