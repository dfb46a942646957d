// Insertion: force on a tool that makes a straight track in matter, compared with closed forms.
#include <cmath>
#include <random>

#include "tests/haptics/servo/servo_bench.h"
#include "volume/cuts/removal.h"

namespace trephine::haptics {
namespace {

/// A plate perpendicular to z, with its middle at z = 0; thickness and spacing in mm.
TouchScene plate(double thickness, const dvec3& spacing) {
  data_tools::PhantomOptions o;
  o.spacing_mm = spacing;
  o.size = glm::ivec3(glm::ceil(dvec3(24) / spacing));
  o.psf_sigma_voxels = 0.7;
  o.parameters = {{"thickness", thickness}, {"angle", 0}};
  return scenes::phantom_scene("plate", o);
}

/// A hand that pushes a tip along a track. `insertion`: the track and its layers; `rate`: Hz.
struct Push {
  TouchScene scene;
  Insertion track;
  LawSet laws;
  LawMemory memory;
  double dt;
  const volume::Version* cuts = nullptr;
  Push(TouchScene touched, Insertion insertion, double rate = 1000)
      : scene(std::move(touched)), track(insertion), dt(1 / rate) {
    EXPECT_FALSE(laws.add(law_of(Effect{insertion, 20}, 0).value()));
  }
  LawForces at(const dvec3& hip) {
    return memory.step(
        laws, {scene, cuts, {}, dvec3(0), dvec3(0), hip, {1, 0, 0, 0}, dvec3(0), dvec3(0), dt, true});
  }
  LawForces at(double z) { return at(track.start_world + dvec3(0, 0, z - track.start_world.z)); }
};

Insertion track_in(const InsertionLayer& layer, double start) {
  Insertion track;
  track.start_world = {0.3, -0.2, start};
  track.layers[0] = layer;
  track.layer_count = 1;
  return track;
}

TEST(Insertion, ResistsWhileTheTrackGrowsAndLetsGoAtTheFarSide) {
  constexpr double k_thickness = 8, k_speed = 20;  // mm, mm/s
  for (const double rate : {250.0, 1000.0, 4000.0})
    for (const dvec3& spacing : {dvec3(0.3), dvec3(0.5), dvec3(0.6, 0.6, 1.5)}) {
      SCOPED_TRACE(std::to_string(rate) + " Hz, " + std::to_string(spacing.z) + " mm");
      Push push(plate(k_thickness, spacing), track_in({0, -1, 2, 2}, 0.5 * k_thickness), rate);
      double released_at = 1e9;
      int lost = 0, met = 0;
      double deepest = 0;
      const double step = k_speed / rate;
      for (double z = 4; z > -8; z -= step) {
        const LawForces f = push.at(z);
        ASSERT_TRUE(f.has_tip);
        lost += f.has_lost_resistance, met += f.has_met_resistance;
        if (lost == 0) released_at = f.tip_world.z;  // in the last tick that held it
        // The tip is on the line, 2 N / (1 N/mm) = 2 mm behind the hand.
        EXPECT_NEAR(f.tip_world.x, 0.3, 1e-12);
        if (z < 1.5 && z > -1.5) {
          EXPECT_NEAR(f.passive_world.z, 2, 0.04) << z;
          EXPECT_NEAR(f.tip_world.z, z + 2, 0.06) << z;
        }
        deepest = f.tip_world.z;
      }
      EXPECT_EQ(lost, 1);
      EXPECT_EQ(met, 1);
      // The tip is released where the tip leaves the plate, not 2 mm earlier, where the hand leaves it. The
      // tolerance is 0.2 mm plus the motion in one tick.
      EXPECT_NEAR(released_at, -0.5 * k_thickness, 0.2 + step) << released_at;
      EXPECT_NEAR(push.at(-8).passive_world.z, 0, 1e-9);
      EXPECT_NEAR(deepest, -8, 0.1);
      // The hand moves back and in again along the track: no force and no event.
      for (double z = -8; z < 4; z += step) {
        const LawForces f = push.at(z);
        EXPECT_NEAR(f.passive_world.z, 0, 1e-12);
        EXPECT_FALSE(f.has_lost_resistance || f.has_met_resistance);
        EXPECT_NEAR(f.tip_world.z, z, 1e-12);
      }
      for (double z = 4; z > -7.5; z -= step) EXPECT_NEAR(push.at(z).passive_world.z, 0, 1e-12);
      // Sideways, a spring of 2 N/mm holds the tip.
      EXPECT_NEAR(push.at({1.3, -0.2, 0}).passive_world.x, -2, 1e-12);
    }
}

TEST(Insertion, ALayerIsPuncturedOnce) {
  Push push(plate(8, dvec3(0.4)), track_in({0, -1, 3, 0.5}, 4.5));
  double most = 0, z = 4.5;
  for (; z > 3; z -= 0.01) most = std::max(most, push.at(z).passive_world.z);
  double before_puncture = 0;
  for (; most < 2.99 && z > -4; z -= 0.01)
    most = std::max(most, before_puncture = push.at(z).passive_world.z);
  EXPECT_NEAR(most, 3, 0.02);
  for (int i = 0; i < 50; ++i) push.at(z);  // the tip moves at most 0.5 mm in a tick
  EXPECT_NEAR(push.at(z).passive_world.z, 0.5, 1e-6);
  for (const double end = z - 2; z > end; z -= 0.01) EXPECT_LT(push.at(z).passive_world.z, 0.53);
  for (double back = z; back < 4.5; back += 0.05) push.at(back);
  for (double again = 4.5; again > z; again -= 0.05) EXPECT_LT(push.at(again).passive_world.z, 0.53);
}

TEST(Insertion, ALabelIsALayerAndRemovedMatterDoesNotResist) {
  TouchScene scene = plate(8, dvec3(0.5));
  auto labelled = std::make_shared<volume::Volume>(
      volume::make_volume(scene.base->size, scene.base->frame, true).value());
  std::copy(scene.base->voxels.span().begin(), scene.base->voxels.span().end(), labelled->voxels.data());
  labelled->label_names = {"nothing", "brain"};
  for (int z = 0; z < labelled->size.z; ++z)
    for (int y = 0; y < labelled->size.y; ++y)
      for (int x = 0; x < labelled->size.x; ++x)
        labelled->labels[labelled->index(x, y, z)] =
            std::abs(labelled->frame.world_from_volume(dvec3(x, y, z)).z) < 2 ? 1 : 0;
  scene.base = labelled;
  Push push(scene, track_in({-1, 1, 1, 1}, 6));
  double z = 6;
  for (; z > 2.5; z -= 0.02) EXPECT_NEAR(push.at(z).passive_world.z, 0, 0.03);
  for (; z > 0.5; z -= 0.02) push.at(z);
  for (; z > -2.5; z -= 0.02) EXPECT_NEAR(push.at(z).passive_world.z, 1, 0.03) << z;

  // A drilled hole does not resist.
  TouchScene solid = plate(8, dvec3(0.5));
  ASSERT_FALSE(set_smallest_burr(solid, 3).has_value());
  volume::RemovalEditor editor(uncut_version(solid), {solid.items[0].field});
  editor.remove({{0.3, -0.2, 6}, {0.3, -0.2, 0}, 2, false});
  const auto cut = editor.publish();
  Push drilled(solid, track_in({0, -1, 2, 2}, 4));
  drilled.cuts = cut.get();
  for (z = 4; z > -1; z -= 0.02) EXPECT_NEAR(drilled.at(z).passive_world.z, 0, 0.03) << z;
  for (; z > -4; z -= 0.02) drilled.at(z);
  EXPECT_NEAR(drilled.at(z).passive_world.z, 2, 0.03);
}

TEST(Insertion, NeverReturnsMoreWorkThanItTook) {
  std::mt19937 random(4);
  std::normal_distribution<double> shake(0, 1);
  for (const double rate : {250.0, 1000.0, 4000.0}) {
    Push push(plate(8, dvec3(0.4)), track_in({0, -1, 3, 0.8}, 4), rate);
    dvec3 hip = push.track.start_world, velocity(0), held = push.at(hip).passive_world;
    double work = 0, least = 0;  // N mm, done by the hand
    for (int i = 0; i < 40 * rate; ++i) {
      velocity +=
          (0.2 * 60.0 * dvec3(shake(random), shake(random), shake(random)) - 2.0 * velocity) / rate * 20.0;
      dvec3 next = hip + velocity / rate;
      next += 0.002 * (push.track.start_world - dvec3(0, 0, 4) - next);  // stays near the plate
      const dvec3 force = push.at(next).passive_world;
      work -= 0.5 * glm::dot(held + force, next - hip);  // the trapezoid rule excludes errors of sampling
      held = force, hip = next;
      least = std::min(least, work);
    }
    EXPECT_GT(least, -0.02) << rate;
    EXPECT_GT(work, 1) << "it dissipates";
  }
}

TEST(Insertion, WordsAndInvalidInput) {
  Insertion track = track_in({0, -1, 3, 0.5}, 4);
  track.layers[1] = {-1, 12, 1.25, 0};
  track.layer_count = 2;
  const Effect effect{track, 5};
  const std::string words = words_of(effect);
  const auto back = parse_effect(words);
  ASSERT_TRUE(back.is_ok()) << back.error().message();
  EXPECT_TRUE(back.value() == effect) << words;
  for (const char* text : {"constant", "viscous damping=0.004", "spring anchor=1,2,3.25", "line", "plane",
                           "vibration", "gravity", "texture", "align", "spin drag=0.2", "insertion"}) {
    const Effect parsed = parse_effect(text).value();
    EXPECT_TRUE(parse_effect(words_of(parsed)).value() == parsed) << words_of(parsed);
  }
  for (const char* wrong :
       {"insertion layers=bone:1:1", "insertion layers=item0:1", "insertion layers=item0:1:1,",
        "insertion layers=item-1:1:1", "insertion layers=item0:21:1", "insertion layers=item0:1:-1",
        "insertion layers=item0:1:1,item1:1:1,item2:1:1,item3:1:1,item4:1:1", "insertion ahead=0,0,0",
        "insertion along=0", "insertion lateral=5", "insertion layers=item0:nan:1"})
    EXPECT_FALSE(parse_effect(wrong).is_ok()) << wrong;
  // Items and labels that the scene lacks resist nothing.
  for (const InsertionLayer& layer : {InsertionLayer{7, -1, 2, 2}, InsertionLayer{-1, 3, 2, 2}}) {
    Push push(plate(8, dvec3(0.5)), track_in(layer, 4));
    for (double z = 4; z > -6; z -= 0.05) EXPECT_NEAR(push.at(z).passive_world.z, 0, 1e-9);
  }
  // Forces at positions far away stay bounded.
  Push push(plate(8, dvec3(0.5)), track_in({0, -1, 2, 2}, 4));
  for (const double far : {1e3, 1e6, -1e6})
    EXPECT_LE(glm::length(push.at({far, far, far}).passive_world), 20.001);
}

}  // namespace
}  // namespace trephine::haptics
