// A servo core whose memory is saved and loaded in the middle of a run continues with identical bits.
#include "haptics/servo/servo_memory.h"

#include <cmath>
#include <gtest/gtest.h>
#include <random>

#include "haptics/force/effects.h"
#include "haptics/methods/methods.h"
#include "tests/haptics/servo/servo_fixture.h"
#include "volume/cuts/removal.h"

namespace trephine::haptics {
namespace {

struct Path {
  std::mt19937 random;
  glm::dvec3 at{0, 0, 60};
  Pose next(int i) {
    std::normal_distribution<double> noise(0, 0.2);
    const double depth = 42 + 9 * std::sin(0.05 * i);
    at = {depth * std::sin(0.3 + 0.3 * std::sin(0.003 * i)) + noise(random),
          5 * std::cos(0.02 * i) + noise(random),
          depth * std::cos(0.3 + 0.3 * std::sin(0.003 * i)) + noise(random)};
    return {at, {1, 0, 0, 0}, i % 300 < 200 ? 1u : 0u};
  }
};

ServoInput input_at(Path& path, int i) {
  ServoInput input;
  input.pose = path.next(i);
  if (i % 700 == 650) input.faults = fault_lost_device;
  input.is_reset = i % 700 == 690;
  if (i % 910 == 905) {
    input.is_restarted = true;
    input.restart_volume = {2, 2, 2};
  }
  if (i % 1300 == 1200) input.pose.position_world.x = std::nan("");
  return input;
}

std::shared_ptr<ServoScene> with(const ServoScene& before, std::shared_ptr<const volume::Version> version) {
  auto next = std::make_shared<ServoScene>(before);
  ++next->serial;
  next->hands[0].state = TouchState(std::move(version));
  return next;
}
/// Returns a scene in which matter grows over the proxy, with an escape path.
std::shared_ptr<ServoScene> grown(const ServoScene& before, std::shared_ptr<const volume::Version> version,
                                  const glm::dvec3& proxy) {
  auto next = with(before, std::move(version));
  EscapePath way;
  way.serial = next->serial;
  way.count = 5;
  for (std::uint32_t k = 0; k < way.count; ++k)
    way.positions_volume[k] = next->hands[0].scene->base->frame.volume_from_world(proxy * (1 + 0.1 * k));
  next->hands[0].escape_path = std::make_shared<const EscapePath>(way);
  return next;
}

class ServoMemories : public testing::TestWithParam<const char*> {};

TEST_P(ServoMemories, ContinueFromAnyTickWithIdenticalBits) {
  TouchScene scene = scenes::phantom_scene("sphere", phantom_options(48));
  scene.items[0].material.static_friction = 0.5;
  scene.items[0].material.dynamic_friction = 0.3;
  scene.items[0].material.pop_force = 3;
  const auto method = make_method(GetParam()).value();
  ASSERT_FALSE(method->prepare(scene));
  auto laws = std::make_shared<LawSet>();
  for (const char* words : {"vibration direction=0,0,1 amplitude=0.2 frequency=90",
                            "line start=0,0,35 ahead=0,0,-1", "viscous damping=0.001"})
    ASSERT_FALSE(laws->add(
        law_of(parse_effect(words).value(), static_cast<std::uint32_t>(laws->laws().size() + 3)).value()));
  volume::RemovalEditor editor(std::make_shared<volume::Version>(scene.base), {scene.items[0].field});
  const auto whole = editor.publish();
  editor.remove({{0, 0, 45}, {25, 0, 35}, 12, false});
  const auto cut = editor.publish();
  for (const bool is_passive : {false, true}) {
    ForceOptions options;
    options.is_passive = is_passive;
    options.delay_ticks = is_passive ? 2 : 0;
    ServoCore core(options, 1e-3);
    std::shared_ptr<const ServoScene> seen = servo_scene_of(scene, *method);
    auto with_laws = std::make_shared<ServoScene>(*seen);
    with_laws->hands[0].laws = laws;
    seen = with_laws;
    Path path{std::mt19937(5)};
    long contacts = 0, escaping_ticks = 0, loads = 0;
    std::optional<ServoCore> loaded;
    for (int i = 0; i < 4000; ++i) {
      const ServoInput input = input_at(path, i);
      if (i % 500 == 100) seen = with(*seen, cut);
      if (i % 500 == 400) seen = grown(*seen, whole, core.last_step().proxy_world);
      const ServoRecord record = core.step(*seen, input);
      contacts += record.has_contact;
      escaping_ticks += record.is_escaping;
      if (loaded) {
        const ServoRecord again = loaded->step(*seen, input);
        std::string a, b;
        put_record(a, record);
        put_record(b, again);
        ASSERT_EQ(a, b) << "tick " << i << ", " << loads;
      }
      if (i % 37 == 36) {
        const std::string bytes = ServoMemory::save(core, seen->hands[0]);
        loaded.emplace(options, 1e-3);
        ASSERT_TRUE(ServoMemory::load(bytes, seen->hands[0], *loaded)) << i;
        ASSERT_EQ(ServoMemory::save(*loaded, seen->hands[0]), bytes);
        ++loads;
        std::string_view in = bytes;
        ServoRecord back;
        std::string result;
        put_record(result, record);
        in = result;
        ASSERT_TRUE(get_record(in, back) && in.empty());
      }
    }
    EXPECT_GT(contacts, 200);
    EXPECT_GT(loads, 90);
    EXPECT_GT(escaping_ticks, 0);
  }
}

TEST_P(ServoMemories, BrokenBytesAreRefusedOrHarmless) {
  const TouchScene scene = scenes::phantom_scene("sphere", phantom_options(32));
  const auto method = make_method(GetParam()).value();
  ASSERT_FALSE(method->prepare(scene));
  const auto seen = servo_scene_of(scene, *method);
  ServoCore core({}, 1e-3);
  Path path{std::mt19937(5)};
  for (int i = 0; i < 500; ++i) core.step(*seen, {path.next(i)});
  const std::string bytes = ServoMemory::save(core, seen->hands[0]);
  std::mt19937 random(9);
  int refused = 0;
  for (int i = 0; i < 2000; ++i) {
    std::string wrong = bytes;
    if (i % 5 == 0)
      wrong.resize(random() % wrong.size());
    else
      wrong[random() % wrong.size()] = static_cast<char>(random());
    ServoCore loaded({}, 1e-3);
    if (!ServoMemory::load(wrong, seen->hands[0], loaded)) {
      ++refused;
      continue;
    }
    for (int k = 0; k < 5; ++k) {
      const ServoRecord r = loaded.step(*seen, {path.next(500 + k)});
      ASSERT_TRUE(std::isfinite(r.force_world.x + r.force_world.y + r.force_world.z));
      ASSERT_LE(glm::length(r.force_world), 8.001);
    }
  }
  EXPECT_GT(refused, 400);  // all truncated bytes (one input in five), and some changed bytes
}

// More points of the tool are near matter than a step can test. The points left out are not tested, so that
// the number of points in matter is unknown.
TEST(ServoMemory, OfAToolWithPointsLeftOutIsLoaded) {
  data_tools::PhantomOptions options = phantom_options(48);
  options.parameters = {{"angle", 0}};
  TouchScene scene = scenes::phantom_scene("plane", options);
  const auto tool = sample_surface(std::make_shared<const ToolShape>(ToolProfile{{{0, 9}, {20, 9}}, 0.2}));
  ASSERT_TRUE(tool);
  ASSERT_FALSE(set_tool(scene, tool.value()));
  const auto method = make_method("shell").value();
  ASSERT_FALSE(method->prepare(scene));
  const auto seen = servo_scene_of(scene, *method);
  ServoCore core({}, 1e-3);
  ServoRecord record;
  for (int i = 0; i < 120; ++i) record = core.step(*seen, {Pose{{0, 0, 10 - 0.1 * i}, {1, 0, 0, 0}}});
  EXPECT_TRUE(record.has_contact);
  ServoCore loaded({}, 1e-3);
  ASSERT_TRUE(ServoMemory::load(ServoMemory::save(core, seen->hands[0]), seen->hands[0], loaded));
  for (int i = 0; i < 20; ++i) {
    std::string a, b;
    const ServoInput input{Pose{{0.05 * i, 0, -2}, {1, 0, 0, 0}}};
    put_record(a, core.step(*seen, input));
    put_record(b, loaded.step(*seen, input));
    ASSERT_EQ(a, b) << i;
  }
}

INSTANTIATE_TEST_SUITE_P(All, ServoMemories, testing::Values("implicit", "subvoxel", "explicit", "scene"));

}  // namespace
}  // namespace trephine::haptics
