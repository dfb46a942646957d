// Objects that are touched by depth images: the sets that a hand needs, and those that it has.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "haptics/depth/depth_picture.h"
#include "haptics/depth/depth_rules.h"
#include "haptics/servo/servo_scene.h"
#include "sim/command.h"

namespace trephine::sim {

/// A set to be made. Made on any thread, from immutable things alone.
struct DepthJob {
  std::uint8_t hand = 0;
  std::int64_t item = 0;
  std::uint64_t serial = 0;  ///< of the set
  std::shared_ptr<const haptics::depth::DepthSource> source;
  haptics::depth::DepthView view;

  /// Milliseconds, by what there is to see; the same bits whatever `threads`. Null: it cannot be seen so.
  std::shared_ptr<const haptics::depth::DepthSet> make(int threads = 1) const;
  /// The command that adopts this set.
  AdoptDepths command(const haptics::depth::DepthSet& made) const;
};

/// A submitted picture in a command: `time` when it was taken, `edge` of the clip volume about
/// `touch` (mm, of the item's frame).
AdoptPicture told_of(const haptics::depth::DepthPicture& picture, std::int64_t item, const glm::dvec3& touch,
                     double edge);
haptics::depth::DepthPicture picture_of(const AdoptPicture& request);
/// The surface that it shows; some milliseconds.
std::shared_ptr<const haptics::depth::DepthSet> set_of(const AdoptPicture& request);

/// An adopted set, for display.
struct SeenDepths {
  int item;
  std::shared_ptr<const haptics::depth::DepthSet> set;
  haptics::Placement drawn;  ///< of the thing's frame in the world; the clip volume lies so
  haptics::Placement now;    ///< of what was drawn, as it has gone on
};

/// One hand's. A value.
class DepthSets {
 public:
  using Sets = std::vector<std::shared_ptr<const haptics::depth::DepthSet>>;
  /// s from a set that is drawn then to the next: of things at rest as many a second at most as of those that
  /// move. Shorter where it would turn meanwhile, which a motion between two sets does not.
  static double interval_of(const haptics::TouchItem& item, double time) noexcept;
  /// mm, the edge of a clip volume: as far as the hand goes, either way, until the next set and while that is
  /// made. A hand goes 1 m/s, or half as fast again as it went last.
  double edge_of(const haptics::TouchItem& item) const noexcept;

  /// Can images of such pixels show as much of it as a hand of 1 m/s needs? Error: they are too fine.
  static volume::Status check_pixel(double pixel_mm, double rate, double tool_radius);

  /// `tick`: s between two poses of the hand.
  DepthSets(const haptics::TouchScene& scene, double tick);

  /// Adopted sets: one an item that is touched so.
  const Sets& newest() const noexcept { return newest_; }
  /// Position of the hand, and the radius of its tool; world.
  void see(const glm::dvec3& hip, const glm::dvec3& proxy) noexcept;
  /// The first set to be made at `time` (s), if the object is in reach; empty when all that is near is known.
  std::optional<DepthJob> job(const haptics::ServoHand& hand, std::uint8_t number, double time) const;
  /// Adopts a set in place of the one before it.
  void take(std::int64_t item, std::shared_ptr<haptics::depth::DepthSet> made);
  /// Index of an item among those; empty: it is not touched so.
  std::optional<std::size_t> place_of(std::int64_t item) const noexcept;
  std::uint64_t next_serial(std::size_t place) const noexcept;

 private:
  std::vector<int> items_;
  Sets newest_;
  glm::dvec3 hip_{0.0}, proxy_{0.0};
  bool is_seen_ = false;
  double tick_;
  double speed_ = 0;  ///< mm/s, of the hand; a fast one is remembered for a while
};

/// The job whose result such a command adopts.
DepthJob job_of(const AdoptDepths& request, std::uint8_t hand, const haptics::TouchScene& scene);

}  // namespace trephine::sim
