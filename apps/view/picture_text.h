// PictureText: text over a picture: letters of the patient's directions at its edges, a scale bar, lines in a
// corner.
#pragma once

#include <array>
#include <glm/vec2.hpp>
#include <string>
#include <vtkNew.h>
#include <vtkSmartPointer.h>

class vtkActor2D;
class vtkPolyData;
class vtkRenderer;
class vtkTextActor;

namespace trephine::view {

/// Drawing thread only. Borrows the renderer.
class PictureText {
 public:
  explicit PictureText(vtkRenderer* renderer);
  ~PictureText();

  /// Shows lines in the upper left corner, and one line at the bottom centre.
  void show(const std::string& corner, const std::string& foot);
  /// Sets the factor of the size of the letters and of the scale bar's text.
  void set_scale(double factor);
  /// Updates letters and scale for the current camera. Call before each frame.
  void update();
  /// Returns the lower left and the upper right corner of the lines in the corner, pixels; equal if there are
  /// no lines.
  std::array<glm::dvec2, 2> corner_box() const;

 private:
  void show_directions();
  void show_scale();

  vtkRenderer* renderer_;
  vtkNew<vtkTextActor> corner_, foot_, bar_text_;
  std::array<vtkSmartPointer<vtkTextActor>, 4> edges_;  ///< letters at the right, left, upper and lower edge
  vtkNew<vtkPolyData> bar_line_;
  vtkNew<vtkActor2D> bar_;
};

}  // namespace trephine::view
