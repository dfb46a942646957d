#include "modules/bone_flap/bone_flap.h"

#include "tests/modules/flap_vault.h"
#include "tests/modules/traced_voxels.h"

namespace trephine::bone_flap {
namespace {

TEST(BoneFlap, AreaWallsAndKerfEqualAShells) {
  const Outline outline(14, 6);
  for (const dvec3& spacing : {dvec3(0.45), dvec3(0.9), dvec3(0.45, 0.45, 3), dvec3(0)}) {
    SCOPED_TRACE(spacing.z);
    const Vault vault = spacing.z > 0 ? Vault(spacing, 6.5, Vault::shell, 24) : Vault(Vault::sheared(), 6.5);
    sim::Lockstep run = vault.run();
    ASSERT_EQ(cut(run, outline.request()), "");
    const auto cuts = events_of<FlapCut>(run.engine());
    ASSERT_EQ(cuts.size(), 1u);
    const FlapCut& flap = cuts[0].first;
    EXPECT_EQ(flap.pieces, 1);
    EXPECT_EQ(flap.holes, 0);
    EXPECT_NEAR(flap.area / outline.area(), 1, 0.01);
    EXPECT_NEAR(flap.wall / outline.wall(), 1, 0.01);
    EXPECT_NEAR(flap.kerf_size / (outline.wall() * 1.6), 1, 0.02);
    // The kerf is centred on the outline: half of it is cut from the flap.
    const double shell = (k_outer * k_outer * k_outer - k_inner * k_inner * k_inner) / 3;
    EXPECT_NEAR(flap.flap_size / (outline.solid_angle() * shell - 0.5 * outline.wall() * 1.6), 1, 0.03);
    ASSERT_EQ(run.engine().state().undoable.bodies.size(), 1u);
    EXPECT_EQ(run.engine().state().undoable.bodies[0].piece->mm3, flap.flap_size);
  }
}

/// Numbers of points of bone in the cells of the cut lattice, by outcome, in units of the masks. The ledger
/// of the version is compared with them.
struct Points {
  std::int64_t before = 0, kerf = 0, flap = 0, rest = 0, elsewhere = 0;
};

/// Counts all points of the cut lattice one by one. `left`: the version after the cut. `sheet`: the surface
/// of the cut. `width`: of the saw, mm.
Points count_points(const Vault& vault, const volume::Version& left, const CutSurface& sheet, double width) {
  Points points;
  const volume::Field& bone = vault.scene.items[0].field;
  const volume::CutLattice& lattice = left.lattice();
  std::vector<CutSurface::Strip> strips;
  for (std::size_t i = 0; i < sheet.lines().size(); ++i) strips.push_back(sheet.strip(i));
  left.for_bricks_in(
      glm::ivec3(0), lattice.size() - 1, [&](const glm::ivec3& low, const volume::Brick& brick) {
        for (int z = 0; z < volume::k_brick; ++z)
          for (int y = 0; y < volume::k_brick; ++y)
            for (int x = 0; x < volume::k_brick; ++x) {
              const glm::ivec3 sample = low + glm::ivec3(x, y, z);
              if (!vault.scene.base->contains(lattice.voxel_of(sample))) continue;
              const int n = brick.mask ? brick.mask->n : 4;
              for (int p = 0; p < n * n * n; ++p) {
                const dvec3 at =
                    dvec3(sample) +
                    (dvec3(p % n, p / n % n, p / (n * n)) + 0.5 + dvec3(volume::point_shift(sample))) /
                        static_cast<double>(n) -
                    0.5;
                if (bone.value(lattice.volume_from_lattice(at)) < 0) continue;
                const std::int64_t units = 512 / (n * n * n);
                points.before += units;
                const auto word = volume::Brick::index(x, y, z) * static_cast<std::size_t>(n * n * n / 64) +
                                  static_cast<std::size_t>(p / 64);
                const bool is_gone =
                    brick.is_hollow || (brick.mask && (brick.mask->words[word] >> (p % 64) & 1));
                if (!is_gone) {
                  points.rest += units;
                  continue;
                }
                const dvec3 world = lattice.frame().world_from_volume(at);
                double square = 1e9;
                for (const CutSurface::Strip& strip : strips)
                  square = std::min(square, CutSurface::distance_square(strip, world));
                const double from_saw = std::sqrt(square) - 0.5 * width;
                if (from_saw <= 0)
                  points.kerf += units;
                else if (sheet.pyramid().contains(world))
                  points.flap += units;
                else if (from_saw > 0.1)  // mm: interpolated distances may be smaller at corners
                  points.elsewhere += units;
              }
            }
      });
  return points;
}

TEST(BoneFlap, AFlapIsFoundFromTheBoneNearestToItsCentre) {
  // One outline has a burr hole at its centre. The other is a horseshoe, and its centre lies outside it.
  CutFlap horseshoe;
  for (const auto& [x, y] : std::initializer_list<std::pair<double, double>>{
           {-15, -15}, {15, -15}, {15, 15}, {9, 15}, {9, -9}, {-9, -9}, {-9, 15}, {-15, 15}})
    horseshoe.anchors.push_back(k_outer * glm::normalize(dvec3(x, y, 73)));
  const auto with_hole = [](const dvec3& p) {
    return std::min(Vault::shell(p), 300 + 400 * (std::hypot(p.x, p.y) - 6));
  };
  const struct {
    CutFlap request;
    dvec3 outside;  // bone that stays
  } cases[] = {{Outline(14, 6).request(), dvec3(30, 0, 68)}, {horseshoe, dvec3(0, 0, 74)}};
  for (const auto& one : cases) {
    const bool is_ring = &one == &cases[0];
    SCOPED_TRACE(is_ring ? "ring" : "horseshoe");
    const Vault vault =
        is_ring ? Vault(dvec3(0.9), 6.5, with_hole, 24) : Vault(dvec3(0.9), 6.5, Vault::shell, 24);
    sim::Lockstep run = vault.run();
    ASSERT_EQ(cut(run, one.request), "");
    ASSERT_EQ(run.engine().state().undoable.bodies.size(), 1u);
    const auto voxel = volume::voxel_of(vault.scene.base->frame.volume_from_world(one.outside));
    EXPECT_TRUE(run.engine().version()->is_kept(voxel));
    const dvec3 removed = is_ring ? dvec3(10, 0, 73) : dvec3(12, 0, 72.5);
    EXPECT_FALSE(run.engine().version()->is_kept(
        volume::voxel_of(vault.scene.base->frame.volume_from_world(removed))));
  }
}

TEST(BoneFlap, FlapKerfAndRestAddUpToTheOriginalBone) {
  const Outline outline(8, 5);
  const Vault vault(dvec3(0.9), 8.2, Vault::shell, 20);
  sim::Lockstep run = vault.run();
  ASSERT_EQ(cut(run, outline.request(Saw::w2_4)), "");
  const volume::Version& left = *run.engine().version();
  const auto pyramid = make_pyramid(outline.anchors, outline.height, vault.scene.items[0].field);
  ASSERT_TRUE(pyramid);
  CutSurface sheet;
  ASSERT_FALSE(sheet.make(pyramid.value(), vault.scene.items[0].field, 2.4, {}));
  const Points points = count_points(vault, left, sheet, 2.4);
  const std::int64_t removed = left.ledger().units_by_label[0], freed = left.ledger().detached_units;
  EXPECT_GT(removed, 0);
  EXPECT_GT(freed, 0);
  // The sum is exact, in whole points. The division into kerf and flap is approximate, because distances are
  // interpolated at the edge of the kerf.
  EXPECT_EQ(points.before, removed + freed + points.rest);
  EXPECT_EQ(points.elsewhere, 0);
  EXPECT_NEAR(static_cast<double>(points.kerf) / static_cast<double>(removed), 1, 0.005);
  EXPECT_NEAR(static_cast<double>(points.flap) / static_cast<double>(freed), 1, 0.01);
}

/// A cut of the voxels on single lines from the apex leaves holes. Lines farther apart leave more of them.
TEST(BoneFlap, VoxelsOnLinesLeaveHoles) {
  const Outline outline(10, 5);
  const Vault vault(dvec3(0.45), 6.5, Vault::shell, 22);
  const volume::Field& bone = vault.scene.items[0].field;
  const auto pyramid = make_pyramid(outline.anchors, outline.height, bone);
  ASSERT_TRUE(pyramid);
  CutSurface sheet;
  ASSERT_FALSE(sheet.make(pyramid.value(), bone, 1.6, {}));
  const auto uncut = haptics::uncut_version(vault.scene);
  Kerf kerf(sheet, *uncut);
  const auto holes_after = [&](volume::RemovalField& field, const volume::VoxelBox& samples) {
    volume::RemovalEditor editor(uncut, {bone});
    editor.remove(field, samples);
    return kerf.count_holes(bone, *editor.freeze());
  };
  const std::int64_t initial_holes = kerf.count_holes(bone, *uncut);
  EXPECT_GT(initial_holes, 10000);  // every path through the bone is a hole
  EXPECT_EQ(holes_after(kerf, kerf.samples()), 0);
  TracedVoxels dense(sheet, *uncut, 0.2), sparse(sheet, *uncut, 1.5);
  const std::int64_t of_dense = holes_after(dense, dense.samples()),
                     of_sparse = holes_after(sparse, sparse.samples());
  EXPECT_GT(of_dense, 0);
  EXPECT_GT(of_sparse, 3 * of_dense);
  EXPECT_LT(of_sparse, initial_holes);
  // A saw narrower than the step between samples is refused, since it leaves holes too.
  CutSurface narrow;
  ASSERT_FALSE(narrow.make(pyramid.value(), bone, 0.3, {}));
  Kerf thin(narrow, *uncut);
  EXPECT_GT(holes_after(thin, thin.samples()), 0);
  const Vault coarse(dvec3(0.9), 0, Vault::shell, 22);
  sim::Lockstep run = coarse.run();
  EXPECT_NE(cut(run, outline.request(Saw::w1_2)).find("too narrow"), std::string::npos);
}

/// A label of bone joins the two tables of a skull with a wide diploe that is darker than the threshold.
TEST(BoneFlap, ALabelJoinsTablesAcrossWideDiploe) {
  const auto hollow = [](const dvec3& p) {
    const double r = glm::length(p), table = std::max(std::min(r - k_inner, k_inner + 1 - r),
                                                      std::min(r - (k_outer - 1), k_outer - r));
    return 300 + 400 * table;
  };
  volume::Volume scan = scenes::sampled({-30, -30, 55}, {30, 30, 80}, dvec3(0.5), hollow);
  const Outline outline(10, 6);
  const auto inner_of = [&](const volume::Volume& of) {
    const volume::Field bone(of, {"bone", 300});
    const Pyramid pyramid = make_pyramid(outline.anchors, outline.height, bone).value();
    CutSurface sheet;
    SawLimits limits;
    EXPECT_FALSE(sheet.make(pyramid, bone, 1.6, limits));
    double least = 1e300, most = 0;
    for (const CutSurface::Line& line : sheet.lines()) {
      const double r = glm::length(sheet.point_at(line, line.inner));
      least = std::min(least, r), most = std::max(most, r);
    }
    return glm::dvec2(least, most);
  };
  const glm::dvec2 without = inner_of(scan);
  EXPECT_GT(without.x, k_outer - 1.2);
  scan.labels = Buffer<std::uint8_t>(scan.voxels.size());
  scan.label_names = {"", "skull"};
  for (int z = 0; z < scan.size.z; ++z)
    for (int y = 0; y < scan.size.y; ++y)
      for (int x = 0; x < scan.size.x; ++x) {
        const double r = glm::length(scan.frame.world_from_volume({x, y, z}));
        scan.labels[scan.index(x, y, z)] = r >= k_inner && r <= k_outer ? 1 : 0;
      }
  const glm::dvec2 labelled = inner_of(scan);
  EXPECT_NEAR(labelled.x, k_inner, 0.1);
  EXPECT_NEAR(labelled.y, k_inner, 0.1);
  scan.label_names = {"", "brain"};
  EXPECT_GT(inner_of(scan).x, k_outer - 1.2) << "a label that does not name bone joins no tables";
}

/// A refusal states its reason and location, and changes nothing.
TEST(BoneFlap, ReportsReasonAndLocationOfInvalidOutlinesAndCutsNothing) {
  const Outline outline(10, 6);
  struct Case {
    const char* words;
    CutFlap request;
    Vault::Hounsfield hounsfield;
    dvec3 place;
    double reach;  ///< mm, largest distance of the reported location from `place`
  };
  std::vector<Case> cases;
  const auto add = [&](const char* words, const dvec3& place, double reach, auto&& change,
                       const Vault::Hounsfield& hounsfield = Vault::shell) {
    cases.push_back({words, outline.request(), hounsfield, place, reach});
    change(cases.back().request);
  };
  const auto no_change = [](CutFlap&) {};
  const auto& a = outline.anchors;
  add("it has 2 anchors", a[0], 1, [](CutFlap& w) { w.anchors.resize(2); });
  add("the outline is open: its ends are", 0.5 * (a[0] + a[5]), 14, [&](CutFlap& w) {
    w.anchors.clear();
    for (int i = 0; i < 12; ++i) w.anchors.push_back(Outline(10, 24).anchors[static_cast<std::size_t>(i)]);
  });
  add("crosses itself", a[2], 20, [](CutFlap& w) { std::swap(w.anchors[1], w.anchors[3]); });
  add("are less than 1 mm apart", a[1], 1, [](CutFlap& w) { w.anchors[2] = w.anchors[1]; });
  add("anchor 3 lies off the bone", 1.2 * a[2], 1, [](CutFlap& w) { w.anchors[2] *= 1.2; });
  add(
      "anchor 2 lies level with the apex or behind it", dvec3(0, 0, 45.5), 1,
      [](CutFlap& w) {
        w.distance = 20;
        w.anchors[1] = dvec3(0, 0, 45.5);
      },
      [](const dvec3& p) {
        return std::max(Vault::shell(p), 300 + 400 * (2 - glm::length(p - dvec3(0, 0, 45.5))));
      });
  // The bone has a hole of 8 mm between the first and the second anchor.
  const dvec3 between = k_outer * glm::normalize(a[0] + a[1]);
  const auto distance_off_line = [between](const dvec3& p) {
    return glm::length(p - glm::dot(p, between) / glm::dot(between, between) * between);
  };
  add("goes through a hole of 8 mm in the bone between anchors 1 and 2", between, 2, no_change,
      [=](const dvec3& p) { return std::min(Vault::shell(p), 300 + 400 * (distance_off_line(p) - 4)); });
  add(
      "the outline leaves the scan", dvec3(0, 0, 82), 20,
      [](CutFlap& w) {
        for (dvec3& anchor : w.anchors) anchor *= 1.12;
      },
      [](const dvec3& p) { return Vault::shell(p / 1.12); });  // top of the skull: beyond the last slice
  // A head of solid bone is thicker than a calvaria. In the case after that, a post and a beam below the flap
  // keep it connected with the bone outside.
  add("is thicker than 25 mm", between, 30, no_change,
      [](const dvec3& p) { return 300 + 400 * (k_outer - glm::length(p)); });
  add("deeper than the saw went", dvec3(0, 0, 58), 30, no_change, [](const dvec3& p) {
    const bool is_post = p.z > 55 && std::abs(p.x) < 3 && std::abs(p.y) < 3;
    const bool is_beam = p.z > 52 && p.z < 58 && std::abs(p.y) < 3 && p.x > -3 && p.x < 22;
    const bool is_second = p.z > 55 && p.x > 17 && p.x < 22 && std::abs(p.y) < 3;
    return glm::length(p) < k_inner + 1 && (is_post || is_beam || is_second) ? 1500.0 : Vault::shell(p);
  });
  add("there is no bone at the position on the flap", dvec3(0, 0, 60), 1,
      [](CutFlap& w) { w.seed = {dvec3(0, 0, 60)}; });
  add("the position on the flap lies outside", dvec3(18, 0, 72.4), 1,
      [](CutFlap& w) { w.seed = {dvec3(18, 0, 72.4)}; });
  add("piece 2 does not exist: number of pieces: 1", dvec3(0, 0, 74), 5, [](CutFlap& w) { w.leave = {{2}}; });
  add("encloses almost no area", dvec3(0, 0, 74), 20, [&](CutFlap& w) {
    w.anchors = {a[0], 0.5 * (a[0] + a[1]) * dvec3(0.9, 0.9, 1), a[1]};
  });
  add("reverses its direction at anchor 2", a[1], 1, [&](CutFlap& w) {
    w.anchors = {a[0], a[1], 0.5 * (a[0] + a[1]), a[3], a[4]};
  });
  add("the request leaves all pieces in place", dvec3(0, 0, 74), 5, [](CutFlap& w) { w.leave = {{1}}; });
  for (const Case& one : cases) {
    SCOPED_TRACE(one.words);
    const Vault vault(dvec3(0.9), 6.5, one.hounsfield, 24);
    sim::Lockstep run = vault.run();
    const std::uint64_t before = run.engine().version()->content_hash();
    EXPECT_NE(cut(run, one.request).find(one.words), std::string::npos) << cut(run, one.request);
    const auto refusals = events_of<FlapFailed>(run.engine());
    ASSERT_FALSE(refusals.empty());
    EXPECT_LT(glm::length(refusals[0].second - one.place), one.reach);
    EXPECT_EQ(run.engine().version()->content_hash(), before);
    EXPECT_TRUE(run.engine().state().undoable.bodies.empty());
    EXPECT_FALSE(run.engine().can_undo());
    // A warning shows the error.
    bool is_shown = false;
    for (const sim::Overlay& overlay : run.engine().overlays())
      is_shown = is_shown || (overlay.kind == sim::Overlay::Kind::warning && !overlay.labels.empty());
    EXPECT_TRUE(is_shown);
  }
}

TEST(BoneFlap, PiecesAreNamedDetachedOrKeptAndRestored) {
  // A seam of 1.8 mm crosses the vault at x = 3 mm, to one side of the flap's centre.
  const Vault vault(
      dvec3(0.9), 6.5,
      [](const dvec3& p) { return std::min(Vault::shell(p), 300 + 400 * (std::abs(p.x - 3) - 0.5 - 0.4)); },
      24);
  const Outline outline(11, 6);
  sim::Lockstep run = vault.run();
  const std::uint64_t before = run.engine().version()->content_hash();
  CutFlap request = outline.request();
  request.leave = {{2}};
  ASSERT_EQ(cut(run, request), "");
  auto pieces = events_of<FlapPiece>(run.engine());
  ASSERT_EQ(pieces.size(), 2u);
  EXPECT_GT(pieces[0].first.size, 1.3 * pieces[1].first.size);
  EXPECT_LT(pieces[0].second.x, 3);
  EXPECT_GT(pieces[1].second.x, 3);
  EXPECT_TRUE(pieces[0].first.is_detached && pieces[0].first.is_seed && !pieces[0].first.is_at_border);
  EXPECT_FALSE(pieces[1].first.is_detached);
  ASSERT_EQ(run.engine().state().undoable.bodies.size(), 1u);
  // The version still has the matter of the kept piece, but not that of the detached piece.
  const volume::Version& left = *run.engine().version();
  const auto is_kept = [&](const dvec3& p) {
    return left.distance(vault.scene.base->frame.volume_from_world(p)) > 0;
  };
  EXPECT_FALSE(is_kept(pieces[0].second));
  EXPECT_TRUE(is_kept(pieces[1].second));

  // PlaceBody, which can be undone, lifts the body. Without a position it returns the body to its pose at the
  // detachment.
  const sim::Id body = run.engine().state().undoable.bodies[0].id;
  EXPECT_FALSE(run.apply({sim::PlaceBody{body, dvec3(0, 0, 40)}, 0}).refused);
  EXPECT_EQ(run.engine().state().undoable.bodies[0].placement.position_world, dvec3(0, 0, 40));
  EXPECT_FALSE(run.apply({sim::PlaceBody{body}, 0}).refused);
  EXPECT_EQ(run.engine().state().undoable.bodies[0].placement, haptics::Placement{});
  EXPECT_TRUE(run.apply({sim::PlaceBody{{99}}, 0}).refused);
  EXPECT_TRUE(run.apply({sim::PlaceBody{body, dvec3(0), {2, 0, 0, 0}}, 0}).refused);
  run.undo();
  EXPECT_EQ(run.engine().state().undoable.bodies[0].placement.position_world, dvec3(0, 0, 40));
  run.undo();
  EXPECT_EQ(run.engine().state().undoable.bodies[0].placement, haptics::Placement{});
  EXPECT_EQ(run.engine().state().undoable_of<FlapState>()->flaps, 1);
  run.undo();
  EXPECT_TRUE(run.engine().state().undoable.bodies.empty());
  EXPECT_EQ(run.engine().state().undoable_of<FlapState>()->flaps, 0);
  EXPECT_EQ(run.engine().version()->content_hash(), before);
  // A request without `leave` detaches both pieces.
  request.leave.clear();
  ASSERT_EQ(cut(run, request), "");
  EXPECT_EQ(run.engine().state().undoable.bodies.size(), 2u);
}

TEST(BoneFlap, AnOutlineIsDrawnAnchorByAnchor) {
  const Vault vault(dvec3(0.9), 6.5, Vault::shell, 22);
  const Outline outline(10, 5);
  sim::Lockstep run = vault.run();
  const auto drawn = [&] { return run.engine().state().persistent_of<FlapSettings>()->anchors; };
  const auto refused = [&](const sim::Command& command, const char* words) {
    const sim::Outcome outcome = run.apply(command);
    return outcome.refused && outcome.refused->what.find(words) != std::string::npos;
  };
  EXPECT_TRUE(refused(MoveAnchor{1, dvec3(0)}, "unknown anchor"));
  EXPECT_TRUE(refused(RemoveAnchor{}, "unknown anchor"));
  for (const dvec3& at : outline.anchors) EXPECT_FALSE(run.apply({AddAnchor{at}, 0}).refused);
  EXPECT_EQ(drawn(), outline.anchors);
  EXPECT_TRUE(refused({AddAnchor{outline.anchors[1] + dvec3(0.3, 0, 0)}, 0}, "less than 1 mm from anchor 2"));
  EXPECT_EQ(drawn(), outline.anchors);
  EXPECT_FALSE(run.apply({AddAnchor{dvec3(0, 0, 40)}, 0}).refused);
  EXPECT_FALSE(run.apply({RemoveAnchor{}, 0}).refused);
  EXPECT_FALSE(run.apply({MoveAnchor{2, 2.0 * outline.anchors[1]}, 0}).refused);
  EXPECT_TRUE(refused(MoveAnchor{6, dvec3(0)}, "unknown anchor"));
  EXPECT_FALSE(run.engine().can_undo());
  // Anchors have numbers. An error is reported, and the anchor can then be corrected.
  ASSERT_FALSE(run.engine().overlays().empty());
  EXPECT_EQ(run.engine().overlays()[0].labels.size(), 5u);
  CutFlap no_shape = outline.request();
  no_shape.item = 1;
  EXPECT_TRUE(refused(no_shape, "unknown shape"));
  CutFlap request = outline.request();
  request.anchors.clear();
  EXPECT_NE(cut(run, request).find("anchor 2 lies off the bone"), std::string::npos);
  EXPECT_EQ(drawn().size(), 5u);
  EXPECT_FALSE(run.apply({MoveAnchor{2, outline.anchors[1]}, 0}).refused);
  EXPECT_EQ(cut(run, request), "");
  // The outline is kept for another attempt after an undo. The anchors of a request do not change it.
  EXPECT_EQ(drawn(), outline.anchors);
  run.undo();
  EXPECT_EQ(cut(run, request), "");
  run.undo();
  CutFlap other = outline.request();
  other.anchors.resize(2);
  EXPECT_NE(cut(run, other), "");
  EXPECT_EQ(drawn(), outline.anchors);
  EXPECT_EQ(cut(run, request), "");
  sim::Lockstep whole_run = vault.run();
  EXPECT_EQ(cut(whole_run, outline.request()), "");
  EXPECT_EQ(run.engine().version()->content_hash(), whole_run.engine().version()->content_hash());
  EXPECT_FALSE(run.apply({AddAnchor{dvec3(0, 0, 40)}, 0}).refused);
  EXPECT_FALSE(run.apply({ClearAnchors{}, 0}).refused);
  EXPECT_TRUE(drawn().empty());
}

/// Smoothing rounds the edges of the rim as a Gaussian rounds a right angle. Walls and the surface of the
/// skull stay as they are.
TEST(BoneFlap, ARimIsSmoothedAtItsEdges) {
  const Outline outline(10, 6);
  const Vault vault(dvec3(0.45), 6.5, Vault::shell, 22);
  CutFlap request = outline.request();
  sim::Lockstep sharp = vault.run(), smooth = vault.run();
  ASSERT_EQ(cut(sharp, request), "");
  request.smoothing = 0.8;
  ASSERT_EQ(cut(smooth, request), "");
  const FlapCut one = events_of<FlapCut>(sharp.engine())[0].first,
                other = events_of<FlapCut>(smooth.engine())[0].first;
  EXPECT_EQ(one.rim_size, 0);
  EXPECT_EQ(one.kerf_size, other.kerf_size);
  // The expected volume is the area that is removed from a right angle, times the length of both edges. Let x
  // and y be the distances from the two sides of the angle, P the normal distribution, and the smoothing the
  // unit of length. A point is removed if (P(x) P(y) - 1/2) sqrt(2 pi) is below minus the spared margin.
  const double spared =
      Rim::spared(request.smoothing, sharp.engine().version()->lattice()) / request.smoothing;
  const auto normal = [](double x) { return 0.5 * std::erfc(-x / std::sqrt(2.0)); };
  double share = 0;
  constexpr double k_step = 0.005;
  for (double x = 0.5 * k_step; x < 2; x += k_step)
    for (double y = 0.5 * k_step; y < 2; y += k_step)
      share += k_step * k_step * ((normal(x) * normal(y) - 0.5) * std::sqrt(2 * k_pi) < -spared);
  const double edges = outline.count * outline.side_angle() * (k_outer + k_inner);
  EXPECT_NEAR(other.rim_size / (share * request.smoothing * request.smoothing * edges), 1, 0.2);
  // The surface is unchanged in the middle of a wall, and more than 3 mm off the rim.
  const dvec3 over = glm::normalize(outline.anchors[0] + outline.anchors[1]),
              aside = glm::normalize(over - dvec3(0, 0, glm::dot(over, dvec3(0, 0, 1))));
  const auto solid = [&](const sim::Lockstep& run, const dvec3& p) {
    const dvec3 at = vault.scene.base->frame.volume_from_world(p);
    return run.engine().version()->distance(at) > 0 && vault.scene.items[0].field.value(at) >= 0;
  };
  const dvec3 wall = 72.0 * over, edge = k_outer * over;
  for (double off = 0; off < 4; off += 0.02) {
    EXPECT_EQ(solid(smooth, wall + off * aside), solid(sharp, wall + off * aside)) << off;
    EXPECT_TRUE(off <= 3 || solid(smooth, edge + off * aside) == solid(sharp, edge + off * aside)) << off;
  }
  // Soft tissue below the kerf stays: the saw ends 1.05 mm below the inner table, and the rim 1.5 samples
  // below the inner table.
  const auto is_kept = [&](const sim::Lockstep& run, double r) {
    return run.engine().version()->distance(vault.scene.base->frame.volume_from_world(r * over)) > 0;
  };
  for (double deep = 1.6; deep < 4; deep += 0.1) {
    EXPECT_TRUE(is_kept(sharp, k_inner - deep)) << deep;
    EXPECT_TRUE(is_kept(smooth, k_inner - deep)) << deep;
  }
}

}  // namespace
}  // namespace trephine::bone_flap
