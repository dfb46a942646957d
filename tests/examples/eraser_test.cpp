// The module of docs/how-to/add-a-module.md behaves as described on that page.
#include "modules/eraser/eraser.h"

#include "haptics/proxy/subvoxel_proxy.h"
#include "sim/engine/scene_description.h"
#include "tests/sim/opens_anywhere.h"
#include "tests/sim/session_fixture.h"

namespace trephine::sim {
namespace {

using eraser::Erased;
using eraser::Eraser;
using eraser::EraserTotal;
using eraser::LimitEraser;

const Catalogue& catalogue() {
  static const eraser::EraserModule module;
  static const Catalogue all({&module});
  return all;
}

double erased(const Engine& engine) { return engine.state().undoable_of<EraserTotal>()->amount; }

TEST(Eraser, ErasesRaisesEventsCountsUndoesAndOpensAnywhere) {
  const Folder folder;
  const std::string path = folder.file("eraser.session");
  haptics::TouchScene scene = small_bone();
  SceneDescription spec = describe_scene(scene, haptics::SubvoxelProxy(), {}, {HandSpec()});
  spec.hands[0].instrument = "eraser";
  spec.hands[0].parameters = "diameter=2.5";
  spec.smallest_burr = 2;
  {
    auto start = build_scene(spec, data_of(scene), catalogue());
    ASSERT_TRUE(start.is_ok()) << start.error().message();
    auto writer = SessionWriter::create(path, SessionHeader(describe_scene(start.value().hands, {})),
                                        data_of(scene), catalogue(), with_checkpoint_work(300))
                      .value();
    Lockstep run(Engine(start.value().hands, 1e-3, catalogue()), {}, 1000, writer.get());
    double first = 0;
    for (int stroke = 0; stroke < 3; ++stroke) {
      for (int i = 0; i < 400; ++i)
        run.step({{-6 + 0.03 * i, 3.0 * stroke - 3, 1.5}, {1, 0, 0, 0}, i < 390 ? 1u : 0u});
      if (stroke == 0) first = run.engine().removed_mm3();
    }
    EXPECT_GT(first, 10);
    EXPECT_NEAR(erased(run.engine()), run.engine().removed_mm3(), 1e-6);
    const Chronicle& events = run.engine().state().chronicle;
    ASSERT_EQ(events.size(), 3u);
    EXPECT_NEAR(events[0].value.as<Erased>()->amount, first, 1e-6);
    EXPECT_EQ(run.engine().measures().back().name, "erased");

    // The overlay: a flag at the end of the newest stroke.
    const Overlays shown = run.engine().overlays();
    ASSERT_EQ(shown.size(), 1u);
    EXPECT_NEAR(shown[0].placement.position_world.y, 3, 1e-9);
    EXPECT_TRUE(shown[0].labels.at(0).text.ends_with("mm3 erased"));

    // The limit is a setting: undo keeps it, and removes the strokes.
    EXPECT_FALSE(run.apply(LimitEraser{first + 1}).refused);
    EXPECT_TRUE(run.apply(Eraser{3}).refused);
    run.undo(), run.undo();
    EXPECT_NEAR(erased(run.engine()), first, 1e-6);
    EXPECT_FALSE(run.apply(Eraser{3}).refused);
    EXPECT_TRUE(run.apply(Eraser{30}).refused);
    EXPECT_TRUE(run.apply(LimitEraser{-1}).refused);
    for (int i = 0; i < 300; ++i) run.step({{0, 0.03 * i, 1}, {1, 0, 0, 0}, i < 290 ? 1u : 0u});
    EXPECT_FALSE(writer->finish(run.engine()));
  }
  expect_opens_anywhere(path, catalogue(), scene.base, 3);
}

}  // namespace
}  // namespace trephine::sim
