// Scorer: judges a proxy's path over a scene, for our methods and other programs alike.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "apps/bench/feel.h"
#include "apps/verify/ideal_proxy.h"
#include "haptics/force/force.h"
#include "haptics/scene/touch_scene.h"

namespace trephine::bench {

/// Path of an ideal proxy on one solid, from the start of a motion.
struct IdealProxy {
  using Advance = std::function<glm::dvec3(const glm::dvec3& proxy, const glm::dvec3& hip_from,
                                           const glm::dvec3& hip_to)>;
  Advance advance;                  ///< one step of the ideal proxy
  std::vector<glm::dvec3> proxies;  ///< one per step of the motion
};

/// Paths of the ideal proxies of a scene, on each of its solids; built once for all methods.
class IdealProxies {
 public:
  explicit IdealProxies(const FeelScene& scene);

  const IdealProxy& on_shape() const { return on_shape_; }  ///< on the analytic shape; empty for scans
  const IdealProxy& on_smooth_solid() const;  ///< on the smooth solid of the samples; built at the first call
  const IdealProxy& on_cubes() const;         ///< on solid voxels; built at the first call
  /// The ideal proxy that decides whether a proxy is stuck. For a point on a sharp shape it is on the smooth
  /// solid, since the samples describe a blunt shape, on which the point rests.
  const IdealProxy& stuck_reference() const;
  /// True if a proxy is deeper in the analytic shape than the tolerance. The tolerance is a voxel for a
  /// point; for a ball it is 2 % of the radius plus a tenth of a voxel, or plus a voxel if the shape has an
  /// outer edge. On a sharp shape, a point is fallen only if it is also in the smooth solid. Requires an
  /// analytic shape.
  bool is_fallen(const glm::dvec3& p) const;
  /// True if p is in the analytic shape; for scans, in the smooth solid.
  bool is_in_matter(const glm::dvec3& p) const {
    return (scene_.distance ? scene_.distance(p) : of_smooth_(p)) < 0;
  }
  double voxel() const { return voxel_; }

 private:
  IdealProxy follow_path(IdealProxy::Advance advance) const;

  const FeelScene& scene_;
  double voxel_;
  verify::Clearance of_smooth_;
  IdealProxy on_shape_;
  mutable IdealProxy on_smooth_, on_cubes_;
};

/// Compares a proxy with an ideal proxy. If the proxy comes to rest at another local minimum, the tracker
/// continues with an ideal proxy of its own from that position.
class IdealProxyTracker {
 public:
  IdealProxyTracker(const IdealProxy& reference, const FeelScene& scene, double voxel)
      : reference_(reference), scene_(scene), voxel_(voxel) {}

  enum class Verdict {
    following,
    away,       ///< for fewer than ten steps
    stuck,      ///< away for ten steps, although an ideal proxy would move on from there
    other_rest  ///< away for ten steps, at rest at another local minimum
  };
  /// The ideal proxy at this step.
  const glm::dvec3& at(std::size_t i);
  /// `is_away`: more than a voxel off. Call after at().
  Verdict judge(std::size_t i, const glm::dvec3& proxy, bool is_away);
  /// Continues with an ideal proxy of its own from this position.
  void continue_from(const glm::dvec3& proxy) { own_ = proxy; }

 private:
  const glm::dvec3& hip(std::size_t i) const { return scene_.path.samples()[i].pose.position_world; }

  const IdealProxy& reference_;
  const FeelScene& scene_;
  double voxel_;
  std::optional<glm::dvec3> own_;
  long away_ = 0;
};

/// Scores the steps of a path, in order.
class Scorer {
 public:
  /// `same_solid`: ideal proxy on the solid that the method guarantees, or null.
  Scorer(const FeelScene& scene, const IdealProxies& ideal, const IdealProxy* same_solid = nullptr);
  void judge_step(std::size_t i, const haptics::ProxyStep& step);
  /// Writes errors, forces and counts to the row. FeelRow::fall_throughs becomes the larger of its previous
  /// value and the number of falls counted here.
  void finish(FeelRow& row);

 private:
  /// Contribution of a step to the errors. Contributions are pending while the proxy is away from the ideal
  /// proxy. They are discarded if the proxy comes to rest elsewhere, and otherwise added.
  struct Errors {
    double distance = 0, deviation = 0, tangential_deviation = 0, rendered_error = 0;
    std::optional<double> degrees;
    bool is_pressed = false;
  };
  void add_errors();
  void add_from_same();
  void find_falls(const glm::dvec3& proxy);

  const FeelScene& scene_;
  const IdealProxies& ideal_;
  haptics::ForceModel raw_, smoothed_;
  IdealProxyTracker on_shape_, stuck_tracker_;
  std::optional<IdealProxyTracker> on_same_;
  std::vector<Errors> pending_;
  std::vector<double> pending_same_;
  glm::dvec3 last_force_{0.0};
  glm::ivec3 last_voxel_{-100};
  std::vector<double> raw_n_, smoothed_n_, tangential_;
  std::vector<bool> contact_;
  double distance_square_ = 0, angle_square_ = 0, deviation_square_ = 0, rendered_square_ = 0, jump_ = 0;
  double max_change_ = 0, max_deviation_ = 0, deepest_ = 0, max_from_same_ = 0;
  long contacts_ = 0, distance_count_ = 0, angle_count_ = 0, jumps_ = 0, missed_ = 0, ghosts_ = 0;
  long stuck_ = 0, other_rest_ = 0, entered_ = 0;
  bool was_inside_ = false;
  std::optional<glm::dvec3> last_proxy_;
};

/// Returns the step of a program that gives only its proxies: contact if the proxy differs from the HIP. The
/// Scorer ignores contacts within a thousandth of a voxel.
haptics::ProxyStep step_from_proxy(const glm::dvec3& proxy, const glm::dvec3& hip);

}  // namespace trephine::bench
