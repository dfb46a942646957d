// copy_framebuffer(): copies between framebuffers of OpenGL.
#pragma once

#include <glm/vec2.hpp>

namespace trephine::view {

/// Copies a whole framebuffer to another one, scaled if the sizes (pixels) differ: colours, and the depths if
/// `has_depth`, which requires equal sizes. Restores the bindings, because VTK caches them. Requires a
/// current GL context.
void copy_framebuffer(unsigned from, const glm::ivec2& from_size, unsigned to, const glm::ivec2& to_size,
                      bool has_depth);

}  // namespace trephine::view
