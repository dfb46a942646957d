#include "apps/view/eye_display.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <utility>
#include <vtkCallbackCommand.h>
#include <vtkCamera.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkShaderProgram.h>

#include "apps/view/bone_layer.h"
#include "apps/view/picture_cache.h"
#include "apps/view/screen_quad.h"

namespace trephine::view {

using glm::dvec2;
using glm::dvec3;

namespace {

// Anaglyph: least-squares projection for red and cyan filters (E. Dubois, ICASSP 2001), rows: red, green,
// blue.
constexpr const char* k_combine = R"(//VTK::System::Dec
in vec2 texCoord;
uniform sampler2D leftPicture;
uniform sampler2D rightPicture;
uniform int eyes;
uniform int mirrored;
//VTK::Output::Dec
void main() {
  vec2 at = texCoord;
  bool isRight = false;
  if (eyes == 2) {
    isRight = at.x >= 0.5;
    at.x = 2.0 * at.x - (isRight ? 1.0 : 0.0);
  }
  if (mirrored == 1) at.x = 1.0 - at.x;
  vec3 left = texture(leftPicture, at).rgb, right = texture(rightPicture, at).rgb;
  vec3 colour = isRight ? right : left;
  if (eyes == 1)
    colour = clamp(mat3(0.456, -0.040, -0.015, 0.500, -0.038, -0.021, 0.176, -0.016, -0.005) * left +
                   mat3(-0.043, 0.378, -0.072, -0.088, 0.734, -0.113, -0.002, -0.018, 1.226) * right, 0.0, 1.0);
  gl_FragData[0] = vec4(colour, 1.0);
})";

dvec3 vector_of(const double* v) { return {v[0], v[1], v[2]}; }

}  // namespace

dvec2 window_position(const DisplayMode& mode, const dvec2& in_picture) noexcept {
  dvec2 at = in_picture;
  if (mode.is_mirrored) at.x = 1 - at.x;
  if (mode.eyes == DisplayMode::Eyes::side_by_side) at.x *= 0.5;
  return at;
}

dvec2 picture_position(const DisplayMode& mode, const dvec2& in_window) noexcept {
  dvec2 at = in_window;
  if (mode.eyes == DisplayMode::Eyes::side_by_side) at.x = 2 * at.x - (at.x >= 0.5 ? 1 : 0);
  if (mode.is_mirrored) at.x = 1 - at.x;
  return at;
}

void move_to_eye(vtkCamera* camera, double aspect, const dvec3& eye) {
  const dvec3 position = vector_of(camera->GetPosition()), focus = vector_of(camera->GetFocalPoint());
  const dvec3 toward_viewer = glm::normalize(position - focus);
  const dvec3 right = glm::normalize(glm::cross(vector_of(camera->GetViewUp()), toward_viewer));
  const dvec3 up = glm::cross(toward_viewer, right);
  const double half_height =
      glm::length(position - focus) * std::tan(0.5 * glm::radians(camera->GetViewAngle()));
  const dvec3 target = focus + eye.x * right + eye.y * up, at = target + eye.z * toward_viewer;
  camera->SetPosition(at.x, at.y, at.z);
  camera->SetFocalPoint(target.x, target.y, target.z);
  camera->SetViewAngle(glm::degrees(2 * std::atan(half_height / eye.z)));
  camera->SetWindowCenter(-eye.x / (half_height * aspect), -eye.y / half_height);
}

void move_to_headset_eye(vtkCamera* camera, const HmdEye& eye, const HmdEye& start, double distance) {
  const dvec3 position = vector_of(camera->GetPosition()), focus = vector_of(camera->GetFocalPoint());
  const dvec3 toward_viewer = glm::normalize(position - focus);
  const dvec3 right = glm::normalize(glm::cross(vector_of(camera->GetViewUp()), toward_viewer));
  const dvec3 up = glm::cross(toward_viewer, right);
  // Directions of the room, seen from the start, are those of the picture.
  const auto turned = [&](const dvec3& in_room) {
    const dvec3 v = glm::conjugate(start.orientation) * in_room;
    return v.x * right + v.y * up + v.z * toward_viewer;
  };
  const double scale = glm::length(position - focus) / distance;
  const dvec3 at = position + scale * turned(eye.position - start.position);
  const dvec3 target = at + glm::length(position - focus) * turned(eye.orientation * dvec3(0, 0, -1));
  const dvec3 upward = turned(eye.orientation * dvec3(0, 1, 0));
  camera->SetPosition(at.x, at.y, at.z);
  camera->SetFocalPoint(target.x, target.y, target.z);
  camera->SetViewUp(upward.x, upward.y, upward.z);
  const double width = eye.right - eye.left, height = eye.up - eye.down;
  camera->SetViewAngle(glm::degrees(2 * std::atan(0.5 * height)));
  camera->SetWindowCenter((eye.right + eye.left) / width, (eye.up + eye.down) / height);
  camera->SetExplicitAspectRatio(width / height);
  camera->SetUseExplicitAspectRatio(true);
}

