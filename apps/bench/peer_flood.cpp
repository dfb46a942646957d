// ITK as a peer: floods and components with its usual filters.
#include <chrono>
#include <itkBinaryThresholdImageFilter.h>
#include <itkConnectedComponentImageFilter.h>
#include <itkConnectedThresholdImageFilter.h>
#include <itkImportImageFilter.h>

#include "apps/bench/peers.h"

namespace trephine::bench {

namespace {

using Image = itk::Image<short, 3>;
using Mask = itk::Image<unsigned char, 3>;

double seconds_since(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

Image::Pointer image_of(const short* voxels, int size) {
  using Import = itk::ImportImageFilter<short, 3>;
  const auto import = Import::New();
  Import::SizeType extent;
  extent.Fill(static_cast<itk::SizeValueType>(size));
  Import::RegionType region;
  region.SetSize(extent);
  import->SetRegion(region);
  const auto edge = static_cast<itk::SizeValueType>(size), count = edge * edge * edge;
  import->SetImportPointer(const_cast<short*>(voxels), count, false);
  import->Update();
  return import->GetOutput();
}

}  // namespace

double itk_flood(const short* voxels, int size, short low, const int* seed, long long& count) {
  using Filter = itk::ConnectedThresholdImageFilter<Image, Mask>;
  const auto filter = Filter::New();
  filter->SetInput(image_of(voxels, size));
  filter->SetLower(low);
  filter->SetUpper(32767);
  filter->SetReplaceValue(1);
  filter->SetConnectivity(Filter::FullConnectivity);
  filter->SetSeed({{seed[0], seed[1], seed[2]}});
  const auto begin = std::chrono::steady_clock::now();
  filter->Update();
  const double seconds = seconds_since(begin);
  const unsigned char* mask = filter->GetOutput()->GetBufferPointer();
  count = 0;
  for (std::size_t i = 0; i < filter->GetOutput()->GetPixelContainer()->Size(); ++i) count += mask[i];
  return seconds;
}

double itk_components(const short* voxels, int size, short low, bool has_corners, int threads,
                      long long& count) {
  using Threshold = itk::BinaryThresholdImageFilter<Image, Mask>;
  using Filter = itk::ConnectedComponentImageFilter<Mask, itk::Image<int, 3>>;
  const auto threshold = Threshold::New();
  threshold->SetInput(image_of(voxels, size));
  threshold->SetLowerThreshold(low);
  threshold->SetInsideValue(1);
  threshold->SetOutsideValue(0);
  const auto filter = Filter::New();
  filter->SetInput(threshold->GetOutput());
  filter->SetFullyConnected(has_corners);
  threshold->SetNumberOfWorkUnits(static_cast<itk::ThreadIdType>(threads));
  filter->SetNumberOfWorkUnits(static_cast<itk::ThreadIdType>(threads));
  const auto begin = std::chrono::steady_clock::now();
  filter->Update();
  const double seconds = seconds_since(begin);
  count = static_cast<long long>(filter->GetObjectCount());
  return seconds;
}

}  // namespace trephine::bench
