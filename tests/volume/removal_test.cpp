// RemovalEditor against a brute-force twin: distances, kept bits, masks and ledger; channels of versions.
// One file: all tests use the same editor.
#include "volume/cuts/removal.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <limits>
#include <numbers>
#include <random>
#include <thread>

#include "volume/base/channel.h"
#include "volume/cuts/removal_kernels.h"
#include "volume/scan/occupancy.h"
#include "volume/surface/surface_nets.h"

namespace trephine::volume {
namespace {

std::shared_ptr<Volume> block(const glm::ivec3& size, const Frame& frame) {
  auto v = std::make_shared<Volume>(make_volume(size, frame).value());
  for (auto& x : v->voxels.span()) x = 1000;
  return v;
}

double capsule_distance(const glm::dvec3& p, const Sweep& s) {
  const glm::dvec3 ab = s.end_world - s.start_world;
  const double l2 = glm::dot(ab, ab);
  const double t = l2 > 0 ? std::clamp(glm::dot(p - s.start_world, ab) / l2, 0.0, 1.0) : 0.0;
  return glm::length(p - s.start_world - t * ab) - s.radius_mm;
}

std::vector<Frame> frames() {
  glm::dmat3 sheared(0.0);
  sheared[0][0] = 0.5, sheared[1][1] = 0.6, sheared[2][2] = 0.9, sheared[2][1] = 0.3;
  return {Frame(), Frame::from_spacing({5, -3, 2}, {0.48, 0.48, 1.25}).value(),
          Frame::from_axes({1, 2, 3}, sheared).value()};
}

/// Returns the allowance by which distances are below the distance to the ball
/// (docs/decisions/0012-cut-lattice.md): 3/16 h^2 / r, at most 2 % of r. h^2 is the mean square of the
/// lattice's spacings.
double documented_allowance(double radius, const Frame& lattice) {
  const glm::dvec3& h = lattice.spacing();
  return std::min(3.0 / 16 * glm::dot(h, h) / 3 / radius, 0.02 * radius);
}

/// Returns the position of a point of a cell, in lattice steps from the cell's sample
/// (docs/decisions/0012-cut-lattice.md). The points of each cell are shifted by a fraction of their step,
/// which follows from a table of integers.
glm::dvec3 documented_offset(const glm::ivec3& sample, int point, int n) {
  const int table[9] = {237, 499, 327, 247, 59, 631, 709, 861, 993};
  const int in_cell[3] = {point % n, point / n % n, point / (n * n)};
  glm::dvec3 offset;
  for (int a = 0; a < 3; ++a) {
    const int turn =
        (table[3 * a] * sample.x + table[3 * a + 1] * sample.y + table[3 * a + 2] * sample.z) & 1023;
    offset[a] = (in_cell[a] + (turn + 0.5) / 1024) / n - 0.5;
  }
  return offset;
}

struct BruteForceCase {
  Frame frame;
  glm::ivec3 size;
  double radius;
  double smallest_burr;  ///< mm; 0: the lattice has one sample per voxel
};

// Compares distances, kept bits, masks and the ledger with a brute force over every sample and point in
// double precision.
void expect_brute_force(const BruteForceCase& c) {
  const Frame& frame = c.frame;
  const auto base = block(c.size, frame);
  // Part of the block is not bone; the surface crosses cells.
  for (int z = 0; z < c.size.z; ++z)
    for (int y = 0; y < c.size.y; ++y)
      for (int x = 0; x < c.size.x; ++x)
        base->voxels[base->index(x, y, z)] = static_cast<std::int16_t>(1000 - 41 * x - 13 * y);
  const Field field(*base, Shape{});
  const CutLattice lattice =
      c.smallest_burr > 0 ? CutLattice::for_burr(*base, c.smallest_burr).value() : CutLattice(*base);
  RemovalEditor editor(std::make_shared<Version>(base, lattice), {field});
  std::vector<Sweep> sweeps;
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> share(-0.1, 0.9);
  const glm::dvec3 extent(c.size);
  glm::dvec3 at = frame.world_from_volume(0.4 * extent);
  for (int i = 0; i < 5; ++i) {
    const glm::dvec3 to =
        frame.world_from_volume(glm::dvec3{share(random), share(random), share(random)} * extent);
    sweeps.push_back({at, to, c.radius, i > 0});
    at = to;
  }
  std::int64_t units = 0;
  for (const Sweep& s : sweeps) units += editor.remove(s).removed_units;
  const auto version = editor.publish();
  EXPECT_EQ(version->ledger().total(), units);

  const double allowance = documented_allowance(c.radius, lattice.frame());
  std::int64_t expected_units = 0;
  long disagreements = 0;
  for (int z = 0; z < lattice.size().z; ++z)
    for (int y = 0; y < lattice.size().y; ++y)
      for (int x = 0; x < lattice.size().x; ++x) {
        const glm::ivec3 sample(x, y, z);
        const glm::dvec3 p = lattice.frame().world_from_volume(sample);
        double d = 1e9;
        for (const Sweep& s : sweeps) d = std::min(d, capsule_distance(p, s));
        d -= allowance;
        const double clamped = std::clamp(d, -version->band_mm(), version->band_mm());
        ASSERT_NEAR(version->sample_distance(sample), clamped, 2e-5);
        const Brick* brick = version->brick_at(sample);
        if (std::abs(d) > 1e-5) {
          ASSERT_EQ(brick == nullptr || brick->is_kept(x & 7, y & 7, z & 7), d > 0);
        }
        const RemovalMask* mask = brick ? brick->mask.get() : nullptr;
        const int n = mask ? mask->n : 4;
        if (d > 2 * version->band_mm() && !mask) continue;
        for (int s = 0; s < n * n * n; ++s) {
          const glm::dvec3 in_lattice = glm::dvec3(sample) + documented_offset(sample, s, n),
                           q = lattice.frame().world_from_volume(in_lattice);
          double e = 1e9;
          for (const Sweep& sweep : sweeps) e = std::min(e, capsule_distance(q, sweep));
          const bool is_removed = (brick && brick->is_hollow) ||
                                  (mask && (mask->words[Brick::index(x & 7, y & 7, z & 7) *
                                                            static_cast<std::size_t>(mask->words_per_cell()) +
                                                        static_cast<std::size_t>(s / 64)] >>
                                                (s % 64) &
                                            1));
          if (is_removed != (e <= 0)) {
            ++disagreements;
            // Points on the surface may differ, since masks are computed in single precision up to 30 mm from
            // the start of a sweep.
            ASSERT_LT(std::abs(e), 1e-4);
          }
          const glm::dvec3 in_volume = lattice.volume_from_lattice(in_lattice);
          if (is_removed && base->contains(lattice.voxel_of(sample)) && field.value(in_volume) >= 0)
            expected_units += RemovalLedger::k_units_per_cell / (n * n * n);
        }
      }
  EXPECT_EQ(units, expected_units);
  EXPECT_LT(disagreements, 30);
  EXPECT_GT(units, 1000);
}

/// Sweeps along rows of the grid and oblique to them, with the smallest burr for which this lattice suffices
/// (4.5 samples per radius) and with one of twice its radius.
TEST(Removal, VolumesAreTheCapsulesInEveryDirection) {
  const auto base = block({64, 64, 64}, Frame());
  const Field field(*base, Shape{});
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> share(0, 1);
  for (const double radius : {4.5, 9.0})
    for (const glm::dvec3& way :
         {glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 0), glm::dvec3(0, 0, 1), glm::dvec3(1, 1, 0),
          glm::dvec3(0, 1, -1), glm::dvec3(1, 1, 1), glm::dvec3(1, 0.02, 0), glm::dvec3(3, -2, 1.5)}) {
      const glm::dvec3 along = glm::normalize(way);
      const double length = 24;
      const glm::dvec3 start =
          31.5 - 0.5 * length * along + glm::dvec3{share(random), share(random), share(random)};
      RemovalEditor editor(std::make_shared<Version>(base), {field});
      editor.remove({start, start + length * along, radius});
      const double exact = std::numbers::pi * radius * radius * (length + 4.0 / 3 * radius);
      const auto version = editor.publish();
      EXPECT_NEAR(version->mm3_of(version->ledger().total()) / exact, 1, 1e-3)
          << radius << " " << way.x << " " << way.y << " " << way.z;
    }
}

/// Bias, spread and largest error of the removed volume for capsules at random positions in random
/// directions, and for single balls (docs/decisions/0012-cut-lattice.md).
TEST(Removal, VolumesOfRandomCapsulesSpreadLittle) {
  const auto base = block({40, 40, 40}, Frame());
  const Field field(*base, Shape{});
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> share(-0.5, 0.5);
  double worst = 0;
  for (const double radius : {4.5, 5.0, 7.0, 8.0, 9.0})
    for (const double length : {0.0, 3.0, 12.0}) {
      const int count = 100;
      double sum = 0, squares = 0;
      for (int i = 0; i < count; ++i) {
        const auto any = [&] { return glm::dvec3{share(random), share(random), share(random)}; };
        const glm::dvec3 along = glm::normalize(any()), start = 20.0 + any() - 0.5 * length * along;
        RemovalEditor editor(std::make_shared<Version>(base), {field});
        editor.remove({start, start + length * along, radius});
        const auto version = editor.publish();
        const double exact = std::numbers::pi * radius * radius * (length + 4.0 / 3 * radius),
                     off = version->mm3_of(version->ledger().total()) / exact - 1;
        sum += off, squares += off * off;
        worst = std::max(worst, std::abs(off));
      }
      const double mean = sum / count, spread = std::sqrt(squares / count - mean * mean);
      EXPECT_LT(std::abs(mean), 1e-3) << radius << " " << length;
      EXPECT_LT(spread, 6e-4) << radius << " " << length;
    }
  EXPECT_LT(worst, 2.2e-3);
}

TEST(Removal, EqualsBruteForceInEveryFrame) {
  for (const Frame& frame : frames())
    for (const double radius : {1.1, 4.0}) expect_brute_force({frame, {30, 26, 22}, radius, 0});
}

TEST(Removal, EqualsBruteForceOnFineLattices) {
  for (const Frame& frame : frames()) expect_brute_force({frame, {10, 9, 8}, 1.3, 2.4});
  expect_brute_force({Frame::from_spacing({0, 0, 0}, {0.4, 0.4, 4.8}).value(), {14, 12, 4}, 1.0, 2.0});
}

TEST(CutLattice, IsNearIsotropicAndHasASampleOnEveryVoxelCentre) {
  for (const Frame& frame : frames())
    for (const double burr : {0.5, 1.0, 3.0, 20.0}) {
      const auto base = block({9, 11, 7}, frame);
      const CutLattice lattice = CutLattice::for_burr(*base, burr).value();
      for (int a = 0; a < 3; ++a) {
        EXPECT_EQ(lattice.per_voxel()[a] % 2, 1);
        EXPECT_LE(lattice.frame().spacing()[a], 0.5 * burr / CutLattice::k_samples_per_radius * (1 + 1e-9));
      }
      for (const glm::ivec3& v : {glm::ivec3(0), glm::ivec3(3, 10, 6), glm::ivec3(-1, 11, 2)}) {
        const glm::ivec3 s = lattice.centre_of(v);
        EXPECT_LT(glm::length(lattice.frame().world_from_volume(s) - frame.world_from_volume(v)), 1e-11);
        EXPECT_EQ(lattice.voxel_of(s), v);
        EXPECT_EQ(lattice.voxel_of(lattice.low_of(v)), v);
        EXPECT_EQ(lattice.voxel_of(lattice.high_of(v)), v);
        EXPECT_EQ(lattice.voxel_of(lattice.high_of(v) + 1), v + 1);
      }
      const CutLattice::Point p = lattice.point_of({2.3, 4.49, 5.51});
      EXPECT_LT(
          glm::length(lattice.volume_from_lattice(glm::dvec3(p.sample) + p.at) - glm::dvec3(2.3, 4.49, 5.51)),
          1e-12);
      for (int a = 0; a < 3; ++a) EXPECT_LE(std::abs(p.at[a]), 0.5 + 1e-12);
    }
}

TEST(CutLattice, RefusesABurrThatIsTooSmallAndNamesTheSmallestThatWorks) {
  const auto base = block({8, 8, 8}, Frame::from_spacing({0, 0, 0}, {0.5, 0.5, 5}).value());
  const auto refused = CutLattice::for_burr(*base, 0.05);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().expected.find("at least"), std::string::npos) << refused.error().message();
  const double smallest = CutLattice::smallest_burr_mm(*base);
  EXPECT_TRUE(CutLattice::for_burr(*base, smallest));
  EXPECT_TRUE(CutLattice::for_burr(*base, 0.5));
  EXPECT_FALSE(CutLattice::for_burr(*base, 0.99 * smallest));
  EXPECT_FALSE(CutLattice::for_burr(*base, 0));
  EXPECT_FALSE(CutLattice::for_burr(*base, std::nan("")));
}

