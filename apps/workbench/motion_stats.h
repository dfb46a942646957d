// MotionStats: process measures of the hands of an operation: time, path, speed, smoothness, strokes, force.
#pragma once

#include <cstdint>
#include <vector>

#include "haptics/servo/servo_record.h"

namespace trephine::workbench {

struct MotionLimits {
  double idle_speed = 2;  ///< mm/s; a slower hand without its button pressed is idle (assumed)
  double near = 3;        ///< mm; a tool nearer to a forbidden structure is near it (assumed)
  double near_force = 2;  ///< N; near a forbidden structure a greater force counts as pressing (assumed)
};

/// Measures of one hand, or of all hands together. Path, speed and jerk are computed from positions averaged
/// over 20 ms (docs/scores.md).
struct HandMotion {
  double seconds = 0;          ///< recorded time; of all hands: their sum
  double working_seconds = 0;  ///< with the button pressed
  double idle_seconds = 0;     ///< with the button released and the hand at rest
  double path = 0;             ///< mm
  double mean_speed = 0;       ///< mm/s: path per recorded time
  double peak_speed = 0;       ///< mm/s
  double jerk = 0;             ///< mm/s3, root mean square of the third derivative of the position
  /// Mean over the measured strokes of ln((D^3 / v_peak^2) * integral of jerk^2 dt), the log dimensionless
  /// jerk (Hogan and Sternad 2009). D is the duration of a stroke, v_peak its peak speed. A motion of minimum
  /// jerk has 5.3; rougher motions have more. 0 without measured strokes.
  double log_jerk = 0;
  std::int64_t measured_strokes = 0;  ///< strokes of at least 0.25 s with a measurable jerk
  std::int64_t strokes = 0;
  double stroke_length = 0;  ///< mm, mean
  double stroke_spread = 0;  ///< mm, standard deviation
  double mean_force = 0;     ///< N, over the time with a force
  double peak_force = 0;     ///< N
  double near_seconds = 0;   ///< time nearer than MotionLimits::near to a forbidden structure
  /// Part of near_seconds with a force above MotionLimits::near_force.
  double near_force_seconds = 0;
};

/// Computes the jerk, speeds and the path of a motion from positions that are averaged over 20 ms. The third
/// difference of four such means, divided by (20 ms)^3, is the jerk, averaged with a cubic B-spline (width
/// 80 ms).
class SmoothedMotion {
 public:
  explicit SmoothedMotion(double dt) noexcept;
  void add(const glm::dvec3& p_world) noexcept;
  /// Starts again after a gap: later positions are not compared with earlier ones.
  void interrupt() noexcept;
  /// Newest speed, mm/s; negative until there are two means since the start or a gap.
  double speed() const noexcept { return speed_; }

  /// Length of the path, mm, including the segment from the first position to the first mean and that from
  /// the last mean to the last position.
  double path() const noexcept;
  double peak_speed = 0;           ///< mm/s
  double jerk_square_seconds = 0;  ///< integral of the squared jerk over jerk_seconds, mm2/s5
  double jerk_seconds = 0;         ///< time for which the jerk is known, s

 private:
  int ticks_per_mean_;
  double seconds_per_mean_;
  glm::dvec3 sum_{0.0}, first_{0.0}, last_{0.0};
  int count_ = 0;
  std::array<glm::dvec3, 4> means_{};  ///< newest last
  int mean_count_ = 0;                 ///< since the last gap, at most 4
  bool has_position_ = false;
  double path_ = 0, speed_ = -1;
};

/// Accumulates the measures tick by tick, in constant time and without allocations.
class MotionStats {
 public:
  /// `dt`: period of the servo, s.
  MotionStats(std::size_t hand_count, double dt, const MotionLimits& limits = {});
  /// Adds a tick. The ticks of each hand must be added in order. `clearance`: mm from the hand's tool to the
  /// nearest forbidden structure.
  void add(const haptics::ServoRecord& record, double clearance) noexcept;

  std::size_t hand_count() const noexcept { return hands_.size(); }
  HandMotion hand(std::size_t index) const noexcept;
  HandMotion total() const noexcept;

 private:
  struct Strokes {
    std::int64_t count = 0, measured = 0;
    double length = 0, length_square = 0, log_jerk = 0;  ///< sums; mm, mm2
  };
  struct Hand {
    explicit Hand(double dt) noexcept : whole(dt), stroke(dt) {}
    SmoothedMotion whole, stroke;
    std::int64_t ticks = 0, working = 0, idle = 0, forced = 0, near = 0, near_force = 0, stroke_ticks = 0;
    double force_sum = 0, force_peak = 0;
    Strokes strokes;  ///< the finished ones
    std::uint64_t next_tick = 0;
    glm::dvec3 last{0.0};  ///< position of the newest valid pose, world
    bool is_pressed = false;
  };
  struct Sums;
  void begin_stroke(Hand& hand) const noexcept;
  void end_stroke(Hand& hand) const noexcept;
  void add_stroke(const Hand& hand, Strokes& strokes) const noexcept;
  void add(const Hand& hand, Sums& sums) const noexcept;
  HandMotion result(const Sums& sums) const noexcept;

  double dt_;
  MotionLimits limits_;
  std::vector<Hand> hands_;
};

}  // namespace trephine::workbench
