#include "volume/version_changes.h"

#include <cmath>
#include <gtest/gtest.h>
#include <random>

#include "volume/removal.h"

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

// From version to version, over undos, by bytes alone: the same contents, the same ledger, and whoever cuts
// on comes to the same bits.
TEST(VersionChanges, LeadToTheSameVersions) {
  for (const int frame : {0, 1})
    for (const double burr : {0.0, 1.5}) {
      SCOPED_TRACE(std::to_string(frame) + ", " + std::to_string(burr));
      Cut cut = some_block(frame, burr);
      std::mt19937 random(static_cast<unsigned>(frame) + 7);
      std::vector<std::shared_ptr<const Version>> versions{cut.editor.freeze()}, made;
      made.push_back(std::make_shared<Version>(cut.start));
      std::size_t bytes = 0, whole = 0;
      std::vector<std::string> all_told;
      for (int i = 0; i < 16; ++i) {
        if (i % 7 == 6)
          cut.editor.reset(versions[random() % versions.size()]);
        else
          for (int k = 0; k < 4; ++k) cut.editor.remove(random_sweep(random, *cut.base));
        versions.push_back(cut.editor.freeze());
        const std::string told = VersionChanges::between(*versions[versions.size() - 2], *versions.back());
        auto back = VersionChanges::applied(*made.back(), told);
        ASSERT_TRUE(back.is_ok()) << back.error().message();
        made.push_back(back.value());
        all_told.push_back(told);
        const Version &a = *versions.back(), &b = *made.back();
        ASSERT_EQ(a.content_hash(), b.content_hash()) << i;
        ASSERT_EQ(a.serial(), b.serial());
        ASSERT_EQ(a.brick_count(), b.brick_count());
        ASSERT_EQ(a.ledger().units_by_label, b.ledger().units_by_label);
        bytes += told.size();
        whole += a.bytes();
      }
      EXPECT_LT(bytes, whole / 2);
      // The older ones stay as they were.
      for (std::size_t i = 0; i < made.size(); ++i)
        ASSERT_EQ(made[i]->content_hash(), versions[i]->content_hash());
      // Cut on, from the middle and from the end.
      for (const std::size_t from : {made.size() / 2, made.size() - 1}) {
        RemovalEditor on = cut.editor, on_made = cut.editor;
        on.reset(versions[from]);
        on_made.reset(made[from]);
        for (int k = 0; k < 10; ++k) {
          const Sweep sweep = random_sweep(random, *cut.base);
          ASSERT_EQ(on.remove(sweep).removed_units, on_made.remove(sweep).removed_units);
        }
        ASSERT_EQ(on.freeze()->content_hash(), on_made.freeze()->content_hash());
      }
      // All that was told, to the end and into the middle.
      for (const std::size_t to : {all_told.size(), all_told.size() / 2}) {
        const std::vector<std::string_view> told(all_told.begin(),
                                                 all_told.begin() + static_cast<std::ptrdiff_t>(to));
        const auto back = VersionChanges::applied(cut.start, told);
        ASSERT_TRUE(back.is_ok()) << back.error().message();
        EXPECT_EQ(back.value()->content_hash(), versions[to]->content_hash());
        EXPECT_EQ(back.value()->serial(), versions[to]->serial());
        EXPECT_EQ(back.value()->brick_count(), versions[to]->brick_count());
        EXPECT_EQ(back.value()->ledger().units_by_label, versions[to]->ledger().units_by_label);
      }
      // All of it at once.
      auto at_once = VersionChanges::applied(cut.start, VersionChanges::between(cut.start, *versions.back()));
      ASSERT_TRUE(at_once.is_ok());
      EXPECT_EQ(at_once.value()->content_hash(), versions.back()->content_hash());
    }
}

TEST(VersionChanges, BrokenBytesAreRefused) {
  Cut cut = some_block(0, 1.5);
  std::mt19937 random(3);
  for (int k = 0; k < 3; ++k) cut.editor.remove(random_sweep(random, *cut.base));
  const auto whole = cut.editor.freeze();
  const std::string told = VersionChanges::between(cut.start, *whole);
  for (std::size_t length = 0; length < told.size(); length += 1 + told.size() / 200)
    if (auto made = VersionChanges::applied(cut.start, told.substr(0, length))) {
      EXPECT_LT(made.value()->brick_count(), whole->brick_count()) << length;  // cut where a brick ends
    }
  for (int i = 0; i < 300; ++i) {
    std::string wrong = told;
    wrong[random() % wrong.size()] = static_cast<char>(random());
    if (auto made = VersionChanges::applied(cut.start, wrong)) {
      // Whatever it holds can be cut on, and nowhere is a distance beyond the band.
      RemovalEditor on = cut.editor;
      on.reset(made.value());
      on.remove(random_sweep(random, *cut.base));
      for (int x = 0; x < cut.base->size.x; ++x)
        EXPECT_LE(std::abs(made.value()->distance_at(x, 30, 25)), 2 * made.value()->band_mm());
    }
  }
}

}  // namespace
}  // namespace trephine::volume
