#include "data-tools/invesalius.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <sstream>
#include <vtkNew.h>
#include <vtkXMLDataElement.h>
#include <vtkXMLDataParser.h>

#include "data-tools/archive.h"
#include "data-tools/atomic_file.h"
#include "data-tools/opening.h"
#include "data-tools/voxel_values.h"
#include "data-tools/vtk_errors.h"

namespace trephine::data_tools {

using volume::Error;
using volume::Result;

namespace {

constexpr std::size_t k_most_list = 64u << 20;

/// A property list: <dict> of <key> and value by turns.
vtkXMLDataElement* value_of(vtkXMLDataElement* dict, const std::string& key) {
  if (dict == nullptr) return nullptr;
  for (int i = 0; i + 1 < dict->GetNumberOfNestedElements(); ++i) {
    vtkXMLDataElement* one = dict->GetNestedElement(i);
    if (std::string_view(one->GetName()) == "key" && one->GetCharacterData() &&
        key == one->GetCharacterData())
      return dict->GetNestedElement(i + 1);
  }
  return nullptr;
}

std::string text_of(vtkXMLDataElement* value) {
  return value && value->GetCharacterData() ? value->GetCharacterData() : "";
}

/// Numbers of an <array>, of arrays in it too.
void numbers_of(vtkXMLDataElement* value, std::vector<double>& numbers) {
  if (value == nullptr) return;
  const std::string_view name = value->GetName();
  if (name == "integer" || name == "real") {
    double number = std::nan("");
    const std::string text = text_of(value);
    const std::size_t begin = std::min(text.find_first_not_of(" \n\t"), text.size());
    std::from_chars(text.data() + begin, text.data() + text.size(), number);
    numbers.push_back(number);
  }
  for (int i = 0; i < value->GetNumberOfNestedElements(); ++i)
    numbers_of(value->GetNestedElement(i), numbers);
}

const ArchiveMember* member(const std::vector<ArchiveMember>& all, const std::string& name) {
  const auto found = std::find_if(all.begin(), all.end(), [&](const ArchiveMember& one) {
    return one.name == name || one.name.ends_with("/" + name);
  });
  return found == all.end() ? nullptr : &*found;
}

}  // namespace

Result<OpenedVolume> open_invesalius(const std::string& path, const OpenOptions& options) {
  const std::string where = file_name(path);
  const auto broken = [&](const std::string& found) {
    return Error{"the InVesalius project cannot be read", where, found,
                 "an .inv3 archive with main.plist and its matrix",
                 "export the scan from InVesalius as NIfTI, or open its DICOM files"};
  };
  const Result<std::vector<ArchiveMember>> read = read_archive(path, options.progress);
  if (!read) return read.error();
  const std::vector<ArchiveMember>& members = read.value();
  const ArchiveMember* list = member(members, "main.plist");
  if (list == nullptr) return broken("no main.plist");
  vtkNew<vtkXMLDataParser> parser;
  std::string heard;
  listen_to(parser, heard);
  std::istringstream text(list->bytes->substr(0, k_most_list));
  parser->SetStream(&text);
  const bool is_read = parser->Parse() != 0;
  vtkXMLDataElement* root = is_read && heard.empty() ? parser->GetRootElement() : nullptr;
  vtkXMLDataElement* project = root ? root->FindNestedElementWithName("dict") : nullptr;
  vtkXMLDataElement* matrix = value_of(project, "matrix");
  std::vector<double> shape, spacing, affine, orientation;
  numbers_of(value_of(matrix, "shape"), shape);
  numbers_of(value_of(project, "spacing"), spacing);
  numbers_of(value_of(project, "affine"), affine);
  numbers_of(value_of(project, "orientation"), orientation);
  const std::string type = text_of(value_of(matrix, "dtype"));
  const auto is_sound = [](const std::vector<double>& values, double most) {
    return values.size() == 3 &&
           std::all_of(values.begin(), values.end(), [most](double v) { return v > 0 && v <= most; });
  };
  if (!is_sound(shape, 1e6) || !is_sound(spacing, 1000) || type != "int16")
    return broken(type == "int16" || type.empty() ? "a main.plist without shape or spacing"
                                                  : "a matrix of " + type + " instead of int16");
  if (orientation != std::vector<double>{1})
    return broken("slices that are not axial: how they lie in the patient is not kept in the project");
  OpenedVolume opened;
  opened.format = "InVesalius";
  opened.modality = text_of(value_of(project, "modality"));
  const glm::ivec3 size(static_cast<int>(shape[2]), static_cast<int>(shape[1]), static_cast<int>(shape[0]));
  OpenOptions placed = options;
  placed.spacing = glm::dvec3(spacing[0], spacing[1], spacing[2]);
  const Result<volume::Frame> frame = given_frame(opened, placed, where);
  if (!frame) return frame.error();
  Result<volume::Volume> made = make_room(size, frame, where);
  if (!made) return made.error();
  opened.volume = std::move(made).value();
  const std::string name = text_of(value_of(matrix, "filename"));
  const ArchiveMember* voxels = name.empty() ? nullptr : member(members, name);
  if (voxels == nullptr || voxels->bytes->size() != opened.volume.voxels.bytes())
    return broken(voxels ? std::to_string(voxels->bytes->size()) + " of " +
                               std::to_string(opened.volume.voxels.bytes()) + " bytes of voxels"
                         : "no file with the voxels");
  std::memcpy(opened.volume.voxels.data(), voxels->bytes->data(), voxels->bytes->size());
  if (!affine.empty())
    opened.notices.push_back("the project's own frame (of a NIfTI that it came from) was not taken");
  if (opened.modality == "CT")
    opened.volume.is_hounsfield = true;
  else if (opened.modality == "MRI")
    opened.modality = "MR";
  else
    opened.modality.clear(), know_units(opened, false);
  return opened;
}

}  // namespace trephine::data_tools
