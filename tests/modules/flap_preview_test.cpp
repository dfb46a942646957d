// What is shown of a flap before it is cut.
#include "tests/modules/flap_vault.h"

namespace trephine::bone_flap {
namespace {

/// What would come off is shown before it is cut: as large as the shell's, on it, as deep as the saw goes.
/// It is gone with the next change of the outline.
TEST(BoneFlap, APreviewShowsWhatWouldComeOff) {
  const Outline outline(12, 6);
  for (const dvec3& spacing : {dvec3(0.6), dvec3(0.45, 0.45, 3)}) {
    const Vault vault(spacing, 6.5, Vault::shell, 24);
    sim::Lockstep run = vault.run();
    const std::uint64_t before = run.engine().current()->content_hash();
    for (const dvec3& at : outline.anchors) run.apply({AddAnchor{at}, 0});
    PreviewFlap wish;
    wish.distance = outline.height;
    ASSERT_FALSE(run.apply_whole({wish, 0}).refused);
    const auto shown = [&] { return *run.engine().now().settings_of<FlapSettings>(); };
    EXPECT_FALSE(shown().preview.empty()) << shown().trouble;
    const sim::Overlays all = run.engine().overlays();
    ASSERT_EQ(all.size(), 2u);
    EXPECT_EQ(all[0].handles.size(), outline.anchors.size());
    // The lid lies 0.6 mm above the skull, so that it is seen; the walls reach through it.
    double lid = 0, wall = 0, lowest = k_outer;
    for (const auto& [a, b, c] : all[1].skin) {
      const double area = 0.5 * glm::length(glm::cross(b - a, c - a));
      const double nearest = std::min({glm::length(a), glm::length(b), glm::length(c)});
      (nearest > k_outer - 0.5 ? lid : wall) += area;
      lowest = std::min(lowest, nearest);
      for (const dvec3& p : {a, b, c})
        if (nearest > k_outer - 0.5) {
          EXPECT_NEAR(glm::length(p), k_outer + 0.6, 0.3 * spacing.z);
        }
    }
    EXPECT_NEAR(lid / outline.area(), 1, 0.03);
    EXPECT_GT(wall, outline.wall());  // from above the outer table to under the inner one
    EXPECT_LT(lowest, k_inner);
    EXPECT_EQ(run.engine().current()->content_hash(), before);
    EXPECT_FALSE(run.engine().can_undo());

    run.apply({MoveAnchor{1, outline.anchors[0] + dvec3(0, 0, 0.1)}, 0});
    EXPECT_TRUE(shown().preview.empty());
    EXPECT_TRUE(shown().lid.empty());
    // Where there would be none it says why, as cutting does.
    run.apply({MoveAnchor{1, 2.0 * outline.anchors[0]}, 0});
    run.apply_whole({wish, 0});
    EXPECT_NE(shown().trouble.find("anchor 1 lies off the bone"), std::string::npos);
    EXPECT_TRUE(shown().preview.empty());
    EXPECT_TRUE(told<NoFlap>(run.engine()).empty());
    run.apply({MoveAnchor{1, outline.anchors[0]}, 0});
    run.apply_whole({wish, 0});
    EXPECT_FALSE(shown().preview.empty());
    CutFlap cuts = outline.wish();
    cuts.anchors.clear();
    EXPECT_EQ(cut(run, cuts), "");
    EXPECT_TRUE(shown().preview.empty());
    wish.item = 1;
    const sim::Outcome no_shape = run.apply({wish, 0});
    ASSERT_TRUE(no_shape.refused.has_value());
    EXPECT_NE(no_shape.refused->what.find("no such shape"), std::string::npos);
  }
}

}  // namespace
}  // namespace trephine::bone_flap
