// NetCase: surface patches of the 256 configurations of a cell. Corner i is at (i & 1, i >> 1 & 1,
// i >> 2 & 1); edge 4 * axis + k is parallel to `axis` and starts at the corner with the bits of k as its
// other two coordinates (in ascending axis order).
#pragma once

#include <array>
#include <cstdint>

namespace trephine::volume {

struct NetCase {
  std::uint16_t edges = 0;                       ///< bits of the crossed edges (with one solid end)
  std::uint8_t patch_count = 0;                  ///< 0..4
  std::array<std::uint8_t, 12> patch_of_edge{};  ///< patch of each crossed edge
  std::int8_t pinch_face = -1;                   ///< ambiguous face that meets one patch twice, or -1
  std::array<float, 3> corner_sum{};             ///< sum over all crossed edges of their fixed coordinates
  float inverse_count = 0;                       ///< 1 / number of crossed edges
};

/// Lower corner of an edge.
constexpr int net_edge_corner(int edge) {
  const int axis = edge / 4, k = edge % 4;
  const int b = axis == 0 ? 1 : 0, c = axis == 2 ? 1 : 2;
  return (k & 1) << b | (k >> 1) << c;
}
/// Edge parallel to `axis` at a corner.
constexpr int net_edge(int axis, int corner) {
  const int b = axis == 0 ? 1 : 0, c = axis == 2 ? 1 : 2;
  return 4 * axis + ((corner >> b & 1) | (corner >> c & 1) << 1);
}

/// Builds the case of a configuration. Faces are numbered 2 * axis + side. The two crossed edges of a face
/// belong to one patch. On an ambiguous face (four crossings) the two edges at each solid corner belong to
/// one patch; on `flipped_face`, the two edges at each air corner.
constexpr NetCase make_net_case(int config, int flipped_face) {
  NetCase result;
  std::array<int, 12> parent{};
  for (int e = 0; e < 12; ++e) {
    parent[static_cast<std::size_t>(e)] = e;
    const int corner = net_edge_corner(e);
    if ((config >> corner & 1) != (config >> (corner | 1 << e / 4) & 1))
      result.edges |= static_cast<std::uint16_t>(1 << e);
  }
  const auto root = [&parent](int e) {
    while (parent[static_cast<std::size_t>(e)] != e) e = parent[static_cast<std::size_t>(e)];
    return e;
  };
  std::array<std::array<int, 2>, 6> ambiguous{};  // an edge of each of the two segments
  std::array<bool, 6> is_ambiguous{};
  for (int face = 0; face < 6; ++face) {
    const int axis = face / 2, b = axis == 0 ? 1 : 0, c = axis == 2 ? 1 : 2;
    const int base = (face & 1) << axis;
    const std::array<int, 4> corners{base, base | 1 << b, base | 1 << b | 1 << c,
                                     base | 1 << c};  // around the face
    const std::array<int, 4> edges{net_edge(b, corners[0]), net_edge(c, corners[1]), net_edge(b, corners[3]),
                                   net_edge(c, corners[0])};  // edge i joins corner i and i + 1
    int crossed = 0;
    for (const int e : edges) crossed += result.edges >> e & 1;
    if (crossed == 2) {
      int first = -1;
      for (const int e : edges) {
        if (!(result.edges >> e & 1)) continue;
        if (first < 0)
          first = e;
        else
          parent[static_cast<std::size_t>(root(e))] = root(first);
      }
    } else if (crossed == 4) {
      // Joins the two edges at each corner of the separated kind.
      const int separated = face == flipped_face ? 0 : 1;
      const std::size_t start = (config >> corners[0] & 1) == separated ? 0 : 1;
      for (std::size_t i = start; i < 4; i += 2) {
        const int before = edges[(i + 3) % 4], after = edges[i];
        parent[static_cast<std::size_t>(root(before))] = root(after);
      }
      is_ambiguous[static_cast<std::size_t>(face)] = true;
      ambiguous[static_cast<std::size_t>(face)] = {edges[start], edges[start + 2 < 4 ? start + 2 : 0]};
    }
  }
  std::array<int, 12> number{};
  for (int& n : number) n = -1;
  int count = 0;
  for (int e = 0; e < 12; ++e) {
    if (!(result.edges >> e & 1)) continue;
    int& n = number[static_cast<std::size_t>(root(e))];
    if (n < 0) n = result.patch_count++;
    result.patch_of_edge[static_cast<std::size_t>(e)] = static_cast<std::uint8_t>(n);
    const int corner = net_edge_corner(e);
    for (int a = 0; a < 3; ++a)
      result.corner_sum[static_cast<std::size_t>(a)] += static_cast<float>(corner >> a & 1);
    ++count;
  }
  if (count > 0) result.inverse_count = 1.0f / static_cast<float>(count);
  for (int face = 0; face < 6; ++face) {
    const auto& [p, q] = ambiguous[static_cast<std::size_t>(face)];
    if (is_ambiguous[static_cast<std::size_t>(face)] && root(p) == root(q))
      result.pinch_face = static_cast<std::int8_t>(face);
  }
  return result;
}

/// [0]: separates solid corners on every ambiguous face. [1]: separates air corners on the pinching face.
using NetCases = std::array<std::array<NetCase, 256>, 2>;

constexpr NetCases make_net_cases() {
  NetCases cases{};
  for (int config = 0; config < 256; ++config) {
    const auto i = static_cast<std::size_t>(config);
    cases[0][i] = make_net_case(config, -1);
    cases[1][i] = make_net_case(config, cases[0][i].pinch_face);
  }
  return cases;
}

inline constexpr NetCases k_net_cases = make_net_cases();

}  // namespace trephine::volume
