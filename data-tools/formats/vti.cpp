#include "data-tools/formats/vti.h"

#include <cerrno>
#include <cmath>
#include <cstring>
#include <functional>
#include <new>
#include <vtkDataArray.h>
#include <vtkErrorCode.h>
#include <vtkExecutive.h>
#include <vtkFieldData.h>
#include <vtkImageData.h>
#include <vtkMatrix3x3.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkShortArray.h>
#include <vtkStringArray.h>
#include <vtkUnsignedCharArray.h>
#include <vtkXMLImageDataReader.h>
#include <vtkXMLImageDataWriter.h>

#include "data-tools/files/atomic_file.h"
#include "data-tools/files/subprocess.h"
#include "data-tools/formats/reader_support.h"
#include "data-tools/formats/voxel_values.h"
#include "data-tools/formats/vtk_errors.h"

namespace trephine::data_tools {

namespace {

constexpr const char* k_voxels = "voxels";

}  // namespace

namespace {

/// Properties of a file. Trivially copyable, for memory shared by processes.
struct VtiFacts {
  glm::ivec3 size{0};
  glm::dvec3 origin{0.0};
  glm::dmat3 axes{1.0};
  bool is_short = false, is_ours = false, is_hounsfield = false;
  char fault[160] = "";
};

/// Reads a file and its properties; null if there is a fault. Only for child processes: VTK crashes on some
/// damaged files.
vtkDataArray* read_vti(vtkXMLImageDataReader* reader, const std::string& path, VtiFacts& facts) {
  const auto fail = [&](const std::string& reason) -> vtkDataArray* {
    std::snprintf(facts.fault, sizeof facts.fault, "%s", reason.c_str());
    return nullptr;
  };
  std::string errors;
  listen_to(reader, errors);
  listen_to(reader->GetExecutive(), errors);
  reader->SetFileName(path.c_str());
  if (!reader->CanReadFile(path.c_str())) return fail("no image data");
  reader->Update();
  vtkImageData* image = reader->GetOutput();
  if (!errors.empty() || !image || image->GetNumberOfPoints() == 0) return fail("damaged contents");
  vtkDataArray* values = image->GetPointData()->GetScalars();
  for (int i = 0; !values && i < image->GetPointData()->GetNumberOfArrays(); ++i)
    values = image->GetPointData()->GetArray(i);
  if (!values) return fail("no array of numbers at its points");
  if (values->GetNumberOfComponents() != 1)
    return fail(std::to_string(values->GetNumberOfComponents()) + " values per voxel instead of 1");
  int extent[6];
  image->GetExtent(extent);
  facts.size = {extent[1] - extent[0] + 1, extent[3] - extent[2] + 1, extent[5] - extent[4] + 1};
  for (int a = 0; a < 3; ++a)
    for (int row = 0; row < 3; ++row)
      facts.axes[a][row] = image->GetDirectionMatrix()->GetElement(row, a) * image->GetSpacing()[a];
  const double* o = image->GetOrigin();
  facts.origin = glm::dvec3(o[0], o[1], o[2]) + facts.axes * glm::dvec3(extent[0], extent[2], extent[4]);
  facts.is_short = vtkShortArray::SafeDownCast(values) != nullptr;
  auto* units = vtkStringArray::SafeDownCast(image->GetFieldData()->GetAbstractArray(k_units_key));
  facts.is_ours = units && units->GetNumberOfValues() == 1;
  facts.is_hounsfield = facts.is_ours && units->GetValue(0) == k_units;
  return values;
}

}  // namespace

Result<OpenedVolume> open_vti(const std::string& path, const OpenOptions& options) {
  const std::string where = file_name(path);
  const auto shared = SharedBytes::make(sizeof(VtiFacts));
  if (!shared) return too_large(sizeof(VtiFacts), where);
  VtiFacts& facts = *new (shared->data()) VtiFacts;
  const auto run_in_child = [&](const std::function<void()>& work) {
    return subprocess_status(
        run_in_subprocess(
            1, [&](int) { work(); }, [&](double) { return !options.progress || options.progress(0); }),
        where);
  };
  if (Status error = run_in_child([&] {
        vtkNew<vtkXMLImageDataReader> reader;
        read_vti(reader, path, facts);
      }))
    return *error;
  const auto read_error = [&] {
    return Error{.what = "the .vti file cannot be read",
                 .where = where,
                 .found = facts.fault,
                 .expected = "a complete file of that format",
                 .remedy = "copy or export it again"};
  };
  if (facts.fault[0] != 0) return read_error();
  Result<volume::Volume> result =
      allocate_volume(facts.size, volume::Frame::from_axes(facts.origin, facts.axes), where);
  if (!result) return result.error();
  const std::size_t count = result.value().voxels.size(),
                    bytes = count * (facts.is_short ? sizeof(short) : sizeof(double));
  const auto buffer = SharedBytes::make(bytes);
  if (!buffer) return too_large(bytes, where);
  const VtiFacts expected = facts;
  if (Status error = run_in_child([&] {
        vtkNew<vtkXMLImageDataReader> reader;
        vtkDataArray* values = read_vti(reader, path, facts);
        if (values == nullptr || facts.size != expected.size || facts.is_short != expected.is_short) {
          if (facts.fault[0] == 0)
            std::snprintf(facts.fault, sizeof facts.fault, "contents that changed while they were read");
          return;
        }
        if (facts.is_short) {
          std::memcpy(buffer->data(), values->GetVoidPointer(0), bytes);
          return;
        }
        auto* const doubles = reinterpret_cast<double*>(buffer->data());
        for (std::size_t i = 0; i < count; ++i) doubles[i] = values->GetTuple1(static_cast<vtkIdType>(i));
      }))
    return *error;
  if (facts.fault[0] != 0) return read_error();
  OpenedVolume opened;
  opened.volume = std::move(result).value();
  opened.format = "VTK image data";
  if (Status error =
          fill_voxels(opened.volume,
                      facts.is_short ? values_of<short>(buffer->data()) : values_of<double>(buffer->data()),
                      options.scale, where, opened.notices))
    return *error;
  opened.is_rounded = !opened.notices.empty();
  if (!facts.is_ours)
    opened.notices.push_back("a .vti has no patient axes: LPS (left, back, up) was assumed");
  detect_units(opened, facts.is_hounsfield);
  return opened;
}

Status write_vti(const std::string& temporary, const std::string& path, const VoxelsToWrite& voxels) {
  const glm::ivec3& size = voxels.size;
  const volume::Frame& frame = voxels.frame;
  vtkNew<vtkImageData> image;
  image->SetDimensions(size.x, size.y, size.z);
  image->SetOrigin(frame.origin().x, frame.origin().y, frame.origin().z);
  image->SetSpacing(frame.spacing().x, frame.spacing().y, frame.spacing().z);
  for (int a = 0; a < 3; ++a)
    for (int row = 0; row < 3; ++row)
      image->GetDirectionMatrix()->SetElement(row, a, frame.axes()[a][row] / frame.spacing()[a]);
  const vtkIdType count = image->GetNumberOfPoints();
  vtkNew<vtkShortArray> shorts;
  vtkNew<vtkUnsignedCharArray> bytes;
  // Borrowed arrays: the writer only reads them.
  if (voxels.is_int16())
    shorts->SetArray(const_cast<short*>(voxels.scan), count, 1);
  else
    bytes->SetArray(const_cast<unsigned char*>(voxels.labels), count, 1);
  vtkDataArray* values = voxels.is_int16() ? static_cast<vtkDataArray*>(shorts) : bytes;
  values->SetName(k_voxels);
  image->GetPointData()->SetScalars(values);
  vtkNew<vtkStringArray> units;
  units->SetName(k_units_key);
  units->InsertNextValue(voxels.is_hounsfield ? k_units : "");
  image->GetFieldData()->AddArray(units);
  std::string errors;
  vtkNew<vtkXMLImageDataWriter> writer;
  listen_to(writer, errors);
  writer->SetFileName(temporary.c_str());
  writer->SetInputData(image);
  writer->SetCompressorTypeToNone();
  writer->SetDataModeToAppended();
  writer->EncodeAppendedDataOff();
  listen_to(writer->GetExecutive(), errors);
  // VTK does not report a full disk. The path was checked before, so a failure is attributed to a full disk,
  // and the size of the file is checked.
  const bool is_written = writer->Write() == 1 && errors.empty() && writer->GetErrorCode() == 0;
  return is_written ? check_written(temporary, path, voxels.bytes()) : cannot_write(path, ENOSPC);
}

}  // namespace trephine::data_tools