/// Removed fractions and ledger do not depend on the order of cuts: a large ball over fine scratches is
/// counted like scratches after the large ball.
TEST(Removal, AnOrderOfSmallAndLargeBallsMakesNoDifference) {
  const auto base = block({40, 40, 40}, Frame::from_spacing({0, 0, 0}, glm::dvec3(0.25)).value());
  const Field field(*base, Shape{});
  std::vector<Sweep> sweeps;
  for (int i = 0; i < 6; ++i)
    sweeps.push_back({{3 + 0.5 * i, 3, 4}, {4 + 0.5 * i, 6, 6.1}, i % 2 ? 2.1 : 0.4});
  const auto run = [&](const std::vector<Sweep>& order) {
    RemovalEditor editor(std::make_shared<Version>(base), {field});
    for (const Sweep& s : order) editor.remove(s);
    return editor.publish();
  };
  const auto forward = run(sweeps);
  std::reverse(sweeps.begin(), sweeps.end());
  const auto backward = run(sweeps);
  EXPECT_EQ(forward->ledger().total(), backward->ledger().total());
  for (int z = 0; z < 40; ++z)
    for (int y = 0; y < 40; ++y)
      for (int x = 0; x < 40; ++x)
        ASSERT_EQ(forward->removed_share({x, y, z}), backward->removed_share({x, y, z}));
}

