#include "apps/workbench/performer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "volume/base/deterministic_math.h"

namespace trephine::workbench {

using glm::dvec3;
using haptics::PosePath;

namespace {

constexpr double k_degree = std::numbers::pi / 180;
constexpr double k_step = 0.005;  // s, between samples of a performed path

constexpr Skill k_skills[] = {
    {"novice", 1.6, 3.5 * k_degree, 0.20, 0.30, 1.8, 0.15, 0.8, 2.5, 0.45},
    {"trained", 0.7, 1.5 * k_degree, 0.10, 0.15, 1.3, 0.05, 0.4, 4, 0.7},
    {"expert", 0.25, 0.5 * k_degree, 0.04, 0.05, 1, 0, 0, 8, 1},
};

/// Sequence of random numbers for one purpose, such as "pauses". Equal seeds and purposes give the same
/// numbers on every machine.
class Random {
 public:
  Random(std::uint64_t seed, std::string_view purpose) : state_(hash_bits(seed)) {
    for (const char c : purpose) state_ = hash_bits(state_ ^ static_cast<unsigned char>(c));
  }
  /// Returns a number from 0 to 1, without 1.
  double uniform() noexcept {
    state_ = hash_bits(state_);
    return static_cast<double>(state_ >> 11) * 0x1p-53;
  }
  /// Returns a number from a distribution of mean 0 and standard deviation 1: the sum of twelve uniform
  /// numbers, less 6 (Irwin 1927).
  double normal() noexcept {
    double sum = -6;
    for (int i = 0; i < 12; ++i) sum += uniform();
    return sum;
  }

 private:
  unsigned long long state_;
};

/// Sum of sines in a band of frequencies, with the requested RMS per axis.
class Oscillation {
 public:
  Oscillation(Random random, double rms, double low_hz, double high_hz) {
    const double amplitude = rms * std::sqrt(2.0 / k_count);
    for (Wave& wave : waves_) {
      wave.direction = amplitude * dvec3(random.uniform() < 0.5 ? -1 : 1);
      wave.frequency = 2 * std::numbers::pi * (low_hz + (high_hz - low_hz) * random.uniform());
      for (int a = 0; a < 3; ++a) wave.phase[a] = 2 * std::numbers::pi * random.uniform();
    }
  }
  dvec3 at(double t) const noexcept {
    dvec3 sum(0);
    for (const Wave& wave : waves_)
      for (int a = 0; a < 3; ++a)
        sum[a] += wave.direction[a] * deterministic_sin(wave.frequency * t + wave.phase[a]);
    return sum;
  }

 private:
  static constexpr int k_count = 6;
  struct Wave {
    dvec3 direction{0.0}, phase{0.0};
    double frequency = 0;
  };
  std::array<Wave, k_count> waves_;
};

/// Position of a mass on a spring and a damper that is pulled along the planned path.
class Response {
 public:
  Response(const Skill& skill, const dvec3& start)
      : omega_(2 * std::numbers::pi * skill.bandwidth), damping_(skill.damping), position_(start) {}
  /// Advances by k_step toward `target`.
  const dvec3& follow(const dvec3& target) noexcept {
    if (omega_ == 0) return position_ = target;
    constexpr int k_parts = 5;  // substeps, so that the response of the largest bandwidth is stable
    const double dt = k_step / k_parts;
    for (int i = 0; i < k_parts; ++i) {
      velocity_ += dt * omega_ * (omega_ * (target - position_) - 2 * damping_ * velocity_);
      position_ += dt * velocity_;
    }
    return position_;
  }

 private:
  double omega_, damping_;
  dvec3 position_, velocity_{0.0};
};

}  // namespace

std::span<const Skill> skills() noexcept { return k_skills; }

const Skill* find_skill(std::string_view name) noexcept {
  const auto found = std::find_if(std::begin(k_skills), std::end(k_skills),
                                  [&](const Skill& skill) { return skill.name == name; });
  return found == std::end(k_skills) ? nullptr : found;
}

Performer::Performer(const Skill& skill, std::uint64_t seed, double duration)
    : skill_(skill), seed_(seed), duration_(duration) {
  Random random(seed, "pauses");
  for (double second = 0; second < duration; ++second) {
    const double chance = random.uniform(), at = second + random.uniform(), length = random.uniform();
    if (chance < skill.pauses_per_second) pauses_.push_back({at, skill.pause * (0.5 + length)});
  }
}

void Performer::displace(Place& place) const {
  Random random(seed_, place.name);
  const double aside = skill_.place_error * random.normal(), upward = skill_.place_error * random.normal();
  const double right = skill_.tilt * random.normal(), up = skill_.tilt * random.normal();
  place.point += aside * place.along + upward * place.across;
  place.outward = glm::normalize(place.outward + right * place.along + up * place.across);
  place.along = glm::normalize(place.along - glm::dot(place.along, place.outward) * place.outward);
  place.across = glm::cross(place.outward, place.along);
}

double Performer::time_of(double planned) const noexcept {
  double time = skill_.slowness * planned;
  for (const Pause& pause : pauses_)
    if (pause.at < planned) time += pause.seconds;
  return time;
}

double Performer::planned_of(double time) const noexcept {
  double waited = 0;
  for (const Pause& pause : pauses_) {
    const double begin = skill_.slowness * pause.at + waited;
    if (time <= begin) break;
    if (time <= begin + pause.seconds) return pause.at;
    waited += pause.seconds;
  }
  return (time - waited) / skill_.slowness;
}

PosePath Performer::perform(const PosePath& planned, std::size_t hand) const {
  const std::string purpose = "hand " + std::to_string(hand);
  const Oscillation tremor({seed_, purpose + " tremor"}, skill_.tremor, 8, 12),
      drift({seed_, purpose + " drift"}, skill_.drift, 0.1, 0.8);
  Response response(skill_, planned.at(0).position_world);
  std::vector<PosePath::Sample> samples;
  const double end = time_of(std::max(planned.end_time(), duration_));
  for (double step = 0; step * k_step <= end + k_step; ++step) {
    const double time = step * k_step;
    haptics::Pose pose = planned.at(planned_of(time));
    pose.position_world = response.follow(pose.position_world) + tremor.at(time) + drift.at(time);
    samples.push_back({time, pose});
  }
  return PosePath::from_samples(std::move(samples), "").value();
}

}  // namespace trephine::workbench
