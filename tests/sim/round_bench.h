// RoundBench: a round tool on the small bone.
#pragma once

#include "tests/sim/session_fixture.h"

namespace trephine::sim {

/// A round burr (Burr::is_round) on the small bone, and a scene whose tool has the burr's touch radius.
struct RoundBench {
  haptics::TouchScene scene = small_bone();
  std::unique_ptr<haptics::ProxyMethod> method = haptics::make_method("subvoxel").value();
  drilling::Burr burr{3, 60};

  RoundBench() {
    burr.is_round = true;
    EXPECT_FALSE(haptics::set_smallest_burr(scene, burr.diameter).has_value());
    EXPECT_FALSE(haptics::set_tool_radius(scene, drilling::touch_radius(burr, *scene.base), 1).has_value());
    EXPECT_FALSE(method->prepare(scene).has_value());
  }
  std::unique_ptr<SessionWriter> writer(const std::string& path, double rate = 1000,
                                        const WriterOptions& options = {}) {
    haptics::ServoOptions servo;
    servo.rate_hz = rate;
    SessionHeader h = describe_scene(scene, *method, servo, {HandSpec(drilling::burr(burr))});
    return SessionWriter::create(path, h, scene.base, drilling_catalogue(), options).value();
  }
};

}  // namespace trephine::sim
