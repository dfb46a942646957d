#include "apps/bench/scorer.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "apps/bench/scenes/guaranteed_solid.h"
#include "apps/verify/fall_through.h"
#include "apps/verify/volume_samples.h"
#include "volume/base/percentile.h"
#include "volume/scan/traversal.h"

namespace trephine::bench {

using glm::dvec3;

namespace {

constexpr std::size_t k_dropped = MinimumOfRuns::k_dropped;

/// Returns the RMS of the force (1 kHz) minus its moving mean over 51 ticks, that is, of the frequencies
/// above about 20 Hz. Uses only windows with contact in every tick.
double rough_above_20_hz(const std::vector<double>& force, const std::vector<bool>& contact) {
  constexpr int k_half = 25;
  double square = 0;
  long count = 0;
  const int n = static_cast<int>(force.size());
  for (int i = 100 + k_half; i + k_half < n; ++i) {
    double sum = 0;
    bool is_whole = true;
    for (int k = i - k_half; k <= i + k_half && is_whole; ++k) {
      is_whole = contact[static_cast<std::size_t>(k)];
      sum += force[static_cast<std::size_t>(k)];
    }
    if (!is_whole) continue;
    const double rest = force[static_cast<std::size_t>(i)] - sum / (2 * k_half + 1);
    square += rest * rest;
    ++count;
  }
  return count > 0 ? std::sqrt(square / static_cast<double>(count)) : 0;
}

haptics::ForceOptions without_smoothing() {
  haptics::ForceOptions options;
  options.smoothing_alpha = 1;
  return options;
}

/// The smooth solid of every shape, as a clearance (world frame).
verify::Clearance clearance_of(const FeelScene& s) {
  struct Part {
    verify::SmoothSolid solid;
    volume::Frame frame;
  };
  std::vector<Part> parts;
  for (std::size_t i = 0; i < s.scene.items.size(); ++i) {
    const auto offset = scenes::touch_offset_field(s.scene, s.drilled.get(), i);
    parts.push_back({scenes::touched_smooth_solid(s.scene, s.drilled, i),
                     offset ? offset->frame() : s.scene.base->frame});
  }
  return [parts = std::move(parts)](const dvec3& p) {
    double clearance = 1e300;
    for (const Part& part : parts) {
      const dvec3 q = part.frame.volume_from_world(p);
      double solid = 1e300;
      for (std::size_t f = 0; f < part.solid.field_count(); ++f)
        solid = std::min(solid, part.solid.value(f, q));
      clearance = std::min(clearance, -solid);
    }
    return clearance;
  };
}

IdealProxy::Advance advance_by_clearance(verify::Clearance clearance, double voxel) {
  return [clearance = std::move(clearance), voxel](const dvec3& proxy, const dvec3& from, const dvec3& to) {
    return verify::follow_exactly(clearance, voxel, proxy, from, to);
  };
}

IdealProxy::Advance advance_on_cubes(const FeelScene& s) {
  return [solid = verify::solid_voxels(s.scene.base, s.scene.items[0].field.shape(),
                                       s.drilled ? s.drilled->version : nullptr),
          base = s.scene.base](const dvec3& proxy, const dvec3&, const dvec3& to) {
    const volume::Frame& frame = base->frame;
    const dvec3 axes[3] = {frame.axes()[0], frame.axes()[1], frame.axes()[2]};
    return frame.world_from_volume(verify::resting_point_on_cubes(
        base->size, solid, axes, frame.volume_from_world(proxy), frame.volume_from_world(to)));
  };
}

}  // namespace

IdealProxies::IdealProxies(const FeelScene& scene) : scene_(scene), of_smooth_(clearance_of(scene)) {
  const dvec3& spacing = scene.scene.base->frame.spacing();
  voxel_ = std::min({spacing.x, spacing.y, spacing.z});
  if (scene.distance) on_shape_ = follow_path(advance_by_clearance(scene.distance, voxel_));
}

IdealProxy IdealProxies::follow_path(IdealProxy::Advance advance) const {
  IdealProxy path{std::move(advance), {}};
  dvec3 last(0);
  for (const auto& sample : scene_.path.samples()) {
    const dvec3& hip = sample.pose.position_world;
    path.proxies.push_back(path.proxies.empty() ? hip : path.advance(path.proxies.back(), last, hip));
    last = hip;
  }
  return path;
}

const IdealProxy& IdealProxies::on_smooth_solid() const {
  if (!on_smooth_.advance) on_smooth_ = follow_path(advance_by_clearance(of_smooth_, voxel_));
  return on_smooth_;
}

const IdealProxy& IdealProxies::on_cubes() const {
  if (!on_cubes_.advance) on_cubes_ = follow_path(advance_on_cubes(scene_));
  return on_cubes_;
}

const IdealProxy& IdealProxies::stuck_reference() const {
  const bool is_blunted_by_samples = scene_.group == "sharp" && scene_.radius_mm == 0;
  return is_blunted_by_samples || !scene_.distance ? on_smooth_solid() : on_shape_;
}

bool IdealProxies::is_fallen(const dvec3& p) const {
  const double deep = -scene_.distance(p);
  const double blunted = scene_.has_outer_edge ? voxel_ : 0.1 * voxel_;
  if (scene_.radius_mm > 0) return deep > blunted + 0.02 * scene_.radius_mm;
  // The samples of a sharp shape describe a blunt shape. A point outside that blunt shape is free.
  return deep > voxel_ && (scene_.group != "sharp" || of_smooth_(p) < 0);
}

const dvec3& IdealProxyTracker::at(std::size_t i) {
  if (!own_) return reference_.proxies[i];
  own_ = reference_.advance(*own_, hip(i > 0 ? i - 1 : 0), hip(i));
  return *own_;
}

IdealProxyTracker::Verdict IdealProxyTracker::judge(std::size_t i, const dvec3& proxy, bool is_away) {
  away_ = is_away ? away_ + 1 : 0;
  if (away_ == 0) return Verdict::following;
  if (away_ < 10) return Verdict::away;
  away_ = 0;
  const dvec3 free = reference_.advance(proxy, proxy, proxy), down = reference_.advance(free, hip(i), hip(i));
  if (glm::length(down - free) > voxel_) return Verdict::stuck;
  own_ = down;
  return Verdict::other_rest;
}

Scorer::Scorer(const FeelScene& scene, const IdealProxies& ideal, const IdealProxy* same_solid)
    : scene_(scene),
      ideal_(ideal),
      raw_(without_smoothing(), 1e-3),
      smoothed_(haptics::ForceOptions{}, 1e-3),
      on_shape_(ideal.on_shape(), scene, ideal.voxel()),
      stuck_tracker_(ideal.stuck_reference(), scene, ideal.voxel()) {
  if (same_solid != nullptr) on_same_.emplace(*same_solid, scene, ideal.voxel());
}

void Scorer::judge_step(std::size_t i, const haptics::ProxyStep& step) {
  const dvec3& hip = scene_.path.samples()[i].pose.position_world;
  const double voxel = ideal_.voxel(), stiffness = scene_.scene.items[0].material.stiffness;
  // A proxy within a thousandth of a voxel of the HIP is not in contact, even if the step reports contact.
  const bool has_contact = step.has_contact && glm::length(step.proxy_world - hip) > 1e-3 * voxel;
  const dvec3 force = raw_.step(step, hip, scene_.scene).force_world,
              smoothed = smoothed_.step(step, hip, scene_.scene).force_world;
  const bool had_contact = i > k_dropped && has_contact && contact_.back();
  if (had_contact) max_change_ = std::max(max_change_, glm::length(force - last_force_));
  last_force_ = force;
  raw_n_.push_back(glm::length(force));
  contact_.push_back(has_contact);
  smoothed_n_.push_back(glm::length(smoothed));
  const dvec3 proxy = has_contact ? step.proxy_world : hip;
  const dvec3 position_volume = scene_.scene.base->frame.volume_from_world(proxy);
  const glm::ivec3 at_voxel = volume::voxel_of(glm::clamp(position_volume, dvec3(-1e6), dvec3(1e6)));
  if (had_contact && at_voxel != last_voxel_) {
    jump_ += std::abs(raw_n_[i] - raw_n_[i - 1]);
    ++jumps_;
  }
  last_voxel_ = at_voxel;

  if (on_same_) {
    const double off = glm::length(proxy - on_same_->at(i));
    pending_same_.push_back(off);
    const IdealProxyTracker::Verdict verdict = on_same_->judge(i, proxy, off > voxel);
    if (verdict == IdealProxyTracker::Verdict::other_rest) pending_same_.clear();
    if (verdict != IdealProxyTracker::Verdict::away) add_from_same();
  }

  const dvec3 expected = stuck_tracker_.at(i), exact = scene_.distance ? on_shape_.at(i) : expected;
  find_falls(proxy);
  if (i < k_dropped) return;
  contacts_ += has_contact;
  // Steps with missing or unexpected contact also contribute to the errors.
  const bool is_missed = !has_contact && glm::length(expected - hip) > voxel;
  missed_ += is_missed;
  ghosts_ += expected == hip && glm::length(proxy - hip) > voxel;
  if (!has_contact && !is_missed) {
    stuck_tracker_.judge(i, proxy, false);
    return;
  }
  if (scene_.distance) {
    Errors e;
    const dvec3 offset = exact - hip, deviation = proxy - exact;
    e.distance = exact != hip ? scene_.distance(proxy) : glm::length(deviation);
    e.deviation = e.tangential_deviation = glm::length(deviation);
    e.rendered_error = glm::length(smoothed - stiffness * offset);
    e.is_pressed = std::max(glm::length(offset), exact == hip ? e.deviation : 0.0) > 0.2;
    if (exact != hip) {
      const dvec3 n = glm::normalize(offset);
      e.tangential_deviation = glm::length(deviation - glm::dot(deviation, n) * n);
      if (has_contact) {
        const double cosine = glm::dot(proxy - hip, n) / std::max(1e-12, glm::length(proxy - hip));
        e.degrees = 57.29577951308232 * std::acos(std::clamp(cosine, -1.0, 1.0));
      }
    }
    pending_.push_back(e);
  }
  // Stuck: the proxy is more than a voxel from the ideal proxy for ten steps in a row, and an ideal proxy
  // that starts at its position moves on by more than a voxel. A proxy inside matter without contact does not
  // count as away, because it rests on no surface.
  const bool is_fallen_through = is_missed && ideal_.is_in_matter(hip);
  switch (stuck_tracker_.judge(i, proxy, !is_fallen_through && glm::length(proxy - expected) > voxel)) {
    case IdealProxyTracker::Verdict::away:
      return;
    case IdealProxyTracker::Verdict::stuck:
      ++stuck_;
      break;
    case IdealProxyTracker::Verdict::other_rest:
      ++other_rest_;
      on_shape_.continue_from(proxy);
      pending_.clear();
      break;
    case IdealProxyTracker::Verdict::following:
      break;
  }
  add_errors();
}

/// Counts entries into the shape. On plates it tests points along the segment from the previous proxy to this
/// one, not only the ends of the segment.
void Scorer::find_falls(const dvec3& proxy) {
  if (!scene_.distance) return;
  deepest_ = std::max(deepest_, -scene_.distance(proxy));
  bool is_inside = ideal_.is_fallen(proxy);
  if (scene_.plate_mm > 0 && last_proxy_) {
    const int parts = 1 + static_cast<int>(10 * glm::length(proxy - *last_proxy_) / scene_.plate_mm);
    for (int k = 0; k <= parts && !is_inside; ++k)
      is_inside = -scene_.distance(*last_proxy_ + (static_cast<double>(k) / parts) * (proxy - *last_proxy_)) >
                  0.4 * scene_.plate_mm;
  }
  entered_ += is_inside && !was_inside_;
  was_inside_ = is_inside;
  last_proxy_ = proxy;
}

void Scorer::add_from_same() {
  for (const double off : pending_same_) max_from_same_ = std::max(max_from_same_, off);
  pending_same_.clear();
}

void Scorer::add_errors() {
  for (const Errors& e : pending_) {
    distance_square_ += e.distance * e.distance;
    ++distance_count_;
    if (!e.is_pressed) continue;
    max_deviation_ = std::max(max_deviation_, e.deviation);
    tangential_.push_back(e.tangential_deviation);
    deviation_square_ += e.deviation * e.deviation;
    rendered_square_ += e.rendered_error * e.rendered_error;
    if (!e.degrees) continue;
    angle_square_ += *e.degrees * *e.degrees;
    ++angle_count_;
  }
  pending_.clear();
}

void Scorer::finish(FeelRow& row) {
  add_errors();
  add_from_same();
  const auto root = [](double square, std::size_t count) -> std::optional<double> {
    if (count == 0) return std::nullopt;
    return std::sqrt(square / static_cast<double>(count));
  };
  row.contacts = contacts_;
  row.fall_throughs = std::max(row.fall_throughs, entered_);
  row.stuck = stuck_, row.other_rest = other_rest_, row.missed = missed_, row.ghosts = ghosts_;
  if (on_same_) row.method_error_voxels = max_from_same_ / ideal_.voxel();
  if (const auto rms = root(distance_square_, static_cast<std::size_t>(distance_count_)))
    row.total_rms_voxels = *rms / ideal_.voxel();
  if (scene_.distance) row.deepest_voxels = deepest_ / ideal_.voxel();
  row.direction_rms_deg = root(angle_square_, static_cast<std::size_t>(angle_count_));
  if (!tangential_.empty()) {
    row.force_rms_n = scene_.scene.items[0].material.stiffness * *root(deviation_square_, tangential_.size());
    row.rendered_rms_n = root(rendered_square_, tangential_.size());
    row.max_deviation_mm = max_deviation_;
    row.tangential_p50_mm = percentile_of(tangential_, 50);
    row.tangential_p99_mm = percentile_of(tangential_, 99);
  }
  row.rough_n = rough_above_20_hz(raw_n_, contact_);
  row.rough_smoothed_n = rough_above_20_hz(smoothed_n_, contact_);
  row.jump_n = jumps_ > 0 ? jump_ / static_cast<double>(jumps_) : 0;
  row.max_change_n = max_change_;
}

haptics::ProxyStep step_from_proxy(const dvec3& proxy, const dvec3& hip) {
  haptics::ProxyStep step;
  step.proxy_world = proxy;
  step.has_contact = proxy != hip;
  if (step.has_contact) {
    step.normal_world = glm::normalize(proxy - hip);
    step.shape = 0;
    step.side = haptics::Side::front;
  }
  return step;
}

}  // namespace trephine::bench
