// BoneLayer: draws bone in batches and shows a kept picture in between.
// One file, because the kept picture, its depth and the drawing into it share one set of buffers.
#include "apps/view/bone_layer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/vector_relational.hpp>
#include <map>
#include <vector>
#include <vtkActor.h>
#include <vtkCallbackCommand.h>
#include <vtkCamera.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>
#include <vtkPlane.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkRect.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>
#include <vtk_glew.h>

#include "apps/view/bone_mesh.h"
#include "apps/view/picture_cache.h"
#include "apps/view/render_window.h"
#include "apps/workbench/clock.h"

namespace trephine::view {

using workbench::Clock;
using workbench::seconds_since;

using glm::dvec3;

namespace {

constexpr int k_group = 4;               // chunks along the edge of a coarse group
constexpr double k_rest_seconds = 0.12;  // rest of the view before drawing at full detail starts
constexpr double k_batch_ms = 30;        // share of a frame for drawing at full detail

vtkPolyDataMapper* mapper_of(vtkActor* actor) { return static_cast<vtkPolyDataMapper*>(actor->GetMapper()); }

}  // namespace

class BoneLayer::Painter {
 public:
  Painter(vtkRenderWindow* window, vtkRenderer* bone, vtkRenderer* tools, bool is_live);
  ~Painter();
  Painter(const Painter&) = delete;
  Painter& operator=(const Painter&) = delete;

  void show(const ChunkMesh& mesh);
  void show_reduced(const std::vector<ChunkMesh>& meshes);
  void end_reduced();
  void clear();
  void remove_shape(std::size_t shape);
  void set_hidden(std::set<std::size_t> shapes);
  void set_opacity(double opacity, std::function<void()> restore_behind);
  void blend();
  void set_clip(const dvec3& origin, const dvec3& normal);
  void set_room(const dvec3& low, const dvec3& high) { room_low_ = low, room_high_ = high; }
  bool render(bool always);
  void expose();
  bool is_complete() const noexcept { return is_fine_ && !has_moved(); }
  double drawn_share() const noexcept {
    if (is_complete()) return 1;
    if (has_moved()) return 0;
    if (chunks_.empty()) return 1;
    return 1 - std::min(1.0, static_cast<double>(to_draw_.size()) / static_cast<double>(chunks_.size()));
  }
  std::size_t triangle_count() const noexcept { return triangles_; }
  std::size_t coarse_triangle_count() const;
  void bounds(dvec3& low, dvec3& high) const;
  std::size_t drawn_triangles() const noexcept { return drawn_triangles_; }
  std::uint64_t revision() const noexcept { return revision_; }

 private:
  using Key = std::array<int, 4>;  // chunk and shape
  struct Chunk {
    vtkSmartPointer<vtkActor> actor;
    dvec3 low{0.0}, high{0.0};
    std::size_t triangles = 0;
    DrawMesh coarse;
  };
  struct Group {  // coarse chunks with one actor
    vtkSmartPointer<vtkActor> actor;
    std::vector<Key> chunks;
    std::size_t triangles = 0;
    bool is_stale = true;
  };
  struct Rectangle {
    double low_x = 1e9, low_y = 1e9, high_x = -1e9, high_y = -1e9;
    bool is_empty() const { return low_x > high_x; }
    double area() const { return (high_x - low_x) * (high_y - low_y); }
    void add(const Rectangle& other);
    bool meets(const Rectangle& other) const;
  };
  enum class Pass { nothing, everything, coarse, batch, rectangle };

  vtkSmartPointer<vtkActor> make_actor(std::size_t shape) const;
  bool is_shown(const Key& key) const { return hidden_.count(static_cast<std::size_t>(key[3])) == 0; }
  /// True if the bone is blended over what is behind it.
  bool is_blended() const { return restore_behind_ && can_keep_ && kept_.is_filled(); }
  Rectangle on_screen(const dvec3& low, const dvec3& high) const;
  void refresh_groups();
  void fit_clipping_range();
  /// Camera of the view, without the clipping range.
  std::array<double, 16> view() const;
  /// Returns true if the window has another size or camera than the kept picture.
  bool has_moved() const;
  /// Begins the picture of a new view: at full detail if that is quick, otherwise coarse.
  void prepare_view();
  void draw_all_once();
  void prepare_reduced();
  void prepare_coarse();
  void prepare_batch();
  void prepare_rectangle();
  void on_start();
  void on_end();
  void begin_redraw();
  void end_redraw();

