// ScreenQuad: a shader that is run for each pixel of a window.
#pragma once

#include <functional>
#include <memory>
#include <span>

class vtkOpenGLQuadHelper;
class vtkRenderWindow;
class vtkShaderProgram;

namespace trephine::view {

/// Draws while VTK renders, and restores the OpenGL state that it changes.
class ScreenQuad {
 public:
  ScreenQuad();
  ~ScreenQuad();
  ScreenQuad(const ScreenQuad&) = delete;
  ScreenQuad& operator=(const ScreenQuad&) = delete;

  struct Texture {
    const char* name;  ///< of the sampler in the shader
    unsigned texture;  ///< OpenGL name
  };
  enum class Depth { ignored, tested };
  /// Runs a fragment shader, the same in all calls, for the lower left `width` x `height` pixels. The result
  /// is blended by its alpha. `Depth::tested`: the shader writes a depth, and is drawn where this depth is
  /// nearer.
  void draw(vtkRenderWindow* window, const char* shader, int width, int height,
            std::span<const Texture> textures, Depth depth,
            const std::function<void(vtkShaderProgram&)>& set_uniforms);

 private:
  std::unique_ptr<vtkOpenGLQuadHelper> quad_;  ///< null before the first draw()
};

}  // namespace trephine::view
