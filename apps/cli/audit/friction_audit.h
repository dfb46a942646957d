// FrictionAudit: judges the friction of a hand in a session, with code independent of the judged code.
#pragma once

#include <memory>
#include <vector>

#include "apps/verify/mesh_judge.h"
#include "apps/verify/smooth_judge.h"
#include "haptics/servo/servo_core.h"
#include "haptics/servo/servo_scene.h"

namespace trephine::cli {

/// Checks Coulomb's cone at the proxy: on shapes of the anatomy by the scan's own samples and cuts, on models
/// by their triangles. Not judged: scenes with additional scans or depth images, methods that do not touch
/// the smooth solid, and tools with six degrees of freedom.
class FrictionAudit {
 public:
  struct Found {
    long judged = 0, slid = 0;  ///< judged ticks, and those in which the proxy slid along one wall
    long outside = 0;           ///< ticks in which friction held a pull outside its cone
    /// Ticks in which a slide ended with less than the dynamic friction, as after a bump. Reported, not a
    /// fault.
    long slid_with_less = 0;
    double worst = 0;  ///< largest distance of a pull from the cone, as a share of the pull
    Found& operator+=(const Found& other);
  };

  /// Sets the scene and the cuts that are touched in the next ticks.
  void set_solid(const std::shared_ptr<const haptics::ServoHand>& hand);
  /// Judges a tick in contact; `pull`: mm, from the proxy to the hand.
  void judge(const haptics::ServoRecord& record, const haptics::Material& material, const glm::dvec3& pull);
  const Found& found() const { return found_; }
  /// Returns the vector (mm) that, added to the pull, moves it outside the cone of a wall with this normal
  /// and friction coefficient.
  static glm::dvec3 planted(const glm::dvec3& pull, const glm::dvec3& normal, double coefficient);

 private:
  struct Solid {
    verify::SmoothSolid solid;
    volume::Frame frame;
  };
  /// A model at its placement.
  struct Model {
    std::shared_ptr<const verify::MeshWall> wall;
    haptics::Placement placement;
    double radius;  ///< radius of the tool, mm
    bool blocks = true;
  };
  /// Adds the facets of models that touch the tool at the proxy.
  void add_facets(const glm::dvec3& proxy_world, std::vector<glm::dvec3>& walls) const;
  static std::shared_ptr<const verify::MeshWall> wall_of(const haptics::MeshTree& tree);
  std::vector<Solid> solids_;
  std::vector<Model> models_;
  std::shared_ptr<const haptics::TouchScene> scene_;
  glm::dvec3 last_{0.0}, last_hand_{0.0};
  bool is_new_ = true;
  Found found_;
};

}  // namespace trephine::cli
