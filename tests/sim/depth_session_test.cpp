// Objects that are touched by depth images in an operation: sets of images follow the hands, and sessions
// replay them to the bit.
#include <chrono>
#include <thread>

#include "haptics/depth/depth_model.h"
#include "sim/drivers/live_session.h"
#include "tests/sim/crowd.h"
#include "tests/sim/opens_anywhere.h"

namespace trephine::sim {
namespace {

using haptics::depth::DepthModel;
using haptics::depth::ModelKeys;

/// Returns a paddle of small triangles at `time` (s). The paddle moves up and down, and bends.
std::shared_ptr<const haptics::MeshTree> paddle(double time) {
  constexpr int k_side = 16;
  std::vector<dvec3> corners;
  std::vector<std::uint32_t> triangles;
  for (int j = 0; j <= k_side; ++j)
    for (int i = 0; i <= k_side; ++i)
      for (int k = 0; k < 2; ++k) {
        const double x = 0.6 * (i - k_side / 2), y = 0.6 * (j - k_side / 2);
        const double z = 7 + 3 * std::cos(6 * time) + 0.02 * std::sin(9 * time) * (x * x + y * y);
        corners.push_back({x - 9, y, z + k - 0.5});
      }
  const auto at = [](int i, int j, int k) {
    return static_cast<std::uint32_t>(2 * (i + (k_side + 1) * j) + k);
  };
  const auto quad = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    triangles.insert(triangles.end(), {a, b, c, a, c, d});
  };
  for (int j = 0; j < k_side; ++j)
    for (int i = 0; i < k_side; ++i) {
      quad(at(i, j, 1), at(i + 1, j, 1), at(i + 1, j + 1, 1), at(i, j + 1, 1));
      quad(at(i, j, 0), at(i, j + 1, 0), at(i + 1, j + 1, 0), at(i + 1, j, 0));
    }
  for (int i = 0; i < k_side; ++i) {
    quad(at(i, 0, 0), at(i + 1, 0, 0), at(i + 1, 0, 1), at(i, 0, 1));
    quad(at(i + 1, k_side, 0), at(i, k_side, 0), at(i, k_side, 1), at(i + 1, k_side, 1));
    quad(at(0, i + 1, 0), at(0, i, 0), at(0, i, 1), at(0, i + 1, 1));
    quad(at(k_side, i, 0), at(k_side, i + 1, 0), at(k_side, i + 1, 1), at(k_side, i, 1));
  }
  return std::make_shared<const haptics::MeshTree>(std::move(corners), std::move(triangles));
}

/// Returns bone to drill, and a block and a paddle that are touched by depth images.
haptics::TouchScene mixed() {
  haptics::TouchScene scene = small_bone();
  const auto add = [&](std::vector<std::shared_ptr<const haptics::MeshTree>> keys, double beat) {
    const auto first = keys[0];
    const auto after = keys.size() > 1 ? ModelKeys::After::repeat : ModelKeys::After::stay;
    scene.items.push_back(
        haptics::depth_item("drawn", DepthModel::of_keys(std::move(keys), beat, after).value(), first));
  };
  add({box({6, -3, 0}, {9, 3, 4})}, 1);
  std::vector<std::shared_ptr<const haptics::MeshTree>> keys;
  for (int k = 0; k < 20; ++k) keys.push_back(paddle(k * 0.05));
  add(std::move(keys), 0.05);
  scene.items.back().mover = 0;
  return scene;
}

OperationStart start_of(const haptics::TouchScene& scene) {
  SceneDescription spec =
      describe_scene(scene, *haptics::make_method("scene").value(), {}, {HandSpec(drilling::burr(k_burr))});
  HandSpec& second = spec.hands.emplace_back();
  second.method = "scene";
  second.tool = std::make_shared<const haptics::ToolShape>(0.8);
  spec.smallest_burr = 3;
  auto result = build_scene(spec, data_of(scene), drilling_catalogue());
  EXPECT_TRUE(result.is_ok()) << result.error().message();
  return std::move(result).value();
}

/// Returns the poses of both hands at `t` (s). The first hand drills. The second moves back and forth between
/// the block and the paddle, and presses on both.
std::array<haptics::Pose, 2> poses_at(double t) {
  static const haptics::PosePath request = drilling_path(20);
  const double s = 0.5 - 0.5 * std::cos(4.4 * t);
  return {request.at(t), haptics::Pose{{8 - 16 * s, 0.6 * std::sin(5 * t), 3.4 + 3 * s}, {1, 0, 0, 0}, 0}};
}

/// Numbers of ticks in which the second hand touches.
struct Touched {
  long on_block = 0, on_paddle = 0, pushed = 0;
  void add(const haptics::ServoRecord& r) {
    if (r.hand != 1 || !r.has_contact) return;
    on_block += r.shape == 1;
    on_paddle += r.shape == 2;
    pushed += r.shape == 2 && glm::length(r.proxy_world - r.pose.position_world) > 0.3;
  }
};

TEST(DepthSession, AReplayTouchesTheSameAndOpensAnywhere) {
  const Folder folder;
  const std::string path = folder.file("mixed.session");
  const haptics::TouchScene scene = mixed();
  std::uint64_t state = 0;
  {
    OperationStart start = start_of(scene);
    auto writer = SessionWriter::create(path, SessionHeader(describe_scene(start.hands, {})), data_of(scene),
                                        drilling_catalogue(), with_checkpoint_work(8'000));
    ASSERT_TRUE(writer.is_ok()) << writer.error().message();
    Lockstep run(Engine(std::move(start.hands), 1e-3, drilling_catalogue()), {}, 1000, writer.value().get());
    Touched touched;
    for (int i = 0; i < 1500; ++i) {
      for (const haptics::ServoRecord& r : run.step(poses_at(1e-3 * i))) touched.add(r);
      if (i % 700 == 450) run.undo();
      if (i == 1200) {
        PlaceModel placement;
        placement.position = {0.5, 0, 0};
        EXPECT_FALSE(run.apply(placement).refused);
      }
    }
    EXPECT_GT(touched.on_block, 100);
    EXPECT_GT(touched.on_paddle, 100);
    EXPECT_GT(touched.pushed, 50);
    EXPECT_GT(run.engine().removed_mm3(), 5);
    state = run.engine().state().hash();
    EXPECT_FALSE(writer.value()->finish(run.engine()));
  }
  const Verdict v = replay(path);
  expect_same(v);
  EXPECT_EQ(v.state, state);
  EXPECT_GT(v.counts.commands, 120u);  // sets of images, a hundred per second
  expect_opens_anywhere(path, drilling_catalogue(), data_of(scene), 3);
}

TEST(DepthSession, NothingIsDrawnWithoutMotionOrHandsNearby) {
  haptics::TouchScene scene = mixed();
  scene.items.pop_back();  // the block only
  OperationStart start = start_of(scene);
  Lockstep run(Engine(std::move(start.hands), 1e-3, drilling_catalogue()), {}, 1000);
  std::vector<haptics::Pose> poses(2, {{200, 0, 0}, {1, 0, 0, 0}, 0});
  const auto sets = [&] {
    const auto& set = run.engine().servo_scene()->hands[1].state.depths.at(0);
    return set ? set->serial : 0;
  };
  for (int i = 0; i < 200; ++i) run.step(poses);
  EXPECT_EQ(sets(), 0u);
  poses[1].position_world = {10, 0, 2};
  for (int i = 0; i < 200; ++i) run.step(poses);
  EXPECT_EQ(sets(), 1u);  // drawn once, and nothing moved since
  const auto& set = *run.engine().servo_scene()->hands[1].state.depths[0];
  EXPECT_LT(set.pixels, 100'000u);  // pixels of the clip volume
  EXPECT_FALSE(run.engine().servo_scene()->hands[0].state.depths[0]);
}

/// The hand is so far from its proxy that no set covers the surroundings of both, with coarse and with fine
/// pixels.
TEST(DepthSession, AtMostAHundredSetsPerSecondWhateverTheirContents) {
  for (const double pixel : {5.0, 0.2}) {
    haptics::TouchScene scene = mixed();
    scene.items.pop_back();
    scene.items.back().depth_pixel = pixel;
    OperationStart start = start_of(scene);
    Lockstep run(Engine(std::move(start.hands), 1e-3, drilling_catalogue()), {}, 1000);
    std::vector<haptics::Pose> poses(2, {{20, 0, 2}, {1, 0, 0, 0}, 0});
    for (int i = 0; i < 45; ++i) {
      if (i > 20) poses[1].position_world = {-80 + 0.1 * i, 0, 2};
      run.step(poses);
    }
    const auto& set = run.engine().servo_scene()->hands[1].state.depths.at(0);
    ASSERT_TRUE(set) << pixel;
    EXPECT_LE(set->serial, 5u) << pixel;
  }
}

/// Sets are drawn at the requested rate (100 Hz in the publication: Kim et al., Presence 18:340, 2009). Each
/// set is large enough for a hand that moves at 1 m/s until the next set.
TEST(DepthSession, AsManySetsPerSecondAsRequested) {
  for (const double rate : {30.0, 100.0, 250.0}) {
    haptics::TouchScene scene = mixed();
    scene.items.back().depth_rate = rate;
    OperationStart start = start_of(scene);
    Lockstep run(Engine(std::move(start.hands), 1e-3, drilling_catalogue()), {}, 1000);
    std::vector<haptics::Pose> poses(2, {{-9, 0, 3}, {1, 0, 0, 0}, 0});
    for (int i = 0; i < 400; ++i) run.step(poses);
    const auto& set = run.engine().servo_scene()->hands[1].state.depths.at(1);
    ASSERT_TRUE(set) << rate;
    // In addition, a set is drawn when the motion changes: at each key of the paddle, every 0.05 s.
    EXPECT_GE(static_cast<double>(set->serial), 0.4 * rate - 2 - 0.02 * rate) << rate;
    EXPECT_LE(static_cast<double>(set->serial), 0.4 * rate + 6 + 0.02 * rate) << rate;
    EXPECT_LE(set->view.interval, 1 / rate);
    EXPECT_GE(set->view.edge, 2000 / rate) << rate;
    // A scene description keeps the rate.
    const SceneDescription spec =
        describe_scene(scene, *haptics::make_method("scene").value(), {}, {HandSpec()});
    EXPECT_EQ(spec.structures.back().depth_rate, rate);
  }
}

/// An overlay shows an object by the key that is nearest to the current time. The displayed depth images of a
/// hand are drawn at the object's current pose.
TEST(DepthSession, APictureShowsAMovingObjectAtItsTime) {
  OperationStart start = start_of(mixed());
  Lockstep run(Engine(std::move(start.hands), 1e-3, drilling_catalogue()), {}, 1000);
  std::vector<haptics::Pose> poses(2, {{200, 0, 0}, {1, 0, 0, 0}, 0});
  const auto lowest_of = [](const haptics::MeshTree& tree) {
    double z = 1e300;
    for (const dvec3& p : tree.vertices()) z = std::min(z, p.z);
    return z;
  };
  const auto lowest = [&](std::size_t overlay) {
    return lowest_of(*run.engine().overlays().at(overlay).surface);
  };
  const double block = lowest(0);
  EXPECT_EQ(lowest(1), lowest_of(*paddle(0)));
  EXPECT_TRUE(run.engine().displayed_depths(1).empty());
  poses[1].position_world = {-9, 0, 3};
  for (int i = 0; i < 500; ++i) run.step(poses);
  EXPECT_EQ(lowest(1), lowest_of(*paddle(0.5)));
  EXPECT_EQ(lowest(0), block);
  EXPECT_TRUE(run.engine().has_moving_surfaces());
  const std::vector<DisplayedDepths> seen = run.engine().displayed_depths(1);
  ASSERT_FALSE(seen.empty());
  // The drawn surface is on the object in its current pose.
  double least = 1e300;
  for (const dvec3& p : seen.back().set->tree->vertices())
    least = std::min(least, seen.back().surface_pose.world_from_local(p).z);
  EXPECT_NEAR(least, lowest(1), 0.25);
}

TEST(DepthSession, PixelsTooFineForAHandAreRefused) {
  EXPECT_FALSE(DepthSets::check_pixel(0.05, 100, 0));
  const auto fine = DepthSets::check_pixel(0.02, 100, 0);
  ASSERT_TRUE(fine);
  EXPECT_NE(fine->what.find("too small"), std::string::npos);
  EXPECT_FALSE(DepthSets::check_pixel(0.02, 1000, 0));  // at 1000 Hz the clip volume is smaller
}

/// Returns a command that adopts depth images with a clip volume of `edge` mm.
Adopt images_of(std::int64_t item, double edge) {
  DepthImages input;
  input.edge = edge;
  return {DerivedKind::depth_images, item, 1, Value(input).bytes(), 0};
}

TEST(DepthSession, CommandsAboutSetsAreChecked) {
  OperationStart start = start_of(mixed());
  Engine engine(std::move(start.hands), 1e-3, drilling_catalogue());
  ASSERT_TRUE(engine.apply({images_of(0, 20), 1}).refused);
  EXPECT_NE(engine.apply({images_of(0, 20), 1}).refused->message().find("has no depth images"),
            std::string::npos);
  EXPECT_TRUE(engine.apply({images_of(1, 1e9), 1}).refused);
  Adopt torn = images_of(1, 20);
  torn.input.pop_back();
  EXPECT_TRUE(engine.apply({torn, 1}).refused);
  Adopt search = images_of(1, 20);
  search.kind = DerivedKind::loose_parts;  // FreePieces adopts this kind
  EXPECT_TRUE(engine.apply({search, 1}).refused);
  EXPECT_FALSE(engine.apply({images_of(1, 20), 1}).refused);
}

/// Returns an incoming picture of a plane, from a camera that faces down.
haptics::depth::DepthPicture picture_of_plane(double height) {
  haptics::depth::DepthPicture picture;
  picture.placement = {{8, 0, 100}, {0, 1, 0, 0}};  // x is kept, y and z are reversed
  picture.camera = {80, 80, 200, 200, 39.5, 39.5};
  picture.set_depths(std::vector<double>(80 * 80, 100 - height));
  return picture;
}

TEST(DepthSession, IncomingPicturesAreKeptAndReplayed) {
  const Folder folder;
  const std::string path = folder.file("pictures.session");
  haptics::TouchScene scene = small_bone();
  scene.items.push_back(haptics::depth_item("background", std::make_shared<haptics::depth::IncomingDepths>(),
                                            box({4, -4, 0}, {12, 4, 2})));
  OperationStart start = start_of(scene);
  auto writer = SessionWriter::create(path, SessionHeader(describe_scene(start.hands, {})), data_of(scene),
                                      drilling_catalogue(), with_checkpoint_work(20'000));
  ASSERT_TRUE(writer.is_ok()) << writer.error().message();
  Lockstep run(Engine(std::move(start.hands), 1e-3, drilling_catalogue()), {}, 1000, writer.value().get());
  std::uint64_t last_serial = 0;
  const auto show = [&](double height) {
    const DerivedJob job = run.engine().picture_job(picture_of_plane(height), 1, {8, 0, height}, 16, 1);
    EXPECT_EQ(job.serial, ++last_serial);
    return run.apply(run.engine().submit_result(job, job.make(1)));
  };
  std::vector<haptics::Pose> poses{poses_at(0)[0], {{8, 0, 6}, {1, 0, 0, 0}, 0}};
  double lowest[2] = {1e9, 1e9};
  for (int i = 0; i < 2600; ++i) {
    const bool is_lower = i >= 250;
    if (i == 50 || i % 250 == 0) {
      ASSERT_FALSE(show(is_lower ? 2.5 : 3).refused);
    }
    poses[0] = poses_at(1e-3 * i)[0];
    poses[1].position_world.z = std::max(1.0, 6 - 0.05 * i);
    for (const haptics::ServoRecord& r : run.step(poses))
      if (r.hand == 1 && r.has_contact) lowest[is_lower] = std::min(lowest[is_lower], r.proxy_world.z);
  }
  EXPECT_NEAR(lowest[0], 3.8, 1e-3);  // the centre of a ball of radius 0.8 mm on the plane
  EXPECT_NEAR(lowest[1], 3.3, 1e-3);
  // A picture for an item without depth images is refused. So are invalid pictures, and the command to draw
  // an item that receives incoming pictures.
  const auto is_refused = [&](const haptics::depth::DepthPicture& picture, std::int64_t item) {
    const DerivedJob job = run.engine().picture_job(picture, item, {8, 0, 3}, 16, 1);
    return run.apply(job.command({})).refused.has_value();
  };
  EXPECT_TRUE(is_refused(picture_of_plane(3), 0));
  haptics::depth::DepthPicture wrong = picture_of_plane(3);
  wrong.values.pop_back();
  EXPECT_TRUE(is_refused(wrong, 1));
  wrong = picture_of_plane(3);
  wrong.placement.rotation = {1, 1, 0, 0};
  EXPECT_TRUE(is_refused(wrong, 1));
  EXPECT_TRUE(run.apply({images_of(1, 10), 1}).refused);
  const std::uint64_t state = run.engine().state().hash();
  EXPECT_FALSE(writer.value()->finish(run.engine()));
  const Verdict v = replay(path);
  expect_same(v);
  EXPECT_EQ(v.state, state);
  expect_opens_anywhere(path, drilling_catalogue(), data_of(scene), 3);
}

TEST(DepthSession, InvalidModelsAreRefusedWithAReason) {
  haptics::TouchScene scene = mixed();
  const auto refused = [&](auto&& change) {
    SceneDescription spec = describe_scene(scene, *haptics::make_method("scene").value(), {}, {HandSpec()});
    spec.hands[0].method = "scene";
    SceneData data = data_of(scene);
    change(spec, data);
    const auto result = build_scene(spec, data, drilling_catalogue());
    EXPECT_FALSE(result.is_ok());
    return result ? std::string() : result.error().message();
  };
  EXPECT_NE(refused([](SceneDescription& s, SceneData& d) {
              const auto& old = *d.models[0];
              auto some = old.triangles();
              some.resize(some.size() - 3);
              d.models[0] = std::make_shared<const haptics::MeshTree>(old.vertices(), some);
              s.models[0] = {d.models[0]->triangle_count(), content_hash(*d.models[0])};
            }).find("not closed"),
            std::string::npos);
  EXPECT_NE(refused([](SceneDescription& s, SceneData&) { s.structures[2].mover = -1; }).find("mover"),
            std::string::npos);
  EXPECT_NE(
      refused([](SceneDescription& s, SceneData&) { s.structures[1].depth_pixel = 1e-5; }).find("pixels"),
      std::string::npos);
  for (const char* method : {"depth", "lomi", "mesh", "scene-sequential", "subvoxel"})
    EXPECT_NE(refused([&](SceneDescription& s, SceneData&) { s.hands[0].method = method; }).find("scene"),
              std::string::npos)
        << method;
}

TEST(DepthSession, ALiveRunIsReplayedToTheBit) {
  const Folder folder;
  const std::string path = folder.file("live.session");
  const haptics::TouchScene scene = mixed();
  OperationStart start = start_of(scene);
  auto writer = SessionWriter::create(path, SessionHeader(describe_scene(start.hands, {})), data_of(scene),
                                      drilling_catalogue(), {});
  ASSERT_TRUE(writer.is_ok());
  std::vector<haptics::PosePath::Sample> samples[2];
  for (double t = 0; t < 2.5; t += 0.01)
    for (std::size_t h = 0; h < 2; ++h) samples[h].push_back({t, poses_at(t)[h]});
  haptics::PlaybackDevice first(haptics::PosePath::from_samples(samples[0], "").value()),
      second(haptics::PosePath::from_samples(samples[1], "").value());
  haptics::Device* devices[] = {&first, &second};
  haptics::ServoOptions options;
  options.watchdog_seconds = options.lag_seconds = 10;
  std::uint64_t hash = 0;
  {
    LiveSession live(devices, Engine(std::move(start.hands), 1e-3, drilling_catalogue()), options,
                     writer.value().get());
    live.keep_trace(100'000);
    ASSERT_FALSE(live.start());
    std::this_thread::sleep_for(std::chrono::milliseconds(1500));
    live.stop();
    const LiveSession::DerivedReport drawn = live.derived_report(DerivedKind::depth_images);
    Touched touched;
    for (const haptics::ServoRecord& r : live.trace()) touched.add(r);
    // If the machine is too busy to draw in time, the hand passes through the object, as intended.
    if (drawn.longest_seconds < haptics::depth::k_extrapolation_time) {
      EXPECT_GT(drawn.count, 30u);
      EXPECT_GT(touched.on_block + touched.on_paddle, 100);
    }
    hash = live.engine().state().hash();
    EXPECT_FALSE(writer.value()->finish(live.engine()));
  }
  const Verdict v = replay(path);
  expect_same(v);
  EXPECT_EQ(v.state, hash);
}

}  // namespace
}  // namespace trephine::sim