TEST(Removal, IsIdempotentAndOrderFree) {
  const auto base = block({48, 48, 48}, Frame());
  const Field field(*base, Shape{});
  std::vector<Sweep> sweeps;
  std::mt19937_64 random(17);
  std::uniform_real_distribution<double> anywhere(4, 44);
  for (int i = 0; i < 12; ++i) {
    const glm::dvec3 a(anywhere(random), anywhere(random), anywhere(random));
    // All radii are equal, so that masks are equally fine in any order and whole hashes can be compared.
    sweeps.push_back({a, a + glm::dvec3(5, 2, -3), 5.0});
  }
  const auto run = [&](std::vector<Sweep> order) {
    RemovalEditor editor(std::make_shared<Version>(base), {field});
    for (const Sweep& s : order) editor.remove(s);
    return editor.publish();
  };
  const auto first = run(sweeps);
  std::vector<Sweep> twice = sweeps;
  twice.insert(twice.end(), sweeps.begin(), sweeps.end());
  EXPECT_EQ(run(twice)->content_hash(), first->content_hash());
  EXPECT_EQ(run(twice)->ledger().total(), first->ledger().total());
  std::shuffle(sweeps.begin(), sweeps.end(), random);
  EXPECT_EQ(run(sweeps)->content_hash(), first->content_hash());
  EXPECT_EQ(run(sweeps)->ledger().total(), first->ledger().total());
}

