#include "volume/cuts/separation.h"

#include <algorithm>
#include <array>
#include <bit>
#include <deque>
#include <glm/common.hpp>
#include <glm/vector_relational.hpp>
#include <unordered_map>
#include <vector>

namespace trephine::volume {

namespace {

/// 8 x 8 x 8 samples, laid out as Brick::kept.
using Words = std::array<std::uint64_t, k_brick>;

constexpr std::uint64_t k_first_x = 0x0101010101010101, k_last_x = 0x8080808080808080, k_first_y = 0xff,
                        k_last_y = 0xffull << 56;

bool has_bits(const Words& w) noexcept {
  std::uint64_t bits = 0;
  for (const std::uint64_t word : w) bits |= word;
  return bits != 0;
}
Words intersection(const Words& a, const Words& b) noexcept {
  Words out;
  for (std::size_t z = 0; z < k_brick; ++z) out[z] = a[z] & b[z];
  return out;
}
Words difference(const Words& a, const Words& b) noexcept {
  Words out;
  for (std::size_t z = 0; z < k_brick; ++z) out[z] = a[z] & ~b[z];
  return out;
}
void add(Words& to, const Words& more) noexcept {
  for (std::size_t z = 0; z < k_brick; ++z) to[z] |= more[z];
}
std::uint64_t dilated_x(std::uint64_t w) noexcept { return w | (w & ~k_last_x) << 1 | (w & ~k_first_x) >> 1; }
std::uint64_t dilated_y(std::uint64_t w) noexcept { return w | w << 8 | w >> 8; }
/// Returns the samples and those of their 26 neighbours that are inside the brick.
Words dilated(const Words& w) noexcept {
  Words flat, out;
  for (std::size_t z = 0; z < k_brick; ++z) flat[z] = dilated_y(dilated_x(w[z]));
  for (std::size_t z = 0; z < k_brick; ++z)
    out[z] = flat[z] | (z > 0 ? flat[z - 1] : 0) | (z + 1 < k_brick ? flat[z + 1] : 0);
  return out;
}
/// Returns the samples of the neighbouring brick in direction `d` that touch samples of `w`.
Words neighbours_in(const Words& w, const glm::ivec3& d) noexcept {
  Words flat;
  for (std::size_t z = 0; z < k_brick; ++z) {
    std::uint64_t s = w[z];
    s = d.x > 0 ? (s & k_last_x) >> 7 : d.x < 0 ? (s & k_first_x) << 7 : dilated_x(s);
    s = d.y > 0 ? (s & k_last_y) >> 56 : d.y < 0 ? (s & k_first_y) << 56 : dilated_y(s);
    flat[z] = s;
  }
  Words out{};
  if (d.z > 0)
    out[0] = flat[k_brick - 1];
  else if (d.z < 0)
    out[k_brick - 1] = flat[0];
  else
    for (std::size_t z = 0; z < k_brick; ++z)
      out[z] = flat[z] | (z > 0 ? flat[z - 1] : 0) | (z + 1 < k_brick ? flat[z + 1] : 0);
  return out;
}

template <class Each>
void for_neighbours(Each&& each) {
  for (int n = 0; n < 27; ++n)
    if (n != 13) each(glm::ivec3(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1));
}

/// One call of detect_detachment().
class Search {
 public:
  Search(const Field& field, const Occupancy& bits, const Version& before, const Version& after,
         const SeparationLimits& limits)
      : field_(field),
        bits_(bits),
        before_(before),
        after_(after),
        lattice_(after.lattice()),
        size_((lattice_.size() + (k_brick - 1)) / k_brick),
        max_bricks_(limits.max_bricks),
        min_samples_(limits.min_samples),
        cost_(lattice_.has_voxel_resolution() ? 1 : 3) {}

  Separation run() {
    const bool is_within_limit = flood_near_cut();
    return {is_within_limit ? flood_outward() : Separation::Kind::pending, count_};
  }

