// NetBuilder: surface nets of uniform and of two-level cells. Both stay in one file since they share one pass
// over the cells, its tables and its vertices.
#include "volume/surface/surface_nets.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <emmintrin.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "volume/base/parallel.h"
#include "volume/base/work_counters.h"
#include "volume/surface/fine_net.h"
#include "volume/surface/surface_net_cases.h"
#include "volume/surface/surface_net_vertices.h"

namespace trephine::volume {

namespace {

constexpr std::uint32_t k_many_patches = 1u << 31;  // flag on a cell's first vertex id
constexpr int k_halo = 2;  // voxels below the first owned cell: one cell for quads, one for faces

/// Number of vertices and triangles of a row or layer; after the prefix sum, their first index.
struct Counts {
  std::uint32_t vertices = 0, triangles = 0;
};

/// Builds the surface net of a box of cells. Local voxel (i, j, k) is voxel first + (i, j, k); local cell i
/// is between local voxels i and i + 1. Owned cells are 2 .. count + 1 along each axis. They get vertices,
/// and quads around the edges that start at their lowest voxel. Halo cells 1 get vertices if
/// `has_halo_vertices`.
class NetBuilder {
 public:
  NetBuilder(const SurfaceSource& source, const glm::ivec3& first_cell, const glm::ivec3& cells,
             bool has_halo_vertices, int threads)
      : source_(source),
        volume_(source.field->volume()),
        first_(first_cell - k_halo),
        cells_(cells),
        vertex_low_(has_halo_vertices ? 1 : 2),
        threads_(threads),
        voxels_(cells + 2 * k_halo),
        words_((voxels_.x + 63) / 64),
        bits_(static_cast<std::size_t>(words_) * static_cast<std::size_t>(voxels_.y) *
              static_cast<std::size_t>(voxels_.z)),
        is_cut_(source.version != nullptr && !source.version->is_uncut()),
        vertices_(source) {
    if (!is_cut_ || source.uses_voxel_centres_only || source.version->lattice().has_voxel_resolution())
      return;
    fine_.emplace(source, VoxelBox{first_cell, first_cell + cells - 1});
    if (fine_->is_empty()) {
      fine_.reset();
      return;
    }
    fine_bits_.assign(bits_.size(), 0);
    fine_->for_fine_cells([&](const glm::ivec3& cell) {
      const glm::ivec3 c = cell - first_;
      if (c.x < 0 || c.y < 0 || c.z < 0 || c.x >= voxels_.x || c.y >= voxels_.y || c.z >= voxels_.z) return;
      fine_bits_[row_index(c.y, c.z) + static_cast<std::size_t>(c.x >> 6)] |= std::uint64_t{1} << (c.x & 63);
    });
  }

  /// Builds a box of few cells in one pass, with buffers enlarged per layer for its worst case.
  Mesh build_small(NetScratch& scratch) {
    for (int z = 0; z < voxels_.z; ++z) fill_bits(z);
    const int layers = cells_.z + k_halo;
    busy_.assign(static_cast<std::size_t>(layers) * static_cast<std::size_t>(cells_.y + k_halo),
                 ~std::uint64_t{0} >> (64 - words_));
    const std::size_t layer_cells =
        static_cast<std::size_t>(cells_.x + k_halo) * static_cast<std::size_t>(cells_.y + k_halo);
    Buffer<glm::vec3>& vertices = scratch.vertices;
    Buffer<std::uint32_t>& triangles = scratch.triangles;
    const auto reserve = [](auto& buffer, std::size_t used, std::size_t more) {
      if (used + more <= buffer.size()) return;
      std::remove_reference_t<decltype(buffer)> larger(2 * buffer.size() + more);
      std::copy_n(buffer.data(), used, larger.data());
      buffer = std::move(larger);
    };
    Slabs slabs(cells_ + k_halo);
    Counts at;
    for (int z = 0; z < layers; ++z) {
      reserve(vertices, at.vertices, 4 * layer_cells);
      reserve(triangles, 3 * static_cast<std::size_t>(at.triangles), 18 * layer_cells);
      slabs.swap();
      at = emit_layer(z, at, slabs, vertices.data(), triangles.data());
    }
    place_queued(slabs, vertices.data());
    return with_fine_net({vertices.data(), at.vertices},
                         {triangles.data(), 3 * static_cast<std::size_t>(at.triangles)});
  }