HmdEye horizontal_middle(const std::array<HmdEye, 2>& eyes) {
  HmdEye middle;
  middle.position = 0.5 * (eyes[0].position + eyes[1].position);
  const dvec3 sight = eyes[0].orientation * dvec3(0, 0, -1) + eyes[1].orientation * dvec3(0, 0, -1);
  // A line of sight straight up or down has no horizontal direction: the room's is kept.
  if (glm::length(dvec2(sight.x, sight.z)) > 1e-6)
    middle.orientation = glm::angleAxis(std::atan2(-sight.x, -sight.z), dvec3(0, 1, 0));
  return middle;
}

/// Pictures of the eyes, and the shader that combines them.
struct EyeDisplay::Pictures {
  std::array<PictureCache, 2> eyes;
  ScreenQuad quad;
};

EyeDisplay::EyeDisplay(vtkRenderWindow* window, vtkRenderer* renderer, vtkRenderer* last,
                       const DisplayMode& mode, std::shared_ptr<HeadTracker> tracker,
                       std::shared_ptr<Hmd> hmd)
    : window_(window),
      renderer_(renderer),
      last_(last),
      mode_(mode),
      tracker_(std::move(tracker)),
      hmd_(std::move(hmd)),
      pictures_(std::make_unique<Pictures>()) {
  vtkNew<vtkCallbackCommand> end;
  end->SetClientData(this);
  end->SetCallback(
      [](vtkObject*, unsigned long, void* self, void*) { static_cast<EyeDisplay*>(self)->end_frame(); });
  observers_[0] = last->AddObserver(vtkCommand::EndEvent, end);
  if (!hmd_) return;
  vtkNew<vtkCallbackCommand> begin_texts;
  begin_texts->SetClientData(this);
  begin_texts->SetCallback([](vtkObject*, unsigned long, void* self, void*) {
    static_cast<EyeDisplay*>(self)->keep_headset_eye();
  });
  observers_[1] = last->AddObserver(vtkCommand::StartEvent, begin_texts);
}

EyeDisplay::~EyeDisplay() {
  for (const unsigned long observer : observers_) last_->RemoveObserver(observer);
  window_->MakeCurrent();
  if (!window_->IsCurrent()) return;
  if (hmd_) hmd_->end_session();
  for (PictureCache& picture : pictures_->eyes) picture.release();
}

/// Returns the position of an eye as move_to_eye() takes it. `head`: newest position of the tracker.
/// `picture_width`: of the plane through the focal point, mm; `distance`: of the camera from the focal point,
/// mm.
dvec3 EyeDisplay::eye_position(int eye, const std::optional<dvec3>& head, double picture_width,
                               double distance) const {
  const double side = mode_.eyes == DisplayMode::Eyes::one ? 0 : eye == 0 ? -0.5 : 0.5;
  if (head) {
    // The screen shows `picture_width` mm of the scene on `screen_width` mm.
    const double scale = picture_width / mode_.screen_width;
    constexpr double k_nearest = 100;  // mm
    return scale * dvec3(head->x + side * mode_.eye_distance, head->y, std::max(head->z, k_nearest));
  }
  // The scene is scaled so that the camera is at the viewing distance.
  return {side * mode_.eye_distance * distance / mode_.viewing_distance, 0, distance};
}

std::array<double, 18> EyeDisplay::centre_view() const {
  std::array<double, 18> view;
  vtkCamera* camera = renderer_->GetActiveCamera();
  std::copy_n(camera->GetModelViewTransformMatrix()->GetData(), 16, view.begin());
  view[15] = camera->GetViewAngle();
  view[16] = window_->GetSize()[0], view[17] = window_->GetSize()[1];
  return view;
}

/// Draws the eyes of a headset and shows them. While the headset shows nothing, one ordinary frame is drawn.
bool EyeDisplay::render_headset(BoneLayer& bone, const std::function<bool()>& draw) {
  window_->MakeCurrent();
  const auto eyes = is_paused_ ? std::nullopt : hmd_->begin_frame();
  vtkCamera* camera = renderer_->GetActiveCamera();
  drawn_view_ = centre_view();
  if (eyes && !start_) start_ = horizontal_middle(*eyes);
  vtkNew<vtkCamera> middle;
  middle->DeepCopy(camera);
  bool is_drawn = false;
  are_eyes_complete_ = true, share_ = 1;
  for (eye_ = 0; eye_ < (eyes ? 2 : 1); ++eye_) {
    if (eyes)
      move_to_headset_eye(camera, (*eyes)[static_cast<std::size_t>(eye_)], *start_, mode_.viewing_distance);
    bone.set_eye(eye_);
    is_drawn |= draw();
    are_eyes_complete_ &= bone.is_complete();
    share_ = std::min(share_, bone.drawn_share());
    camera->DeepCopy(middle);
    camera->SetUseExplicitAspectRatio(false);  // not copied
  }
  eye_ = -1;
  bone.set_eye(0);
  if (!eyes) return is_drawn;
  const int* size = window_->GetSize();
  for (int i = 0; i < 2; ++i)
    hmd_->show(i, pictures_->eyes[static_cast<std::size_t>(i)].framebuffer(), size[0], size[1]);
  hmd_->end_frame();
  return is_drawn;
}

