#include "volume/cuts/removal_shape.h"

namespace trephine::volume {

namespace {

/// Splines of distance samples with spacing h overestimate the distance to a wall of curvature 1/r: by
/// h^2/(8r) along a cylindrical hole, by twice that at its spherical end. The samples are reduced by the mean
/// of both.
constexpr double k_spline_share = 3.0 / 16;
/// Largest allowance as a share of the radius; limits balls with a radius of only one or two lattice steps.
constexpr double k_max_allowance = 0.02;
/// Allowance of a tool body, as a share of that of a ball: its side is curved in one direction, and its ends
/// hardly.
constexpr double k_side_share = 1.0 / 3;
/// Points along a cell's edge: a body's surface crosses more cells than a ball's and is flatter in them.
constexpr int k_points_of_a_body = 4;

double allowance(double radius_mm, const Frame& lattice) {
  const glm::dvec3& h = lattice.spacing();
  const double square = (h.x * h.x + h.y * h.y + h.z * h.z) / 3;
  return radius_mm > 0 ? std::min(k_spline_share * square / radius_mm, k_max_allowance * radius_mm) : 0;
}

/// Number of points along a cell's edge at which removed volume is counted: 4 for a ball of many cells, 8 for
/// a small one. The error of the volume is then typically within 0.05 %, and 0.2 % at worst.
int points_per_edge(double radius_mm, const Frame& lattice) {
  const glm::dvec3& h = lattice.spacing();
  return radius_mm < 8 * std::max({h.x, h.y, h.z}) ? 8 : 4;
}

}  // namespace

SweptShape::SweptShape(const Sweep& s, const Version& version)
    : SweptShape(s.start_world, s.continues, s.radius_mm, version) {
  allowance = static_cast<float>(volume::allowance(s.radius_mm, version.lattice().frame()));
  const glm::dvec3 d = s.end_world - s.start_world;
  const double l = glm::length(d);
  length = static_cast<float>(l);
  for (int a = 0; a < 3; ++a) along[a] = l > 0 ? static_cast<float>(d[a] / l) : 0.0f;
  cell_reach += 1e-6f * (cell_reach + radius + length);  // rounding
}

SweptShape::SweptShape(const ToolSweep& s, int first, int last, int count, const Version& version)
    : SweptShape(s.start.at_world, s.continues, s.body.min_radius(), version) {
  n = k_points_of_a_body;
  allowance = static_cast<float>(k_side_share * volume::allowance(radius, version.lattice().frame()));
  length = along[0] = along[1] = along[2] = 0;
  set_body(s.body);
  float farthest = body_reach_;
  for (int i = first; i <= last; ++i) {
    const ToolPose pose = between(s.start, s.end, static_cast<double>(i) / count);
    const glm::vec3 at(pose.at_world - s.start.at_world), axis(pose.axis_world);
    stamps_[static_cast<std::size_t>(stamp_count_++)] = {{at.x, at.y, at.z}, {axis.x, axis.y, axis.z}};
    farthest = std::max(farthest, glm::length(at) + body_reach_);
  }
  cell_reach += 1e-6f * (cell_reach + farthest);  // rounding
}

void SweptShape::sweep_brick(const RemovalKernels& kernels, const glm::vec3& corner, const glm::vec3& middle,
                             const float* old, BrickSweep& out) const {
  if (stamp_count_ == 0) {
    // Past its end, the sweep is only its last ball. All points of the brick's cells, not only its samples,
    // must be past the end.
    const bool is_ball = projection(middle) - brick_extent_along() - cell_reach >= length;
    return kernels.sweep_brick(*this, &corner.x, is_ball, old, out);
  }
  near_count_ = 0;
  for (int i = 0; i < stamp_count_; ++i)
    if (const BodyShape::Stamp& stamp = stamps_[static_cast<std::size_t>(i)]; !misses_brick(stamp, middle))
      near_stamps_[static_cast<std::size_t>(near_count_++)] = stamp;
  out.is_in_band = near_count_ > 0;
  if (out.is_in_band)
    kernels.stamp_brick(*this, body_, near_stamps_.data(), near_count_, &corner.x, old, out);
}

void SweptShape::sample(const RemovalKernels& kernels, const CellPoints& points, const glm::vec3& at,
                        bool is_past_end, std::uint64_t* words) const {
  if (stamp_count_ == 0) return kernels.sample(*this, points, &at.x, is_past_end, words);
  kernels.sample_stamps(*this, body_, near_stamps_.data(), near_count_, points, &at.x, words);
}

SweptShape::SweptShape(const glm::dvec3& start, bool is_continued, double smallest_radius,
                       const Version& version)
    : start_world(start),
      continues(is_continued),
      n(points_per_edge(smallest_radius, version.lattice().frame())) {
  const Frame& frame = version.lattice().frame();
  radius = static_cast<float>(smallest_radius);
  band = static_cast<float>(version.band_mm());
  for (int a = 0; a < 3; ++a) {
    ax[a] = static_cast<float>(frame.axes()[0][a]);
    ay[a] = static_cast<float>(frame.axes()[1][a]);
    az[a] = static_cast<float>(frame.axes()[2][a]);
  }
  cell_reach = static_cast<float>(0.5 * frame.diagonal_mm() * 1.0001);
}

void SweptShape::set_body(const ToolBody& b) {
  body_.is_drum = b.form == ToolBody::Form::drum;
  body_.radius = static_cast<float>(b.radius), body_.length = static_cast<float>(b.length);
  body_middle_ = static_cast<float>(b.middle()), body_reach_ = static_cast<float>(b.reach());
  if (!body_.is_drum) {
    const double taper = b.length > 0 ? (b.radius - b.end_radius) / b.length : 0;
    body_.growth = static_cast<float>(-taper);
    body_.slope = static_cast<float>(taper / std::sqrt(1 - taper * taper));
    return;
  }
  const ToolBody::Corner corner = b.corner();
  body_.edge = static_cast<float>(b.edge), body_.bulge = static_cast<float>(b.bulge());
  body_.half = static_cast<float>(0.5 * b.length);
  body_.corner = static_cast<float>(corner.along), body_.core = static_cast<float>(corner.off);
  body_.lean_sine = static_cast<float>(corner.lean);
  body_.lean_cosine = static_cast<float>(std::sqrt(1 - corner.lean * corner.lean));
}

}  // namespace trephine::volume