  Mesh build() {
    parallel_for(voxels_.z, threads_, [this](int z) { fill_bits(z); });

    // Counts per layer and computes the first index of each layer, so that the output does not depend on the
    // distribution of layers to threads.
    const int layers = cells_.z + k_halo;
    std::vector<Counts> layer(static_cast<std::size_t>(layers) + 1);
    busy_.resize(static_cast<std::size_t>(layers) * static_cast<std::size_t>(cells_.y + k_halo));
    parallel_for(layers, threads_, [&](int z) { layer[static_cast<std::size_t>(z) + 1] = count_layer(z); });
    for (std::size_t z = 1; z < layer.size(); ++z) {
      layer[z].vertices += layer[z - 1].vertices;
      layer[z].triangles += layer[z - 1].triangles;
    }

    Mesh mesh;
    mesh.vertices = Buffer<glm::vec3>(layer.back().vertices);
    mesh.triangles = Buffer<std::uint32_t>(3 * static_cast<std::size_t>(layer.back().triangles));
    // A task also numbers the layer below its own, which favours few large tasks; several per thread balance
    // the load.
    const int threads = thread_count(threads_);
    const int task_layers = threads == 1 ? layers : std::max(8, layers / (4 * threads));
    const int tasks = (layers + task_layers - 1) / task_layers;
    parallel_for(tasks, threads, [&](int task) {
      Slabs slabs(cells_ + k_halo);
      const int begin = task * task_layers;
      if (begin > 0) number_layer(begin - 1, layer[static_cast<std::size_t>(begin) - 1].vertices, slabs);
      for (int z = begin; z < std::min(begin + task_layers, layers); ++z) {
        slabs.swap();
        emit_layer(z, layer[static_cast<std::size_t>(z)], slabs, mesh.vertices.data(), mesh.triangles.data());
      }
      place_queued(slabs, mesh.vertices.data());
    });
    return fine_ ? with_fine_net(mesh.vertices.span(), mesh.triangles.span()) : std::move(mesh);
  }

 private:
  /// Returns the net of the voxels joined with that of the fine lattice near cuts.
  Mesh with_fine_net(std::span<const glm::vec3> vertices, std::span<const std::uint32_t> triangles) {
    std::vector<glm::vec3> fine_vertices;
    std::vector<std::uint32_t> fine_triangles;
    if (fine_) {
      FineNet::CoarseVertices coarse;
      for (const auto& [cell, vertex] : coarse_vertices_) coarse.emplace(FineNet::key(cell), vertex);
      fine_->make(coarse, static_cast<std::uint32_t>(vertices.size()), fine_vertices, fine_triangles);
    }
    Mesh mesh;
    mesh.vertices = Buffer<glm::vec3>(vertices.size() + fine_vertices.size());
    mesh.triangles = Buffer<std::uint32_t>(triangles.size() + fine_triangles.size());
    std::copy(fine_vertices.begin(), fine_vertices.end(),
              std::copy(vertices.begin(), vertices.end(), mesh.vertices.data()));
    std::copy(fine_triangles.begin(), fine_triangles.end(),
              std::copy(triangles.begin(), triangles.end(), mesh.triangles.data()));
    return mesh;
  }

  /// A cell whose vertices are computed later.
  struct Queued {
    glm::ivec3 cell;
    std::uint32_t first;
    const NetCase* net;
  };
  static constexpr std::size_t k_queue = 64;
  /// First vertex and case of the active cells of the current layer and of the one below.
  struct Slabs {
    explicit Slabs(const glm::ivec3& cells)
        : width(static_cast<std::size_t>(cells.x)),
          ids{Buffer<std::uint32_t>(width * static_cast<std::size_t>(cells.y)),
              Buffer<std::uint32_t>(width * static_cast<std::size_t>(cells.y))},
          cases{Buffer<const NetCase*>(width * static_cast<std::size_t>(cells.y)),
                Buffer<const NetCase*>(width * static_cast<std::size_t>(cells.y))} {}
    void swap() { current ^= 1; }
    std::size_t width;
    std::array<Buffer<std::uint32_t>, 2> ids;
    std::array<Buffer<const NetCase*>, 2> cases;  // written only for cells with several patches
    std::size_t current = 0;                      // index of the current layer
    std::array<Queued, k_queue> queue;
    std::size_t queued = 0;
  };

