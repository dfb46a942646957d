#include "volume/surface/fine_net.h"

#include <algorithm>
#include <glm/common.hpp>
#include <tuple>

#include "volume/surface/surface_net_vertices.h"

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

/// Interpolates between a (i = 0) and b (i = k); exact at both ends, so that neighbours share equal samples.
double between(double a, double b, int i, int k) {
  if (i == 0) return a;
  return i == k ? b : a + static_cast<double>(i) / k * (b - a);
}

/// Field at the lattice sample with this offset in a fine cell. `g`: field at the corners of the cell.
double field_at(const std::array<double, 8>& g, const ivec3& offset, const ivec3& k) {
  const double c00 = between(g[0], g[1], offset.x, k.x), c10 = between(g[2], g[3], offset.x, k.x);
  const double c01 = between(g[4], g[5], offset.x, k.x), c11 = between(g[6], g[7], offset.x, k.x);
  return between(between(c00, c10, offset.y, k.y), between(c01, c11, offset.y, k.y), offset.z, k.z);
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
  // A polygon needs the cells next to the owned ones. The net cases of these cells need the samples of the
  // next cells. Those samples depend on which neighbours of the next cells are fine: three cells in total.
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
                           // A cell with only hollow bricks is air, whether fine or coarse.
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
      if (!is_fine(cell)) adjacent_.insert(key(cell));
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
            field_at(block.corners, {x, y, z}, k_) >= 0 && version_.sample_distance(low + ivec3(x, y, z)) > 0;
  separate_ambiguous_faces(block);
}