/// Keeps the finished picture of an eye without texts, which the renderer `last_` draws next. The window then
/// shows the picture of the left eye, with texts.
void EyeDisplay::keep_headset_eye() {
  const int* size = window_->GetSize();
  if (eye_ < 0) return;
  pictures_->eyes[static_cast<std::size_t>(eye_)].save(size[0], size[1]);
  if (eye_ == 1) combine();
}

bool EyeDisplay::render(BoneLayer& bone, const std::function<bool()>& draw) {
  if (hmd_) return render_headset(bone, draw);
  vtkCamera* camera = renderer_->GetActiveCamera();
  const int* size = window_->GetSize();
  const double aspect = std::max(1, size[0]) / static_cast<double>(std::max(1, size[1]));
  const dvec3 position = vector_of(camera->GetPosition()), focus = vector_of(camera->GetFocalPoint());
  const double angle = camera->GetViewAngle(), distance = glm::length(position - focus);
  const double width = 2 * distance * std::tan(0.5 * glm::radians(angle)) * aspect;
  drawn_view_ = centre_view();
  const std::optional<dvec3> head = tracker_ ? tracker_->position() : std::nullopt;  // the same for both eyes
  bool is_drawn = false;
  are_eyes_complete_ = true, share_ = 1;
  for (eye_ = 0; eye_ < (mode_.eyes == DisplayMode::Eyes::one ? 1 : 2); ++eye_) {
    move_to_eye(camera, aspect, eye_position(eye_, head, width, distance));
    bone.set_eye(eye_);
    is_drawn |= draw();
    are_eyes_complete_ &= bone.is_complete();
    share_ = std::min(share_, bone.drawn_share());
    camera->SetPosition(position.x, position.y, position.z);
    camera->SetFocalPoint(focus.x, focus.y, focus.z);
    camera->SetViewAngle(angle);
    camera->SetWindowCenter(0, 0);
  }
  eye_ = -1;
  bone.set_eye(0);
  return is_drawn;
}

Status EyeDisplay::take_problem() {
  if (!hmd_ || is_problem_taken_ || !hmd_->problem()) return std::nullopt;
  is_problem_taken_ = true;
  return hmd_->problem();
}

bool EyeDisplay::is_complete() const { return are_eyes_complete_ && centre_view() == drawn_view_; }
double EyeDisplay::drawn_share() const { return centre_view() == drawn_view_ ? share_ : 0; }

/// Keeps the finished picture of an eye, and draws the combined picture over it. A frame that is drawn
/// outside render(), by the window system or for a file, shows the last pictures of the eyes. If the view has
/// changed since, it shows both eyes the same picture until the next render().
void EyeDisplay::end_frame() {
  if (hmd_) return;
  const int* size = window_->GetSize();
  const bool is_outdated = eye_ < 0 && centre_view() != drawn_view_;
  for (int i = 0; i < 2; ++i)
    if (is_outdated || eye_ == i) pictures_->eyes[static_cast<std::size_t>(i)].save(size[0], size[1]);
  combine();
}

/// Draws the kept pictures of the eyes over the framebuffer.
void EyeDisplay::combine() {
  const int* size = window_->GetSize();
  const bool has_two = mode_.eyes != DisplayMode::Eyes::one;
  const auto& eyes = pictures_->eyes;
  const PictureCache &left = eyes[0], &right = eyes[has_two && eyes[1].is_filled() ? 1 : 0];
  if (!left.is_filled()) return;
  const ScreenQuad::Texture textures[] = {{"leftPicture", left.colour_texture()},
                                          {"rightPicture", right.colour_texture()}};
  pictures_->quad.draw(window_, k_combine, size[0], size[1], textures, ScreenQuad::Depth::ignored,
                       [this](vtkShaderProgram& program) {
                         program.SetUniformi("eyes", static_cast<int>(mode_.eyes));
                         program.SetUniformi("mirrored", mode_.is_mirrored ? 1 : 0);
                       });
}

}  // namespace trephine::view
