#include "data-tools/image_files.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <glm/geometric.hpp>
#include <itkMetaDataObject.h>
#include <itkMetaImageIO.h>
#include <itkNrrdImageIO.h>
#include <itkObjectFactoryBase.h>
#include <sstream>

#include "data-tools/atomic_file.h"
#include "data-tools/nifti.h"
#include "data-tools/opening.h"
#include "data-tools/output_set.h"
#include "data-tools/quiet_streams.h"
#include "data-tools/voxel_values.h"
#include "data-tools/vti.h"
#include "volume/parallel.h"
#include "volume/text.h"

namespace trephine::data_tools {

namespace fs = std::filesystem;
using volume::Error;
using volume::Result;
using volume::Status;
using volume::Volume;

namespace {

struct Format {
  itk::ImageIOBase::Pointer io;
  std::string name;
};
Format format_of(const std::string& path) {
  if (has_extension(path, ".mha") || has_extension(path, ".mhd"))
    return {itk::MetaImageIO::New().GetPointer(), "MetaImage"};
  if (has_extension(path, ".nrrd") || has_extension(path, ".nhdr"))
    return {itk::NrrdImageIO::New().GetPointer(), "NRRD"};
  if (has_extension(path, ".nii") || has_extension(path, ".nii.gz")) return {nullptr, "NIfTI"};
  return {nullptr, ""};
}

/// ITK's words without its file names and line numbers.
std::string reason(const itk::ExceptionObject& e) {
  std::string text = e.GetDescription() ? e.GetDescription() : "";
  if (const auto at = text.rfind("): "); at != std::string::npos) text = text.substr(at + 3);
  if (const auto slash = text.find('/'); slash != std::string::npos) text = text.substr(0, slash);
  if (const auto line = text.find("[nrrd]"); line != std::string::npos)
    text = "its data end before its header says";
  return text.substr(0, text.find('\n')).substr(0, 160);
}

std::optional<ValueReader> reader_of(itk::IOComponentEnum type, const void* data) {
  using C = itk::IOComponentEnum;
  switch (type) {
    case C::UCHAR:
      return values_of<unsigned char>(data);
    case C::CHAR:
      return values_of<signed char>(data);
    case C::USHORT:
      return values_of<unsigned short>(data);
    case C::SHORT:
      return values_of<short>(data);
    case C::UINT:
      return values_of<unsigned int>(data);
    case C::INT:
      return values_of<int>(data);
    case C::ULONG:
      return values_of<unsigned long>(data);
    case C::LONG:
      return values_of<long>(data);
    case C::ULONGLONG:
      return values_of<unsigned long long>(data);
    case C::LONGLONG:
      return values_of<long long>(data);
    case C::FLOAT:
      return values_of<float>(data);
    case C::DOUBLE:
      return values_of<double>(data);
    default:
      return std::nullopt;
  }
}

/// ITK's reader trusts a MetaImage's header: it divides by what it finds and loops as often as it is told.
/// What no reader should be shown, in words, or "".
std::string metaimage_header_fault(const std::string& path) {
  if (!has_extension(path, ".mha") && !has_extension(path, ".mhd")) return "";
  std::ifstream in(path, std::ios::binary);
  int dimensions = 0, lines = 0;
  for (std::string line; std::getline(in, line) && lines < 1000; ++lines) {
    if (line.size() > 4096) return "a header line of " + std::to_string(line.size()) + " characters";
    for (const char c : line)
      if ((static_cast<unsigned char>(c) < 0x20 && c != '\t' && c != '\r') ||
          static_cast<unsigned char>(c) >= 0x7f)
        return "a header that is no plain text";
    const std::size_t equals = line.find('=');
    if (equals == std::string::npos) return "a header line without key = value";
    std::string key = line.substr(0, equals);
    key.erase(std::min(key.size(), key.find_last_not_of(" \t") + 1));
    if (key == "ElementDataFile") return dimensions > 0 ? "" : "no NDims before its data";
    std::istringstream values(line.substr(equals + 1));
    const auto is_vector = [&](int count) {
      double v = 0;
      int n = 0;
      while (values >> v && std::isfinite(v)) ++n;
      return n == count && values.eof();
    };
    if (key == "NDims") {
      if (dimensions != 0 || !(values >> dimensions) || dimensions < 1 || dimensions > 8)
        return "a number of dimensions that cannot be";
    } else if (key == "DimSize" || key == "ElementSpacing" || key == "ElementSize" || key == "Offset" ||
               key == "Origin" || key == "Position" || key == "CenterOfRotation") {
      if (dimensions == 0 || !is_vector(dimensions)) return key + " without a number for each dimension";
    } else if (key == "TransformMatrix" || key == "Rotation" || key == "Orientation") {
      if (dimensions == 0 || !is_vector(dimensions * dimensions))
        return key + " without a number for each pair of dimensions";
    } else if (key == "ElementNumberOfChannels" || key == "CompressedDataSize" || key == "HeaderSize") {
      long long v = -2;
      if (!(values >> v) || v < (key == "HeaderSize" ? -1 : 1)) return key + " of no use";
    }
  }
  return "no data after its header";
}

/// ITK reads on past the end of a short MetaImage: what is missing from it, in words, or "".
std::string missing_bytes(const std::string& path, std::size_t voxel_bytes) {
  if (!has_extension(path, ".mha") && !has_extension(path, ".mhd")) return "";
  std::ifstream in(path, std::ios::binary);
  std::string head(1 << 16, '\0');
  in.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(in.gcount()));
  const std::size_t marker = head.find("ElementDataFile");
  const std::size_t line_end = marker == std::string::npos ? marker : head.find('\n', marker);
  if (line_end == std::string::npos) return "no data after its header";
  std::size_t expected = voxel_bytes;
  if (head.find("CompressedData = True") < marker) {
    const std::size_t at = head.find("CompressedDataSize = ");
    expected = at > marker ? 1 : static_cast<std::size_t>(std::strtoull(head.c_str() + at + 21, nullptr, 10));
  }
  // The voxels follow the header, or lie in a file beside it.
  std::string data = head.substr(head.find('=', marker) + 1, line_end - head.find('=', marker) - 1);
  data.erase(0, data.find_first_not_of(' '));
  data.erase(data.find_last_not_of(" \r") + 1);
  std::size_t held = 0;
  if (leaves_folder(data)) return "voxels in a file outside its folder";
  if (data == "LOCAL") {
    held = static_cast<std::size_t>(fs::file_size(path)) - (line_end + 1);
  } else {
    std::error_code error;
    const fs::path beside = fs::path(path).parent_path() / data;
    if (data.starts_with("LIST") || data.find('%') != std::string::npos)
      return "voxels spread over several files";
    held = static_cast<std::size_t>(fs::file_size(beside, error));
    if (error) return "no file " + file_name(data) + " with the voxels";
  }
  return held < expected ? std::to_string(held) + " of " + std::to_string(expected) + " bytes of voxels" : "";
}

/// Has a file that was written room for so many bytes of voxels?
bool holds(const std::string& path, std::uint64_t bytes) {
  std::error_code failed;
  const std::uint64_t size = fs::file_size(path, failed);
  return !failed && size >= bytes;
}

/// Does a MetaImage say its voxels' size?
bool says_spacing(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  for (std::string line; std::getline(in, line) && !line.starts_with("ElementDataFile");)
    if (line.starts_with("ElementSpacing") || line.starts_with("ElementSize")) return true;
  return false;
}

Status write_image(const std::string& path, const glm::ivec3& size, const volume::Frame& frame,
                   itk::IOComponentEnum type, const void* data, bool is_hounsfield) {
  if (Status error = check_extension(OutputKind::volume, path)) return error;
  for (const char* extension : {".mha", ".nrrd", ".nii", ".nii.gz", ".vti"})
    if (has_extension(path, extension) && !path.ends_with(extension))
      return Error{"the extension must be in lower case", file_name(path), "", extension,
                   "rename the output"};
  return write_atomically(path, [&](const std::string& temporary) -> Status {
    const Format format = format_of(path);
    if (format.name == "NIfTI")
      return write_nifti(temporary, path, size, frame, type == itk::IOComponentEnum::SHORT, data,
                         is_hounsfield);
    if (has_extension(path, ".vti"))
      return write_vti(temporary, path, size, frame, type == itk::IOComponentEnum::SHORT, data,
                       is_hounsfield);
    const QuietStreams quiet;
    try {
      format.io->SetFileName(temporary);
      format.io->SetNumberOfDimensions(3);
      format.io->SetNumberOfComponents(1);
      format.io->SetComponentType(type);
      format.io->SetPixelType(itk::IOPixelEnum::SCALAR);
      itk::ImageIORegion region(3);
      for (unsigned a = 0; a < 3; ++a) {
        const int i = static_cast<int>(a);
        format.io->SetDimensions(a, static_cast<itk::SizeValueType>(size[i]));
        format.io->SetSpacing(a, frame.spacing()[i]);
        format.io->SetOrigin(a, frame.origin()[i]);
        const glm::dvec3 direction = frame.axes()[i] / frame.spacing()[i];
        format.io->SetDirection(a, {direction.x, direction.y, direction.z});
        region.SetSize(a, static_cast<itk::SizeValueType>(size[i]));
      }
      format.io->SetIORegion(region);
      // Read again, a file of ours says itself what its values are.
      if (is_hounsfield)
        itk::EncapsulateMetaData<std::string>(format.io->GetMetaDataDictionary(), k_units_key, k_units);
      format.io->SetUseCompression(false);
      format.io->WriteImageInformation();
      format.io->Write(data);
    } catch (const itk::ExceptionObject&) {
      return cannot_write(path, ENOSPC);  // place and name are good
    }
    // Some writers say nothing of a full disk.
    const std::uint64_t voxels = static_cast<std::uint64_t>(size.x) * static_cast<std::uint64_t>(size.y) *
                                 static_cast<std::uint64_t>(size.z),
                        bytes = voxels * format.io->GetComponentSize();
    if (holds(temporary, bytes)) return std::nullopt;
    Error error = cannot_write(path, 0);
    error.found = "a disk that took less than the whole file";
    error.expected = "room for " + std::to_string(bytes) + " bytes";
    return error;
  });
}

}  // namespace

