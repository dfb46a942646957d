// Render target: a window on a display, or memory without a display.
#pragma once

#include <memory>
#include <string>

#include "volume/error.h"

class vtkRenderWindow;

namespace trephine::view {

/// Is there an X display to open a window on?
bool has_display();
/// Error for a window without a display.
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

/// Description of the OpenGL in use: "llvmpipe (LLVM 15), 4.5 (Core Profile) Mesa 22.3". Makes a context and
/// drops it.
volume::Result<std::string> describe_gl();

/// Contents of the window as a PNG file.
std::string png_of(vtkRenderWindow* window);
/// Writes what the window shows as PNG, atomically. What is written in the picture is its description, too.
volume::Status write_png(vtkRenderWindow* window, const std::string& path);

}  // namespace trephine::view
