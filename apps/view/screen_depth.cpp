#include "apps/view/screen_depth.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/mat3x3.hpp>
#include <utility>
#include <vector>
#include <vtkCamera.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtk_glew.h>

#include "haptics/depth/depth_rules.h"

namespace trephine::view {

using glm::dvec3;
using glm::ivec2;
using haptics::depth::DepthCamera;
using haptics::depth::DepthPicture;

namespace {

constexpr int k_max = 160;  // pixels, largest width and height: the picture must fit into a command

/// Converts the camera of the window to a camera of depth pictures (x right, y down, z ahead) with all pixels
/// of the window, and its pose.
std::pair<DepthCamera, haptics::Placement> camera_of(vtkCamera* camera, const int* size) {
  double at[3], ahead[3], up[3];
  camera->GetPosition(at);
  camera->GetDirectionOfProjection(ahead);
  camera->OrthogonalizeViewUp();
  camera->GetViewUp(up);
  const dvec3 z(ahead[0], ahead[1], ahead[2]), y = -dvec3(up[0], up[1], up[2]);
  DepthCamera whole;
  whole.width = size[0], whole.height = size[1];
  whole.fx = whole.fy = 0.5 * size[1] / std::tan(0.5 * camera->GetViewAngle() * 3.14159265358979 / 180);
  whole.cx = 0.5 * (size[0] - 1), whole.cy = 0.5 * (size[1] - 1);
  haptics::Placement placement;
  placement.position_world = {at[0], at[1], at[2]};
  placement.rotation = glm::normalize(glm::quat_cast(glm::dmat3(glm::normalize(glm::cross(y, z)), y, z)));
  return {whole, placement};
}

}  // namespace

void ScreenDepth::read_before(vtkRenderer* renderer, vtkRenderWindow* window) {
  ++counters_.draws;
  is_reading_ = false;
  if (!request_ || pending_) return;
  const Request request = *std::exchange(request_, std::nullopt);
  vtkCamera* camera = renderer->GetActiveCamera();
  const auto [whole, placement] = camera_of(camera, window->GetSize());
  const dvec3 p = placement.local_from_world(request.at);
  if (!(p.z > 0)) return;
  const double column = whole.fx * p.x / p.z + whole.cx, row = whole.fy * p.y / p.z + whole.cy;
  // Half the cube's diagonal, which covers any orientation.
  const double reach = 0.87 * request.edge / p.z * whole.fx + 2;
  const auto range = [&](double middle, int count, int& first, int& number) {
    const double half = std::min(reach, 0.5 * (k_max - 1));
    first = static_cast<int>(std::clamp(std::floor(middle - half), 0.0, 1.0 * count));
    const int last = static_cast<int>(std::clamp(std::ceil(middle + half), -1.0, count - 1.0));
    number = std::min(k_max, last - first + 1);
  };
  int left = 0, top = 0, columns = 0, rows = 0;
  range(column, whole.width, left, columns);
  range(row, whole.height, top, rows);
  if (columns < 4 || rows < 4) return;
  Reading reading{{}, request.at, request.edge};
  reading.picture.camera = {columns, rows, whole.fx, whole.fy, whole.cx - left, whole.cy - top};
  reading.picture.placement = placement;
  camera->GetClippingRange(near_, far_);
  corner_ = {left, whole.height - top - rows};
  pending_ = std::move(reading);
  is_reading_ = true;
  read(0);
}

void ScreenDepth::read_after(vtkRenderer*, vtkRenderWindow*) {
  if (!is_reading_) return;
  is_reading_ = false;
  read(1);
  fence_ = glFenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
  ++counters_.reads;
}

/// Starts to copy the depth into a buffer in graphics memory: 0 before, 1 after the scenery. Restores every
/// binding.
void ScreenDepth::read(std::size_t buffer) {
  const DepthCamera& c = pending_->picture.camera;
  GLint from = 0, to = 0, pack = 0, alignment = 4;
  glGetIntegerv(GL_READ_FRAMEBUFFER_BINDING, &from);
  glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &to);
  glGetIntegerv(GL_PIXEL_PACK_BUFFER_BINDING, &pack);
  glGetIntegerv(GL_PACK_ALIGNMENT, &alignment);
  if (buffers_[buffer] == 0) glGenBuffers(1, &buffers_[buffer]);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, static_cast<GLuint>(to));
  glBindBuffer(GL_PIXEL_PACK_BUFFER, buffers_[buffer]);
  glBufferData(GL_PIXEL_PACK_BUFFER, static_cast<GLsizeiptr>(sizeof(float)) * c.width * c.height, nullptr,
               GL_STREAM_READ);
  glPixelStorei(GL_PACK_ALIGNMENT, 4);
  glReadPixels(corner_.x, corner_.y, c.width, c.height, GL_DEPTH_COMPONENT, GL_FLOAT, nullptr);
  glPixelStorei(GL_PACK_ALIGNMENT, alignment);
  glBindBuffer(GL_PIXEL_PACK_BUFFER, static_cast<GLuint>(pack));
  glBindFramebuffer(GL_READ_FRAMEBUFFER, static_cast<GLuint>(from));
}

std::optional<ScreenDepth::Reading> ScreenDepth::take_result() {
  if (!pending_ || fence_ == nullptr) return std::nullopt;
  if (glClientWaitSync(static_cast<GLsync>(fence_), GL_SYNC_FLUSH_COMMANDS_BIT, 0) == GL_TIMEOUT_EXPIRED)
    return std::nullopt;
  glDeleteSync(static_cast<GLsync>(std::exchange(fence_, nullptr)));
  Reading reading = *std::exchange(pending_, std::nullopt);
  const DepthCamera& c = reading.picture.camera;
  const auto count = static_cast<std::size_t>(c.width) * static_cast<std::size_t>(c.height);
  std::array<std::vector<float>, 2> read;
  GLint pack = 0;
  glGetIntegerv(GL_PIXEL_PACK_BUFFER_BINDING, &pack);
  for (std::size_t buffer = 0; buffer < 2; ++buffer) {
    read[buffer].resize(count);
    glBindBuffer(GL_PIXEL_PACK_BUFFER, buffers_[buffer]);
    glGetBufferSubData(GL_PIXEL_PACK_BUFFER, 0, static_cast<GLsizeiptr>(sizeof(float) * count),
                       read[buffer].data());
  }
  glBindBuffer(GL_PIXEL_PACK_BUFFER, static_cast<GLuint>(pack));
  // Scenery is visible where drawing it decreased the depth. OpenGL stores rows from the bottom up.
  std::vector<double> depths(count, 0);
  for (int row = 0; row < c.height; ++row)
    for (int column = 0; column < c.width; ++column) {
      const auto at = [&](int r) {
        return static_cast<std::size_t>(column) +
               static_cast<std::size_t>(c.width) * static_cast<std::size_t>(r);
      };
      const std::size_t from = at(c.height - 1 - row);
      if (read[1][from] < read[0][from])
        depths[at(row)] =
            haptics::depth::perspective_distance(near_, far_, static_cast<double>(read[1][from]));
    }
  reading.picture.set_depths(depths);
  reading.edge = std::min(reading.edge, reading.picture.known_cube_edge(reading.at));
  return reading;
}

void ScreenDepth::release() {
  if (fence_ != nullptr) glDeleteSync(static_cast<GLsync>(std::exchange(fence_, nullptr)));
  glDeleteBuffers(2, buffers_.data());
  buffers_ = {};
  pending_.reset();
}

}  // namespace trephine::view
