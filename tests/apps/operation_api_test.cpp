// trephine::Operation gives the same results as the libraries that it uses, to the bit. Its errors state
// problem and remedy.
#include <cmath>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>

#include "apps/api/operation.h"
#include "apps/bench/scenes/scratch.h"
#include "apps/imaging/xray_panel.h"
#include "apps/workbench/operation.h"
#include "modules/ct_viewer/slice_image.h"
#include "sim/drivers/lockstep.h"
#include "tests/apps/operation_fixture.h"
#include "volume/surface/surface_nets.h"

namespace trephine {
namespace {

/// Presses into the top of the built-in head, then lifts.
std::vector<Pose> poses() {
  std::vector<Pose> result(700);
  for (std::size_t i = 0; i < result.size(); ++i) {
    result[i].position_world = {0, -20, i < 650 ? 69 - 0.008 * static_cast<double>(i) : 75.0};
    result[i].press(i < 650);
  }
  return result;
}

/// Expects an error with a problem, the found and the expected value, and a remedy.
template <class T>
void expect_error(const Result<T>& result, const std::string& what, const std::string& found) {
  ASSERT_FALSE(result.is_ok());
  const Error& error = result.error();
  EXPECT_NE(error.what.find(what), std::string::npos) << error.message();
  EXPECT_NE(error.found.find(found), std::string::npos) << error.message();
  EXPECT_FALSE(error.expected.empty()) << error.message();
  EXPECT_FALSE(error.remedy.empty()) << error.message();
}

/// A burr of 4 mm that rests in bone is replaced by a perforator of 14 mm. The perforator is moved out of the
/// bone, and no structure is reported as entered.
TEST(OperationApi, ALargerToolThatIsLedOutOfBoneEntersNoStructure) {
  OperationOptions options = with_burr();
  options.uses_plan = true;
  auto result = Operation::open("head", options);
  ASSERT_TRUE(result.is_ok()) << result.error().message();
  Operation& operation = result.value();
  Pose rest;
  rest.position_world = {71.3, 0.19, -0.47};  // 0.3 mm into thin temporal bone
  const dvec3 out(1, 0, 0);
  rest.orientation = glm::dquat(dvec3(0, 0, 1), out);
  for (int i = 0; i < 60; ++i) {
    Pose approach = rest;
    approach.position_world += 0.1 * (60 - i) * out;
    ASSERT_TRUE(operation.step(approach).is_ok());
  }
  ASSERT_FALSE(operation.command("take-instrument", "instrument=perforator"));
  const dvec3 begin = operation.step(rest).value().proxy_world;
  dvec3 end = begin;
  for (int i = 0; i < 300; ++i) end = operation.step(rest).value().proxy_world;
  EXPECT_GT(glm::length(end - begin), 2) << "the perforator was moved out of the bone";
  for (std::size_t i = 0; i < operation.event_count(); ++i)
    EXPECT_NE(operation.event(i).value.name(), "forbidden-entered");
}

TEST(OperationApi, DrillsTheHeadExactlyAsLockstep) {
  auto result = Operation::open("head", with_burr());
  ASSERT_TRUE(result.is_ok()) << result.error().message();
  Operation& operation = result.value();
  workbench::OperationChoice choice;
  choice.hands[0].instrument = k_burr.instrument;
  choice.hands[0].parameters = k_burr.parameters;
  const auto built = workbench::open_operation("head", choice);
  ASSERT_TRUE(built.is_ok());
  sim::Lockstep lockstep(built.value().engine(), {}, 1000);

  double strongest = 0;
  for (const Pose& pose : poses()) {
    const auto touch = operation.step(pose);
    ASSERT_TRUE(touch.is_ok());
    const haptics::ServoRecord record = lockstep.step(pose);
    ASSERT_EQ(touch.value().force_world, record.force_world);
    ASSERT_EQ(touch.value().proxy_world, record.proxy_world);
    strongest = std::max(strongest, touch.value().force_world.z);
  }
  EXPECT_GT(strongest, 0.1);
  EXPECT_GT(operation.removed_mm3(), 5);
  EXPECT_EQ(operation.removed_mm3(), lockstep.engine().removed_mm3());
  EXPECT_EQ(operation.hash(), lockstep.engine().snapshot()->hash());
  EXPECT_EQ(operation.tick(), poses().size());
  EXPECT_EQ(operation.measures()[0].name, "removed");
  EXPECT_EQ(operation.measures()[0].value, operation.removed_mm3());

  // Images are those of the libraries that make them, and show the hole.
  ImagePlane plane;
  plane.middle_world = {0, -20, 66};
  plane.columns = plane.rows = 64;
  const auto slice = operation.slice(plane);
  ASSERT_TRUE(slice.is_ok());
  const auto values =
      ct_viewer::slice_values(*built.value().source.volume, *lockstep.engine().version(), plane, {});
  EXPECT_EQ(slice.value().pixels, values.now);
  EXPECT_NE(values.now, values.before);

  const XrayPose pose{
      .isocentre_world = {0, -20, 40}, .secondary = 20, .pixel = 1, .columns = 96, .rows = 80};
  const auto xray = operation.xray(pose);
  ASSERT_TRUE(xray.is_ok()) << xray.error().message();
  fluoroscopy::CArm arm;
  arm.isocentre = pose.isocentre_world, arm.secondary = 20, arm.pixel = 1, arm.columns = 96, arm.rows = 80;
  imaging::Subject subject;
  subject.scan = built.value().source.volume;
  lockstep.engine().freeze();
  subject.version = lockstep.engine().version();
  imaging::XrayCamera camera;
  const auto panel = camera.shoot(subject, arm, 1, fluoroscopy::Display());
  ASSERT_TRUE(panel.is_ok());
  ASSERT_EQ(xray.value().pixels.size(), 96u * 80u);
  std::size_t differing = 0, dark = 0;
  for (std::size_t row = 0; row < 80; ++row)
    for (std::size_t column = 0; column < 96; ++column) {
      const std::uint8_t grey = xray.value().pixels[row * 96 + column];
      differing += grey != panel.value().pixels[(79 - row) * 96 + column][0];
      dark += grey < 128;
    }
  EXPECT_EQ(differing, 0u);
  EXPECT_GT(dark, 100u);
  EXPECT_LT(dark, 96u * 80u - 100u);

  ASSERT_FALSE(operation.undo());
  EXPECT_EQ(operation.removed_mm3(), 0);
  EXPECT_EQ(operation.slice(plane).value().pixels, values.before);
  ASSERT_FALSE(operation.redo());
  EXPECT_EQ(operation.slice(plane).value().pixels, values.now);
}

TEST(OperationApi, RecordsReopensAndVerifies) {
  const scenes::Scratch folder;
  const std::string file = (folder.path / "cube.session").string();
  OperationOptions options = with_burr();
  options.recording = {file, true, "operation test"};
  std::uint64_t hash = 0;
  double removed = 0;
  {
    Operation operation = opened(options);
    drill(operation, -3);
    ASSERT_FALSE(operation.command("note", "text=\"first hole\""));
    drill(operation, 3);
    hash = operation.hash(), removed = operation.removed_mm3();
    ASSERT_FALSE(operation.end());
    // After the end only queries are allowed.
    EXPECT_TRUE(operation.end());
    EXPECT_FALSE(operation.step(Pose()).is_ok());
    EXPECT_TRUE(operation.undo());
    EXPECT_EQ(operation.removed_mm3(), removed);
  }
  EXPECT_GT(removed, 10);
  auto reopened = Operation::reopen(file);
  ASSERT_TRUE(reopened.is_ok()) << reopened.error().message();
  Operation& operation = reopened.value();
  EXPECT_TRUE(operation.is_whole());
  EXPECT_EQ(operation.tick(), 0u);
  EXPECT_EQ(operation.tick_count(), 600u);
  EXPECT_EQ(operation.removed_mm3(), 0);
  ASSERT_FALSE(operation.go_to(300));
  EXPECT_GT(operation.removed_mm3(), 0);
  EXPECT_LT(operation.removed_mm3(), removed);
  const Status different = operation.verify();
  EXPECT_FALSE(different) << different->message();
  EXPECT_EQ(operation.removed_mm3(), removed);
  EXPECT_EQ(operation.hash(), hash);
  // A recorded operation is read-only.
  EXPECT_EQ(operation.step(Pose()).error().what, "a recorded operation cannot be changed");
  EXPECT_TRUE(operation.undo() && operation.command("note", "text=no") && operation.reset());

  // The volumes may also come from the caller; those of another scan are refused.
  EXPECT_TRUE(Operation::reopen(file, {cube()}).is_ok());
  auto other = volume::copy_of(*cube());
  other.value().voxels[0] = 7;
  EXPECT_FALSE(Operation::reopen(file, {std::make_shared<const Volume>(std::move(other).value())}).is_ok());

  // A file that exists is not overwritten. is_whole() reports a truncated file.
  expect_error(Operation::open(cube(), options), "already exists", "");
  const std::string part = (folder.path / "part.session").string();
  std::filesystem::copy_file(file, part);
  std::filesystem::resize_file(part, std::filesystem::file_size(part) - 100);
  auto cut = Operation::reopen(part);
  ASSERT_TRUE(cut.is_ok());
  EXPECT_FALSE(cut.value().is_whole());
  // Changed bytes in the middle are damage, which reopen() or verify() reports.
  std::fstream bytes(part, std::ios::in | std::ios::out | std::ios::binary);
  bytes.seekp(static_cast<std::streamoff>(std::filesystem::file_size(part) / 2));
  bytes.write("damage", 6);
  bytes.close();
  auto broken = Operation::reopen(part);
  EXPECT_TRUE(!broken || broken.value().verify());
}

TEST(OperationApi, CommandsByWordsAndByStructReportWhatIsWrong) {
  Operation operation = opened();
  Status error = operation.command("brr", "diameter=3");
  ASSERT_TRUE(error);
  EXPECT_EQ(error->what, "unknown command");
  EXPECT_EQ(error->found, "brr");
  EXPECT_NE(error->expected.find("burr"), std::string::npos);
  EXPECT_FALSE(error->remedy.empty());
  error = operation.command("burr", "diametre=3");
  ASSERT_TRUE(error);
  EXPECT_NE(error->message().find("diametre"), std::string::npos) << error->message();
  EXPECT_NE(error->message().find("diameter"), std::string::npos) << error->message();
  error = operation.command("burr", "diameter=wide");
  ASSERT_TRUE(error);
  EXPECT_NE(error->message().find("wide"), std::string::npos) << error->message();
  error = operation.command("burr", "diameter=4", 1);
  ASSERT_TRUE(error);
  EXPECT_EQ(error->what, "unknown hand");
  EXPECT_EQ(operation.command(Command(sim::Note{"x"}, 3))->what, "unknown hand");
  // A command that the state does not allow is refused.
  error = operation.command("hold-body", "body=3");
  ASSERT_TRUE(error);
  EXPECT_EQ(error->kind, ErrorKind::refused);
  // A command whose job fails is refused, too.
  error = operation.command("place-screw", "entry=900,0,0 target=900,0,9 diameter=6 length=35");
  ASSERT_TRUE(error);
  EXPECT_EQ(error->kind, ErrorKind::refused);
  EXPECT_EQ(error->where, "place-screw");
  EXPECT_EQ(error->found, "there is no bone along the screw");
  EXPECT_FALSE(operation.command("burr", "diameter=5"));
  EXPECT_FALSE(operation.command(sim::Note{"text"}));
  // An undo without a previous change is no error.
  EXPECT_FALSE(operation.undo());
}

TEST(OperationApi, HandsFaultsEventsAndChangedVoxels) {
  OperationOptions options = with_burr();
  options.hands.push_back({});
  Operation operation = opened(options);
  EXPECT_EQ(operation.hand_count(), 2u);
  EXPECT_EQ(operation.step(Pose()).error().what, "the number of poses is wrong");
  EXPECT_FALSE(operation.take_changed());
  Pose first, second;
  second.position_world = {0, 0, 20};
  for (int i = 0; i < 300; ++i) {
    first.position_world = {0, 0, 9 - 0.01 * i};
    const Pose both[] = {first, second};
    const auto touches = operation.step(both);
    ASSERT_TRUE(touches.is_ok());
    EXPECT_FALSE(touches.value()[1].has_contact);
  }
  const auto changed = operation.take_changed();
  ASSERT_TRUE(changed);
  const auto values = operation.read(*changed);
  ASSERT_TRUE(values.is_ok());
  EXPECT_LT(*std::min_element(values.value().begin(), values.value().end()), 0);
  EXPECT_FALSE(operation.take_changed());
  EXPECT_FALSE(operation.read({glm::ivec3(0), glm::ivec3(48)}).is_ok());
  EXPECT_FALSE(operation.read({glm::ivec3(5), glm::ivec3(4)}).is_ok());

  first.position_world.z = std::numeric_limits<double>::quiet_NaN();
  const Pose broken[] = {first, second};
  const auto faulty = operation.step(broken);
  EXPECT_NE(faulty.value()[0].faults, 0u);
  EXPECT_EQ(faulty.value()[0].force_world, dvec3(0));
  ASSERT_GT(operation.event_count(), 0u);
  EXPECT_EQ(operation.event(operation.event_count() - 1).value.name(), "fault");
  EXPECT_FALSE(operation.reset());
  const Pose again[] = {second, second};
  EXPECT_EQ(operation.step(again).value()[0].faults, 0u);
}

TEST(OperationApi, SurfacesBodiesAndScenesInText) {
  Operation operation = opened();
  const auto whole = operation.surface();
  ASSERT_TRUE(whole.is_ok());
  // Enclosed volume by the divergence theorem, positive if the surface faces outward.
  const auto volume_of = [](const Surface& surface) {
    double sum = 0;
    for (std::size_t i = 0; i + 2 < surface.triangles.size(); i += 3) {
      const dvec3 &a = surface.vertices_world[surface.triangles[i]],
                  &b = surface.vertices_world[surface.triangles[i + 1]],
                  &c = surface.vertices_world[surface.triangles[i + 2]];
      sum += glm::dot(a, glm::cross(b, c)) / 6;
    }
    return sum;
  };
  EXPECT_NEAR(volume_of(whole.value()), 16 * 16 * 16, 20);
  drill(operation, 0);
  EXPECT_NEAR(volume_of(whole.value()) - volume_of(operation.surface().value()), operation.removed_mm3(),
              0.1 * operation.removed_mm3());
  EXPECT_FALSE(operation.surface(1).is_ok());

  // The scene and its instrument are described in text. A cut through the cube detaches a body.
  auto scene = Operation::open_scene("structure=bone\nlow=300\nhand=burr\nparameters=diameter=4 kinematic=1",
                                     {cube()});
  ASSERT_TRUE(scene.is_ok()) << scene.error().message();
  Operation& sawing = scene.value();
  std::vector<Pose> path;
  for (int y = -10; y <= 10; ++y)
    for (int i = 0; i <= 40; ++i)
      path.emplace_back().position_world = {y % 2 ? 10 - 0.5 * i : -10 + 0.5 * i, y, 0};
  path.emplace_back(path.back()).press(false);
  ASSERT_TRUE(sawing.run(path).is_ok());
  const Status not_freed = sawing.command("free-pieces");
  ASSERT_FALSE(not_freed) << not_freed->message();
  ASSERT_EQ(sawing.bodies().size(), 1u);
  const Body body = sawing.bodies()[0];
  EXPECT_GT(body.mm3, 500);
  EXPECT_NEAR(volume_of(*body.surface), body.mm3, 0.05 * body.mm3);
  EXPECT_EQ(body.holder, -1);
  ASSERT_FALSE(sawing.command("place-body", "body=1 position=0,0,5"));
  EXPECT_EQ(sawing.bodies()[0].position_world, dvec3(0, 0, 5));
  // The text of scene() opens the same scene again.
  auto again = Operation::open_scene(sawing.scene(), {cube()});
  ASSERT_TRUE(again.is_ok()) << again.error().message();
  EXPECT_EQ(again.value().scene(), sawing.scene());

  EXPECT_FALSE(Operation::open_scene("structure=bone\nlow=300", {}).is_ok());
  EXPECT_FALSE(Operation::open_scene("structur=bone", {cube()}).is_ok());
  const Surface hole{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {0, 1, 3}};
  const auto broken = Operation::open_scene("structure=bone\nlow=300\nhand=", {cube()}, {hole});
  ASSERT_FALSE(broken.is_ok());
  EXPECT_EQ(broken.error().where, "model 1");
}

/// A device moves the hand of an operation. Force and stiffness stay within the limits of the device.
TEST(OperationApi, ADeviceMovesAHand) {
  const scenes::Scratch scratch;
  const std::string path = scratch / "press.csv";
  std::ofstream(path) << "t,x,y,z\n0,0,-20,74\n0.2,0,-20,74\n0.5,0,-20,64.5\n1,0,-20,64.5\n";
  auto device = HandDevice::open("playback:" + path);
  ASSERT_TRUE(device.is_ok()) << device.error().message();
  EXPECT_EQ(device.value().capabilities().name, "playback");
  const auto most_force = [&](const std::vector<DeviceCapabilities>& devices) {
    OperationOptions options;
    options.devices = devices;
    auto operation = Operation::open("head", options);
    EXPECT_TRUE(operation.is_ok());
    double most = 0;
    for (int tick = 0; tick < 900; ++tick) {
      const auto pose = device.value().read(0.001 * tick);
      if (!pose) return -1.0;
      const auto touch = operation.value().step(*pose);
      if (!touch.is_ok()) return -2.0;
      device.value().write(touch.value());
      most = std::max(most, glm::length(touch.value().force_world));
    }
    return most;
  };
  const double free = most_force({});
  EXPECT_GT(free, 1.2);
  DeviceCapabilities weak;
  weak.max_force = 1, weak.max_stiffness = 0;
  EXPECT_NEAR(most_force({weak}), 1, 1e-9);
  DeviceCapabilities soft;
  soft.max_stiffness = 0.1;
  EXPECT_LT(most_force({soft}), 0.1 * 4);
  EXPECT_GT(most_force({soft}), 0.1 * 2);

  HandDevice moved = std::move(device).value();
  EXPECT_TRUE(moved.read(0));
  EXPECT_FALSE(device.value().read(0)) << "it was moved away";
  expect_error(HandDevice::open("mouse"), "needs a window", "mouse");
  expect_error(HandDevice::open("no-such-device"), "unknown device", "no-such-device");
}

TEST(OperationApi, RunsTheLinesOfTheReadme) {
  auto operation =
      trephine::Operation::open("head", {.hands = {{.instrument = "burr", .parameters = "diameter=4"}}})
          .value();
  trephine::Touch touch = operation.step({.position_world = {0, -20, 66}}).value();
  double removed = operation.removed_mm3();
  EXPECT_FALSE(touch.has_contact);  // the first position is free by definition
  EXPECT_EQ(removed, 0);
}

TEST(OperationApi, MovesAndOutlivesItsOptionsAndScan) {
  auto scan = cube();
  const std::weak_ptr<const Volume> watch = scan;
  std::optional<Operation> last;
  {
    Operation first = opened();
    drill(first, 0);
    Operation second = std::move(first);
    const double removed = second.removed_mm3();
    EXPECT_GT(removed, 5);
    first = std::move(second);
    drill(first, 4);
    EXPECT_GT(first.removed_mm3(), removed);
    auto from_scan = Operation::open(std::move(scan), with_burr());
    last = std::move(from_scan).value();
  }
  EXPECT_FALSE(watch.expired());
  drill(*last, 0);
  EXPECT_GT(last->removed_mm3(), 5);
  last.reset();
  EXPECT_TRUE(watch.expired());
}

TEST(OperationApi, ErrorsOfOpeningStateProblemAndRemedy) {
  expect_error(Operation::open("haed", with_burr()), "not", "");
  expect_error(Operation::open("missing/scan.mha", with_burr()), "not", "");
  OperationOptions options = with_burr();
  options.hands[0].instrument = "chisel";
  expect_error(Operation::open("head", options), "unknown instrument", "chisel");
  options = with_burr();
  options.hands[0].parameters = "diameter=400";
  EXPECT_FALSE(Operation::open(cube(), options).is_ok());
  options = with_burr();
  options.hands.clear();
  EXPECT_EQ(Operation::open("head", options).error().what, "the number of hands is out of range");
  options = with_burr();
  options.iso = 300, options.window = "100:200";
  EXPECT_EQ(Operation::open("head", options).error().what, "more than one shape was chosen");
  EXPECT_EQ(Operation::open(std::shared_ptr<const Volume>(), {}).error().what, "a volume is missing");
  EXPECT_FALSE(Operation::reopen("missing.session").is_ok());
  // Without Hounsfield units there is no default threshold for bone; the caller must choose it.
  auto plain = volume::copy_of(*cube());
  plain.value().is_hounsfield = false;
  const auto scan = std::make_shared<const Volume>(std::move(plain).value());
  EXPECT_FALSE(Operation::open(scan, with_burr()).is_ok());
  options = with_burr();
  options.iso = 300;
  auto result = Operation::open(scan, options);
  ASSERT_TRUE(result.is_ok());
  EXPECT_EQ(result.value().xray({}).error().what, "an X-ray needs Hounsfield units");
  ImagePlane plane;
  plane.columns = 0;
  EXPECT_FALSE(result.value().slice(plane).is_ok());
}

}  // namespace
}  // namespace trephine
