// Judges the friction of a hand in a session, by code that shares nothing with what it judges.
#pragma once

#include <memory>
#include <vector>

#include "haptics/servo/servo_core.h"
#include "haptics/servo/servo_scene.h"
#include "tests/checker/mesh_judge.h"
#include "tests/checker/smooth_judge.h"

namespace trephine::app {

/// Coulomb's cone at the proxy: on shapes of the anatomy by the scan's own samples and cuts, on models by
/// their triangles. A scene with other scans or with depth images is not judged.
class FrictionAudit {
 public:
  struct Found {
    long judged = 0, slid = 0;  ///< ticks; and those of them in which the proxy slid along one wall
    long outside = 0;           ///< ticks in which friction held more than its cone does
    long slid_with_less =
        0;             ///< slides over a bump that ended without friction; they take and make no energy
    double worst = 0;  ///< share of the pull outside the cone
    Found& operator+=(const Found& other);
  };

  /// Sets the scene and the cuts that the next ticks touch.
  void set_solid(const std::shared_ptr<const haptics::ServoHand>& hand);
  /// Judges a tick in contact; `pull`: mm, from the proxy to the hand.
  void judge(const haptics::ServoRecord& record, const haptics::Material& material, const glm::dvec3& pull);
  const Found& found() const { return found_; }
  /// Returns what to add to a pull so that no wall of that normal holds it.
  static glm::dvec3 planted(const glm::dvec3& pull, const glm::dvec3& normal, double coefficient);

 private:
  struct Solid {
    checker::SmoothSolid solid;
    volume::Frame frame;
  };
  /// A model at its place.
  struct Model {
    std::shared_ptr<const checker::MeshWall> wall;
    haptics::Placement placement;
    double radius;  ///< mm, of the tool
    bool holds = true;
  };
  /// Adds the facets of models that touch the tool at the proxy.
  void add_facets(const glm::dvec3& proxy_world, std::vector<glm::dvec3>& walls) const;
  static std::shared_ptr<const checker::MeshWall> wall_of(const haptics::MeshTree& tree);
  std::vector<Solid> solids_;
  std::vector<Model> models_;
  std::shared_ptr<const haptics::TouchScene> scene_;
  glm::dvec3 last_{0.0}, last_hand_{0.0};
  bool is_new_ = true;
  Found found_;
};

}  // namespace trephine::app
