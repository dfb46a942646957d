// StylusStyle: mouse controls of the picture. The left button presses the stylus, the middle button tilts the
// stylus, and the right button turns the picture, or moves the picture with Shift. The wheel sets the depth
// of the stylus; it rolls the stylus while the middle button is down, and zooms with Ctrl.
#pragma once

#include <algorithm>
#include <functional>
#include <string>
#include <vtkInteractorStyleTrackballCamera.h>
#include <vtkRenderWindow.h>
#include <vtkRenderWindowInteractor.h>

namespace trephine::view {

/// Translates mouse and key events to callbacks; VTK's own key bindings are disabled.
class StylusStyle : public vtkInteractorStyleTrackballCamera {
 public:
  static StylusStyle* New();
  vtkTypeMacro(StylusStyle, vtkInteractorStyleTrackballCamera)

      /// The left button was pressed (true) or released. If on_shift_press is set, a press with Shift calls
      /// it in place of on_press, and a release calls both.
      std::function<void(bool)> on_press = [](bool) {},
                                on_shift_press;
  /// The wheel was turned by one step: 1 forward, -1 backward. on_roll: while the middle button was down.
  std::function<void(int)> on_wheel = [](int) {}, on_roll = [](int) {};
  /// Zooms in (1) or out (-1) toward a position in the picture. The position is given as shares of the width
  /// and the height, from the lower left corner.
  std::function<void(int, double, double)> on_zoom = [](int, double, double) {};
  /// A key was pressed: its VTK key symbol, and true if Ctrl was down.
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
