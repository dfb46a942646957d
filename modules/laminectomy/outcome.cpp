#include "modules/laminectomy/outcome.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

#include "volume/base/parallel.h"
#include "volume/scan/traversal.h"

namespace trephine::laminectomy {

using glm::dvec3;
using volume::CanalSection, volume::k_canal_reach;

namespace {

constexpr double k_section = 1;      // mm between sections
constexpr double k_medial = 0.7;     // share of the canal's half width; facets are lateral to it
constexpr double k_facet_wide = 12;  // mm beyond the canal's wall to the transverse process

double median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

bool touches_border(const volume::Volume& scan, int label) {
  if (label < 0) return false;
  const glm::ivec3& size = scan.size;
  for (int a = 0; a < 3; ++a)
    for (const int end : {0, size[a] - 1}) {
      const int b = (a + 1) % 3, c = (a + 2) % 3;
      for (int i = 0; i < size[b]; ++i)
        for (int k = 0; k < size[c]; ++k) {
          glm::ivec3 v;
          v[a] = end, v[b] = i, v[c] = k;
          if (scan.labels[scan.index(v.x, v.y, v.z)] == label) return true;
        }
    }
  return false;
}

class Judge {
 public:
  Judge(const volume::Field& bone, int label, const volume::Version& version, Outcome& outcome)
      : bone_(bone), scan_(bone.volume()), label_(label), version_(version), outcome_(outcome) {}

  LocatedStatus find_canal() {
    const int count = static_cast<int>((outcome_.frame.high - outcome_.frame.low) / k_section) + 1;
    outcome_.sections.resize(static_cast<std::size_t>(count));
    parallel_for(count, 0, [&](int i) {
      outcome_.sections[static_cast<std::size_t>(i)] = volume::canal_section(
          outcome_.frame, outcome_.frame.low + i * k_section, {bone_, label_}, &version_);
    });
    const auto pedicles = volume::find_pedicles(outcome_.frame, {bone_, label_}, outcome_.sections);
    if (!pedicles) return LocatedError{"no pedicles on both sides of the canal", outcome_.frame.middle};
    outcome_.half_width = pedicles->half_width;
    outcome_.pedicle_low = pedicles->low, outcome_.pedicle_high = pedicles->high;
    if (!find_roof()) return LocatedError{"no lamina closes the canal at the back", outcome_.frame.middle};
    double least = 1e300, widest = 0;
    for (int i = outcome_.roof_first; i <= outcome_.roof_last; ++i) {
      const CanalSection& s = outcome_.sections[static_cast<std::size_t>(i)];
      if (const double area = s.area(false); area >= 0 && area < least) least = area, outcome_.narrowest = i;
      if (s.has_roof(true)) continue;
      outcome_.opened_length += k_section;
      if (const double width = s.opening(); width > widest) widest = width, outcome_.widest_opened = i;
    }
    if (least == 1e300) return LocatedError{"the canal is not closed at any lamina", outcome_.frame.middle};
    return std::nullopt;
  }

  /// Finds the start of the spinous process: the median depth of the outer surface of the laminae, half way
  /// from the midline to the sides of the canal.
  void find_spinous_process() {
    std::vector<double> behind;
    for (int i = outcome_.roof_first; i <= outcome_.roof_last; ++i) {
      const CanalSection& s = outcome_.sections[static_cast<std::size_t>(i)];
      for (const double x : {-0.5 * outcome_.half_width, 0.5 * outcome_.half_width}) {
        double inner = -1, outer = -1;
        for (double y = 0; y < 2 * k_canal_reach && (outer < 0 || y < outer + k_pores); y += k_fine)
          if (is_bone({x, y, s.z})) {
            if (inner < 0) inner = y;
            outer = y;
          }
        if (outer > 0) behind.push_back(outer);
      }
    }
    outcome_.roof_back = behind.empty() ? 2 * k_canal_reach : median(behind);
  }