  std::size_t row_index(int y, int z) const {
    return static_cast<std::size_t>(words_) *
           (static_cast<std::size_t>(y) + static_cast<std::size_t>(voxels_.y) * static_cast<std::size_t>(z));
  }
  std::uint64_t* bit_row(int y, int z) { return bits_.data() + row_index(y, z); }
  /// One word of the fine cells of row (y, z).
  std::uint64_t fine_word(int y, int z, int w) const {
    return fine_ ? fine_bits_[row_index(y, z) + static_cast<std::size_t>(w)] : 0;
  }
  /// One word of row (y, z), with the bit of a cell set if the previous cell along x is fine.
  std::uint64_t previous_fine_word(int y, int z, int w) const {
    return fine_word(y, z, w) << 1 | (w > 0 ? fine_word(y, z, w - 1) >> 63 : 0);
  }
  bool is_fine(const glm::ivec3& cell) const {
    return fine_word(cell.y, cell.z, cell.x >> 6) >> (cell.x & 63) & 1;
  }
  const std::uint64_t* bit_row(int y, int z) const { return const_cast<NetBuilder*>(this)->bit_row(y, z); }

  void fill_bits(int z) {
    const int gz = first_.z + z;
    const int source_words = (volume_.size.x + 63) / 64;
    // Words of the scan's rows that overlap this box.
    const int from = std::clamp(first_.x >> 6, 0, source_words - 1);
    const int count = std::clamp((first_.x + voxels_.x - 1) >> 6, 0, source_words - 1) - from + 1;
    std::vector<std::uint64_t> row(static_cast<std::size_t>(source_words));
    for (int y = 0; y < voxels_.y; ++y) {
      std::uint64_t* out = bit_row(y, z);
      const int gy = first_.y + y;
      if (gy < 0 || gz < 0 || gy >= volume_.size.y || gz >= volume_.size.z) {
        std::fill_n(out, words_, 0);
        continue;
      }
      if (source_.bits)
        std::copy_n(source_.bits->row(gy, gz) + from, count, row.data() + from);
      else
        threshold_row(volume_, source_.field->shape(), gy, gz, row.data());
      if (is_cut_) source_.version->mask_row(gy, gz, from, count, row.data() + from);
      // Local bit i is voxel first + i: shifts the row by `first` bits, with zeros outside.
      for (int w = 0; w < words_; ++w) {
        const int start = first_.x + 64 * w;
        const int at = start >> 6, shift = start & 63;  // floor division, also for negative numbers
        const auto word = [&](int i) {
          return i >= from && i < from + count ? row[static_cast<std::size_t>(i)] : 0;
        };
        out[w] = shift == 0 ? word(at) : word(at) >> shift | word(at + 1) << (64 - shift);
      }
      const int used = voxels_.x & 63;
      if (used != 0) out[words_ - 1] &= (std::uint64_t{1} << used) - 1;
    }
  }

  /// Bits of local cells low .. high (both included) within word w.
  static std::uint64_t range_mask(int w, int low, int high) {
    const int from = std::max(low - 64 * w, 0), to = std::min(high - 64 * w, 63);
    if (from > to) return 0;
    const std::uint64_t up_to = to == 63 ? ~std::uint64_t{0} : (std::uint64_t{1} << (to + 1)) - 1;
    return up_to & ~((std::uint64_t{1} << from) - 1);
  }
  /// Clamps low .. high to the existing cells of an axis: those of an open surface do not extend beyond the
  /// grid.
  void cell_range(int axis, int& low, int& high) const {
    if (!source_.is_open) return;
    low = std::max(low, 0 - first_[axis]);
    high = std::min(high, volume_.size[axis] - 2 - first_[axis]);
  }

