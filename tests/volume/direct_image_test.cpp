// Direct volume rendering: compared with a sum over every sample of every ray in double precision, and with
// closed forms.
#include "volume/imaging/direct_image.h"

#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include "tests/hash_number.h"
#include "tests/whole.h"
#include "volume/cuts/operated_volume.h"
#include "volume/cuts/removal.h"

namespace trephine::volume {
namespace {

using glm::dmat3;
using glm::dvec3;
using glm::ivec3;

template <class Value>
Volume made_of(const ivec3& size, const dmat3& axes, const Value& value) {
  const dvec3 origin = -0.5 * (axes * (dvec3(size) - 1.0));
  Volume v = make_volume(size, Frame::from_axes(origin, axes).value()).value();
  v.is_hounsfield = true;
  for (int z = 0; z < size.z; ++z)
    for (int y = 0; y < size.y; ++y)
      for (int x = 0; x < size.x; ++x)
        v.voxels[v.index(x, y, z)] =
            static_cast<std::int16_t>(std::lround(value(v.frame.world_from_volume({x, y, z}))));
  return v;
}
template <class Value>
std::shared_ptr<const Volume> scan_of(const ivec3& size, const dmat3& axes, const Value& value) {
  return std::make_shared<const Volume>(made_of(size, axes, value));
}

const TransferFunction k_bone{
    {150, {0.8, 0.3, 0.2}, 0}, {300, {0.9, 0.8, 0.6}, 0.3}, {1200, {1, 1, 0.95}, 0.9}};

/// Brute-force twin: opacity of one ray from all its samples, with its own interpolation, transfer function
/// and cut edges.
struct BruteForceRay {
  const Volume& scan;
  const Version& version;
  const TransferFunction& ramp;
  const RaycastRequest& request;
  double step;

