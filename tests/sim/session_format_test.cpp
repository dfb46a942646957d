// Format of session files, item by item and line by line.
#include "sim/session/session_format.h"

#include <cstring>
#include <random>

#include "tests/sim/session_fixture.h"

namespace trephine::sim {
namespace {

TEST(SessionFormat, HeadersRoundTripThroughText) {
  Bench bench;
  SessionHeader h = bench.header(2000);
  h.case_name = "a name\nwith a break";
  h.structures[0].shape.high = 1234.5;
  h.hands.emplace_back();
  describe(drilling_catalogue(), h);
  const auto back = decode_header(encode(h));
  ASSERT_TRUE(back.is_ok());
  EXPECT_EQ(back.value().case_name, "a name with a break");
  EXPECT_EQ(back.value().structures[0].shape.low, h.structures[0].shape.low);
  EXPECT_EQ(back.value().structures[0].shape.high, 1234.5);
  EXPECT_EQ(back.value().hands.size(), 2u);
  EXPECT_EQ(back.value().hands[0].instrument, "burr");
  EXPECT_EQ(back.value().hands[0].parameters, h.hands[0].parameters);
  ASSERT_EQ(back.value().types.size(), h.types.size());
  for (std::size_t i = 0; i < h.types.size(); ++i) {
    EXPECT_EQ(back.value().types[i].name, h.types[i].name);
    EXPECT_EQ(back.value().types[i].version, h.types[i].version);
    EXPECT_EQ(back.value().types[i].fields, h.types[i].fields);
  }
  ASSERT_EQ(back.value().modules.size(), 1u);
  EXPECT_EQ(back.value().modules[0].name, "drilling");
  EXPECT_EQ(back.value().rate_hz, 2000);
  EXPECT_FALSE(decode_header("surprise=1\n" + encode(h)).is_ok());
  EXPECT_FALSE(decode_header("rate=nan\n" + encode(h)).is_ok());
  EXPECT_FALSE(decode_header("").is_ok());
}

// Inputs round-trip to the bit for any value. Forces are outputs: each component is rounded to 1/1024 N.
TEST(SessionFormat, KeepsInputsExactlyAndForcesToHalfAMillinewton) {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> along(-100, 100);
  const double odd[] = {0.0,    -0.0,    1e-300,   -1e9, 0x1p52, std::numeric_limits<double>::infinity(),
                        1e300,  0x1p-20, -0x1p-21, 1e6,  0.1,    std::numeric_limits<double>::quiet_NaN(),
                        5e-324, 0x1p32,  -0x1p60,  3.5};
  std::vector<haptics::ServoRecord> records;
  ItemEncoder encoder({});
  haptics::Pose pose;
  for (int i = 0; i < 3000; ++i) {
    haptics::ServoRecord r;
    r.tick = static_cast<std::uint64_t>(i) + (i > 1500 ? 1'000'000'000'000u : 0);
    const bool is_odd = random() % 7 == 0;
    for (int a = 0; a < 3; ++a) {
      pose.position_world[a] = is_odd ? odd[random() % std::size(odd)] : pose.position_world[a] + 0.01;
      r.force_world[a] = random() % 3 == 0 ? along(random) / 20 : 0;
    }
    if (random() % 5 == 0)
      pose.orientation.x = random() % 2 == 0 ? along(random) : odd[random() % std::size(odd)];
    r.pose = random() % 2 == 0 ? haptics::rounded_to_grid(pose) : pose;
    r.version = random() % 9 == 0 ? random() : records.empty() ? 0 : records.back().version;
    r.has_contact = random() % 2 == 0;
    encoder.add(r);
    records.push_back(r);
  }
  const std::string bytes = encoder.fetch_bytes();
  ItemDecoder decoder(bytes, {});
  for (const haptics::ServoRecord& r : records) {
    const auto item = decoder.next();
    ASSERT_TRUE(item.is_ok());
    const haptics::ServoRecord& back = std::get<TickItem>(item.value()).record;
    ASSERT_EQ(back.tick, r.tick);
    ASSERT_EQ(back.version, r.version);
    ASSERT_EQ(back.has_contact, r.has_contact);
    ASSERT_EQ(std::memcmp(&back.pose.position_world, &r.pose.position_world, sizeof(dvec3)), 0) << r.tick;
    ASSERT_EQ(std::memcmp(&back.pose.orientation, &r.pose.orientation, sizeof(glm::dquat)), 0) << r.tick;
    ASSERT_LE(glm::length(back.force_world - r.force_world), 0x1p-10);
  }
  EXPECT_TRUE(decoder.is_at_end());
}

// Drilling and sliding, with encoder noise and a stylus that turns.
TEST(SessionFormat, ATickTakesAtMost25BytesOnAverage) {
  const Folder folder;
  const std::string path = folder.file("a.session");
  Bench bench;
  auto writer = bench.writer(path);
  // First it drills, then it slides.
  std::vector<haptics::PosePath::Sample> samples = drilling_path(10).samples();
  for (double t = 10; t < 21; t += 0.05)
    samples.push_back({t, {{5 * std::sin(4 * t), 4 * std::cos(3 * t), 1.2}, {1, 0, 0, 0}, false}});
  haptics::VirtualDevice device(haptics::PosePath::from_samples(samples, "test").value(), {});
  ASSERT_FALSE(device.open());
  Lockstep run(bench.scene, bench.method, drilling::burr(k_burr), {}, 1000, writer.get());
  std::mt19937 random(2);
  std::normal_distribution<double> noise(0, 2e-4);
  double contacts = 0, cut = 0;
  constexpr int k_ticks = 20'000;
  for (int i = 0; i < k_ticks; ++i) {
    haptics::Pose pose;
    ASSERT_TRUE(device.read(1e-3 * i, pose));
    const double turn = 0.3 * std::sin(2e-3 * i), w = std::cos(turn), x = std::sin(turn) + noise(random);
    const double y = noise(random), z = noise(random);
    pose.orientation = glm::normalize(glm::dquat(w, x, y, z));
    const haptics::ServoRecord r = run.step(pose);
    device.write(r.force_world);
    contacts += r.has_contact;
    cut += run.last_outcome().is_changed;
  }
  EXPECT_FALSE(writer->finish(run.engine()));
  const double bytes = static_cast<double>(fs::file_size(path)) / k_ticks;
  EXPECT_GT(contacts, 0.4 * k_ticks);
  EXPECT_GT(cut, 0.08 * k_ticks);
  EXPECT_LE(bytes, 25);
  RecordProperty("bytes", std::to_string(bytes));
  std::printf("%.1f bytes per tick\n", bytes);
  expect_same(replay(path));
}

TEST(SessionFormat, KeepsButtonsAndAxesOfEveryHand) {
  std::mt19937 random(8);
  std::vector<haptics::ServoRecord> records;
  ItemEncoder encoder({});
  std::array<haptics::Pose, 2> poses;
  for (int i = 0; i < 400; ++i)
    for (std::uint8_t hand = 0; hand < 2; ++hand) {
      haptics::Pose& pose = poses[hand];
      if (random() % 5 == 0)
        pose.buttons = static_cast<std::uint32_t>(random() % 3 == 0 ? random() : random() % 2);
      if (random() % 7 == 0) pose.axes[random() % 4] = 0.25f * static_cast<float>(random() % 5);
      haptics::ServoRecord record;
      record.tick = static_cast<std::uint64_t>(i);
      record.hand = hand;
      record.pose = pose;
      encoder.add(record);
      records.push_back(record);
    }
  const std::string bytes = encoder.fetch_bytes();
  ItemDecoder decoder(bytes, {});
  for (const haptics::ServoRecord& record : records) {
    const auto item = decoder.next();
    ASSERT_TRUE(item.is_ok());
    const haptics::ServoRecord& read = std::get<TickItem>(item.value()).record;
    ASSERT_EQ(read.hand, record.hand);
    ASSERT_EQ(read.pose.buttons, record.pose.buttons);
    ASSERT_EQ(read.pose.axes, record.pose.axes);
  }
  EXPECT_TRUE(decoder.is_at_end());
  // Contradictory bytes: the first button is both pressed and released.
  haptics::ServoRecord second_button;
  second_button.pose.buttons = 2;
  encoder.add(second_button);
  std::string contradictory = encoder.fetch_bytes();
  EXPECT_TRUE(ItemDecoder(contradictory, {}).next().is_ok());
  contradictory[0] = static_cast<char>(contradictory[0] ^ 8);
  EXPECT_FALSE(ItemDecoder(contradictory, {}).next().is_ok());
}

}  // namespace
}  // namespace trephine::sim