  struct RowWords {
    std::uint64_t r00, r10, r01, r11;  // one word of voxels (y, z), (y+1, z), (y, z+1), (y+1, z+1)
    std::uint64_t s00, s10, s01, s11;  // these, shifted to the next voxel along x
  };
  RowWords row_words(int y, int z, int w) const {
    const std::uint64_t *a = bit_row(y, z), *b = bit_row(y + 1, z), *c = bit_row(y, z + 1),
                        *d = bit_row(y + 1, z + 1);
    const auto next = [&](const std::uint64_t* row) {
      return row[w] >> 1 | (w + 1 < words_ ? row[w + 1] << 63 : 0);
    };
    return {a[w], b[w], c[w], d[w], next(a), next(b), next(c), next(d)};
  }
  static int config_of(const RowWords& r, int i) {
    const auto bit = [i](std::uint64_t word, int to) { return static_cast<int>(word >> i & 1u) << to; };
    return bit(r.r00, 0) | bit(r.s00, 1) | bit(r.r10, 2) | bit(r.s10, 3) | bit(r.r01, 4) | bit(r.s01, 5) |
           bit(r.r11, 6) | bit(r.s11, 7);
  }
  int config_at(const glm::ivec3& cell) const {
    if (cell.x < 0 || cell.y < 0 || cell.z < 0 || cell.x + 1 >= voxels_.x || cell.y + 1 >= voxels_.y ||
        cell.z + 1 >= voxels_.z)
      return 0;
    return config_of(row_words(cell.y, cell.z, cell.x >> 6), cell.x & 63);
  }
  /// Case of a cell: an ambiguous face separates air instead of solid if both its cells would pinch there.
  const NetCase& case_of(int config, const glm::ivec3& cell) const {
    const NetCase& standard = k_net_cases[0][static_cast<std::size_t>(config)];
    if (standard.pinch_face < 0) return standard;
    glm::ivec3 other = cell;
    other[standard.pinch_face / 2] += standard.pinch_face % 2 ? 1 : -1;
    if (fine_ && is_fine(other)) return fine_->coarse_case(first_ + cell, config);
    const bool is_pinched_too =
        k_net_cases[0][static_cast<std::size_t>(config_at(other))].pinch_face == (standard.pinch_face ^ 1);
    return k_net_cases[is_pinched_too ? 1 : 0][static_cast<std::size_t>(config)];
  }

  static std::uint64_t active_cells(const RowWords& r) {
    const std::uint64_t any = r.r00 | r.r10 | r.r01 | r.r11 | r.s00 | r.s10 | r.s01 | r.s11;
    const std::uint64_t all = r.r00 & r.r10 & r.r01 & r.r11 & r.s00 & r.s10 & r.s01 & r.s11;
    return any & ~all;
  }
  /// Edges with their low end in row (y, z) that get quads: directions, and ranges of their local x.
  struct EdgeLimits {
    bool has_x, has_y, has_z;
    int along_low, along_high, across_low, across_high;
    bool is_empty() const { return !(has_x || has_y || has_z); }
  };
  EdgeLimits edge_limits(int y, int z) const {
    // In an open surface an edge needs all four cells around it.
    const auto limits = [&](int axis, bool is_along) {
      int low = 2, high = cells_[axis] + 1;
      cell_range(axis, low, high);
      if (source_.is_open && !is_along) low = std::max(low, 1 - first_[axis]);
      return std::pair(low, high);
    };
    const auto is_within = [&](int axis, bool is_along, int i) {
      const auto [low, high] = limits(axis, is_along);
      return i >= low && i <= high;
    };
    const bool along_y = is_within(1, true, y), across_y = is_within(1, false, y),
               along_z = is_within(2, true, z), across_z = is_within(2, false, z);
    const auto [along_low, along_high] = limits(0, true);
    const auto [across_low, across_high] = limits(0, false);
    return {across_y && across_z, along_y && across_z, across_y && along_z, along_low,
            along_high,           across_low,          across_high};
  }
  /// Bits of the crossed owned edges along x, y and z, by the local x of their low end.
  struct CrossedEdges {
    std::uint64_t x, y, z;
  };
  CrossedEdges crossed_edges(const RowWords& r, const EdgeLimits& limits, int y, int z, int w) const {
    const std::uint64_t along = range_mask(w, limits.along_low, limits.along_high),
                        across = range_mask(w, limits.across_low, limits.across_high);
    CrossedEdges e{limits.has_x ? (r.r00 ^ r.s00) & along : 0, limits.has_y ? (r.r00 ^ r.r10) & across : 0,
                   limits.has_z ? (r.r00 ^ r.r01) & across : 0};
    if (fine_ && y > 0 && z > 0) {
      // Edges of fine cells belong to the fine net.
      const std::uint64_t own = fine_word(y, z, w) | previous_fine_word(y, z, w);
      e.x &= ~(fine_word(y, z, w) | fine_word(y - 1, z, w) | fine_word(y, z - 1, w) |
               fine_word(y - 1, z - 1, w));
      e.y &= ~(own | fine_word(y, z - 1, w) | previous_fine_word(y, z - 1, w));
      e.z &= ~(own | fine_word(y - 1, z, w) | previous_fine_word(y - 1, z, w));
    }
    return e;
  }

