#include "apps/workbench/motion_stats.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "volume/base/deterministic_math.h"

namespace trephine::workbench {

namespace {

/// Positions are averaged over this time.
constexpr double k_mean_seconds = 0.02;
/// Shortest stroke whose smoothness is measured: it has so many averages that the first and the last one have
/// little influence on the result.
constexpr double k_measured_seconds = 0.25;

double square_of(const glm::dvec3& v) noexcept { return glm::dot(v, v); }

}  // namespace

SmoothedMotion::SmoothedMotion(double dt) noexcept
    : ticks_per_mean_(std::max(1, static_cast<int>(std::lround(k_mean_seconds / dt)))),
      seconds_per_mean_(ticks_per_mean_ * dt) {}

void SmoothedMotion::add(const glm::dvec3& p_world) noexcept {
  if (!has_position_) first_ = p_world;
  has_position_ = true, last_ = p_world;
  sum_ += p_world;
  if (++count_ < ticks_per_mean_) return;
  const glm::dvec3 mean = sum_ / static_cast<double>(count_);
  sum_ = glm::dvec3(0), count_ = 0;
  std::rotate(means_.begin(), means_.begin() + 1, means_.end());
  means_.back() = mean;
  mean_count_ = std::min(mean_count_ + 1, 4);
  if (mean_count_ == 1) path_ += glm::distance(first_, mean);
  if (mean_count_ < 2) return;
  const double h = seconds_per_mean_, step = glm::distance(means_[2], mean);
  path_ += step, speed_ = step / h;
  peak_speed = std::max(peak_speed, speed_);
  if (mean_count_ < 4) return;
  const glm::dvec3 jerk = (mean - 3.0 * means_[2] + 3.0 * means_[1] - means_[0]) / (h * h * h);
  jerk_square_seconds += h * square_of(jerk), jerk_seconds += h;
}

void SmoothedMotion::interrupt() noexcept {
  path_ = path();
  sum_ = glm::dvec3(0), count_ = mean_count_ = 0;
  has_position_ = false, speed_ = -1;
}

double SmoothedMotion::path() const noexcept {
  if (!has_position_) return path_;
  return path_ + glm::distance(mean_count_ > 0 ? means_.back() : first_, last_);
}

/// Sums over one hand or several.
struct MotionStats::Sums {
  double ticks = 0, working = 0, idle = 0, forced = 0, near = 0, near_force = 0;
  double path = 0, peak_speed = 0, jerk_square_seconds = 0, jerk_seconds = 0;
  double force = 0, force_peak = 0;
  Strokes strokes;
};

MotionStats::MotionStats(std::size_t hand_count, double dt, const MotionLimits& limits)
    : dt_(dt), limits_(limits), hands_(hand_count, Hand(dt)) {}

void MotionStats::add(const haptics::ServoRecord& record, double clearance) noexcept {
  if (record.hand >= hands_.size()) return;
  Hand& hand = hands_[record.hand];
  const glm::dvec3& p = record.pose.position_world;
  const bool is_finite = std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
  const bool is_pressed = record.pose.is_pressed() && is_finite;
  // A gap of the recording, and a jump of a mouse's tool, end a stroke and interrupt the motion.
  constexpr double k_fastest = 3000;  // mm/s; a hand is slower
  const bool is_jump = is_finite && hand.ticks > 0 && glm::distance(p, hand.last) > k_fastest * dt_;
  hand.last = is_finite ? p : hand.last;
  if (hand.ticks > 0 && (record.tick != hand.next_tick || !is_finite || is_jump)) {
    end_stroke(hand);
    hand.whole.interrupt();
  }
  hand.next_tick = record.tick + 1;
  ++hand.ticks;
  if (hand.is_pressed && !is_pressed) end_stroke(hand);
  if (!hand.is_pressed && is_pressed) begin_stroke(hand);
  if (is_finite) hand.whole.add(p);
  if (is_pressed) hand.stroke.add(p), ++hand.stroke_ticks, ++hand.working;
  const double speed = hand.whole.speed();
  if (!is_pressed && speed >= 0 && speed < limits_.idle_speed) ++hand.idle;
  const double force = glm::length(record.force_world);
  if (force > 0) hand.force_sum += force, ++hand.forced;
  hand.force_peak = std::max(hand.force_peak, force);
  if (clearance >= limits_.near) return;
  ++hand.near;
  if (force > limits_.near_force) ++hand.near_force;
}

void MotionStats::begin_stroke(Hand& hand) const noexcept {
  hand.is_pressed = true;
  hand.stroke = SmoothedMotion(dt_);
  hand.stroke_ticks = 0;
}

void MotionStats::end_stroke(Hand& hand) const noexcept {
  if (!hand.is_pressed) return;
  hand.is_pressed = false;
  add_stroke(hand, hand.strokes);
}

void MotionStats::add_stroke(const Hand& hand, Strokes& strokes) const noexcept {
  const SmoothedMotion& stroke = hand.stroke;
  const double length = stroke.path(), duration = static_cast<double>(hand.stroke_ticks) * dt_;
  ++strokes.count;
  strokes.length += length, strokes.length_square += length * length;
  if (duration < k_measured_seconds || stroke.jerk_square_seconds <= 0 || stroke.peak_speed <= 0) return;
  const double mean_square = stroke.jerk_square_seconds / stroke.jerk_seconds, square = duration * duration;
  const double log_jerk =
      deterministic_log(square * square * mean_square / (stroke.peak_speed * stroke.peak_speed));
  if (log_jerk < 0) return;  // a straight motion of constant speed: its jerk is rounding noise
  ++strokes.measured;
  strokes.log_jerk += log_jerk;
}

void MotionStats::add(const Hand& hand, Sums& sums) const noexcept {
  sums.ticks += static_cast<double>(hand.ticks);
  sums.working += static_cast<double>(hand.working), sums.idle += static_cast<double>(hand.idle);
  sums.near += static_cast<double>(hand.near), sums.near_force += static_cast<double>(hand.near_force);
  sums.forced += static_cast<double>(hand.forced), sums.force += hand.force_sum;
  sums.force_peak = std::max(sums.force_peak, hand.force_peak);
  sums.path += hand.whole.path(), sums.peak_speed = std::max(sums.peak_speed, hand.whole.peak_speed);
  sums.jerk_square_seconds += hand.whole.jerk_square_seconds, sums.jerk_seconds += hand.whole.jerk_seconds;
  Strokes strokes = hand.strokes;
  if (hand.is_pressed) add_stroke(hand, strokes);  // the current one
  sums.strokes.count += strokes.count, sums.strokes.measured += strokes.measured;
  sums.strokes.length += strokes.length, sums.strokes.length_square += strokes.length_square;
  sums.strokes.log_jerk += strokes.log_jerk;
}

HandMotion MotionStats::result(const Sums& sums) const noexcept {
  const auto quotient = [](double sum, double count) { return count > 0 ? sum / count : 0.0; };
  HandMotion motion;
  motion.seconds = sums.ticks * dt_;
  motion.working_seconds = sums.working * dt_, motion.idle_seconds = sums.idle * dt_;
  motion.path = sums.path, motion.peak_speed = sums.peak_speed;
  motion.mean_speed = quotient(sums.path, motion.seconds);
  motion.jerk = std::sqrt(quotient(sums.jerk_square_seconds, sums.jerk_seconds));
  const Strokes& strokes = sums.strokes;
  const auto count = static_cast<double>(strokes.count);
  motion.strokes = strokes.count, motion.measured_strokes = strokes.measured;
  motion.log_jerk = quotient(strokes.log_jerk, static_cast<double>(strokes.measured));
  motion.stroke_length = quotient(strokes.length, count);
  const double mean = motion.stroke_length;
  motion.stroke_spread = std::sqrt(std::max(0.0, quotient(strokes.length_square, count) - mean * mean));
  motion.mean_force = quotient(sums.force, sums.forced), motion.peak_force = sums.force_peak;
  motion.near_seconds = sums.near * dt_, motion.near_force_seconds = sums.near_force * dt_;
  return motion;
}

HandMotion MotionStats::hand(std::size_t index) const noexcept {
  Sums sums;
  add(hands_[index], sums);
  return result(sums);
}

HandMotion MotionStats::total() const noexcept {
  Sums sums;
  for (const Hand& hand : hands_) add(hand, sums);
  return result(sums);
}

}  // namespace trephine::workbench
