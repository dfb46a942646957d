#include "apps/view/picture_cache.h"

#include <utility>
#include <vtkShaderProgram.h>
#include <vtk_glew.h>

#include "apps/view/framebuffer_copy.h"
#include "apps/view/screen_quad.h"

namespace trephine::view {

namespace {

/// Returns the internal format of the depth buffer of the current draw framebuffer; 0 if unknown.
int current_depth_format() {
  GLint type = 0, name = 0, format = 0;
  glGetFramebufferAttachmentParameteriv(GL_DRAW_FRAMEBUFFER, GL_DEPTH_ATTACHMENT,
                                        GL_FRAMEBUFFER_ATTACHMENT_OBJECT_TYPE, &type);
  if (type != GL_TEXTURE && type != GL_RENDERBUFFER) return 0;
  glGetFramebufferAttachmentParameteriv(GL_DRAW_FRAMEBUFFER, GL_DEPTH_ATTACHMENT,
                                        GL_FRAMEBUFFER_ATTACHMENT_OBJECT_NAME, &name);
  GLint bound = 0;
  if (type == GL_RENDERBUFFER) {
    glGetIntegerv(GL_RENDERBUFFER_BINDING, &bound);
    glBindRenderbuffer(GL_RENDERBUFFER, static_cast<GLuint>(name));
    glGetRenderbufferParameteriv(GL_RENDERBUFFER, GL_RENDERBUFFER_INTERNAL_FORMAT, &format);
    glBindRenderbuffer(GL_RENDERBUFFER, static_cast<GLuint>(bound));
  } else {
    glGetIntegerv(GL_TEXTURE_BINDING_2D, &bound);
    glBindTexture(GL_TEXTURE_2D, static_cast<GLuint>(name));
    glGetTexLevelParameteriv(GL_TEXTURE_2D, 0, GL_TEXTURE_INTERNAL_FORMAT, &format);
    glBindTexture(GL_TEXTURE_2D, static_cast<GLuint>(bound));
  }
  return format;
}

}  // namespace

PictureCache::PictureCache() = default;
PictureCache::~PictureCache() = default;

bool PictureCache::make(int width, int height, int depth_format) {
  release();
  GLint read = 0, draw = 0, texture = 0;
  glGetIntegerv(GL_READ_FRAMEBUFFER_BINDING, &read);
  glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &draw);
  glGetIntegerv(GL_TEXTURE_BINDING_2D, &texture);
  const auto image = [width, height](unsigned& name, int internal, GLenum format, GLenum type) {
    glGenTextures(1, &name);
    glBindTexture(GL_TEXTURE_2D, name);
    glTexImage2D(GL_TEXTURE_2D, 0, internal, width, height, 0, format, type, nullptr);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  };
  const bool has_stencil = depth_format == GL_DEPTH24_STENCIL8 || depth_format == GL_DEPTH32F_STENCIL8;
  image(color_, GL_RGBA8, GL_RGBA, GL_UNSIGNED_BYTE);
  if (depth_format == GL_DEPTH24_STENCIL8)
    image(depth_, depth_format, GL_DEPTH_STENCIL, GL_UNSIGNED_INT_24_8);
  else if (depth_format == GL_DEPTH32F_STENCIL8)
    image(depth_, depth_format, GL_DEPTH_STENCIL, GL_FLOAT_32_UNSIGNED_INT_24_8_REV);
  else
    image(depth_, depth_format, GL_DEPTH_COMPONENT, GL_FLOAT);
  glGenFramebuffers(1, &framebuffer_);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, color_, 0);
  glFramebufferTexture2D(GL_FRAMEBUFFER, has_stencil ? GL_DEPTH_STENCIL_ATTACHMENT : GL_DEPTH_ATTACHMENT,
                         GL_TEXTURE_2D, depth_, 0);
  const bool is_complete = glCheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE;
  glBindTexture(GL_TEXTURE_2D, static_cast<GLuint>(texture));
  glBindFramebuffer(GL_READ_FRAMEBUFFER, static_cast<GLuint>(read));
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, static_cast<GLuint>(draw));
  width_ = width;
  height_ = height;
  depth_format_ = depth_format;
  return is_complete;
}

bool PictureCache::save(int width, int height) {
  const int format = current_depth_format();
  if (format == 0) return is_filled_ = false;
  if (framebuffer_ == 0 || width != width_ || height != height_ || format != depth_format_)
    if (!make(width, height, format)) return is_filled_ = false;
  GLint draw = 0;
  glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &draw);
  while (glGetError() != GL_NO_ERROR) {}
  copy_framebuffer(static_cast<unsigned>(draw), {width_, height_}, framebuffer_, {width_, height_}, true);
  return is_filled_ = glGetError() == GL_NO_ERROR;
}

void PictureCache::restore() const {
  if (!is_filled_) return;
  GLint draw = 0;
  glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &draw);
  copy_framebuffer(framebuffer_, {width_, height_}, static_cast<unsigned>(draw), {width_, height_}, true);
}

void PictureCache::blend(vtkRenderWindow* window, double opacity) {
  if (!is_filled_ || !(opacity > 0)) return;
  if (!quad_) quad_ = std::make_unique<ScreenQuad>();
  constexpr const char* k_shader = R"(//VTK::System::Dec
in vec2 texCoord;
uniform sampler2D picture;
uniform sampler2D depth;
uniform float opacity;
//VTK::Output::Dec
void main() {
  float near = texture(depth, texCoord).r;
  if (near >= 1.0) discard;
  gl_FragDepth = near;
  gl_FragData[0] = vec4(texture(picture, texCoord).rgb, opacity);
})";
  const ScreenQuad::Texture textures[] = {{"picture", color_}, {"depth", depth_}};
  quad_->draw(
      window, k_shader, width_, height_, textures, ScreenQuad::Depth::tested,
      [opacity](vtkShaderProgram& program) { program.SetUniformf("opacity", static_cast<float>(opacity)); });
}

void PictureCache::release() {
  if (framebuffer_ != 0) {
    glDeleteFramebuffers(1, &framebuffer_);
    glDeleteTextures(1, &color_);
    glDeleteTextures(1, &depth_);
  }
  framebuffer_ = color_ = depth_ = 0;
  is_filled_ = false;
}

void PictureCache::swap(PictureCache& other) noexcept {
  std::swap(quad_, other.quad_);
  std::swap(framebuffer_, other.framebuffer_);
  std::swap(color_, other.color_);
  std::swap(depth_, other.depth_);
  std::swap(width_, other.width_);
  std::swap(height_, other.height_);
  std::swap(depth_format_, other.depth_format_);
  std::swap(is_filled_, other.is_filled_);
}

}  // namespace trephine::view
