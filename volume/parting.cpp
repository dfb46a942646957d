#include "volume/parting.h"

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

bool is_any(const Words& w) noexcept {
  std::uint64_t all = 0;
  for (const std::uint64_t word : w) all |= word;
  return all != 0;
}
Words both(const Words& a, const Words& b) noexcept {
  Words out;
  for (std::size_t z = 0; z < k_brick; ++z) out[z] = a[z] & b[z];
  return out;
}
Words without(const Words& a, const Words& b) noexcept {
  Words out;
  for (std::size_t z = 0; z < k_brick; ++z) out[z] = a[z] & ~b[z];
  return out;
}
void add(Words& to, const Words& more) noexcept {
  for (std::size_t z = 0; z < k_brick; ++z) to[z] |= more[z];
}
std::uint64_t wider_x(std::uint64_t w) noexcept { return w | (w & ~k_last_x) << 1 | (w & ~k_first_x) >> 1; }
std::uint64_t wider_y(std::uint64_t w) noexcept { return w | w << 8 | w >> 8; }
/// With the 26 around each.
Words wider(const Words& w) noexcept {
  Words flat, out;
  for (std::size_t z = 0; z < k_brick; ++z) flat[z] = wider_y(wider_x(w[z]));
  for (std::size_t z = 0; z < k_brick; ++z)
    out[z] = flat[z] | (z > 0 ? flat[z - 1] : 0) | (z + 1 < k_brick ? flat[z + 1] : 0);
  return out;
}
/// Samples of the brick in direction `d` that touch some of `w`.
Words beyond(const Words& w, const glm::ivec3& d) noexcept {
  Words flat;
  for (std::size_t z = 0; z < k_brick; ++z) {
    std::uint64_t s = w[z];
    s = d.x > 0 ? (s & k_last_x) >> 7 : d.x < 0 ? (s & k_first_x) << 7 : wider_x(s);
    s = d.y > 0 ? (s & k_last_y) >> 56 : d.y < 0 ? (s & k_first_y) << 56 : wider_y(s);
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
void for_around(Each&& each) {
  for (int n = 0; n < 27; ++n)
    if (n != 13) each(glm::ivec3(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1));
}

class Search {
 public:
  Search(const Field& field, const Occupancy& bits, const Version& before, const Version& after,
         const PartingLimits& limits)
      : field_(field),
        bits_(bits),
        before_(before),
        after_(after),
        lattice_(after.lattice()),
        size_((lattice_.size() + (k_brick - 1)) / k_brick),
        most_(limits.most_bricks),
        least_(limits.least_samples),
        cost_(lattice_.is_of_voxels() ? 1 : 3) {}

  Parting run() {
    const bool is_known = flood_beside_cut();
    return {is_known ? flood_onward() : Parting::Kind::pending, count_};
  }

 private:
  using Key = std::uint64_t;
  struct Node {
    glm::ivec3 place{0};
    Words solid{}, removed{};
    Words seeds{};    ///< next to the cut
    Words reached{};  ///< by any part
    /// Samples of each part that reached it, by the part's number when it did.
    std::vector<std::pair<int, Words>> parts;
    bool is_near = false, is_mixed = false;  ///< next to the cut; a voxel in it is not as all around it
  };
  struct Step {
    Key at;
    Words entering;
  };
  struct Part {
    std::deque<Step> steps;  ///< still to be gone
    std::vector<Key> nodes;
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

  Node& node(const glm::ivec3& place) {
    const auto [found, is_new] = nodes_.try_emplace(key_of(place));
    Node& n = found->second;
    if (is_new) {
      n.place = place;
      load(n);
      count_ += cost_;
    }
    return n;
  }

  void load(Node& n) const {
    const glm::ivec3 low = k_brick * n.place;
    if (lattice_.is_of_voxels())
      load_voxels(n, low);
    else
      load_samples(n, low);
  }
  /// Each sample is a voxel.
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
  /// Voxels into which bricks of cuts reach are asked sample by sample, others are what their middles are.
  void load_samples(Node& n, const glm::ivec3& low) const {
    const glm::ivec3 last = low + (k_brick - 1), size = after_.base().size;
    const glm::ivec3 from = glm::max(lattice_.voxel_of(low), glm::ivec3(0)),
                     to = glm::min(lattice_.voxel_of(last), size - 1);
    const Brick* brick = after_.brick_at(low);
    if (brick && brick->is_hollow) {
      // Whatever was there is gone.
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
          // Samples are alike if all voxels around them are.
          const bool is_alike = (row.all & bit) != 0 || (row.any & bit) == 0;
          if (is_alike || (brick == nullptr && !after_.has_brick(lattice_.low_of(v), lattice_.high_of(v)))) {
            if (row.own & bit) fill(n.solid, a - low, b - low);
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
  /// Voxels of a row from x - 1 on, a bit each: which are solid, with all 26 around, with any of them or
  /// itself.
  struct Row {
    std::uint64_t own = 0, all = 0, any = 0;
  };
  Row row_of(int x, int y, int z) const noexcept {
    std::uint64_t all = ~std::uint64_t{0}, any = 0, own = 0;
    for (int dz = -1; dz <= 1; ++dz)
      for (int dy = -1; dy <= 1; ++dy) {
        const std::uint64_t word = voxels_from(x - 1, y + dy, z + dz);
        all &= word, any |= word;
        if (dy == 0 && dz == 0) own = word;
      }
    return {own, all & all << 1 & all >> 1, any | any << 1 | any >> 1};
  }
  /// 16 voxels at least, from x on; beyond the grid nothing is solid.
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

  /// Solid parts next to the bricks that changed, as far as they are connected there. False: too
  /// much changed.
  bool flood_beside_cut() {
    // Removed voxels, and voxels that a brick came to reach into, which are asked again; with their
    // neighbours.
    bool is_too_much = false;
    const glm::ivec3& per = lattice_.per_voxel();
    const int longest = std::min(k_brick, std::max({per.x, per.y, per.z}));
    after_.for_bricks_in(
        glm::ivec3(0), lattice_.size() - 1, [&](const glm::ivec3& first, const Brick& brick) {
          const Brick* was = before_.brick_at(first);
          if (is_too_much || was == &brick) return;
          Words gone;
          for (std::size_t z = 0; z < k_brick; ++z)
            gone[z] = (was ? was->kept[z] : ~std::uint64_t{0}) & ~brick.kept[z];
          const glm::ivec3 place = first / k_brick;
          const bool is_asked = was == nullptr && !lattice_.is_of_voxels() && node(place).is_mixed;
          if (is_asked) gone.fill(~std::uint64_t{0});
          if (!is_any(gone)) return;
          add_seeds(node(place), wider(gone));
          for_around([&](const glm::ivec3& d) {
            Words beside = beyond(gone, d);
            if (!is_any(beside) || !is_inside(place + d)) return;
            // As far as a voxel reaches that the brick asked again.
            for (int i = 1; is_asked && i < longest; ++i) beside = wider(beside);
            add_seeds(node(place + d), beside);
          });
          is_too_much = count_ > most_;
        });
    if (is_too_much) return false;
    std::vector<Key> near;
    for (const auto& [key, n] : nodes_)
      if (n.is_near) near.push_back(key);
    for (const Key key : near)
      for (;;) {
        const Node& n = nodes_.at(key);
        Words left = without(n.seeds, n.reached);
        if (!is_any(left)) break;
        // One of them.
        Words one{};
        for (std::size_t z = 0; z < k_brick; ++z)
          if (left[z] != 0) {
            one[z] = left[z] & (~left[z] + 1);
            break;
          }
        const int part = static_cast<int>(parts_.size());
        parts_.emplace_back();
        parent_.push_back(part);
        parts_.back().steps.push_back({key, one});
        std::deque<Step> outside;
        while (!parts_[static_cast<std::size_t>(part)].steps.empty()) {
          Part& own = parts_[static_cast<std::size_t>(part)];
          const Step step = own.steps.front();
          own.steps.pop_front();
          const auto known = nodes_.find(step.at);
          if (known == nodes_.end() || !known->second.is_near) {
            outside.push_back(step);
            continue;
          }
          go(part, step);
        }
        parts_[static_cast<std::size_t>(part)].steps = std::move(outside);
      }
    return true;
  }

  static void add_seeds(Node& n, const Words& beside) noexcept {
    n.is_near = true;
    add(n.seeds, both(beside, n.solid));
  }

  int root(int part) noexcept {
    while (parent_[static_cast<std::size_t>(part)] != part) part = parent_[static_cast<std::size_t>(part)];
    return part;
  }

  /// One part goes into one brick: all that it can reach in it, and the next steps from there.
  void go(int part, const Step& step) {
    Node& n = nodes_.at(step.at);
    Words fresh = both(step.entering, n.solid);
    Words* own = nullptr;
    for (auto& [number, words] : n.parts)
      if (root(number) == part) {
        own = &words;
        fresh = without(fresh, words);
      }
    if (!is_any(fresh)) return;
    for (Words grown = both(wider(fresh), n.solid); grown != fresh; grown = both(wider(fresh), n.solid))
      fresh = grown;
    // Parts that meet become one.
    for (const auto& [number, words] : n.parts)
      if (const int other = root(number); other != part && is_any(both(words, fresh))) {
        join(part, other);
        break;
      }
    part = root(part);
    if (own) {
      add(*own, fresh);
    } else {
      n.parts.push_back({part, fresh});
    }
    parts_[static_cast<std::size_t>(part)].nodes.push_back(step.at);
    for (const std::uint64_t word : without(fresh, n.reached))
      parts_[static_cast<std::size_t>(part)].samples += std::popcount(word);
    add(n.reached, fresh);
    for_around([&](const glm::ivec3& d) {
      const glm::ivec3 to = n.place + d;
      if (!is_inside(to)) return;
      if (const Words entering = beyond(fresh, d); is_any(entering))
        parts_[static_cast<std::size_t>(part)].steps.push_back({key_of(to), entering});
    });
  }
  void join(int a, int b) {
    a = root(a), b = root(b);
    if (a == b) return;
    if (a > b) std::swap(a, b);
    parent_[static_cast<std::size_t>(b)] = a;
    Part &to = parts_[static_cast<std::size_t>(a)], &from = parts_[static_cast<std::size_t>(b)];
    to.steps.insert(to.steps.end(), from.steps.begin(), from.steps.end());
    to.nodes.insert(to.nodes.end(), from.nodes.begin(), from.nodes.end());
    to.samples += from.samples;
    from = {};
  }

  /// In turns, a brick each.
  Parting::Kind flood_onward() {
    std::vector<int> open;
    for (int p = 0; p < static_cast<int>(parts_.size()); ++p)
      if (root(p) == p) open.push_back(p);
    for (;;) {
      // Who has nowhere to go is whole.
      std::vector<int> left;
      for (const int p : open) {
        if (root(p) != p) continue;
        if (!parts_[static_cast<std::size_t>(p)].steps.empty()) {
          left.push_back(p);
          continue;
        }
        if (parts_[static_cast<std::size_t>(p)].samples < least_) continue;
        if (const Parting::Kind tied = is_tied(p); tied != Parting::Kind::holds)
          return tied == Parting::Kind::parted && !lattice_.is_of_voxels() ? Parting::Kind::pending : tied;
      }
      open = std::move(left);
      if (open.size() <= 1) return Parting::Kind::holds;
      for (const int p : open) {
        if (root(p) != p || parts_[static_cast<std::size_t>(p)].steps.empty()) continue;
        if (count_ > most_) return Parting::Kind::pending;
        Part& own = parts_[static_cast<std::size_t>(p)];
        const Step step = own.steps.front();
        own.steps.pop_front();
        node(place_of(step.at));
        go(p, step);
      }
    }
  }
  glm::ivec3 place_of(Key key) const noexcept {
    const auto x = static_cast<Key>(size_.x), y = static_cast<Key>(size_.y);
    return {static_cast<int>(key % x), static_cast<int>(key / x % y), static_cast<int>(key / x / y)};
  }

  /// Of a whole part: does what was removed lead from it to another one?
  Parting::Kind is_tied(int part) {
    std::unordered_map<Key, Words> gone;
    std::deque<Step> steps;
    const auto own_in = [&](const Node& n) {
      Words own{};
      for (const auto& [number, words] : n.parts)
        if (root(number) == part) add(own, words);
      return own;
    };
    const auto spread = [&](const glm::ivec3& place, const Words& from) {
      steps.push_back({key_of(place), wider(from)});
      for_around([&](const glm::ivec3& d) {
        if (!is_inside(place + d)) return;
        if (const Words entering = beyond(from, d); is_any(entering))
          steps.push_back({key_of(place + d), entering});
      });
    };
    for (const Key key : parts_[static_cast<std::size_t>(part)].nodes) {
      const Node& n = nodes_.at(key);
      spread(n.place, own_in(n));
    }
    while (!steps.empty()) {
      const Step step = steps.front();
      steps.pop_front();
      if (count_ > most_) return Parting::Kind::pending;
      Node& n = node(place_of(step.at));
      Words& seen = gone[step.at];
      Words fresh = without(both(step.entering, n.removed), seen);
      // Solid next to what was removed, and not its own.
      if (!is_any(fresh)) continue;
      for (Words grown = both(wider(fresh), n.removed); grown != fresh; grown = both(wider(fresh), n.removed))
        fresh = grown;
      add(seen, fresh);
      if (is_any(without(both(wider(fresh), n.solid), own_in(n)))) return Parting::Kind::parted;
      bool is_other = false;
      for_around([&](const glm::ivec3& d) {
        if (!is_inside(n.place + d) || is_other) return;
        const Words entering = beyond(fresh, d);
        if (!is_any(entering)) return;
        const Node& beside = node(n.place + d);
        is_other = is_any(without(both(entering, beside.solid), own_in(beside)));
        steps.push_back({key_of(beside.place), entering});
      });
      if (is_other) return Parting::Kind::parted;
    }
    return Parting::Kind::holds;
  }

  const Field& field_;
  const Occupancy& bits_;
  const Version &before_, &after_;
  const CutLattice& lattice_;
  glm::ivec3 size_;  ///< in bricks
  std::int64_t most_, least_, cost_, count_ = 0;
  std::unordered_map<Key, Node> nodes_;
  std::vector<Part> parts_;
  std::vector<int> parent_;
};

}  // namespace

Parting parting(const Field& field, const Occupancy& bits, const Version& before, const Version& after,
                const PartingLimits& limits) {
  return Search(field, bits, before, after, limits).run();
}

}  // namespace trephine::volume
