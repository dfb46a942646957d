// SequentialProxy: contact with scenes, first with all meshes, then with each volume.
#pragma once

#include "haptics/proxy/implicit_proxy.h"

namespace trephine::haptics::baselines {

/// The pipeline of Jiang (dissertation "A Surface-based Volume Haptics Approach", 4.2.2): a god-object on the
/// meshes follows the hand; then, on every volume alone, a proxy follows that god-object. The proxy that is
/// stopped first counts. Implemented with its faults: meshes do not react when volumes push the proxy into
/// them (figure 23). Changes of a scene after prepare() have no effect.
class SequentialProxy final : public ProxyMethod {
 public:
  static constexpr MethodInfo k_info{
      .name = "scene-sequential",
      .meaning = "a god-object on the models, then each volume after it",
      .source = "Jiang, dissertation \"A Surface-based Volume Haptics Approach\", 4.2.2",
      .solid = MethodInfo::Solid::cubes,
      .takes_ball = true,
      .takes_meshes = true,
      .takes_moving_meshes = true};
  const MethodInfo& info() const noexcept override { return k_info; }
  Status prepare(const TouchScene& scene) override;
  ProxyStep step(const TouchScene& scene, const TouchState& touch_state, ProxyState& state,
                 const ProxyInput& input) const noexcept override;

 private:
  /// A volume as a scene of its own.
  struct Part {
    TouchScene scene;
    int first;                                ///< index of its first shape in the whole scene
    std::shared_ptr<const TouchState> uncut;  ///< null: the base volume, whose state each step passes

    int count() const noexcept { return item_count(scene); }
    const TouchState& state(const TouchState& base_state) const noexcept {
      return uncut ? *uncut : base_state;
    }
  };
  /// Result of one volume alone.
  struct PartResult {
    ProxyStep step;
    ProxyState state;
    double depth = 1e300;  ///< mm from the start to the contact; 1e299: no contact; 1e300: not computed
  };
  void begin(const TouchState& touch_state, const glm::dvec3& hip, ProxyState& state) const noexcept;
  PartResult follow(const Part& part, const TouchState& touch_state, const ProxyState& state,
                    const glm::dvec3& start, const glm::dvec3& target) const noexcept;

  std::vector<Part> parts_;  ///< the base volume first
  ImplicitProxy method_;
};

}  // namespace trephine::haptics::baselines
