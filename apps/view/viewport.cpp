#include "apps/view/viewport.h"

#include <algorithm>
#include <array>
#include <bit>
#include <chrono>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <thread>
#include <vtkCamera.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>

#include "apps/imaging/depth_panel.h"
#include "apps/view/bone_mesh.h"
#include "apps/workbench/clock.h"
#include "haptics/walls/solid_grid.h"

namespace trephine::view {

using workbench::Clock;
using workbench::seconds_since;

using glm::dvec3;

namespace {
bool has_scenery(const haptics::TouchScene& scene) {
  return std::any_of(scene.items.begin(), scene.items.end(),
                     [](const haptics::TouchItem& item) { return item.depth && item.depth->is_streamed(); });
}

constexpr int k_threads = 2;  // for meshing, at lower priority than the drawing thread
}  // namespace

Viewport::Viewport(const haptics::TouchScene& scene, vtkRenderWindow* window, bool is_live)
    : scene_(&scene),
      window_(window),
      is_live_(is_live),
      view_(window, is_live, has_scenery(scene)),
      opened_labels_(untouchable_structures(scene)),
      list_(structures_of(scene)),
      surfaces_(*scene.base),
      cap_(scene),
      contacts_{Contact::of(*scene.tool)} {
  uncut_ = haptics::uncut_version(scene);
  worker_ = std::make_unique<ChunkWorker>(scene, k_threads);
  opened_ = std::make_unique<OpenedStructures>(scene, opened_labels_);
  // Box of the solid voxels: the camera needs it before the surface is finished.
  glm::ivec3 low = scene.base->size, high(-1);
  for (const haptics::TouchItem& shape : base_shapes(scene))
    for (int z = 0; z < scene.base->size.z; ++z)
      for (int y = 0; y < scene.base->size.y; ++y) {
        const std::uint64_t* row = shape.bits->row(y, z);
        for (int w = 0; w < shape.bits->words_per_row(); ++w) {
          if (row[w] == 0) continue;
          low = glm::min(low, glm::ivec3(64 * w + std::countr_zero(row[w]), y, z));
          high = glm::max(high, glm::ivec3(64 * w + 63 - std::countl_zero(row[w]), y, z));
        }
      }
  low_ = dvec3(1e300), high_ = dvec3(-1e300);
  for (int corner = 0; corner < 8; ++corner) {
    const dvec3 p = scene.base->frame.world_from_volume(
        dvec3(corner & 1 ? high.x : low.x, corner & 2 ? high.y : low.y, corner & 4 ? high.z : low.z));
    low_ = glm::min(low_, p), high_ = glm::max(high_, p);
  }
  visible_low_ = low_, visible_high_ = high_;
  dvec3 room_low(low_), room_high(high_);
  for (const haptics::TouchItem& item : scene.items) {
    if (!item.tree || item.tree->triangle_count() == 0) continue;
    dvec3 box_low(1e300), box_high(-1e300);
    for (const dvec3& v : item.tree->vertices()) {
      const dvec3 p = item.placement.world_from_local(v);
      box_low = glm::min(box_low, p), box_high = glm::max(box_high, p);
    }
    room_low = glm::min(room_low, box_low), room_high = glm::max(room_high, box_high);
    // Skip a large model, such as a room around the head: a view need not show all of it.
    if (glm::length(box_high - box_low) > 1.5 * glm::length(high_ - low_)) continue;
    visible_low_ = glm::min(visible_low_, box_low), visible_high_ = glm::max(visible_high_, box_high);
  }
  view_.bone().set_room(room_low, room_high);
  view_.overlays().shade_bone = [this](const dvec3& p, const dvec3& normal) -> OverlayLayer::Vertex {
    const VertexMatter matter = matter_of_detached(*scene_, p, normal);
    return {bone_colour(matter), matter.normal_world};
  };
  view_.overlays().labels().is_hidden = [this](const dvec3& at, bool is_name) {
    constexpr double k_deep = 6;           // mm; a point less deep behind the surface counts as visible
    constexpr double k_transparent = 0.5;  // opacity of bone below which it hides no names
    const bool is_transparent =
        list_[0].kind == Structure::Kind::all_bone && list_[0].opacity < k_transparent;
    if (!version_ || is_transparent) return false;
    const dvec3 from = camera().at, line = at - from;
    // Cuts do not uncover the names of a plan: below an opening there are dura and loose bone.
    const volume::Version& bone = is_name ? *uncut_ : *version_;
    const double hit = distance_to_solid(bone, {from, glm::normalize(line)});
    return hit >= 0 && hit < glm::length(line) - k_deep;
  };
}

sim::Overlays with_clip_volumes(sim::Overlays overlays, std::span<const sim::DisplayedDepths> depths) {
  overlays.emplace_back().lines = imaging::clip_volumes(depths);
  return overlays;
}

void Viewport::request_all(const std::shared_ptr<const volume::Version>& version) {
  version_ = version;
  worker_->request_all(version);
  opened_->request_all(version);
  for (std::size_t i = 0; i < list_.size(); ++i) request_whole(i, version);
  if (clip_plane()) request_cap();
}

void Viewport::request(const std::shared_ptr<const volume::Version>& version,
                       const volume::VoxelBox& changed) {
  if (changed.low.x > changed.high.x) return;
  version_ = version;
  worker_->request(version, changed.low, changed.high);
  opened_->request(version, changed);
  if (is_clipped_in(changed)) request_cap();
  if (!has_whole_structures()) return;
  for (std::size_t i = 0; i < list_.size(); ++i)
    if (list_[i].label >= 0 && surfaces_.has_voxels(list_[i].label, changed)) request_whole(i, version);
}

void Viewport::wait() {
  worker_->finish();
  opened_->finish();
  surfaces_.finish();
  cap_.finish();
  fetch_meshes();
}

void Viewport::preview(std::unique_ptr<haptics::TouchScene> shapes,
                       const std::shared_ptr<const volume::Version>& version) {
  worker_.reset();  // destroyed before the shapes that it borrows
  preview_ = std::move(shapes);
  worker_ = std::make_unique<ChunkWorker>(preview_ ? *preview_ : *scene_, k_threads);
  view_.bone().clear();
  request_all(version);
}

volume::Camera Viewport::camera() {
  view_.fit_camera();
  vtkCamera* vtk_camera = view_.renderer()->GetActiveCamera();
  volume::Camera camera;
  const int* size = window_->GetSize();
  vtk_camera->GetPosition(camera.at.x, camera.at.y, camera.at.z);
  vtk_camera->GetDirectionOfProjection(camera.forward.x, camera.forward.y, camera.forward.z);
  dvec3 up;
  vtk_camera->GetViewUp(up.x, up.y, up.z);
  camera.forward = glm::normalize(camera.forward);
  camera.up = glm::normalize(up - glm::dot(up, camera.forward) * camera.forward);
  camera.distance = vtk_camera->GetDistance();
  constexpr double k_half_degree = 3.14159265358979 / 360;
  camera.height = 2 * camera.distance * std::tan(vtk_camera->GetViewAngle() * k_half_degree);
  camera.columns = std::max(1, size[0]), camera.rows = std::max(1, size[1]);
  return camera;
}

void Viewport::turn(double left, double up) {
  vtkCamera* camera = view_.renderer()->GetActiveCamera();
  constexpr double k_radians = 3.14159265358979 / 180, k_pole = 0.5 * k_radians;
  dvec3 target, at, screen_up;
  camera->GetFocalPoint(target.x, target.y, target.z);
  camera->GetPosition(at.x, at.y, at.z);
  camera->GetViewUp(screen_up.x, screen_up.y, screen_up.z);
  const dvec3 from = at - target;
  const double distance = glm::length(from);
  // In a view along the body's axis, the position of the camera does not determine the angle around this
  // axis. The view's up vector determines the angle in its place.
  dvec3 level(from.x, from.y, 0);
  constexpr double k_flat = 0.5;  // the up vector (unit) is used if its horizontal part is longer
  if (glm::length(level) < 2 * k_pole * distance && std::hypot(screen_up.x, screen_up.y) > k_flat)
    level = (from.z > 0 ? -1.0 : 1.0) * dvec3(screen_up.x, screen_up.y, 0);
  const double around = std::atan2(level.y, level.x) - k_radians * left;
  const double polar = std::clamp(std::acos(std::clamp(from.z / distance, -1.0, 1.0)) - k_radians * up,
                                  k_pole, 3.14159265358979 - k_pole);
  at = target + distance * dvec3(std::sin(polar) * std::cos(around), std::sin(polar) * std::sin(around),
                                 std::cos(polar));
  camera->SetPosition(at.x, at.y, at.z);
  camera->SetViewUp(0, 0, 1);
  view_.renderer()->ResetCameraClippingRange();
}

void Viewport::zoom(const volume::Version& version, double factor, double x, double y) {
  constexpr double k_nearest = 20, k_farthest = 4000;  // mm
  vtkCamera* camera = view_.renderer()->GetActiveCamera();
  const Ray ray = ray_at(x, y);
  dvec3 target;
  camera->GetFocalPoint(target.x, target.y, target.z);
  // A structure in an opening counts: the distance to the bone behind it would lead into the head.
  const double hit = resting_position(version, ray).distance,
               middle = glm::dot(target - ray.origin, ray.direction);
  double current = hit >= 0 ? hit : std::max(middle, k_nearest);
  // A position in or very near bone must not prevent zooming out.
  if (factor < 1) current = std::max(current, k_nearest);
  const double next = std::clamp(current / factor, std::min(current, k_nearest), k_farthest);
  // The point under the cursor keeps its position in the picture. The focal point moves to the depth of this
  // point.
  const dvec3 position = ray.origin + (current - next) * ray.direction;
  const dvec3 forward = glm::normalize(target - ray.origin);
  const double distance = std::max(k_nearest, next * glm::dot(ray.direction, forward));
  const dvec3 at = position + distance * forward;
  camera->SetPosition(position.x, position.y, position.z);
  camera->SetFocalPoint(at.x, at.y, at.z);
  view_.renderer()->ResetCameraClippingRange();
}

Ray Viewport::ray_at(double x, double y) {
  const glm::dvec2 at = picture_position(display(), {x, y});
  view_.fit_camera();
  vtkRenderer* renderer = view_.renderer();
  const int* size = window_->GetSize();
  // The ray starts at the camera, because the near plane moves when the view turns.
  double position[3], world[4];
  renderer->GetActiveCamera()->GetPosition(position);
  renderer->SetDisplayPoint(at.x * size[0], at.y * size[1], 1);
  renderer->DisplayToWorld();
  renderer->GetWorldPoint(world);
  const dvec3 from(position[0], position[1], position[2]);
  return {from, glm::normalize(dvec3(world[0], world[1], world[2]) / world[3] - from)};
}

glm::dvec2 Viewport::project(const dvec3& at_world) {
  view_.fit_camera();
  vtkRenderer* renderer = view_.renderer();
  const int* size = window_->GetSize();
  renderer->SetWorldPoint(at_world.x, at_world.y, at_world.z, 1);
  renderer->WorldToDisplay();
  const double* at = renderer->GetDisplayPoint();
  return window_position(display(), {at[0] / std::max(size[0], 1), at[1] / std::max(size[1], 1)});
}

dvec3 Viewport::outside_point() const {
  const volume::Volume& base = *scene_->base;
  const dvec3 low = base.frame.world_from_volume(dvec3(0)),
              high = base.frame.world_from_volume(dvec3(base.size - 1));
  return 0.5 * (low + high) + dvec3(0, 0, glm::length(high - low));
}

dvec3 Viewport::normal_at(const volume::Version& version, const dvec3& p_world) const {
  int cells = 0;
  return haptics::outward_normal(scene_->items[0], version, scene_->base->frame.volume_from_world(p_world),
                                 cells);
}

dvec3 Viewport::shaft_direction(const dvec3& normal, const dvec3& toward_viewer) {
  return glm::normalize(0.7 * normal + 0.5 * toward_viewer + dvec3(0, 0, 0.25));
}

Viewport::Contact Viewport::Contact::of(const haptics::ToolShape& tool) {
  Contact contact{tool.radius(), tool.is_six_dof(), tool.mesh()};
  for (const haptics::ToolProfile::Ring& ring : tool.profile().rings)
    contact.profile.emplace_back(ring.along, ring.radius);
  return contact;
}

void Viewport::set_contact_tool(const haptics::ToolShape& tool, std::size_t hand) {
  if (contacts_.size() <= hand) contacts_.resize(hand + 1);
  contacts_[hand] = Contact::of(tool);
}

void Viewport::show_stylus(const haptics::ServoRecord& record, ToolAppearance tool,
                           const volume::Version& version, const dvec3& toward_viewer) {
  const Contact& contact = contacts_[record.hand < contacts_.size() ? record.hand : 0];
  StylusState stylus;
  stylus.hip_world = record.pose.position_world;
  stylus.hand_turn = haptics::unit_of(record.pose.orientation);
  stylus.has_contact = record.has_contact;
  stylus.proxy_world = record.has_contact ? record.proxy_world : stylus.hip_world;
  stylus.force_world = record.force_world;
  if (contact.mesh || (tool.parts.empty() && !contact.profile.empty()))
    tool = surface_appearance(contact.mesh, contact.profile);
  if (tool.is_ball)  // a ball is drawn as large as the ball that touches, and at least 0.6 mm in radius
    if (const double radius = std::max(contact.radius, 0.6); tool.radius < radius) {
      tool = ball_appearance(radius);
      tool.parts[0].is_fluted = false;
    }
  const bool is_round = contact.radius > 0 || contact.is_rigid;  // the proxy is the centre of the tool
  constexpr glm::dquat k_identity{1, 0, 0, 0};
  dvec3 shaft;
  if (tool.is_ball && !contact.is_rigid && record.pose.orientation == k_identity) {
    const dvec3 touched = is_round && record.has_contact
                              ? stylus.proxy_world - contact.radius * record.normal_world
                              : stylus.proxy_world;
    const dvec3 normal = normal_at(version, touched);
    shaft = normal != dvec3(0) ? shaft_direction(normal, toward_viewer) : toward_viewer;
    stylus.turn = glm::dquat(dvec3(0, 0, 1), shaft);
  } else {
    const dvec3 half = 0.5 * record.turn_world;
    const glm::dquat bent(std::sqrt(std::max(0.0, 1 - glm::dot(half, half))), half);
    stylus.turn = glm::normalize(bent * haptics::unit_of(record.pose.orientation));
    shaft = stylus.turn * dvec3(0, 0, 1);
  }
  stylus.tool_world = stylus.proxy_world;
  if (!is_round && tool.is_ball)
    stylus.tool_world += tool.radius * (record.has_contact ? record.normal_world : shaft);
  // As a depth cue, show a ring at the point where the tool would touch the bone.
  const Ray down{stylus.tool_world, -shaft};
  constexpr double k_near = 15;  // mm; at a greater distance the ring is not perceived as part of the tool
  if (const double landing = distance_to_solid(version, down);
      !record.has_contact && landing > 0 && landing < k_near) {
    stylus.has_ring = true;
    stylus.ring_world = down.origin + landing * down.direction;
    stylus.ring_normal_world = normal_at(version, stylus.ring_world);
  }
  stylus.tool = std::move(tool);
  if (record.hand == 0) stylus.edge = edge_;
  view_.show(stylus, record.hand);
}

void Viewport::show(std::span<const sim::Overlay> overlays, std::span<const haptics::ServoRecord> hands) {
  std::vector<haptics::Placement> placements;
  for (const haptics::ServoRecord& hand : hands) placements.push_back(haptics::placement_of(hand.pose));
  OverlayLayer* scenery = view_.scenery();
  const auto is_in_front = [&](const sim::Overlay& overlay) { return is_live_ && overlay.is_in_front; };
  const bool has_front = std::any_of(overlays.begin(), overlays.end(), is_in_front);
  if (has_front || !in_front_.empty()) {
    in_front_.clear();
    std::copy_if(overlays.begin(), overlays.end(), std::back_inserter(in_front_), is_in_front);
    show_in_front();
  }
  if (plan_.empty() && scenery == nullptr && !has_front) return view_.overlays().show(overlays, placements);
  sim::Overlays others = plan_, scenery_overlays;
  for (const sim::Overlay& overlay : overlays) {
    if (is_in_front(overlay)) continue;
    const bool is_scenery = scenery != nullptr && overlay.kind == sim::Overlay::Kind::scenery;
    (is_scenery ? scenery_overlays : others).push_back(overlay);
  }
  if (scenery != nullptr) scenery->show(scenery_overlays, placements);
  view_.overlays().show(others, placements);
}

void Viewport::set_marks(sim::Overlays marks) {
  marks_ = std::move(marks);
  show_in_front();
}

void Viewport::show_in_front() {
  sim::Overlays all = in_front_;
  all.insert(all.end(), marks_.begin(), marks_.end());
  view_.set_marks(all);
}

dvec3 Viewport::oblique_direction(const dvec3& out) {
  const dvec3 sideways = glm::cross(out, dvec3(0, 0, 1));
  return glm::normalize(out + 0.35 * (glm::length(sideways) > 0.1 ? sideways : dvec3(1, 0, 0)) +
                        dvec3(0, 0, 0.15));
}

dvec3 Viewport::upward_from(const dvec3& from) {
  return std::abs(from.z) > 0.9 ? dvec3(0, -1, 0) : dvec3(0, 0, 1);
}

void Viewport::show_still(const std::shared_ptr<const volume::Version>& version,
                          std::span<const sim::Overlay> overlays, const dvec3& at, const dvec3& from,
                          double share, double distance_factor) {
  request_all(version);
  wait();
  dvec3 low, high;
  view_.bounds(low, high);
  view_.aim_camera(glm::mix(0.5 * (low + high), at, share), from, upward_from(from),
                   distance_factor * BoneView::distance_of(low, high));
  view_.show(StylusState{.is_visible = false});
  const haptics::ServoRecord nowhere;
  show(overlays, {&nowhere, 1});
  draw();
}

void Viewport::look_at_work(const dvec3& at_world) {
  const dvec3 middle = 0.5 * (visible_low_ + visible_high_), out = at_world - middle;
  if (glm::length(out) < 1) return view_.look_from(0, visible_low_, visible_high_);
  view_.aim_camera(glm::mix(middle, at_world, 0.6), oblique_direction(glm::normalize(out)), {0, 0, 1},
                   0.75 * BoneView::distance_of(visible_low_, visible_high_));
}

void Viewport::set_plan(sim::Overlays plan) {
  plan_ = std::move(plan);
  show({}, {});
}

void Viewport::request_depth(const dvec3& at, double edge) {
  if (ScreenDepth* depth = view_.screen_depth()) depth->request(at, edge);
}

std::optional<ScreenDepth::Reading> Viewport::take_depth() {
  ScreenDepth* depth = view_.screen_depth();
  return depth != nullptr && view_.is_drawable() ? depth->take_result() : std::nullopt;
}

std::optional<double> Viewport::draw() {
  const auto begin = Clock::now();
  fetch_meshes();
  if (!view_.render()) return std::nullopt;
  return 1e3 * seconds_since(begin);
}

void Viewport::fetch_meshes() {
  // Read before take(): if the work is finished, this call of take() returns the last meshes.
  const bool is_finished = worker_->remaining() == 0;
  // The chunks wait for the reduced surfaces: without these, the first pictures would show parts of the bone.
  if (is_finished || !is_live_ || !worker_->is_reducing()) {
    for (const ChunkMesh& mesh : worker_->take()) view_.bone().show(mesh);
    if (const std::vector<ChunkMesh> reduced = worker_->take_reduced(); !is_finished && is_live_)
      view_.bone().show_reduced(reduced);
  }
  if (is_finished) view_.bone().end_reduced();
  for (const ChunkMesh& mesh : opened_->take()) view_.bone().show(mesh);
  for (const StructureSurfaces::Surface& surface : surfaces_.take()) {
    const auto row = std::find_if(list_.begin(), list_.end(),
                                  [&](const Structure& s) { return s.label == surface.label; });
    view_.structures()->show(surface.label, surface.mesh, row->colour);
  }
  if (const std::optional<CapImage> cap = cap_.take()) view_.structures()->show_cap(*cap);
}

bool Viewport::is_complete() const {
  return worker_->remaining() == 0 && opened_->is_complete() && surfaces_.is_complete() &&
         cap_.is_complete() && (view_.eyes() ? view_.eyes()->is_complete() : view_.bone().is_complete());
}

double Viewport::drawn_share() const {
  if (is_complete()) return 1;
  constexpr double k_meshing = 0.7;  // share of the work; the rest is drawing
  const double meshed = worker_->finished_share();
  return std::min(0.99, k_meshing * meshed +
                            (meshed < 1 ? 0
                                        : (1 - k_meshing) * (view_.eyes() ? view_.eyes()->drawn_share()
                                                                          : view_.bone().drawn_share())));
}

bool Viewport::is_whole() const { return worker_->finished_share() >= 1; }

bool Viewport::complete() {
  if (!view_.is_drawable()) return false;
  wait();
  // In a headset, each motion of the head begins a new picture.
  if (EyeDisplay* eyes = view_.eyes()) eyes->pause(true);
  do {
    draw();
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  } while (!is_complete());
  if (EyeDisplay* eyes = view_.eyes()) eyes->pause(false);
  return true;
}

}  // namespace trephine::view
