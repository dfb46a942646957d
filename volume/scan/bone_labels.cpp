#include "volume/scan/bone_labels.h"

#include <algorithm>
#include <cctype>
#include <string>

#include "volume/scan/traversal.h"

namespace trephine::volume {

bool is_bone_name(std::string_view label) {
  std::string name(label);
  for (char& c : name) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  // Soft tissue named after a bone: "vertebral disc", "vertebral artery".
  for (const char* soft : {"disc", "artery", "vein", "canal", "nerve"})
    if (name.find(soft) != std::string::npos) return false;
  for (const char* bone :
       {"vertebra", "sacrum",  "coccyx", "skull",   "cranium", "mandible", "bone",    "pelvis",
        "femur",    "tibia",   "fibula", "humerus", "radius",  "ulna",     "scapula", "clavicula",
        "clavicle", "sternum", "ilium",  "diploe",  "calvari", "maxilla",  "zygoma"})
    if (name.starts_with(bone) || name.find(std::string("_") + bone) != std::string::npos ||
        name.find(std::string(" ") + bone) != std::string::npos)
      return true;
  // Short names that begin other words, too: "rib 3", "ribs", "left hip", but not "hippocampus".
  for (const std::string word : {"rib", "ribs", "hip", "hips"})
    for (std::size_t at = name.find(word); at != std::string::npos; at = name.find(word, at + 1)) {
      const auto is_letter = [&](std::size_t i) {
        return i < name.size() && std::isalpha(static_cast<unsigned char>(name[i]));
      };
      if (!(at > 0 && is_letter(at - 1)) && !is_letter(at + word.size())) return true;
    }
  // Vertebrae by level: "c3", "T12", "L4", "S1", "l4 vertebra".
  if (name.size() < 2 || std::string_view("ctls").find(name[0]) == std::string_view::npos) return false;
  std::size_t end = 1;
  while (end < name.size() && name[end] >= '0' && name[end] <= '9') ++end;
  return end > 1 && end <= 3 && (end == name.size() || name.find("vertebra", end) != std::string::npos);
}

bool is_spine(const Volume& scan) {
  bool has_vertebra = false;
  for (const std::string& label : scan.label_names) {
    std::string name(label);
    for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    for (const char* head_name : {"skull", "cranium", "brain", "mandible"})
      if (name.find(head_name) != std::string::npos) return false;
    const bool is_short = name.size() >= 2 && name.size() <= 3 && name[1] >= '0' && name[1] <= '9';
    has_vertebra |= is_bone_name(label) && (is_short || name.find("vertebra") != std::string::npos);
  }
  return has_vertebra;
}

bool has_soft_label(const Volume& volume, const glm::dvec3& p_world) {
  if (volume.labels.is_empty()) return false;
  const glm::ivec3 v = voxel_of(volume.frame.volume_from_world(p_world));
  if (!volume.contains(v)) return false;
  const std::size_t label = volume.labels[volume.index(v.x, v.y, v.z)];
  if (label == 0) return false;
  if (label >= volume.label_names.size()) return true;
  std::string name = volume.label_names[label];
  std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) { return std::tolower(c); });
  for (const char* hard : {"tooth", "teeth", "screw", "implant", "metal"})
    if (name.find(hard) != std::string_view::npos) return false;
  return !is_bone_name(name);
}

BoneLabels::BoneLabels(const Volume& volume) : volume_(&volume) {
  if (volume.labels.is_empty()) return;
  for (std::size_t i = 1; i < std::min(volume.label_names.size(), is_bone_.size()); ++i)
    has_any_ |= is_bone_[i] = is_bone_name(volume.label_names[i]);
}

bool BoneLabels::contains(const glm::dvec3& p) const noexcept { return contains_voxel(voxel_of(p)); }

bool BoneClassifier::has_bone_label(const glm::dvec3& p_world) const noexcept {
  if (!labels_.has_any()) return false;
  const glm::ivec3 v = voxel_of(field_.volume().frame.volume_from_world(p_world));
  return labels_.contains_voxel(v) && (version_ == nullptr || version_->is_kept(v));
}

bool BoneClassifier::operator()(const glm::dvec3& p_world) const noexcept {
  const glm::dvec3 p = field_.volume().frame.volume_from_world(p_world);
  return has_bone_label(p_world) ||
         (field_.value(p) >= 0 && (version_ == nullptr || version_->distance(p) > 0));
}

}  // namespace trephine::volume