  struct CellSpan {
    int low, high;
    bool is_empty() const { return low > high; }
  };
  CellSpan vertex_cells(int axis) const {
    CellSpan span{vertex_low_, cells_[axis] + 1};
    cell_range(axis, span.low, span.high);
    return span;
  }
  bool has_vertices(int y, int z) const {
    const CellSpan ys = vertex_cells(1), zs = vertex_cells(2);
    return y >= ys.low && y <= ys.high && z >= zs.low && z <= zs.high;
  }

  /// Bits of the busy words of row (y, z): those with active cells. In rows of more than 64 words the bits
  /// are not used, and all words count as busy.
  std::uint64_t& busy_words(int y, int z) {
    return busy_[static_cast<std::size_t>(z) * static_cast<std::size_t>(cells_.y + k_halo) +
                 static_cast<std::size_t>(y)];
  }
  /// Calls each(word) for the busy words of a row.
  template <class Each>
  void for_busy_words(int y, int z, const Each& each) const {
    const std::uint64_t busy = const_cast<NetBuilder*>(this)->busy_words(y, z);
    if (words_ > 64)
      for (int w = 0; w < words_; ++w) each(w);
    else
      for (std::uint64_t remaining = busy; remaining != 0; remaining &= remaining - 1)
        each(std::countr_zero(remaining));
  }

  Counts count_layer(int z) {
    Counts layer;
    const CellSpan xs = vertex_cells(0);
    for (int y = 0; y < cells_.y + k_halo; ++y) {
      const bool has_row_vertices = has_vertices(y, z);
      const EdgeLimits limits = edge_limits(y, z);
      std::uint64_t busy = 0;
      for (int w = 0; w < words_; ++w) {
        const RowWords r = row_words(y, z, w);
        const std::uint64_t active = active_cells(r);
        if (active == 0) continue;
        busy |= std::uint64_t{1} << (w & 63);
        if (has_row_vertices)
          for (std::uint64_t remaining = active & ~fine_word(y, z, w) & range_mask(w, xs.low, xs.high);
               remaining != 0; remaining &= remaining - 1) {
            const int i = std::countr_zero(remaining);
            layer.vertices += case_of(config_of(r, i), {64 * w + i, y, z}).patch_count;
          }
        const CrossedEdges e = crossed_edges(r, limits, y, z, w);
        layer.triangles +=
            2 * static_cast<std::uint32_t>(std::popcount(e.x) + std::popcount(e.y) + std::popcount(e.z));
      }
      busy_words(y, z) = busy;
    }
    return layer;
  }

  /// Assigns vertex ids to the active cells of a row, from `id` on; calls each(cell, case, id). Returns the
  /// next id.
  template <class Each>
  std::uint32_t number_row(int y, int z, std::uint32_t id, Slabs& slabs, const Each& each) const {
    if (!has_vertices(y, z)) return id;
    const CellSpan xs = vertex_cells(0);
    std::uint32_t* ids = slabs.ids[slabs.current].data() + slabs.width * static_cast<std::size_t>(y);
    const NetCase** cases = slabs.cases[slabs.current].data() + slabs.width * static_cast<std::size_t>(y);
    for_busy_words(y, z, [&](int w) {
      const RowWords r = row_words(y, z, w);
      for (std::uint64_t remaining = active_cells(r) & ~fine_word(y, z, w) & range_mask(w, xs.low, xs.high);
           remaining != 0; remaining &= remaining - 1) {
        const int i = std::countr_zero(remaining), x = 64 * w + i;
        const int config = config_of(r, i);
        const NetCase& net = case_of(config, {x, y, z});
        ids[x] = net.patch_count > 1 ? id | k_many_patches : id;
        if (net.patch_count > 1) cases[x] = &net;
        each(glm::ivec3(x, y, z), net, id);
        id += net.patch_count;
      }
    });
    return id;
  }
  void number_layer(int z, std::uint32_t id, Slabs& slabs) const {
    for (int y = 0; y < cells_.y + k_halo; ++y) id = number_row(y, z, id, slabs, [](const auto&...) {});
  }

