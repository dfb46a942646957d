// StylusStyle: mouse controls of the picture: left presses the stylus, middle tilts it, right turns the
// picture, Shift + right moves it; the wheel sets the depth, with the middle button roll, with Ctrl zoom.
#pragma once

#include <algorithm>
#include <functional>
#include <string>
#include <vtkInteractorStyleTrackballCamera.h>
#include <vtkRenderWindow.h>
#include <vtkRenderWindowInteractor.h>

namespace trephine::view {

/// Translates mouse and keys to callbacks; VTK's own key bindings are disabled.
class StylusStyle : public vtkInteractorStyleTrackballCamera {
 public:
  static StylusStyle* New();
  vtkTypeMacro(StylusStyle, vtkInteractorStyleTrackballCamera)

      std::function<void(bool)> on_press = [](bool) {},
                                on_shift_press;
  std::function<void(int)> on_wheel = [](int) {}, on_roll = [](int) {};
  /// Zooms in (1) or out (-1) toward a position in the picture: shares from the lower left.
  std::function<void(int, double, double)> on_zoom = [](int, double, double) {};
  std::function<void(const std::string&, bool)> on_key = [](const std::string&, bool) {};
  /// The middle button was pressed or released.
  std::function<void(bool)> on_tilt = [](bool) {};
  /// The cursor moved while the middle (tilt) or right (turn) button was down: pixels to the right and up.
  std::function<void(double, double)> on_tilt_move = [](double, double) {}, on_turn = [](double, double) {};

  void OnLeftButtonDown() override {
    Interactor->GetShiftKey() && on_shift_press ? on_shift_press(true) : on_press(true);
  }
  void OnLeftButtonUp() override {
    if (on_shift_press) on_shift_press(false);  // also if Shift was released before the button
    on_press(false);
  }
  void OnRightButtonDown() override {
    pick_renderer();
    Interactor->GetShiftKey() ? StartPan() : StartRotate();
  }
  void OnRightButtonUp() override { State == VTKIS_PAN ? EndPan() : EndRotate(); }
  void OnMiddleButtonDown() override { on_tilt(is_tilting_ = true); }
  void OnMiddleButtonUp() override { on_tilt(is_tilting_ = false); }
  void OnMouseMove() override {
    if (is_tilting_) on_tilt_move(cursor_motion(0), cursor_motion(1));
    Superclass::OnMouseMove();
  }
  void Rotate() override { on_turn(cursor_motion(0), cursor_motion(1)); }
  void OnMouseWheelForward() override { wheel(1); }
  void OnMouseWheelBackward() override { wheel(-1); }
  void OnKeyPress() override {
    on_key(Interactor->GetKeySym() ? Interactor->GetKeySym() : "", Interactor->GetControlKey() != 0);
  }
  void OnChar() override {}

 private:
  void pick_renderer() { SetCurrentRenderer(DefaultRenderer); }
  int cursor_motion(int axis) const {
    return Interactor->GetEventPosition()[axis] - Interactor->GetLastEventPosition()[axis];
  }
  bool is_tilting_ = false;
  void wheel(int direction) {
    if (is_tilting_) return on_roll(direction);
    if (!Interactor->GetControlKey()) return on_wheel(direction);
    const int *at = Interactor->GetEventPosition(), *size = Interactor->GetRenderWindow()->GetSize();
    on_zoom(direction, static_cast<double>(at[0]) / std::max(1, size[0]),
            static_cast<double>(at[1]) / std::max(1, size[1]));
  }
};

}  // namespace trephine::view
