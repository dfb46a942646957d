#include "apps/view/screen_quad.h"

#include <vector>
#include <vtkOpenGLQuadHelper.h>
#include <vtkOpenGLRenderWindow.h>
#include <vtkOpenGLShaderCache.h>
#include <vtkOpenGLState.h>
#include <vtkShaderProgram.h>
#include <vtk_glew.h>

namespace trephine::view {

ScreenQuad::ScreenQuad() = default;
ScreenQuad::~ScreenQuad() = default;

void ScreenQuad::draw(vtkRenderWindow* window, const char* shader, int width, int height,
                      std::span<const Texture> textures, Depth depth,
                      const std::function<void(vtkShaderProgram&)>& set_uniforms) {
  auto* gl_window = vtkOpenGLRenderWindow::SafeDownCast(window);
  if (gl_window == nullptr) return;
  if (!quad_)
    quad_ = std::make_unique<vtkOpenGLQuadHelper>(gl_window, nullptr, shader, nullptr);
  else
    gl_window->GetShaderCache()->ReadyShaderProgram(quad_->Program);
  if (quad_->Program == nullptr) return;
  vtkOpenGLState* state = gl_window->GetState();
  const vtkOpenGLState::ScopedglEnableDisable depth_test(state, GL_DEPTH_TEST), blending(state, GL_BLEND),
      scissor(state, GL_SCISSOR_TEST), culling(state, GL_CULL_FACE);
  const vtkOpenGLState::ScopedglDepthFunc depth_func(state);
  const vtkOpenGLState::ScopedglDepthMask depth_mask(state);
  const vtkOpenGLState::ScopedglViewport viewport(state);
  const vtkOpenGLState::ScopedglBlendFuncSeparate blend_func(state);
  const vtkOpenGLState::ScopedglActiveTexture active(state);
  if (depth == Depth::tested)
    state->vtkglEnable(GL_DEPTH_TEST);
  else
    state->vtkglDisable(GL_DEPTH_TEST);
  state->vtkglEnable(GL_BLEND);
  state->vtkglDisable(GL_SCISSOR_TEST);
  state->vtkglDisable(GL_CULL_FACE);
  state->vtkglDepthFunc(GL_LESS);
  state->vtkglDepthMask(depth == Depth::tested ? GL_TRUE : GL_FALSE);
  state->vtkglViewport(0, 0, width, height);
  state->vtkglBlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  constexpr unsigned k_first_unit = 6;  // units that VTK does not use here
  std::vector<GLint> bound(textures.size(), 0);
  for (unsigned i = 0; i < textures.size(); ++i) {
    state->vtkglActiveTexture(GL_TEXTURE0 + k_first_unit + i);
    glGetIntegerv(GL_TEXTURE_BINDING_2D, &bound[i]);
    glBindTexture(GL_TEXTURE_2D, textures[i].texture);
    quad_->Program->SetUniformi(textures[i].name, static_cast<int>(k_first_unit + i));
  }
  set_uniforms(*quad_->Program);
  quad_->Render();
  for (unsigned i = 0; i < textures.size(); ++i) {
    state->vtkglActiveTexture(GL_TEXTURE0 + k_first_unit + i);
    glBindTexture(GL_TEXTURE_2D, static_cast<GLuint>(bound[i]));
  }
}

}  // namespace trephine::view
