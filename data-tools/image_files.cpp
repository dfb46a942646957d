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
#include <map>
#include <memory>
#include <sstream>
#include <zlib.h>

#include "data-tools/atomic_file.h"
#include "data-tools/opening.h"
#include "data-tools/quiet_streams.h"
#include "data-tools/voxel_values.h"
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

/// ITK's reader trusts a MetaImage's header: it divides by what it finds and loops as often as it says.
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

/// Location of the voxels of a MetaImage.
struct MetaImageData {
  std::string path;
  std::uint64_t begin = 0, size = 0;  ///< bytes, in that file
  bool is_compressed = false;
};

/// Reads it from the header. Returns what is wrong, in words, or "".
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
  if (leaves_folder(name)) return "voxels in a file outside its folder";
  if (name == "LOCAL" || name == "local" || name == "Local") {
    data.path = path;
    data.begin = in ? static_cast<std::uint64_t>(in.tellg()) : fs::file_size(path);
  } else {
    if (name.starts_with("LIST") || name.find('%') != std::string::npos)
      return "voxels spread over several files";
    data.path = (fs::path(path).parent_path() / name).string();
  }
  std::error_code error;
  const std::uint64_t whole = fs::file_size(data.path, error);
  if (error) return "no file " + file_name(name) + " with the voxels";
  data.size = whole > data.begin ? whole - data.begin : 0;
  if (!data.is_compressed || !fields.contains("CompressedDataSize")) return "";
  const std::uint64_t promised = std::strtoull(fields["CompressedDataSize"].c_str(), nullptr, 10);
  if (data.size < promised)
    return std::to_string(data.size) + " of " + std::to_string(promised) + " bytes of compressed voxels";
  data.size = promised;
  return "";
}

/// Inflates compressed voxels, whose size and checksum must be right: MetaIO checks neither. Returns what is
/// wrong, in words, or "".
std::string inflate_voxels(const MetaImageData& data, char* to, std::size_t bytes) {
  std::ifstream in(data.path, std::ios::binary);
  in.seekg(static_cast<std::streamoff>(data.begin));
  z_stream stream{};
  constexpr int k_zlib_or_gzip = 32 + MAX_WBITS;
  if (inflateInit2(&stream, k_zlib_or_gzip) != Z_OK) return "no memory to decompress it";
  const std::unique_ptr<z_stream, int (*)(z_stream*)> closing(&stream, inflateEnd);
  std::vector<char> part(1 << 20);
  std::uint64_t left = data.size;
  std::size_t written = 0;
  char spare = 0;  // shows whether there is more than was promised
  for (;;) {
    if (stream.avail_in == 0 && left > 0) {
      const std::size_t count = std::min<std::uint64_t>(left, part.size());
      in.read(part.data(), static_cast<std::streamsize>(count));
      if (in.gcount() != static_cast<std::streamsize>(count)) return "its compressed voxels cannot be read";
      left -= count;
      stream.next_in = reinterpret_cast<Bytef*>(part.data());
      stream.avail_in = static_cast<uInt>(count);
    }
    const bool is_full = written == bytes;
    const std::size_t room = is_full ? 1 : std::min<std::size_t>(bytes - written, 1u << 30);
    stream.next_out = reinterpret_cast<Bytef*>(is_full ? &spare : to + written);
    stream.avail_out = static_cast<uInt>(room);
    const int state = inflate(&stream, Z_NO_FLUSH);
    const std::size_t made = room - stream.avail_out;
    if (is_full && made > 0) return "more voxels than its size promises";
    written += made;
    if (state == Z_STREAM_END) break;
    if (state == Z_BUF_ERROR || (state == Z_OK && made == 0 && stream.avail_in == 0 && left == 0))
      return "compressed voxels that end too early";
    if (state != Z_OK) return "damaged compressed voxels";
  }
  if (written < bytes) return std::to_string(written) + " of " + std::to_string(bytes) + " bytes of voxels";
  return "";
}

/// Does a MetaImage's header say one of these?
bool says(const std::string& path, std::initializer_list<const char*> keys) {
  std::ifstream in(path, std::ios::binary);
  for (std::string line; std::getline(in, line) && !line.starts_with("ElementDataFile");)
    for (const char* key : keys)
      if (line.starts_with(key)) return true;
  return false;
}

