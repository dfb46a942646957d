// VoxelImages, the images of a volume from six sides: compared with rows that are read voxel by voxel, after
// cuts and their undo, and compared with images that contain every layer.
#include "apps/bench/voxel_images.h"

#include <gtest/gtest.h>

#include "apps/bench/scenes/scenes.h"
#include "haptics/depth/depth_cube.h"
#include "volume/base/deterministic_math.h"
#include "volume/cuts/removal.h"

namespace trephine::haptics::depth {
namespace {

using bench::VoxelImages;
using glm::dvec3;
using glm::ivec3;

data_tools::PhantomOptions odd_size() {
  data_tools::PhantomOptions o;
  o.size = {70, 61, 37};  // words of 64 bits are partly filled; slices are 2.5 pixels thick
  o.spacing_mm = {0.6, 0.6, 1.5};
  return o;
}

long differences(const VoxelImages& images, const volume::SurfaceSource& source) {
  long wrong = 0;
  const volume::VoxelSamples samples(source);
  const ivec3 size = images.size();
  for (int axis = 0; axis < 3; ++axis) {
    const auto [u, v] = across(axis);
    for (int j = 0; j < size[v]; ++j)
      for (int i = 0; i < size[u]; ++i) {
        int ends[2] = {-1, -1};
        ivec3 at(0);
        at[u] = i, at[v] = j;
        for (at[axis] = 0; at[axis] < size[axis]; ++at[axis]) {
          if (!samples.is_solid(at)) continue;
          if (ends[0] < 0) ends[0] = at[axis];
          ends[1] = at[axis];
        }
        for (const bool from_high : {false, true}) {
          wrong += images.first(axis, from_high, i, j) != ends[from_high];
          if (ends[from_high] < 0) continue;
          ivec3 in(at), air(at);
          in[axis] = ends[from_high], air[axis] = in[axis] + (from_high ? 1 : -1);
          const bool is_within = air[axis] >= 0 && air[axis] < size[axis];
          const float far = is_within ? samples.crossing(in, air) : 0.5f;
          wrong += images.surface(axis, from_high, i, j) !=
                   static_cast<float>(in[axis]) + (from_high ? far : -far);
        }
      }
  }
  return wrong;
}

TEST(VoxelImages, ShowTheFirstVoxelOfEachRowThroughCutsAndUndo) {
  const TouchScene scene = scenes::phantom_scene("gyroid", odd_size());
  const TouchItem& shape = scene.items[0];
  auto version = std::make_shared<const volume::Version>(
      scene.base, volume::CutLattice::for_burr(*scene.base, 3).value());
  volume::RemovalEditor editor(version, solids_of(scene));
  std::vector<std::shared_ptr<const volume::Version>> before{version};
  std::vector<volume::VoxelBox> boxes;
  const auto source = [&](const volume::Version& of) {
    return volume::SurfaceSource{&shape.field, &of, shape.bits.get()};
  };
  VoxelImages images(source(*version));
  EXPECT_EQ(differences(images, source(*version)), 0);
  std::size_t most = 0;
  for (std::uint64_t n = 0; n < 12; ++n) {
    const auto number = [&](std::uint64_t k) {
      return static_cast<double>(hash_bits(8 * n + k) >> 11) * 0x1p-53;
    };
    const dvec3 at =
        scene.base->frame.world_from_volume(dvec3(scene.base->size) * dvec3(number(0), number(1), number(2)));
    const volume::RemovalReport cut = editor.remove({at, at, 1.5 + 5 * number(3)});
    version = editor.freeze();
    before.push_back(version), boxes.push_back(cut.box);
    if (cut.box.low.x > cut.box.high.x) continue;
    images.update(source(*version), cut.box);
    most = std::max(most, images.query_count());
    ASSERT_EQ(differences(images, source(*version)), 0) << n;
  }
  EXPECT_GT(most, 100u);
  EXPECT_LT(most, static_cast<std::size_t>(scene.base->size.x) *
                      static_cast<std::size_t>(scene.base->size.y) *
                      static_cast<std::size_t>(scene.base->size.z) / 2);
  // Undo: matter grows.
  for (std::size_t n = boxes.size(); n-- > 0;) {
    if (boxes[n].low.x > boxes[n].high.x) continue;
    images.update(source(*before[n]), boxes[n]);
    ASSERT_EQ(differences(images, source(*before[n])), 0) << n;
  }
  // Planted fault: an image that is not updated is detected.
  const dvec3 middle = scene.base->frame.world_from_volume(0.5 * dvec3(scene.base->size));
  editor.remove({middle, middle + dvec3(30, 0, 0), 20});
  EXPECT_GT(differences(images, source(*editor.freeze())), 0);
}

TEST(VoxelImages, AgreeWithTheImagesOfEveryLayer) {
  const TouchScene scene = scenes::phantom_scene("gyroid", odd_size());
  const TouchItem& shape = scene.items[0];
  const VoxelImages images({&shape.field, nullptr, shape.bits.get()});
  const DepthCube cube = DepthCube::of_voxels(shape.field, *shape.bits, ivec3(1)).value();
  long seen = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const auto [u, v] = across(axis);
    for (int j = 0; j < images.size()[v]; ++j)
      for (int i = 0; i < images.size()[u]; ++i) {
        const auto layers = cube.ray(axis, i + 1, j + 1);  // its lattice begins one voxel earlier
        ASSERT_EQ(layers.empty(), images.first(axis, false, i, j) < 0);
        if (layers.empty()) continue;
        ++seen;
        EXPECT_NEAR(layers.front() - 1, images.surface(axis, false, i, j), 1e-4);
        EXPECT_NEAR(layers.back() - 1, images.surface(axis, true, i, j), 1e-4);
      }
  }
  EXPECT_GT(seen, 1000);
}

}  // namespace
}  // namespace trephine::haptics::depth
