#include "data-tools/vti.h"

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

#include "data-tools/apart.h"
#include "data-tools/atomic_file.h"
#include "data-tools/opening.h"
#include "data-tools/voxel_values.h"
#include "data-tools/vtk_errors.h"

namespace trephine::data_tools {

using volume::Error;
using volume::Result;

namespace {

constexpr const char* k_voxels = "voxels";

}  // namespace

namespace {

/// Contents of a file. Plain, so that it can lie in memory that processes share.
struct VtiFacts {
  glm::ivec3 size{0};
  glm::dvec3 origin{0.0};
  glm::dmat3 axes{1.0};
  bool is_short = false, is_ours = false, is_hounsfield = false;
  char fault[160] = "";
};

/// The whole file, and its facts; null when there is a fault. VTK crashes on some damaged ones: in a process
/// of its own only.
vtkDataArray* read_vti(vtkXMLImageDataReader* reader, const std::string& path, VtiFacts& facts) {
  const auto fail = [&](const std::string& why) -> vtkDataArray* {
    std::snprintf(facts.fault, sizeof facts.fault, "%s", why.c_str());
    return nullptr;
  };
  std::string heard;
  listen_to(reader, heard);
  listen_to(reader->GetExecutive(), heard);
  reader->SetFileName(path.c_str());
  if (!reader->CanReadFile(path.c_str())) return fail("no image data");
  reader->Update();
  vtkImageData* image = reader->GetOutput();
  if (!heard.empty() || !image || image->GetNumberOfPoints() == 0) return fail("damaged contents");
  vtkDataArray* values = image->GetPointData()->GetScalars();
  for (int i = 0; !values && i < image->GetPointData()->GetNumberOfArrays(); ++i)
    values = image->GetPointData()->GetArray(i);
  if (!values) return fail("no array of numbers at its points");
  if (values->GetNumberOfComponents() != 1)
    return fail(std::to_string(values->GetNumberOfComponents()) + " values a voxel instead of 1");
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
  const auto apart = [&](const std::function<void()>& work) {
    return apart_status(
        run_apart(
            1, [&](int) { work(); }, [&](double) { return !options.progress || options.progress(0); }),
        where);
  };
  if (volume::Status error = apart([&] {
        vtkNew<vtkXMLImageDataReader> reader;
        read_vti(reader, path, facts);
      }))
    return *error;
  const auto broken = [&] {
    return Error{"the .vti file cannot be read", where, facts.fault, "a complete file of that format",
                 "copy or export it again"};
  };
  if (facts.fault[0] != 0) return broken();
  Result<volume::Volume> made =
      make_room(facts.size, volume::Frame::from_axes(facts.origin, facts.axes), where);
  if (!made) return made.error();
  const std::size_t count = made.value().voxels.size(),
                    bytes = count * (facts.is_short ? sizeof(short) : sizeof(double));
  const auto room = SharedBytes::make(bytes);
  if (!room) return too_large(bytes, where);
  const VtiFacts promised = facts;
  if (volume::Status error = apart([&] {
        vtkNew<vtkXMLImageDataReader> reader;
        vtkDataArray* values = read_vti(reader, path, facts);
        if (values == nullptr || facts.size != promised.size || facts.is_short != promised.is_short) {
          if (facts.fault[0] == 0) std::snprintf(facts.fault, sizeof facts.fault, "contents that change");
          return;
        }
        if (facts.is_short) {
          std::memcpy(room->data(), values->GetVoidPointer(0), bytes);
          return;
        }
        auto* const to = reinterpret_cast<double*>(room->data());
        for (std::size_t i = 0; i < count; ++i) to[i] = values->GetTuple1(static_cast<vtkIdType>(i));
      }))
    return *error;
  if (facts.fault[0] != 0) return broken();
  OpenedVolume opened;
  opened.volume = std::move(made).value();
  opened.format = "VTK image data";
  if (volume::Status error = fill_voxels(
          opened.volume, facts.is_short ? values_of<short>(room->data()) : values_of<double>(room->data()),
          options.scale, where, opened.notices))
    return *error;
  opened.is_rounded = !opened.notices.empty();
  if (!facts.is_ours)
    opened.notices.push_back(
        "a .vti does not say which way a patient lies: its axes were taken for left, back, up (LPS)");
  know_units(opened, facts.is_hounsfield);
  return opened;
}

volume::Status write_vti(const std::string& temporary, const std::string& path, const VoxelsToWrite& voxels) {
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
  // Lent: the writer only reads.
  if (voxels.is_short())
    shorts->SetArray(const_cast<short*>(voxels.scan), count, 1);
  else
    bytes->SetArray(const_cast<unsigned char*>(voxels.labels), count, 1);
  vtkDataArray* values = voxels.is_short() ? static_cast<vtkDataArray*>(shorts) : bytes;
  values->SetName(k_voxels);
  image->GetPointData()->SetScalars(values);
  vtkNew<vtkStringArray> units;
  units->SetName(k_units_key);
  units->InsertNextValue(voxels.is_hounsfield ? k_units : "");
  image->GetFieldData()->AddArray(units);
  std::string heard;
  vtkNew<vtkXMLImageDataWriter> writer;
  listen_to(writer, heard);
  writer->SetFileName(temporary.c_str());
  writer->SetInputData(image);
  writer->SetCompressorTypeToNone();
  writer->SetDataModeToAppended();
  writer->EncodeAppendedDataOff();
  listen_to(writer->GetExecutive(), heard);
  // Place and name are good; and it says nothing of a full disk.
  const bool is_written = writer->Write() == 1 && heard.empty() && writer->GetErrorCode() == 0;
  return is_written ? check_written(temporary, path, voxels.bytes()) : cannot_write(path, ENOSPC);
}

}  // namespace trephine::data_tools
