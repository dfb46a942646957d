#include "modules/drilling/burr.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "sim/edit_session.h"
#include "volume/offset_field.h"

namespace trephine::drilling {

using glm::dvec3;

namespace {
constexpr double k_memory_voxels =
    1.5;  // contact lost over a way of fewer voxel diagonals is the same contact
constexpr double k_credit_seconds = 0.02;  // removal that may be saved up while the ball closes in
constexpr double k_step_mm = 0.05;         // the ball moves in bites of at most this, each paid for
constexpr double k_turn_cosine = 0.7071;   // a wall farther than this from the axis turns it ...
constexpr double k_turn_seconds = 0.25;    // ... over about this, when pressed by a radius
}  // namespace

void Burr::lift() {
  has_centre_ = false;
  axis_ = dvec3(0);
  free_mm_ = owed_mm3_ = 0;
}

double touch_radius(const BurrOptions& options, const volume::Volume& volume) noexcept {
  const double step = volume::OffsetField::step_for(options.radius, volume);
  return std::max(0.5 * options.radius, options.radius - step);
}

sim::ToolSpec BurrOptions::spec() const {
  sim::ToolSpec spec{"burr",
                     {{"diameter", 2 * radius},
                      {"removal_rate", removal_rate},
                      {"feed_limit", feed_limit},
                      {"is_kinematic", is_kinematic ? 1 : 0}}};
  if (is_round) spec.settings.emplace_back("is_round", 1);  // what is not as usual
  return spec;
}

bool Burr::set(std::string_view name, double value) {
  if (name == "is_kinematic" && (value == 0 || value == 1))
    options_.is_kinematic = value == 1;
  else if (name == "is_round" && (value == 0 || value == 1))
    options_.is_round = value == 1;
  else if (name == "diameter" && value > 0 && value >= options_.smallest && value <= 30)
    options_.radius = 0.5 * value;
  else if (name == "removal_rate" && value > 0 && value <= 1e5)
    options_.removal_rate = value;
  else if (name == "feed_limit" && value > 0 && value <= 1e4)
    options_.feed_limit = value;
  else
    return false;
  lift();
  return true;
}

double Burr::sweep_to(const dvec3& centre, volume::RemovalEditor& editor, volume::RemovalReport& report) {
  const volume::RemovalReport one =
      editor.remove({has_centre_ ? centre_ : centre, centre, options_.radius, has_centre_});
  centre_ = centre;
  has_centre_ = true;
  report.removed_units += one.removed_units;
  report.bricks_changed += one.bricks_changed;
  if (one.bricks_changed > 0) report.box = sim::united(report.box, one.box);
  return editor.working().mm3_of(one.removed_units);
}

void Burr::turn_axis(const haptics::ServoRecord& tick, double dt) noexcept {
  // The axis of approach is the first normal. A wall that stands steeply to it, and is pressed, turns it; a
  // new touch on such a wall starts anew.
  const dvec3& normal = tick.normal_world;
  const double cosine = glm::dot(axis_, normal);
  if (cosine >= k_turn_cosine) return;
  if (!has_centre_) {
    axis_ = normal;
  } else if (cosine > -0.99) {
    const double press = glm::dot(tick.proxy_world - tick.pose.position_world, normal) / options_.radius;
    axis_ = glm::normalize(axis_ + dt / k_turn_seconds * std::clamp(press, 0.0, 1.0) * normal);
  }
}

volume::RemovalReport Burr::apply(const haptics::ServoRecord& tick, double dt,
                                  volume::RemovalEditor& editor) {
  volume::RemovalReport report;
  if (options_.is_kinematic) {
    sweep_to(tick.pose.position_world, editor, report);
    return report;
  }
  // The ball clears the voxels in front of the HIP, and their walls stand up to a voxel off the cut, so
  // contact comes and goes while the ball works: while it cuts, and for a short way after, it is still in
  // contact.
  const dvec3& hip = tick.pose.position_world;
  free_mm_ = tick.has_contact ? 0 : free_mm_ + glm::length(hip - hip_);
  hip_ = hip;
  if (free_mm_ > k_memory_voxels * editor.working().base().frame.diagonal_mm()) has_centre_ = false;
  if (!tick.has_contact && !has_centre_) return report;
  owed_mm3_ = std::min(owed_mm3_ + budget(dt), budget(k_credit_seconds + dt));
  if (tick.has_contact) {
    if (!options_.is_round) turn_axis(tick, dt);  // else the axis stays 0
    if (!has_centre_) owed_mm3_ -= sweep_to(tick.proxy_world + options_.radius * axis_, editor, report);
  }

  // Toward the place where the lowest point is on the HIP, by bites that time has paid for.
  const dvec3 way = hip + options_.radius * axis_ - centre_;
  const double length = std::min(glm::length(way), options_.feed_limit * dt);
  if (length <= 1e-9) return report;
  const dvec3 start = centre_, direction = way / glm::length(way);
  const int bites = std::max(1, static_cast<int>(std::ceil(length / k_step_mm)));
  for (int i = 1; i <= bites && owed_mm3_ > 0; ++i)
    owed_mm3_ -= sweep_to(start + (length * i / bites) * direction, editor, report);
  if (report.removed_units > 0) free_mm_ = 0;
  return report;
}

}  // namespace trephine::drilling