 private:
  using Key = std::uint64_t;
  /// Samples of one brick.
  struct Node {
    glm::ivec3 position{0};  ///< in bricks
    Words solid{}, removed{};
    Words seeds{};    ///< solid samples next to the cut
    Words reached{};  ///< samples reached by any part
    /// Samples reached by each part, with the part's number at that time; root() gives the current number.
    std::vector<std::pair<int, Words>> parts;
    bool is_near = false;   ///< next to the cut
    bool is_mixed = false;  ///< has a voxel whose samples were evaluated one by one
  };
  /// Pending growth of a part into a brick.
  struct Step {
    Key key;
    Words entering;
  };
  struct Part {
    std::deque<Step> steps;  ///< pending
    std::vector<Key> nodes;  ///< visited bricks
    std::int64_t samples = 0;
  };

  Key key_of(const glm::ivec3& p) const noexcept {
    return static_cast<Key>(p.x) +
           static_cast<Key>(size_.x) *
               (static_cast<Key>(p.y) + static_cast<Key>(size_.y) * static_cast<Key>(p.z));
  }
  bool is_inside(const glm::ivec3& p) const noexcept {
    return glm::all(glm::greaterThanEqual(p, glm::ivec3(0))) && glm::all(glm::lessThan(p, size_));
  }

  Node& node(const glm::ivec3& position) {
    const auto [entry, is_new] = nodes_.try_emplace(key_of(position));
    Node& n = entry->second;
    if (is_new) {
      n.position = position;
      load(n);
      count_ += cost_;
    }
    return n;
  }

  void load(Node& n) const {
    const glm::ivec3 low = k_brick * n.position;
    if (lattice_.has_voxel_resolution())
      load_voxels(n, low);
    else
      load_samples(n, low);
  }
  /// Loads a brick of a lattice with one sample per voxel.
  void load_voxels(Node& n, const glm::ivec3& low) const {
    const glm::ivec3 v = lattice_.voxel_of(low), size = after_.base().size;
    if (v.x <= -k_brick || v.x >= size.x) return;
    const Brick* brick = after_.brick_at(low);
    for (int z = 0; z < k_brick; ++z)
      for (int y = 0; y < k_brick; ++y) {
        if (v.y + y < 0 || v.z + z < 0 || v.y + y >= size.y || v.z + z >= size.z) continue;
        n.solid[static_cast<std::size_t>(z)] |= (voxels_from(v.x, v.y + y, v.z + z) & 0xff) << (8 * y);
      }
    if (brick == nullptr) return;
    for (std::size_t z = 0; z < k_brick; ++z) {
      n.removed[z] = n.solid[z] & ~brick->kept[z];
      n.solid[z] &= brick->kept[z];
    }
  }
  /// Loads a brick of a lattice that is finer than the voxels. Evaluates each sample in voxels that overlap
  /// bricks of cuts; in other voxels all samples equal the centre.
  void load_samples(Node& n, const glm::ivec3& low) const {
    const glm::ivec3 last = low + (k_brick - 1), size = after_.base().size;
    const glm::ivec3 from = glm::max(lattice_.voxel_of(low), glm::ivec3(0)),
                     to = glm::min(lattice_.voxel_of(last), size - 1);
    const Brick* brick = after_.brick_at(low);
    if (brick && brick->is_hollow) {
      // All matter of a hollow brick is removed.
      n.removed.fill(~std::uint64_t{0});
      return;
    }
    for (int z = from.z; z <= to.z; ++z)
      for (int y = from.y; y <= to.y; ++y) {
        const Row row = row_of(from.x, y, z);
        for (int x = from.x; x <= to.x; ++x) {
          const glm::ivec3 v(x, y, z), a = glm::max(lattice_.low_of(v), low),
                                       b = glm::min(lattice_.high_of(v), last);
          const std::uint64_t bit = std::uint64_t{2} << (x - from.x);
          // All samples of a voxel are equal if the voxel equals its 26 neighbours.
          const bool is_uniform = (row.all & bit) != 0 || (row.any & bit) == 0;
          if (is_uniform ||
              (brick == nullptr && !after_.has_brick(lattice_.low_of(v), lattice_.high_of(v)))) {
            if (row.centre & bit) fill(n.solid, a - low, b - low);
          } else {
            n.is_mixed = true;
            for (int k = a.z; k <= b.z; ++k)
              for (int j = a.y; j <= b.y; ++j)
                for (int i = a.x; i <= b.x; ++i)
                  if (field_.value(lattice_.volume_from_lattice(glm::dvec3(i, j, k))) >= 0)
                    fill(n.solid, glm::ivec3(i, j, k) - low, glm::ivec3(i, j, k) - low);
          }
        }
      }
    if (brick == nullptr) return;
    for (std::size_t z = 0; z < k_brick; ++z) {
      n.removed[z] = n.solid[z] & ~brick->kept[z];
      n.solid[z] &= brick->kept[z];
    }
  }
  static void fill(Words& words, const glm::ivec3& a, const glm::ivec3& b) noexcept {
    const std::uint64_t x = (0xffull >> (7 - (b.x - a.x))) << a.x;
    for (int z = a.z; z <= b.z; ++z)
      for (int y = a.y; y <= b.y; ++y) words[static_cast<std::size_t>(z)] |= x << (8 * y);
  }
  /// Bits of the voxels of a row, the first for voxel x - 1. `centre`: the voxel is solid. `all`, `any`: all
  /// (any) of the voxel and its 26 neighbours are solid.
  struct Row {
    std::uint64_t centre = 0, all = 0, any = 0;
  };
  Row row_of(int x, int y, int z) const noexcept {
    std::uint64_t all = ~std::uint64_t{0}, any = 0, centre = 0;
    for (int dz = -1; dz <= 1; ++dz)
      for (int dy = -1; dy <= 1; ++dy) {
        const std::uint64_t word = voxels_from(x - 1, y + dy, z + dz);
        all &= word, any |= word;
        if (dy == 0 && dz == 0) centre = word;
      }
    return {centre, all & all << 1 & all >> 1, any | any << 1 | any >> 1};
  }
  /// Returns the bits of at least 16 voxels, the first for voxel x; 0 beyond the grid.
  std::uint64_t voxels_from(int x, int y, int z) const noexcept {
    const glm::ivec3& size = after_.base().size;
    if (y < 0 || z < 0 || y >= size.y || z >= size.z) return 0;
    const std::uint64_t* row = bits_.row(y, z);
    if (x < 0) return row[0] << -x;
    const int word = x >> 6, shift = x & 63;
    std::uint64_t out = row[word] >> shift;
    if (shift > 48 && word + 1 < bits_.words_per_row()) out |= row[word + 1] << (64 - shift);
    return out;
  }

