#include "apps/view/framebuffer_copy.h"

#include <vtk_glew.h>

namespace trephine::view {

void copy_framebuffer(unsigned from, const glm::ivec2& from_size, unsigned to, const glm::ivec2& to_size,
                      bool has_depth) {
  GLint read = 0, draw = 0;
  glGetIntegerv(GL_READ_FRAMEBUFFER_BINDING, &read);
  glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &draw);
  const GLboolean is_clipped = glIsEnabled(GL_SCISSOR_TEST);
  glDisable(GL_SCISSOR_TEST);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, from);
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, to);
  const GLbitfield buffers = GL_COLOR_BUFFER_BIT | (has_depth ? GL_DEPTH_BUFFER_BIT : 0);
  glBlitFramebuffer(0, 0, from_size.x, from_size.y, 0, 0, to_size.x, to_size.y, buffers,
                    from_size == to_size ? GL_NEAREST : GL_LINEAR);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, static_cast<GLuint>(read));
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, static_cast<GLuint>(draw));
  if (is_clipped) glEnable(GL_SCISSOR_TEST);
}

}  // namespace trephine::view
