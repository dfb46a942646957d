#include "apps/bench/depth_images.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "apps/bench/bench_library.h"
#include "apps/bench/depth_models.h"
#include "apps/bench/measure.h"
#include "apps/bench/peers.h"
#include "apps/bench/scenes/scenes.h"
#include "apps/bench/voxel_images.h"
#include "data-tools/phantoms/phantoms.h"
#include "haptics/depth/depth_cube.h"
#include "haptics/depth/depth_model.h"
#include "haptics/methods/methods.h"
#include "volume/cuts/removal.h"
#include "volume/imaging/direct_image.h"
#include "volume/surface/surface_nets.h"

namespace trephine::bench {

using glm::dvec3;
using glm::ivec3;
using namespace haptics;
using depth::DepthCube;

namespace {

template <class Work>
double min_ms(int runs, Work&& work) {
  double least = 1e300;
  for (int run = 0; run < runs; ++run) {
    const auto begin = Clock::now();
    work();
    least = std::min(least, 1e3 * seconds_since(begin));
  }
  return least;
}

DrawPeer draw_peer() {
  static const auto found = find_in_library<DrawPeer>("libtrephine-render-peer.so", "trephine_draw_peer");
  return found;
}

struct Floats {
  std::vector<float> vertices;
  explicit Floats(const std::vector<dvec3>& from) {
    for (const dvec3& p : from)
      for (int a = 0; a < 3; ++a) vertices.push_back(static_cast<float>(p[a]));
  }
};

/// Counts the pixels in which a peer's images differ from ours. The rays of `ours` pass through the centres
/// of the peer's pixels.
long count_differing_pixels(const DepthCube& ours, const SixImages& peer, double edge) {
  constexpr double k_apart = 2e-3;  // mm; rasterisers snap vertices to 1/256 pixel
  const int pixels = peer.pixels;
  const double step = edge / pixels;
  long count = 0;
  const float* mm = peer.mm.data();
  for (int camera = 0; camera < 6; ++camera) {
    const int axis = camera / 2, u = (axis + 1) % 3, v = (axis + 2) % 3;
    for (int row = 0; row < pixels; ++row)
      for (int column = 0; column < pixels; ++column, ++mm) {
        const auto ray = ours.ray(axis, u < v ? column : row, u < v ? row : column);
        double first = edge;
        for (const float crossing : ray) {
          const double from_low = (static_cast<double>(crossing) + 0.5) * step;
          if (from_low <= 0 || from_low >= edge)
            continue;  // beyond the cube, or where a ray starts in matter
          first = std::min(first, camera % 2 == 0 ? from_low : edge - from_low);
        }
        const double distance = static_cast<double>(*mm);
        const bool has_peer_hit = distance < edge - k_apart, has_our_hit = first < edge - k_apart;
        count += has_peer_hit != has_our_hit || (has_peer_hit && std::abs(distance - first) > k_apart);
      }
  }
  return count;
}

DrawPeerRequest request_of(const Floats& floats, const BenchModel& m, const dvec3& middle, double edge,
                           int rounds, SixImages& images) {
  DrawPeerRequest request{floats.vertices.data(),
                          static_cast<long>(m.vertices.size()),
                          m.triangles.data(),
                          static_cast<long>(m.triangles.size() / 3),
                          {},
                          edge,
                          rounds,
                          images.mm.data()};
  for (int a = 0; a < 3; ++a) request.middle[a] = middle[a];
  return request;
}

}  // namespace

std::vector<ImagesRow> run_depth_images(bool is_quick, MakeDrawTarget make_draw_target) {
  std::vector<ImagesRow> rows;
  const std::vector<int> counts =
      is_quick ? std::vector{69'451} : std::vector{69'451, 200'000, 400'000, 800'000, 1'600'000};
  const std::vector<int> sizes = is_quick ? std::vector{100} : std::vector{100, 250, 500, 1000};
  for (const int count : counts) {
    const BenchModel m = ball_of(count);
    const Floats floats(m.vertices);
    const dvec3 contact_point = k_ball_radius * direction(3);
    constexpr double k_edge = 20;  // mm
    for (const int pixels : sizes) {
      // The smallest and the largest model at every size, and every model at 100^2 pixels.
      if (pixels != 100 && count != 69'451 && count != 1'600'000) continue;
      ImagesRow row;
      row.triangles = count, row.pixels = pixels;
      const double step = k_edge / pixels;
      row.ours_ms = min_ms(3, [&] {
        (void)DepthCube::of_triangles(
            m.vertices, m.triangles,
            volume::Frame::from_spacing(contact_point - 0.5 * k_edge, dvec3(step)).value(), ivec3(pixels))
            .value();
      });
      // Rays through pixel centres, as in the peers.
      const auto ours_at = [&](const dvec3& middle) {
        const dvec3 first = middle - 0.5 * k_edge + 0.5 * step;
        return DepthCube::of_triangles(m.vertices, m.triangles,
                                       volume::Frame::from_spacing(first, dvec3(step)).value(), ivec3(pixels))
            .value();
      };
      SixImages images(pixels);
      if (peers().embree_images) {
        const double at[3] = {contact_point.x, contact_point.y, contact_point.z};
        row.embree_build_ms = peers().embree_images(
            floats.vertices.data(), static_cast<long>(m.vertices.size()), m.triangles.data(),
            static_cast<long>(m.triangles.size() / 3), at, k_edge, pixels, row.embree_ms, images.mm.data());
        row.embree_differing_pixels = count_differing_pixels(ours_at(contact_point), images, k_edge);
      }
      if (const DrawTarget target = make_draw_target(pixels); target.window && draw_peer()) {
        DrawPeerResult answer;
        if (draw_peer()(request_of(floats, m, contact_point, k_edge, 3, images), target.window, answer)) {
          row.gl_first_ms = answer.first_ms, row.gl_ms = answer.draw_ms + answer.read_ms;
          row.gl_differing_pixels = count_differing_pixels(ours_at(contact_point), images, k_edge);
        }
      }
      if (row.embree_differing_pixels >= 0 || row.gl_differing_pixels >= 0)
        row.moved_differing_pixels =
            count_differing_pixels(ours_at(contact_point + dvec3(step, 0, 0)), images, k_edge);
      rows.push_back(row);
    }
  }
  return rows;
}

std::vector<EditRow> run_depth_edits(bool is_quick) {
  data_tools::PhantomOptions o;
  const int side = is_quick ? 128 : 256;
  o.size = ivec3(side);
  o.spacing_mm = dvec3(128.0 / side);
  o.psf_sigma_voxels = 1;
  const TouchScene scene = scenes::phantom_scene("shell", o);
  const TouchItem& bone = scene.items[0];
  const auto start =
      std::make_shared<volume::Version>(scene.base, volume::CutLattice::for_burr(*scene.base, 4).value());
  const dvec3 middle = scene.base->frame.world_from_volume(0.5 * (dvec3(scene.base->size) - 1.0));
  // Finds the outer surface of the shell in a direction, by a march inward.
  const auto outside = [&](const dvec3& out) {
    double far = 80;
    while (far > 0 && scene.base->contains(ivec3(scene.base->frame.volume_from_world(middle + far * out))) &&
           !bone.bits->is_solid(ivec3(scene.base->frame.volume_from_world(middle + far * out))))
      far -= 0.25;
    return middle + far * out;
  };
  std::vector<EditRow> rows;
  for (const double burr : is_quick ? std::vector{4.0} : std::vector{1.0, 2.0, 4.0, 6.0}) {
    volume::RemovalEditor editor(start, {bone.field});
    EditRow row;
    row.burr = burr;
    volume::SurfaceSource source{&bone.field, start.get(), bone.bits.get()};
    std::shared_ptr<const volume::Version> current = start;
    VoxelImages images(source);
    row.all_ms = min_ms(2, [&] { images = VoxelImages(source); });
    std::vector<double> us, net_ms, tree_ms;
    for (int n = 0; n < 40; ++n) {
      const dvec3 at = outside(direction(n));
      const volume::RemovalReport cut = editor.remove({at, at, 0.5 * burr});
      if (cut.removed_units == 0) continue;
      current = editor.freeze();
      source.version = current.get();
      auto begin = Clock::now();
      images.update(source, cut.box);
      us.push_back(1e6 * seconds_since(begin));
      const ivec3 chunk = (ivec3(scene.base->frame.volume_from_world(at)) + 1) / volume::k_chunk;
      begin = Clock::now();
      const volume::Mesh net = volume::surface_net_chunk(source, chunk);
      net_ms.push_back(1e3 * seconds_since(begin));
      row.triangles = std::max(row.triangles, static_cast<long>(net.triangles.size() / 3));
      if (peers().embree_build_ms && net.triangles.size() > 0)
        tree_ms.push_back(peers().embree_build_ms(
            &net.vertices.span()[0].x, static_cast<long>(net.vertices.size()), net.triangles.span().data(),
            static_cast<long>(net.triangles.size() / 3)));
    }
    row.update_us = times_of(us).p50, row.net_ms = times_of(net_ms).p50;
    if (!tree_ms.empty()) row.embree_ms = times_of(tree_ms).p50;
    rows.push_back(row);
  }
  return rows;
}

std::vector<FrameRow> run_frame_times(bool is_quick, MakeDrawTarget make_draw_target) {
  std::vector<FrameRow> rows;
  data_tools::PhantomOptions o;
  o.size = ivec3(128);
  const TouchScene scene = scenes::phantom_scene("sphere", o);
  const auto version = uncut_version(scene);
  const auto method = make_method(k_default_method).value();
  if (method->prepare(scene)) return rows;
  const TouchState touch_state(version);
  // Cost of voxel touch during a frame: the time of the 16 servo steps that run meanwhile. They run on
  // another thread, but are counted as a cost of the frame.
  const dvec3 middle = scene.base->frame.world_from_volume(0.5 * (dvec3(scene.base->size) - 1.0));
  const auto steps_us = [&] {
    ProxyState state;
    for (int i = 0; i < 400; ++i)
      (void)method->step(scene, touch_state, state, {middle + (80.0 - 0.1 * i) * direction(5)});
    return 1e3 * min_ms(5, [&] {
             for (int i = 0; i < 16; ++i)
               (void)method->step(scene, touch_state, state, {middle + (40.0 + 0.01 * i) * direction(5)});
           });
  };
  constexpr int k_pixels = 512;
  for (const int count :
       is_quick ? std::vector{100'000} : std::vector{100'000, 200'000, 400'000, 800'000, 1'200'000}) {
    const BenchModel m = ball_of(count);
    const Floats floats(m.vertices);
    FrameRow row;
    row.triangles = count;
    row.voxel_touch_us = steps_us();
    const dvec3 contact_point = k_ball_radius * direction(3);
    row.depth_ms = min_ms(3, [&] {
      (void)DepthCube::of_triangles(m.vertices, m.triangles,
                                    volume::Frame::from_spacing(contact_point - 10.0, dvec3(0.2)).value(),
                                    ivec3(100))
          .value();
    });
    long near = 0;
    row.feedback_ms = min_ms(3, [&] {
      near = 0;
      for (std::size_t t = 0; t + 2 < m.triangles.size(); t += 3) {
        const dvec3 &a = m.vertices[m.triangles[t]], &b = m.vertices[m.triangles[t + 1]],
                    &c = m.vertices[m.triangles[t + 2]];
        const dvec3 low = glm::min(glm::min(a, b), c), high = glm::max(glm::max(a, b), c);
        near += glm::length(contact_point - glm::clamp(contact_point, low, high)) < 5;
      }
    });
    if (near == 0) row.feedback_ms = -1;  // uses the count, so that the compiler keeps the timed loop
    if (const DrawTarget target = make_draw_target(k_pixels); target.window && draw_peer()) {
      DrawPeerResult answer;
      SixImages images(k_pixels);
      if (draw_peer()(request_of(floats, m, dvec3(0), 2.5 * k_ball_radius, 3, images), target.window,
                      answer)) {
        row.draw_ms = answer.draw_ms / 6;
        row.redraw_ms = (answer.draw_ms + answer.read_ms) / 6;
      }
    }
    rows.push_back(row);
  }
  volume::DirectImage image(scene.base);
  image.set_transfer_function({{0, dvec3(1), 0}, {500, dvec3(1), 0.6}, {1000, dvec3(1), 0.9}});
  const double wide = scene.base->frame.spacing().x * scene.base->size.x;
  volume::RaycastRequest request;
  request.camera.forward = {0, 1, 0}, request.camera.up = {0, 0, 1};
  request.camera.at = middle - dvec3(0, 3 * wide, 0);
  request.camera.distance = 3 * wide, request.camera.height = 1.2 * wide;
  request.camera.columns = request.camera.rows = k_pixels;
  std::vector<volume::DirectPixel> pixels(static_cast<std::size_t>(k_pixels) * k_pixels);
  for (const int samples_across : is_quick ? std::vector{200} : std::vector{200, 500, 1000, 2000}) {
    FrameRow row;
    row.samples_across = samples_across;
    request.step = wide / samples_across;
    row.voxel_touch_us = steps_us();
    row.draw_ms = min_ms(3, [&] { image.draw(request, *version, {}, 0, pixels); });
    rows.push_back(row);
  }
  return rows;
}

}  // namespace trephine::bench
