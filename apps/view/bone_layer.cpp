#include "apps/view/bone_layer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/vector_relational.hpp>
#include <vector>
#include <vtkCallbackCommand.h>
#include <vtkCamera.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>
#include <vtkRect.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtk_glew.h>

#include "apps/view/bone_actors.h"
#include "apps/view/picture_cache.h"
#include "apps/view/render_window.h"
#include "apps/view/screen_rectangle.h"
#include "apps/workbench/clock.h"

namespace trephine::view {

using glm::dvec3;
using workbench::Clock;
using workbench::seconds_since;

namespace {
constexpr double k_rest_seconds = 0.12;  // time without motion before drawing at full detail starts
constexpr double k_batch_ms = 30;        // time for the triangles that one frame draws at full detail
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
  void complete_next_drawing();
  void set_eye(int eye);
  void begin_new_picture();
  /// Makes the next frame begin a new picture.
  void forget_view() {
    kept_view_ = {}, ++revision_;
    if (other_eye_) other_eye_->kept_view = {};
  }
  bool is_complete() const noexcept { return is_fine_ && !has_moved(); }
  double drawn_share() const noexcept {
    if (is_complete()) return 1;
    if (has_moved()) return 0;
    if (actors_.chunk_count() == 0) return 1;
    return 1 -
           std::min(1.0, static_cast<double>(to_draw_.size()) / static_cast<double>(actors_.chunk_count()));
  }
  const BoneActors& actors() const noexcept { return actors_; }
  std::size_t drawn_triangles() const noexcept { return drawn_triangles_; }
  std::uint64_t revision() const noexcept { return revision_; }

 private:
  enum class Pass { nothing, everything, coarse, batch, rectangle };
  /// State of the eye that is not drawn now; see set_eye().
  struct OtherEye {
    PictureCache kept, pending;
    bool can_keep = true, is_fine = false, is_first_batch = true, is_last_batch = false;
    bool is_blend_stale = false;
    std::vector<BoneActors::Key> to_draw;
    std::vector<BoneActors::Box> changed_boxes;
    ScreenRectangle changed;
    dvec3 fitted_low{1e300}, fitted_high{-1e300};
    std::array<double, 2> fitted_range{};
    std::array<double, 16> kept_view{};
    std::array<int, 2> kept_size{};
    Clock::time_point moved_at;
    vtkMTimeType drawn_top_time = 0;
  };

  /// True if the bone is blended over what is behind it.
  bool is_blended() const { return restore_behind_ && can_keep_ && kept_.is_filled(); }
  ScreenRectangle on_screen(const BoneActors::Box& box) const {
    return view::on_screen(box.low, box.high, bone_->GetActiveCamera(), window_);
  }
  void begin_pass(Pass pass, std::size_t triangles);
  void fit_clipping_range();
  /// Camera of the view, without the clipping range.
  std::array<double, 16> view() const;
  /// Returns true if the window has another size or camera than the kept picture.
  bool has_moved() const;
  /// Begins the picture of a new view. Draws reduced surfaces if there are any. Otherwise draws at full
  /// detail if that is quick or if no picture can be kept, and coarsely if not.
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
  BoneActors actors_;
  double opacity_ = 1;
  bool is_blend_stale_ = false;  ///< the opacity changed since the last frame
  std::function<void()> restore_behind_;
  std::size_t drawn_triangles_ = 0;
  std::uint64_t revision_ = 0;

