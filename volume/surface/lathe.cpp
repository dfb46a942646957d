#include "volume/surface/lathe.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "volume/base/deterministic_math.h"
#include "volume/base/error.h"

namespace trephine::volume {

using glm::dvec3;

namespace {

constexpr double k_turn = 2 * 3.14159265358979323846;

/// Number of points of a thread's section within one pitch: the starts of root, flank, crest and flank.
constexpr int k_section_points = 4;

std::array<double, k_section_points> section_of(const TurnedThread& thread) {
  const double flank = 0.5 * (1 - thread.root - thread.crest);
  return {0, thread.root, thread.root + flank, thread.root + flank + thread.crest};
}

/// Returns the number of whole turns of the ridge.
int turns_of(const TurnedThread& thread) noexcept {
  return static_cast<int>(std::floor((thread.end - thread.begin) / thread.pitch + 1e-9)) - 1;
}

/// Returns the height of the ridge as a share of its full height. `share`: height without the run-out.
double ridge_of(const TurnedThread& thread, double along, double share) noexcept {
  const double end = turns_of(thread) + 1, at = (along - thread.begin) / thread.pitch;
  return share * std::clamp(std::min(at, end - at) / thread.run_out, 0.0, 1.0);
}

class Lathe {
 public:
  explicit Lathe(int facets) : facets_(facets) {
    for (int i = 0; i < facets; ++i)
      directions_.emplace_back(deterministic_cos(k_turn * i / facets), deterministic_sin(k_turn * i / facets),
                               0);
  }

  void add_ring(const TurnedRing& ring) {
    const std::uint32_t first = count();
    for (const dvec3& direction : directions_)
      out_.vertices.push_back(ring.radius * direction + dvec3(0, 0, ring.along));
    if (has_ring_)
      for (std::uint32_t i = 0; i < columns(); ++i) {
        const std::uint32_t j = (i + 1) % columns();
        add(last_ + i, last_ + j, first + i);
        add(last_ + j, first + j, first + i);
      }
    has_ring_ = true, last_ = first;
  }

  /// Adds the ridge as a grid whose rows rise by one pitch per turn, so that its edges follow the thread.
  void add_thread(const TurnedThread& thread) {
    const std::array<double, k_section_points> section = section_of(thread);
    // Row q of column i is at begin + pitch (turns[q] + i / facets).
    std::vector<double> turns;
    for (int turn = 0; turn < turns_of(thread); ++turn)
      for (const double point : section) turns.push_back(turn + point);
    turns.push_back(turns_of(thread));
    const auto rows = static_cast<std::uint32_t>(turns.size());
    const std::uint32_t first = count(), low = last_;
    for (std::uint32_t q = 0; q < rows; ++q)
      for (int i = 0; i < facets_; ++i) {
        const double along = thread.begin + thread.pitch * (turns[q] + static_cast<double>(i) / facets_);
        const double share = ridge_of(thread, along, q % k_section_points >= 2 ? 1 : 0);
        out_.vertices.push_back(glm::dvec3(0, 0, along) +
                                (thread.core + share * (thread.outer - thread.core)) *
                                    directions_[static_cast<std::size_t>(i)]);
      }
    const auto at = [&](std::uint32_t row, std::uint32_t column) { return first + row * columns() + column; };
    const std::uint32_t end = columns() - 1;
    for (std::uint32_t q = 0; q + 1 < rows; ++q)
      for (std::uint32_t i = 0; i < end; ++i) {
        add(at(q, i), at(q, i + 1), at(q + 1, i));
        add(at(q, i + 1), at(q + 1, i + 1), at(q + 1, i));
      }
    // The last column joins the first one a pitch higher.
    for (std::uint32_t q = 0; q + k_section_points + 1 < rows; ++q) {
      const std::uint32_t p = q + k_section_points;
      add(at(q, end), at(p, 0), at(q + 1, end));
      add(at(p, 0), at(p + 1, 0), at(q + 1, end));
    }
    // Joins the first row to the ring below, and closes the step of one pitch with a fan.
    for (std::uint32_t i = 0; i < end; ++i) {
      add(low + i, low + i + 1, at(0, i));
      add(low + i + 1, at(0, i + 1), at(0, i));
    }
    add(low + end, low, at(0, end));
    add(low, at(0, 0), at(0, end));
    for (std::uint32_t q = 0; q < k_section_points; ++q) add(at(q, 0), at(q + 1, 0), at(0, end));
    top_of_thread_ = at(rows - 1, 0), step_ = k_section_points;
  }

  /// Adds the ring that follows a thread.
  void add_ring_after_thread(const TurnedRing& ring) {
    const std::uint32_t top = top_of_thread_, end = columns() - 1, high = count();
    has_ring_ = false;
    add_ring(ring);
    for (std::uint32_t i = 0; i < end; ++i) {
      add(top + i, top + i + 1, high + i);
      add(top + i + 1, high + i + 1, high + i);
    }
    for (std::uint32_t q = step_; q > 0; --q)
      add(top + end - q * columns(), top, top + end - (q - 1) * columns());
    add(top + end, top, high + end);
    add(top, high, high + end);
  }

  TurnedSolid close(double low, double high) && {
    const std::uint32_t bottom = count(), top = bottom + 1;
    out_.vertices.emplace_back(0, 0, low);
    out_.vertices.emplace_back(0, 0, high);
    for (std::uint32_t i = 0; i < columns(); ++i) {
      const std::uint32_t j = (i + 1) % columns();
      add(bottom, j, i);
      add(last_ + i, last_ + j, top);
    }
    return std::move(out_);
  }

 private:
  void add(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    out_.triangles.insert(out_.triangles.end(), {a, b, c});
  }
  std::uint32_t count() const { return static_cast<std::uint32_t>(out_.vertices.size()); }
  std::uint32_t columns() const { return static_cast<std::uint32_t>(facets_); }

  int facets_;
  std::vector<dvec3> directions_;
  TurnedSolid out_;
  bool has_ring_ = false;
  std::uint32_t last_ = 0, top_of_thread_ = 0, step_ = 0;
};

}  // namespace

TurnedSolid turned_solid(double low, std::span<const TurnedRing> rings, double high, int facets,
                         const std::optional<TurnedThread>& thread) {
  TREPHINE_ASSERT(!rings.empty() && facets >= 3 && (!thread || turns_of(*thread) >= 1));
  Lathe lathe(facets);
  bool is_thread_pending = thread.has_value();
  for (std::size_t i = 0; i < rings.size(); ++i) {
    if (i > 0 && is_thread_pending && rings[i].along > thread->begin) {
      is_thread_pending = false;
      lathe.add_thread(*thread);
      lathe.add_ring_after_thread(rings[i]);
    } else {
      lathe.add_ring(rings[i]);
    }
  }
  TREPHINE_ASSERT(!is_thread_pending);
  return std::move(lathe).close(low, high);
}

double radius_of(const TurnedThread& thread, double along, double turn) noexcept {
  const double turns = (along - thread.begin) / thread.pitch - turn, part = turns - std::floor(turns);
  if (!(turns > 0 && turns < turns_of(thread))) return thread.core;
  const double flank = 0.5 * (1 - thread.root - thread.crest);
  const double height = part < thread.root                          ? 0
                        : part < thread.root + flank                ? (part - thread.root) / flank
                        : part < thread.root + flank + thread.crest ? 1
                                                                    : (1 - part) / flank;
  return thread.core + ridge_of(thread, along, height) * (thread.outer - thread.core);
}

}  // namespace trephine::volume