/// Separates solid samples on ambiguous faces shared with a coarse cell: inside the face, samples stay solid
/// only in the quadrants of solid corners, and not in the middle.
void FineNet::separate_ambiguous_faces(Block& block) const {
  for (int face = 0; face < 6; ++face) {
    const int axis = face / 2, side = face % 2, p = (axis + 1) % 3, q = (axis + 2) % 3;
    if (is_fine(block.cell + (side ? 1 : -1) * unit(axis))) continue;
    const auto at = [&](int i, int j) {
      ivec3 offset(0);
      offset[axis] = side * k_[axis], offset[p] = i, offset[q] = j;
      return sample_index(offset);
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
  const auto entry = blocks_.find(key(cell_of(lattice_cell)));
  return entry == blocks_.end() ? nullptr : &storage_[entry->second];
}

int FineNet::config_of(const ivec3& lattice_cell) const {
  const Block& block = *block_of(lattice_cell);
  const ivec3 offset = lattice_cell - origin_ - block.cell * k_;
  int config = 0;
  for (int i = 0; i < 8; ++i) config |= block.solid[sample_index(offset + corner(i))] << i;
  return config;
}

/// Finds the lattice cell that is flipped (separates air instead of solid) at face `face` of coarse cell
/// `cell`. Requires that the net of the coarse cell touches itself (a pinch) at this face. The lattice cell
/// is on the other side of the face, and its net touches itself there too. It is at one of the two air
/// corners of `face`: only there can solid samples along two edges of `face` be on opposite corners of a
/// lattice face. If the nets of two lattice cells touch themselves, only the first is flipped, which is
/// enough to separate the patch of the coarse cell.
bool FineNet::find_flipped(const ivec3& cell, int face, ivec3& lattice_cell) const {
  const int axis = face / 2, side = face % 2, p = (axis + 1) % 3, q = (axis + 2) % 3;
  const ivec3 neighbour = cell + (side ? 1 : -1) * unit(axis);
  const auto entry = blocks_.find(key(neighbour));
  if (entry == blocks_.end() || storage_[entry->second].solid.empty()) return false;
  for (int i = 0; i < 4; ++i) {
    ivec3 offset(0);
    offset[axis] = side ? 0 : k_[axis] - 1;
    offset[p] = i & 1 ? k_[p] - 1 : 0, offset[q] = i & 2 ? k_[q] - 1 : 0;
    lattice_cell = origin_ + neighbour * k_ + offset;
    if (k_net_cases[0][static_cast<std::size_t>(config_of(lattice_cell))].pinch_face == (face ^ 1))
      return true;
  }
  return false;
}

const NetCase& FineNet::coarse_case(const ivec3& cell, int config) const {
  const NetCase& standard = k_net_cases[0][static_cast<std::size_t>(config)];
  ivec3 flipped;
  return find_flipped(cell, standard.pinch_face, flipped) ? k_net_cases[1][static_cast<std::size_t>(config)]
                                                          : standard;
}

/// As in the net of the voxels, an ambiguous face separates air instead of solid if both its cells would
/// pinch there.
const NetCase& FineNet::case_of(const ivec3& lattice_cell, int config) const {
  const NetCase& standard = k_net_cases[0][static_cast<std::size_t>(config)];
  if (standard.pinch_face < 0) return standard;
  const ivec3 other = lattice_cell + (standard.pinch_face % 2 ? 1 : -1) * unit(standard.pinch_face / 2);
  if (block_of(other) == nullptr) {
    const ivec3 coarse = cell_of(other);
    const auto is_kept = [this](const ivec3& v) {
      return source_.field->at(v.x, v.y, v.z) >= 0 && version_.voxel_distance(v.x, v.y, v.z) > 0;
    };
    int corners = 0;
    for (int i = 0; i < 8; ++i) corners |= static_cast<int>(is_kept(coarse + corner(i))) << i;
    const int face = k_net_cases[0][static_cast<std::size_t>(corners)].pinch_face;
    ivec3 flipped;
    const bool is_flipped =
        face == (standard.pinch_face ^ 1) && find_flipped(coarse, face, flipped) && flipped == lattice_cell;
    return k_net_cases[is_flipped ? 1 : 0][static_cast<std::size_t>(config)];
  }
  const bool is_pinched_too =
      k_net_cases[0][static_cast<std::size_t>(config_of(other))].pinch_face == (standard.pinch_face ^ 1);
  return k_net_cases[is_pinched_too ? 1 : 0][static_cast<std::size_t>(config)];
}

void FineNet::place_vertices(Block& block, std::uint32_t first_id, std::vector<glm::vec3>& vertices) const {
  block.first.assign(static_cast<std::size_t>(k_.x * k_.y * k_.z), k_none);
  const ivec3 low = origin_ + block.cell * k_;
  for (int z = 0; z < k_.z; ++z)
    for (int y = 0; y < k_.y; ++y)
      for (int x = 0; x < k_.x; ++x) {
        const ivec3 offset(x, y, z);
        const int config = config_of(low + offset);
        if (config == 0 || config == 255) continue;
        const NetCase& net = case_of(low + offset, config);
        float g[8], d[8];
        for (int i = 0; i < 8; ++i) {
          g[i] = static_cast<float>(field_at(block.corners, offset + corner(i), k_));
          d[i] = static_cast<float>(version_.sample_distance(low + offset + corner(i)));
        }
        std::array<glm::vec3, 4> out;
        place_patches(g, d, true, config, net, true, out.data());
        block.first[lattice_index(offset)] = first_id + static_cast<std::uint32_t>(vertices.size());
        for (std::size_t k = 0; k < net.patch_count; ++k)
          vertices.emplace_back(glm::vec3(block.cell) + (glm::vec3(offset) + out[k]) / glm::vec3(k_));
      }
}

std::uint32_t FineNet::coarse_vertex(const ivec3& cell, const Edge& edge,
                                     const CoarseVertices& coarse) const {
  const CoarseVertex& vertex = coarse.at(key(cell));
  const ivec3 u = edge.low - origin_ - cell * k_;
  const int a = edge.axis, b = (a + 1) % 3, c = (a + 2) % 3;
  const auto is_end = [&](int axis) { return u[axis] == 0 || u[axis] == k_[axis]; };
  int patch_edge = 0;
  if (is_end(b) && is_end(c)) {
    patch_edge = net_edge(a, (u[b] == k_[b]) << b | (u[c] == k_[c]) << c);
  } else {
    // Inside a face: the curve that the edge crosses ends on two of the face's edges.
    const int normal_axis = is_end(b) ? b : c, q = is_end(b) ? c : b;
    const int side = (u[normal_axis] == k_[normal_axis]) << normal_axis;
    const int face_edges[4] = {net_edge(a, side), net_edge(a, side | 1 << q), net_edge(q, side),
                               net_edge(q, side | 1 << a)};
    int crossed = 0;
    for (const int e : face_edges)
      if (vertex.net->edges >> e & 1) ++crossed, patch_edge = e;
    if (crossed == 4) {
      // There are two curves, each around a solid corner. Chooses the curve in the quadrant of the solid end.
      const int solid_end = u[a] + (is_solid(edge.low) ? 0 : 1);
      const int upper_a = solid_end > (k_[a] - 1) / 2;
      int upper_q = u[q] > (k_[q] - 1) / 2;
      // A solid end on one of the face's edges belongs to the solid corner of that edge, at any distance from
      // the corner.
      if (solid_end == 0 || solid_end == k_[a]) {
        ivec3 low_corner = edge.low;
        low_corner[a] += solid_end - u[a];
        low_corner[q] -= u[q];
        upper_q = !is_solid(low_corner);
      }
      patch_edge = net_edge(a, side | upper_a << a | upper_q << q);
      // If the face of this cell is flipped, all edges inside the face belong to the curve around one of the
      // two air corners: the corner without the flipped lattice cell.
      const int face = 2 * normal_axis + (side != 0);
      const std::ptrdiff_t config = vertex.net - k_net_cases[1].data();
      const bool is_flipped =
          config >= 0 && config < 256 && k_net_cases[0][static_cast<std::size_t>(config)].pinch_face == face;
      if (ivec3 flipped; is_flipped && find_flipped(cell, face, flipped)) {
        const ivec3 from = origin_ + cell * k_;
        const int air_a = flipped[a] > from[a] + k_[a] / 2;
        // The edge along axis a from the solid corner ends at that air corner if the corner with the flipped
        // lattice cell has the position of the solid corner along a. Otherwise the edge along q ends there.
        if (air_a != upper_a) patch_edge = net_edge(q, side | upper_a << a | upper_q << q);
      }
    }
  }
  return vertex.first + vertex.net->patch_of_edge[static_cast<std::size_t>(patch_edge)];
}

bool FineNet::is_solid(const ivec3& sample) const {
  // A sample on a border belongs to several cells; any fine one gives the same result.
  for (int i = 0; i < 8; ++i)
    if (const Block* block = block_of(sample - corner(i)); block && !block->solid.empty())
      return block->solid[sample_index(sample - origin_ - block->cell * k_)] != 0;
  return false;
}

void FineNet::add_polygon(const Edge& edge, const CoarseVertices& coarse,
                          std::vector<std::uint32_t>& triangles) const {
  const int first = (edge.axis + 1) % 3, second = (edge.axis + 2) % 3;
  // The four cells around the edge, counter-clockwise viewed from its high end.
  const ivec3 steps[4] = {unit(first) + unit(second), unit(second), ivec3(0), unit(first)};
  std::array<std::uint32_t, 4> ids;
  std::size_t count = 0;
  for (const ivec3& step : steps) {
    const ivec3 lattice_cell = edge.low - step, cell = cell_of(lattice_cell);
    if (!exists(cell)) return;
    std::uint32_t id = 0;
    if (const Block* block = block_of(lattice_cell)) {
      const ivec3 offset = lattice_cell - origin_ - cell * k_;
      const NetCase& net = case_of(lattice_cell, config_of(lattice_cell));
      const ivec3 u = edge.low - lattice_cell;
      id = block->first[lattice_index(offset)] +
           net.patch_of_edge[static_cast<std::size_t>(net_edge(edge.axis, u.x | u.y << 1 | u.z << 2))];
    } else {
      id = coarse_vertex(cell, edge, coarse);
    }
    if (count == 0 || ids[count - 1] != id) ids[count++] = id;
  }
  if (count > 1 && ids[count - 1] == ids[0]) --count;
  if (count < 3) return;
  // The polygon faces the high end if the low end is solid; else its order is reversed.
  if (!is_solid(edge.low)) std::reverse(ids.begin(), ids.begin() + static_cast<std::ptrdiff_t>(count));
  for (std::size_t i = 2; i < count; ++i) triangles.insert(triangles.end(), {ids[0], ids[i - 1], ids[i]});
}

void FineNet::make(const CoarseVertices& coarse, std::uint32_t first_id, std::vector<glm::vec3>& vertices,
                   std::vector<std::uint32_t>& triangles) {
  const auto is_within = [&](const ivec3& cell, int margin) {
    return VoxelBox{owned_.low - margin, owned_.high + margin}.contains(cell);
  };
  for (Block& block : storage_)
    if (is_within(block.cell, 1)) place_vertices(block, first_id, vertices);

  // Visits the edges by voxel: those in the cell above it, whose lowest corner is the centre of the voxel,
  // but not on the upper faces of that cell.
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
      // Chooses a fine cell that contains the edge: one of the four around it if ub = uc = 0, one of the two
      // at its face if only ub or uc is 0, and the cell above the voxel otherwise.
      const auto fine_cell = [&](const ivec3& cell) { return block_of(origin_ + cell * k_); };
      const Block *above = fine_cell(v), *below_b = fine_cell(v - unit(b)), *below_c = fine_cell(v - unit(c)),
                  *below = fine_cell(v - unit(b) - unit(c));
      for (int uc = 0; uc < k_[c]; ++uc)
        for (int ub = 0; ub < k_[b]; ++ub) {
          const Block* block = above;
          if (!block && ub == 0) block = below_b;
          if (!block && uc == 0) block = below_c;
          if (!block && ub == 0 && uc == 0) block = below;
          if (!block) continue;
          ivec3 u(0);
          u[b] = ub, u[c] = uc;
          ivec3 offset = low + u - origin_ - block->cell * k_;
          const std::size_t step = axis == 0   ? 1
                                   : axis == 1 ? static_cast<std::size_t>(k_.x + 1)
                                               : static_cast<std::size_t>((k_.x + 1) * (k_.y + 1));
          const std::uint8_t* solid = block->solid.data() + sample_index(offset);
          for (int t = 0; t < k_[axis]; ++t, solid += step) {
            if (solid[0] == solid[step]) continue;
            u[axis] = t;
            add_polygon({low + u, axis}, coarse, triangles);
          }
        }
    }
}

}  // namespace trephine::volume
