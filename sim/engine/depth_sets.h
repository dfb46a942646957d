// DepthSets: the depth images by which a hand touches drawable objects.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "haptics/depth/depth_picture.h"
#include "haptics/depth/depth_rules.h"
#include "haptics/servo/servo_scene.h"
#include "sim/engine/derived_job.h"

namespace trephine::sim {

/// Input of depth images: members of haptics::depth::DepthView. The item determines its other members,
/// `pixel` and `interval`.
struct DepthImages {
  glm::dvec3 middle{0.0}, touch{0.0};  ///< mm, item's frame
  double edge = 0, time = 0;           ///< mm; s
  static const Schema& schema();
};
/// Input of a depth picture: the clip volume, and the picture as in haptics::depth::DepthPicture.
struct DepthPixels {
  glm::dvec3 touch{0.0};                     ///< mm, item's frame: middle of the clip volume
  double edge = 0, time = 0;                 ///< mm; s
  std::int64_t width = 0, height = 0;        ///< pixels
  double fx = 0, fy = 0, cx = 0, cy = 0;     ///< pixels
  glm::dvec3 position{0.0};                  ///< mm, of the camera, item's frame
  std::vector<double> rotation{1, 0, 0, 0};  ///< a unit quaternion, w first
  double nearest = 1, step = 0.1;            ///< mm: depth of the value 1; depth per value
  std::string values;                        ///< as in haptics::depth::DepthPicture
  static const Schema& schema();

  static DepthPixels of(const haptics::depth::DepthPicture& picture, const glm::dvec3& touch, double edge,
                        double time);
  haptics::depth::DepthPicture picture() const;
};

/// Returns the job that makes a set of an item. `input`: bytes of DepthImages or DepthPixels. Error if the
/// item is not touched by data of this kind, or if the input is invalid.
Result<DerivedJob> depth_job(const DerivedKey& key, std::uint64_t serial, std::string_view input,
                             const std::shared_ptr<const haptics::TouchScene>& scene);
/// Returns the job that makes a set from a picture; does not check the picture. The job takes some
/// milliseconds.
DerivedJob picture_job(const DerivedKey& key, std::uint64_t serial, const DepthPixels& input);

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
  /// Returns the interval from a set drawn at `time` (s) to the next set, s. It is the period of the item's
  /// depth rate. It is shorter, but at least a fifth of this period, if the object's motion changes within
  /// the period, because the motion between two sets is assumed to be uniform.
  static double interval_of(const haptics::TouchItem& item, double time) noexcept;
  /// Returns the edge of a clip volume, mm. The volume covers the path of the hand, in any direction, until
  /// the next set is ready. The hand is assumed to move at 1 m/s, or at 1.5 times its recent speed if that is
  /// more.
  double edge_of(const haptics::TouchItem& item) const noexcept;

  /// Checks that images with pixels of `pixel_mm` can cover the surroundings of a hand that moves at 1 m/s.
  /// Returns an error if the pixels are too small. `rate`: Hz; `tool_radius`: mm.
  static Status check_pixel(double pixel_mm, double rate, double tool_radius);

  /// `tick`: period of the hand's poses, s.
  DepthSets(const haptics::TouchScene& scene, double tick);

  /// Newest adopted sets: one per item that is touched by depth images; null before its first set.
  const Sets& newest() const noexcept { return newest_; }
  /// Records the positions of the hand and of its proxy; mm, world.
  void record_positions(const glm::dvec3& hip, const glm::dvec3& proxy) noexcept;
  /// Returns the job of the first set that is due at `time` (s), of an object within reach; empty if no set
  /// is due. `number`: of the hand; `scene`: its scene without detached bodies.
  std::optional<DerivedJob> job(const haptics::ServoHand& hand, std::uint8_t number,
                                const std::shared_ptr<const haptics::TouchScene>& scene, double time) const;
  /// Replaces the set of an item.
  void adopt(std::int64_t item, std::shared_ptr<haptics::depth::DepthSet> result);
  /// Returns the index of an item in newest(); empty if it is not touched by depth images.
  std::optional<std::size_t> index_of(std::int64_t item) const noexcept;
  std::uint64_t next_serial(std::size_t index) const noexcept;

 private:
  std::vector<int> items_;
  Sets newest_;
  glm::dvec3 hip_{0.0}, proxy_{0.0};
  bool has_position_ = false;
  double tick_;       ///< s
  double speed_ = 0;  ///< mm/s, of the hand; decays slowly after a fast motion
};

}  // namespace trephine::sim
