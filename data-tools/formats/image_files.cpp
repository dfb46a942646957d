#include "data-tools/formats/image_files.h"

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
#include <map>
#include <memory>
#include <sstream>
#include <zlib.h>

#include "data-tools/files/atomic_file.h"
#include "data-tools/formats/open_volume.h"
#include "data-tools/formats/quiet_streams.h"
#include "data-tools/formats/reader_support.h"
#include "data-tools/formats/voxel_values.h"
#include "volume/base/text.h"

namespace trephine::data_tools {

namespace fs = std::filesystem;
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

/// Returns ITK's message without file names and line numbers.
std::string itk_message(const itk::ExceptionObject& e) {
  std::string text = e.GetDescription() ? e.GetDescription() : "";
  if (const auto at = text.rfind("): "); at != std::string::npos) text = text.substr(at + 3);
  if (const auto slash = text.find('/'); slash != std::string::npos) text = text.substr(0, slash);
  if (const auto line = text.find("[nrrd]"); line != std::string::npos)
    text = "its data are shorter than its header states";
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

/// Returns a fault of a MetaImage header, or "". ITK's reader uses the values in divisions and loops without
/// checks, so that it must not receive a faulty header.
std::string metaimage_header_fault(const std::string& path) {
  if (!has_extension(path, ".mha") && !has_extension(path, ".mhd")) return "";
  std::ifstream in(path, std::ios::binary);
  int dimensions = 0, lines = 0;
  for (std::string line; std::getline(in, line) && lines < 1000; ++lines) {
    if (line.size() > 4096) return "a header line of " + std::to_string(line.size()) + " characters";
    for (const char c : line)
      if ((static_cast<unsigned char>(c) < 0x20 && c != '\t' && c != '\r') ||
          static_cast<unsigned char>(c) >= 0x7f)
        return "a header that is not plain text";
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
        return "an impossible number of dimensions";
    } else if (key == "DimSize" || key == "ElementSpacing" || key == "ElementSize" || key == "Offset" ||
               key == "Origin" || key == "Position" || key == "CenterOfRotation") {
      if (dimensions == 0 || !is_vector(dimensions)) return key + " without a number for each dimension";
    } else if (key == "TransformMatrix" || key == "Rotation" || key == "Orientation") {
      if (dimensions == 0 || !is_vector(dimensions * dimensions))
        return key + " without a number for each pair of dimensions";
    } else if (key == "ElementNumberOfChannels" || key == "CompressedDataSize" || key == "HeaderSize") {
      long long v = -2;
      if (!(values >> v) || v < (key == "HeaderSize" ? -1 : 1)) return key + " with an invalid value";
    }
  }
  return "no data after its header";
}

/// Location of the voxels of a MetaImage.
struct MetaImageData {
  std::string path;
  std::uint64_t begin = 0, size = 0;  ///< bytes, in that file
  bool is_compressed = false;
};

/// Reads the location from the header; returns an error text, or "".
std::string find_metaimage_data(const std::string& path, MetaImageData& data) {
  std::ifstream in(path, std::ios::binary);
  std::map<std::string, std::string> fields;
  const auto trimmed = [](const std::string& text) {
    const std::size_t first = text.find_first_not_of(" \t\r"), last = text.find_last_not_of(" \t\r");
    return first == std::string::npos ? std::string() : text.substr(first, last - first + 1);
  };
  for (std::string line; !fields.contains("ElementDataFile") && std::getline(in, line);)
    if (const std::size_t equals = line.find('='); equals != std::string::npos)
      fields[trimmed(line.substr(0, equals))] = trimmed(line.substr(equals + 1));
  if (!fields.contains("ElementDataFile")) return "no data after its header";
  const std::string flag = fields["CompressedData"];
  data.is_compressed = !flag.empty() && (flag[0] == 'T' || flag[0] == 't' || flag[0] == '1');
  const std::string name = fields["ElementDataFile"];
  if (escapes_folder(name)) return "voxels in a file outside its folder";
  if (name == "LOCAL" || name == "local" || name == "Local") {
    data.path = path;
    data.begin = in ? static_cast<std::uint64_t>(in.tellg()) : fs::file_size(path);
  } else {
    if (name.starts_with("LIST") || name.find('%') != std::string::npos)
      return "voxels spread over several files";
    data.path = (fs::path(path).parent_path() / name).string();
  }
  std::error_code error;
  const std::uint64_t file_bytes = fs::file_size(data.path, error);
  if (error) return "no file " + file_name(name) + " with the voxels";
  data.size = file_bytes > data.begin ? file_bytes - data.begin : 0;
  if (!data.is_compressed || !fields.contains("CompressedDataSize")) return "";
  const std::uint64_t expected_bytes = std::strtoull(fields["CompressedDataSize"].c_str(), nullptr, 10);
  if (data.size < expected_bytes)
    return std::to_string(data.size) + " of " + std::to_string(expected_bytes) +
           " bytes of compressed voxels";
  data.size = expected_bytes;
  return "";
}

/// Decompresses voxels and checks their size and checksum, because MetaIO checks neither. Returns an error
/// text, or "".
std::string inflate_voxels(const MetaImageData& data, char* voxels, std::size_t bytes) {
  std::ifstream in(data.path, std::ios::binary);
  in.seekg(static_cast<std::streamoff>(data.begin));
  z_stream stream{};
  constexpr int k_zlib_or_gzip = 32 + MAX_WBITS;
  if (inflateInit2(&stream, k_zlib_or_gzip) != Z_OK) return "no memory to decompress it";
  const std::unique_ptr<z_stream, int (*)(z_stream*)> stream_end(&stream, inflateEnd);
  std::vector<char> part(1 << 20);
  std::uint64_t remaining = data.size;
  std::size_t written = 0;
  char excess = 0;  // receives data beyond the expected size
  for (;;) {
    if (stream.avail_in == 0 && remaining > 0) {
      const std::size_t count = std::min<std::uint64_t>(remaining, part.size());
      in.read(part.data(), static_cast<std::streamsize>(count));
      if (in.gcount() != static_cast<std::streamsize>(count)) return "its compressed voxels cannot be read";
      remaining -= count;
      stream.next_in = reinterpret_cast<Bytef*>(part.data());
      stream.avail_in = static_cast<uInt>(count);
    }
    const bool is_full = written == bytes;
    const std::size_t capacity = is_full ? 1 : std::min<std::size_t>(bytes - written, 1u << 30);
    stream.next_out = reinterpret_cast<Bytef*>(is_full ? &excess : voxels + written);
    stream.avail_out = static_cast<uInt>(capacity);
    const int state = inflate(&stream, Z_NO_FLUSH);
    const std::size_t result = capacity - stream.avail_out;
    if (is_full && result > 0) return "more voxels than its header states";
    written += result;
    if (state == Z_STREAM_END) break;
    if (state == Z_BUF_ERROR || (state == Z_OK && result == 0 && stream.avail_in == 0 && remaining == 0))
      return "truncated compressed voxels";
    if (state != Z_OK) return "damaged compressed voxels";
  }
  if (written < bytes) return std::to_string(written) + " of " + std::to_string(bytes) + " bytes of voxels";
  return "";
}

/// Returns true if a MetaImage header contains one of the keys.
bool has_key(const std::string& path, std::initializer_list<const char*> keys) {
  std::ifstream in(path, std::ios::binary);
  for (std::string line; std::getline(in, line) && !line.starts_with("ElementDataFile");)
    for (const char* key : keys)
      if (line.starts_with(key)) return true;
  return false;
}

/// Adds Slicer's metadata about the segments of a label map.
void add_segment_metadata(itk::MetaDataDictionary& metadata, const VoxelsToWrite& voxels) {
  const auto add = [&metadata](const std::string& key, const std::string& value) {
    itk::EncapsulateMetaData<std::string>(metadata, key, value);
  };
  add("Segmentation_MasterRepresentation", "Binary labelmap");
  add("Segmentation_ContainedRepresentationNames", "Binary labelmap|");
  add("Segmentation_ReferenceImageExtentOffset", "0 0 0");
  std::string extent;
  for (int a = 0; a < 3; ++a) extent.append(a == 0 ? "0 " : " 0 ").append(std::to_string(voxels.size[a] - 1));
  for (std::size_t label = 1; label < voxels.label_names.size(); ++label) {
    std::string segment = "Segment";
    segment.append(std::to_string(label - 1)).append("_");
    const glm::dvec3 c = label_colour(static_cast<int>(label), voxels.label_colours);
    std::string id = "Segment_";
    add(segment + "ID", id.append(std::to_string(label)));
    add(segment + "Name", voxels.label_names[label]);
    add(segment + "Color", text_of(c.x) + " " + text_of(c.y) + " " + text_of(c.z));
    add(segment + "LabelValue", std::to_string(label));
    add(segment + "Layer", "0");
    add(segment + "Extent", extent);
    add(segment + "NameAutoGenerated", "0");
    add(segment + "ColorAutoGenerated", voxels.label_colours.empty() ? "1" : "0");
    add(segment + "Tags", "|");
  }
}

}  // namespace

