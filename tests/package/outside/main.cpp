// Uses the libraries volume and haptics alone, without trephine::trephine, in a project outside the source
// tree: a volume, and a device that plays a path.
#include <cstdio>
#include <sstream>

#include "haptics/device/device.h"
#include "volume/scan/shape.h"

int main() {
  using namespace trephine;
  auto frame = volume::Frame::from_spacing({-8, -8, -8}, {0.5, 0.5, 0.5});
  auto scan = volume::make_volume(glm::ivec3(32), frame.value());
  if (!scan) return 2;
  for (std::size_t i = 0; i < scan.value().voxels.size(); ++i)
    scan.value().voxels[i] = i < scan.value().voxels.size() / 2 ? 1200 : -1000;
  const volume::Shape bone;
  std::istringstream csv("t,x,y,z\n0,0,0,4\n1,0,0,-4\n");
  auto path = haptics::PosePath::read_csv(csv, "path");
  if (!path) return 3;
  haptics::PlaybackDevice device(std::move(path).value());
  int solid = 0;
  for (int tick = 0; tick <= 1000; ++tick) {
    haptics::Pose pose;
    if (!device.read(1e-3 * tick, pose)) return 4;
    const glm::ivec3 voxel(scan.value().frame.volume_from_world(pose.position_world) + 0.5);
    solid += bone.is_solid(scan.value().voxels[scan.value().index(voxel.x, voxel.y, voxel.z)]);
  }
  std::printf("in bone for %d ms of 1000\n", solid);
  return solid > 450 && solid < 550 ? 0 : 1;
}