// A continued sweep does not process the cells behind its start again. The result must equal that of plain
// sweeps (distances up to single-precision rounding).
TEST(Removal, ContinuingASweepChangesNothing) {
  for (const double step : {0.02, 0.3, 2.0}) {
    const auto base = block({48, 40, 40}, Frame());
    const Field field(*base, Shape{});
    std::shared_ptr<const Version> results[2];
    for (const bool continues : {false, true}) {
      RemovalEditor editor(std::make_shared<Version>(base), {field});
      glm::dvec3 at(10, 20, 20);
      for (int i = 0; i < 30; ++i) {
        const glm::dvec3 to = at + step * glm::normalize(glm::dvec3(1, i % 3 - 1, 0.3 * (i % 5) - 0.6));
        editor.remove({at, to, 6.0, continues && i > 0});
        at = to;
      }
      results[continues] = editor.publish();
    }
    EXPECT_EQ(results[0]->ledger().total(), results[1]->ledger().total());
    int kept_differently = 0;
    for (int z = 0; z < 40; ++z)
      for (int y = 0; y < 40; ++y)
        for (int x = 0; x < 48; ++x) {
          ASSERT_NEAR(results[0]->voxel_distance(x, y, z), results[1]->voxel_distance(x, y, z), 2e-5);
          kept_differently += results[0]->is_kept({x, y, z}) != results[1]->is_kept({x, y, z});
        }
    EXPECT_EQ(kept_differently, 0);
  }
}

