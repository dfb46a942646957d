#include "data-tools/dicom.h"

#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <set>
#include <vtkCallbackCommand.h>
#include <vtkDICOMDirectory.h>
#include <vtkDICOMItem.h>
#include <vtkDICOMMetaData.h>
#include <vtkDICOMReader.h>
#include <vtkDICOMValue.h>
#include <vtkExecutive.h>
#include <vtkImageData.h>
#include <vtkIntArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkStringArray.h>

#include "data-tools/atomic_file.h"
#include "data-tools/dicom_stack.h"
#include "data-tools/quiet_streams.h"
#include "volume/parallel.h"

namespace trephine::data_tools {

namespace fs = std::filesystem;
using volume::Error;
using volume::Result;
using volume::Volume;

namespace {

constexpr int k_scan_depth = 2;  // folders in the folder that are looked into
constexpr double k_air = -1000, k_lowest_hounsfield = -1024;

/// What VTK would have printed, and the caller's wish to stop.
struct Listener {
  std::string first_error;
  const Progress* progress = nullptr;
  bool is_cancelled = false;

  static void hear(vtkObject* caller, unsigned long event, void* self, void* data) {
    auto* listener = static_cast<Listener*>(self);
    if (event == vtkCommand::ErrorEvent && listener->first_error.empty() && data)
      listener->first_error = static_cast<const char*>(data);
    if (event == vtkCommand::ProgressEvent && listener->progress && *listener->progress) {
      auto* algorithm = vtkAlgorithm::SafeDownCast(caller);
      if (algorithm && !(*listener->progress)(algorithm->GetProgress())) {
        listener->is_cancelled = true;
        algorithm->SetAbortExecute(1);
      }
    }
  }
  void attach(vtkObject* object) {
    vtkNew<vtkCallbackCommand> command;
    command->SetCallback(&Listener::hear);
    command->SetClientData(this);
    for (const unsigned long event :
         {vtkCommand::ErrorEvent, vtkCommand::WarningEvent, vtkCommand::ProgressEvent})
      object->AddObserver(event, command);
  }
};

struct Rescale {
  double slope = 1, intercept = 0;
};

std::string short_number(double v) {
  char text[40];
  std::snprintf(text, sizeof text, "%g", v);
  return text;
}

/// The last line of a VTK message that says something, without addresses and paths.
std::string last_line(const std::string& message) {
  std::size_t end = message.find_last_not_of(" \n\r");
  if (end == std::string::npos) return "";
  const std::size_t start = message.rfind('\n', end);
  std::string line = message.substr(start == std::string::npos ? 0 : start + 1,
                                    end - (start == std::string::npos ? 0 : start + 1) + 1);
  if (const std::size_t at = line.rfind("): "); at != std::string::npos) line.erase(0, at + 3);
  for (std::size_t slash; (slash = line.find('/')) != std::string::npos;) {  // a path becomes its last part
    const std::size_t stop = std::min(line.find_first_of(" ,;:", slash), line.size());
    line.replace(slash, stop - slash, file_name(line.substr(slash, stop - slash)));
    if (line.find('/') == slash) break;
  }
  return line.substr(0, 160);
}

/// What the files of one series say about each slice.
struct Series {
  std::vector<SlicePlace> places;
  std::vector<Rescale> rescales;
  std::string modality;
  bool is_signed = false;
  bool has_padding = false;
  int padding_low = 0, padding_high = 0;
};

Result<Series> read_series_facts(vtkDICOMMetaData* meta, vtkIntArray* files, vtkIntArray* frames,
                                 const std::string& where) {
  Series series;
  std::set<std::string> modalities;
  const auto slices = files->GetNumberOfTuples();
  for (vtkIdType k = 0; k < slices; ++k) {
    const int file = files->GetValue(k), frame = frames ? frames->GetValue(k) : 0;
    const auto get = [&](vtkDICOMTag tag) -> const vtkDICOMValue& { return meta->Get(file, frame, tag); };
    const auto fail = [&](const char* what, const std::string& found, const char* expected) {
      return Error{what, where, found, expected, "export the images of one CT or MR series"};
    };
    if (const int samples = get(DC::SamplesPerPixel).AsInt(); samples > 1)
      return fail("the images are in colour", std::to_string(samples) + " samples a pixel", "grey values");
    const vtkDICOMValue& orientation = get(DC::ImageOrientationPatient);
    const vtkDICOMValue& position = get(DC::ImagePositionPatient);
    const vtkDICOMValue& spacing = get(DC::PixelSpacing);
    if (orientation.GetNumberOfValues() != 6 || position.GetNumberOfValues() != 3 ||
        spacing.GetNumberOfValues() != 2)
      return fail("an image does not say where in the patient it lies",
                  "no orientation, position or pixel spacing", "all three, in every image");
    SlicePlace place;
    for (unsigned i = 0; i < 3; ++i) {
      place.position[static_cast<int>(i)] = position.GetDouble(i);
      place.row_axis[static_cast<int>(i)] = orientation.GetDouble(i);
      place.column_axis[static_cast<int>(i)] = orientation.GetDouble(3 + i);
    }
    place.row_spacing = spacing.GetDouble(0);
    place.column_spacing = spacing.GetDouble(1);
    place.thickness = get(DC::SliceThickness).AsDouble();
    series.places.push_back(place);
    Rescale rescale;
    if (get(DC::RescaleSlope).IsValid()) rescale.slope = get(DC::RescaleSlope).AsDouble();
    if (get(DC::RescaleIntercept).IsValid()) rescale.intercept = get(DC::RescaleIntercept).AsDouble();
    if (rescale.slope == 0 || !std::isfinite(rescale.slope) || !std::isfinite(rescale.intercept))
      return fail("an image's rescale slope or intercept is no usable number", std::to_string(rescale.slope),
                  "a slope that is not 0");
    if (get(DC::PhotometricInterpretation).AsString() == "MONOCHROME1")
      return fail("the images are inverted", "MONOCHROME1: high values are dark",
                  "MONOCHROME2, as CT and MR are");
    series.rescales.push_back(rescale);
    modalities.insert(get(DC::Modality).AsString());
    if (k == 0) {
      series.is_signed = get(DC::PixelRepresentation).AsInt() != 0;
      if (get(DC::PixelPaddingValue).IsValid()) {
        const auto value = [&](const vtkDICOMValue& v) {
          const int raw = v.AsInt();
          return series.is_signed ? static_cast<int>(static_cast<std::int16_t>(raw)) : raw & 0xffff;
        };
        series.has_padding = true;
        series.padding_low = series.padding_high = value(get(DC::PixelPaddingValue));
        if (get(DC::PixelPaddingRangeLimit).IsValid()) {
          const int other = value(get(DC::PixelPaddingRangeLimit));
          series.padding_low = std::min(series.padding_low, other);
          series.padding_high = std::max(series.padding_high, other);
        }
      }
    }
  }
  series.modality = *modalities.begin();
  return series;
}

/// One slice into the volume; false when a value is not a whole int16.
template <class T>
bool convert_slice(const T* from, std::int16_t* to, std::size_t count, const Rescale& rescale,
                   const Series& series, bool is_ct, bool maps_padding) {
  const bool is_whole =
      rescale.slope == std::floor(rescale.slope) && rescale.intercept == std::floor(rescale.intercept);
  bool is_good = true;
  for (std::size_t i = 0; i < count; ++i) {
    const auto raw = static_cast<int>(from[i]);
    double value = rescale.slope * raw + rescale.intercept;
    if (maps_padding) {
      const bool is_padding = series.has_padding && raw >= series.padding_low && raw <= series.padding_high;
      if (is_ct && (is_padding || value < k_lowest_hounsfield)) value = k_air;
    }
    if (!(value >= -32768 && value <= 32767) || (!is_whole && value != std::floor(value)))
      is_good = false;
    else
      to[i] = static_cast<std::int16_t>(value);
  }
  return is_good;
}

}  // namespace

bool has_dicom_magic(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  char bytes[132] = {};
  in.read(bytes, 132);
  return in.gcount() == 132 && std::memcmp(bytes + 128, "DICM", 4) == 0;
}

Result<OpenedVolume> open_dicom(const std::string& path, const OpenOptions& options) {
  const std::string where = file_name(path);
  const QuietStreams quiet;
  Listener listener;
  listener.progress = &options.progress;

  // Which files hold images, and of how many series.
  vtkNew<vtkDICOMDirectory> directory;
  listener.attach(directory);
  vtkNew<vtkStringArray> single;
  if (fs::is_directory(path)) {
    directory->SetDirectoryName(path.c_str());
    directory->SetScanDepth(k_scan_depth);
    directory->IgnoreDicomdirOn();
  } else {
    single->InsertNextValue(path);
    directory->SetInputFileNames(single);
  }
  directory->RequirePixelDataOn();
  directory->Update();
  const int series_count = directory->GetNumberOfSeries();
  if (series_count == 0)
    return Error{"there are no DICOM images here", where,
                 fs::is_directory(path) ? "a folder without DICOM images" : "a file without an image",
                 "a folder that holds the slices of one series",
                 "point at the folder with the scanner's files"};
  // A file that is DICOM but shows no image would leave a hole at an end of the stack, where no gap tells of
  // it.
  std::vector<std::string> notices;
  if (fs::is_directory(path)) {
    int dicom_files = 0, other_files = 0, images = 0;
    std::error_code error;
    for (fs::recursive_directory_iterator it(path, error), end; it != end; it.increment(error)) {
      if (it.depth() >= k_scan_depth) it.disable_recursion_pending();
      if (!it->is_regular_file(error) || it->path().filename() == "DICOMDIR") continue;
      ++(has_dicom_magic(it->path().string()) ? dicom_files : other_files);
    }
    for (int s = 0; s < series_count; ++s)
      images += static_cast<int>(directory->GetFileNamesForSeries(s)->GetNumberOfValues());
    if (images < dicom_files)
      return Error{"some DICOM files of the folder hold no readable image", where,
                   std::to_string(dicom_files - images) + " of " + std::to_string(dicom_files) + " files",
                   "an image in every file",
                   "copy them again; move reports and plans, which hold no image, elsewhere"};
    if (const int ignored = dicom_files + other_files - images; ignored > 0)
      notices.push_back(std::to_string(ignored) + (ignored == 1 ? " file" : " files") +
                        " in the folder that are no DICOM were left out");
  }
  if (series_count > 1) {
    std::string found = std::to_string(series_count) + " series:";
    for (int s = 0; s < std::min(series_count, 8); ++s) {
      const auto& record = directory->GetSeriesRecord(s);
      found += (s ? ", " : " ") + record.Get(DC::Modality).AsString() + " number " +
               record.Get(DC::SeriesNumber).AsString() + " with " +
               std::to_string(directory->GetFileNamesForSeries(s)->GetNumberOfValues()) + " files (such as " +
               file_name(directory->GetFileNamesForSeries(s)->GetValue(0)) + ")";
    }
    return Error{"the folder holds several series", where, found, "one series",
                 "move the files of one series to a folder of their own"};
  }

  // Facts of every slice, in the order of the files; our own geometry decides.
  vtkNew<vtkDICOMReader> reader;
  listener.attach(reader);
  listener.attach(reader->GetExecutive());
  reader->SetFileNames(directory->GetFileNamesForSeries(0));
  reader->SortingOff();
  reader->AutoRescaleOff();
  reader->SetMemoryRowOrderToFileNative();
  reader->UpdateInformation();
  vtkDICOMMetaData* meta = reader->GetMetaData();
  const auto broken = [&](const std::string& what) {
    return Error{what, where, last_line(listener.first_error),
                 "complete images in a transfer syntax that vtk-dicom and GDCM read",
                 "copy the files again, or convert them, for example with gdcmconv --raw"};
  };
  if (!listener.first_error.empty() || meta == nullptr)
    return broken("an image of the series cannot be read");
  Result<Series> facts =
      read_series_facts(meta, reader->GetFileIndexArray(), reader->GetFrameIndexArray(), where);
  if (!facts) return facts.error();
  const Series& series = facts.value();
  Result<SliceStack> stacked = stack_slices(series.places);
  if (!stacked) {
    Error error = stacked.error();
    error.where = where;
    return error;
  }
  const SliceStack& stack = stacked.value();
  int extent[6];
  reader->GetDataExtent(extent);
  const glm::ivec3 size(extent[1] - extent[0] + 1, extent[3] - extent[2] + 1,
                        static_cast<int>(series.places.size()));
  Result<Volume> made = volume::make_volume(size, stack.frame);
  if (!made) return made.error();

  reader->Update();
  if (listener.is_cancelled)
    return Error{"reading was interrupted", where, "", "", "", volume::ErrorKind::interrupted};
  vtkImageData* image = reader->GetOutput();
  if (!listener.first_error.empty() ||
      image->GetNumberOfPoints() != static_cast<vtkIdType>(made.value().voxels.size()))
    return broken("an image of the series cannot be read");
  const int type = image->GetScalarType();
  if (type != VTK_SHORT && type != VTK_UNSIGNED_SHORT && type != VTK_UNSIGNED_CHAR &&
      type != VTK_SIGNED_CHAR && type != VTK_CHAR)
    return Error{"the pixels are of a kind that trephine does not hold", where,
                 image->GetScalarTypeAsString(), "whole numbers of 8 or 16 bits", "convert the series"};

  OpenedVolume opened{std::move(made).value(), "DICOM", series.modality, std::move(notices), 0};
  Volume& volume = opened.volume;
  volume.is_hounsfield = series.modality == "CT";
  const std::size_t slice = static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y);
  std::vector<char> is_good(static_cast<std::size_t>(size.z), 1);
  volume::parallel_for(size.z, 0, [&](int k) {
    const auto input = static_cast<std::size_t>(stack.order[static_cast<std::size_t>(k)]);
    std::int16_t* to = volume.voxels.data() + slice * static_cast<std::size_t>(k);
    const void* from = static_cast<const char*>(image->GetScalarPointer()) +
                       slice * input * static_cast<std::size_t>(image->GetScalarSize());
    const auto convert = [&](auto kind) {
      return convert_slice(static_cast<const decltype(kind)*>(from), to, slice, series.rescales[input],
                           series, volume.is_hounsfield, options.maps_padding);
    };
    bool good = false;
    if (type == VTK_SHORT)
      good = convert(short{});
    else if (type == VTK_UNSIGNED_SHORT)
      good = convert(static_cast<unsigned short>(0));
    else if (type == VTK_UNSIGNED_CHAR)
      good = convert(static_cast<unsigned char>(0));
    else
      good = convert(static_cast<signed char>(0));
    is_good[static_cast<std::size_t>(k)] = good;
  });
  for (std::size_t k = 0; k < is_good.size(); ++k)
    if (!is_good[k])
      return Error{"slope and intercept give values that are not whole numbers of 16 bits", where,
                   "slice " + std::to_string(k + 1) + ", slope " +
                       std::to_string(series.rescales[static_cast<std::size_t>(stack.order[k])].slope),
                   "whole numbers from -32768 to 32767",
                   "export without rescaling, or scale the values to whole numbers"};
  if (size.z == 1)
    opened.notices.push_back("one slice only: its thickness of " + short_number(stack.frame.spacing().z) +
                             " mm stands for the distance of slices");
  return opened;
}

}  // namespace trephine::data_tools
