// Outcome of a laminectomy against the phantom's own shapes: areas by counting pixels of the exact bone,
// parts by counting points of the exact bone.
#include "modules/laminectomy/laminectomy.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <gtest/gtest.h>
#include <span>

#include "apps/bench/scenes/scenes.h"
#include "data-tools/phantoms/phantoms.h"
#include "data-tools/phantoms/spine_phantom.h"
#include "haptics/methods/methods.h"
#include "sim/drivers/lockstep.h"
#include "tests/whole.h"
#include "volume/cuts/removal.h"

namespace trephine::laminectomy {
namespace {

using data_tools::SpinePhantom;
using glm::dvec3;

constexpr int k_l4 = 1;

/// Returns the distance from a world point to the removed volume (mm), negative inside.
using Cut = std::function<double(const dvec3&)>;

/// Removes the inside of a Cut.
class CutField final : public volume::RemovalField {
 public:
  CutField(const volume::Version& version, Cut cut)
      : frame_(version.lattice().frame()), size_(version.lattice().size()), cut_(std::move(cut)) {}
  volume::VoxelBox samples() const { return {glm::ivec3(0), size_ - 1}; }
  Reach find(const glm::ivec3& low, double band, Distances& mm) override {
    const dvec3 middle = frame_.world_from_volume(dvec3(low) + 3.5);
    if (cut_(middle) > 8 * frame_.diagonal_mm()) return Reach::none;
    bool is_any = false;
    std::size_t i = 0;
    for (int z = -1; z <= volume::k_brick; ++z)
      for (int y = -1; y <= volume::k_brick; ++y)
        for (int x = -1; x <= volume::k_brick; ++x) {
          const double d = cut_(frame_.world_from_volume(dvec3(low) + dvec3(x, y, z)));
          is_any = is_any || d < band;
          mm[i++] = static_cast<float>(std::clamp(d, -band, band));
        }
    return is_any ? Reach::some : Reach::none;
  }

 private:
  volume::Frame frame_;
  glm::ivec3 size_;
  Cut cut_;
};

struct Spine {
  std::shared_ptr<const volume::Volume> scan;
  volume::Field bone;
  explicit Spine(const dvec3& spacing, double noise = 0, double shear = 0, std::uint64_t seed = 1) {
    data_tools::PhantomOptions options;
    options.spacing_mm = spacing;
    options.seed = seed;
    options.shear_degrees = shear;
    options.parameters["noise"] = noise;
    scan = std::make_shared<const volume::Volume>(data_tools::make_phantom("spine", options).value());
    bone = volume::Field(*scan, {"bone", 140});
  }
  std::shared_ptr<const volume::Version> cut(const Cut& cut) const {
    const auto lattice =
        volume::CutLattice::for_burr(*scan, std::max(4.5, volume::CutLattice::smallest_burr_mm(*scan)));
    volume::RemovalEditor editor(std::make_shared<const volume::Version>(scan, lattice.value()), {bone});
    CutField field(editor.working(), cut);
    editor.remove(field, field.samples());
    return editor.freeze();
  }
  Outcome judged(const volume::Version& version, const std::string& vertebra = "L4") const {
    const auto outcome = judge(bone, scan->label_value(vertebra), nullptr, version);
    EXPECT_TRUE(outcome) << outcome.error().reason;
    return outcome.value();
  }
  volume::Version uncut() const { return volume::Version(scan); }
};

/// Returns a block in the vertebra's own frame (mm, from the middle of its canal at the lamina). It extends
/// `aside` to either side, from `front` to the back, and from `low` to `high`; moved by `shift` to the left.
Cut block(const SpinePhantom& spine, double aside, double front, double low, double high, double shift = 0) {
  const dvec3 middle = spine.world_point(k_l4, {0, 24, 0}),
              left = glm::normalize(spine.world_point(k_l4, {1, 24, 0}) - middle),
              back = glm::normalize(spine.world_point(k_l4, {0, 25, 0}) - middle),
              up = glm::normalize(spine.world_point(k_l4, {0, 24, 1}) - middle);
  return [=](const dvec3& w) {
    const dvec3 p(glm::dot(w - middle, left), glm::dot(w - middle, back), glm::dot(w - middle, up));
    return std::max({std::abs(p.x - shift) - aside, front - p.y, low - p.z, p.z - high});
  };
}

/// Pixels in the plane of a section of the canal. A pixel counts if no bone lies between it and the centre.
struct Pixels {
  static constexpr double k_pixel = 0.15;
  const SpinePhantom& spine;
  const volume::VertebraFrame& frame;
  double z;
  Cut cut = [](const dvec3&) { return 1e3; };

