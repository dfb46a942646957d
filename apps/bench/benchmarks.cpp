#include "apps/bench/benchmarks.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <memory>
#include <thread>
#include <utility>

#include "apps/bench/peer_flying_edges.h"
#include "apps/bench/peers.h"
#include "apps/bench/scenes/scenes.h"
#include "haptics/device/composite_device.h"
#include "haptics/device/latest.h"
#include "haptics/device/mapped_device.h"
#include "haptics/methods/methods.h"
#include "haptics/proxy/implicit_proxy.h"
#include "sim/engine/engine.h"
#include "volume/base/channel.h"
#include "volume/cuts/removal.h"
#include "volume/surface/surface_nets.h"

namespace trephine::bench {

using glm::dvec3;

namespace {

data_tools::PhantomOptions grid(int size, double psf) {
  data_tools::PhantomOptions o;
  o.size = glm::ivec3(size);
  o.psf_sigma_voxels = psf;
  return o;
}

/// Plays a path several times. Returns percentiles, over the steps in contact, of the shortest time of each
/// step. Sets the mean numbers of voxels and cells per step.
StepTimes time_steps(const haptics::TouchScene& scene, const haptics::PosePath& path, double& voxels,
                     double& cells) {
  haptics::ImplicitProxy method;
  if (method.prepare(scene)) return {};
  const volume::Version version(scene.base);
  MinimumOfRuns minima;
  long voxel_count = 0, cell_count = 0;
  for (int run = 0; run < MinimumOfRuns::k_runs; ++run) {
    haptics::ProxyState state;
    for (std::size_t i = 0; i < path.samples().size(); ++i) {
      const auto start = Clock::now();
      const haptics::ProxyStep step =
          method.step(scene, version, state, {path.samples()[i].pose.position_world});
      const double us = 1e6 * seconds_since(start);
      if (step.has_contact) minima.add(i, us);
      voxel_count += step.counters.voxels;
      cell_count += step.counters.cells;
    }
  }
  const double steps = static_cast<double>(path.samples().size()) * MinimumOfRuns::k_runs;
  voxels = static_cast<double>(voxel_count) / steps;
  cells = static_cast<double>(cell_count) / steps;
  return minima.result();
}

/// Corner of a room at the origin: three square walls of `size` mm, of right triangles with legs of `edge`
/// mm.
haptics::TouchItem mesh_corner(double size, double edge) {
  std::vector<dvec3> vertices;
  std::vector<std::uint32_t> triangles;
  const auto count = static_cast<std::uint32_t>(std::lround(size / edge));
  for (int axis = 0; axis < 3; ++axis) {
    const auto first = static_cast<std::uint32_t>(vertices.size());
    for (std::uint32_t j = 0; j <= count; ++j)
      for (std::uint32_t i = 0; i <= count; ++i) {
        dvec3 p(0);
        p[(axis + 1) % 3] = i * edge, p[(axis + 2) % 3] = j * edge;
        vertices.push_back(p);
      }
    for (std::uint32_t j = 0; j < count; ++j)
      for (std::uint32_t i = 0; i < count; ++i) {
        const std::uint32_t a = first + j * (count + 1) + i, c = a + count + 1;
        for (const std::uint32_t corner : {a, a + 1, c + 1, a, c + 1, c}) triangles.push_back(corner);
      }
  }
  return haptics::mesh_item("corner", std::make_shared<const haptics::MeshTree>(vertices, triangles));
}

/// Times a rod of balls that a hand presses into a corner of a mesh, moves along its walls and turns.
StepTimes time_chain_in_corner() {
  haptics::TouchScene scene;
  const auto frame = volume::Frame::from_spacing(dvec3(-100), dvec3(0.5)).value();
  scene.base = std::make_shared<const volume::Volume>(volume::make_volume(glm::ivec3(8), frame).value());
  scene.items.push_back(mesh_corner(60, 0.5));
  std::vector<dvec3> centres;
  for (int i = 0; i < static_cast<int>(haptics::ToolShape::k_max_balls); ++i)
    centres.push_back({2.0 * i, 0, 0});
  scene.tool = haptics::make_tool(3, centres).value();
  const auto method = haptics::make_method(haptics::general_method(*scene.tool).name).value();
  if (method->prepare(scene)) return {};
  const haptics::TouchState uncut(std::shared_ptr<const volume::Version>(haptics::uncut_version(scene)));
  constexpr int k_steps = 6000;
  MinimumOfRuns minima;
  for (int run = 0; run < MinimumOfRuns::k_runs; ++run) {
    haptics::ProxyState state;
    for (int i = 0; i < k_steps; ++i) {
      const double t = 1e-3 * i;
      const dvec3 sway(std::sin(3 * t), std::sin(4.1 * t + 1), std::sin(2.3 * t + 2)),
          rotation(0.3 * std::sin(2 * t), 0.5 + 0.4 * std::sin(1.7 * t), 0.6 + 0.4 * std::sin(1.3 * t));
      const dvec3 hip = dvec3(8 - 9 * std::min(1.0, t)) + 2.0 * sway;
      const glm::dquat turn = glm::normalize(glm::dquat(1, 0.5 * rotation));
      const auto start = Clock::now();
      const haptics::ProxyStep step =
          method->step(scene, uncut, state, {.hip_world = hip, .orientation = turn});
      const double us = 1e6 * seconds_since(start);
      if (step.has_contact) minima.add(static_cast<std::size_t>(i), us);
    }
  }
  return minima.result();
}

}  // namespace

SurfaceResult run_surface_benchmark(int size) {
  SurfaceResult result;
  for (const char* name : {"shell", "gyroid"}) {
    const volume::Volume volume =
        data_tools::make_phantom(name, grid(size, name[0] == 'g' ? 1.5 : 0)).value();
    const volume::Field field(volume, volume::Shape{});
    for (const int threads : {1, 2}) {
      SurfaceRow row{name, size, threads, 1e300, 1e300, 0, 0};
      for (int run = 0; run < 3; ++run) {
        const auto start = Clock::now();
        const volume::Mesh mesh = volume::surface_net({&field}, threads);
        row.our_ms = std::min(row.our_ms, 1e3 * seconds_since(start));
        row.our_triangles = mesh.triangle_count();
        const int dimensions[3] = {size, size, size};
        const PeerSurface peer = flying_edges(volume.voxels.data(), dimensions, 300, threads);
        row.peer_ms = std::min(row.peer_ms, 1e3 * peer.seconds);
        row.peer_triangles = peer.triangles;
      }
      result.rows.push_back(row);
    }
  }

  // A burr moves through the shell's bone. After each tick, the chunk at its centre is remeshed.
  const haptics::TouchScene scene = scenes::phantom_scene("shell", grid(size, 0));
  const double spacing = scene.base->frame.spacing().x;
  volume::NetScratch scratch;
  MinimumOfRuns minima;
  for (int run = 0; run < MinimumOfRuns::k_runs; ++run) {
    volume::RemovalEditor editor(std::make_shared<volume::Version>(scene.base), {scene.items[0].field});
    dvec3 at(-20, 20, 0);
    at.z = std::sqrt(48.0 * 48.0 - 800.0);
    for (std::size_t i = 0; i < 500; ++i) {
      const dvec3 to = at + dvec3(0.08, 0.02, -0.01);
      editor.remove({at, to, 8 * spacing, i > 0});
      const auto version = editor.publish();
      at = to;
      const glm::ivec3 voxel(scene.base->frame.volume_from_world(at));
      const glm::ivec3 chunk = (voxel + 1) / volume::k_chunk;
      const auto start = Clock::now();
      const volume::Mesh mesh = volume::surface_net_chunk(
          {&scene.items[0].field, version.get(), scene.items[0].bits.get()}, chunk, &scratch);
      minima.add(i, 1e6 * seconds_since(start));
      result.drilled_chunk_vertices = std::max(result.drilled_chunk_vertices, mesh.vertices.size());
    }
  }
  result.drilled_chunk = minima.result();

  // Meshing of every chunk of the shell that contains surface.
  MinimumOfRuns everywhere;
  const volume::SurfaceSource whole{&scene.items[0].field, nullptr, scene.items[0].bits.get()};
  const glm::ivec3 chunks = volume::chunk_grid(scene.base->size);
  for (int run = 0; run < MinimumOfRuns::k_runs; ++run) {
    std::size_t step = 0;
    for (int z = 0; z < chunks.z; ++z)
      for (int y = 0; y < chunks.y; ++y)
        for (int x = 0; x < chunks.x; ++x) {
          const auto start = Clock::now();
          const volume::Mesh mesh = volume::surface_net_chunk(whole, {x, y, z}, &scratch);
          const double us = 1e6 * seconds_since(start);
          if (mesh.triangle_count() > 0) everywhere.add(step++, us);
        }
  }
  result.surface_chunk = everywhere.result();
  return result;
}

namespace {

/// Times the ticks of a ball of 24 voxels in diameter that cuts solid bone at 50 mm/s, with a version
/// published each tick. The bone is uncut, or contains scratches: 16 narrow cuts along each stroke, made by a
/// ball of 2 voxels in diameter.
StepTimes time_removal(const haptics::TouchScene& bone, bool has_scratches) {
  MinimumOfRuns minima;
  const dvec3 direction = glm::normalize(dvec3(1, 0.3, -0.2));
  for (int run = 0; run < MinimumOfRuns::k_runs; ++run) {
    volume::RemovalEditor editor(std::make_shared<volume::Version>(bone.base), {bone.items[0].field});
    Channel<volume::Version> channel(editor.publish());
    for (std::size_t lane = 0; lane < 4; ++lane) {
      // Four strokes of 20 mm, each in its own lane.
      const dvec3 start(-20, -10 + 6.5 * static_cast<double>(lane), -5);
      if (has_scratches)
        for (int i = 0; i < 16; ++i) {
          const dvec3 aside(0, 0.4 * (i % 4 - 1.5) * 3, 0.4 * (i / 4 - 1.5) * 3);
          editor.remove({start + aside - 2.0 * direction, start + aside + 22.0 * direction, 0.25, false});
        }
      editor.end_stroke();
      for (std::size_t k = 0; k < 400; ++k) {
        const dvec3 from = start + 0.05 * static_cast<double>(k) * direction, to = from + 0.05 * direction;
        const auto begin = Clock::now();
        editor.remove({from, to, 3, k > 0});
        channel.publish(editor.publish());
        const double us = 1e6 * seconds_since(begin);
        if (k >= 20) minima.add(400 * lane + k, us);  // the plunge of a whole ball is not a typical tick
      }
    }
  }
  return minima.result();
}

/// Plays ticks of a burr as in a live session, on a simulated clock. An update of the offset field contains
/// the cuts made before it began; later cuts wait for the next update.
void time_hover(StepResult& result) {
  data_tools::PhantomOptions o = grid(128, 1.5);
  o.spacing_mm = dvec3(0.5);
  haptics::TouchScene bone = scenes::phantom_scene("plane", o);
  const haptics::TouchItem& shape = bone.items[0];
  std::shared_ptr<const volume::OffsetField> field =
      volume::OffsetField::build(shape.field, *shape.bits, nullptr, 2).value();
  volume::RemovalEditor editor(std::make_shared<volume::Version>(bone.base), {shape.field});
  std::vector<double> updates, hovers;
  const auto at = [](double t_ms) {
    // Down by 5 mm, then along x at 10 mm/s, with a wave across.
    const double path = 0.01 * t_ms;
    return dvec3(-20 + std::max(0.0, path - 5), 3 * std::sin(0.3 * path), std::max(-3.0, 2 - path));
  };
  std::vector<double> waiting;  // times (ms) of cuts that no field contains yet
  volume::VoxelBox box{glm::ivec3(0), glm::ivec3(-1)};
  double busy_until = 0;
  std::vector<double> in_work;
  for (int tick = 0; tick < 4000; ++tick) {
    const volume::RemovalReport report = editor.remove({at(tick), at(tick + 1), 2, true});
    if (report.bricks_changed > 0) {
      waiting.push_back(tick);
      box = sim::union_of(box, report.box);
    }
    if (tick < busy_until || waiting.empty()) continue;
    for (const double cut : in_work) hovers.push_back(busy_until - cut);
    in_work = std::exchange(waiting, {});
    const auto version = editor.publish();
    const auto begin = Clock::now();
    field = field->updated(shape.field, *shape.bits, *version,
                           std::exchange(box, {glm::ivec3(0), glm::ivec3(-1)}));
    updates.push_back(1e3 * seconds_since(begin));
    busy_until = tick + updates.back();
  }
  result.field_update_ms = times_of(std::move(updates));
  result.hover_ms = times_of(std::move(hovers));
}

/// A device whose pose comes from a thread of its own.
class ReportingDevice final : public haptics::Device {
 public:
  Status open() override {
    driver_ = std::jthread([this](const std::stop_token& stop) {
      haptics::Pose pose;
      for (int i = 0; !stop.stop_requested(); ++i) {
        pose.position_world.x = 0.01 * (i % 1000);
        latest_.set(pose);
        std::this_thread::sleep_for(std::chrono::microseconds(250));
      }
    });
    return std::nullopt;
  }
  void close() noexcept override { driver_ = {}; }
  haptics::DeviceCapabilities capabilities() const override { return {.name = "benchmark"}; }
  bool read(double, haptics::Pose& pose) noexcept override {
    if (const auto latest = latest_.get()) last_ = *latest;
    pose = last_;
    return true;
  }
  void write(const haptics::Wrench& wrench) noexcept override { wrench_.set(wrench); }

