#include "data-tools/formats/invesalius.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <sstream>
#include <vtkNew.h>
#include <vtkXMLDataElement.h>
#include <vtkXMLDataParser.h>

#include "data-tools/files/archive.h"
#include "data-tools/files/atomic_file.h"
#include "data-tools/formats/reader_support.h"
#include "data-tools/formats/voxel_values.h"
#include "data-tools/formats/vtk_errors.h"

namespace trephine::data_tools {

namespace {

constexpr std::size_t k_max_list = 64u << 20;  // bytes of main.plist that are read

/// Returns the value of a key in a property list: a <dict> of alternating <key> and value; null if absent.
vtkXMLDataElement* value_of(vtkXMLDataElement* dict, const std::string& key) {
  if (dict == nullptr) return nullptr;
  for (int i = 0; i + 1 < dict->GetNumberOfNestedElements(); ++i) {
    vtkXMLDataElement* element = dict->GetNestedElement(i);
    if (std::string_view(element->GetName()) == "key" && element->GetCharacterData() &&
        key == element->GetCharacterData())
      return dict->GetNestedElement(i + 1);
  }
  return nullptr;
}

std::string text_of(vtkXMLDataElement* value) {
  return value && value->GetCharacterData() ? value->GetCharacterData() : "";
}

/// Appends the number of an element, or the numbers of an <array> and its nested arrays.
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

/// Returns a member by its file name; null if absent.
const ArchiveMember* find_member(const std::vector<ArchiveMember>& members, const std::string& name) {
  const auto found = std::find_if(members.begin(), members.end(), [&](const ArchiveMember& candidate) {
    return candidate.name == name || candidate.name.ends_with("/" + name);
  });
  return found == members.end() ? nullptr : &*found;
}

}  // namespace

Result<OpenedVolume> open_invesalius(const std::string& path, const OpenOptions& options) {
  const std::string where = file_name(path);
  const auto project_error = [&](const std::string& found) {
    return Error{.what = "the InVesalius project cannot be read",
                 .where = where,
                 .found = found,
                 .expected = "an .inv3 archive with main.plist and its matrix",
                 .remedy = "export the scan from InVesalius as NIfTI, or open its DICOM files"};
  };
  const Result<std::vector<ArchiveMember>> archive_result = read_archive(path, options.progress);
  if (!archive_result) return archive_result.error();
  const std::vector<ArchiveMember>& members = archive_result.value();
  const ArchiveMember* list = find_member(members, "main.plist");
  if (list == nullptr) return project_error("no main.plist");
  vtkNew<vtkXMLDataParser> parser;
  std::string parse_errors;
  listen_to(parser, parse_errors);
  std::istringstream text(list->bytes->substr(0, k_max_list));
  parser->SetStream(&text);
  const bool is_parsed = parser->Parse() != 0;
  vtkXMLDataElement* root = is_parsed && parse_errors.empty() ? parser->GetRootElement() : nullptr;
  vtkXMLDataElement* project = root ? root->FindNestedElementWithName("dict") : nullptr;
  vtkXMLDataElement* matrix = value_of(project, "matrix");
  std::vector<double> shape, spacing, affine, orientation;
  numbers_of(value_of(matrix, "shape"), shape);
  numbers_of(value_of(project, "spacing"), spacing);
  numbers_of(value_of(project, "affine"), affine);
  numbers_of(value_of(project, "orientation"), orientation);
  const std::string type = text_of(value_of(matrix, "dtype"));
  const auto is_valid = [](const std::vector<double>& values, double limit) {
    return values.size() == 3 &&
           std::all_of(values.begin(), values.end(), [limit](double v) { return v > 0 && v <= limit; });
  };
  if (!is_valid(shape, 1e6) || !is_valid(spacing, 1000) || type != "int16")
    return project_error(type == "int16" || type.empty() ? "a main.plist without shape or spacing"
                                                         : "a matrix of " + type + " instead of int16");
  if (orientation != std::vector<double>{1})
    return project_error(
        "slices that are not axial: the project does not store their directions in the patient");
  OpenedVolume opened;
  opened.format = "InVesalius";
  opened.modality = text_of(value_of(project, "modality"));
  const glm::ivec3 size(static_cast<int>(shape[2]), static_cast<int>(shape[1]), static_cast<int>(shape[0]));
  OpenOptions frame_options = options;
  frame_options.spacing = glm::dvec3(spacing[0], spacing[1], spacing[2]);
  const Result<volume::Frame> frame = frame_from_options(opened, frame_options, where);
  if (!frame) return frame.error();
  Result<volume::Volume> result = allocate_volume(size, frame, where);
  if (!result) return result.error();
  opened.volume = std::move(result).value();
  const std::string name = text_of(value_of(matrix, "filename"));
  const ArchiveMember* voxels = name.empty() ? nullptr : find_member(members, name);
  if (voxels == nullptr || voxels->bytes->size() != opened.volume.voxels.bytes())
    return project_error(voxels ? std::to_string(voxels->bytes->size()) + " of " +
                                      std::to_string(opened.volume.voxels.bytes()) + " bytes of voxels"
                                : "no file with the voxels");
  std::memcpy(opened.volume.voxels.data(), voxels->bytes->data(), voxels->bytes->size());
  if (!affine.empty()) opened.notices.push_back("the project's frame (of an imported NIfTI) was ignored");
  if (opened.modality == "CT")
    opened.volume.is_hounsfield = true;
  else if (opened.modality == "MRI")
    opened.modality = "MR";
  else
    opened.modality.clear(), detect_units(opened, false);
  return opened;
}

}  // namespace trephine::data_tools
