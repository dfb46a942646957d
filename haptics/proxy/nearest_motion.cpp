#include "haptics/proxy/nearest_motion.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "volume/base/error.h"

namespace trephine::haptics {

using glm::dvec3;

namespace {

constexpr std::size_t k_size = 6;      // coordinates of a motion
constexpr double k_tolerance = 1e-9;   // violation of a bound, as a share of the hardest push
constexpr double k_least_part = 1e-5;  // a smaller part of a unit bound counts as dependent on the others
constexpr std::size_t k_most_changes = 200;  // of the active set

/// A motion or a bound, with rotations scaled so that the distance of two motions is the Euclidean one.
struct Vector {
  dvec3 first, second;
  friend double dot(const Vector& a, const Vector& b) noexcept {
    return glm::dot(a.first, b.first) + glm::dot(a.second, b.second);
  }
  void add(double size, const Vector& v) noexcept { first += size * v.first, second += size * v.second; }
};

/// Bounds that the motion meets with equality, and the orthonormal basis of their vectors.
class ActiveSet {
 public:
  std::size_t size() const noexcept { return count_; }
  std::size_t operator[](std::size_t i) const noexcept { return bounds_[i]; }
  bool contains(std::size_t bound) const noexcept {
    for (std::size_t i = 0; i < count_; ++i)
      if (bounds_[i] == bound) return true;
    return false;
  }
  /// Returns the part of v that is orthogonal to all active vectors. `shares`: v - part as a sum of shares of
  /// the active vectors.
  Vector split(const Vector& v, std::array<double, k_size>& shares) const noexcept {
    Vector rest = v;
    std::array<double, k_size> along{};
    // The second pass removes the rounding of the first.
    for (int pass = 0; pass < 2; ++pass)
      for (std::size_t i = 0; i < count_; ++i) {
        const double part = dot(basis_[i], rest);
        along[i] += part;
        rest.add(-part, basis_[i]);
      }
    for (std::size_t i = count_; i-- > 0;) {
      double sum = along[i];
      for (std::size_t j = i + 1; j < count_; ++j) sum -= upper_[i][j] * shares[j];
      shares[i] = sum / upper_[i][i];
    }
    return rest;
  }
  void add(std::size_t bound, const Vector& v) noexcept {
    bounds_[count_] = bound;
    vectors_[count_] = v;
    extend();
  }
  void remove(std::size_t i) noexcept {
    const std::size_t last = count_;
    std::array<std::size_t, k_size> bounds = bounds_;
    std::array<Vector, k_size> vectors = vectors_;
    count_ = i;
    for (std::size_t k = i + 1; k < last; ++k)
      bounds_[count_] = bounds[k], vectors_[count_] = vectors[k], extend();
  }

 private:
  /// Appends the vector at count_ to the basis.
  void extend() noexcept {
    Vector rest = vectors_[count_];
    for (std::size_t i = 0; i < count_; ++i) upper_[i][count_] = 0;
    for (int pass = 0; pass < 2; ++pass)
      for (std::size_t i = 0; i < count_; ++i) {
        const double part = dot(basis_[i], rest);
        upper_[i][count_] += part;
        rest.add(-part, basis_[i]);
      }
    const double length = std::sqrt(dot(rest, rest));
    upper_[count_][count_] = length;
    basis_[count_] = {rest.first / length, rest.second / length};
    ++count_;
  }
  std::array<std::size_t, k_size> bounds_{};
  std::array<Vector, k_size> vectors_{}, basis_{};
  std::array<std::array<double, k_size>, k_size> upper_{};  ///< vectors as sums of the basis
  std::size_t count_ = 0;
};

}  // namespace

bool find_pushes(const Twist& request, double square, std::span<MotionBound> bounds) noexcept {
  TREPHINE_ASSERT(bounds.size() <= k_max_motion_bounds);
  const double radius = std::sqrt(square);
  std::array<Vector, k_max_motion_bounds> vectors;
  std::array<double, k_max_motion_bounds> lengths;  // of the vectors before they were made unit vectors
  for (std::size_t k = 0; k < bounds.size(); ++k) {
    MotionBound& b = bounds[k];
    b.push = 0;
    Vector v{b.normal, b.moment / radius};
    lengths[k] = std::sqrt(dot(v, v));
    vectors[k] = lengths[k] > 0 ? Vector{v.first / lengths[k], v.second / lengths[k]} : v;
  }
  const Vector requested{request.translation, radius * request.rotation};
  ActiveSet active;
  std::array<double, k_size> pushes{};  // of the active bounds, for unit vectors
  bool is_solved = false;
  for (std::size_t change = 0; change < k_most_changes && !is_solved;) {
    // Computed from the pushes, so that roundings do not accumulate.
    Vector motion = requested;
    double hardest = 1;
    for (std::size_t i = 0; i < active.size(); ++i) {
      motion.add(pushes[i], vectors[active[i]]);
      hardest = std::max(hardest, pushes[i]);
    }
    // The bound that is violated most becomes active.
    std::size_t worst = bounds.size();
    double least = -k_tolerance * hardest;
    for (std::size_t k = 0; k < bounds.size(); ++k) {
      if (!(lengths[k] > 0) || active.contains(k)) continue;
      const double excess = dot(vectors[k], motion) - bounds[k].least / lengths[k];
      if (excess < least) least = excess, worst = k;
    }
    if (worst == bounds.size()) {
      is_solved = true;
      break;
    }
    double push = 0;
    for (bool is_active = false; !is_active && change < k_most_changes; ++change) {
      std::array<double, k_size> shares{};
      const Vector rest = active.split(vectors[worst], shares);
      // The push grows until the bound is satisfied, or the push of an active bound is 0.
      double growth = 1e300;
      std::size_t released = k_size;
      for (std::size_t i = 0; i < active.size(); ++i)
        if (shares[i] > 0 && pushes[i] / shares[i] < growth) growth = pushes[i] / shares[i], released = i;
      const double part = dot(rest, rest);
      if (part > k_least_part * k_least_part && active.size() < k_size) {
        const double excess = dot(vectors[worst], motion) - bounds[worst].least / lengths[worst];
        if (const double whole = -excess / part; whole <= growth)
          growth = whole, released = k_size, is_active = true;
        motion.add(growth, rest);
      } else if (released == k_size) {
        change = k_most_changes;  // the bounds contradict each other
        break;
      }
      for (std::size_t i = 0; i < active.size(); ++i) pushes[i] -= growth * shares[i];
      push += growth;
      if (is_active) {
        pushes[active.size()] = push;
        active.add(worst, vectors[worst]);
      } else {
        active.remove(released);
        for (std::size_t i = released; i + 1 < k_size; ++i) pushes[i] = pushes[i + 1];
      }
    }
  }
  for (std::size_t i = 0; i < active.size(); ++i)
    bounds[active[i]].push = std::max(0.0, pushes[i]) / lengths[active[i]];
  return is_solved;
}

}  // namespace trephine::haptics
