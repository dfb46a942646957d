// The sequential proxy on scenes: models first, then each volume after them.
#pragma once

#include "haptics/proxy/implicit_proxy.h"

namespace trephine::haptics {

/// The pipeline of the thesis "A Surface-based Volume Haptics Approach" (4.2.2): a god-object on the meshes
/// follows the hand, then every volume for itself follows that god-object, and the one with the shortest
/// penetration counts. Kept honest: what the volumes push the proxy into, no mesh hears of (figure 23). A
/// scene that is changed after prepare() is seen as it was.
class SequentialProxy final : public ProxyMethod {
 public:
  const char* name() const noexcept override { return "scene-sequential"; }
  volume::Status prepare(const TouchScene& scene) override;
  ProxyStep step(const TouchScene& scene, const TouchState& seen, ProxyState& state,
                 const ProxyInput& input) const noexcept override;

 private:
  /// A volume as a scene of its own.
  struct Part {
    TouchScene scene;
    int first;                                    ///< of its shapes, as the whole scene counts
    std::shared_ptr<const TouchState> untouched;  ///< null: the base, whose state comes with the step

    int count() const noexcept { return item_count(scene); }
    const TouchState& state(const TouchState& of_base) const noexcept {
      return untouched ? *untouched : of_base;
    }
  };
  /// Result of one volume alone.
  struct Answer {
    ProxyStep step;
    ProxyState state;
    double depth = 1e300;  ///< mm to where it was met; 1e299: not at all
  };
  void begin(const TouchState& seen, const glm::dvec3& hip, ProxyState& state) const noexcept;
  Answer follow(const Part& part, const TouchState& seen, const ProxyState& state, const glm::dvec3& start,
                const glm::dvec3& target) const noexcept;

  std::vector<Part> parts_;  ///< the base first
  ImplicitProxy method_;
};

}  // namespace trephine::haptics