  double voxel(int x, int y, int z) const {
    const ivec3 v = glm::clamp(ivec3(x, y, z), ivec3(0), scan.size - 1);
    return scan.voxels[scan.index(v.x, v.y, v.z)];
  }
  double value(const dvec3& at) const {
    const dvec3 p = glm::clamp(at, dvec3(0), dvec3(scan.size - 1));
    double sum = 0;
    for (int n = 0; n < 8; ++n) {
      const dvec3 low = glm::floor(p), f = p - low;
      const dvec3 share(n & 1 ? f.x : 1 - f.x, n & 2 ? f.y : 1 - f.y, n & 4 ? f.z : 1 - f.z);
      sum += share.x * share.y * share.z *
             voxel(static_cast<int>(low.x) + (n & 1), static_cast<int>(low.y) + (n >> 1 & 1),
                   static_cast<int>(low.z) + (n >> 2));
    }
    const dvec3 mm = scan.frame.spacing();
    const double soft = std::min(0.5 * std::max({mm.x, mm.y, mm.z}), 0.9 * version.band_mm());
    const double air = air_of(scan);
    return air + std::clamp(0.5 + 0.5 * version.distance(p) / soft, 0.0, 1.0) * (sum - air);
  }
  double passes(double v) const {  // transmittance per mm
    if (v < ramp[0].value) return 1;
    for (std::size_t i = 1; i < ramp.size(); ++i)
      if (v <= ramp[i].value)
        return 1 - (ramp[i - 1].opacity + (v - ramp[i - 1].value) / (ramp[i].value - ramp[i - 1].value) *
                                              (ramp[i].opacity - ramp[i - 1].opacity));
    return 1 - ramp.back().opacity;
  }
  bool is_shown(const dvec3& world) const {
    const dvec3 p = scan.frame.volume_from_world(world);
    if (glm::any(glm::lessThan(p, dvec3(-0.5))) || glm::any(glm::greaterThan(p, dvec3(scan.size) - 0.5)))
      return false;
    const auto& open = request.openings;
    if (open.plane && glm::dot(world - open.plane->at, open.plane->normal) > 0) return false;
    for (const auto& tube : open.tubes) {
      double nearest = 1e9;  // mm, to the nearest of a thousand points on the tube's axis
      for (int s = 0; s <= 1000; ++s)
        nearest = std::min(nearest, glm::length(world - glm::mix(tube.from, tube.to, s / 1000.0)));
      if (nearest < tube.radius) return false;
    }
    return true;
  }
  double opacity(int i, int j) const {
    const Camera::Ray ray = request.camera.ray(i, j);
    const auto world = [&](double t) { return ray.from + t * ray.along; };
    const auto value_at = [&](double t) { return value(scan.frame.volume_from_world(world(t))); };
    double depth = 0;
    // Values change linearly between samples; each layer is integrated in 64 parts.
    const auto add = [&](double from, double to) {
      const double first = value_at(from), second = value_at(to);
      for (int part = 0; part < 64; ++part)
        depth -= (to - from) / 64 *
                 std::log(passes(std::floor(first + (second - first) * (part + 0.5) / 64 + 0.5)));
    };
    // Samples are counted from the start of each visible range, whose ends are found by bisection.
    const double stride = step / 8;
    bool was_shown = false;
    double from = 0;
    for (int n = 0; n * stride < 900; ++n) {
      const bool is_now = is_shown(world(n * stride));
      if (is_now == was_shown) continue;
      double low = (n - 1) * stride, high = n * stride;
      for (int k = 0; k < 50; ++k) {
        const double middle = 0.5 * (low + high);
        (is_shown(world(middle)) == was_shown ? low : high) = middle;
      }
      if (was_shown)
        for (double t = from; t < low; t += step) add(t, std::min(t + step, low));
      from = std::max(high, 0.0), was_shown = is_now;
    }
    return 1 - std::exp(-depth);
  }
};

Camera camera_at(const dvec3& at, int pixels, double height) {
  Camera camera;
  camera.at = at;
  camera.forward = glm::normalize(-at);
  const dvec3 up = std::abs(camera.forward.z) < 0.9 ? dvec3(0, 0, 1) : dvec3(0, 1, 0);
  camera.up = glm::normalize(up - glm::dot(up, camera.forward) * camera.forward);
  camera.distance = glm::length(at), camera.height = height;
  camera.columns = camera.rows = pixels;
  return camera;
}

TEST(DirectImage, EqualsBruteForceOfEverySampleOfEveryRay) {
  const dmat3 fine(1.0), thick(dvec3(0.7, 0, 0), dvec3(0, 0.7, 0), dvec3(0, 0, 4)),
      leaning(dvec3(0.8, 0, 0), dvec3(0.1, 0.9, 0), dvec3(0.3, 0.6, 2));
  double worst = 0;
  int rays = 0, planted = 0;
  for (const dmat3& axes : {fine, thick, leaning}) {
    // Shells, noise, and solid voxels at the border.
    const auto scan = scan_of({44, 41, 30}, axes, [&](const dvec3& p) {
      const double r = glm::length(p);
      const double grain =
          60 *
          number(static_cast<std::uint64_t>(std::llround(1000 * (p.x + 91 * p.y + 377 * p.z)) + (1LL << 40)));
      return (std::abs(r - 12) < 2.5 || p.x > 0.48 * 44 * axes[0].x - 1.5 ? 900.0
              : r < 9                                                     ? 180.0
                                                                          : -1000.0) +
             grain;
    });
    const Field bone(*scan, Shape{"bone", 200});
    RemovalEditor editor(std::make_shared<Version>(scan, CutLattice::for_burr(*scan, 4).value()), {bone});
    editor.remove({{0, -12, 3}, {2, -11, 0}, 4});
    const auto cut = editor.freeze();
    DirectImage image(scan, 2);
    image.set_transfer_function(k_bone);
    for (const dvec3& at : {dvec3(0, -200, 0), dvec3(150, 80, 60), dvec3(-20, 5, 190), dvec3(8, -3, 1)})
      for (int opening = 0; opening < 3; ++opening) {
        RaycastRequest request;
        request.camera = camera_at(at, 24, 46);
        if (opening == 2) request.camera.distance = 0;
        if (opening == 1)
          request.openings.plane = Openings::Plane{{1, 2, 0}, glm::normalize(dvec3(0.3, -1, 0.2))};
        if (opening == 1) request.openings.tubes = {{{0, -30, 0}, {0, 0, 0}, 3}};
        const std::size_t pixels = 24 * 24;
        std::vector<DirectPixel> drawn(pixels), again(pixels);
        image.draw(request, *cut, {}, 1, drawn);
        EXPECT_GT(image.counters().leaps, 0u);
        image.draw(request, *cut, {}, 2, again);
        for (std::size_t n = 0; n < pixels; ++n) ASSERT_EQ(drawn[n].opacity, again[n].opacity) << "threads";
        const BruteForceRay twin{*scan, *cut, k_bone, request, image.default_step_mm()};
        const int every = runs_all_cases() ? 1 : 3;
        for (int j = 0; j < 24; j += every)
          for (int i = 0; i < 24; i += every, ++rays) {
            const double is = twin.opacity(i, j),
                         result = static_cast<double>(drawn[static_cast<std::size_t>(i + 24 * j)].opacity);
            // A ray ends at a transmittance of 0.5 %.
            worst = std::max(worst, is > 0.995 && result > 0.995 ? 0.0 : std::abs(is - result));
          }
        // Planted fault: a twin that reads the uncut scan must differ.
        if (opening == 0) {
          const Version uncut(scan);
          const BruteForceRay wrong{*scan, uncut, k_bone, request, image.default_step_mm()};
          for (int j = 0; j < 24; j += 2)
            for (int i = 0; i < 24; i += 2)
              planted +=
                  std::abs(wrong.opacity(i, j) -
                           static_cast<double>(drawn[static_cast<std::size_t>(i + 24 * j)].opacity)) > 0.01;
        }
      }
  }
  std::printf("%d rays: largest error of the opacity %.1e; %d rays differ from those of the uncut scan\n",
              rays, worst, planted);
  EXPECT_LT(worst, 2e-3);
  EXPECT_GT(planted, 20);
}

TEST(DirectImage, BallConvergesToItsChordWithTheStep) {
  // The intensity changes over 0.8 mm at the surface of the ball: a sharp edge would show the voxels.
  const auto scan = scan_of({80, 80, 80}, dmat3(0.5), [](const dvec3& p) {
    return 1000 * std::clamp((14 - glm::length(p)) / 0.8 + 0.5, 0.0, 1.0);
  });
  const TransferFunction ramp{{0, dvec3(1), 0}, {1000, dvec3(1), 0.05}};
  DirectImage image(scan, 2);
  image.set_transfer_function(ramp);
  const Version uncut(scan);
  double before = 1;
  for (const double step : {2.0, 1.0, 0.5, 0.25}) {
    RaycastRequest request;
    request.camera = camera_at({0, -300, 0}, 40, 36);
    request.step = step;
    std::vector<DirectPixel> drawn(1600);
    image.draw(request, uncut, {}, 2, drawn);
    double square = 0;
    for (int j = 0; j < 40; ++j)
      for (int i = 0; i < 40; ++i) {
        const Camera::Ray ray = request.camera.ray(i, j);
        const double b = glm::dot(ray.from, ray.along), root = b * b - glm::dot(ray.from, ray.from) + 14 * 14;
        if (std::abs(14 - std::sqrt(14 * 14 - root)) < 1)
          continue;  // near the soft rim the closed form does not hold
        const double is = root > 0 ? 1 - std::pow(0.95, 2 * std::sqrt(root)) : 0;
        square +=
            std::pow(is - static_cast<double>(drawn[static_cast<std::size_t>(i + 40 * j)].opacity), 2) / 1600;
      }
    const double rms = std::sqrt(square);
    std::printf("step %.2f mm: opacity within %.1e (rms)\n", step, rms);
    EXPECT_LT(rms, 1.05 * before);
    before = rms;
  }
  EXPECT_LT(before, 1e-3);
}

TEST(DirectImage, EndsOnWallsHidesLabelsAndReportsDepth) {
  const ivec3 size(40);
  Volume output =
      made_of(size, dmat3(1.0), [](const dvec3& p) { return glm::length(p) < 14 ? 1500.0 : -1000.0; });
  output.label_names = {"", "shell", "core"};
  output.labels = Buffer<std::uint8_t>(output.voxels.size());
  for (int z = 0; z < 40; ++z)
    for (int y = 0; y < 40; ++y)
      for (int x = 0; x < 40; ++x) {
        const double r = glm::length(output.frame.world_from_volume({x, y, z}));
        output.labels[output.index(x, y, z)] = r < 8 ? 2 : r < 14 ? 1 : 0;
      }
  const auto scan = std::make_shared<const Volume>(std::move(output));
  const Version uncut(scan);
  DirectImage image(scan, 1);
  image.set_transfer_function({{500, {1, 0, 0}, 0}, {1000, {1, 0, 0}, 0.9}});
  RaycastRequest request;
  request.camera = camera_at({0, -100, 0}, 1, 1);
  DirectPixel pixel;
  image.draw(request, uncut, {}, 1, {&pixel, 1});
  EXPECT_GT(pixel.opacity, 0.99);
  EXPECT_NEAR(pixel.depth, 86, 1.5);
  image.set_labels({{1, {}}, {0, {}}, {1, dvec3(0, 1, 0)}});
  image.draw(request, uncut, {}, 1, {&pixel, 1});
  EXPECT_NEAR(pixel.depth, 92, 1.5) << "the shell is hidden";
  EXPECT_GT(pixel.green, 0.3);
  EXPECT_EQ(pixel.red, 0) << "the blurred edge of the shell is hidden as well";
  image.set_labels({});
  const float wall = 80;
  image.draw(request, uncut, {&wall, 1}, 1, {&pixel, 1});
  EXPECT_EQ(pixel.opacity, 0) << "an opaque wall in front hides the ball";
}

/// The distance between samples must not show as rings: a layer thinner than a step is as opaque with the
/// default step as with much shorter steps.
TEST(DirectImage, ThinLayersShowNoRings) {
  const auto scan = scan_of({80, 80, 80}, dmat3(0.5), [](const dvec3& p) {
    return -1000 + 2000 * std::clamp((14 - glm::length(p)) / 1.6 + 0.5, 0.0, 1.0);
  });
  const TransferFunction layer{
      {0, dvec3(1), 0}, {100, dvec3(1), 0.9}, {200, dvec3(1), 0.9}, {300, dvec3(1), 0}};
  DirectImage image(scan, 2);
  image.set_transfer_function(layer);
  const Version uncut(scan);
  RaycastRequest request;
  request.camera = camera_at({10, -300, 20}, 80, 20);
  const auto opacities = [&](double step) {
    request.step = step;
    std::vector<DirectPixel> pixels(80 * 80);
    image.draw(request, uncut, {}, 2, pixels);
    std::vector<double> result;
    for (const DirectPixel& pixel : pixels) result.push_back(pixel.opacity);
    return result;
  };
  const auto fine = opacities(0.02), usual = opacities(0);
  // Planted fault: the transfer function is evaluated only at the samples.
  request.step = 0;
  const BruteForceRay ray{*scan, uncut, layer, request, 0.25};
  double worst = 0, planted = 0;
  for (int j = 0; j < 80; j += 5)
    for (int i = 0; i < 80; i += 5) {
      const auto n = static_cast<std::size_t>(j * 80 + i);
      worst = std::max(worst, std::abs(usual[n] - fine[n]));
      const Camera::Ray line = request.camera.ray(i, j);
      double depth = 0;
      for (double t = 270; t < 350; t += ray.step) {
        const double value = ray.value(scan->frame.volume_from_world(line.from + t * line.along));
        depth -= ray.step * std::log(value <= 300 ? ray.passes(value) : 1.0);
      }
      planted = std::max(planted, std::abs(1 - std::exp(-depth) - fine[n]));
    }
  std::printf("opacity within %.3f of fine steps; by samples alone %.3f\n", worst, planted);
  EXPECT_LT(worst, 0.05);
  EXPECT_GT(planted, 0.2);
}

/// Returns the red component of one ray whose layers are shaded by the gradient at their middle, with a lamp
/// at the camera. `start`: position of the first sample, mm along the ray, in air.
double shaded_at_middles(const BruteForceRay& twin, const Camera::Ray& ray, double start, double colour) {
  const Volume& scan = twin.scan;
  const auto value = [&](const dvec3& world) { return twin.value(scan.frame.volume_from_world(world)); };
  double red = 0, passed = 1;
  for (double t = start; t < start + 40 && passed > 0.005; t += twin.step) {
    const double first = value(ray.from + t * ray.along),
                 second = value(ray.from + (t + twin.step) * ray.along);
    double depth = 0;
    for (int part = 0; part < 16; ++part)
      depth -= twin.step / 16 * std::log(twin.passes(first + (second - first) * (part + 0.5) / 16));
    const dvec3 middle = ray.from + (t + 0.5 * twin.step) * ray.along;
    dvec3 g(0);
    for (int a = 0; a < 3; ++a) {
      dvec3 h(0);
      h[a] = 0.3;
      g[a] = value(middle + h) - value(middle - h);
    }
    const double size = glm::length(g);
    // The lamp of DirectImage is at another position, which changes the brightness but not the rings.
    const double brightness = size > 0.6 ? 0.22 + 0.78 * std::abs(glm::dot(g / size, ray.along)) : 0.7;
    const double share = passed * (1 - std::exp(-depth));
    red += share * colour * brightness;
    passed -= share;
  }
  return red;
}

/// Inside uniform bone the gradient vanishes. The depth at which it vanishes must not show as rings. Rings
/// move if the first sample of the rays is shifted. Their amplitude is the deviation of the pixels from their
/// means over all shifts (rms).
TEST(DirectImage, ShadingOfUniformBoneShowsNoRings) {
  const auto scan = scan_of({80, 80, 80}, dmat3(0.5), [](const dvec3& p) {
    return -1000 + 2200 * std::clamp((14 - glm::length(p)) / 1.0 + 0.5, 0.0, 1.0);
  });
  const dvec3 colour(0.8);
  const TransferFunction bone{{150, colour, 0}, {300, colour, 0.3}, {1200, colour, 0.9}};
  DirectImage image(scan, 2);
  image.set_transfer_function(bone);
  const Version uncut(scan);
  RaycastRequest request;
  request.camera = camera_at({10, -300, 20}, 60, 20);
  const double step = image.default_step_mm();
  const BruteForceRay twin{*scan, uncut, bone, request, step};
  constexpr int k_shifts = 6, k_every = 6, k_pixels = 60;
  constexpr double k_start = 18;  // mm from the centre of the ball, in air
  std::vector<std::array<double, k_shifts>> drawn, middles;
  for (int shift = 0; shift < k_shifts; ++shift) {
    const double height = k_start - shift * step / k_shifts;
    request.openings.plane = Openings::Plane{-height * request.camera.forward, -request.camera.forward};
    std::vector<DirectPixel> pixels(k_pixels * k_pixels);
    image.draw(request, uncut, {}, 2, pixels);
    drawn.resize(pixels.size());
    for (std::size_t n = 0; n < pixels.size(); ++n)
      drawn[n][static_cast<std::size_t>(shift)] = static_cast<double>(pixels[n].red);
    std::size_t at = 0;
    for (int j = 0; j < k_pixels; j += k_every)
      for (int i = 0; i < k_pixels; i += k_every, ++at) {
        const Camera::Ray ray = request.camera.ray(i, j);
        const double cosine = glm::dot(ray.along, request.camera.forward),
                     start = (request.camera.distance - height) / cosine;
        middles.resize(std::max(middles.size(), at + 1));
        middles[at][static_cast<std::size_t>(shift)] = shaded_at_middles(twin, ray, start, colour.x);
      }
  }
  const auto amplitude = [](const std::vector<std::array<double, k_shifts>>& all) {
    double square = 0;
    for (const auto& pixel : all) {
      double mean = 0;
      for (const double red : pixel) mean += red / k_shifts;
      for (const double red : pixel)
        square += (red - mean) * (red - mean) / k_shifts / static_cast<double>(all.size());
    }
    return std::sqrt(square);
  };
  std::printf("rings of %.4f (rms); by the gradient at the middle %.4f\n", amplitude(drawn),
              amplitude(middles));
  EXPECT_LT(amplitude(drawn), 0.004);
  EXPECT_GT(amplitude(middles), 0.01);  // planted fault
}

TEST(DirectImage, ChecksTransferFunctionsAndFindsTheirWindows) {
  EXPECT_TRUE(check(TransferFunction{}).has_value());
  EXPECT_TRUE(check(TransferFunction{{0, dvec3(1), 0}, {0, dvec3(1), 1}}).has_value());
  EXPECT_TRUE(check(TransferFunction{{0, dvec3(1), 1.2}}).has_value());
  EXPECT_TRUE(check(TransferFunction{{0, dvec3(2), 0.2}}).has_value());
  EXPECT_TRUE(check(TransferFunction{{NAN, dvec3(1), 0.2}}).has_value());
  EXPECT_FALSE(check(k_bone).has_value());
  const auto bone = window_of_opacity(k_bone, 0.3);
  ASSERT_TRUE(bone.has_value());
  EXPECT_NEAR(*bone->low, 300, 1e-9);
  EXPECT_FALSE(bone->high.has_value());
  const TransferFunction skin{
      {-400, dvec3(1), 0}, {-200, dvec3(1), 0.4}, {0, dvec3(1), 0.4}, {100, dvec3(1), 0}};
  const auto between = window_of_opacity(skin, 0.2);
  ASSERT_TRUE(between.has_value());
  EXPECT_NEAR(*between->low, -300, 1e-9);
  EXPECT_NEAR(*between->high, 50, 1e-9);
  EXPECT_FALSE(window_of_opacity(skin, 0.5).has_value());
  // If two ranges of intensities are opaque enough, the window is the longer one.
  const TransferFunction two_runs{{0, dvec3(1), 0},   {10, dvec3(1), 1},  {20, dvec3(1), 0},
                                  {100, dvec3(1), 0}, {200, dvec3(1), 1}, {300, dvec3(1), 0}};
  EXPECT_NEAR(*window_of_opacity(two_runs, 0.5)->low, 150, 1e-9);
  Camera camera;
  EXPECT_FALSE(check(camera).has_value());
  camera.up = {0, 1, 0};
  EXPECT_TRUE(check(camera).has_value());
}

}  // namespace
}  // namespace trephine::volume
