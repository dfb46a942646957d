// Text over a picture: letters of the patient's directions at its edges, a scale bar, lines in a corner.
#pragma once

#include <array>
#include <string>
#include <vtkNew.h>
#include <vtkSmartPointer.h>

class vtkActor2D;
class vtkPolyData;
class vtkRenderer;
class vtkTextActor;

namespace trephine::view {

/// One thread: the one that draws. Borrows the renderer.
class PictureText {
 public:
  explicit PictureText(vtkRenderer* renderer);
  ~PictureText();

  /// Lines in the upper left corner, and one below in the middle.
  void show(const std::string& corner, const std::string& foot);
  /// Times the size that text has otherwise.
  void set_scale(double factor);
  /// Letters and scale for the camera as it is now. Before each frame.
  void update();

 private:
  void show_directions();
  void show_scale();

  vtkRenderer* renderer_;
  vtkNew<vtkTextActor> corner_, foot_, bar_text_;
  std::array<vtkSmartPointer<vtkTextActor>, 4> edges_;  ///< which way of the patient is right, left, up, down
  vtkNew<vtkPolyData> bar_line_;
  vtkNew<vtkActor2D> bar_;
};

}  // namespace trephine::view