  vtkRenderWindow* window_;
  vtkRenderer* bone_;
  bool is_live_;
  std::map<Key, Chunk> chunks_;
  std::map<Key, Group> groups_;
  std::map<std::size_t, Tint> tints_;                                       // of shapes
  std::vector<std::pair<std::size_t, vtkSmartPointer<vtkActor>>> reduced_;  ///< with their shapes
  std::set<std::size_t> hidden_;                                            ///< shapes
  double opacity_ = 1;
  std::function<void()> restore_behind_;
  dvec3 reduced_low_{1e300}, reduced_high_{-1e300};
  std::size_t reduced_triangles_ = 0;
  vtkNew<vtkPlane> clip_;
  bool is_clipped_ = false;
  std::size_t triangles_ = 0, drawn_triangles_ = 0;
  std::uint64_t revision_ = 0;

  // The kept picture, and the picture that is being drawn at full detail.
  PictureCache kept_, pending_;
  Pass pass_ = Pass::everything;
  bool can_keep_ = true, is_fine_ = false, is_first_batch_ = true, is_last_batch_ = false;
  bool is_redraw_ = false;  ///< the window system redraws a new view, outside render()
  std::array<unsigned long, 2> redraw_observers_{};  ///< of the window
  std::vector<Key> to_draw_;                         ///< chunks that are missing in the pending picture
  Rectangle changed_;                                ///< outdated part of the kept picture
  dvec3 room_low_{1e300}, room_high_{-1e300};        ///< box of the objects on top
  dvec3 fitted_low_{1e300}, fitted_high_{-1e300};    ///< box that the camera's clipping range includes
  std::array<double, 2> fitted_range_{};             ///< that clipping range
  std::array<double, 16> kept_view_{};
  std::array<int, 2> kept_size_{};
  Clock::time_point moved_at_;
  vtkMTimeType drawn_top_time_ = 0;  ///< newest_change() of the other renderers at the last frame
  double triangles_per_ms_ = 3000;   ///< measured
};

void BoneLayer::Painter::Rectangle::add(const Rectangle& other) {
  low_x = std::min(low_x, other.low_x), low_y = std::min(low_y, other.low_y);
  high_x = std::max(high_x, other.high_x), high_y = std::max(high_y, other.high_y);
}

bool BoneLayer::Painter::Rectangle::meets(const Rectangle& other) const {
  return low_x <= other.high_x && other.low_x <= high_x && low_y <= other.high_y && other.low_y <= high_y;
}

BoneLayer::Painter::Painter(vtkRenderWindow* window, vtkRenderer* bone, vtkRenderer* tools, bool is_live)
    : window_(window), bone_(bone), is_live_(is_live) {
  if (!is_live) return;
  vtkNew<vtkCallbackCommand> start, end;
  start->SetClientData(this);
  start->SetCallback(
      [](vtkObject*, unsigned long, void* self, void*) { static_cast<Painter*>(self)->on_start(); });
  end->SetClientData(this);
  end->SetCallback(
      [](vtkObject*, unsigned long, void* self, void*) { static_cast<Painter*>(self)->on_end(); });
  bone->AddObserver(vtkCommand::StartEvent, start);
  bone->AddObserver(vtkCommand::EndEvent, end);
  // Tools are drawn on top of the bone into the same depth buffer, without clearing.
  tools->PreserveColorBufferOn();
  tools->PreserveDepthBufferOn();
  vtkNew<vtkCallbackCommand> before_tools;
  before_tools->SetClientData(this);
  before_tools->SetCallback([](vtkObject*, unsigned long, void* self, void*) {
    auto* layer = static_cast<Painter*>(self);
    if (layer->is_blended())
      layer->restore_behind_();
    else if (layer->pass_ == Pass::nothing || layer->pass_ == Pass::batch)
      layer->kept_.restore();
  });
  tools->AddObserver(vtkCommand::StartEvent, before_tools);
  // The window system redraws on its own after a resize: the kept picture may then have another size.
  vtkNew<vtkCallbackCommand> begin, finish;
  begin->SetClientData(this);
  begin->SetCallback(
      [](vtkObject*, unsigned long, void* self, void*) { static_cast<Painter*>(self)->begin_redraw(); });
  finish->SetClientData(this);
  finish->SetCallback(
      [](vtkObject*, unsigned long, void* self, void*) { static_cast<Painter*>(self)->end_redraw(); });
  redraw_observers_ = {window->AddObserver(vtkCommand::StartEvent, begin),
                       window->AddObserver(vtkCommand::EndEvent, finish)};
}

BoneLayer::Painter::~Painter() {
  if (!is_live_) return;
  for (const unsigned long observer : redraw_observers_) window_->RemoveObserver(observer);
  window_->MakeCurrent();
  if (window_->IsCurrent()) kept_.release(), pending_.release();
}

vtkSmartPointer<vtkActor> BoneLayer::Painter::make_actor(std::size_t shape) const {
  auto actor = vtkSmartPointer<vtkActor>::New();
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->ScalarVisibilityOn();
  if (is_clipped_) mapper->AddClippingPlane(clip_);
  actor->SetMapper(mapper);
  actor->GetProperty()->SetSpecular(shape == 0 ? 0.16 : 0.25);
  actor->GetProperty()->SetSpecularPower(22);
  actor->GetProperty()->SetAmbient(0.10);
  actor->PickableOff();
  return actor;
}

void BoneLayer::Painter::show(const ChunkMesh& mesh) {
  const Key key{mesh.chunk.x, mesh.chunk.y, mesh.chunk.z, static_cast<int>(mesh.shape)};
  const auto known = chunks_.find(key);
  tints_[mesh.shape] = tint_of(mesh.shape, mesh.colour);
  if (mesh.fine.triangles.empty() && known == chunks_.end()) return;
  Key group_key = key;
  for (std::size_t a = 0; a < 3; ++a) group_key[a] /= k_group;
  groups_[group_key].is_stale = true;

  // Mark both the old and the new extent of the chunk as changed.
  Chunk& chunk = chunks_[key];
  triangles_ -= chunk.triangles;
  const bool is_known = chunk.actor != nullptr;
  const dvec3 old_low = glm::max(chunk.low, mesh.changed_low),
              old_high = glm::min(chunk.high, mesh.changed_high);
  if (is_known && glm::all(glm::lessThan(old_low, old_high))) changed_.add(on_screen(old_low, old_high));
  if (mesh.fine.triangles.empty()) {
    bone_->RemoveActor(chunk.actor);
    chunks_.erase(key);
    return;
  }
  chunk.low = dvec3(1e300), chunk.high = dvec3(-1e300);
  for (const glm::vec3& v : mesh.fine.vertices)
    chunk.low = glm::min(chunk.low, dvec3(v)), chunk.high = glm::max(chunk.high, dvec3(v));
  chunk.triangles = mesh.fine.triangles.size() / 3;
  triangles_ += chunk.triangles;
  if (is_live_) {
    chunk.coarse = mesh.coarse;
    const dvec3 low = is_known ? glm::max(chunk.low, mesh.changed_low) : chunk.low;
    const dvec3 high = is_known ? glm::min(chunk.high, mesh.changed_high) : chunk.high;
    if (glm::all(glm::lessThan(low, high))) changed_.add(on_screen(low, high));
    if (!is_fine_) to_draw_.push_back(key);
  }
  if (!chunk.actor) {
    chunk.actor = make_actor(mesh.shape);
    bone_->AddActor(chunk.actor);
    groups_[group_key].chunks.push_back(key);
  }
  mapper_of(chunk.actor)->SetInputData(to_poly_data({&mesh.fine}, tints_.at(mesh.shape)));
}

void BoneLayer::Painter::show_reduced(const std::vector<ChunkMesh>& meshes) {
  for (const ChunkMesh& mesh : meshes) {
    if (mesh.coarse.triangles.empty()) continue;
    for (const glm::vec3& v : mesh.coarse.vertices)
      reduced_low_ = glm::min(reduced_low_, dvec3(v)), reduced_high_ = glm::max(reduced_high_, dvec3(v));
    reduced_triangles_ += mesh.coarse.triangles.size() / 3;
    vtkActor* actor = reduced_.emplace_back(mesh.shape, make_actor(mesh.shape)).second;
    mapper_of(actor)->SetInputData(to_poly_data({&mesh.coarse}, tint_of(mesh.shape, mesh.colour)));
    bone_->AddActor(actor);
    kept_view_ = {};  // forces a new picture
  }
}

void BoneLayer::Painter::end_reduced() {
  if (reduced_.empty()) return;
  for (const auto& [shape, actor] : reduced_) bone_->RemoveActor(actor);
  reduced_.clear();
  reduced_low_ = dvec3(1e300), reduced_high_ = dvec3(-1e300);
  reduced_triangles_ = 0;
  kept_view_ = {};
}

void BoneLayer::Painter::clear() {
  end_reduced();
  for (const auto& [key, chunk] : chunks_) bone_->RemoveActor(chunk.actor);
  for (const auto& [key, group] : groups_)
    if (group.actor) bone_->RemoveActor(group.actor);
  chunks_.clear();
  groups_.clear();
  to_draw_.clear();
  triangles_ = 0;
  kept_view_ = {};
  ++revision_;
}

void BoneLayer::Painter::remove_shape(std::size_t shape) {
  const auto is_of_shape = [&](const auto& entry) { return entry.first[3] == static_cast<int>(shape); };
  for (const auto& entry : chunks_) {
    if (!is_of_shape(entry)) continue;
    bone_->RemoveActor(entry.second.actor);
    triangles_ -= entry.second.triangles;
  }
  for (const auto& entry : groups_)
    if (is_of_shape(entry) && entry.second.actor) bone_->RemoveActor(entry.second.actor);
  const std::size_t removed = std::erase_if(chunks_, is_of_shape);
  std::erase_if(groups_, is_of_shape);
  if (removed == 0) return;
  kept_view_ = {};
  ++revision_;
}

void BoneLayer::Painter::set_hidden(std::set<std::size_t> shapes) {
  if (shapes == hidden_) return;
  hidden_ = std::move(shapes);
  kept_view_ = {};
  ++revision_;
}

void BoneLayer::Painter::set_opacity(double opacity, std::function<void()> restore_behind) {
  opacity_ = opacity;
  restore_behind_ = std::move(restore_behind);
  kept_view_ = {};
  ++revision_;
}

void BoneLayer::Painter::blend() {
  if (is_blended()) kept_.blend(window_, opacity_);
}

void BoneLayer::Painter::set_clip(const dvec3& origin, const dvec3& normal) {
  const bool is_clipped = normal != dvec3(0);
  if (is_clipped) {
    clip_->SetOrigin(origin.x, origin.y, origin.z);
    clip_->SetNormal(normal.x, normal.y, normal.z);
  }
  if (is_clipped != is_clipped_) {
    is_clipped_ = is_clipped;
    const auto apply = [&](vtkActor* actor) {
      if (actor == nullptr) return;
      mapper_of(actor)->RemoveAllClippingPlanes();
      if (is_clipped) mapper_of(actor)->AddClippingPlane(clip_);
    };
    for (const auto& [key, chunk] : chunks_) apply(chunk.actor);
    for (const auto& [key, group] : groups_) apply(group.actor);
    for (const auto& [shape, actor] : reduced_) apply(actor);
  }
  kept_view_ = {};  // forces a new picture
  ++revision_;
}

std::size_t BoneLayer::Painter::coarse_triangle_count() const {
  std::size_t count = 0;
  for (const auto& [key, chunk] : chunks_) count += chunk.coarse.triangles.size() / 3;
  return count;
}

void BoneLayer::Painter::bounds(dvec3& low, dvec3& high) const {
  low = dvec3(1e300), high = dvec3(-1e300);
  for (const auto& [key, chunk] : chunks_) low = glm::min(low, chunk.low), high = glm::max(high, chunk.high);
  low = glm::min(low, reduced_low_), high = glm::max(high, reduced_high_);
}

BoneLayer::Painter::Rectangle BoneLayer::Painter::on_screen(const dvec3& low, const dvec3& high) const {
  Rectangle r;
  const int* size = window_->GetSize();
  if (size[0] <= 0 || size[1] <= 0) return r;
  vtkMatrix4x4* m = bone_->GetActiveCamera()->GetCompositeProjectionTransformMatrix(
      static_cast<double>(size[0]) / size[1], -1, 1);
  for (int corner = 0; corner < 8; ++corner) {
    const double p[4] = {corner & 1 ? high.x : low.x, corner & 2 ? high.y : low.y,
                         corner & 4 ? high.z : low.z, 1};
    double q[4];
    m->MultiplyPoint(p, q);
    if (q[3] <= 0) return {0, 0, static_cast<double>(size[0]), static_cast<double>(size[1])};
    const double x = 0.5 * (q[0] / q[3] + 1) * size[0], y = 0.5 * (q[1] / q[3] + 1) * size[1];
    r.low_x = std::min(r.low_x, x - 2), r.high_x = std::max(r.high_x, x + 2);
    r.low_y = std::min(r.low_y, y - 2), r.high_y = std::max(r.high_y, y + 2);
  }
  r.low_x = std::max(r.low_x, 0.0), r.low_y = std::max(r.low_y, 0.0);
  r.high_x = std::min<double>(r.high_x, size[0]), r.high_y = std::min<double>(r.high_y, size[1]);
  return r.low_x < r.high_x && r.low_y < r.high_y ? r : Rectangle{};
}

void BoneLayer::Painter::refresh_groups() {
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
    if (!group.actor) {
      group.actor = make_actor(static_cast<std::size_t>(key[3]));
      bone_->AddActor(group.actor);
    }
    mapper_of(group.actor)->SetInputData(to_poly_data(meshes, tints_.at(static_cast<std::size_t>(key[3]))));
  }
}

