// What is said of a proxy's way over a scene, ours and anybody else's alike.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "haptics/force/force.h"
#include "haptics/scene/touch_scene.h"
#include "tests/bench/feel.h"
#include "tests/checker/ideal_hand.h"

namespace trephine::bench {

/// Where an exact hand would be on one solid, from the start of a motion on.
struct ExactHand {
  using Go = std::function<glm::dvec3(const glm::dvec3& proxy, const glm::dvec3& hip_from,
                                      const glm::dvec3& hip_to)>;
  Go go;                            ///< one step of such a hand
  std::vector<glm::dvec3> proxies;  ///< a step of the motion each
};

/// Exact hands over a scene, made once for all methods.
class Ideal {
 public:
  explicit Ideal(const FeelScene& scene);

  const ExactHand& on_shape() const { return on_shape_; }  ///< the analytic one; empty on scans
  const ExactHand& on_smooth_solid() const;  ///< of the samples; made when it is first asked for
  const ExactHand& on_cubes() const;         ///< of the voxels; likewise
  /// Which of them says that a proxy is stuck: samples of a sharp shape hold a blunt one, where a point
  /// rests.
  const ExactHand& judge() const;
  /// Is a proxy so deep in the analytic shape that nothing excuses it? More than a voxel; of a ball, a tenth
  /// of one (a whole one beside an outer edge) and 2 % of its radius.
  bool is_fallen(const glm::dvec3& p) const;
  /// Is p in the solid that the judge's hand is on?
  bool is_in_matter(const glm::dvec3& p) const {
    return (scene_.distance ? scene_.distance(p) : of_smooth_(p)) < 0;
  }
  double voxel() const { return voxel_; }

 private:
  ExactHand made(ExactHand::Go go) const;

  const FeelScene& scene_;
  double voxel_;
  checker::Clearance of_smooth_;
  ExactHand on_shape_;
  mutable ExactHand on_smooth_, on_cubes_;
};

/// A proxy beside an exact hand. Where the proxy comes to rest in another place, from where nothing leads
/// down, it has an exact hand of its own from there on.
class Beside {
 public:
  Beside(const ExactHand& hand, const FeelScene& scene, double voxel)
      : hand_(hand), scene_(scene), voxel_(voxel) {}

  enum class Verdict {
    with_it,
    away,   ///< for fewer than ten steps
    stuck,  ///< for ten steps, and held by nothing
    parted
  };
  /// The exact hand's proxy at this step.
  const glm::dvec3& at(std::size_t i);
  /// `is_away`: more than a voxel off. After at().
  Verdict judge(std::size_t i, const glm::dvec3& proxy, bool is_away);
  /// Goes on from here.
  void part(const glm::dvec3& proxy) { own_ = proxy; }

 private:
  const glm::dvec3& hip(std::size_t i) const { return scene_.path.samples()[i].pose.position_world; }

  const ExactHand& hand_;
  const FeelScene& scene_;
  double voxel_;
  std::optional<glm::dvec3> own_;
  long away_ = 0;
};

/// Looks at each step of a way, in order.
class Scorer {
 public:
  /// `same_solid`: of the solid that the method promises, or null.
  Scorer(const FeelScene& scene, const Ideal& ideal, const ExactHand* same_solid = nullptr);
  void judge_step(std::size_t i, const haptics::ProxyStep& step);
  /// Errors, forces and counts. Of falls those that are counted here stand where they are more than the
  /// row's.
  void finish(FeelRow& row);

 private:
  /// What a step adds to the errors, once it is known that the proxy has not parted from the exact hand.
  struct Errors {
    double distance = 0, off = 0, aside = 0, unrendered = 0;
    std::optional<double> degrees;
    bool is_pressed = false;
  };
  void add_errors();
  void add_from_same();
  void find_falls(const glm::dvec3& proxy);

  const FeelScene& scene_;
  const Ideal& ideal_;
  haptics::ForceModel raw_, smoothed_;
  Beside on_shape_, judged_;
  std::optional<Beside> on_same_;
  std::vector<Errors> pending_;
  std::vector<double> pending_same_;
  glm::dvec3 last_force_{0.0};
  glm::ivec3 last_voxel_{-100};
  std::vector<double> raw_n_, smoothed_n_, tangential_;
  std::vector<bool> contact_;
  double distance_square_ = 0, angle_square_ = 0, off_square_ = 0, rendered_square_ = 0, jump_ = 0;
  double most_change_ = 0, most_off_ = 0, deepest_ = 0, most_from_same_ = 0;
  long contacts_ = 0, distance_count_ = 0, angle_count_ = 0, jumps_ = 0, missed_ = 0, ghosts_ = 0;
  long stuck_ = 0, parted_ = 0, entered_ = 0;
  bool was_inside_ = false;
  std::optional<glm::dvec3> last_proxy_;
};

/// A way of a program that says no more than its proxies: contact is where the proxy is not at the HIP, by
/// more than a thousandth of a voxel.
haptics::ProxyStep step_of_answer(const glm::dvec3& proxy, const glm::dvec3& hip);

}  // namespace trephine::bench
