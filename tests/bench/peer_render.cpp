// VTK's mappers of volumes, in a library that only `trephine bench render` loads.
#include <algorithm>
#include <vtkAutoInit.h>
#include <vtkCamera.h>
#include <vtkColorTransferFunction.h>
#include <vtkFixedPointVolumeRayCastMapper.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkOpenGLGPUVolumeRayCastMapper.h>
#include <vtkPiecewiseFunction.h>
#include <vtkPointData.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkShortArray.h>
#include <vtkUnsignedCharArray.h>
#include <vtkVolume.h>
#include <vtkVolumeProperty.h>

#include "tests/bench/measure.h"
#include "tests/bench/render.h"

VTK_MODULE_INIT(vtkRenderingVolumeOpenGL2)

using namespace trephine::bench;

extern "C" bool trephine_render_peer(const RenderPeerWish& wish, vtkRenderWindow* window,
                                     RenderPeerAnswer& answer) {
  vtkNew<vtkShortArray> scalars;
  scalars->SetArray(wish.voxels, static_cast<vtkIdType>(wish.size) * wish.size * wish.size, 1);
  vtkNew<vtkImageData> image;
  image->SetDimensions(wish.size, wish.size, wish.size);
  image->SetSpacing(wish.spacing, wish.spacing, wish.spacing);
  image->SetOrigin(wish.origin);
  image->GetPointData()->SetScalars(scalars);
  vtkNew<vtkColorTransferFunction> white;
  white->AddRGBPoint(-32768, 1, 1, 1);
  white->AddRGBPoint(32767, 1, 1, 1);
  vtkNew<vtkPiecewiseFunction> opacity;
  opacity->AddPoint(wish.ramp[0] - 1, 0);
  for (int i = 0; i < wish.ramp_count; ++i) opacity->AddPoint(wish.ramp[2 * i], wish.ramp[2 * i + 1]);
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
  if (wish.is_on_gpu) {
    graphics->SetInputData(image);
    graphics->AutoAdjustSampleDistancesOff();
    graphics->SetSampleDistance(static_cast<float>(wish.step));
    graphics->UseJitteringOff();
    volume->SetMapper(graphics);
  } else {
    software->SetInputData(image);
    software->AutoAdjustSampleDistancesOff();
    software->SetSampleDistance(static_cast<float>(wish.step));
    software->SetInteractiveSampleDistance(static_cast<float>(wish.step));
    software->SetImageSampleDistance(1);
    software->SetNumberOfThreads(wish.threads);
    volume->SetMapper(software);
  }
  vtkNew<vtkRenderer> renderer;
  renderer->SetBackground(0, 0, 0);
  renderer->AddVolume(volume);
  vtkCamera* camera = renderer->GetActiveCamera();
  camera->SetPosition(wish.eye);
  camera->SetFocalPoint(wish.aim);
  camera->SetViewUp(wish.up);
  camera->SetViewAngle(wish.view_angle);
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
      wish.voxels[wish.changed[0] +
                  static_cast<std::ptrdiff_t>(wish.size) *
                      (wish.changed[1] + static_cast<std::ptrdiff_t>(wish.size) * wish.changed[2])];
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
