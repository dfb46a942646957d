// Structures of Viewport: opacities, clipping and the cut face.
#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <set>
#include <utility>
#include <vtkCamera.h>
#include <vtkRenderer.h>

#include "apps/view/viewport.h"

namespace trephine::view {

using glm::dvec3;

void Viewport::set_clip(const ClipChoice& choice) {
  clip_ = choice;
  const dvec3 middle = 0.5 * (low_ + high_);
  clip_normal_ = dvec3(0);
  switch (choice.axis) {
    case ClipChoice::Axis::none:
    case ClipChoice::Axis::plane:
      break;
    case ClipChoice::Axis::left:
      clip_normal_ = {-1, 0, 0};
      break;
    case ClipChoice::Axis::back:
      clip_normal_ = {0, 1, 0};
      break;
    case ClipChoice::Axis::up:
      clip_normal_ = {0, 0, -1};
      break;
    case ClipChoice::Axis::view: {
      double n[3];
      view_.renderer()->GetActiveCamera()->GetDirectionOfProjection(n);
      clip_normal_ = {n[0], n[1], n[2]};
      break;
    }
  }
  if (choice.axis == ClipChoice::Axis::plane) {
    clip_origin_ = choice.at, clip_normal_ = -choice.normal;
  } else {
    const double reach = 0.5 * glm::dot(high_ - low_, glm::abs(clip_normal_));
    clip_origin_ = middle + (2 * choice.share - 1) * reach * clip_normal_;
  }
  view_.bone().set_clip(clip_origin_, clip_normal_);
  if (!is_live_) return;
  view_.structures()->set_clip(clip_origin_, clip_normal_);
  view_.overlays().set_clip(clip_origin_, clip_normal_);
  is_cap_moved_ = true;
  if (has_whole_structures() != are_structures_whole_)
    apply_opacities();
  else
    request_cap();
}

/// Requests the cut face of the clipped picture.
void Viewport::request_cap() {
  if (!is_live_) return;
  const std::optional<volume::Openings::Plane> plane = clip_plane();
  if (plane && version_ && !preview_) {
    // A coarse cut face is shown at once when the plane moves; the fine cut face replaces it later.
    const bool is_moved = std::exchange(is_cap_moved_, false);
    if (is_moved)
      view_.structures()->show_cap(cap_image(*scene_, *version_, list_, *plane, k_coarse_cap_pixels));
    return cap_.request(version_, list_, *plane, is_moved);
  }
  cap_.clear();
  view_.structures()->show_cap({});
}

/// Returns true if the clip plane crosses a box of voxels.
bool Viewport::is_clipped_in(const volume::VoxelBox& voxels) const {
  const std::optional<volume::Openings::Plane> plane = clip_plane();
  if (!plane) return false;
  bool is_before = false, is_behind = false;
  for (int corner = 0; corner < 8; ++corner) {
    const dvec3 p = glm::mix(dvec3(voxels.low) - 1.0, dvec3(voxels.high) + 1.0,
                             dvec3(corner & 1, (corner >> 1) & 1, corner >> 2));
    (glm::dot(scene_->base->frame.world_from_volume(p) - plane->at, plane->normal) > 0 ? is_before
                                                                                       : is_behind) = true;
  }
  return is_before && is_behind;
}

std::optional<double> Viewport::distance_to_clip_face(const volume::Version& version, const Ray& ray) const {
  const std::optional<volume::Openings::Plane> plane = clip_plane();
  if (!plane) return std::nullopt;
  const double toward = glm::dot(ray.direction, plane->normal);
  if (std::abs(toward) < 1e-6) return std::nullopt;
  const double along = glm::dot(plane->at - ray.origin, plane->normal) / toward;
  if (along < 0 || !has_cap_at(*scene_, version, list_, ray.origin + along * ray.direction))
    return std::nullopt;
  return along;
}

std::optional<volume::Openings::Plane> Viewport::clip_plane() const {
  if (clip_normal_ == dvec3(0)) return std::nullopt;
  return volume::Openings::Plane{clip_origin_, -clip_normal_};
}

bool Viewport::has_whole_structures() const {
  // The cut face of a clipped picture also shows the structures inside bone, so these are drawn whole.
  return clip_normal_ != dvec3(0) || std::any_of(list_.begin(), list_.end(), [](const Structure& s) {
           if (s.kind == Structure::Kind::objects) return false;
           return s.is_translucent() || (s.kind == Structure::Kind::all_bone && s.opacity < 1);
         });
}

bool Viewport::has_translucent_single_bone() const {
  return std::any_of(list_.begin(), list_.end(), [](const Structure& s) {
    return s.kind == Structure::Kind::one_bone && s.is_translucent();
  });
}

void Viewport::request_whole(std::size_t structure, const std::shared_ptr<const volume::Version>& version) {
  const Structure& s = list_[structure];
  if (s.label < 0 || s.opacity == 0 || !has_whole_structures()) return;
  if (s.kind == Structure::Kind::one_bone && !has_translucent_single_bone()) return;
  const auto known = whole_versions_.find(s.label);
  if (known != whole_versions_.end() && known->second == version->serial()) return;
  whole_versions_[s.label] = version->serial();
  surfaces_.request(s.label, version);
}

void Viewport::set_opacity(std::size_t structure, double opacity) {
  if (!is_live_ || list_[structure].opacity == opacity) return;
  list_[structure].opacity = opacity;
  apply_opacities();
}

Status Viewport::set_opacities(std::span<const StructureOpacity> opacities) {
  if (opacities.empty() || !is_live_) return {};
  if (Status error = view::set_opacities(list_, opacities)) return error;
  apply_opacities();
  return {};
}

void Viewport::apply_opacities() {
  const bool has_whole = are_structures_whole_ = has_whole_structures();
  // The bone of the window is one picture. If one bone is translucent, all labelled bones are drawn as
  // structures, so that each pixel shows them in the order of their depth.
  const bool are_bones_whole = has_translucent_single_bone();
  const double bone = list_[0].kind == Structure::Kind::all_bone ? list_[0].opacity : 1;
  std::set<std::size_t> hidden;
  std::vector<int> opened;
  for (std::size_t i = 0; i < list_.size(); ++i) {
    const Structure& s = list_[i];
    if (s.kind == Structure::Kind::objects) {
      view_.overlays().set_opacity(s.group, s.opacity);
      continue;
    }
    const bool is_bone = s.kind == Structure::Kind::one_bone;
    // A touched structure that is drawn whole is not drawn with the bone.
    const bool is_whole = s.label >= 0 && has_whole && (!is_bone || are_bones_whole);
    if (s.shape >= 0 && (s.opacity == 0 || is_whole)) hidden.insert(static_cast<std::size_t>(s.shape));
    if (s.label < 0) continue;
    if (s.shape < 0 && s.opacity > 0 && !has_whole) opened.push_back(s.label);
    if (!has_whole) continue;
    view_.structures()->set_opacity(s.label, is_whole ? s.opacity * (is_bone ? bone : 1) : 0);
    if (version_) request_whole(i, version_);
  }
  view_.bone().set_hidden(std::move(hidden));
  if (opened != opened_labels_) {
    opened_labels_ = std::move(opened);
    opened_ = std::make_unique<OpenedStructures>(*scene_, opened_labels_);
    view_.bone().remove_shape(base_shapes(*scene_).size());
    if (version_) opened_->request_all(version_);
  }
  view_.set_bone_opacity(has_whole ? std::optional<double>(bone) : std::nullopt);
  is_cap_moved_ = true;
  if (clip_plane()) request_cap();
}

}  // namespace trephine::view
