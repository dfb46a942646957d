#include "apps/view/bone_actors.h"

#include <algorithm>
#include <glm/common.hpp>
#include <glm/vector_relational.hpp>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkRenderer.h>

#include "apps/view/bone_mesh.h"

namespace trephine::view {

using glm::dvec3;

namespace {

constexpr int k_group = 4;  // chunks along the edge of a coarse group

vtkPolyDataMapper* mapper_of(vtkActor* actor) { return static_cast<vtkPolyDataMapper*>(actor->GetMapper()); }

BoneActors::Box box_of(const std::vector<glm::vec3>& vertices) {
  BoneActors::Box box;
  for (const glm::vec3& v : vertices)
    box.low = glm::min(box.low, dvec3(v)), box.high = glm::max(box.high, dvec3(v));
  return box;
}

BoneActors::Box united(const BoneActors::Box& a, const BoneActors::Box& b) {
  return {glm::min(a.low, b.low), glm::max(a.high, b.high)};
}

}  // namespace

bool BoneActors::Box::is_empty() const { return !glm::all(glm::lessThan(low, high)); }

vtkSmartPointer<vtkActor> BoneActors::add_actor(std::size_t shape) const {
  auto actor = vtkSmartPointer<vtkActor>::New();
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->ScalarVisibilityOn();
  if (is_clipped_) mapper->AddClippingPlane(clip_);
  actor->SetMapper(mapper);
  actor->GetProperty()->SetSpecular(shape == 0 ? 0.16 : 0.25);
  actor->GetProperty()->SetSpecularPower(22);
  actor->GetProperty()->SetAmbient(0.10);
  light_reversed_triangles(actor);
  actor->PickableOff();
  renderer_->AddActor(actor);
  return actor;
}

BoneActors::Change BoneActors::show(const ChunkMesh& mesh) {
  const Key key{mesh.chunk.x, mesh.chunk.y, mesh.chunk.z, static_cast<int>(mesh.shape)};
  const auto known = chunks_.find(key);
  tints_[mesh.shape] = tint_of(mesh.shape, mesh.colour);
  if (mesh.fine.triangles.empty() && known == chunks_.end()) return {};
  Key group_key = key;
  for (std::size_t a = 0; a < 3; ++a) group_key[a] /= k_group;
  groups_[group_key].is_stale = true;

  Change change;
  Chunk& chunk = chunks_[key];
  triangles_ -= chunk.triangles;
  const bool is_known = chunk.actor != nullptr;
  const auto changed_part = [&](const Box& box) {
    return Box{glm::max(box.low, mesh.changed_low), glm::min(box.high, mesh.changed_high)};
  };
  if (is_known) change.boxes[0] = changed_part(chunk.box);
  if (mesh.fine.triangles.empty()) {
    renderer_->RemoveActor(chunk.actor);
    chunks_.erase(key);
    return change;
  }
  chunk.box = box_of(mesh.fine.vertices);
  chunk.triangles = mesh.fine.triangles.size() / 3;
  triangles_ += chunk.triangles;
  if (has_coarse_) chunk.coarse = mesh.coarse;
  change.boxes[1] = is_known ? changed_part(chunk.box) : chunk.box;
  change.chunk = key;
  if (!chunk.actor) {
    chunk.actor = add_actor(mesh.shape);
    // A chunk that became empty earlier is still in its group.
    std::vector<Key>& chunks = groups_[group_key].chunks;
    if (std::find(chunks.begin(), chunks.end(), key) == chunks.end()) chunks.push_back(key);
  }
  mapper_of(chunk.actor)->SetInputData(to_poly_data({&mesh.fine}, tints_.at(mesh.shape)));
  return change;
}

void BoneActors::add_reduced(const ChunkMesh& mesh) {
  reduced_box_ = united(reduced_box_, box_of(mesh.coarse.vertices));
  reduced_.push_back({mesh.shape, add_actor(mesh.shape), mesh.coarse.triangles.size() / 3});
  mapper_of(reduced_.back().actor)
      ->SetInputData(to_poly_data({&mesh.coarse}, tint_of(mesh.shape, mesh.colour)));
}

bool BoneActors::remove_reduced() {
  if (reduced_.empty()) return false;
  for (const Reduced& reduced : reduced_) renderer_->RemoveActor(reduced.actor);
  reduced_.clear();
  reduced_box_ = {};
  return true;
}

void BoneActors::clear() {
  remove_reduced();
  for (const auto& [key, chunk] : chunks_) renderer_->RemoveActor(chunk.actor);
  for (const auto& [key, group] : groups_)
    if (group.actor) renderer_->RemoveActor(group.actor);
  chunks_.clear();
  groups_.clear();
  triangles_ = 0;
}

bool BoneActors::remove_shape(std::size_t shape) {
  const auto is_of_shape = [&](const auto& entry) { return entry.first[3] == static_cast<int>(shape); };
  for (const auto& entry : chunks_) {
    if (!is_of_shape(entry)) continue;
    renderer_->RemoveActor(entry.second.actor);
    triangles_ -= entry.second.triangles;
  }
  for (const auto& entry : groups_)
    if (is_of_shape(entry) && entry.second.actor) renderer_->RemoveActor(entry.second.actor);
  std::erase_if(groups_, is_of_shape);
  return std::erase_if(chunks_, is_of_shape) > 0;
}

bool BoneActors::set_hidden(std::set<std::size_t> shapes) {
  if (shapes == hidden_) return false;
  hidden_ = std::move(shapes);
  return true;
}

void BoneActors::set_clip(const dvec3& origin, const dvec3& normal) {
  const bool is_clipped = normal != dvec3(0);
  if (is_clipped) {
    clip_->SetOrigin(origin.x, origin.y, origin.z);
    clip_->SetNormal(normal.x, normal.y, normal.z);
  }
  if (std::exchange(is_clipped_, is_clipped) == is_clipped) return;
  const auto apply = [&](vtkActor* actor) {
    if (actor == nullptr) return;
    mapper_of(actor)->RemoveAllClippingPlanes();
    if (is_clipped) mapper_of(actor)->AddClippingPlane(clip_);
  };
  for (const auto& [key, chunk] : chunks_) apply(chunk.actor);
  for (const auto& [key, group] : groups_) apply(group.actor);
  for (const Reduced& reduced : reduced_) apply(reduced.actor);
}

void BoneActors::refresh_groups() {
  for (auto& [key, group] : groups_) {
    if (!group.is_stale) continue;
    group.is_stale = false;
    group.triangles = 0;
    std::vector<const DrawMesh*> meshes;
    for (const Key& k : group.chunks)
      if (const auto it = chunks_.find(k); it != chunks_.end()) {
        meshes.push_back(&it->second.coarse);
        group.triangles += it->second.coarse.triangles.size() / 3;
      }
    const auto shape = static_cast<std::size_t>(key[3]);
    if (!group.actor) group.actor = add_actor(shape);
    mapper_of(group.actor)->SetInputData(to_poly_data(meshes, tints_.at(shape)));
  }
}

void BoneActors::draw_nothing() {
  for (const auto& [key, chunk] : chunks_) chunk.actor->VisibilityOff();
  for (const auto& [key, group] : groups_)
    if (group.actor) group.actor->VisibilityOff();
  for (const Reduced& reduced : reduced_) reduced.actor->VisibilityOff();
}

std::size_t BoneActors::draw_chunk(const Key& chunk) {
  const auto it = chunks_.find(chunk);
  if (it == chunks_.end() || !is_shown(chunk)) return 0;
  it->second.actor->VisibilityOn();
  return it->second.triangles;
}

std::size_t BoneActors::draw_where(const std::function<bool(const Box&)>& is_drawn) {
  draw_nothing();
  std::size_t triangles = 0;
  for (const auto& [key, chunk] : chunks_)
    if (is_drawn(chunk.box)) triangles += draw_chunk(key);
  return triangles;
}

std::size_t BoneActors::draw_all() {
  return draw_where([](const Box&) { return true; });
}

std::size_t BoneActors::draw_coarse() {
  refresh_groups();
  draw_nothing();
  std::size_t triangles = 0;
  for (const auto& [key, group] : groups_)
    if (is_shown(key)) group.actor->VisibilityOn(), triangles += group.triangles;
  return triangles;
}

std::size_t BoneActors::draw_reduced() {
  draw_nothing();
  std::size_t triangles = 0;
  for (const Reduced& reduced : reduced_) {
    reduced.actor->SetVisibility(is_shown(reduced.shape));
    if (is_shown(reduced.shape)) triangles += reduced.triangles;
  }
  return triangles;
}

std::vector<BoneActors::Key> BoneActors::chunks() const {
  std::vector<Key> keys;
  keys.reserve(chunks_.size());
  for (const auto& [key, chunk] : chunks_) keys.push_back(key);
  return keys;
}

std::size_t BoneActors::coarse_triangle_count() const {
  std::size_t count = 0;
  for (const auto& [key, chunk] : chunks_) count += chunk.coarse.triangles.size() / 3;
  return count;
}

BoneActors::Box BoneActors::bounds() const {
  Box box = reduced_box_;
  for (const auto& [key, chunk] : chunks_) box = united(box, chunk.box);
  return box;
}

}  // namespace trephine::view
