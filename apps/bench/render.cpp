#include "apps/bench/render.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <memory>

#include "apps/bench/bench_library.h"
#include "apps/bench/measure.h"
#include "data-tools/phantoms/phantoms.h"
#include "volume/cuts/removal.h"
#include "volume/imaging/direct_image.h"

namespace trephine::bench {

using glm::dvec3;
using volume::DirectPixel;

namespace {

constexpr int k_render_pixels = 512, k_render_runs = 4;
constexpr double k_ramp[] = {160, 0, 320, 0.55, 1200, 0.95};

}  // namespace

std::vector<RenderRow> run_render_benchmark(int size, vtkRenderWindow* window) {
  data_tools::PhantomOptions o;
  o.size = glm::ivec3(size);
  o.psf_sigma_voxels = 1.2, o.is_psf_given = true;
  o.parameters["noise"] = 15;
  auto phantom = std::make_shared<volume::Volume>(data_tools::make_phantom("shell", o).value());
  phantom->is_hounsfield = true;
  const std::shared_ptr<const volume::Volume> scan = phantom;
  const double mm = scan->frame.spacing().x;
  const dvec3 middle = scan->frame.world_from_volume(0.5 * (dvec3(scan->size) - 1.0));

  volume::TransferFunction ramp;
  for (std::size_t i = 0; i < std::size(k_ramp); i += 2) ramp.push_back({k_ramp[i], dvec3(1), k_ramp[i + 1]});
  volume::RaycastRequest request;
  const dvec3 from = glm::normalize(dvec3(0.55, -1, 0.38));
  constexpr double k_half_angle = 14 * 3.14159265358979 / 180;
  const double distance = 0.5 * mm * size / std::tan(k_half_angle) * 1.25;
  request.camera.at = middle + distance * from;
  request.camera.forward = -from;
  request.camera.up = glm::normalize(dvec3(0, 0, 1) - from.z * from);
  request.camera.distance = distance, request.camera.height = 2 * distance * std::tan(k_half_angle);
  request.camera.columns = request.camera.rows = k_render_pixels;
  request.is_shaded = false;

  volume::DirectImage image(scan);
  image.set_transfer_function(ramp);
  const volume::Field bone(*scan, volume::Shape{"bone", 300});
  auto start = std::make_shared<volume::Version>(scan, volume::CutLattice::for_burr(*scan, 4).value());
  volume::RemovalEditor editor(start, {bone});
  const auto uncut = editor.freeze();
  std::vector<DirectPixel> pixels(static_cast<std::size_t>(k_render_pixels) * k_render_pixels);
  const auto opacities = [&] {
    std::vector<double> all;
    for (const DirectPixel& p : pixels) all.push_back(static_cast<double>(p.opacity));
    return all;
  };
  request.step = mm / 16;
  image.draw(request, *uncut, {}, 0, pixels);
  const std::vector<double> exact = opacities();

  std::vector<RenderRow> rows;
  const auto rms = [&](const auto& value) {
    double sum = 0;
    for (std::size_t i = 0; i < exact.size(); ++i) sum += std::pow(value(i) - exact[i], 2);
    return std::sqrt(sum / static_cast<double>(exact.size()));
  };
  std::shared_ptr<const volume::Version> now = uncut;
  for (const double voxels : {2.0, 1.0, 0.5, 0.25})
    for (const int threads : {1, 2}) {
      if (threads == 1 && voxels != 0.5) continue;
      RenderRow row{"ours", voxels * mm, threads, 1e300, 1e300};
      request.step = row.step;
      image.draw(request, *uncut, {}, threads, pixels);
      row.error = rms([&](std::size_t i) { return static_cast<double>(pixels[i].opacity); });
      for (int run = 0; run < k_render_runs; ++run) {
        auto begin = Clock::now();
        image.draw(request, *now, {}, threads, pixels);
        row.frame_ms = std::min(row.frame_ms, 1e3 * seconds_since(begin));
        const dvec3 at =
            middle +
            (0.39 * mm * size) * glm::normalize(from + 0.1 * dvec3(run, 0, static_cast<double>(rows.size())));
        editor.remove({at, at, 2});
        now = editor.freeze();
        begin = Clock::now();
        image.draw(request, *now, {}, threads, pixels);
        row.changed_ms = std::min(row.changed_ms, 1e3 * seconds_since(begin));
      }
      rows.push_back(row);
    }
  const RenderPeer peer =
      window != nullptr ? find_in_library<RenderPeer>("libtrephine-render-peer.so", "trephine_render_peer")
                        : nullptr;
  for (const auto& [name, is_on_gpu, threads] :
       {std::tuple("VTK fixed point", false, 1), std::tuple("VTK fixed point", false, 2),
        std::tuple("VTK OpenGL", true, 0)}) {
    RenderRow row{name, 0.5 * mm, threads};
    RenderPeerRequest peer_request{phantom->voxels.data(),
                                   size,
                                   mm,
                                   {},
                                   {},
                                   {},
                                   {},
                                   28,
                                   k_ramp,
                                   static_cast<int>(std::size(k_ramp) / 2),
                                   row.step,
                                   threads,
                                   is_on_gpu,
                                   {size / 2, size / 2, size / 8}};
    for (int a = 0; a < 3; ++a) {
      peer_request.origin[a] = scan->frame.origin()[a];
      peer_request.camera_position[a] = request.camera.at[a], peer_request.aim[a] = middle[a],
      peer_request.up[a] = request.camera.up[a];
    }
    RenderPeerAnswer answer;
    row.is_available =
        peer != nullptr && peer(peer_request, window, answer) && answer.greys.size() == exact.size();
    row.frame_ms = answer.frame_ms, row.changed_ms = answer.changed_ms;
    if (row.is_available)
      row.error = rms([&](std::size_t i) {
        const std::size_t column = i % k_render_pixels, line = i / k_render_pixels;
        return answer.greys[column + k_render_pixels * (k_render_pixels - 1 - line)] / 255.0;
      });
    rows.push_back(row);
  }
  return rows;
}

}  // namespace trephine::bench
