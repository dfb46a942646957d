// Forbidden structures of a scan: distances, watches, events and sessions.
#include "sim/api/forbidden.h"

#include <glm/gtc/quaternion.hpp>
#include <random>

#include "tests/sim/session_fixture.h"

namespace trephine::sim {
namespace {

// Compares the distance to a ball of known radius with the exact one, outside and inside, for every frame,
// slice spacing, unit and mask.
TEST(Forbidden, TheDistanceIsRightToHalfAVoxel) {
  for (const scenes::Scan& scan : scenes::k_scans) {
    SCOPED_TRACE(scan.name());
    const haptics::TouchScene scene = scenes::scan_scene(scan, false);
    const auto forbidden = Forbidden::build(scene.base, scene.items[0].field.shape());
    ASSERT_TRUE(forbidden.is_ok()) << forbidden.error().message();
    const dvec3& spacing = scene.base->frame.spacing();
    const double half = 0.5 * std::max({spacing.x, spacing.y, spacing.z});
    std::mt19937 random(5);
    std::uniform_real_distribution<double> share(-1, 1);
    double worst = 0;
    int inside = 0, compared = 0;
    for (int i = 0; i < 400; ++i) {
      const double x = share(random), y = share(random), z = share(random);
      const double r = 4 * std::abs(share(random)) * scan.unit, away = 19 * share(random);
      const dvec3 p =
          glm::normalize(dvec3(x, y, z)) * (45 * scan.unit + (scan.unit > 1 ? away : away * scan.unit));
      const double exact = glm::length(p) - 45 * scan.unit;
      const double found = forbidden.value()->clearance({p, r}, share(random) * 20) + r;
      inside += found < 0;
      if (std::abs(exact) > Forbidden::k_reach) continue;  // beyond its reach, where distances are clamped
      worst = std::max(worst, std::abs(found - exact));
      ++compared;
    }
    EXPECT_LT(worst, half);
    EXPECT_GT(inside, 100);
    EXPECT_GT(compared, 350);
    std::printf("%s: %.3f of %.3f\n", scan.name().c_str(), worst, half);
  }
}

/// A plane of bone, with a forbidden label below z = k_bottom.
struct Guarded {
  haptics::TouchScene scene;
  std::unique_ptr<haptics::ProxyMethod> method = haptics::make_method("subvoxel").value();
  std::shared_ptr<const Forbidden> forbidden;
  static constexpr double k_bottom = -4;  // mm: below this everything is forbidden
  Guarded() {
    data_tools::PhantomOptions o;
    o.size = glm::ivec3(48);
    o.spacing_mm = dvec3(0.5);
    o.psf_sigma_voxels = 1;
    o.parameters = {{"angle", 0}};
    scene = scenes::phantom_scene("plane", o);
    auto marked = std::make_shared<volume::Volume>(
        volume::make_volume(scene.base->size, scene.base->frame, true).value());
    std::copy(scene.base->voxels.span().begin(), scene.base->voxels.span().end(), marked->voxels.data());
    marked->label_names = {"nothing", "dura"};
    for (int z = 0; z < 48; ++z)
      for (int y = 0; y < 48; ++y)
        for (int x = 0; x < 48; ++x)
          marked->labels[marked->index(x, y, z)] = marked->frame.world_from_volume({x, y, z}).z < k_bottom;
    volume::Shape dura;
    dura.label = 1;
    dura.name = "dura";
    forbidden = Forbidden::build(marked, dura).value();
    EXPECT_FALSE(method->prepare(scene));
  }
  Engine engine(const drilling::Burr& burr, bool is_watched = true) const {
    return Engine({{haptics::ServoHand(haptics::borrowed(scene), haptics::borrowed(*method),
                                       haptics::TouchState(nullptr)),
                    drilling::burr(burr)}},
                  1e-3, drilling_catalogue(),
                  is_watched ? std::vector{forbidden} : std::vector<std::shared_ptr<const Forbidden>>{});
  }
};

std::vector<const Event*> all_events(const Engine& engine) {
  std::vector<const Event*> found;
  for (std::size_t i = 0; i < engine.state().chronicle.size(); ++i)
    found.push_back(&engine.state().chronicle[i]);
  return found;
}

// A burr moves down into the structure and up again. Its events have the correct time, position and depth.
TEST(Forbidden, EntriesAreReportedWithDepthTimeAndPosition) {
  const Guarded guarded;
  Lockstep run(guarded.engine({3, 1e4, 400, true}), {}, 1000);
  const auto z_at = [](int tick) { return tick < 1000 ? 5 - 0.009 * tick : -4 + 0.009 * (tick - 1000); };
  double nearest = 1e9;
  int first = -1, last = -1;
  for (int i = 0; i < 2000; ++i) {
    const double z = z_at(i), exact = z - 1.5 - Guarded::k_bottom;
    run.step({{0.3, -0.2, z}, {1, 0, 0, 0}, true});
    const double clearance = run.engine().clearance(0, 0), watched = run.engine().watch(0, 0).clearance;
    ASSERT_NEAR(clearance, exact, 0.25) << i;
    ASSERT_LE(watched, clearance + 1e-9) << i;
    if (clearance <= Forbidden::k_always_measured) {
      ASSERT_EQ(watched, clearance) << i;
    }
    nearest = std::min(nearest, exact);
    if (exact < 0) {
      if (first < 0) first = i;
      last = i;
    }
  }
  const auto events = all_events(run.engine());
  ASSERT_EQ(events.size(), 3u);
  const auto* entered = events[0]->value.as<ForbiddenEntered>();
  const auto* torn = events[1]->value.as<StructureTorn>();
  const auto* left = events[2]->value.as<ForbiddenLeft>();
  ASSERT_TRUE(entered && torn && left);
  EXPECT_NEAR(torn->deepest, k_tear_depth, 0.05);
  EXPECT_NEAR(static_cast<double>(events[1]->tick - events[0]->tick), 1000 * k_tear_depth / 9, 12);
  EXPECT_EQ(entered->structure, "dura");
  EXPECT_TRUE(entered->is_working);
  EXPECT_NEAR(static_cast<double>(events[0]->tick), first, 30);  // a quarter of a mm
  EXPECT_NEAR(events[0]->position_world.z, Guarded::k_bottom + 1.5, 0.26);
  EXPECT_NEAR(left->deepest, -nearest, 0.25);
  EXPECT_NEAR(events[2]->position_world.z, -4, 0.1) << "the deepest position, not that of leaving";
  EXPECT_TRUE(guarded.forbidden->contains({0.3, -0.2, Guarded::k_bottom - 0.5}));
  EXPECT_FALSE(guarded.forbidden->contains({0.3, -0.2, Guarded::k_bottom + 0.5}));
  EXPECT_NEAR(left->seconds, 1e-3 * (last - first), 0.06);
  // A mark shows the tear where the tool entered the dura.
  const Overlays overlays = run.engine().overlays();
  const auto injury = std::find_if(overlays.begin(), overlays.end(), [](const Overlay& overlay) {
    return overlay.kind == Overlay::Kind::injury;
  });
  ASSERT_NE(injury, overlays.end());
  EXPECT_EQ(injury->name, "tear of the dura");
  EXPECT_TRUE(injury->surface);
  EXPECT_LT(glm::length(injury->placement.position_world - dvec3(0.3, -0.2, Guarded::k_bottom)), 0.3);
  // Events are not undoable.
  run.undo();
  EXPECT_EQ(run.engine().state().chronicle.size(), 3u);
  EXPECT_EQ(run.engine().watch(0, 0).entries, 1);
}

// Far from the structure the watch measures only after some motion; its smallest clearance is exact.
TEST(Forbidden, AFarToolIsMeasuredAfterMotionOnly) {
  const Guarded guarded;
  Lockstep run(guarded.engine({.diameter = 3}), {}, 1000);
  double nearest = Forbidden::k_reach;
  int measured = 0, count = 0;
  for (int i = 0; i < 20000; ++i) {
    const double t = 1e-3 * i;
    const glm::dvec3 at(3 * std::sin(1.3 * t), 2 * std::cos(0.7 * t),
                        9 + 5 * std::cos(0.9 * t) + 0.2 * std::sin(40 * t) - 0.1 * t);
    run.step({at, {1, 0, 0, 0}, false});
    const ForbiddenWatch& watch = run.engine().watch(0, 0);
    const double exact = run.engine().clearance(0, 0);
    ASSERT_LE(watch.clearance, exact + 1e-9) << i;
    nearest = std::min(nearest, exact);
    ASSERT_EQ(watch.nearest, nearest) << i;
    if (i < 200) continue;  // the first approach
    measured += watch.clearance == watch.measured;
    ++count;
  }
  EXPECT_LT(nearest, 7);
  EXPECT_LT(measured, 0.5 * count);
}

// The ball with which a round burr touches is smaller than the burr.
TEST(Forbidden, ARoundBurrAtRestIsWatchedAtItsOwnSurface) {
  Guarded guarded;
  ASSERT_FALSE(haptics::set_smallest_burr(guarded.scene, 8));
  ASSERT_FALSE(guarded.method->prepare(guarded.scene));
  Lockstep run(guarded.engine({.diameter = 8}), {}, 1000);
  ASSERT_FALSE(run.apply_and_finish(TakeInstrument{"burr", "diameter=8 round=yes"}).refused);
  const double contact = run.engine().tool(0).scene->tool->radius();
  ASSERT_GT(contact, 2);
  ASSERT_LT(contact, 4 - 0.3);
  haptics::ServoRecord record;
  for (int i = 0; i < 2000; ++i)
    record = run.step({{0.3, -0.2, std::max(3.0, 10 - 0.005 * i)}, {1, 0, 0, 0}, false});
  ASSERT_TRUE(record.has_contact);
  const double face = record.proxy_world.z - contact;
  EXPECT_NEAR(run.engine().watch(0, 0).clearance, face - Guarded::k_bottom, 0.25);
}

// A structure is stripped, touched or torn, depending on the depth of the visit and on whether the tool
// worked.
TEST(Forbidden, EventsReportWhatAVisitDid) {
  Guarded guarded;
  // A forbidden region in the air: everything more than 4 mm above the bone. The tool enters it from below.
  auto above = std::make_shared<volume::Volume>(
      volume::make_volume(guarded.scene.base->size, guarded.scene.base->frame, true).value());
  above->label_names = {"nothing", "dura"};
  std::fill(above->voxels.span().begin(), above->voxels.span().end(), std::int16_t{0});
  double edge = 1e9;
  for (int z = 0; z < above->size.z; ++z)
    for (int y = 0; y < above->size.y; ++y)
      for (int x = 0; x < above->size.x; ++x) {
        const double height = above->frame.world_from_volume({x, y, z}).z;
        const bool is_in = height > 4;
        above->labels[above->index(x, y, z)] = is_in;
        if (is_in) edge = std::min(edge, height - 0.5 * above->frame.spacing().z);
      }
  volume::Shape dura;
  dura.label = 1;
  dura.name = "dura";
  guarded.forbidden = Forbidden::build(above, dura).value();
  const struct {
    double deep;
    bool is_pressed;
    std::string_view event;
  } visits[] = {{0.3, true, "structure-touched"},
                {0.3, false, "structure-stripped"},
                {2.5, false, "structure-stripped"},
                {1.0, true, "structure-torn"},
                {3.3, false, "structure-torn"}};
  for (const auto& visit : visits) {
    Lockstep run(guarded.engine({1, 1e4, 400, true}), {}, 1000);
    constexpr double k_out = 1.5, k_radius = 0.5;
    for (int i = -1000; i <= 1000; ++i) {
      const double way = (k_out + visit.deep) * (1 - std::abs(i) / 1000.0);
      run.step({{0, 0, edge - k_radius - k_out + way}, {1, 0, 0, 0}, visit.is_pressed});
    }
    std::vector<std::string_view> events;
    const Chronicle& all = run.engine().state().chronicle;
    for (std::size_t i = 0; i < all.size(); ++i)
      if (all[i].value.name().starts_with("structure-")) events.push_back(all[i].value.name());
    ASSERT_EQ(events.size(), 1u) << visit.deep << visit.is_pressed;
    EXPECT_EQ(events[0], visit.event) << visit.deep << visit.is_pressed;
  }
  // A tool that trembles at the surface makes one visit, until it moves away.
  Lockstep run(guarded.engine({1, 1e4, 400, true}), {}, 1000);
  int contacts = 0;
  for (int i = 0; i < 2000; ++i) {
    const double out = i < 1000 ? 0.05 * std::sin(0.4 * i) : 1e-3 * (i - 1000);  // mm from the surface
    run.step({{0, 0, edge - 0.5 - out}, {1, 0, 0, 0}, true});
    contacts += i > 0 && i < 1000 && out < 0 && std::sin(0.4 * (i - 1)) >= 0;
  }
  EXPECT_GT(contacts, 50);
  EXPECT_EQ(run.engine().watch(0, 0).entries, 1);
  EXPECT_FALSE(run.engine().watch(0, 0).is_inside);
}

/// The brain behind an intact dura yields to a tool that does not cut. A tool that cuts, or that tears the
/// dura, enters the brain.
TEST(Forbidden, AnIntactDuraCarriesTheBrainBehindIt) {
  const Guarded guarded;
  auto layers = std::make_shared<volume::Volume>(
      volume::make_volume(guarded.scene.base->size, guarded.scene.base->frame, true).value());
  layers->label_names = {"nothing", "dura", "brain"};
  std::fill(layers->voxels.span().begin(), layers->voxels.span().end(), std::int16_t{0});
  constexpr double k_dura = 4,
                   k_brain = 4.5;  // mm, heights of the lower faces, half a voxel below the first centres
  for (int z = 0; z < layers->size.z; ++z)
    for (int y = 0; y < layers->size.y; ++y)
      for (int x = 0; x < layers->size.x; ++x) {
        const double height = layers->frame.world_from_volume({x, y, z}).z;
        layers->labels[layers->index(x, y, z)] = height > k_brain ? 2 : height > k_dura ? 1 : 0;
      }
  std::vector<std::shared_ptr<const Forbidden>> structures;
  for (const int label : {2, 1}) {  // the brain comes first: the order must not matter
    volume::Shape shape;
    shape.label = label;
    shape.name = label == 1 ? "dura" : "brain";
    structures.push_back(Forbidden::build(layers, shape).value());
  }
  const struct {
    double up;  ///< mm, height of the ball's upper end
    bool is_pressed, is_in_brain;
  } visits[] = {{6, false, false}, {6, true, true}, {8.5, false, true}};
  for (const auto& visit : visits) {
    Engine engine({{haptics::ServoHand(haptics::borrowed(guarded.scene), haptics::borrowed(*guarded.method),
                                       haptics::TouchState(nullptr)),
                    drilling::burr({4, 1e4, 400, true})}},
                  1e-3, drilling_catalogue(), structures);
    Lockstep run(std::move(engine), {}, 1000);
    constexpr double k_radius = 2;
    for (int i = 0; i <= 1000; ++i)
      run.step({{0, 0, 2 - k_radius + (visit.up - 2) * i / 1000.0}, {1, 0, 0, 0}, visit.is_pressed});
    SCOPED_TRACE(visit.up);
    EXPECT_EQ(run.engine().watch(0, 1).entries, 1) << "dura";
    EXPECT_EQ(run.engine().watch(0, 1).is_torn, visit.is_in_brain);
    EXPECT_EQ(run.engine().watch(0, 0).entries, visit.is_in_brain ? 1 : 0);
    EXPECT_EQ(run.engine().watch(0, 0).nearest >= 0, !visit.is_in_brain);
  }
  // A ball that is smaller than its depth lies behind the dura, which it still pushes: it slides, and comes
  // out at another place. This is one visit without a tear, and no entry into the brain.
  Engine engine({{haptics::ServoHand(haptics::borrowed(guarded.scene), haptics::borrowed(*guarded.method),
                                     haptics::TouchState(nullptr)),
                  drilling::burr({1.5, 1e4, 400, true})}},
                1e-3, drilling_catalogue(), structures);
  Lockstep run(std::move(engine), {}, 1000);
  const dvec3 turns[] = {{-4, 0, 1}, {-4, 0, 5.6}, {4, 0, 5.6}, {4, 0, 1}};  // centres of the ball
  for (int leg = 0; leg < 3; ++leg)
    for (int i = 0; i < 1000; ++i)
      run.step({glm::mix(turns[leg], turns[leg + 1], i / 999.0), {1, 0, 0, 0}, false});
  EXPECT_EQ(run.engine().watch(0, 1).entries, 1);
  EXPECT_FALSE(run.engine().watch(0, 1).is_torn);
  EXPECT_FALSE(run.engine().watch(0, 1).is_inside) << "it came out";
  EXPECT_EQ(run.engine().watch(0, 0).entries, 0);
  int stripped = 0;
  for (const Event* event : all_events(run.engine())) stripped += event->value.name() == "structure-stripped";
  EXPECT_EQ(stripped, 1);
}

// A tool crosses a brain of radius 9 mm, through its centre and off it, or slides just below its surface:
// depth is measured to the side on which the tool entered.
TEST(Forbidden, DepthIsMeasuredAlongThePathIn) {
  constexpr double k_radius = 9;
  for (const double spacing : {0.4, 1.0})
    for (const double offset : {0.0, 2.5}) {
      SCOPED_TRACE(std::to_string(spacing) + " " + std::to_string(offset));
      const auto axes = spacing * glm::dmat3(1, 0, 0, 0.2, 1, 0, 0, 0, 1);
      const int n = static_cast<int>(30 / spacing);
      auto scan = std::make_shared<volume::Volume>(
          volume::make_volume(glm::ivec3(n), volume::Frame::from_axes(axes * dvec3(-0.5 * n), axes).value(),
                              true)
              .value());
      scan->label_names = {"nothing", "brain"};
      std::fill(scan->voxels.span().begin(), scan->voxels.span().end(), std::int16_t{0});
      for (int z = 0; z < n; ++z)
        for (int y = 0; y < n; ++y)
          for (int x = 0; x < n; ++x)
            scan->labels[scan->index(x, y, z)] =
                glm::length(scan->frame.world_from_volume({x, y, z})) <= k_radius;
      volume::Shape brain;
      brain.label = 1;
      const auto forbidden = Forbidden::build(scan, brain).value();
      const double half = std::sqrt(k_radius * k_radius - offset * offset), ball = 0.5;
      // The tool enters from above, in steps of the given length, leaves at the far side and moves away.
      for (const double step : {0.03, 0.4, 3.0}) {
        ForbiddenWatch watch;
        dvec3 at(offset, 0, 12);
        watch.clearance = forbidden->begin_path({at, ball}, 0, watch);
        double deepest = 0;
        for (double z = 12; z > -12; z -= step) {
          const dvec3 to(offset, 0, z);
          watch.clearance = forbidden->follow(at, {to, ball}, watch.clearance, watch);
          at = to;
          deepest = std::max(deepest, watch.depth);
          const double exact = half - z + ball;
          if (z > -half + 2 && z < half - 1) {
            ASSERT_NEAR(watch.depth, exact, 0.2 * exact + 1.5 * spacing) << z << " by " << step;
          }
        }
        for (int i = 0; i < 2; ++i) {
          const dvec3 to = at - dvec3(0, 0, 3);
          watch.clearance = forbidden->follow(at, {to, ball}, watch.clearance, watch);
          at = to;
        }
        EXPECT_EQ(watch.depth, 0) << "outside again";
        EXPECT_GT(deepest, 1.7 * half) << "not the distance to the far side";
      }
      // The tool slides 1 mm below the surface, almost half around the brain.
      ForbiddenWatch watch;
      const auto place = [&](double angle) {
        return (k_radius - 1) * dvec3(std::sin(angle), 0, std::cos(angle));
      };
      watch.clearance = forbidden->begin_path({place(0), ball}, 0, watch);
      for (double angle = 0; angle < 3; angle += 0.02) {
        watch.clearance =
            forbidden->follow(place(angle - 0.02), {place(angle), ball}, watch.clearance, watch);
        ASSERT_NEAR(watch.depth, 1.5, 0.6 * spacing) << angle;
      }
    }
}

// A tool passes through a thin sheet within one tick. The path between the two ticks counts.
TEST(Forbidden, AJumpThroughASheetIsDetected) {
  Guarded guarded;
  auto sheet = std::make_shared<volume::Volume>(
      volume::make_volume(guarded.scene.base->size, guarded.scene.base->frame, true).value());
  sheet->label_names = {"nothing", "nerve"};
  std::fill(sheet->voxels.span().begin(), sheet->voxels.span().end(), std::int16_t{0});
  std::fill(sheet->labels.span().begin(), sheet->labels.span().end(), std::uint8_t{0});
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 48; ++x) sheet->labels[sheet->index(x, y, 24)] = 1;
  volume::Shape nerve;
  nerve.label = 1;
  nerve.name = "nerve";
  guarded.forbidden = Forbidden::build(sheet, nerve).value();
  Lockstep run(guarded.engine({1, 1e4, 1e4, true}), {}, 1000);
  run.step({{0, 0, 6}, {1, 0, 0, 0}, true});
  EXPECT_GT(run.engine().watch(0, 0).clearance, 4);
  run.step({{0, 0, -6}, {1, 0, 0, 0}, true});
  EXPECT_EQ(run.engine().watch(0, 0).entries, 1);
  run.step({{0, 0, -6}, {1, 0, 0, 0}, true});
  EXPECT_EQ(run.engine().state().chronicle.size(), 3u);  // entered, torn and left
}

// Only the path of a tool in the hand counts: not that of a hand without an instrument, and not the attitude
// of the stylus.
TEST(Forbidden, OnlyThePathOfTheToolItselfCounts) {
  const Guarded guarded;  // forbidden below -4; bone below 0
  Lockstep run(guarded.engine({4, 60, 40, true}), {}, 1000);
  const auto go = [&](const dvec3& at) { run.step({at, {1, 0, 0, 0}, false}); };
  go({-6, 0, 5});
  // The hand moves into the forbidden region and out again, without an instrument.
  run.apply(RemoveInstrument{});
  go({0, 0, -9});
  go({6, 0, 5});
  run.apply(drilling::Burr{4, 60, 40, true});
  go({6, 0, 5});
  EXPECT_EQ(run.engine().watch(0, 0).entries, 0);
  // The instrument is removed inside the structure, which ends the visit.
  run.step({{6, 0, -4}, {1, 0, 0, 0}, true});
  EXPECT_EQ(run.engine().watch(0, 0).entries, 1);
  run.apply(RemoveInstrument{});
  go({6, 0, -4});
  EXPECT_FALSE(run.engine().watch(0, 0).is_inside);
  const Chronicle& all = run.engine().state().chronicle;
  EXPECT_TRUE(all[all.size() - 1].value.as<ForbiddenLeft>());
  // A burr that is not kinematic and only touches stays on the surface of the bone, for any attitude of the
  // stylus. A hand that moves up and down enters no structure.
  Lockstep touch(guarded.engine({4, 60, 40}), {}, 1000);
  for (int i = 0; i < 3000; ++i) {
    const double z = 1.5 * std::sin(0.01 * i);
    touch.step({{0, 0, z}, {0, 1, 0, 0}, false});  // upside down
    EXPECT_GT(touch.engine().watch(0, 0).clearance, 3.5) << i;
  }
  EXPECT_EQ(touch.engine().watch(0, 0).entries, 0);
  // A jump of 1.6 km is no entry either.
  touch.step({{9e5, -9e5, 9e5}, {1, 0, 0, 0}, false});
  EXPECT_EQ(touch.engine().watch(0, 0).entries, 0);
}

TEST(Forbidden, SessionsKeepItAndAnUnguardedSceneHasNoCost) {
  const Guarded guarded;
  const Engine without = guarded.engine({3}, false);
  EXPECT_TRUE(without.state().watches.empty());
  EXPECT_TRUE(without.forbidden().empty());

  // A session contains the structure, which is a shape of the session's scan.
  const Folder folder;
  const std::string path = folder.file("guarded.session");
  haptics::TouchScene scene = small_bone();
  StructureSpec structure;
  structure.shape.low = 900;
  structure.shape.name = "dense";
  structure.is_touchable = false;
  structure.is_forbidden = true;
  const auto method = haptics::make_method("subvoxel").value();
  ASSERT_FALSE(method->prepare(scene));
  SessionHeader header(describe_scene(scene, *method, {}, burr_spec()));
  header.structures.push_back(structure);
  std::uint64_t state = 0, events = 0;
  {
    auto start = build_scene(header, data_of(scene), drilling_catalogue());
    ASSERT_TRUE(start.is_ok()) << start.error().message();
    ASSERT_EQ(start.value().forbidden.size(), 1u);
    EXPECT_EQ(start.value().hands[0].touch.scene->items.size(), 1u);
    auto writer = SessionWriter::create(path, header, data_of(scene), drilling_catalogue()).value();
    Lockstep run(Engine(std::move(start.value().hands), 1e-3, drilling_catalogue(),
                        std::move(start.value().forbidden)),
                 {}, 1000, writer.get());
    const haptics::PosePath request = drilling_path(10);
    for (int i = 0; i < 1500; ++i) run.step(request.at(1e-3 * i));
    EXPECT_FALSE(writer->finish(run.engine()));
    state = run.engine().state().hash();
    events = run.engine().state().chronicle.size();
  }
  EXPECT_GT(events, 0u);
  const Verdict v = replay(path, scene.base);
  expect_same(v);
  EXPECT_EQ(v.state, state);
  EXPECT_EQ(v.counts.events, events);
  // An empty structure is refused. The error names it.
  header.structures.back().shape.low = 32000;
  const auto empty = build_scene(header, data_of(scene), drilling_catalogue());
  ASSERT_FALSE(empty.is_ok());
  EXPECT_EQ(empty.error().where, "dense");
}

}  // namespace
}  // namespace trephine::sim