TEST(Removal, EightLanesGiveTheBitsOfFour) {
  if (!__builtin_cpu_supports("avx2")) GTEST_SKIP() << "no AVX2 here";
  for (const Frame& frame : frames())
    for (const double radius : {1.3, 6.0}) {
      const auto base = block({60, 50, 44}, frame);
      std::uint64_t hashes[2];
      std::int64_t units[2];
      for (const int wide : {0, 1}) {
        RemovalEditor editor(std::make_shared<Version>(base), {Field(*base, Shape{})},
                             wide ? k_removal_kernels_8 : k_removal_kernels_4);
        std::mt19937_64 random(23);
        std::uniform_real_distribution<double> index(5, 40);
        glm::dvec3 at = frame.world_from_volume({20, 20, 20});
        for (int i = 0; i < 60; ++i) {
          const glm::dvec3 aim = frame.world_from_volume({index(random), index(random), index(random)});
          const glm::dvec3 to = at + (i % 3 ? 0.02 : 0.4) * (aim - at);
          editor.remove({at, to, radius, i > 0});
          at = to;
        }
        hashes[wide] = editor.working().content_hash();
        units[wide] = editor.working().ledger().total();
      }
      EXPECT_EQ(hashes[0], hashes[1]);
      EXPECT_EQ(units[0], units[1]);
      EXPECT_GT(units[0], 10000);
    }
}

