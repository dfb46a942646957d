#include "volume/local_net.h"

namespace trephine::volume {

/// The vertex of the cell's patch that holds one of its edges.
glm::vec3 LocalNet::vertex(const glm::ivec3& cell, int edge) const noexcept {
  const int bits = config(cell);
  const NetCase* net = &k_net_cases[0][static_cast<std::size_t>(bits)];
  if (net->pinch_face >= 0) {
    glm::ivec3 other = cell;
    other[net->pinch_face / 2] += net->pinch_face % 2 ? 1 : -1;
    if (k_net_cases[0][static_cast<std::size_t>(config(other))].pinch_face == (net->pinch_face ^ 1))
      net = &k_net_cases[1][static_cast<std::size_t>(bits)];
  }
  std::array<glm::vec3, 4> all;
  vertices_.place(cell, *net, all.data());
  return all[net->patch_of_edge[static_cast<std::size_t>(edge)]];
}

NetQuad LocalNet::quad(const glm::ivec3& low, int axis) const noexcept {
  // The four cells around the edge, counter-clockwise seen from its high end.
  const int first = (axis + 1) % 3, second = (axis + 2) % 3;
  NetQuad quad;
  const int corners[4] = {1 << first | 1 << second, 1 << second, 0, 1 << first};
  for (std::size_t i = 0; i < 4; ++i) {
    const int corner = corners[i];
    const glm::ivec3 cell = low - glm::ivec3(corner & 1, corner >> 1 & 1, corner >> 2 & 1);
    quad.corners[i] = vertex(cell, net_edge(axis, corner));
  }
  // Solid at the low end faces its high end; else turned round.
  if (!is_solid(low)) std::swap(quad.corners[1], quad.corners[3]);
  return quad;
}

}  // namespace trephine::volume
