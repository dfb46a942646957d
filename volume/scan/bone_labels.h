// BoneLabels: bone identified by a segmentation. A voxel with a bone's label is bone at any intensity.
#pragma once

#include <array>
#include <string_view>

#include "volume/cuts/version.h"
#include "volume/scan/field.h"

namespace trephine::volume {

/// Returns true if the label name denotes a bone: "vertebrae_L4", "L4", "skull", "sacrum", "hip_left".
/// Knows the names of TotalSegmentator, VerSe and the built-in phantoms.
bool is_bone_name(std::string_view label);

/// Returns true if the labels name vertebrae and no structure of the head (skull, brain, mandible), as in a
/// scan of a spine that is operated on from the back.
bool is_spine(const Volume& scan);

/// Returns true in a voxel of soft tissue: its label is not the background, and denotes no bone, tooth,
/// implant or metal. The blurred edge of bone may extend into such a voxel, where a threshold finds bone by
/// mistake.
bool has_soft_label(const Volume& volume, const glm::dvec3& p_world);

/// Set of the voxels whose label denotes a bone. Borrows the volume.
class BoneLabels {
 public:
  explicit BoneLabels(const Volume& volume);
  /// Returns true if any label denotes a bone.
  bool has_any() const noexcept { return has_any_; }
  bool contains_voxel(const glm::ivec3& v) const noexcept {
    return has_any_ && volume_->contains(v) && is_bone_[volume_->labels[volume_->index(v.x, v.y, v.z)]];
  }
  /// `p`: volume frame, voxels.
  bool contains(const glm::dvec3& p) const noexcept;

 private:
  const Volume* volume_;
  std::array<bool, 256> is_bone_{};
  bool has_any_ = false;
};

/// Tests points for bone: inside a shape or in a voxel of a bone label, and not removed. Borrows volume and
/// version; `version` null: nothing was removed.
class BoneClassifier {
 public:
  BoneClassifier(const Volume& volume, const Shape& shape, const Version* version)
      : field_(volume, shape), labels_(volume), version_(version) {}
  /// Returns true if any label denotes a bone.
  bool has_labels() const noexcept { return labels_.has_any(); }
  /// Returns true in a voxel of a bone label that is not removed. Does not test the shape.
  bool has_bone_label(const glm::dvec3& p_world) const noexcept;
  bool operator()(const glm::dvec3& p_world) const noexcept;

 private:
  Field field_;
  BoneLabels labels_;
  const Version* version_;
};

}  // namespace trephine::volume
