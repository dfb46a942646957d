// A place to draw: a window on a display, or memory where there is none.
#pragma once

#include <memory>
#include <string>

#include "volume/error.h"

class vtkRenderWindow;

namespace trephine::view {

/// Is there an X display to open a window on?
bool has_display();
/// What to say when a window is wanted and there is none.
volume::Error no_display();

/// Owns an OpenGL context and a VTK window that draws into it. One thread.
class DrawSurface {
 public:
  virtual ~DrawSurface() = default;
  virtual vtkRenderWindow* window() = 0;
};

/// Memory of width x height pixels; needs no display (EGL, surfaceless). Error (missing here) when no GL is
/// found.
volume::Result<std::unique_ptr<DrawSurface>> make_offscreen(int width, int height);

/// Which OpenGL draws, in words: "llvmpipe (LLVM 15), 4.5 (Core Profile) Mesa 22.3". Makes a context and
/// drops it.
volume::Result<std::string> describe_gl();

/// What the window shows, as a PNG file holds it.
std::string png_of(vtkRenderWindow* window);
/// Writes what the window shows as PNG, atomically. What is written in the picture is its description, too.
volume::Status write_png(vtkRenderWindow* window, const std::string& path);

}  // namespace trephine::view