/// Another thread may read a frozen version completely while the stroke continues. The stroke ends with the
/// same result as a stroke without frozen versions.
TEST(Removal, AFrozenVersionMayBeKeptInTheMiddleOfAStroke) {
  const auto base = block({40, 40, 40}, Frame());
  const auto drill = [&](bool is_frozen, std::vector<std::shared_ptr<const Version>>& kept) {
    RemovalEditor editor(std::make_shared<Version>(base), {Field(*base, Shape{})});
    std::vector<std::thread> readers;
    for (int i = 0; i < 60; ++i) {
      const glm::dvec3 from(8 + 0.3 * i, 15, 20 + 0.05 * i);
      editor.remove({from, from + glm::dvec3(0.3, 0, 0.05), 4, i > 0});
      const auto seen = editor.publish();
      EXPECT_FALSE(seen->is_frozen());
      if (!is_frozen || i % 20 != 10) continue;
      const auto frozen = editor.freeze();
      EXPECT_TRUE(frozen->is_frozen());
      EXPECT_TRUE(seen->is_frozen());
      kept.push_back(frozen);
      readers.emplace_back([frozen] {
        const std::uint64_t hash = frozen->content_hash();
        for (int again = 0; again < 20; ++again) EXPECT_EQ(frozen->content_hash(), hash);
      });
    }
    for (std::thread& reader : readers) reader.join();
    editor.end_stroke();
    return editor.publish();
  };
  std::vector<std::shared_ptr<const Version>> kept;
  const auto with = drill(true, kept), without = drill(false, kept);
  EXPECT_EQ(with->content_hash(), without->content_hash());
  EXPECT_EQ(with->ledger().total(), without->ledger().total());
  // Another editor that continues from a frozen version, or from a copy of one, does not change it.
  RemovalEditor first(std::make_shared<Version>(base), {Field(*base, Shape{})});
  first.remove({{20, 20, 20}, {20, 20, 20}, 4});
  const auto seen = first.freeze();
  const std::uint64_t hash = seen->content_hash();
  RemovalEditor second(seen, {Field(*base, Shape{})}), copy(first);
  EXPECT_TRUE(copy.publish()->is_frozen());
  for (RemovalEditor* editor : {&second, &copy, &first}) {
    editor->remove({{20.3, 20, 20.1}, {20.6, 20, 20.1}, 4});
    EXPECT_EQ(seen->content_hash(), hash);
  }
  // The removed fractions of a kept version are those at the time of freeze(): their sum equals its ledger.
  ASSERT_EQ(kept.size(), 3u);
  double last = 0;
  for (const auto& version : kept) {
    double removed = 0;
    for (int z = 0; z < 40; ++z)
      for (int y = 0; y < 40; ++y)
        for (int x = 0; x < 40; ++x) removed += version->removed_share({x, y, z});
    EXPECT_NEAR(removed, version->mm3_of(version->ledger().total()), 1e-6);
    EXPECT_GT(removed, last);
    last = removed;
  }
}

TEST(Removal, OldVersionsStayAsTheyWere) {
  const auto base = block({40, 40, 40}, Frame());
  const Field field(*base, Shape{});
  RemovalEditor editor(std::make_shared<Version>(base), {field});
  std::vector<std::shared_ptr<const Version>> versions;
  std::vector<std::uint64_t> hashes;
  for (int i = 0; i < 8; ++i) {
    editor.remove({{10.0 + i, 20, 20}, {11.0 + i, 20, 20}, 5});
    versions.push_back(editor.publish());
    hashes.push_back(versions.back()->content_hash());
    editor.end_stroke();
  }
  for (std::size_t i = 0; i < versions.size(); ++i) EXPECT_EQ(versions[i]->content_hash(), hashes[i]);
  // Returns to the third version and cuts elsewhere. The old versions do not change, and a repetition of the
  // original cut gives the same bits.
  editor.reset(versions[2]);
  editor.remove({{30, 10, 10}, {30, 10, 10}, 4});
  EXPECT_NE(editor.publish()->content_hash(), hashes[2]);
  for (std::size_t i = 0; i < versions.size(); ++i) EXPECT_EQ(versions[i]->content_hash(), hashes[i]);
  editor.reset(versions[2]);
  editor.remove({{13, 20, 20}, {14, 20, 20}, 5});
  EXPECT_EQ(editor.publish()->content_hash(), hashes[3]);
}