  /// Finds the solid parts in the changed bricks and in the bricks next to them. Returns false if the brick
  /// limit is exceeded.
  bool flood_near_cut() {
    // Seeds are the solid samples next to removed samples. If a new brick overlaps mixed voxels, the samples
    // of these voxels are evaluated for the first time; then the samples in and next to this brick are also
    // seeds.
    bool is_over_limit = false;
    const glm::ivec3& per = lattice_.per_voxel();
    const int longest = std::min(k_brick, std::max({per.x, per.y, per.z}));
    after_.for_bricks_in(glm::ivec3(0), lattice_.size() - 1,
                         [&](const glm::ivec3& first, const Brick& brick) {
                           const Brick* old = before_.brick_at(first);
                           if (is_over_limit || old == &brick) return;
                           Words changed;
                           for (std::size_t z = 0; z < k_brick; ++z)
                             changed[z] = (old ? old->kept[z] : ~std::uint64_t{0}) & ~brick.kept[z];
                           const glm::ivec3 position = first / k_brick;
                           const bool is_refined =
                               old == nullptr && !lattice_.has_voxel_resolution() && node(position).is_mixed;
                           if (is_refined) changed.fill(~std::uint64_t{0});
                           if (!has_bits(changed)) return;
                           add_seeds(node(position), dilated(changed));
                           for_neighbours([&](const glm::ivec3& d) {
                             Words neighbours = neighbours_in(changed, d);
                             if (!has_bits(neighbours) || !is_inside(position + d)) return;
                             // Extends the seeds to all samples of the voxels at the brick's border.
                             for (int i = 1; is_refined && i < longest; ++i) neighbours = dilated(neighbours);
                             add_seeds(node(position + d), neighbours);
                           });
                           is_over_limit = count_ > max_bricks_;
                         });
    if (is_over_limit) return false;
    std::vector<Key> near;
    for (const auto& [key, n] : nodes_)
      if (n.is_near) near.push_back(key);
    for (const Key key : near)
      for (;;) {
        const Node& n = nodes_.at(key);
        Words unreached = difference(n.seeds, n.reached);
        if (!has_bits(unreached)) break;
        // Starts a part at the first of these seeds.
        Words seed{};
        for (std::size_t z = 0; z < k_brick; ++z)
          if (unreached[z] != 0) {
            seed[z] = unreached[z] & (~unreached[z] + 1);
            break;
          }
        const int part = static_cast<int>(parts_.size());
        parts_.emplace_back();
        parent_.push_back(part);
        parts_.back().steps.push_back({key, seed});
        std::deque<Step> outside;
        while (!parts_[static_cast<std::size_t>(part)].steps.empty()) {
          Part& current = parts_[static_cast<std::size_t>(part)];
          const Step step = current.steps.front();
          current.steps.pop_front();
          const auto known = nodes_.find(step.key);
          if (known == nodes_.end() || !known->second.is_near) {
            outside.push_back(step);
            continue;
          }
          grow(part, step);
        }
        parts_[static_cast<std::size_t>(part)].steps = std::move(outside);
      }
    return true;
  }