void BoneLayer::Painter::draw_all_once() {
  pass_ = Pass::everything;
  for (const auto& [key, chunk] : chunks_) chunk.actor->SetVisibility(is_shown(key));
  for (const auto& [key, group] : groups_)
    if (group.actor) group.actor->VisibilityOff();
  for (const auto& [shape, actor] : reduced_) actor->VisibilityOff();
  drawn_triangles_ = triangles_;
  bone_->DrawOn();
  bone_->PreserveColorBufferOff();
  bone_->PreserveDepthBufferOff();
}

void BoneLayer::Painter::prepare_reduced() {
  draw_all_once();
  pass_ = Pass::coarse;
  for (const auto& [key, chunk] : chunks_) chunk.actor->VisibilityOff();
  for (const auto& [shape, actor] : reduced_) actor->SetVisibility(hidden_.count(shape) == 0);
  drawn_triangles_ = reduced_triangles_;
}

void BoneLayer::Painter::prepare_coarse() {
  draw_all_once();
  pass_ = Pass::coarse;
  refresh_groups();
  drawn_triangles_ = 0;
  for (const auto& [key, chunk] : chunks_) chunk.actor->VisibilityOff();
  for (const auto& [key, group] : groups_)
    group.actor->SetVisibility(is_shown(key)), drawn_triangles_ += group.triangles;
}

