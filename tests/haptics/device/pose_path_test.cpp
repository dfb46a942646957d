#include "haptics/device/pose_path.h"

#include <gtest/gtest.h>
#include <sstream>

namespace trephine::haptics {
namespace {

Result<PosePath> read(const std::string& text) {
  std::istringstream in(text);
  return PosePath::read_csv(in, "path.csv");
}

TEST(PosePath, ReadsColumnsInAnyOrderAndSamplesLinearly) {
  const auto path = read("button,t,z,y,x\n1,0,3,2,1\n0,2,3,2,5\n");
  ASSERT_TRUE(path.is_ok());
  EXPECT_EQ(path.value().at(0.5).position_world, glm::dvec3(2, 2, 3));
  EXPECT_TRUE(path.value().at(0.5).is_pressed());
  EXPECT_FALSE(path.value().at(2).is_pressed());
  EXPECT_EQ(path.value().at(-1).position_world.x, 1);
  EXPECT_EQ(path.value().at(9).position_world.x, 5);
}

TEST(PosePath, WithoutAButtonColumnTheButtonIsPressedThroughout) {
  EXPECT_TRUE(read("t,x,y,z\r\n0,1,2,3\r\n").value().at(0).is_pressed());
}

TEST(PosePath, RoundTripsExactly) {
  const auto path =
      read("t,x,y,z,qx,qy,qz,qw,button\n0,0.1,1e-7,-3.25,0,0,0.6,0.8,1\n0.001,0.2,7,3,0,0,0,1,0\n").value();
  std::ostringstream out;
  path.write_csv(out);
  const auto again = read(out.str()).value();
  ASSERT_EQ(again.samples().size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(again.samples()[i].t, path.samples()[i].t);
    EXPECT_EQ(again.samples()[i].pose.position_world, path.samples()[i].pose.position_world);
    EXPECT_EQ(again.samples()[i].pose.orientation, path.samples()[i].pose.orientation);
    EXPECT_EQ(again.samples()[i].pose.is_pressed(), path.samples()[i].pose.is_pressed());
  }
}

TEST(PosePath, HasThirtyTwoButtonsAndFourAxes) {
  const std::string text =
      "t,x,y,z,buttons,axis1,axis2,axis3,axis4\n0,1,2,3,0,0,0,0,0\n1,1,2,3,4294967295,1,-1,0.5,0.1\n"
      "2,1,2,3,6,1,1,1,1\n";
  const auto path = read(text).value();
  EXPECT_FALSE(path.at(0).is_pressed());
  EXPECT_TRUE(path.at(1).is_pressed());
  EXPECT_EQ(path.at(1).buttons, 0xffffffffu);
  EXPECT_EQ(path.at(2).buttons, 6u);
  EXPECT_FALSE(path.at(2).is_pressed());
  EXPECT_EQ(path.at(0.5).axes, (std::array<float, 4>{0.5f, -0.5f, 0.25f, 0.05f}));
  std::ostringstream out;
  path.write_csv(out);
  const auto again = read(out.str()).value();
  for (const double t : {0.0, 1.0, 2.0}) {
    EXPECT_EQ(again.at(t).buttons, path.at(t).buttons);
    EXPECT_EQ(again.at(t).axes, path.at(t).axes);
  }
  for (const char* broken : {"t,x,y,z,buttons\n0,1,2,3,-1\n", "t,x,y,z,buttons\n0,1,2,3,1.5\n",
                             "t,x,y,z,buttons\n0,1,2,3,4294967296\n", "t,x,y,z,button\n0,1,2,3,2\n",
                             "t,x,y,z,button,buttons\n0,1,2,3,1,1\n", "t,x,y,z,axis1\n0,1,2,3,nan\n",
                             "t,x,y,z,axis5\n0,1,2,3,1\n", "t,x,y,z,axis2\n0,1,2,3,1e9\n"})
    EXPECT_FALSE(read(broken).is_ok()) << broken;
}

TEST(PosePath, ServoTimesIncludeTheLastTimeOnce) {
  const auto path = read("t,x,y,z\n0.5,0,0,0\n1.5,1,0,0\n").value();
  const auto times = servo_times(path, 1000);
  EXPECT_EQ(times.size(), 1001u);
  EXPECT_EQ(times.front(), 0.5);
  EXPECT_EQ(times.back(), 1.5);
  const auto odd = servo_times(path, 300.7);
  EXPECT_EQ(odd.back(), 1.5);
  for (std::size_t i = 1; i < odd.size(); ++i) EXPECT_GT(odd[i], odd[i - 1]);
}

TEST(PosePath, EveryFaultIsReportedWithItsLocation) {
  const std::pair<const char*, const char*> faults[] = {
      {"", "empty"},
      {"t,x,y\n0,1,2\n", "no column z"},
      {"t,x,y,z,qx\n0,1,2,3,0\n", "part of a quaternion"},
      {"t,x,y,z,w\n", "unknown"},
      {"t,t,x,y,z\n", "repeated"},
      {"t,x,y,z\n", "no samples"},
      {"t,x,y,z\n0,1,2\n", "line 2"},
      {"t,x,y,z\n0,1,2,nan\n", "column z"},
      {"t,x,y,z\n0,1,2,3\n0,1,2,3\n", "not increasing"},
      {"t,x,y,z\n0,1,2,3\n-1,1,2,3\n", "line 3"},
      {"t,x,y,z\n0,1,2,3e9\n", "out of range"},
      {"t,x,y,z,button\n0,1,2,3,2\n", "button"},
      {"t,x,y,z,qx,qy,qz,qw\n0,1,2,3,0,0,0,0\n", "invalid orientation"},
      {"t,x,y,z\n0,1,2,3x\n", "3x"},
  };
  for (const auto& [text, word] : faults) {
    const auto path = read(text);
    ASSERT_FALSE(path.is_ok()) << text;
    EXPECT_NE(path.error().message().find(word), std::string::npos) << path.error().message();
    EXPECT_NE(path.error().message().find("path.csv"), std::string::npos);
  }
}

}  // namespace
}  // namespace trephine::haptics