/// Slicer's words for what a label map holds.
void name_segments(itk::MetaDataDictionary& facts, const VoxelsToWrite& voxels) {
  const auto say = [&facts](const std::string& key, const std::string& value) {
    itk::EncapsulateMetaData<std::string>(facts, key, value);
  };
  say("Segmentation_MasterRepresentation", "Binary labelmap");
  say("Segmentation_ContainedRepresentationNames", "Binary labelmap|");
  say("Segmentation_ReferenceImageExtentOffset", "0 0 0");
  std::string extent;
  for (int a = 0; a < 3; ++a) extent.append(a == 0 ? "0 " : " 0 ").append(std::to_string(voxels.size[a] - 1));
  for (std::size_t label = 1; label < voxels.label_names.size(); ++label) {
    std::string segment = "Segment";
    segment.append(std::to_string(label - 1)).append("_");
    const glm::dvec3 c = label_colour(static_cast<int>(label), voxels.label_colours);
    std::string id = "Segment_";
    say(segment + "ID", id.append(std::to_string(label)));
    say(segment + "Name", voxels.label_names[label]);
    say(segment + "Color", volume::text_of(c.x) + " " + volume::text_of(c.y) + " " + volume::text_of(c.z));
    say(segment + "LabelValue", std::to_string(label));
    say(segment + "Layer", "0");
    say(segment + "Extent", extent);
    say(segment + "NameAutoGenerated", "0");
    say(segment + "ColorAutoGenerated", voxels.label_colours.empty() ? "1" : "0");
    say(segment + "Tags", "|");
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
    format.io->SetComponentType(voxels.is_short() ? itk::IOComponentEnum::SHORT
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
    itk::MetaDataDictionary& facts = format.io->GetMetaDataDictionary();
    // Read again, a file of ours says itself what its values are.
    if (voxels.is_hounsfield) itk::EncapsulateMetaData<std::string>(facts, k_units_key, k_units);
    if (has_extension(path, ".seg.nrrd")) name_segments(facts, voxels);
    format.io->SetUseCompression(false);
    format.io->WriteImageInformation();
    format.io->Write(voxels.data());
  } catch (const itk::ExceptionObject&) {
    return cannot_write(path, ENOSPC);  // place and name are good
  }
  return check_written(temporary, path, voxels.bytes());
}

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
    OpenedVolume opened;
    if (!says(path, {"ElementSpacing", "ElementSize"})) {
      if (!options.spacing)
        return Error{"the file does not say how large its voxels are", where,
                     "neither ElementSpacing nor ElementSize", "one of them, in mm",
                     "say it: --spacing X,Y,Z"};
      for (int a = 0; a < 3; ++a) axes[a] *= (*options.spacing)[a];
      opened.uses_given_frame = true;
    }
    opened.format = format.name;
    if (!says(path, {"TransformMatrix", "Rotation", "Orientation"})) {
      axes = *axes_of(options.axes) * axes;
      opened.uses_given_frame = true;
      opened.notices.push_back("the file does not say which way a patient lies: its axes were taken as " +
                               options.axes + " (--axes)");
    }
    const Result<volume::Frame> frame = volume::Frame::from_axes(origin, axes);
    // The file first, the memory for it then. A product that wraps is larger than any file, too.
    std::size_t promised = io.GetComponentSize();
    for (int i = 0; i < 3; ++i)
      if (__builtin_mul_overflow(promised, static_cast<std::size_t>(size[i]), &promised))
        return broken("a size that cannot be");
    if (__builtin_mul_overflow(promised, volumes, &promised)) return broken("a size that cannot be");
    MetaImageData data;
    if (const std::string fault = find_metaimage_data(path, data); !fault.empty()) return broken(fault);
    if (!data.is_compressed && data.size < promised)
      return broken(std::to_string(data.size) + " of " + std::to_string(promised) + " bytes of voxels");
    Result<Volume> made = make_room(size, frame, where);
    if (!made) return made.error();
    const std::size_t bytes = made.value().voxels.size() * io.GetComponentSize() * volumes;
    if (Status error = check_memory(bytes, where)) return *error;
    itk::ImageIORegion region(io.GetNumberOfDimensions());
    for (unsigned a = 0; a < io.GetNumberOfDimensions(); ++a) region.SetSize(a, io.GetDimensions(a));
    io.SetIORegion(region);
    if (options.progress && !options.progress(0)) return reading_interrupted(where);

    opened.volume = std::move(made).value();
    const std::size_t told = opened.notices.size();
    Volume& volume = opened.volume;
    const auto read_all = [&](char* to) -> std::string {
      if (!data.is_compressed) {
        io.Read(to);
        return "";
      }
      if (std::string fault = inflate_voxels(data, to, bytes); !fault.empty()) return fault;
      if (io.GetByteOrder() == itk::IOByteOrderEnum::BigEndian) {
        const std::size_t width = io.GetComponentSize();
        for (char* v = to; v < to + bytes; v += width) std::reverse(v, v + width);
      }
      return "";
    };
    if (io.GetComponentType() == itk::IOComponentEnum::SHORT && volumes == 1 && !options.scale) {
      if (const std::string fault = read_all(reinterpret_cast<char*>(volume.voxels.data())); !fault.empty())
        return broken(fault);
    } else {
      volume::Buffer<char> raw(bytes);
      if (const std::string fault = read_all(raw.data()); !fault.empty()) return broken(fault);
      const auto values = reader_of(io.GetComponentType(), raw.data() + index.value() * (bytes / volumes));
      if (!values) return broken("voxels of an unknown kind");
      if (Status error = fill_voxels(volume, *values, options.scale, where, opened.notices)) return *error;
    }
    opened.is_rounded = opened.notices.size() > told;
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

}  // namespace trephine::data_tools