void BoneLayer::Painter::prepare_batch() {
  draw_all_once();
  pass_ = Pass::batch;
  for (const auto& [key, chunk] : chunks_) chunk.actor->VisibilityOff();
  const double max_triangles = std::max(60000.0, triangles_per_ms_ * k_batch_ms);
  drawn_triangles_ = 0;
  while (!to_draw_.empty() && static_cast<double>(drawn_triangles_) < max_triangles) {
    if (const auto it = chunks_.find(to_draw_.back()); it != chunks_.end() && is_shown(it->first)) {
      it->second.actor->VisibilityOn();
      drawn_triangles_ += it->second.triangles;
    }
    to_draw_.pop_back();
  }
  is_last_batch_ = to_draw_.empty();
  if (!is_first_batch_) {
    bone_->PreserveColorBufferOn();
    bone_->PreserveDepthBufferOn();
  }
}

void BoneLayer::Painter::prepare_rectangle() {
  draw_all_once();
  pass_ = Pass::rectangle;
  drawn_triangles_ = 0;
  for (const auto& [key, chunk] : chunks_) {
    const bool is_affected = is_shown(key) && on_screen(chunk.low, chunk.high).meets(changed_);
    chunk.actor->SetVisibility(is_affected);
    if (is_affected) drawn_triangles_ += chunk.triangles;
  }
  const int x = static_cast<int>(changed_.low_x), y = static_cast<int>(changed_.low_y);
  bone_->GetActiveCamera()->SetScissorRect(vtkRecti(x, y, static_cast<int>(std::ceil(changed_.high_x)) - x,
                                                    static_cast<int>(std::ceil(changed_.high_y)) - y));
  bone_->GetActiveCamera()->SetUseScissor(true);
}

