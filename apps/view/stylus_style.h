// Mouse over the picture: left presses the stylus, right turns, middle moves, wheel is depth, Ctrl + wheel
// zooms.
#pragma once

#include <functional>
#include <string>
#include <vtkInteractorStyleTrackballCamera.h>
#include <vtkRenderWindowInteractor.h>

namespace trephine::view {

/// Mouse and keys, turned into calls; VTK's own key bindings stay out.
class StylusStyle : public vtkInteractorStyleTrackballCamera {
 public:
  static StylusStyle* New();
  vtkTypeMacro(StylusStyle, vtkInteractorStyleTrackballCamera)

      std::function<void(bool)> on_press,
      on_shift_press;
  std::function<void(int)> on_wheel;
  std::function<void(const std::string&, bool)> on_key;

  void OnLeftButtonDown() override {
    Interactor->GetShiftKey() && on_shift_press ? on_shift_press(true) : on_press(true);
  }
  void OnLeftButtonUp() override {
    if (on_shift_press) on_shift_press(false);  // whatever its key does by now
    on_press(false);
  }
  void OnRightButtonDown() override { pick_renderer(), StartRotate(); }
  void OnRightButtonUp() override { EndRotate(); }
  void OnMiddleButtonDown() override { pick_renderer(), StartPan(); }
  void OnMiddleButtonUp() override { EndPan(); }
  void OnMouseWheelForward() override { wheel(1); }
  void OnMouseWheelBackward() override { wheel(-1); }
  void OnKeyPress() override {
    on_key(Interactor->GetKeySym() ? Interactor->GetKeySym() : "", Interactor->GetControlKey() != 0);
  }
  void OnChar() override {}

 private:
  void pick_renderer() { SetCurrentRenderer(DefaultRenderer); }
  void wheel(int way) {
    if (!Interactor->GetControlKey()) return on_wheel(way);
    pick_renderer();
    way > 0 ? Superclass::OnMouseWheelForward() : Superclass::OnMouseWheelBackward();
  }
};

}  // namespace trephine::view