TEST(Removal, MaskedRowsEqualKeptBits) {
  const auto base = block({150, 30, 30}, Frame());
  const Field field(*base, Shape{});
  for (const double smallest_burr : {0.0, 4.0}) {
    const CutLattice lattice =
        smallest_burr > 0 ? CutLattice::for_burr(*base, smallest_burr).value() : CutLattice(*base);
    RemovalEditor editor(std::make_shared<Version>(base, lattice), {field});
    editor.remove({{20, 15, 15}, {130, 12, 14}, 5});
    const auto version = editor.publish();
    for (int z = 0; z < 30; ++z)
      for (int y = 0; y < 30; ++y) {
        std::uint64_t words[3];
        threshold_row(*base, Shape{}, y, z, words);
        version->mask_row(y, z, 0, 3, words);
        for (int x = 0; x < 150; ++x)
          ASSERT_EQ(words[x / 64] >> (x % 64) & 1, version->is_kept({x, y, z}) ? 1u : 0u);
      }
  }
}

// Readers sample the newest version while the writer publishes further versions. Every version that they read
// is consistent (its kept bits agree with its distances), and no version is freed while a reader uses it.
// Calls of yield() vary the interleaving of the threads.
TEST(Channel, ReadersSeeWholeVersionsWhileEditsGoOn) {
  const auto base = block({64, 64, 64}, Frame());
  const Field field(*base, Shape{});
  RemovalEditor editor(std::make_shared<Version>(base), {field});
  Channel<Version> channel(editor.publish());
  std::atomic<bool> is_over{false};
  std::atomic<int> torn{0}, reads{0}, backward{0};
  std::vector<std::jthread> readers;
  for (int r = 0; r < 3; ++r)
    readers.emplace_back([&, r] {
      const int reader = channel.open_reader();
      std::uint64_t last = 0;
      std::mt19937 random(static_cast<unsigned>(r));
      while (!is_over.load()) {
        const Version* version = channel.adopt(reader);
        if (version->serial() < last) ++backward;
        last = version->serial();
        for (int i = 0; i < 40; ++i) {
          const glm::ivec3 v(random() % 64, random() % 64, random() % 64);
          if (i % 8 == 0) std::this_thread::yield();
          if (version->is_kept(v) != (version->voxel_distance(v.x, v.y, v.z) > 0)) ++torn;
        }
        ++reads;
      }
      channel.close_reader(reader);
    });
  glm::dvec3 at(20, 20, 20);
  std::size_t max_alive = 0;
  for (int i = 0; i < 400; ++i) {
    const glm::dvec3 to = at + glm::dvec3(0.06, 0.05, 0.04);
    editor.remove({at, to, 6, i > 0});
    channel.publish(editor.publish());
    max_alive = std::max(max_alive, static_cast<std::size_t>(channel.alive_count()));
    at = to;
    if (i % 3 == 0) std::this_thread::yield();
  }
  const auto patience = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (reads.load() < 20 && std::chrono::steady_clock::now() < patience) std::this_thread::yield();
  EXPECT_GE(reads.load(), 20);
  is_over = true;
  readers.clear();
  EXPECT_EQ(torn.load(), 0);
  EXPECT_EQ(backward.load(), 0);
  channel.publish(editor.publish());
  EXPECT_EQ(channel.alive_count(), 1) << "all readers are closed: only the newest version may be alive";
  EXPECT_GE(max_alive, 1u);
}

TEST(Channel, KeepsWhatAReaderHolds) {
  const auto base = block({32, 32, 32}, Frame());
  RemovalEditor editor(std::make_shared<Version>(base), {});
  Channel<Version> channel(editor.publish());
  const int reader = channel.open_reader();
  const Version* held = channel.adopt(reader);
  const std::uint64_t serial = held->serial();
  for (int i = 0; i < 5; ++i) channel.publish(editor.publish());
  EXPECT_EQ(held->serial(), serial);
  EXPECT_EQ(channel.alive_count(), 6);
  EXPECT_GT(channel.adopt(reader)->serial(), serial);
  channel.publish(editor.publish());
  EXPECT_LE(channel.alive_count(), 2);
  channel.close_reader(reader);
}

}  // namespace
}  // namespace trephine::volume
