#include "apps/verify/exact_traversal.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace trephine::verify {

namespace {

__extension__ typedef __int128 Int128;

/// Integer of any size: sign and base 2^32 digits, lowest first.
struct Big {
  int sign = 0;
  std::vector<std::uint32_t> digits;

  static Big from_double_times_power(double x, int power) {  // x * 2^power must be an integer
    Big b;
    if (x == 0) return b;
    int e = 0;
    const double m = std::frexp(std::fabs(x), &e);  // x = m * 2^e
    auto bits = static_cast<std::uint64_t>(std::ldexp(m, 53));
    int shift = e - 53 + power;
    while (shift < 0) {
      bits >>= 1;  // loses only zeros, since the product is an integer
      ++shift;
    }
    b.sign = x < 0 ? -1 : 1;
    b.digits.assign(static_cast<std::size_t>(shift / 32), 0);
    const int in = shift % 32;
    std::uint64_t carry = 0;
    for (int part = 0; part < 2; ++part) {
      const std::uint64_t digit = (bits >> (32 * part) & 0xffffffffu) << in | carry;
      b.digits.push_back(static_cast<std::uint32_t>(digit));
      carry = digit >> 32;
    }
    b.digits.push_back(static_cast<std::uint32_t>(carry));
    b.trim();
    return b;
  }
  void trim() {
    while (!digits.empty() && digits.back() == 0) digits.pop_back();
    if (digits.empty()) sign = 0;
  }
  static int compare_magnitude(const Big& a, const Big& b) {
    if (a.digits.size() != b.digits.size()) return a.digits.size() < b.digits.size() ? -1 : 1;
    for (std::size_t i = a.digits.size(); i-- > 0;)
      if (a.digits[i] != b.digits[i]) return a.digits[i] < b.digits[i] ? -1 : 1;
    return 0;
  }
  friend Big operator-(const Big& a, const Big& b) {
    if (b.sign == 0) return a;
    Big r;
    if (a.sign == 0) {
      r = b;
      r.sign = -b.sign;
      return r;
    }
    if (a.sign != b.sign) {  // magnitudes add
      r.sign = a.sign;
      std::uint64_t carry = 0;
      for (std::size_t i = 0; i < std::max(a.digits.size(), b.digits.size()) || carry; ++i) {
        carry += (i < a.digits.size() ? a.digits[i] : 0u);
        carry += (i < b.digits.size() ? b.digits[i] : 0u);
        r.digits.push_back(static_cast<std::uint32_t>(carry));
        carry >>= 32;
      }
    } else {
      const int order = compare_magnitude(a, b);
      if (order == 0) return r;
      const Big& big = order > 0 ? a : b;
      const Big& small = order > 0 ? b : a;
      r.sign = order > 0 ? a.sign : -a.sign;
      std::int64_t borrow = 0;
      for (std::size_t i = 0; i < big.digits.size(); ++i) {
        std::int64_t d = static_cast<std::int64_t>(big.digits[i]) - borrow -
                         (i < small.digits.size() ? static_cast<std::int64_t>(small.digits[i]) : 0);
        borrow = d < 0;
        if (d < 0) d += std::int64_t{1} << 32;
        r.digits.push_back(static_cast<std::uint32_t>(d));
      }
    }
    r.trim();
    return r;
  }
  friend Big operator*(const Big& a, const Big& b) {
    Big r;
    r.sign = a.sign * b.sign;
    r.digits.assign(a.digits.size() + b.digits.size(), 0);
    for (std::size_t i = 0; i < a.digits.size(); ++i) {
      std::uint64_t carry = 0;
      for (std::size_t j = 0; j < b.digits.size(); ++j) {
        carry += r.digits[i + j] + static_cast<std::uint64_t>(a.digits[i]) * b.digits[j];
        r.digits[i + j] = static_cast<std::uint32_t>(carry);
        carry >>= 32;
      }
      r.digits[i + b.digits.size()] = static_cast<std::uint32_t>(carry);
    }
    r.trim();
    return r;
  }
};

/// Crossing of the plane at k + 1/2 on an axis.
struct Crossing {
  int axis;
  int k;  // between voxel k and k + 1
};

/// Coordinates as integers in units of 2^-power: in 128 bits if they fit, else Big.
class Scaled {
 public:
  Scaled(const std::array<double, 3>& a, const std::array<double, 3>& b) {
    int lowest = -1, highest = 1;  // exponents; halves are always needed
    for (const auto* p : {&a, &b})
      for (const double x : *p) {
        if (x == 0) continue;
        int e = 0;
        const double m = std::frexp(x, &e);
        auto bits = static_cast<std::int64_t>(std::ldexp(m, 53));
        int low = e - 53;
        while (bits % 2 == 0) {
          bits /= 2;
          ++low;
        }
        lowest = std::min(lowest, low);
        highest = std::max(highest, e);
      }
    power_ = -lowest;
    is_small_ = highest + power_ <= 60;
    for (std::size_t i = 0; i < 3; ++i) {
      if (is_small_) {
        a_[i] = static_cast<std::int64_t>(std::ldexp(a[i], power_));
        b_[i] = static_cast<std::int64_t>(std::ldexp(b[i], power_));
      } else {
        big_a_[i] = Big::from_double_times_power(a[i], power_);
        big_b_[i] = Big::from_double_times_power(b[i], power_);
      }
      step_[i] = b[i] > a[i] ? 1 : b[i] < a[i] ? -1 : 0;
    }
    start_ = a;
    end_ = b;
  }
  int step(std::size_t axis) const { return step_[axis]; }