Result<OpenedVolume> open_image_file(const std::string& path, const OpenOptions& options) {
  const std::string where = file_name(path);
  const Format format = format_of(path);
  const auto broken = [&](const std::string& found) {
    return Error{"the " + format.name + " file cannot be read", where, found,
                 "a complete file of that format", "copy or export it again"};
  };
  if (const std::string fault = metaimage_header_fault(path); !fault.empty()) return broken(fault);
  const QuietStreams quiet;
  try {
    itk::ImageIOBase& io = *format.io;
    if (!io.CanReadFile(path.c_str())) return broken("no " + format.name + " header");
    io.SetFileName(path);
    io.ReadImageInformation();
    unsigned dimensions = io.GetNumberOfDimensions();
    for (; dimensions > 3 && io.GetDimensions(dimensions - 1) == 1; --dimensions) {}
    if (dimensions != 3 && dimensions != 4)
      return broken(std::to_string(dimensions) + " dimensions instead of 3");
    const std::size_t volumes = dimensions == 4 ? io.GetDimensions(3) : 1;
    const Result<std::size_t> index = volume_index(options, volumes, where);
    if (!index) return index.error();
    if (io.GetNumberOfComponents() != 1)
      return broken(std::to_string(io.GetNumberOfComponents()) + " values a voxel instead of 1");
    glm::ivec3 size;
    glm::dvec3 origin;
    glm::dmat3 axes;
    for (unsigned a = 0; a < 3; ++a) {
      const int i = static_cast<int>(a);
      size[i] = static_cast<int>(std::min<itk::SizeValueType>(io.GetDimensions(a), 2'000'000'000));
      origin[i] = io.GetOrigin(a);
      if (!(io.GetSpacing(a) > 0) || !std::isfinite(io.GetSpacing(a)))
        return Error{"the spacing is not a positive number", where, volume::text_of(io.GetSpacing(a)) + " mm",
                     "a spacing above 0 mm on each axis", "export the volume again"};
      const std::vector<double> direction = io.GetDirection(a);
      for (int k = 0; k < 3; ++k) axes[i][k] = direction[static_cast<std::size_t>(k)] * io.GetSpacing(a);
    }
    if (!says_spacing(path)) {
      if (!options.spacing)
        return Error{"the file does not say how large its voxels are", where,
                     "neither ElementSpacing nor ElementSize", "one of them, in mm",
                     "say it: --spacing X,Y,Z"};
      for (int a = 0; a < 3; ++a) axes[a] *= (*options.spacing)[a];
    }
    const Result<volume::Frame> frame = volume::Frame::from_axes(origin, axes);
    // The file first, the memory for it then. A product that wraps is larger than any file, too.
    std::size_t promised = io.GetComponentSize();
    for (int i = 0; i < 3; ++i)
      if (__builtin_mul_overflow(promised, static_cast<std::size_t>(size[i]), &promised))
        return broken("a size that cannot be");
    if (__builtin_mul_overflow(promised, volumes, &promised)) return broken("a size that cannot be");
    if (const std::string gap = missing_bytes(path, promised); !gap.empty()) return broken(gap);
    Result<Volume> made = make_room(size, frame, where);
    if (!made) return made.error();
    const std::size_t bytes = made.value().voxels.size() * io.GetComponentSize() * volumes;
    if (Status error = check_memory(bytes, where)) return *error;
    itk::ImageIORegion region(io.GetNumberOfDimensions());
    for (unsigned a = 0; a < io.GetNumberOfDimensions(); ++a) region.SetSize(a, io.GetDimensions(a));
    io.SetIORegion(region);
    if (options.progress && !options.progress(0)) return reading_interrupted(where);

    OpenedVolume opened;
    opened.volume = std::move(made).value();
    opened.format = format.name;
    Volume& volume = opened.volume;
    if (io.GetComponentType() == itk::IOComponentEnum::SHORT && volumes == 1 && !options.scale) {
      io.Read(volume.voxels.data());
    } else {
      volume::Buffer<char> raw(bytes);
      io.Read(raw.data());
      const auto values = reader_of(io.GetComponentType(), raw.data() + index.value() * (bytes / volumes));
      if (!values) return broken("voxels of an unknown kind");
      if (Status error = fill_voxels(volume, *values, options.scale, where, opened.notices)) return *error;
    }
    opened.is_rounded = !opened.notices.empty();
    if (volumes > 1) tell_volumes(opened, index.value(), volumes);
    std::string units;
    itk::ExposeMetaData<std::string>(io.GetMetaDataDictionary(), k_units_key, units);
    know_units(opened, units == k_units);
    return opened;
  } catch (const itk::ExceptionObject& e) {
    return broken(reason(e));
  } catch (const std::exception&) {
    return broken("damaged contents");
  }
}

Result<Volume> orthogonalized(const Volume& volume) {
  if (volume.frame.is_orthogonal()) {
    Result<Volume> made = volume::make_volume(volume.size, volume.frame, !volume.labels.is_empty());
    if (!made) return made;
    std::copy_n(volume.voxels.data(), volume.voxels.size(), made.value().voxels.data());
    std::copy_n(volume.labels.data(), volume.labels.size(), made.value().labels.data());
    made.value().is_hounsfield = volume.is_hounsfield;
    made.value().label_names = volume.label_names;
    return made;
  }
  // Right angles by Gram and Schmidt, x first; a box that holds all corners.
  const glm::dmat3& axes = volume.frame.axes();
  const glm::dvec3 x = glm::normalize(axes[0]);
  const glm::dvec3 y = glm::normalize(axes[1] - glm::dot(axes[1], x) * x);
  glm::dvec3 z = glm::cross(x, y);
  if (glm::dot(z, axes[2]) < 0) z = -z;
  const glm::dmat3 unit(x, y, z);
  const glm::dvec3 spacing(glm::dot(axes[0], x), glm::dot(axes[1], y), glm::dot(axes[2], z));
  glm::dvec3 low(1e300), high(-1e300);
  for (int corner = 0; corner < 8; ++corner) {
    const glm::dvec3 p =
        glm::dvec3(corner & 1, corner >> 1 & 1, corner >> 2 & 1) * glm::dvec3(volume.size - 1);
    const glm::dvec3 q = glm::transpose(unit) * volume.frame.world_from_volume(p);
    low = glm::min(low, q);
    high = glm::max(high, q);
  }
  const glm::ivec3 size = glm::ivec3(glm::floor((high - low) / spacing + 1e-6)) + 1;
  Result<volume::Frame> frame =
      volume::Frame::from_axes(unit * low, glm::dmat3(spacing.x * x, spacing.y * y, spacing.z * z));
  if (!frame) return frame.error();
  Result<Volume> made = volume::make_volume(size, frame.value(), !volume.labels.is_empty());
  if (!made) return made;
  Volume& result = made.value();
  result.is_hounsfield = volume.is_hounsfield;
  result.label_names = volume.label_names;
  const double air = volume.is_hounsfield
                         ? -1000
                         : *std::min_element(volume.voxels.span().begin(), volume.voxels.span().end());
  volume::parallel_for(size.z, 0, [&](int k) {
    for (int j = 0; j < size.y; ++j)
      for (int i = 0; i < size.x; ++i) {
        const glm::dvec3 p = volume.frame.volume_from_world(result.frame.world_from_volume({i, j, k}));
        const glm::dvec3 base = glm::floor(p), f = p - base;
        double sum = 0;
        for (int c = 0; c < 8; ++c) {
          const glm::ivec3 v = glm::ivec3(base) + glm::ivec3(c & 1, c >> 1 & 1, c >> 2 & 1);
          const double w =
              (c & 1 ? f.x : 1 - f.x) * (c >> 1 & 1 ? f.y : 1 - f.y) * (c >> 2 & 1 ? f.z : 1 - f.z);
          sum += w * (volume.contains(v) ? volume.voxels[volume.index(v.x, v.y, v.z)] : air);
        }
        const std::size_t at = result.index(i, j, k);
        result.voxels[at] = static_cast<std::int16_t>(std::floor(sum + 0.5));
        if (!result.labels.is_empty()) {
          const glm::ivec3 v(glm::floor(p + 0.5));
          result.labels[at] =
              volume.contains(v) ? volume.labels[volume.index(v.x, v.y, v.z)] : std::uint8_t{0};
        }
      }
  });
  return made;
}

Status write_volume(const std::string& path, const Volume& volume) {
  if (volume.frame.is_orthogonal())
    return write_image(path, volume.size, volume.frame, itk::IOComponentEnum::SHORT, volume.voxels.data(),
                       volume.is_hounsfield);
  Result<Volume> straight = orthogonalized(volume);
  if (!straight) return straight.error();
  return write_image(path, straight.value().size, straight.value().frame, itk::IOComponentEnum::SHORT,
                     straight.value().voxels.data(), volume.is_hounsfield);
}

Status write_labels(const std::string& path, const Volume& volume) {
  if (volume.labels.is_empty())
    return Error{"this volume has no labels to write", file_name(path), "", "", ""};
  if (volume.frame.is_orthogonal())
    return write_image(path, volume.size, volume.frame, itk::IOComponentEnum::UCHAR, volume.labels.data(),
                       false);
  Result<Volume> straight = orthogonalized(volume);
  if (!straight) return straight.error();
  return write_image(path, straight.value().size, straight.value().frame, itk::IOComponentEnum::UCHAR,
                     straight.value().labels.data(), false);
}

}  // namespace trephine::data_tools