  void weigh_parts() {
    struct Sum {
      double size = 0, removed = 0;
      dvec3 size_moment{0.0}, removed_moment{0.0};
    };
    std::array<Sum, 6> sums;
    const double upper = 0.5 * (outcome_.pedicle_low + outcome_.pedicle_high),
                 lower = 2 * outcome_.pedicle_low - upper;
    for_points([&](const dvec3& p, double size, bool is_removed) {
      const double distance = std::abs(p.x);
      if (p.y <= 0 || distance > outcome_.half_width + k_facet_wide) return;
      const std::size_t side = p.x > 0 ? 0 : 1;
      std::size_t part = 0;
      if (distance < 0.5 * outcome_.half_width && p.y > outcome_.roof_back)
        part = 1;
      else if (distance >= k_medial * outcome_.half_width && p.z > upper)
        part = 2 + side;
      else if (distance >= k_medial * outcome_.half_width && p.z < lower)
        part = 4 + side;
      Sum& sum = sums[part];
      const double removed_size = is_removed ? size : 0;
      sum.size += size, sum.removed += removed_size;
      sum.size_moment += size * p, sum.removed_moment += removed_size * p;
    });
    const auto part_of = [&](const Sum& sum) {
      Part part{sum.size, sum.removed, outcome_.frame.middle};
      if (sum.removed > 0)
        part.at_world = outcome_.frame.world(sum.removed_moment / sum.removed);
      else if (sum.size > 0)
        part.at_world = outcome_.frame.world(sum.size_moment / sum.size);
      return part;
    };
    outcome_.lamina = part_of(sums[0]), outcome_.spinous_process = part_of(sums[1]);
    for (std::size_t side = 0; side < 2; ++side)
      outcome_.upper_facet[side] = part_of(sums[2 + side]),
      outcome_.lower_facet[side] = part_of(sums[4 + side]);
  }

  /// Measures the least width of the arch, viewed from the back, in rows from the centre of the pedicle to
  /// the same distance below its lower edge. Skips rows in which the bone did not reach the midline before
  /// the operation.
  void measure_pars() {
    const double upper = 0.5 * (outcome_.pedicle_low + outcome_.pedicle_high),
                 lower = 2 * outcome_.pedicle_low - upper;
    for (std::size_t side = 0; side < 2; ++side) {
      const double sign = side == 0 ? 1 : -1;
      Pars& pars = outcome_.pars[side];
      pars = {1e300, 1e300, outcome_.frame.middle};
      for (double z = lower; z <= upper; z += k_row) {
        double edge = 0, inner = 0;
        const double width = row_width(sign, z, false, edge, inner);
        if (width <= 0 || inner > 0) continue;  // no bone, or a gap before the midline
        pars.before = std::min(pars.before, width);
        const double width_after = row_width(sign, z, true, edge, inner);
        if (width_after < pars.after) {
          pars.after = width_after;
          pars.at_world = outcome_.frame.world({sign * 0.5 * (edge + inner), 0.7 * outcome_.roof_back, z});
        }
      }
      if (pars.before == 1e300) pars.before = pars.after = 0;
    }
  }

 private:
  /// Finds the consecutive closed sections around the one nearest to the vertebra's centre.
  bool find_roof() {
    const auto has_roof = [this](int i) {
      return outcome_.sections[static_cast<std::size_t>(i)].has_roof(false);
    };
    const int count = static_cast<int>(outcome_.sections.size());
    int nearest = -1;
    for (int i = 0; i < count; ++i)
      if (has_roof(i) &&
          (nearest < 0 || std::abs(outcome_.sections[static_cast<std::size_t>(i)].z) <
                              std::abs(outcome_.sections[static_cast<std::size_t>(nearest)].z)))
        nearest = i;
    if (nearest < 0) return false;
    outcome_.roof_first = outcome_.roof_last = nearest;
    while (outcome_.roof_first > 0 && has_roof(outcome_.roof_first - 1)) --outcome_.roof_first;
    while (outcome_.roof_last + 1 < count && has_roof(outcome_.roof_last + 1)) ++outcome_.roof_last;
    return true;
  }

  static constexpr double k_fine = 0.3, k_row = 0.5, k_pores = 4;  // mm

  bool is_bone(const dvec3& local) const {
    const dvec3 p = scan_.frame.volume_from_world(outcome_.frame.world(local));
    return bone_.value(p) >= 0 && is_of_vertebra(p);
  }
  bool is_kept(const dvec3& local) const {
    return version_.distance(scan_.frame.volume_from_world(outcome_.frame.world(local))) > 0;
  }
  bool is_of_vertebra(const dvec3& p) const {
    if (label_ < 0) return true;
    const glm::ivec3 v = volume::voxel_of(p);
    return scan_.contains(v) && scan_.labels[scan_.index(v.x, v.y, v.z)] == label_;
  }