/// Sets the camera's clipping range by the whole bone, even if only a part is drawn, with room for the
/// instruments.
void BoneLayer::Painter::fit_clipping_range() {
  constexpr double k_room_mm = 150;
  dvec3 low, high;
  bounds(low, high);
  if (low.x > high.x) return;
  fitted_low_ = low, fitted_high_ = high;
  low = glm::min(low, room_low_), high = glm::max(high, room_high_);
  const double box[6] = {low.x - k_room_mm,  high.x + k_room_mm, low.y - k_room_mm,
                         high.y + k_room_mm, low.z - k_room_mm,  high.z + k_room_mm};
  bone_->ResetCameraClippingRange(box);
  bone_->GetActiveCamera()->GetClippingRange(fitted_range_.data());
}

void BoneLayer::Painter::expose() {
  draw_all_once();
  fit_clipping_range();
  is_fine_ = true;
  changed_ = {};
  to_draw_.clear();
}

void BoneLayer::Painter::on_start() {
  if (pass_ == Pass::rectangle) kept_.restore();
  if (pass_ == Pass::batch && !is_first_batch_) pending_.restore();
}

void BoneLayer::Painter::on_end() {
  bone_->GetActiveCamera()->SetUseScissor(false);  // the instruments share the camera
  const int* size = window_->GetSize();
  if (pass_ == Pass::batch)
    can_keep_ = pending_.save(size[0], size[1]);
  else if (pass_ != Pass::nothing)
    can_keep_ = kept_.save(size[0], size[1]);
}

