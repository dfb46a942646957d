#include <algorithm>
#include <cstdlib>
#include <glm/geometric.hpp>
#include <vtkImageData.h>
#include <vtkImageReslice.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkShortArray.h>

#include "apps/bench/measure.h"
#include "apps/bench/reslice.h"
#include "data-tools/phantoms/phantoms.h"
#include "volume/imaging/reslice.h"

namespace trephine::bench {

using glm::dvec3;

namespace {
constexpr int k_slice_pixels = 1024, k_reslice_runs = 7;
constexpr std::int16_t k_outside = -3000;
}  // namespace

std::vector<ResliceRow> run_reslice_benchmark(int size) {
  data_tools::PhantomOptions o;
  o.size = glm::ivec3(size);
  o.psf_sigma_voxels = 1.5, o.is_psf_given = true;
  o.parameters["noise"] = 20;
  volume::Volume v = data_tools::make_phantom("shell", o).value();
  const dvec3 mm = v.frame.spacing(), at = v.frame.origin();
  vtkNew<vtkShortArray> scalars;
  scalars->SetArray(v.voxels.data(), static_cast<vtkIdType>(v.voxels.size()), 1);
  vtkNew<vtkImageData> image;
  image->SetDimensions(size, size, size);
  image->SetSpacing(mm.x, mm.y, mm.z);
  image->SetOrigin(at.x, at.y, at.z);
  image->GetPointData()->SetScalars(scalars);

  struct Plane {
    const char* name;
    dvec3 normal;  ///< 0: orientation given by the name
  };
  const std::size_t count = static_cast<std::size_t>(k_slice_pixels) * k_slice_pixels;
  std::vector<ResliceRow> rows;
  for (const Plane& requested : {Plane{"axial", dvec3(0.0)}, Plane{"coronal", dvec3(0.0)},
                                 Plane{"sagittal", dvec3(0.0)}, Plane{"oblique 1,1,1", {1, 1, 1}},
                                 Plane{"oblique 3,1,2", {3, 1, 2}}, Plane{"oblique 1,5,1", {1, 5, 1}}})
    for (const int threads : {1, 2}) {
      volume::ImagePlane plane;
      plane.columns = plane.rows = k_slice_pixels, plane.pixel = 110.0 / k_slice_pixels;
      if (requested.normal == dvec3(0.0))
        orient_plane(plane, requested.name);
      else
        orient_plane(plane, requested.normal);
      ResliceRow row;
      row.plane = requested.name, row.threads = threads, row.our_ms = row.peer_ms = 1e300;
      std::vector<std::int16_t> ours(count);
      for (int run = 0; run < k_reslice_runs; ++run) {
        const auto begin = Clock::now();
        volume::reslice(v, plane, {}, k_outside, threads, ours);
        row.our_ms = std::min(row.our_ms, 1e3 * seconds_since(begin));
      }
      vtkNew<vtkImageReslice> reslice;
      reslice->SetInputData(image);
      reslice->SetOutputDimensionality(2);
      const dvec3 down = -plane.up, n = glm::cross(plane.right, down), corner = plane.world(0, 0);
      const double directions[9] = {plane.right.x, plane.right.y, plane.right.z, down.x, down.y,
                                    down.z,        n.x,           n.y,           n.z};
      reslice->SetResliceAxesDirectionCosines(directions);
      reslice->SetResliceAxesOrigin(corner.x, corner.y, corner.z);
      reslice->SetOutputOrigin(0, 0, 0);
      reslice->SetOutputSpacing(plane.pixel, plane.pixel, 1);
      reslice->SetOutputExtent(0, k_slice_pixels - 1, 0, k_slice_pixels - 1, 0, 0);
      reslice->SetInterpolationModeToLinear();
      reslice->SetBackgroundLevel(k_outside);
      reslice->SetNumberOfThreads(threads);
      reslice->SetEnableSMP(false);
      for (int run = 0; run < k_reslice_runs; ++run) {
        reslice->Modified();
        const auto begin = Clock::now();
        reslice->Update();
        row.peer_ms = std::min(row.peer_ms, 1e3 * seconds_since(begin));
      }
      const auto* theirs = static_cast<const short*>(reslice->GetOutput()->GetScalarPointer());
      for (std::size_t i = 0; i < count; ++i)
        if (theirs[i] != k_outside && ours[i] != k_outside)
          row.worst_difference = std::max(row.worst_difference, std::abs(theirs[i] - ours[i]));
      rows.push_back(row);
    }
  return rows;
}

}  // namespace trephine::bench
