// Bone by its labels: where a segmentation names a bone, its inside counts whatever the intensity says.
#pragma once

#include <array>
#include <string_view>

#include "volume/field.h"
#include "volume/version.h"

namespace trephine::volume {

/// Does the name of a label name a bone: "vertebrae_L4", "L4", "skull", "sacrum", "hip_left"? Names of
/// TotalSegmentator, VerSe and the built-in phantoms.
bool names_bone(std::string_view label);

/// The voxels of labels that name a bone. Borrows the volume.
class BoneLabels {
 public:
  explicit BoneLabels(const Volume& volume);
  /// Does any label name a bone?
  bool has_any() const noexcept { return has_any_; }
  bool contains_voxel(const glm::ivec3& v) const noexcept {
    return has_any_ && volume_->contains(v) && is_bone_[volume_->labels[volume_->index(v.x, v.y, v.z)]];
  }
  /// `p`: in the volume's frame, voxels.
  bool contains(const glm::dvec3& p) const noexcept;

 private:
  const Volume* volume_;
  std::array<bool, 256> is_bone_{};
  bool has_any_ = false;
};

/// Tests for bone: where a shape is touched and nothing was cut away, or in a voxel of a label that names a
/// bone? Borrows volume and version; `version` null: untouched.
class BoneAt {
 public:
  BoneAt(const Volume& volume, const Shape& shape, const Version* version)
      : field_(volume, shape), labels_(volume), version_(version) {}
  /// Does any label name a bone?
  bool has_labels() const noexcept { return labels_.has_any(); }
  bool by_labels(const glm::dvec3& p_world) const noexcept;
  bool operator()(const glm::dvec3& p_world) const noexcept;

 private:
  Field field_;
  BoneLabels labels_;
  const Version* version_;
};

}  // namespace trephine::volume