std::array<double, 16> BoneLayer::Painter::view() const {
  vtkCamera* camera = bone_->GetActiveCamera();
  std::array<double, 16> values;
  std::copy_n(camera->GetModelViewTransformMatrix()->GetData(), 16, values.begin());
  values[15] = camera->GetViewAngle();
  return values;
}

bool BoneLayer::Painter::has_moved() const {
  const int* size = window_->GetSize();
  return size[0] != kept_size_[0] || size[1] != kept_size_[1] || view() != kept_view_;
}

void BoneLayer::Painter::prepare_view() {
  const int* size = window_->GetSize();
  kept_view_ = view();
  kept_size_ = {size[0], size[1]};
  moved_at_ = Clock::now();
  fit_clipping_range();
  changed_ = {};
  to_draw_.clear();
  for (const auto& [key, chunk] : chunks_) to_draw_.push_back(key);
  is_first_batch_ = true;
  is_fine_ =
      reduced_.empty() && (static_cast<double>(triangles_) < triangles_per_ms_ * k_batch_ms || !can_keep_);
  if (!reduced_.empty()) {
    prepare_reduced();
  } else if (is_fine_) {
    draw_all_once();
    to_draw_.clear();
  } else {
    prepare_coarse();
  }
}

/// Replaces a kept picture of another view before the window system shows it.
void BoneLayer::Painter::begin_redraw() {
  if (pass_ != Pass::nothing || !has_moved()) return;
  prepare_view();
  bone_->GetActiveCamera()->SetClippingRange(fitted_range_.data());
  ++revision_;
  is_redraw_ = true;
}

void BoneLayer::Painter::end_redraw() {
  if (!std::exchange(is_redraw_, false)) return;
  pass_ = Pass::nothing;
  if (can_keep_) bone_->DrawOff();
}