  static void add_seeds(Node& n, const Words& samples) noexcept {
    n.is_near = true;
    add(n.seeds, intersection(samples, n.solid));
  }

  int root(int part) noexcept {
    while (parent_[static_cast<std::size_t>(part)] != part) part = parent_[static_cast<std::size_t>(part)];
    return part;
  }

  /// Floods one brick with a part and appends the part's steps into neighbouring bricks. Joins the part with
  /// another part that it meets in the brick.
  void grow(int part, const Step& step) {
    Node& n = nodes_.at(step.key);
    Words fresh = intersection(step.entering, n.solid);
    Words* own = nullptr;
    for (auto& [number, words] : n.parts)
      if (root(number) == part) {
        own = &words;
        fresh = difference(fresh, words);
      }
    if (!has_bits(fresh)) return;
    for (Words grown = intersection(dilated(fresh), n.solid); grown != fresh;
         grown = intersection(dilated(fresh), n.solid))
      fresh = grown;
    // Joins the part with the first part that it meets. Steps into this brick or from it join further parts.
    for (const auto& [number, words] : n.parts)
      if (const int other = root(number); other != part && has_bits(intersection(words, fresh))) {
        join(part, other);
        break;
      }
    part = root(part);
    if (own) {
      add(*own, fresh);
    } else {
      n.parts.push_back({part, fresh});
    }
    parts_[static_cast<std::size_t>(part)].nodes.push_back(step.key);
    for (const std::uint64_t word : difference(fresh, n.reached))
      parts_[static_cast<std::size_t>(part)].samples += std::popcount(word);
    add(n.reached, fresh);
    for_neighbours([&](const glm::ivec3& d) {
      const glm::ivec3 neighbour = n.position + d;
      if (!is_inside(neighbour)) return;
      if (const Words entering = neighbours_in(fresh, d); has_bits(entering))
        parts_[static_cast<std::size_t>(part)].steps.push_back({key_of(neighbour), entering});
    });
  }
  void join(int a, int b) {
    a = root(a), b = root(b);
    if (a == b) return;
    if (a > b) std::swap(a, b);
    parent_[static_cast<std::size_t>(b)] = a;
    Part &target = parts_[static_cast<std::size_t>(a)], &source = parts_[static_cast<std::size_t>(b)];
    target.steps.insert(target.steps.end(), source.steps.begin(), source.steps.end());
    target.nodes.insert(target.nodes.end(), source.nodes.begin(), source.nodes.end());
    target.samples += source.samples;
    source = {};
  }

