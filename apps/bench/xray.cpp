#include "apps/bench/xray.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <thread>
#include <tuple>
#include <unistd.h>

#include "apps/bench/measure.h"
#include "apps/bench/scenes/scenes.h"
#include "apps/verify/exact_traversal.h"
#include "data-tools/phantoms/phantoms.h"
#include "haptics/device/device.h"
#include "haptics/proxy/subvoxel_proxy.h"
#include "modules/drilling/burr.h"
#include "modules/fluoroscopy/volume_xray.h"
#include "sim/drivers/live_session.h"
#include "volume/imaging/line_integrals.h"

namespace trephine::bench {

namespace fs = std::filesystem;
using glm::dvec3;

namespace {

constexpr int k_angles = 12, k_xray_runs = 3;
constexpr double k_to_source = 1000, k_to_detector = 1536, k_detector = 200;  // mm
/// Weights of plastimatch: 0 up to -800 HU, above that proportional to HU + 1000, with plastimatch's
/// attenuation of water.
constexpr volume::VoxelWeights k_weights{-800, -1000, 0, 2.2e-5f, 2.2e-5f};

volume::Volume volume_of(const std::string& name, int size) {
  data_tools::PhantomOptions o;
  o.size = glm::ivec3(size);
  o.psf_sigma_voxels = 1.5, o.is_psf_given = true;
  o.parameters["noise"] = 20;
  volume::Volume v = data_tools::make_phantom("shell", o).value();
  if (name == "solid")
    for (std::int16_t& voxel : v.voxels.span()) voxel = static_cast<std::int16_t>(voxel + 1000);
  return v;
}

/// Returns the rays of a view that is rotated around z as in plastimatch: at 0 degrees the source is at +x.
volume::RayFan fan_of(const volume::Volume& v, double degrees, int pixels) {
  const double a = glm::radians(degrees);
  const dvec3 to_source(std::cos(a), -std::sin(a), 0), right(std::sin(a), std::cos(a), 0), down(0, 0, -1);
  const double pixel = k_detector / pixels;
  const dvec3 corner =
      (k_to_source - k_to_detector) * to_source - 0.5 * pixel * (pixels - 1) * (right + down);
  volume::RayFan fan;
  fan.columns = fan.rows = pixels;
  fan.source = v.frame.volume_from_world(k_to_source * to_source);
  fan.corner = v.frame.volume_from_world(corner);
  fan.right = v.frame.vector_volume_from_world(pixel * right);
  fan.down = v.frame.vector_volume_from_world(pixel * down);
  return fan;
}
double length_of(const volume::Volume& v, const volume::RayFan& fan, int i, int j) {
  return glm::length(v.frame.vector_world_from_volume(fan.pixel(i, j) - fan.source));
}

/// Compares some rays of an image with exact arithmetic.
void judge(const volume::Volume& v, const volume::RayFan& fan, const std::vector<double>& sums,
           XrayRow& row) {
  const auto plain = [](const dvec3& p) { return std::array<double, 3>{p.x, p.y, p.z}; };
  const double heaviest = k_weights.of(*std::max_element(v.voxels.span().begin(), v.voxels.span().end()));
  for (int j = 3; j < fan.rows; j += fan.rows / 16)
    for (int i = 5; i < fan.columns; i += fan.columns / 16) {
      const auto visits = verify::exact_traversal(plain(fan.source), plain(fan.pixel(i, j)), {-1, -1, -1},
                                                  {v.size.x, v.size.y, v.size.z});
      long double sum = 0;
      for (std::size_t k = 0; k + 1 < visits.size(); ++k) {
        const glm::ivec3 voxel(visits[k].voxel[0], visits[k].voxel[1], visits[k].voxel[2]);
        if (!v.contains(voxel)) continue;
        const int hu = v.voxels[v.index(voxel.x, voxel.y, voxel.z)];
        if (hu > -800)
          sum +=
              (visits[k + 1].t_enter - visits[k].t_enter) * static_cast<long double>(2.2e-5f) * (hu + 1000);
      }
      const double expected = static_cast<double>(sum), length = glm::length(fan.pixel(i, j) - fan.source);
      const double error = std::abs(sums[static_cast<std::size_t>(i + fan.columns * j)] - expected);
      row.worst_error = std::max(row.worst_error, error / std::max(expected, heaviest / length));
      ++row.judged;
    }
}

/// Runs plastimatch, which writes images of scan.mha to the folder. Returns the duration of the whole
/// program, s; nullopt if it failed.
std::optional<double> run_plastimatch(const fs::path& folder, int pixels, int threads, int angles) {
  char command[1000];
  std::snprintf(command, sizeof command,
                "OMP_NUM_THREADS=%d plastimatch drr -t pfm -i exact -a %d -N 30 --sad %g --sid %g -r '%d %d' "
                "-z '%g %g' -o '0 0 0' -O %s/drr_ %s/scan.mha >/dev/null 2>&1",
                threads, angles, k_to_source, k_to_detector, pixels, pixels, k_detector, k_detector,
                folder.c_str(), folder.c_str());
  const auto begin = Clock::now();
  if (std::system(command) != 0) return std::nullopt;
  return seconds_since(begin);
}

/// Returns the floats of a PFM file in the order of the file; empty if it cannot be read.
std::vector<float> read_pfm(const fs::path& file, int pixels) {
  std::ifstream in(file, std::ios::binary);
  std::string line;
  for (int i = 0; i < 3; ++i) std::getline(in, line);
  std::vector<float> image(static_cast<std::size_t>(pixels * pixels));
  in.read(reinterpret_cast<char*>(image.data()), static_cast<std::streamsize>(image.size() * sizeof(float)));
  return in ? image : std::vector<float>();
}

}  // namespace

std::vector<XrayRow> run_xray_benchmark(int size, int pixels) {
  std::vector<XrayRow> rows;
  const fs::path folder = fs::temp_directory_path() / ("trephine-xray-" + std::to_string(::getpid()));
  const std::size_t count = static_cast<std::size_t>(pixels) * static_cast<std::size_t>(pixels);
  for (const char* name : {"shell", "solid"}) {
    const volume::Volume v = volume_of(name, size);
    fs::create_directories(folder);
    {
      std::ofstream out(folder / "scan.mha", std::ios::binary);
      const dvec3 at = v.frame.origin(), mm = v.frame.spacing();
      char header[500];
      std::snprintf(header, sizeof header,
                    "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n"
                    "TransformMatrix = 1 0 0 0 1 0 0 0 1\nOffset = %.17g %.17g %.17g\nElementSpacing = %.17g "
                    "%.17g %.17g\nDimSize = %d %d %d\nElementType = MET_SHORT\nElementDataFile = LOCAL\n",
                    at.x, at.y, at.z, mm.x, mm.y, mm.z, size, size, size);
      out << header;
      out.write(reinterpret_cast<const char*>(v.voxels.data()),
                static_cast<std::streamsize>(v.voxels.bytes()));
    }
    for (const int threads : {1, 2}) {
      XrayRow row;
      row.volume = name, row.size = size, row.pixels = pixels, row.threads = threads;
      const auto begin = Clock::now();
      const volume::LineIntegrals lines(v, k_weights, threads);
      row.preparing_ms = 1e3 * seconds_since(begin);
      double filled = 0;
      for (int z = 0; z < lines.blocks().z; ++z)
        for (int y = 0; y < lines.blocks().y; ++y)
          for (int x = 0; x < lines.blocks().x; ++x) filled += lines.is_filled({x, y, z});
      row.filled = filled / (static_cast<double>(lines.blocks().x) * lines.blocks().y * lines.blocks().z);
      std::vector<double> sums(count), joseph(count);
      std::vector<std::vector<float>> ours;
      double square = 0, largest = 0;
      for (int angle = 0; angle < k_angles; ++angle) {
        const volume::RayFan fan = fan_of(v, 30 * angle, pixels);
        for (const volume::RaySum how : {volume::RaySum::exact, volume::RaySum::joseph}) {
          double least = 1e300;
          for (int run = 0; run < k_xray_runs; ++run) {
            const auto start = Clock::now();
            lines.integrate(fan, {0, 0, pixels, pixels}, how, threads,
                            how == volume::RaySum::exact ? sums : joseph);
            least = std::min(least, 1e3 * seconds_since(start));
          }
          (how == volume::RaySum::exact ? row.exact_ms : row.joseph_ms) += least / k_angles;
        }
        std::vector<float> image;
        for (int j = 0; j < pixels; ++j)
          for (int i = 0; i < pixels; ++i) {
            const auto at = static_cast<std::size_t>(i + pixels * j);
            const double length = length_of(v, fan, i, j);
            image.push_back(static_cast<float>(sums[at] * length));
            square += (joseph[at] - sums[at]) * (joseph[at] - sums[at]) * length * length;
            largest = std::max(largest, sums[at] * length);
          }
        if (threads == 1) judge(v, fan, sums, row);
        ours.push_back(std::move(image));
      }
      row.joseph_rmse = std::sqrt(square / (static_cast<double>(count) * k_angles)) / largest;
      const auto few = run_plastimatch(folder, pixels, threads, 2),
                 many = run_plastimatch(folder, pixels, threads, 12);
      if (few && many) {
        row.peer_ms = 1e3 * (*many - *few) / 10;
        // The scale factor of plastimatch is arbitrary: use the best fit.
        double ab = 0, aa = 0, error = 0;
        std::vector<std::vector<float>> theirs;
        for (int angle = 0; angle < k_angles; ++angle) {
          char file[20];
          std::snprintf(file, sizeof file, "drr_%04d.pfm", angle);
          theirs.push_back(read_pfm(folder / file, pixels));
        }
        for (int angle = 0; angle < k_angles; ++angle) {
          const auto& t = theirs[static_cast<std::size_t>(angle)];
          const auto& o = ours[static_cast<std::size_t>(angle)];
          for (std::size_t i = 0; i < t.size(); ++i)
            ab += static_cast<double>(t[i]) * static_cast<double>(o[i]),
                aa += static_cast<double>(t[i]) * static_cast<double>(t[i]);
        }
        const double scale = aa > 0 ? ab / aa : 0;
        for (int angle = 0; angle < k_angles; ++angle) {
          const auto& t = theirs[static_cast<std::size_t>(angle)];
          const auto& o = ours[static_cast<std::size_t>(angle)];
          for (std::size_t i = 0; i < t.size(); ++i) {
            const double off = scale * static_cast<double>(t[i]) - static_cast<double>(o[i]);
            error += off * off;
          }
        }
        if (aa > 0) row.peer_rmse = std::sqrt(error / (static_cast<double>(count) * k_angles)) / largest;
      }
      rows.push_back(row);
    }
    std::error_code ignored;
    fs::remove_all(folder, ignored);
  }
  return rows;
}

XrayServoLoad run_servo_during_xray(double seconds) {
  XrayServoLoad result;
  haptics::TouchScene scene =
      scenes::scene_of(data_tools::make_phantom("spine").value(), {}, volume::Shape{"bone", 140});
  if (haptics::set_smallest_burr(scene, 4)) return result;
  haptics::SubvoxelProxy method;
  if (method.prepare(scene)) return result;
  // The hand moves into the spinous process from the back, and up and down in it.
  std::vector<haptics::PosePath::Sample> samples{{0, {{0, 90, 0}}}};
  for (int i = 0; i <= static_cast<int>(seconds); ++i)
    samples.push_back({0.5 + i, {{0, 66.0 - 3 * i, i % 2 ? 4.0 : -4.0}}});
  const haptics::PosePath path = haptics::PosePath::from_samples(std::move(samples), "bench").value();
  for (const auto& [name, pixels, is_turning] :
       {std::tuple("none", 0, false), std::tuple("256, still", 256, false),
        std::tuple("256, turning", 256, true), std::tuple("1024, turning", 1024, true)}) {
    haptics::VirtualDevice device(path, {});
    haptics::Device* const devices[] = {&device};
    sim::Engine engine(scene, method, drilling::burr({}), 1e-3);
    sim::LiveSession live(devices, std::move(engine), haptics::ServoOptions());
    fluoroscopy::VolumeXray xray(scene.base, 60);
    if (live.start()) return result;
    std::vector<double> us;
    const auto begin = Clock::now();
    while (seconds_since(begin) < seconds) {
      if (pixels == 0) {
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
        continue;
      }
      fluoroscopy::CArm arm;
      arm.columns = arm.rows = pixels, arm.pixel = 307.2 / pixels;
      arm.primary = is_turning ? 40 * seconds_since(begin) : 30;
      const auto start = Clock::now();
      if (xray.project(fluoroscopy::View(arm), live.fetch_state().version, {}, volume::RaySum::exact)) break;
      us.push_back(1e6 * seconds_since(start));
    }
    live.stop();
    result.parts.push_back({name, times_of(us), live.servo_report()});
  }
  return result;
}

}  // namespace trephine::bench