  /// Returns a negative number if p comes before q on the moved line, positive if after, 0 if equal.
  int order(const Crossing& p, const Crossing& q) const {
    if (p.axis == q.axis) return (p.k - q.k) * step_[static_cast<std::size_t>(p.axis)];
    const auto i = static_cast<std::size_t>(p.axis), j = static_cast<std::size_t>(q.axis);
    int sign = 0;
    if (is_small_) {
      const Int128 half = Int128{1} << (power_ - 1);
      const Int128 left = ((2 * Int128{p.k} + 1) * half - a_[i]) * (Int128{b_[j]} - a_[j]);
      const Int128 right = ((2 * Int128{q.k} + 1) * half - a_[j]) * (Int128{b_[i]} - a_[i]);
      sign = left < right ? -1 : left > right ? 1 : 0;
    } else {
      const Big left =
          (Big::from_double_times_power(p.k + 0.5, power_) - big_a_[i]) * (big_b_[j] - big_a_[j]);
      const Big right =
          (Big::from_double_times_power(q.k + 0.5, power_) - big_a_[j]) * (big_b_[i] - big_a_[i]);
      sign = (left - right).sign;
    }
    if (sign != 0) return sign * step_[i] * step_[j];
    // The line's coordinates are moved by e, e^2, e^3; the larger of the two moves decides.
    if (p.axis < q.axis) return step_[i] > 0 ? -1 : 1;
    return step_[j] > 0 ? 1 : -1;
  }
  long double parameter(const Crossing& p) const {
    const auto i = static_cast<std::size_t>(p.axis);
    return (static_cast<long double>(p.k) + 0.5L - static_cast<long double>(start_[i])) /
           (static_cast<long double>(end_[i]) - static_cast<long double>(start_[i]));
  }
  /// Returns the voxel of a coordinate: ties go up, since e > 0.
  static int voxel(double x) {
    const double r = std::round(x);  // half away from zero
    double v = r;
    if (x < 0 && r - x == -0.5) v = r + 1;
    return static_cast<int>(v);
  }

 private:
  int power_ = 0;
  bool is_small_ = true;
  std::array<std::int64_t, 3> a_{}, b_{};
  std::array<Big, 3> big_a_, big_b_;
  std::array<int, 3> step_{};
  std::array<double, 3> start_{}, end_{};
};

}  // namespace

std::vector<ExactVisit> exact_traversal(const std::array<double, 3>& start, const std::array<double, 3>& end,
                                        const std::array<int, 3>& low, const std::array<int, 3>& high) {
  const Scaled line(start, end);
  std::vector<Crossing> crossings;
  std::array<int, 3> at{};
  for (std::size_t a = 0; a < 3; ++a) {
    const int first = Scaled::voxel(start[a]), last = Scaled::voxel(end[a]);
    // Planes that bound the box's voxels, among those between the two end voxels.
    const int from = std::max(std::min(first, last), low[a] - 1),
              to = std::min(std::max(first, last) - 1, high[a]);
    for (int k = from; k <= to; ++k) crossings.push_back({static_cast<int>(a), k});
    at[a] = first;
    if (from <= to && first < low[a]) at[a] = low[a] - 1;
    if (from <= to && first > high[a]) at[a] = high[a] + 1;
  }
  std::sort(crossings.begin(), crossings.end(),
            [&line](const Crossing& p, const Crossing& q) { return line.order(p, q) < 0; });
  std::vector<ExactVisit> visits;
  const auto report = [&](long double t, int axis, int step) {
    for (std::size_t a = 0; a < 3; ++a)
      if (at[a] < low[a] || at[a] > high[a]) return;
    visits.push_back({at, t, axis, step});
  };
  report(0, -1, 0);
  for (const Crossing& c : crossings) {
    const auto a = static_cast<std::size_t>(c.axis);
    at[a] += line.step(a);
    report(line.parameter(c), c.axis, line.step(a));
  }
  return visits;
}

