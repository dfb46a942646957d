// ITK with its GDCM classes as a peer: finds the series of a folder, and reads one series.
#include <chrono>
#include <itkGDCMImageIO.h>
#include <itkGDCMSeriesFileNames.h>
#include <itkImageSeriesReader.h>

#include "apps/bench/peers.h"

namespace trephine::bench {

namespace {
double seconds_since(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}
}  // namespace

double gdcm_scan(const char* folder, int& series) {
  const auto begin = std::chrono::steady_clock::now();
  const auto names = itk::GDCMSeriesFileNames::New();
  names->SetRecursive(true);
  names->SetInputDirectory(folder);
  series = static_cast<int>(names->GetSeriesUIDs().size());
  return seconds_since(begin);
}

double itk_read(const char* folder, long long& sum) {
  const auto begin = std::chrono::steady_clock::now();
  const auto names = itk::GDCMSeriesFileNames::New();
  names->SetInputDirectory(folder);
  using Image = itk::Image<short, 3>;
  const auto reader = itk::ImageSeriesReader<Image>::New();
  reader->SetImageIO(itk::GDCMImageIO::New());
  reader->SetFileNames(names->GetInputFileNames());
  reader->Update();
  const double seconds = seconds_since(begin);
  const Image* image = reader->GetOutput();
  const std::size_t count = image->GetLargestPossibleRegion().GetNumberOfPixels();
  sum = 0;
  for (std::size_t i = 0; i < count; ++i)
    sum += (i % 251) * static_cast<std::size_t>(image->GetBufferPointer()[i]);
  return seconds;
}

}  // namespace trephine::bench