  // The kept picture, and the picture that is being drawn at full detail.
  PictureCache kept_, pending_;
  Pass pass_ = Pass::everything;
  bool can_keep_ = true, is_fine_ = false, is_first_batch_ = true, is_last_batch_ = false;
  bool is_redraw_ = false;  ///< the window system redraws a new view, outside render()
  std::array<unsigned long, 2> redraw_observers_{};  ///< of the window
  std::vector<BoneActors::Key> to_draw_;             ///< chunks that are missing in the pending picture
  std::vector<BoneActors::Box> changed_boxes_;       ///< since the last frame; see `changed_`
  ScreenRectangle changed_;                          ///< outdated part of the kept picture
  dvec3 room_low_{1e300}, room_high_{-1e300};        ///< box of the objects on top
  dvec3 fitted_low_{1e300}, fitted_high_{-1e300};    ///< box that the camera's clipping range includes
  std::array<double, 2> fitted_range_{};             ///< that clipping range
  std::array<double, 16> kept_view_{};
  std::array<int, 2> kept_size_{};
  Clock::time_point moved_at_;
  vtkMTimeType drawn_top_time_ = 0;  ///< newest_change() of the other renderers at the last frame
  int eye_ = 0;
  std::unique_ptr<OtherEye> other_eye_;  ///< null before the first set_eye(1)
  double triangles_per_ms_ = 3000;       ///< measured
};

BoneLayer::Painter::Painter(vtkRenderWindow* window, vtkRenderer* bone, vtkRenderer* tools, bool is_live)
    : window_(window), bone_(bone), is_live_(is_live), actors_(bone, is_live) {
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
  if (!window_->IsCurrent()) return;
  kept_.release(), pending_.release();
  if (other_eye_) other_eye_->kept.release(), other_eye_->pending.release();
}

void BoneLayer::Painter::begin_new_picture() {
  set_eye(0);
  window_->MakeCurrent();
  if (other_eye_ && window_->IsCurrent()) other_eye_->kept.release(), other_eye_->pending.release();
  other_eye_.reset();
  forget_view();
}

void BoneLayer::Painter::set_eye(int eye) {
  if (eye == eye_) return;
  eye_ = eye;
  if (!other_eye_) other_eye_ = std::make_unique<OtherEye>();
  OtherEye& o = *other_eye_;
  kept_.swap(o.kept), pending_.swap(o.pending);
  std::swap(can_keep_, o.can_keep), std::swap(is_fine_, o.is_fine);
  std::swap(is_first_batch_, o.is_first_batch), std::swap(is_last_batch_, o.is_last_batch);
  std::swap(is_blend_stale_, o.is_blend_stale);
  to_draw_.swap(o.to_draw);
  std::swap(changed_, o.changed);
  std::swap(fitted_low_, o.fitted_low), std::swap(fitted_high_, o.fitted_high);
  std::swap(fitted_range_, o.fitted_range);
  std::swap(kept_view_, o.kept_view), std::swap(kept_size_, o.kept_size);
  std::swap(moved_at_, o.moved_at), std::swap(drawn_top_time_, o.drawn_top_time);
  changed_boxes_.swap(o.changed_boxes);
}

void BoneLayer::Painter::show(const ChunkMesh& mesh) {
  const BoneActors::Change change = actors_.show(mesh);
  if (!is_live_) return;
  for (const BoneActors::Box& box : change.boxes)
    if (!box.is_empty()) changed_boxes_.push_back(box);
  if (change.chunk && !is_fine_) to_draw_.push_back(*change.chunk);
  if (!other_eye_) return;
  for (const BoneActors::Box& box : change.boxes)
    if (!box.is_empty()) other_eye_->changed_boxes.push_back(box);
  if (change.chunk && !other_eye_->is_fine) other_eye_->to_draw.push_back(*change.chunk);
}

void BoneLayer::Painter::show_reduced(const std::vector<ChunkMesh>& meshes) {
  for (const ChunkMesh& mesh : meshes) {
    if (mesh.coarse.triangles.empty()) continue;
    actors_.add_reduced(mesh);
    forget_view();
  }
}

void BoneLayer::Painter::end_reduced() {
  if (actors_.remove_reduced()) forget_view();
}

void BoneLayer::Painter::clear() {
  actors_.clear();
  to_draw_.clear();
  if (other_eye_) other_eye_->to_draw.clear();
  forget_view();
}

void BoneLayer::Painter::remove_shape(std::size_t shape) {
  if (actors_.remove_shape(shape)) forget_view();
}

void BoneLayer::Painter::set_hidden(std::set<std::size_t> shapes) {
  if (actors_.set_hidden(std::move(shapes))) forget_view();
}

/// Changes how the finished picture of the bone is blended. The picture itself is not drawn again.
void BoneLayer::Painter::set_opacity(double opacity, std::function<void()> restore_behind) {
  opacity_ = opacity;
  restore_behind_ = std::move(restore_behind);
  is_blend_stale_ = true;
  if (other_eye_) other_eye_->is_blend_stale = true;
  ++revision_;
}

void BoneLayer::Painter::blend() {
  if (is_blended()) kept_.blend(window_, opacity_);
}

void BoneLayer::Painter::set_clip(const dvec3& origin, const dvec3& normal) {
  actors_.set_clip(origin, normal);
  forget_view();
}

/// Draws the chosen triangles into a new picture.
void BoneLayer::Painter::begin_pass(Pass pass, std::size_t triangles) {
  pass_ = pass;
  drawn_triangles_ = triangles;
  bone_->DrawOn();
  bone_->PreserveColorBufferOff();
  bone_->PreserveDepthBufferOff();
}

void BoneLayer::Painter::draw_all_once() { begin_pass(Pass::everything, actors_.draw_all()); }
void BoneLayer::Painter::prepare_reduced() { begin_pass(Pass::coarse, actors_.draw_reduced()); }
void BoneLayer::Painter::prepare_coarse() { begin_pass(Pass::coarse, actors_.draw_coarse()); }

void BoneLayer::Painter::prepare_batch() {
  actors_.draw_nothing();
  const double max_triangles = std::max(60000.0, triangles_per_ms_ * k_batch_ms);
  std::size_t triangles = 0;
  while (!to_draw_.empty() && static_cast<double>(triangles) < max_triangles) {
    triangles += actors_.draw_chunk(to_draw_.back());
    to_draw_.pop_back();
  }
  begin_pass(Pass::batch, triangles);
  is_last_batch_ = to_draw_.empty();
  if (!is_first_batch_) {
    bone_->PreserveColorBufferOn();
    bone_->PreserveDepthBufferOn();
  }
}

void BoneLayer::Painter::prepare_rectangle() {
  begin_pass(Pass::rectangle, actors_.draw_where([this](const BoneActors::Box& box) {
    return on_screen(box).meets(changed_);
  }));
  const int x = static_cast<int>(changed_.low_x), y = static_cast<int>(changed_.low_y);
  bone_->GetActiveCamera()->SetScissorRect(vtkRecti(x, y, static_cast<int>(std::ceil(changed_.high_x)) - x,
                                                    static_cast<int>(std::ceil(changed_.high_y)) - y));
  bone_->GetActiveCamera()->SetUseScissor(true);
}

/// Sets the camera's clipping range by the whole bone, even if only a part is drawn, with room for the
/// instruments.
void BoneLayer::Painter::fit_clipping_range() {
  constexpr double k_room_mm = 150;
  const BoneActors::Box bounds = actors_.bounds();
  if (bounds.low.x > bounds.high.x) return;
  fitted_low_ = bounds.low, fitted_high_ = bounds.high;
  const dvec3 low = glm::min(bounds.low, room_low_), high = glm::max(bounds.high, room_high_);
  const double box[6] = {low.x - k_room_mm,  high.x + k_room_mm, low.y - k_room_mm,
                         high.y + k_room_mm, low.z - k_room_mm,  high.z + k_room_mm};
  bone_->ResetCameraClippingRange(box);
  bone_->GetActiveCamera()->GetClippingRange(fitted_range_.data());
}

void BoneLayer::Painter::complete_next_drawing() {
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
  to_draw_ = actors_.chunks();
  is_first_batch_ = true;
  const auto triangles = static_cast<double>(actors_.triangle_count());
  is_fine_ = !actors_.has_reduced() && (triangles < triangles_per_ms_ * k_batch_ms || !can_keep_);
  if (actors_.has_reduced()) {
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
  for (const BoneActors::Box& box : std::exchange(changed_boxes_, {})) changed_.add(on_screen(box));
  // Chunks that arrive while a scan is opened may be outside the camera's clipping range: begin a new
  // picture.
  const BoneActors::Box bounds = actors_.bounds();
  if (glm::any(glm::lessThan(bounds.low, fitted_low_)) ||
      glm::any(glm::greaterThan(bounds.high, fitted_high_)))
    kept_.forget();
  const double broad = 0.35 * size[0] * size[1];
  if (has_moved() || !can_keep_ || !kept_.is_filled() ||
      (!actors_.has_reduced() && !changed_.is_empty() && changed_.area() > broad)) {
    prepare_view();
  } else if (!actors_.has_reduced() && !is_fine_ && seconds_since(moved_at_) > k_rest_seconds) {
    prepare_batch();
  } else if (is_fine_ && !changed_.is_empty()) {
    prepare_rectangle();
  } else {
    pass_ = Pass::nothing;
    drawn_triangles_ = 0;
    bone_->DrawOff();
  }
  // VTK fits the clipping range to the actors of this frame, which may be a part of the bone: restore the
  // range of the whole bone.
  camera->SetClippingRange(fitted_range_.data());
  if (!always && pass_ == Pass::nothing && is_fine_ && !std::exchange(is_blend_stale_, false) &&
      newest_change(window_, bone_) == drawn_top_time_)
    return false;
  revision_ += pass_ != Pass::nothing;
  const bool was_changed = !changed_.is_empty();
  if (pass_ == Pass::rectangle) changed_ = {};
  const auto begin = Clock::now();
  window_->Render();

  // Estimates the drawing speed of this machine from frames with enough triangles.
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
      // A chunk that changed between two batches may be in the picture in both its old and its new state. In
      // this case `changed_` stays, so that a later frame draws this part again.
      if (!was_changed) changed_ = {};
      // The window still shows the previous picture, since batches are drawn into a picture of their own.
      // Show the finished picture.
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
void BoneLayer::begin_new_picture() { painter_->begin_new_picture(); }
void BoneLayer::set_eye(int eye) { painter_->set_eye(eye); }
void BoneLayer::complete_next_drawing() { painter_->complete_next_drawing(); }
bool BoneLayer::render(bool always) { return painter_->render(always); }
bool BoneLayer::is_complete() const noexcept { return painter_->is_complete(); }
double BoneLayer::drawn_share() const noexcept { return painter_->drawn_share(); }
std::size_t BoneLayer::triangle_count() const noexcept { return painter_->actors().triangle_count(); }
std::size_t BoneLayer::coarse_triangle_count() const { return painter_->actors().coarse_triangle_count(); }
std::uint64_t BoneLayer::revision() const noexcept { return painter_->revision(); }
std::size_t BoneLayer::drawn_triangles() const noexcept { return painter_->drawn_triangles(); }
void BoneLayer::bounds(dvec3& low, dvec3& high) const {
  const BoneActors::Box box = painter_->actors().bounds();
  low = box.low, high = box.high;
}

}  // namespace trephine::view