 private:
  haptics::Latest<haptics::Pose> latest_;
  haptics::Latest<haptics::Wrench> wrench_;
  haptics::Pose last_;
  std::jthread driver_;
};

/// Sets the time of one read and one write, ns.
void time_device(haptics::Device& device, StepTimes& read, StepTimes& write) {
  device.set_view({});
  if (device.open()) return;
  constexpr int k_batches = 4000, k_calls = 64;  // a batch is long compared with a reading of the clock
  std::vector<double> reads, writes;
  haptics::Pose pose;
  double t = 0;
  for (int batch = 0; batch < k_batches; ++batch) {
    const auto begin = Clock::now();
    for (int i = 0; i < k_calls; ++i) device.read(t += 1e-3, pose);
    reads.push_back(1e9 * seconds_since(begin) / k_calls);
    const auto middle = Clock::now();
    for (int i = 0; i < k_calls; ++i) device.write({pose.position_world});
    writes.push_back(1e9 * seconds_since(middle) / k_calls);
  }
  device.close();
  read = times_of(std::move(reads)), write = times_of(std::move(writes));
}

void time_devices(StepResult& result) {
  ReportingDevice alone;
  time_device(alone, result.device_read, result.device_write);
  haptics::MappedDevice mapped(std::make_shared<haptics::CompositeDevice>(
                                   std::make_shared<ReportingDevice>(), std::make_shared<ReportingDevice>()),
                               {});
  time_device(mapped, result.mapped_read, result.mapped_write);
}

}  // namespace

StepResult run_step_benchmark(int size) {
  StepResult result;
  double cells = 0;
  {
    const haptics::TouchScene scene = scenes::phantom_scene("sphere", grid(size, 1.5));
    result.implicit = time_steps(scene, scenes::sphere_slide(45, 1, 100, 3), result.voxels_per_step, cells);
  }
  // A small sphere in volumes of increasing size, with voxels of equal size.
  for (const int n : {50, 100, 200, 400, 800}) {
    if (n > 400 && n > size) continue;
    if (static_cast<std::size_t>(n) * static_cast<std::size_t>(n) * static_cast<std::size_t>(n) * 8 >
        volume::available_memory_bytes())
      continue;
    data_tools::PhantomOptions o = grid(n, 1.5);
    o.spacing_mm = dvec3(120.0 / 512);
    o.parameters = {{"radius", 4.5}};
    ScalingRow row;
    row.size = n;
    row.step = time_steps(scenes::phantom_scene("sphere", o), scenes::sphere_slide(4.5, 0.5, 50, 3),
                          row.voxels_per_step, row.cells_per_step);
    result.fixed_density.push_back(row);
  }

  result.chain_corner = time_chain_in_corner();
  data_tools::PhantomOptions o = grid(256, 1);
  o.spacing_mm = dvec3(0.25);
  const haptics::TouchScene bone = scenes::phantom_scene("plane", o);
  result.removal_tick = time_removal(bone, false);
  result.removal_tick_over_scratches = time_removal(bone, true);
  time_hover(result);
  time_devices(result);
  if (peers().csg_ticks != nullptr) {
    const dvec3 step = 0.05 * glm::normalize(dvec3(1, 0.3, -0.2));
    MinimumOfRuns difference, with_capsule;
    for (int run = 0; run < MinimumOfRuns::k_runs; ++run) {
      const CsgTicks ticks = peers().csg_ticks(0.25, 3, &step.x, 4, 400);
      for (std::size_t i = 0; i < ticks.difference_us.size(); ++i) {
        if (i % 400 < 20) continue;
        difference.add(i, ticks.difference_us[i]);
        with_capsule.add(i, ticks.with_capsule_us[i]);
      }
    }
    result.csg_tick = difference.result();
    result.csg_tick_with_capsule = with_capsule.result();
  }
  return result;
}

}  // namespace trephine::bench
