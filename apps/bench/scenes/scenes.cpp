#include "apps/bench/scenes/scenes.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "volume/base/deterministic_math.h"

namespace trephine::scenes {

haptics::TouchScene phantom_scene(const std::string& name, const data_tools::PhantomOptions& options) {
  auto result = data_tools::make_phantom(name, options);
  if (!result) fail_assertion(result.error().message().c_str(), __FILE__, __LINE__);
  return scene_of(std::move(result).value());
}

haptics::TouchScene scene_of(volume::Volume&& volume, const haptics::Material& material,
                             const volume::Shape& shape) {
  haptics::TouchScene scene;
  scene.base = std::make_shared<const volume::Volume>(std::move(volume));
  scene.items.push_back(
      {volume::Field(*scene.base, shape),
       std::make_shared<const volume::Occupancy>(volume::Occupancy::build(*scene.base, shape)), material,
       haptics::Side::front});
  return scene;
}

volume::Volume sampled(const glm::dvec3& low, const glm::dvec3& high, const glm::dvec3& spacing,
                       const std::function<double(const glm::dvec3&)>& hounsfield) {
  const glm::ivec3 size(glm::ceil((high - low) / spacing));
  volume::Volume v = volume::make_volume(size, volume::Frame::from_spacing(low, spacing).value()).value();
  v.is_hounsfield = true;
  for (int z = 0; z < size.z; ++z)
    for (int y = 0; y < size.y; ++y)
      for (int x = 0; x < size.x; ++x)
        v.voxels[v.index(x, y, z)] =
            static_cast<std::int16_t>(std::lround(hounsfield(v.frame.world_from_volume({x, y, z}))));
  return v;
}

std::string Scan::name() const {
  return "slices 1:" + std::to_string(slice) + ", shear " + std::to_string(shear) + ", unit " +
         std::to_string(unit) + (is_mask ? ", mask" : "");
}

haptics::TouchScene scan_scene(const Scan& scan, bool is_block) {
  data_tools::PhantomOptions o;
  o.spacing_mm = 1.5 * glm::dvec3(1, 1, scan.slice);
  o.shear_degrees = scan.shear;
  o.psf_sigma_voxels = scan.is_mask ? 0 : 0.8;
  volume::Volume result = data_tools::make_phantom("sphere", o).value();
  const volume::Frame& f = result.frame;
  result.frame = volume::Frame::from_axes(scan.unit * f.origin(), scan.unit * f.axes()).value();
  for (auto& v : result.voxels.span()) {
    if (is_block) v = 1600;
    if (scan.is_mask) v = v >= 300 ? 1 : 0;
  }
  volume::Shape shape;
  if (scan.is_mask) shape.low = 0.5;
  haptics::TouchScene scene = scene_of(std::move(result), {0.5, 0, 0, 0}, shape);
  haptics::soften(scene);
  return scene;
}

haptics::PosePath sphere_slide(double radius, double depth, double speed, double seconds) {
  std::vector<haptics::PosePath::Sample> samples;
  const glm::dvec3 u = glm::normalize(glm::dvec3(0.62, 0.31, 0.72)),
                   v = glm::normalize(glm::cross(u, glm::dvec3(0.2, 1, -0.4)));
  const double arc = 1.2, r = radius - depth;  // rad of arc, back and forth
  const int count = static_cast<int>(seconds * 1000);
  for (int i = 0; i <= count; ++i) {
    const double t = i * 1e-3;
    const double travelled = speed * t / r, phase = travelled / (2 * arc) - std::floor(travelled / (2 * arc));
    const double angle = arc * (phase < 0.5 ? 2 * phase : 2 - 2 * phase);
    const glm::dvec3 p = r * (deterministic_cos(angle) * u + deterministic_sin(angle) * v);
    samples.push_back({t, {i == 0 ? (radius + 1) * u : p, {1, 0, 0, 0}, true}});
  }
  return haptics::PosePath::from_samples(std::move(samples), "sphere_slide").value();
}

haptics::PosePath rough_walk(const glm::dvec3& low, const glm::dvec3& high, double step, int samples,
                             std::uint64_t seed) {
  std::vector<haptics::PosePath::Sample> path;
  glm::dvec3 p = low, velocity(0);
  for (int i = 0; i < samples; ++i) {
    for (int a = 0; a < 3; ++a) {
      const auto n = static_cast<unsigned long long>(3 * i + a);
      velocity[a] = 0.97 * velocity[a] + 0.12 * step * hash_normal(seed, n);
      p[a] += std::clamp(velocity[a], -step, step);
      if (p[a] < low[a]) p[a] = low[a], velocity[a] = std::abs(velocity[a]);
      if (p[a] > high[a]) p[a] = high[a], velocity[a] = -std::abs(velocity[a]);
    }
    path.push_back({i * 1e-3, {p, {1, 0, 0, 0}, true}});
  }
  return haptics::PosePath::from_samples(std::move(path), "rough_walk").value();
}

}  // namespace trephine::scenes