bool BoneLayer::Painter::render(bool always) {
  if (!is_live_) {
    draw_all_once();
    fit_clipping_range();
    window_->Render();
    return true;
  }
  vtkCamera* camera = bone_->GetActiveCamera();
  const int* size = window_->GetSize();
  // Chunks that arrive while a scan is opened may be outside the camera's clipping range.
  dvec3 low, high;
  bounds(low, high);
  if (glm::any(glm::lessThan(low, fitted_low_)) || glm::any(glm::greaterThan(high, fitted_high_)))
    kept_.forget();
  const double broad = 0.35 * size[0] * size[1];
  if (has_moved() || !can_keep_ || !kept_.is_filled() ||
      (reduced_.empty() && !changed_.is_empty() && changed_.area() > broad)) {
    prepare_view();
  } else if (reduced_.empty() && !is_fine_ && seconds_since(moved_at_) > k_rest_seconds) {
    prepare_batch();
  } else if (is_fine_ && !changed_.is_empty()) {
    prepare_rectangle();
  } else {
    pass_ = Pass::nothing;
    drawn_triangles_ = 0;
    bone_->DrawOff();
  }
  // VTK fits the clipping range to the visible actors, which are only those drawn in this frame: restore it.
  camera->SetClippingRange(fitted_range_.data());
  if (!always && pass_ == Pass::nothing && is_fine_ && newest_change(window_, bone_) == drawn_top_time_)
    return false;
  revision_ += pass_ != Pass::nothing;
  const bool was_changed = !changed_.is_empty();
  if (pass_ == Pass::rectangle) changed_ = {};
  const auto begin = Clock::now();
  window_->Render();

  // Estimates the speed of this machine's drawing, from frames with enough to measure.
  if (drawn_triangles_ > 15000) {
    glFinish();
    const double ms = 1e3 * seconds_since(begin);
    triangles_per_ms_ =
        0.8 * triangles_per_ms_ + 0.2 * static_cast<double>(drawn_triangles_) / std::max(ms, 0.1);
  }
  // If the window system redraws on its own, show the kept picture.
  const bool was_batch = std::exchange(pass_, Pass::nothing) == Pass::batch;
  if (can_keep_) bone_->DrawOff();
  if (was_batch) {
    is_first_batch_ = false;
    if (is_last_batch_ && can_keep_) {
      kept_.swap(pending_);
      is_fine_ = true;
      // Chunks that changed during drawing were drawn too, but perhaps on top of their old state.
      if (!was_changed) changed_ = {};
      // The batches were drawn behind the previous picture: show the finished one.
      camera->SetClippingRange(fitted_range_.data());
      window_->Render();
    }
  }
  drawn_top_time_ = newest_change(window_, bone_);
  return true;
}

BoneLayer::BoneLayer(vtkRenderWindow* window, vtkRenderer* bone, vtkRenderer* tools, bool is_live)
    : painter_(std::make_unique<Painter>(window, bone, tools, is_live)) {}
BoneLayer::~BoneLayer() = default;
void BoneLayer::show(const ChunkMesh& mesh) { painter_->show(mesh); }
void BoneLayer::show_reduced(const std::vector<ChunkMesh>& meshes) { painter_->show_reduced(meshes); }
void BoneLayer::end_reduced() { painter_->end_reduced(); }
void BoneLayer::clear() { painter_->clear(); }
void BoneLayer::remove_shape(std::size_t shape) { painter_->remove_shape(shape); }
void BoneLayer::set_hidden(std::set<std::size_t> shapes) { painter_->set_hidden(std::move(shapes)); }
void BoneLayer::set_opacity(double opacity, std::function<void()> restore_behind) {
  painter_->set_opacity(opacity, std::move(restore_behind));
}
void BoneLayer::blend() { painter_->blend(); }
void BoneLayer::set_clip(const dvec3& origin, const dvec3& normal) { painter_->set_clip(origin, normal); }
void BoneLayer::set_room(const dvec3& low, const dvec3& high) { painter_->set_room(low, high); }
void BoneLayer::expose() { painter_->expose(); }
bool BoneLayer::render(bool always) { return painter_->render(always); }
bool BoneLayer::is_complete() const noexcept { return painter_->is_complete(); }
double BoneLayer::drawn_share() const noexcept { return painter_->drawn_share(); }
std::size_t BoneLayer::triangle_count() const noexcept { return painter_->triangle_count(); }
std::size_t BoneLayer::coarse_triangle_count() const { return painter_->coarse_triangle_count(); }
std::uint64_t BoneLayer::revision() const noexcept { return painter_->revision(); }
std::size_t BoneLayer::drawn_triangles() const noexcept { return painter_->drawn_triangles(); }
void BoneLayer::bounds(dvec3& low, dvec3& high) const { painter_->bounds(low, high); }

}  // namespace trephine::view