  void place_queued(const Slabs& slabs, glm::vec3* vertices) const {
    for (std::size_t i = slabs.queued - std::min(slabs.queued, k_queue); i < slabs.queued; ++i) {
      const Queued& slot = slabs.queue[i % k_queue];
      vertices_.place(slot.cell, *slot.net, vertices + slot.first);
    }
  }
  /// Writes a layer's vertices and triangles from the indices `at` on; returns the start of the next layer.
  Counts emit_layer(int z, Counts at, Slabs& slabs, glm::vec3* vertices, std::uint32_t* triangles) const {
    std::uint32_t* out = triangles + 3 * static_cast<std::size_t>(at.triangles);
    std::uint32_t id = at.vertices;
    for (int y = 0; y < cells_.y + k_halo; ++y) {
      // The scan is no longer in the cache. Vertices are computed after a short queue of cells, so that the
      // voxels of a cell can be prefetched first.
      id = number_row(y, z, id, slabs, [&](const glm::ivec3& cell, const NetCase& net, std::uint32_t first) {
        prefetch(first_ + cell);
        if (fine_ && fine_->is_external(first_ + cell)) record_coarse_vertex(first_ + cell, {first, &net});
        Queued& slot = slabs.queue[slabs.queued++ % k_queue];
        if (slabs.queued > k_queue) vertices_.place(slot.cell, *slot.net, vertices + slot.first);
        slot = {first_ + cell, first, &net};
      });
      const EdgeLimits limits = edge_limits(y, z);
      if (limits.is_empty()) continue;
      const IdRows rows = id_rows(slabs, y);
      for_busy_words(y, z, [&](int w) {
        const RowWords r = row_words(y, z, w);
        const CrossedEdges e = crossed_edges(r, limits, y, z, w);
        out = emit_quads<0>(e.x, r.r00, w, y, rows, slabs, out);
        out = emit_quads<1>(e.y, r.r00, w, y, rows, slabs, out);
        out = emit_quads<2>(e.z, r.r00, w, y, rows, slabs, out);
      });
    }
    return {id, static_cast<std::uint32_t>((out - triangles) / 3)};
  }

  /// Rows y and y - 1 (lower) of first vertex ids, in the current layer and in the one below.
  struct IdRows {
    const std::uint32_t *current, *current_lower, *below, *below_lower;
  };
  static IdRows id_rows(const Slabs& slabs, int y) {
    const std::uint32_t *current = slabs.ids[slabs.current].data(),
                        *below = slabs.ids[slabs.current ^ 1].data();
    const std::size_t row = slabs.width * static_cast<std::size_t>(y), lower = row - slabs.width;
    return {current + row, current + lower, below + row, below + lower};
  }