Status write_image_file(const std::string& temporary, const std::string& path, const VoxelsToWrite& voxels) {
  const Format format = format_of(path);
  const QuietStreams quiet;
  try {
    format.io->SetFileName(temporary);
    format.io->SetNumberOfDimensions(3);
    format.io->SetNumberOfComponents(1);
    format.io->SetComponentType(voxels.is_int16() ? itk::IOComponentEnum::SHORT
                                                  : itk::IOComponentEnum::UCHAR);
    format.io->SetPixelType(itk::IOPixelEnum::SCALAR);
    itk::ImageIORegion region(3);
    const volume::Frame& frame = voxels.frame;
    for (unsigned a = 0; a < 3; ++a) {
      const int i = static_cast<int>(a);
      format.io->SetDimensions(a, static_cast<itk::SizeValueType>(voxels.size[i]));
      format.io->SetSpacing(a, frame.spacing()[i]);
      format.io->SetOrigin(a, frame.origin()[i]);
      const glm::dvec3 direction = frame.axes()[i] / frame.spacing()[i];
      format.io->SetDirection(a, {direction.x, direction.y, direction.z});
      region.SetSize(a, static_cast<itk::SizeValueType>(voxels.size[i]));
    }
    format.io->SetIORegion(region);
    itk::MetaDataDictionary& metadata = format.io->GetMetaDataDictionary();
    // This key states the units of the values for open_volume().
    if (voxels.is_hounsfield) itk::EncapsulateMetaData<std::string>(metadata, k_units_key, k_units);
    if (has_extension(path, ".seg.nrrd")) add_segment_metadata(metadata, voxels);
    format.io->SetUseCompression(false);
    format.io->WriteImageInformation();
    format.io->Write(voxels.data());
  } catch (const itk::ExceptionObject&) {
    return cannot_write(path, ENOSPC);  // write_atomically() has already checked the path
  }
  return check_written(temporary, path, voxels.bytes());
}

