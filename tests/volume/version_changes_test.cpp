#include "volume/cuts/version_changes.h"

#include <cmath>
#include <gtest/gtest.h>
#include <random>

#include "volume/cuts/removal.h"

namespace trephine::volume {
namespace {

using glm::dvec3;

struct Cut {
  std::shared_ptr<const Volume> base;
  Version start;
  RemovalEditor editor;
};

Cut some_block(int frame, double burr) {
  glm::dmat3 sheared(0.0);
  sheared[0][0] = 0.5, sheared[1][1] = 0.6, sheared[2][2] = 2.5, sheared[2][1] = 0.3;
  const Frame frames[] = {Frame::from_spacing(dvec3(0), dvec3(0.5)).value(),
                          Frame::from_axes({1, 2, 3}, sheared).value()};
  auto base = std::make_shared<Volume>(make_volume({70, 60, frame == 0 ? 50 : 14}, frames[frame]).value());
  for (auto& x : base->voxels.span()) x = 1000;
  Version start = burr > 0 ? Version(base, CutLattice::for_burr(*base, burr).value()) : Version(base);
  Shape shape;
  shape.low = 300;
  RemovalEditor editor(std::make_shared<Version>(start), {Field(*base, shape)});
  return {base, start, std::move(editor)};
}

Sweep random_sweep(std::mt19937& random, const Volume& base) {
  std::uniform_real_distribution<double> share(-0.1, 1.1), radius(0.4, 3);
  const auto place = [&] {
    const double x = share(random), y = share(random), z = share(random);
    return base.frame.world_from_volume(dvec3(x, y, z) * dvec3(base.size));
  };
  const dvec3 a = place(), b = place();
  return {a, a + 0.2 * (b - a), radius(random), false};
}

// Versions that are restored from bytes alone, one after the other and over undos, have the contents and the
// ledger of the original versions. Further cuts of both give the same bits.
TEST(VersionChanges, ReproduceTheSameVersions) {
  for (const int frame : {0, 1})
    for (const double burr : {0.0, 1.5}) {
      SCOPED_TRACE(std::to_string(frame) + ", " + std::to_string(burr));
      Cut cut = some_block(frame, burr);
      std::mt19937 random(static_cast<unsigned>(frame) + 7);
      std::vector<std::shared_ptr<const Version>> versions{cut.editor.freeze()}, result;
      result.push_back(std::make_shared<Version>(cut.start));
      std::size_t bytes = 0, whole = 0;
      std::vector<std::string> all_changes;
      for (int i = 0; i < 16; ++i) {
        if (i % 7 == 6)
          cut.editor.reset(versions[random() % versions.size()]);
        else
          for (int k = 0; k < 4; ++k) cut.editor.remove(random_sweep(random, *cut.base));
        versions.push_back(cut.editor.freeze());
        const std::string changes = VersionChanges::encode(*versions[versions.size() - 2], *versions.back());
        auto back = VersionChanges::apply(*result.back(), changes);
        ASSERT_TRUE(back.is_ok()) << back.error().message();
        result.push_back(back.value());
        all_changes.push_back(changes);
        const Version &a = *versions.back(), &b = *result.back();
        ASSERT_EQ(a.content_hash(), b.content_hash()) << i;
        ASSERT_EQ(a.serial(), b.serial());
        ASSERT_EQ(a.brick_count(), b.brick_count());
        ASSERT_EQ(a.ledger().units_by_label, b.ledger().units_by_label);
        bytes += changes.size();
        whole += a.bytes();
      }
      EXPECT_LT(bytes, whole / 2);
      // Older versions are unchanged.
      for (std::size_t i = 0; i < result.size(); ++i)
        ASSERT_EQ(result[i]->content_hash(), versions[i]->content_hash());
      // Cut further, from the middle and from the end.
      for (const std::size_t from : {result.size() / 2, result.size() - 1}) {
        RemovalEditor on = cut.editor, on_made = cut.editor;
        on.reset(versions[from]);
        on_made.reset(result[from]);
        for (int k = 0; k < 10; ++k) {
          const Sweep sweep = random_sweep(random, *cut.base);
          ASSERT_EQ(on.remove(sweep).removed_units, on_made.remove(sweep).removed_units);
        }
        ASSERT_EQ(on.freeze()->content_hash(), on_made.freeze()->content_hash());
      }
      // Applies a list of all changes in one call, up to the end and up to the middle.
      for (const std::size_t to : {all_changes.size(), all_changes.size() / 2}) {
        const std::vector<std::string_view> changes(all_changes.begin(),
                                                    all_changes.begin() + static_cast<std::ptrdiff_t>(to));
        const auto back = VersionChanges::apply(cut.start, changes);
        ASSERT_TRUE(back.is_ok()) << back.error().message();
        EXPECT_EQ(back.value()->content_hash(), versions[to]->content_hash());
        EXPECT_EQ(back.value()->serial(), versions[to]->serial());
        EXPECT_EQ(back.value()->brick_count(), versions[to]->brick_count());
        EXPECT_EQ(back.value()->ledger().units_by_label, versions[to]->ledger().units_by_label);
      }
      // Applies a single change from the first to the last version.
      auto at_once = VersionChanges::apply(cut.start, VersionChanges::encode(cut.start, *versions.back()));
      ASSERT_TRUE(at_once.is_ok());
      EXPECT_EQ(at_once.value()->content_hash(), versions.back()->content_hash());
    }
}

TEST(VersionChanges, BrokenBytesAreRefusedOrGiveValidVersions) {
  Cut cut = some_block(0, 1.5);
  std::mt19937 random(3);
  for (int k = 0; k < 3; ++k) cut.editor.remove(random_sweep(random, *cut.base));
  const auto whole = cut.editor.freeze();
  const std::string changes = VersionChanges::encode(cut.start, *whole);
  for (std::size_t length = 0; length < changes.size(); length += 1 + changes.size() / 200)
    if (auto result = VersionChanges::apply(cut.start, changes.substr(0, length))) {
      // Bytes that end after a complete brick are valid, and give a version with fewer bricks.
      EXPECT_LT(result.value()->brick_count(), whole->brick_count()) << length;
    }
  for (int i = 0; i < 300; ++i) {
    std::string wrong = changes;
    wrong[random() % wrong.size()] = static_cast<char>(random());
    if (auto result = VersionChanges::apply(cut.start, wrong)) {
      // Every accepted version can be cut further, and no distance exceeds twice the band.
      RemovalEditor on = cut.editor;
      on.reset(result.value());
      on.remove(random_sweep(random, *cut.base));
      for (int x = 0; x < cut.base->size.x; ++x)
        EXPECT_LE(std::abs(result.value()->voxel_distance(x, 30, 25)), 2 * result.value()->band_mm());
    }
  }
}

}  // namespace
}  // namespace trephine::volume