  bool is_bone(double x, double y) const {
    const dvec3 w = frame.world({x, y, z});
    const auto all = spine.bone_distances(w);
    return *std::min_element(all.begin(), all.end()) < 0 && cut(w) > 0;
  }
  /// Returns the area of the counted pixels, mm2. Pixels with y >= `behind` do not count. Negative if a
  /// counted pixel is farther from the centre than the wall of a canal can be (17.5 mm).
  double area(double behind = 20) const {
    constexpr double k_canal = 17.5;
    constexpr int k_half = static_cast<int>(18 / k_pixel);
    std::vector<char> bone(4 * k_half * k_half);
    const auto at = [&](double x, double y) -> char& {
      const int i = static_cast<int>(std::floor(x / k_pixel)) + k_half,
                j = static_cast<int>(std::floor(y / k_pixel)) + k_half;
      return bone[static_cast<std::size_t>(std::clamp(i, 0, 2 * k_half - 1) +
                                           2 * k_half * std::clamp(j, 0, 2 * k_half - 1))];
    };
    const auto for_pixels = [&](const auto& each) {
      for (int j = -k_half; j < k_half; ++j)
        for (int i = -k_half; i < k_half; ++i) each((i + 0.5) * k_pixel, (j + 0.5) * k_pixel);
    };
    for_pixels([&](double x, double y) { at(x, y) = is_bone(x, y); });
    int count = 0;
    bool is_open = false;
    for_pixels([&](double x, double y) {
      if (y >= behind || at(x, y)) return;
      const double far = std::hypot(x, y);
      for (double t = 0; t < far; t += 0.5 * k_pixel)
        if (at(x * t / far, y * t / far)) return;
      ++count;
      is_open = is_open || far > k_canal;
    });
    return is_open ? -1 : count * k_pixel * k_pixel;
  }
};

/// A label of the size of a skull is refused as too large for a vertebra. Stray voxels do not make the label
/// of a vertebra too large.
TEST(LaminectomyOutcome, ALabelOfTheSizeOfASkullIsNoVertebra) {
  const Spine spine(dvec3(1), 20, 0);
  volume::Volume copy = volume::copy_of(*spine.scan).value();
  for (std::size_t i = 0; i < 20; ++i) copy.labels[i] = copy.labels[copy.labels.size() - 1 - i] = 2;
  EXPECT_TRUE(volume::find_vertebra({volume::Field(copy, spine.bone.shape()), 2}, nullptr));
  for (std::size_t i = 0; i < copy.labels.size(); ++i) copy.labels[i] = 2;
  copy.frame = volume::Frame::from_spacing(copy.frame.origin(), 2.0 * copy.frame.spacing()).value();
  const auto refused = volume::find_vertebra({volume::Field(copy, spine.bone.shape()), 2}, nullptr);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().reason, "the label is larger than a vertebra: set a position in its canal");
}

TEST(LaminectomyOutcome, AFrameFollowsItsVertebra) {
  const std::pair<dvec3, double> grids[] = {{dvec3(1), 15}, {dvec3(0.5, 0.5, 3), 15}, {dvec3(0.7), 0}};
  for (const auto& [spacing, shear] : std::span(grids).first(runs_all_cases() ? 3 : 2)) {
    const Spine spine(spacing, 20, shear);
    const SpinePhantom exact(1);
    for (int v = 0; v < 3; ++v) {
      Outcome o;
      const auto frame = volume::find_vertebra({spine.bone, v + 1}, nullptr);
      ASSERT_TRUE(frame) << frame.error().reason;
      o.frame = frame.value();
      const dvec3 up = glm::normalize(exact.world_point(v, {0, 24, 1}) - exact.world_point(v, {0, 24, 0}));
      const double off = std::acos(std::min(1.0, glm::dot(o.frame.up, up))) * 57.3;
      EXPECT_LT(off, 1.5) << v << " " << spacing.z << " " << shear;
      EXPECT_LT(std::abs(glm::dot(o.frame.left, dvec3(0, 1, 0))), 0.05);
      const dvec3 middle = o.frame.local(exact.world_point(v, {0, 24, 0}));
      EXPECT_LT(std::abs(middle.x), 0.5);
      EXPECT_LT(std::abs(middle.y), 3);
    }
  }
}

TEST(LaminectomyOutcome, RoomInTheCanalEqualsThatOfItsExactShape) {
  const SpinePhantom exact(1);
  const std::pair<dvec3, double> scans[] = {{dvec3(1), 20}, {dvec3(0.45, 0.45, 3), 20}, {dvec3(0.5), 0}};
  for (const auto& [spacing, noise] : std::span(scans).first(runs_all_cases() ? 3 : 2)) {
    const Spine spine(spacing, noise);
    const double allowed = spacing.z > 1 ? 0.08 : 0.02;
    // A trough of 12 mm through lamina and spinous process.
    const Cut trough = block(exact, 6, 0, -30, 30);
    const Outcome o = spine.judged(*spine.cut(trough));
    int count = 0;
    for (int i = o.roof_first; i <= o.roof_last; i += runs_all_cases() ? 2 : 4) {
      const volume::CanalSection& s = o.sections[static_cast<std::size_t>(i)];
      Pixels pixels{exact, o.frame, s.z};
      const double before = pixels.area();
      if (before < 0) continue;
      EXPECT_NEAR(s.area(false) / before, 1, allowed) << s.z << " " << spacing.z << " noise " << noise;
      // Behind, the canal ends at a line between the rear edges of the bone on both sides of the trough.
      pixels.cut = trough;
      double edge = 0;
      const dvec3 corner = o.frame.local(exact.world_point(k_l4, {0, 24, 0}));
      for (double y = 0; y < 20; y += 0.02)
        for (const double x : {corner.x + 6.02, corner.x - 6.02}) {
          if (pixels.is_bone(x, y)) edge = std::max(edge, y);
        }
      const double after = pixels.area(edge);
      if (after < 0) continue;
      EXPECT_NEAR(s.area(true) / after, 1, allowed) << s.z << " " << spacing.z << " noise " << noise;
      EXPECT_NEAR(s.opening(), 12, 0.5) << s.z;
      ++count;
    }
    EXPECT_GE(count, 2);
    const volume::CanalSection& narrow = o.sections[static_cast<std::size_t>(o.narrowest)];
    EXPECT_GT(narrow.area(true), narrow.area(false));
  }
}

TEST(LaminectomyOutcome, ACutOutsideTheCanalLeavesItsRoom) {
  const SpinePhantom exact(1);
  const Spine spine(dvec3(runs_all_cases() ? 0.6 : 0.8));
  // Cuts only the spinous process.
  const Outcome o = spine.judged(*spine.cut(block(exact, 8, 21, -40, 40)));
  EXPECT_EQ(o.opened_length, 0);
  EXPECT_EQ(o.widest_opened, -1);
  for (const volume::CanalSection& s : o.sections)
    if (s.has_roof(false)) {
      EXPECT_DOUBLE_EQ(s.area(true), s.area(false));
    }
  EXPECT_LT(o.lamina.share_removed(), 0.02);
  EXPECT_GT(o.spinous_process.share_removed(), 0.75);
  for (const auto* facets : {&o.upper_facet, &o.lower_facet})
    for (const Part& facet : *facets) EXPECT_LT(facet.share_removed(), 0.02);
}

/// Counts points of a grid in each part of the exact bone. The definitions of the parts are written here
/// independently of the module.
TEST(LaminectomyOutcome, PartsEqualThoseOfTheExactBone) {
  const SpinePhantom exact(1);
  for (const dvec3& spacing : {dvec3(0.45, 0.45, 3), dvec3(0.7)}) {
    if (spacing.z < 1 && !runs_all_cases()) continue;
    const Spine spine(spacing);
    // The cut is too far to the left, and removes bone of the left facets.
    const Cut cut = block(exact, 10, 0, -30, 30, 4);
    const Outcome o = spine.judged(*spine.cut(cut));
    std::array<double, 6> size{},
        removed{};  // lamina, process, upper left, upper right, lower left, lower right
    constexpr double k_step = 0.5;
    const double middle = (o.pedicle_low + o.pedicle_high) / 2,
                 below = o.pedicle_low - (middle - o.pedicle_low);
    for (double z = o.frame.low; z < o.frame.high; z += k_step)
      for (double y = k_step / 2; y < 60; y += k_step)
        for (double x = -24.75; x < 25; x += k_step) {
          if (std::abs(x) > o.half_width + 12) continue;
          const dvec3 w = o.frame.world({x, y, z});
          if (exact.bone_distances(w)[k_l4] > 0) continue;
          int part = 0;
          if (std::abs(x) < o.half_width / 2 && y > o.roof_back)
            part = 1;
          else if (std::abs(x) >= 0.7 * o.half_width)
            part = z > middle ? (x > 0 ? 2 : 3) : z < below ? (x > 0 ? 4 : 5) : 0;
          size[static_cast<std::size_t>(part)] += k_step * k_step * k_step;
          if (cut(w) < 0) removed[static_cast<std::size_t>(part)] += k_step * k_step * k_step;
        }
    const std::array<const Part*, 6> parts{&o.lamina,         &o.spinous_process, &o.upper_facet[0],
                                           &o.upper_facet[1], &o.lower_facet[0],  &o.lower_facet[1]};
    for (std::size_t i = 0; i < parts.size(); ++i) {
      EXPECT_NEAR(parts[i]->size / size[i], 1, 0.06) << i << " " << spacing.z;
      EXPECT_NEAR(parts[i]->share_removed(), removed[i] / size[i], 0.03) << i << " " << spacing.z;
    }
    // The cut extends 14 mm to the left of the middle and 6 mm to the right.
    EXPECT_GT(o.lower_facet[0].share_removed(), 0.3);
    EXPECT_LT(o.lower_facet[1].share_removed(), 0.1);
    EXPECT_LT(o.pars[0].after, o.pars[1].after - 4);
    EXPECT_NEAR(o.pars[1].before - o.pars[1].after, 6, 0.7);
    EXPECT_NEAR(o.pars[0].before, o.pars[1].before, 0.7);
  }
}

TEST(LaminectomyOutcome, ReportsWhyNoVertebraIsFound) {
  const Spine spine(dvec3(1.2));
  const volume::Version version = spine.uncut();
  const auto judged = [&](int label, const dvec3* canal) { return judge(spine.bone, label, canal, version); };
  const auto disc = judged(spine.scan->label_value("disc"), nullptr);
  ASSERT_FALSE(disc);
  EXPECT_FALSE(disc.error().reason.empty());
  const auto empty = judged(100, nullptr);
  ASSERT_FALSE(empty);
  EXPECT_NE(empty.error().reason.find("no voxels"), std::string::npos);
  EXPECT_FALSE(judged(-1, nullptr));
  const dvec3 air(0, 82, 0), beyond(1e4, 0, 0);
  EXPECT_FALSE(judged(-1, &air));
  EXPECT_FALSE(judged(-1, &beyond));
  // Without a label a position in the canal suffices.
  const dvec3 canal = SpinePhantom(1).world_point(k_l4, {0, 24, 0});
  const auto found = judged(-1, &canal);
  ASSERT_TRUE(found) << found.error().reason;
  const Outcome& outcome = found.value();
  const Outcome labelled = spine.judged(version);
  const auto narrowest = [](const Outcome& o) {
    return o.sections[static_cast<std::size_t>(o.narrowest)].area(false);
  };
  EXPECT_NEAR(narrowest(outcome) / narrowest(labelled), 1, 0.15);  // bounded by blurred walls only
}

/// The command raises an event and sets measures. An invalid vertebra clears the measures, and impossible
/// requests are refused.
TEST(Laminectomy, IsJudgedByCommand) {
  data_tools::PhantomOptions options;
  options.spacing_mm = dvec3(1.2);
  haptics::TouchScene scene =
      scenes::scene_of(data_tools::make_phantom("spine", options).value(), {}, {"bone", 140});
  const auto method = haptics::make_method("subvoxel").value();
  ASSERT_FALSE(method->prepare(scene).has_value());
  const Laminectomy module;
  const sim::Catalogue catalogue({&module});
  sim::Lockstep run(sim::Engine(scene, *method, {}, 1e-3, catalogue), {}, 1000);
  const auto measure = [&](std::string_view name) {
    for (const sim::Measure& one : run.engine().measures())
      if (one.name == name) return one.value;
    return -1.0;
  };
  EXPECT_EQ(measure("canal"), 0);
  const auto outcome = [&]() -> const sim::Value& {
    const sim::Chronicle& all = run.engine().state().chronicle;
    return all[all.size() - 1].value;
  };
  EXPECT_FALSE(run.apply_and_finish({JudgeLaminectomy{"L4"}, 0}).refused.has_value());
  ASSERT_NE(outcome().as<Judgement>(), nullptr);
  EXPECT_EQ(outcome().as<Judgement>()->canal_before, outcome().as<Judgement>()->canal_after);
  EXPECT_FALSE(outcome().as<Judgement>()->is_at_border);
  EXPECT_NEAR(measure("canal"), 351, 12);
  EXPECT_NEAR(measure("lamina remaining"), 100, 1e-9);
  const std::uint64_t first = run.engine().state().hash();
  EXPECT_FALSE(run.apply_and_finish({JudgeLaminectomy{"disc"}, 0}).refused.has_value());
  EXPECT_NE(outcome().as<JudgementFailed>(), nullptr);
  EXPECT_EQ(measure("canal"), 0);
  EXPECT_NE(run.engine().state().hash(), first);
  EXPECT_FALSE(run.apply_and_finish({JudgeLaminectomy{}, 0}).refused.has_value());
  ASSERT_NE(outcome().as<JudgementFailed>(), nullptr);
  EXPECT_NE(outcome().as<JudgementFailed>()->reason.find("no bone"), std::string::npos) << "nothing was cut";
  for (const JudgeLaminectomy& request :
       {JudgeLaminectomy{"L9"}, JudgeLaminectomy{"background"}, JudgeLaminectomy{"L4", {dvec3(0), dvec3(1)}},
        JudgeLaminectomy{"L4", {}, 3}})
    EXPECT_TRUE(run.apply_and_finish({request, 0}).refused.has_value()) << sim::Value(request).words();
}

}  // namespace
}  // namespace trephine::laminectomy