  /// Writes one quad around each crossed edge along Axis, with its outside toward the air. Its corners are
  /// the vertices of the four cells around the edge, counter-clockwise viewed from the high end of the edge.
  template <int Axis>
  std::uint32_t* emit_quads(std::uint64_t edges, std::uint64_t solid, int w, int y, const IdRows& rows,
                            const Slabs& slabs, std::uint32_t* out) const {
    for (; edges != 0; edges &= edges - 1) {
      const int i = std::countr_zero(edges), x = 64 * w + i;
      std::uint32_t a, b, c, d;
      if constexpr (Axis == 0)
        a = rows.below_lower[x], b = rows.below[x], c = rows.current[x], d = rows.current_lower[x];
      else if constexpr (Axis == 1)
        a = rows.below[x - 1], b = rows.current[x - 1], c = rows.current[x], d = rows.below[x];
      else
        a = rows.current_lower[x - 1], b = rows.current_lower[x], c = rows.current[x],
        d = rows.current[x - 1];
      if ((a | b | c | d) & k_many_patches) {
        constexpr int first = (Axis + 1) % 3, second = (Axis + 2) % 3;
        a = patch_vertex(Axis, a, x, y, 1 << first | 1 << second, slabs);
        b = patch_vertex(Axis, b, x, y, 1 << second, slabs);
        c = patch_vertex(Axis, c, x, y, 0, slabs);
        d = patch_vertex(Axis, d, x, y, 1 << first, slabs);
      }
      // The quad faces the high end if the low end is solid; else b and d are exchanged.
      const std::uint32_t exchange = (b ^ d) & (static_cast<std::uint32_t>(solid >> i & 1u) - 1u);
      b ^= exchange;
      d ^= exchange;
      out[0] = a, out[1] = b, out[2] = c;
      out[3] = a, out[4] = c, out[5] = d;
      out += 6;
    }
    return out;
  }
  /// Vertex of the patch that contains an edge along `axis` from voxel (x, y) of the current layer. The cell
  /// is the one at this voxel minus `corner` (offsets of 0 or 1, as bits of x, y, z). `id`: of that cell.
  std::uint32_t patch_vertex(int axis, std::uint32_t id, int x, int y, int corner, const Slabs& slabs) const {
    if (!(id & k_many_patches)) return id;
    const std::size_t slab = corner & 4 ? slabs.current ^ 1 : slabs.current;
    const std::size_t at = slabs.width * static_cast<std::size_t>(y - (corner >> 1 & 1)) +
                           static_cast<std::size_t>(x - (corner & 1));
    return (id & ~k_many_patches) +
           slabs.cases[slab][at]->patch_of_edge[static_cast<std::size_t>(net_edge(axis, corner))];
  }

  void record_coarse_vertex(const glm::ivec3& cell, const FineNet::CoarseVertex& vertex) const {
    const std::lock_guard lock(coarse_mutex_);
    coarse_vertices_.emplace_back(cell, vertex);
  }
  void prefetch(const glm::ivec3& cell) const {
    const glm::ivec3 last = volume_.size - 1, low = glm::clamp(cell, glm::ivec3(0), last),
                     high = glm::min(low + 1, last);
    const std::int16_t* v = volume_.window_voxels().data();
    for (const std::size_t at : {volume_.index(low.x, low.y, low.z), volume_.index(low.x, high.y, low.z),
                                 volume_.index(low.x, low.y, high.z), volume_.index(low.x, high.y, high.z)})
      _mm_prefetch(reinterpret_cast<const char*>(v + at), _MM_HINT_T0);
  }

  SurfaceSource source_;
  const Volume& volume_;
  glm::ivec3 first_, cells_;
  int vertex_low_, threads_;
  glm::ivec3 voxels_;
  int words_;
  Buffer<std::uint64_t> bits_;
  std::vector<std::uint64_t> busy_;
  bool is_cut_;
  NetVertices vertices_;
  std::optional<FineNet> fine_;  ///< set if the lattice of cuts is finer than the voxels
  std::vector<std::uint64_t> fine_bits_;
  mutable std::mutex coarse_mutex_;  ///< several threads build layers
  mutable std::vector<std::pair<glm::ivec3, FineNet::CoarseVertex>> coarse_vertices_;
};

}  // namespace

Mesh surface_net(const SurfaceSource& source, int threads) {
  ++work_counters().surfaces;
  return NetBuilder(source, glm::ivec3(-1), source.field->volume().size + 1, false, threads).build();
}

Mesh surface_net_chunk(const SurfaceSource& source, const glm::ivec3& chunk, NetScratch* scratch) {
  ++work_counters().surfaces;
  const glm::ivec3 first = k_chunk * chunk - 1;
  const glm::ivec3 cells = glm::min(glm::ivec3(k_chunk), source.field->volume().size - first);
  NetScratch local;
  return NetBuilder(source, first, cells, true, 1).build_small(scratch ? *scratch : local);
}

ChunkRange chunks_touching(const glm::ivec3& low, const glm::ivec3& high, const glm::ivec3& size) {
  // A voxel affects its neighbouring cells, their quads extend to the next cell, and a flipped face to one
  // more.
  return {glm::max((low - 2) / k_chunk, 0), glm::min((high + 3) / k_chunk, chunk_grid(size) - 1)};
}

}  // namespace trephine::volume