  /// Returns the width of the arch in a row, mm, from its outer edge on one side inward to the midline or to
  /// the end of the bone. Sets `edge` and `inner` to the distances of both ends from the midline, mm.
  double row_width(double sign, double z, bool is_after, double& edge, double& inner) const {
    const auto is_covered = [&](double x) {
      for (double y = 0; y <= outcome_.roof_back; y += k_fine) {
        const dvec3 p(sign * x, y, z);
        if (is_bone(p) && (!is_after || is_kept(p))) return true;
      }
      return false;
    };
    edge = inner = 0;
    double x = outcome_.half_width + k_facet_wide;
    while (x > 0 && !is_covered(x)) x -= k_fine;
    if (x <= 0) return 0;
    edge = x;
    while (x > 0 && is_covered(x)) x -= k_fine;
    inner = x > k_fine ? x : 0.0;
    return edge - inner;
  }

  /// Divides the voxels of the vertebra into equal parts, and calls each(centre in the vertebra's frame, mm3,
  /// is_removed) for each part.
  template <class Each>
  void for_points(const Each& each) const {
    constexpr double k_half_width = 45;  // mm to each side: no vertebra is wider
    constexpr double k_point = 0.4;      // largest spacing of the points, mm
    const volume::Frame& frame = scan_.frame;
    // The box around the vertebra, in voxels.
    dvec3 low(1e300), high(-1e300);
    for (int c = 0; c < 8; ++c) {
      const dvec3 p = frame.volume_from_world(
          outcome_.frame.world({c & 1 ? k_half_width : -k_half_width, c & 2 ? 2.5 * k_half_width : 0.0,
                                c & 4 ? outcome_.frame.high : outcome_.frame.low}));
      low = glm::min(low, p), high = glm::max(high, p);
    }
    const glm::ivec3 from = glm::max(glm::ivec3(glm::floor(low)), glm::ivec3(0)),
                     to = glm::min(glm::ivec3(glm::ceil(high)), scan_.size - 1);
    const glm::ivec3 parts(glm::ceil(frame.spacing() / k_point));
    const double size = frame.voxel_mm3() / (parts.x * parts.y * parts.z);
    for (int z = from.z; z <= to.z; ++z)
      for (int y = from.y; y <= to.y; ++y)
        for (int x = from.x; x <= to.x; ++x) {
          const std::size_t index = scan_.index(x, y, z);
          if (label_ >= 0 ? scan_.labels[index] != label_ : bone_.at_index(index) < 0) continue;
          for (int n = 0; n < parts.x * parts.y * parts.z; ++n) {
            const dvec3 part(n % parts.x, n / parts.x % parts.y, n / (parts.x * parts.y));
            const dvec3 p = dvec3(x, y, z) - 0.5 + (part + 0.5) / dvec3(parts);
            const dvec3 local = outcome_.frame.local(frame.world_from_volume(p));
            if (local.z >= outcome_.frame.low && local.z <= outcome_.frame.high)
              each(local, size, version_.distance(p) <= 0);
          }
        }
  }

  const volume::Field& bone_;
  const volume::Volume& scan_;
  int label_;
  const volume::Version& version_;
  Outcome& outcome_;
};

}  // namespace

Result<Outcome, LocatedError> judge(const volume::Field& bone, int label, const dvec3* canal_world,
                                    const volume::Version& version) {
  const auto frame = volume::find_vertebra({bone, label}, canal_world);
  if (!frame) return frame.error();
  Outcome outcome;
  outcome.frame = frame.value();
  Judge judge(bone, label, version, outcome);
  if (auto error = judge.find_canal()) return *std::move(error);
  outcome.is_at_border = touches_border(bone.volume(), label);
  judge.find_spinous_process();
  judge.weigh_parts();
  judge.measure_pars();
  return outcome;
}

int slice_of(const volume::Volume& scan, const dvec3& world) noexcept {
  return std::clamp(volume::voxel_of(scan.frame.volume_from_world(world)).z, 0, scan.size.z - 1);
}

}  // namespace trephine::laminectomy