const char* ray_family_name(int family) {
  constexpr const char* k_names[k_ray_families] = {"random",
                                                   "half-lattice",
                                                   "quarter-lattice, 1 ulp off",
                                                   "axis-parallel with signed zeros",
                                                   "zero length",
                                                   "through corners",
                                                   "from afar",
                                                   "denormal offsets",
                                                   "lattice direction through a corner",
                                                   "1 ulp long on an axis"};
  return k_names[family];
}

std::optional<std::array<int, 3>> first_solid(const std::array<double, 3>& start,
                                              const std::array<double, 3>& end,
                                              const std::array<int, 3>& size,
                                              const std::function<bool(int, int, int)>& is_solid) {
  for (const ExactVisit& v : exact_traversal(start, end, {0, 0, 0}, {size[0] - 1, size[1] - 1, size[2] - 1}))
    if (is_solid(v.voxel[0], v.voxel[1], v.voxel[2])) return v.voxel;
  return std::nullopt;
}

AdversarialRay adversarial_ray(std::uint64_t number, std::uint64_t seed) {
  std::uint64_t state = (number + 1) * 0x9e3779b97f4a7c15ull ^ seed * 0xd1342543de82ef95ull;
  const auto next = [&state] {  // xorshift64*
    state ^= state >> 12;
    state ^= state << 25;
    state ^= state >> 27;
    return state * 2685821657736338717ull;
  };
  next();
  const auto integer = [&](int low, int high) {
    return low + static_cast<int>(next() % static_cast<std::uint64_t>(high - low + 1));
  };
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(next() >> 11) * 0x1p-53;
  };
  AdversarialRay ray{};
  const int family = static_cast<int>(number % k_ray_families);
  for (std::size_t a = 0; a < 3; ++a) {
    double &p = ray.start[a], &q = ray.end[a];
    switch (family) {
      case 0:
        p = uniform(-4, 12), q = uniform(-4, 12);
        break;
      case 1:
        p = 0.5 * integer(-6, 22), q = 0.5 * integer(-6, 22);
        break;
      case 2:
        p = 0.25 * integer(-12, 44), q = 0.25 * integer(-12, 44);
        break;
      case 3:
        p = q = 0.5 * integer(-1, 17);
        break;
      case 4:
        p = q = integer(0, 1) ? 0.5 * integer(-2, 18) : uniform(-1, 9);
        break;
      case 5:
        p = integer(-1, 8) + 0.5, q = p;
        break;
      case 6:
        p = uniform(-1e7, 1e7), q = integer(0, 1) ? uniform(-1, 9) : -p + 0.5 * integer(-8, 8);
        break;
      case 7:
        p = 0.5 * integer(-2, 18), q = 0.5 * integer(-2, 18);
        break;
      case 8:
        p = integer(-1, 8) + 0.5, q = p;
        break;
      default:
        p = integer(0, 1) ? 0.5 * integer(-2, 18) : uniform(-1, 9), q = 0.5 * integer(-2, 18);
        break;
    }
  }
  const auto ulp = [&](double x) {
    const int direction = integer(-1, 1);
    return direction == 0 ? x : std::nextafter(x, direction * 1e300);
  };
  if (family == 2 || family == 9)
    for (std::size_t a = 0; a < 3; ++a) ray.start[a] = ulp(ray.start[a]), ray.end[a] = ulp(ray.end[a]);
  if (family == 3) {
    const auto a = static_cast<std::size_t>(integer(0, 2));
    ray.end[a] += integer(0, 1) ? integer(-12, 12) : uniform(-12, 12);
    for (std::size_t b = 0; b < 3; ++b) {
      if (ray.start[b] == 0) ray.start[b] = integer(0, 1) ? 0.0 : -0.0;
      if (ray.end[b] == 0) ray.end[b] = integer(0, 1) ? 0.0 : -0.0;
    }
  }
  if (family == 5) {  // a diagonal through lattice corners
    const int length = integer(1, 9);
    for (std::size_t a = 0; a < 3; ++a) ray.end[a] += integer(-1, 1) * length;
  }
  if (family == 7)
    for (std::size_t a = 0; a < 3; ++a) {
      if (ray.start[a] == 0) ray.start[a] = integer(-2, 2) * 5e-324;
      if (ray.end[a] == 0) ray.end[a] = integer(-2, 2) * 2.3e-310;
    }
  if (family == 8) {  // a lattice direction scaled so that ends fall anywhere on the line through a corner
    const double before = 0.125 * integer(0, 24), after = 0.125 * integer(0, 24);
    for (std::size_t a = 0; a < 3; ++a) {
      const int d = integer(-3, 3);
      ray.start[a] -= before * d;
      ray.end[a] += after * d;
    }
  }
  if (family == 9) {
    const auto a = static_cast<std::size_t>(integer(0, 2));
    ray.end[a] = std::nextafter(ray.start[a], integer(0, 1) ? 1e300 : -1e300);
  }
  return ray;
}

}  // namespace trephine::verify
