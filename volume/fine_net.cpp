#include "volume/fine_net.h"

#include <algorithm>
#include <glm/common.hpp>
#include <tuple>

#include "volume/surface_net_vertices.h"

namespace trephine::volume {

using glm::ivec3;

namespace {

constexpr std::uint32_t k_none = ~std::uint32_t{0};

ivec3 unit(int axis) {
  ivec3 v(0);
  v[axis] = 1;
  return v;
}
ivec3 corner(int i) { return {i & 1, i >> 1 & 1, i >> 2 & 1}; }

/// Floor of a / b for b > 0, per axis.
ivec3 floor_divided(const ivec3& a, const ivec3& b) {
  ivec3 q;
  for (int i = 0; i < 3; ++i) q[i] = a[i] >= 0 ? a[i] / b[i] : -((-a[i] + b[i] - 1) / b[i]);
  return q;
}

/// Between a and b; either of them to the bit at its end, so that neighbours agree on what they share.
double between(double a, double b, int i, int k) {
  if (i == 0) return a;
  return i == k ? b : a + static_cast<double>(i) / k * (b - a);
}

/// The field at lattice sample `in` of a fine cell.
double field_at(const std::array<double, 8>& g, const ivec3& in, const ivec3& k) {
  const double c00 = between(g[0], g[1], in.x, k.x), c10 = between(g[2], g[3], in.x, k.x);
  const double c01 = between(g[4], g[5], in.x, k.x), c11 = between(g[6], g[7], in.x, k.x);
  return between(between(c00, c10, in.y, k.y), between(c01, c11, in.y, k.y), in.z, k.z);
}

}  // namespace

FineNet::FineNet(const SurfaceSource& source, const VoxelBox& owned)
    : source_(source),
      volume_(source.field->volume()),
      version_(*source.version),
      lattice_(source.version->lattice()),
      owned_(owned),
      k_(lattice_.per_voxel()),
      origin_(lattice_.centre_of(ivec3(0))) {
  // Cells of polygons are one below those that are owned; cases ask one cell on, and whether that is fine one
  // more.
  constexpr int k_reach = 3;
  find_fine_cells({owned.low - k_reach, owned.high + k_reach});
  for (Block& block : storage_)
    if (VoxelBox{owned.low - 2, owned.high + 2}.contains(block.cell)) fill(block);
}

bool FineNet::exists(const ivec3& cell) const noexcept {
  const int border = source_.is_open ? 0 : -1;
  for (int a = 0; a < 3; ++a)
    if (cell[a] < border || cell[a] > volume_.size[a] - 2 - border) return false;
  return true;
}

void FineNet::find_fine_cells(const VoxelBox& reach) {
  const ivec3 low = glm::max(reach.low, ivec3(-1)), high = glm::min(reach.high, volume_.size - 1);
  version_.for_bricks_in(origin_ + low * k_, origin_ + (high + 1) * k_,
                         [&](const ivec3& s, const Brick& brick) {
                           // A cell with hollow bricks alone is all air, whichever way it is looked at.
                           if (brick.is_hollow) return;
                           const ivec3 from = glm::max(floor_divided(s - origin_ + (k_ - 1), k_) - 1, low),
                                       to = glm::min(floor_divided(s + (k_brick - 1) - origin_, k_), high);
                           for (int z = from.z; z <= to.z; ++z)
                             for (int y = from.y; y <= to.y; ++y)
                               for (int x = from.x; x <= to.x; ++x) {
                                 if (!blocks_.emplace(key({x, y, z}), storage_.size()).second) continue;
                                 Block block;
                                 block.cell = {x, y, z};
                                 storage_.push_back(std::move(block));
                               }
                         });
  for (const Block& block : storage_)
    for (int i = 0; i < 27; ++i) {
      const ivec3 cell = block.cell + ivec3(i % 3, i / 3 % 3, i / 9) - 1;
      if (!is_fine(cell)) beside_.insert(key(cell));
    }
}

ivec3 FineNet::cell_of(const ivec3& lattice_cell) const noexcept {
  return floor_divided(lattice_cell - origin_, k_);
}

std::array<double, 8> FineNet::field_corners(const ivec3& cell) const {
  std::array<double, 8> g;
  for (int i = 0; i < 8; ++i) {
    const ivec3 v = cell + corner(i);
    g[static_cast<std::size_t>(i)] = source_.field->at(v.x, v.y, v.z);
  }
  return g;
}

void FineNet::fill(Block& block) const {
  block.corners = field_corners(block.cell);
  block.solid.resize(static_cast<std::size_t>((k_.x + 1) * (k_.y + 1) * (k_.z + 1)));
  const ivec3 low = origin_ + block.cell * k_;
  const bool is_field_air =
      std::all_of(block.corners.begin(), block.corners.end(), [](double g) { return g < 0; });
  if (is_field_air) return;
  for (int z = 0; z <= k_.z; ++z)
    for (int y = 0; y <= k_.y; ++y)
      for (int x = 0; x <= k_.x; ++x)
        block.solid[sample_index({x, y, z})] =
            field_at(block.corners, {x, y, z}, k_) >= 0 && version_.distance_of(low + ivec3(x, y, z)) > 0;
  keep_ambiguous_faces_apart(block);
}

/// On a face shared with a coarse cell, where two solid corners lie across from each other: solid samples
/// inside it belong to the corner in whose quarter they lie, and none lie in its middle.
void FineNet::keep_ambiguous_faces_apart(Block& block) const {
  for (int face = 0; face < 6; ++face) {
    const int axis = face / 2, side = face % 2, p = (axis + 1) % 3, q = (axis + 2) % 3;
    if (is_fine(block.cell + (side ? 1 : -1) * unit(axis))) continue;
    const auto at = [&](int i, int j) {
      ivec3 in(0);
      in[axis] = side * k_[axis], in[p] = i, in[q] = j;
      return sample_index(in);
    };
    bool is_solid[2][2];
    for (int j = 0; j < 2; ++j)
      for (int i = 0; i < 2; ++i) is_solid[j][i] = block.solid[at(i * k_[p], j * k_[q])] != 0;
    if (is_solid[0][0] != is_solid[1][1] || is_solid[0][1] != is_solid[1][0] ||
        is_solid[0][0] == is_solid[0][1])
      continue;
    for (int j = 1; j < k_[q]; ++j)
      for (int i = 1; i < k_[p]; ++i) {
        const int half_p = (k_[p] - 1) / 2, half_q = (k_[q] - 1) / 2;
        const bool is_middle = (i == half_p || i == half_p + 1) && (j == half_q || j == half_q + 1);
        if (is_middle || !is_solid[j > half_q][i > half_p]) block.solid[at(i, j)] = 0;
      }
  }
}

const FineNet::Block* FineNet::block_of(const ivec3& lattice_cell) const {
  const auto found = blocks_.find(key(cell_of(lattice_cell)));
  return found == blocks_.end() ? nullptr : &storage_[found->second];
}

int FineNet::config_of(const ivec3& lattice_cell) const {
  const Block& block = *block_of(lattice_cell);
  const ivec3 in = lattice_cell - origin_ - block.cell * k_;
  int config = 0;
  for (int i = 0; i < 8; ++i) config |= block.solid[sample_index(in + corner(i))] << i;
  return config;
}

/// On the face of coarse cell `cell`, which pinches there: the lattice cell beyond it that pinches there too.
/// Solid stretches along two of the face's edges can meet in a lattice face at one of its air corners alone;
/// of two such cells the first is turned, which parts the coarse cell's patch.
bool FineNet::find_turned(const ivec3& cell, int face, ivec3& lattice_cell) const {
  const int axis = face / 2, side = face % 2, p = (axis + 1) % 3, q = (axis + 2) % 3;
  const ivec3 beyond = cell + (side ? 1 : -1) * unit(axis);
  const auto found = blocks_.find(key(beyond));
  if (found == blocks_.end() || storage_[found->second].solid.empty()) return false;
  for (int i = 0; i < 4; ++i) {
    ivec3 in(0);
    in[axis] = side ? 0 : k_[axis] - 1;
    in[p] = i & 1 ? k_[p] - 1 : 0, in[q] = i & 2 ? k_[q] - 1 : 0;
    lattice_cell = origin_ + beyond * k_ + in;
    if (k_net_cases[0][static_cast<std::size_t>(config_of(lattice_cell))].pinch_face == (face ^ 1))
      return true;
  }
  return false;
}

const NetCase& FineNet::coarse_case(const ivec3& cell, int config) const {
  const NetCase& plain = k_net_cases[0][static_cast<std::size_t>(config)];
  ivec3 turned;
  return find_turned(cell, plain.pinch_face, turned) ? k_net_cases[1][static_cast<std::size_t>(config)]
                                                     : plain;
}

/// As in the net of the voxels: an ambiguous face separates air instead of solid when both its cells would
/// pinch there.
const NetCase& FineNet::case_of(const ivec3& lattice_cell, int config) const {
  const NetCase& plain = k_net_cases[0][static_cast<std::size_t>(config)];
  if (plain.pinch_face < 0) return plain;
  const ivec3 other = lattice_cell + (plain.pinch_face % 2 ? 1 : -1) * unit(plain.pinch_face / 2);
  if (block_of(other) == nullptr) {
    const ivec3 coarse = cell_of(other);
    const auto is_kept = [this](const ivec3& v) {
      return source_.field->at(v.x, v.y, v.z) >= 0 && version_.distance_at(v.x, v.y, v.z) > 0;
    };
    int corners = 0;
    for (int i = 0; i < 8; ++i) corners |= static_cast<int>(is_kept(coarse + corner(i))) << i;
    const int face = k_net_cases[0][static_cast<std::size_t>(corners)].pinch_face;
    ivec3 turned;
    const bool is_turned =
        face == (plain.pinch_face ^ 1) && find_turned(coarse, face, turned) && turned == lattice_cell;
    return k_net_cases[is_turned ? 1 : 0][static_cast<std::size_t>(config)];
  }
  const bool is_pinched_too =
      k_net_cases[0][static_cast<std::size_t>(config_of(other))].pinch_face == (plain.pinch_face ^ 1);
  return k_net_cases[is_pinched_too ? 1 : 0][static_cast<std::size_t>(config)];
}

void FineNet::place(Block& block, std::uint32_t first_id, std::vector<glm::vec3>& vertices) const {
  block.first.assign(static_cast<std::size_t>(k_.x * k_.y * k_.z), k_none);
  const ivec3 low = origin_ + block.cell * k_;
  for (int z = 0; z < k_.z; ++z)
    for (int y = 0; y < k_.y; ++y)
      for (int x = 0; x < k_.x; ++x) {
        const ivec3 in(x, y, z);
        const int config = config_of(low + in);
        if (config == 0 || config == 255) continue;
        const NetCase& net = case_of(low + in, config);
        float g[8], d[8];
        for (int i = 0; i < 8; ++i) {
          g[i] = static_cast<float>(field_at(block.corners, in + corner(i), k_));
          d[i] = static_cast<float>(version_.distance_of(low + in + corner(i)));
        }
        std::array<glm::vec3, 4> out;
        place_patches(g, d, true, config, net, true, out.data());
        block.first[lattice_index(in)] = first_id + static_cast<std::uint32_t>(vertices.size());
        for (std::size_t k = 0; k < net.patch_count; ++k)
          vertices.emplace_back(glm::vec3(block.cell) + (glm::vec3(in) + out[k]) / glm::vec3(k_));
      }
}

std::uint32_t FineNet::coarse_vertex(const ivec3& cell, const Edge& edge,
                                     const CoarseVertices& coarse) const {
  const CoarseVertex& vertex = coarse.at(key(cell));
  const ivec3 u = edge.low - origin_ - cell * k_;
  const int a = edge.axis, b = (a + 1) % 3, c = (a + 2) % 3;
  const auto is_end = [&](int axis) { return u[axis] == 0 || u[axis] == k_[axis]; };
  int of_edge = 0;
  if (is_end(b) && is_end(c)) {
    of_edge = net_edge(a, (u[b] == k_[b]) << b | (u[c] == k_[c]) << c);
  } else {
    // Inside a face: the curve that the edge crosses there meets two of the face's own edges.
    const int across = is_end(b) ? b : c, q = is_end(b) ? c : b;
    const int side = (u[across] == k_[across]) << across;
    const int along[4] = {net_edge(a, side), net_edge(a, side | 1 << q), net_edge(q, side),
                          net_edge(q, side | 1 << a)};
    int crossed = 0;
    for (const int e : along)
      if (vertex.net->edges >> e & 1) ++crossed, of_edge = e;
    if (crossed == 4) {
      // Two curves, each around a solid corner: that in whose quarter the solid end lies.
      const int solid_end = u[a] + (is_solid(edge.low) ? 0 : 1);
      const int upper_a = solid_end > (k_[a] - 1) / 2;
      int upper_q = u[q] > (k_[q] - 1) / 2;
      // On one of the face's edges it belongs to that edge's solid corner, however far from it.
      if (solid_end == 0 || solid_end == k_[a]) {
        ivec3 low_corner = edge.low;
        low_corner[a] += solid_end - u[a];
        low_corner[q] -= u[q];
        upper_q = !is_solid(low_corner);
      }
      of_edge = net_edge(a, side | upper_a << a | upper_q << q);
      // On a face on which the cell is turned, the curve of all inner edges leads to the other air corner.
      const int face = 2 * across + (side != 0);
      const std::ptrdiff_t config = vertex.net - k_net_cases[1].data();
      const bool is_turned =
          config >= 0 && config < 256 && k_net_cases[0][static_cast<std::size_t>(config)].pinch_face == face;
      if (ivec3 turned; is_turned && find_turned(cell, face, turned)) {
        const ivec3 from = origin_ + cell * k_;
        const int air_a = turned[a] > from[a] + k_[a] / 2;
        // The edge along a at the solid corner touches that air corner where both lie on its line.
        if (air_a != upper_a) of_edge = net_edge(q, side | upper_a << a | upper_q << q);
      }
    }
  }
  return vertex.first + vertex.net->patch_of_edge[static_cast<std::size_t>(of_edge)];
}

bool FineNet::is_solid(const ivec3& sample) const {
  // A sample on a border belongs to several cells; any fine one will do.
  for (int i = 0; i < 8; ++i)
    if (const Block* block = block_of(sample - corner(i)); block && !block->solid.empty())
      return block->solid[sample_index(sample - origin_ - block->cell * k_)] != 0;
  return false;
}

void FineNet::add_polygon(const Edge& edge, const CoarseVertices& coarse,
                          std::vector<std::uint32_t>& triangles) const {
  const int first = (edge.axis + 1) % 3, second = (edge.axis + 2) % 3;
  // The four cells around it, counter-clockwise seen from its high end.
  const ivec3 steps[4] = {unit(first) + unit(second), unit(second), ivec3(0), unit(first)};
  std::array<std::uint32_t, 4> ids;
  std::size_t count = 0;
  for (const ivec3& step : steps) {
    const ivec3 lattice_cell = edge.low - step, cell = cell_of(lattice_cell);
    if (!exists(cell)) return;
    std::uint32_t id = 0;
    if (const Block* block = block_of(lattice_cell)) {
      const ivec3 in = lattice_cell - origin_ - cell * k_;
      const NetCase& net = case_of(lattice_cell, config_of(lattice_cell));
      const ivec3 u = edge.low - lattice_cell;
      id = block->first[lattice_index(in)] +
           net.patch_of_edge[static_cast<std::size_t>(net_edge(edge.axis, u.x | u.y << 1 | u.z << 2))];
    } else {
      id = coarse_vertex(cell, edge, coarse);
    }
    if (count == 0 || ids[count - 1] != id) ids[count++] = id;
  }
  if (count > 1 && ids[count - 1] == ids[0]) --count;
  if (count < 3) return;
  // Solid at the low end faces its high end; else turned round.
  if (!is_solid(edge.low)) std::reverse(ids.begin(), ids.begin() + static_cast<std::ptrdiff_t>(count));
  for (std::size_t i = 2; i < count; ++i) triangles.insert(triangles.end(), {ids[0], ids[i - 1], ids[i]});
}

void FineNet::make(const CoarseVertices& coarse, std::uint32_t first_id, std::vector<glm::vec3>& vertices,
                   std::vector<std::uint32_t>& triangles) {
  const auto is_within = [&](const ivec3& cell, int more) {
    return VoxelBox{owned_.low - more, owned_.high + more}.contains(cell);
  };
  for (Block& block : storage_)
    if (is_within(block.cell, 1)) place(block, first_id, vertices);

  // Edges by the voxel from which they start, or on whose lower faces they lie.
  std::unordered_map<std::uint64_t, ivec3> voxels;
  for (const Block& block : storage_)
    for (int i = 0; i < 8; ++i)
      if (const ivec3 v = block.cell + corner(i); owned_.contains(v)) voxels.emplace(key(v), v);
  std::vector<ivec3> order;
  order.reserve(voxels.size());
  for (const auto& [unused, v] : voxels) order.push_back(v);
  std::sort(order.begin(), order.end(),
            [](const ivec3& a, const ivec3& b) { return std::tie(a.z, a.y, a.x) < std::tie(b.z, b.y, b.x); });
  for (const ivec3& v : order)
    for (int axis = 0; axis < 3; ++axis) {
      const int b = (axis + 1) % 3, c = (axis + 2) % 3;
      const ivec3 low = origin_ + v * k_;
      // The fine cell through which an edge is looked at: with ub, uc = 0 any around it, else one next to its
      // face.
      const auto block = [&](const ivec3& cell) { return block_of(origin_ + cell * k_); };
      const Block *here = block(v), *below_b = block(v - unit(b)), *below_c = block(v - unit(c)),
                  *below = block(v - unit(b) - unit(c));
      for (int uc = 0; uc < k_[c]; ++uc)
        for (int ub = 0; ub < k_[b]; ++ub) {
          const Block* seen = here;
          if (!seen && ub == 0) seen = below_b;
          if (!seen && uc == 0) seen = below_c;
          if (!seen && ub == 0 && uc == 0) seen = below;
          if (!seen) continue;
          ivec3 u(0);
          u[b] = ub, u[c] = uc;
          ivec3 in = low + u - origin_ - seen->cell * k_;
          const std::size_t step = axis == 0   ? 1
                                   : axis == 1 ? static_cast<std::size_t>(k_.x + 1)
                                               : static_cast<std::size_t>((k_.x + 1) * (k_.y + 1));
          const std::uint8_t* solid = seen->solid.data() + sample_index(in);
          for (int t = 0; t < k_[axis]; ++t, solid += step) {
            if (solid[0] == solid[step]) continue;
            u[axis] = t;
            add_polygon({low + u, axis}, coarse, triangles);
          }
        }
    }
}

}  // namespace trephine::volume
