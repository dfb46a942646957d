#include "data-tools/vti.h"

#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
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

Result<OpenedVolume> open_vti(const std::string& path, const OpenOptions& options) {
  const std::string where = file_name(path);
  const auto broken = [&](const std::string& found) {
    return Error{"the .vti file cannot be read", where, found, "a complete file of that format",
                 "copy or export it again"};
  };
  if (options.progress && !options.progress(0)) return reading_interrupted(where);
  std::string heard;
  vtkNew<vtkXMLImageDataReader> reader;
  listen_to(reader, heard);
  listen_to(reader->GetExecutive(), heard);
  reader->SetFileName(path.c_str());
  if (!reader->CanReadFile(path.c_str())) return broken("no image data");
  int extent[6];
  reader->Update();
  vtkImageData* image = reader->GetOutput();
  if (!heard.empty() || !image || image->GetNumberOfPoints() == 0) return broken("damaged contents");
  vtkDataArray* values = image->GetPointData()->GetScalars();
  for (int i = 0; !values && i < image->GetPointData()->GetNumberOfArrays(); ++i)
    values = image->GetPointData()->GetArray(i);
  if (!values) return broken("no array of numbers at its points");
  if (values->GetNumberOfComponents() != 1)
    return broken(std::to_string(values->GetNumberOfComponents()) + " values a voxel instead of 1");
  image->GetExtent(extent);
  const glm::ivec3 size(extent[1] - extent[0] + 1, extent[3] - extent[2] + 1, extent[5] - extent[4] + 1);
  glm::dmat3 axes;
  for (int a = 0; a < 3; ++a)
    for (int row = 0; row < 3; ++row)
      axes[a][row] = image->GetDirectionMatrix()->GetElement(row, a) * image->GetSpacing()[a];
  const double* o = image->GetOrigin();
  const glm::dvec3 origin = glm::dvec3(o[0], o[1], o[2]) + axes * glm::dvec3(extent[0], extent[2], extent[4]);
  Result<volume::Volume> made = make_room(size, volume::Frame::from_axes(origin, axes), where);
  if (!made) return made.error();
  OpenedVolume opened;
  opened.volume = std::move(made).value();
  opened.format = "VTK image data";
  const ValueReader read = [values](std::size_t first, std::span<double> to) {
    for (std::size_t i = 0; i < to.size(); ++i) to[i] = values->GetTuple1(static_cast<vtkIdType>(first + i));
  };
  if (volume::Status error = fill_voxels(opened.volume, read, options.scale, where, opened.notices))
    return *error;
  opened.is_rounded = !opened.notices.empty();
  auto* units = vtkStringArray::SafeDownCast(image->GetFieldData()->GetAbstractArray(k_units_key));
  const bool is_ours = units && units->GetNumberOfValues() == 1;
  if (!is_ours)
    opened.notices.push_back(
        "a .vti does not say which way a patient lies: its axes were taken for left, back, up (LPS)");
  know_units(opened, is_ours && units->GetValue(0) == k_units);
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
