// Preview of a flap before it is cut.
#include "sim/engine/measurement.h"
#include "tests/modules/flap_vault.h"

namespace trephine::bone_flap {
namespace {

/// The lid of the preview has the area of the flap and lies on the surface of the shell. The walls are as
/// deep as the saw cuts. The next change of the outline clears the preview.
TEST(BoneFlap, APreviewShowsTheFlap) {
  const Outline outline(12, 6);
  for (const dvec3& spacing : {dvec3(0.6), dvec3(0.45, 0.45, 3)}) {
    const Vault vault(spacing, 6.5, Vault::shell, 24);
    sim::Lockstep run = vault.run();
    const std::uint64_t before = run.engine().version()->content_hash();
    for (const dvec3& at : outline.anchors) run.apply({AddAnchor{at}, 0});
    PreviewFlap request;
    request.distance = outline.height;
    ASSERT_FALSE(run.apply_and_finish({request, 0}).refused);
    const auto shown = [&] { return *run.engine().state().result_of<FlapPreview>(); };
    EXPECT_FALSE(shown().summary.empty()) << shown().problem;
    const sim::Overlays all = run.engine().overlays();
    ASSERT_EQ(all.size(), 2u);
    EXPECT_EQ(all[0].handles.size(), outline.anchors.size());
    // The lid is 0.6 mm above the skull, so that it is visible. The walls reach through the skull.
    double lid = 0, wall = 0, lowest = k_outer;
    for (const auto& [a, b, c] : all[1].translucent_triangles) {
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
    EXPECT_EQ(run.engine().version()->content_hash(), before);
    EXPECT_FALSE(run.engine().can_undo());

    run.apply({MoveAnchor{1, outline.anchors[0] + dvec3(0, 0, 0.1)}, 0});
    EXPECT_TRUE(shown().summary.empty());
    EXPECT_TRUE(shown().lid.empty());
    // The preview of an invalid outline fails with the reason with which a cut would fail.
    run.apply({MoveAnchor{1, 2.0 * outline.anchors[0]}, 0});
    run.apply_and_finish({request, 0});
    EXPECT_NE(shown().problem.find("anchor 1 lies off the bone"), std::string::npos);
    EXPECT_TRUE(shown().summary.empty());
    // After the failure, the overlay marks only the anchor. It does not draw the outline as that of a flap.
    const sim::Overlays failed = run.engine().overlays();
    ASSERT_EQ(failed.size(), 2u);
    EXPECT_EQ(failed[1].kind, sim::Overlay::Kind::warning);
    EXPECT_EQ(failed[1].lines.size(), 2u);
    for (const auto& line : failed[1].lines)
      for (const dvec3& end : line) EXPECT_LT(glm::length(end - shown().problem_at), 6);
    ASSERT_EQ(failed[1].labels.size(), 1u);
    EXPECT_LT(glm::length(failed[1].labels[0].at - shown().problem_at), 3);
    EXPECT_EQ(failed[0].labels[0].text, "1");
    EXPECT_TRUE(events_of<FlapFailed>(run.engine()).empty());
    // The measure `previews`, for which a procedure may wait, is 1 only after a successful preview.
    const auto previews = [&] { return sim::Measurements(run.engine(), {}).value_of("previews"); };
    EXPECT_EQ(previews(), 0);
    run.apply({MoveAnchor{1, outline.anchors[0]}, 0});
    run.apply_and_finish({request, 0});
    EXPECT_FALSE(shown().summary.empty());
    EXPECT_EQ(previews(), 1);
    CutFlap cuts = outline.request();
    cuts.anchors.clear();
    EXPECT_EQ(cut(run, cuts), "");
    EXPECT_TRUE(shown().summary.empty());
    // The preview of a cut that was already made fails: no bone is left there. Each of the four previews
    // raised an event.
    EXPECT_FALSE(run.apply_and_finish({request, 0}).refused);
    EXPECT_NE(shown().problem.find("no bone left along the outline"), std::string::npos) << shown().summary;
    const auto seen = events_of<FlapPreviewed>(run.engine());
    ASSERT_EQ(seen.size(), 4u);
    EXPECT_NEAR(seen[0].first.area / outline.area(), 1, 0.01);
    EXPECT_EQ(seen[1].first.area, 0);
    EXPECT_NE(seen[1].first.summary.find("off the bone"), std::string::npos);
    EXPECT_EQ(seen[2].first.area, seen[0].first.area);
    request.saw = Saw::w0_8;
    EXPECT_EQ(run.apply({request, 0}).refused.has_value(),
              run.apply({outline.request(Saw::w0_8), 0}).refused.has_value());
    request.item = 1;
    const sim::Outcome no_shape = run.apply({request, 0});
    ASSERT_TRUE(no_shape.refused.has_value());
    EXPECT_NE(no_shape.refused->what.find("unknown shape"), std::string::npos);
  }
}

/// The saw enters a forbidden structure in the bone, such as a sinus. The preview reports the depth before
/// the cut, and the cut raises an event with depth and location. The footplate strips a structure below the
/// inner table, which is not torn.
TEST(BoneFlap, ForbiddenStructuresAreCheckedAgainstTheSaw) {
  const Outline outline(12, 6);
  const Vault vault(dvec3(0.6), 6.5, Vault::shell, 24);
  for (const double above : {1.0, -0.2, -6.0}) {  // mm from the inner table to the top of the structure
    const double top = k_inner + above;
    const auto within = [top](const dvec3& p) { return 100 * std::clamp(top - glm::length(p), -5.0, 5.0); };
    const auto dura = sim::Forbidden::build(std::make_shared<const volume::Volume>(scenes::sampled(
                                                {-24, -24, 45}, {24, 24, 82}, dvec3(0.6), within)),
                                            {"dura", 0})
                          .value();
    static const BoneFlap module;
    static const sim::Catalogue catalogue({&module});
    sim::Lockstep run(sim::Engine(vault.scene, *vault.method, {}, 1e-3, catalogue, {dura}), {}, 1000);
    for (const dvec3& at : outline.anchors) run.apply({AddAnchor{at}, 0});
    PreviewFlap preview;
    preview.distance = outline.height;
    run.apply_and_finish({preview, 0});
    const std::string seen = run.engine().state().result_of<FlapPreview>()->summary;
    EXPECT_EQ(cut(run, outline.request()), "");
    const auto torn = events_of<sim::StructureTorn>(run.engine());
    EXPECT_TRUE(events_of<sim::StructureTouched>(run.engine()).empty());
    if (above < 0) {
      EXPECT_TRUE(torn.empty());
      EXPECT_EQ(seen.find("dura"), std::string::npos) << seen;
      continue;
    }
    ASSERT_EQ(torn.size(), 1u);
    EXPECT_NEAR(torn[0].first.deepest, above, 0.25);
    EXPECT_NEAR(glm::length(torn[0].second), k_inner + 0.8, 0.4);
    EXPECT_NE(seen.find("mm into dura"), std::string::npos) << seen;
  }
}

}  // namespace
}  // namespace trephine::bone_flap