Result<OpenedVolume> open_image_file(const std::string& path, const OpenOptions& options) {
  const std::string where = file_name(path);
  const Format format = format_of(path);
  const auto read_error = [&](const std::string& found) {
    return Error{.what = "the " + format.name + " file cannot be read",
                 .where = where,
                 .found = found,
                 .expected = "a complete file of that format",
                 .remedy = "copy or export it again"};
  };
  if (const std::string fault = metaimage_header_fault(path); !fault.empty()) return read_error(fault);
  const QuietStreams quiet;
  try {
    itk::ImageIOBase& io = *format.io;
    if (!io.CanReadFile(path.c_str())) return read_error("no " + format.name + " header");
    io.SetFileName(path);
    io.ReadImageInformation();
    unsigned dimensions = io.GetNumberOfDimensions();
    for (; dimensions > 3 && io.GetDimensions(dimensions - 1) == 1; --dimensions) {}
    if (dimensions != 3 && dimensions != 4)
      return read_error(std::to_string(dimensions) + " dimensions instead of 3");
    const std::size_t volumes = dimensions == 4 ? io.GetDimensions(3) : 1;
    const Result<std::size_t> index = volume_index(options, volumes, where);
    if (!index) return index.error();
    if (io.GetNumberOfComponents() != 1)
      return read_error(std::to_string(io.GetNumberOfComponents()) + " values per voxel instead of 1");
    glm::ivec3 size;
    glm::dvec3 origin;
    glm::dmat3 axes;
    for (unsigned a = 0; a < 3; ++a) {
      const int i = static_cast<int>(a);
      size[i] = static_cast<int>(std::min<itk::SizeValueType>(io.GetDimensions(a), 2'000'000'000));
      origin[i] = io.GetOrigin(a);
      if (!(io.GetSpacing(a) > 0) || !std::isfinite(io.GetSpacing(a)))
        return Error{.what = "the spacing is not a positive number",
                     .where = where,
                     .found = text_of(io.GetSpacing(a)) + " mm",
                     .expected = "a spacing above 0 mm on each axis",
                     .remedy = "export the volume again"};
      const std::vector<double> direction = io.GetDirection(a);
      for (int k = 0; k < 3; ++k) axes[i][k] = direction[static_cast<std::size_t>(k)] * io.GetSpacing(a);
    }
    OpenedVolume opened;
    if (!has_key(path, {"ElementSpacing", "ElementSize"})) {
      if (!options.spacing)
        return Error{.what = "the voxel spacing is missing",
                     .where = where,
                     .found = "neither ElementSpacing nor ElementSize",
                     .expected = "one of them, in mm",
                     .remedy = "state the voxel size (option spacing X,Y,Z)"};
      for (int a = 0; a < 3; ++a) axes[a] *= (*options.spacing)[a];
      opened.uses_given_frame = true;
    }
    opened.format = format.name;
    if (!has_key(path, {"TransformMatrix", "Rotation", "Orientation"})) {
      axes = *axes_of(options.axes) * axes;
      opened.uses_given_frame = true;
      opened.notices.push_back("the file has no patient axes: " + options.axes +
                               " was assumed (option axes)");
    }
    const Result<volume::Frame> frame = volume::Frame::from_axes(origin, axes);
    // Check the file before allocating memory. A product that overflows exceeds any file.
    std::size_t expected_bytes = io.GetComponentSize();
    for (int i = 0; i < 3; ++i)
      if (__builtin_mul_overflow(expected_bytes, static_cast<std::size_t>(size[i]), &expected_bytes))
        return read_error("an impossible size");
    if (__builtin_mul_overflow(expected_bytes, volumes, &expected_bytes))
      return read_error("an impossible size");
    MetaImageData data;
    if (const std::string fault = find_metaimage_data(path, data); !fault.empty()) return read_error(fault);
    if (!data.is_compressed && data.size < expected_bytes)
      return read_error(std::to_string(data.size) + " of " + std::to_string(expected_bytes) +
                        " bytes of voxels");
    Result<Volume> result = allocate_volume(size, frame, where);
    if (!result) return result.error();
    const std::size_t bytes = result.value().voxels.size() * io.GetComponentSize() * volumes;
    if (Status error = check_memory(bytes, where)) return *error;
    itk::ImageIORegion region(io.GetNumberOfDimensions());
    for (unsigned a = 0; a < io.GetNumberOfDimensions(); ++a) region.SetSize(a, io.GetDimensions(a));
    io.SetIORegion(region);
    if (options.progress && !options.progress(0)) return reading_interrupted(where);

    opened.volume = std::move(result).value();
    const std::size_t notice_count = opened.notices.size();
    Volume& volume = opened.volume;
    const auto read_all = [&](char* bytes_out) -> std::string {
      if (!data.is_compressed) {
        io.Read(bytes_out);
        return "";
      }
      if (std::string fault = inflate_voxels(data, bytes_out, bytes); !fault.empty()) return fault;
      if (io.GetByteOrder() == itk::IOByteOrderEnum::BigEndian) {
        const std::size_t width = io.GetComponentSize();
        for (char* v = bytes_out; v < bytes_out + bytes; v += width) std::reverse(v, v + width);
      }
      return "";
    };
    if (io.GetComponentType() == itk::IOComponentEnum::SHORT && volumes == 1 && !options.scale) {
      if (const std::string fault = read_all(reinterpret_cast<char*>(volume.voxels.data())); !fault.empty())
        return read_error(fault);
    } else {
      Buffer<char> raw(bytes);
      if (const std::string fault = read_all(raw.data()); !fault.empty()) return read_error(fault);
      const auto values = reader_of(io.GetComponentType(), raw.data() + index.value() * (bytes / volumes));
      if (!values) return read_error("voxels of an unknown type");
      if (Status error = fill_voxels(volume, *values, options.scale, where, opened.notices)) return *error;
    }
    opened.is_rounded = opened.notices.size() > notice_count;
    if (volumes > 1) add_volume_notice(opened, index.value(), volumes);
    std::string units;
    itk::ExposeMetaData<std::string>(io.GetMetaDataDictionary(), k_units_key, units);
    detect_units(opened, units == k_units);
    return opened;
  } catch (const itk::ExceptionObject& e) {
    return read_error(itk_message(e));
  } catch (const std::exception&) {
    return read_error("damaged contents");
  }
}

}  // namespace trephine::data_tools
