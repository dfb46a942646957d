#include "apps/bench/peer_flying_edges.h"

#include <chrono>
#include <vtkFlyingEdges3D.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkSMPTools.h>
#include <vtkShortArray.h>

namespace trephine::bench {

PeerSurface flying_edges(const short* voxels, const int size[3], double iso, int threads) {
  vtkSMPTools::Initialize(threads);
  vtkNew<vtkShortArray> values;
  const vtkIdType count = static_cast<vtkIdType>(size[0]) * size[1] * size[2];
  values->SetArray(const_cast<short*>(voxels), count, 1);
  vtkNew<vtkImageData> image;
  image->SetDimensions(size[0], size[1], size[2]);
  image->GetPointData()->SetScalars(values);
  vtkNew<vtkFlyingEdges3D> filter;
  filter->SetInputData(image);
  filter->SetValue(0, iso);
  filter->ComputeNormalsOff();
  filter->ComputeGradientsOff();
  filter->ComputeScalarsOff();
  const auto start = std::chrono::steady_clock::now();
  filter->Update();
  return {std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(),
          static_cast<std::size_t>(filter->GetOutput()->GetNumberOfPolys())};
}

}  // namespace trephine::bench
