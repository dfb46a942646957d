// DepthSets: the depth images by which a hand touches drawable objects.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "haptics/depth/depth_picture.h"
#include "haptics/depth/depth_rules.h"
#include "haptics/servo/servo_scene.h"
#include "sim/api/command.h"

namespace trephine::sim {

/// A set to be drawn. Runs on any thread, from immutable data alone.
struct DepthJob {
  std::uint8_t hand = 0;
  std::int64_t item = 0;
  std::uint64_t serial = 0;  ///< of the set
  std::shared_ptr<const haptics::depth::DepthSource> source;
  haptics::depth::DepthView view;

  /// Takes milliseconds, by what is visible; the same bits for any `threads`. Null: the view cannot be drawn.
  std::shared_ptr<const haptics::depth::DepthSet> make(int threads = 1) const;
  /// Returns the command that adopts this set.
  AdoptDepths command(const haptics::depth::DepthSet& result) const;
};

/// Returns the command that adopts a submitted picture, without serial and time. `edge`: mm, of the clip
/// volume about `touch` (mm, item's frame).
AdoptPicture adopt_picture_command(const haptics::depth::DepthPicture& picture, std::int64_t item,
                                   const glm::dvec3& touch, double edge);
haptics::depth::DepthPicture picture_of(const AdoptPicture& request);
/// Returns the surface that the picture shows, in some milliseconds.
std::shared_ptr<const haptics::depth::DepthSet> set_of(const AdoptPicture& request);

/// An adopted set, for display.
struct DisplayedDepths {
  int item;
  std::shared_ptr<const haptics::depth::DepthSet> set;
  haptics::Placement item_pose;     ///< of the item's frame, and the clip volume, in the world
  haptics::Placement surface_pose;  ///< of the drawn surface, extrapolated to the current time
};

/// Depth images of one hand. A value.
class DepthSets {
 public:
  using Sets = std::vector<std::shared_ptr<const haptics::depth::DepthSet>>;
  /// Returns the interval from a set drawn at `time` (s) to the next, s: that of the item's depth rate, or
  /// less if the object's motion changes before, since the motion between two sets is uniform.
  static double interval_of(const haptics::TouchItem& item, double time) noexcept;
  /// Returns the edge of a clip volume, mm: covers the path of the hand, in any direction, until the next set
  /// is drawn. The hand is assumed to move at 1 m/s, or at 1.5 times its recent speed if that is more.
  double edge_of(const haptics::TouchItem& item) const noexcept;

  /// Checks that images of such pixels can cover the surroundings of a hand that moves at 1 m/s. Error if the
  /// pixels are too fine. `rate`: Hz; `tool_radius`: mm.
  static Status check_pixel(double pixel_mm, double rate, double tool_radius);

  /// `tick`: period of the hand's poses, s.
  DepthSets(const haptics::TouchScene& scene, double tick);

  /// Adopted sets: one per item that is touched by depth images.
  const Sets& newest() const noexcept { return newest_; }
  /// Records the positions of the hand and of its proxy; world.
  void see(const glm::dvec3& hip, const glm::dvec3& proxy) noexcept;
  /// Returns the first set that is due at `time` (s), of an object within reach; empty if all sets are up to
  /// date. `number`: of the hand.
  std::optional<DepthJob> job(const haptics::ServoHand& hand, std::uint8_t number, double time) const;
  /// Replaces the set of an item.
  void take(std::int64_t item, std::shared_ptr<haptics::depth::DepthSet> result);
  /// Returns the index of an item in newest(); empty if it is not touched by depth images.
  std::optional<std::size_t> index_of(std::int64_t item) const noexcept;
  std::uint64_t next_serial(std::size_t place) const noexcept;

 private:
  std::vector<int> items_;
  Sets newest_;
  glm::dvec3 hip_{0.0}, proxy_{0.0};
  bool has_position_ = false;
  double tick_;       ///< s
  double speed_ = 0;  ///< mm/s, of the hand; decays slowly after a fast motion
};

/// Returns the job whose result such a command adopts.
DepthJob job_of(const AdoptDepths& request, std::uint8_t hand, const haptics::TouchScene& scene);

}  // namespace trephine::sim
