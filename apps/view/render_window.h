// DrawSurface: target of rendering, either a window on a display or memory without a display.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "volume/base/error.h"

class vtkRenderWindow;
class vtkRenderer;

namespace trephine::view {

/// True if the X display of the environment variable DISPLAY accepts a connection. Connects once per process.
bool has_display();
/// Returns the error of a window that needs a display if there is no display.
Error no_display();

/// Owns an OpenGL context and a VTK window that draws into it. One thread.
class DrawSurface {
 public:
  virtual ~DrawSurface() = default;
  virtual vtkRenderWindow* window() = 0;
};

/// Creates a surface in memory of width x height pixels, without a display (surfaceless EGL). Error
/// (ErrorKind::missing_here) if OpenGL is not available.
Result<std::unique_ptr<DrawSurface>> make_offscreen(int width, int height);

/// Description of the OpenGL in use: "llvmpipe (LLVM 15), OpenGL 4.5 (Core Profile) Mesa 22.3". Creates a
/// temporary context.
Result<std::string> describe_gl();

/// Returns the newest modification time of the props of the window's renderers other than `except`.
std::uint64_t newest_change(vtkRenderWindow* window, const vtkRenderer* except);

/// Contents of the window as a PNG file. The texts in the picture become its description.
std::string png_of(vtkRenderWindow* window);
/// Writes png_of() to a file, atomically.
Status write_png(vtkRenderWindow* window, const std::string& path);

}  // namespace trephine::view
