// Servo: a hand over a plane of bone. Tests step its servo core directly, without the servo thread.
#pragma once

#include <gtest/gtest.h>
#include <limits>

#include "apps/bench/scenes/scenes.h"
#include "haptics/force/effects.h"
#include "haptics/methods/methods.h"
#include "haptics/servo/servo_core.h"

namespace trephine::haptics {

using glm::dvec3;

constexpr double k_dt = 1e-3;

/// Voxel spacing and shear of a stack of slices; isotropic 2.5 mm by default.
struct Slices {
  double across = 2.5, thick = 2.5, shear = 0;  ///< mm, mm, degrees
};
constexpr Slices k_slices[] = {{}, {1.5, 3.75, 0}, {0.8, 9.6, 0}, {1.2, 6, 25}};

inline TouchScene scene_of_plane(const Slices& slices = {}) {
  data_tools::PhantomOptions o;
  o.spacing_mm = {slices.across, slices.across, slices.thick};
  o.shear_degrees = slices.shear;
  o.size = glm::ivec3(48);
  o.psf_sigma_voxels = 1.5;
  o.parameters = {{"angle", 0}};
  TouchScene scene = scenes::phantom_scene("plane", o);
  scene.items[0].material = {0.5, 0.001, 0, 0};
  return scene;
}

inline ServoLaw law_of(const std::string& words, std::uint32_t id = 0) {
  const auto effect = parse_effect(words);
  EXPECT_TRUE(effect) << effect.error().message();
  return haptics::law_of(effect.value(), id).value();
}

struct Servo {
  TouchScene scene;
  std::unique_ptr<ProxyMethod> method;
  ServoScene seen;
  ServoCore core;
  std::vector<TouchEvent> events;
  explicit Servo(TouchScene s, const std::string& name = "subvoxel", const ForceOptions& options = {})
      : scene(std::move(s)),
        method(make_method(name).value()),
        seen((static_cast<void>(method->prepare(scene)),
              scene_for_one(scene, *method, std::make_shared<volume::Version>(scene.base)))),
        core(options, k_dt) {}
  ServoHand& hand() { return seen.hands[0]; }
  void set_laws(const std::vector<const char*>& effects) {
    auto laws = std::make_shared<LawSet>();
    for (const char* words : effects)
      EXPECT_FALSE(laws->add(law_of(words, static_cast<std::uint32_t>(laws->laws().size()))).has_value());
    hand().laws = std::move(laws);
  }
  ServoRecord step(const dvec3& hip) {
    ServoInput input;
    input.pose.position_world = hip;
    const ServoRecord r = core.step(seen, input);
    for (std::size_t e = 0; e < r.event_count; ++e) events.push_back(r.events[e]);
    return r;
  }
  long count(TouchEvent::Kind kind) const {
    return std::count_if(events.begin(), events.end(),
                         [kind](const TouchEvent& e) { return e.kind == kind; });
  }
};

inline void expect_near(const dvec3& a, const dvec3& b, double within) {
  EXPECT_LT(glm::length(a - b), within);
}

}  // namespace trephine::haptics
