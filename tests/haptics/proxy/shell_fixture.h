// Rods as whole tools, and a play of ShellProxy, for its tests.
#pragma once

#include <functional>
#include <gtest/gtest.h>
#include <map>
#include <string>

#include "haptics/proxy/shell_proxy.h"
#include "haptics/tool/point_shell.h"
#include "tests/haptics/servo/servo_fixture.h"

namespace trephine::haptics {

/// A rod along the z axis of the hand, from `low` to `high`; mm.
struct Rod {
  double low, high, radius;
};
inline constexpr Rod k_shaft{-2, 28, 1.2};

inline SharedTool shell_of(const Rod& rod, double spacing) {
  return sample_surface(std::make_shared<const ToolShape>(
                            ToolProfile{{{rod.low, rod.radius}, {rod.high, rod.radius}}, spacing}))
      .value();
}

inline TouchScene scene_with(const char* phantom, const std::map<std::string, double>& parameters,
                             SharedTool tool,
                             const std::function<void(data_tools::PhantomOptions&)>& change = nullptr) {
  data_tools::PhantomOptions o = phantom_options(96);
  o.parameters = parameters;
  if (change) change(o);
  TouchScene scene = scenes::phantom_scene(phantom, o);
  EXPECT_FALSE(set_tool(scene, std::move(tool)));
  return scene;
}

struct ShellPlay {
  const TouchScene& scene;
  ShellProxy method;
  ProxyState state;
  TouchState touch_state;
  explicit ShellPlay(const TouchScene& s)
      : scene(s), touch_state(std::shared_ptr<const volume::Version>(uncut_version(s))) {
    EXPECT_FALSE(method.prepare(scene));
  }
  ProxyStep step(const Placement& hand, std::span<const Placement> movers = {}) {
    return method.step(scene, touch_state, state, {hand.position_world, movers, hand.rotation});
  }
  Placement tool(const ProxyStep& r) const { return {r.proxy_world, state.tool_turn}; }
};

}  // namespace trephine::haptics
