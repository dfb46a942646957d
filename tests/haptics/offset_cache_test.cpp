// OffsetCache: fields of tools that are taken again.
#include "haptics/scene/offset_cache.h"

#include <gtest/gtest.h>
#include <thread>

#include "apps/bench/scenes/scenes.h"
#include "volume/base/work_counters.h"

namespace trephine::haptics {
namespace {

TouchScene plate() {
  data_tools::PhantomOptions o;
  o.size = glm::ivec3(48);
  o.spacing_mm = glm::dvec3(0.5);
  o.parameters = {{"thickness", 8}, {"angle", 0}};
  return scenes::phantom_scene("plate", o);
}
long builds() { return work_counters().offset_fields.load(); }

TEST(OffsetCache, AFieldIsBuiltOncePerRadius) {
  TouchScene scene = plate();
  scene.offset_cache = std::make_shared<OffsetCache>(std::size_t{1} << 30);
  const long before = builds();
  ASSERT_FALSE(set_tool_radius(scene, 2));
  const auto field = scene.items[0].offset;
  TouchScene copy = scene;
  ASSERT_FALSE(set_tool_radius(copy, 1));
  ASSERT_FALSE(set_tool_radius(copy, 2));
  EXPECT_EQ(copy.items[0].offset, field);
  EXPECT_EQ(builds(), before + 2);
  // Another solid has its own field.
  TouchScene other = plate();
  other.offset_cache = scene.offset_cache;
  ASSERT_FALSE(set_tool_radius(other, 2));
  EXPECT_NE(other.items[0].offset, field);
  // Without a cache, each tool is built.
  TouchScene single = plate();
  ASSERT_FALSE(set_tool_radius(single, 2));
  ASSERT_FALSE(set_tool_radius(single, 2));
  EXPECT_EQ(builds(), before + 5);
}

TEST(OffsetCache, TheOldestFieldsAreRemoved) {
  TouchScene scene = plate();
  OffsetCache probe(std::size_t{1} << 30);
  const std::size_t bytes = probe.field(scene.items[0], 2).value()->bytes();
  OffsetCache cache(2 * bytes + bytes / 2);  // for two fields of about this size
  const auto first = cache.field(scene.items[0], 2).value();
  EXPECT_TRUE(cache.field(scene.items[0], 2.1));
  EXPECT_EQ(cache.field(scene.items[0], 2).value(), first);
  EXPECT_TRUE(cache.field(scene.items[0], 2.2));  // removes that of 2.1 mm, which was not used for longest
  EXPECT_EQ(cache.field(scene.items[0], 2).value(), first);
  const long before = builds();
  EXPECT_TRUE(cache.field(scene.items[0], 2.1));
  EXPECT_EQ(builds(), before + 1);
  // One field is kept even if it is larger than the memory.
  OffsetCache small(1);
  const auto only = small.field(scene.items[0], 2).value();
  EXPECT_EQ(small.field(scene.items[0], 2).value(), only);
}

TEST(OffsetCache, ThreadsWaitForTheSameField) {
  const TouchScene scene = plate();
  OffsetCache cache(std::size_t{1} << 30);
  const long before = builds();
  std::array<OffsetCache::SharedField, 6> fields;
  {
    std::vector<std::jthread> threads;
    for (auto& field : fields)
      threads.emplace_back([&] { field = cache.field(scene.items[0], 1.5).value(); });
  }
  for (const auto& field : fields) EXPECT_EQ(field, fields[0]);
  EXPECT_EQ(builds(), before + 1);
}

TEST(OffsetCache, ACancelledFieldIsBuiltByTheNextCaller) {
  TouchScene scene = plate();
  scene.offset_cache = std::make_shared<OffsetCache>(std::size_t{1} << 30);
  const std::atomic<bool> is_cancelled = true;
  prepare_offsets(scene, 2, is_cancelled);
  EXPECT_FALSE(scene.offset_cache->field(scene.items[0], 2, 0, &is_cancelled));
  const auto field = scene.offset_cache->field(scene.items[0], 2);
  ASSERT_TRUE(field);
  EXPECT_GT(field.value()->bytes(), 0u);
  // An invalid radius is an error for each caller.
  EXPECT_FALSE(scene.offset_cache->field(scene.items[0], -1));
  EXPECT_FALSE(scene.offset_cache->field(scene.items[0], -1));
}

}  // namespace
}  // namespace trephine::haptics