  /// Grows the parts in turns, each by one brick per turn.
  Separation::Kind flood_outward() {
    std::vector<int> open;
    for (int p = 0; p < static_cast<int>(parts_.size()); ++p)
      if (root(p) == p) open.push_back(p);
    for (;;) {
      // A part without pending steps is complete.
      std::vector<int> growing;
      for (const int p : open) {
        if (root(p) != p) continue;
        if (!parts_[static_cast<std::size_t>(p)].steps.empty()) {
          growing.push_back(p);
          continue;
        }
        if (parts_[static_cast<std::size_t>(p)].samples < min_samples_) continue;
        if (const Separation::Kind kind = classify(p); kind != Separation::Kind::connected)
          return kind == Separation::Kind::detached && !lattice_.has_voxel_resolution()
                     ? Separation::Kind::pending
                     : kind;
      }
      open = std::move(growing);
      if (open.size() <= 1) return Separation::Kind::connected;
      for (const int p : open) {
        if (root(p) != p || parts_[static_cast<std::size_t>(p)].steps.empty()) continue;
        if (count_ > max_bricks_) return Separation::Kind::pending;
        Part& current = parts_[static_cast<std::size_t>(p)];
        const Step step = current.steps.front();
        current.steps.pop_front();
        node(position_of(step.key));
        grow(p, step);
      }
    }
  }
  glm::ivec3 position_of(Key key) const noexcept {
    const auto x = static_cast<Key>(size_.x), y = static_cast<Key>(size_.y);
    return {static_cast<int>(key % x), static_cast<int>(key / x % y), static_cast<int>(key / x / y)};
  }

  /// Classifies a complete part: detached if only removed samples are between it and another part. Otherwise
  /// it was separate before the cut, too, and the result is `connected`.
  Separation::Kind classify(int part) {
    std::unordered_map<Key, Words> visited;
    std::deque<Step> steps;
    const auto own_in = [&](const Node& n) {
      Words own{};
      for (const auto& [number, words] : n.parts)
        if (root(number) == part) add(own, words);
      return own;
    };
    const auto spread = [&](const glm::ivec3& position, const Words& from) {
      steps.push_back({key_of(position), dilated(from)});
      for_neighbours([&](const glm::ivec3& d) {
        if (!is_inside(position + d)) return;
        if (const Words entering = neighbours_in(from, d); has_bits(entering))
          steps.push_back({key_of(position + d), entering});
      });
    };
    for (const Key key : parts_[static_cast<std::size_t>(part)].nodes) {
      const Node& n = nodes_.at(key);
      spread(n.position, own_in(n));
    }
    while (!steps.empty()) {
      const Step step = steps.front();
      steps.pop_front();
      if (count_ > max_bricks_) return Separation::Kind::pending;
      Node& n = node(position_of(step.key));
      Words& known = visited[step.key];
      Words fresh = difference(intersection(step.entering, n.removed), known);
      if (!has_bits(fresh)) continue;
      for (Words grown = intersection(dilated(fresh), n.removed); grown != fresh;
           grown = intersection(dilated(fresh), n.removed))
        fresh = grown;
      add(known, fresh);
      // Solid samples of another part next to the removed ones, in this brick and in its neighbours.
      if (has_bits(difference(intersection(dilated(fresh), n.solid), own_in(n))))
        return Separation::Kind::detached;
      bool is_next_to_other = false;
      for_neighbours([&](const glm::ivec3& d) {
        if (!is_inside(n.position + d) || is_next_to_other) return;
        const Words entering = neighbours_in(fresh, d);
        if (!has_bits(entering)) return;
        const Node& neighbour = node(n.position + d);
        is_next_to_other = has_bits(difference(intersection(entering, neighbour.solid), own_in(neighbour)));
        steps.push_back({key_of(neighbour.position), entering});
      });
      if (is_next_to_other) return Separation::Kind::detached;
    }
    return Separation::Kind::connected;
  }

  const Field& field_;
  const Occupancy& bits_;
  const Version &before_, &after_;
  const CutLattice& lattice_;
  glm::ivec3 size_;  ///< in bricks
  std::int64_t max_bricks_, min_samples_, cost_, count_ = 0;
  std::unordered_map<Key, Node> nodes_;
  std::vector<Part> parts_;
  std::vector<int> parent_;
};

}  // namespace

Separation detect_detachment(const Field& field, const Occupancy& bits, const Version& before,
                             const Version& after, const SeparationLimits& limits) {
  return Search(field, bits, before, after, limits).run();
}

}  // namespace trephine::volume
