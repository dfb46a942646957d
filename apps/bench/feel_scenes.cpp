// Scenes of one benchmark with their analytic distances, kept in one file.
#include <algorithm>
#include <cctype>
#include <cmath>
#include <glm/geometric.hpp>

#include "apps/bench/feel.h"
#include "apps/bench/scenes/scenes.h"
#include "haptics/device/device.h"
#include "volume/base/deterministic_math.h"
#include "volume/cuts/removal.h"

namespace trephine::bench {

using glm::dvec3;

namespace {

constexpr double k_hole_radius = 4;  // mm

using Parameters = std::map<std::string, double>;
using Distance = std::function<double(const dvec3&)>;

dvec3 gradient_of(const Distance& distance, const dvec3& p) {
  constexpr double h = 1e-4;
  return dvec3(distance(p + dvec3(h, 0, 0)) - distance(p - dvec3(h, 0, 0)),
               distance(p + dvec3(0, h, 0)) - distance(p - dvec3(0, h, 0)),
               distance(p + dvec3(0, 0, h)) - distance(p - dvec3(0, 0, h))) /
         (2 * h);
}

dvec3 on_surface(const Distance& distance, dvec3 p) {
  for (int i = 0; i < 30; ++i) {
    const dvec3 g = gradient_of(distance, p);
    p -= distance(p) / std::max(1e-6, glm::dot(g, g)) * g;
  }
  return p;
}

/// Walks over a smooth surface from `start` toward `heading`, reversing at the edge of the box; the HIP is
/// `depth` (mm) below the surface. One sample per ms; the first is 1 mm above the surface.
std::vector<dvec3> surface_walk(const Distance& distance, dvec3 start, dvec3 heading, double speed,
                                double depth, int samples) {
  std::vector<dvec3> hips;
  dvec3 p = on_surface(distance, start);
  double side = 1;
  for (int i = 0; i < samples; ++i) {
    const dvec3 n = glm::normalize(gradient_of(distance, p));
    hips.push_back(p + (i == 0 ? 1.0 : -depth) * n);
    heading = glm::normalize(heading - glm::dot(heading, n) * n);
    const dvec3 next = on_surface(distance, p + side * speed * 1e-3 * heading);
    if (std::max({std::abs(next.x), std::abs(next.y), std::abs(next.z)}) > 50)
      side = -side;
    else
      p = next;
  }
  return hips;
}

haptics::PosePath path_of(const std::vector<dvec3>& hips) {
  std::vector<haptics::PosePath::Sample> samples;
  for (std::size_t i = 0; i < hips.size(); ++i)
    samples.push_back({1e-3 * static_cast<double>(i), {hips[i], {1, 0, 0, 0}, true}});
  return haptics::PosePath::from_samples(std::move(samples), "feel").value();
}

/// Points along a polyline at constant speed (mm/s).
std::vector<dvec3> polyline(const std::vector<dvec3>& corners, double speed) {
  std::vector<dvec3> hips;
  for (std::size_t i = 1; i < corners.size(); ++i) {
    const double length = glm::length(corners[i] - corners[i - 1]);
    const int steps = std::max(1, static_cast<int>(1000 * length / speed));
    for (int k = 0; k < steps; ++k)
      hips.push_back(corners[i - 1] + (static_cast<double>(k) / steps) * (corners[i] - corners[i - 1]));
  }
  return hips;
}

/// Returns a motion that repeats two phases: five times the speed of `hips` for 12 ms, then rest for 48 ms.
template <class Hips>
auto held(Hips hips) {
  return [hips](const Distance& distance, int samples) {
    const std::vector<dvec3> path = hips(distance, samples + 60);
    std::vector<dvec3> result;
    for (std::size_t i = 0; i < static_cast<std::size_t>(samples); ++i)
      result.push_back(path[i / 60 * 60 + 5 * std::min<std::size_t>(i % 60, 12)]);
    return result;
  };
}

struct Grid {
  double psf = 1.5, noise = 0, shear = 0;
  bool is_binary = false, is_anisotropic = false;
  double slice_mm = 0;  ///< above 0: voxels of 0.5 x 0.5 x slice_mm, and cuts as fine as a 2 mm burr needs
};

haptics::TouchScene make_scene(const std::string& phantom, const Parameters& parameters, int size,
                               const Grid& grid) {
  data_tools::PhantomOptions o;
  o.psf_sigma_voxels = grid.psf;
  o.shear_degrees = grid.shear;
  o.parameters = parameters;
  const double spacing = 120.0 / size;
  if (grid.slice_mm > 0)
    o.spacing_mm = dvec3(0.5, 0.5, grid.slice_mm);
  else if (grid.is_anisotropic)
    o.spacing_mm = spacing * dvec3(1, 1, 1.25 / 0.48);
  else
    o.size = glm::ivec3(size);
  volume::Volume output = data_tools::make_phantom(phantom, o).value();
  if (grid.is_binary)
    for (auto& v : output.voxels.span()) v = v >= 300 ? 1600 : -1000;
  if (grid.noise > 0)
    for (std::size_t i = 0; i < output.voxels.size(); ++i)
      output.voxels[i] = static_cast<std::int16_t>(
          std::clamp(output.voxels[i] + std::floor(grid.noise * hash_normal(7, i) + 0.5), -1024.0, 3071.0));
  return scenes::scene_of(std::move(output), {0.5, 0.001, 0, 0});
}

/// Description of a scene. The scene itself is built directly before it is played.
struct SceneRequest {
  std::string name, variant, motion, group, phantom;
  Parameters parameters;
  Grid grid;
  std::function<std::vector<dvec3>(const Distance&, int samples)> hips;
  double radius = 0;      ///< of the tool, mm
  bool has_hole = false;  ///< a burr hole is drilled first: 4 mm radius, along -z at the origin, 8 mm deep
};

std::vector<SceneRequest> scene_requests(bool is_quick) {
  std::vector<SceneRequest> all;
  const auto slide = [](dvec3 start, dvec3 heading, double speed, double depth = 1) {
    return [=](const Distance& d, int samples) {
      return surface_walk(d, start, heading, speed, depth, samples);
    };
  };
  const dvec3 over(0.62, 0.31, 0.72), heading(0.4, 0.8, -0.3);
  const Grid soft{}, sharp{0, 0, 0, false, false};
  // Smooth shapes, one motion.
  for (const double angle : {0.0, 30.0, 45.0, 23.7})
    all.push_back({angle == 23.7 ? "plane, any" : "plane " + std::to_string(static_cast<int>(angle)),
                   "psf 1.5",
                   "slide 100 mm/s",
                   "smooth",
                   "plane",
                   {{"angle", angle}, {"offset", angle == 23.7 ? 3.3 : 0}},
                   soft,
                   slide({3, 2, 1}, {1, 0.63, 0}, 100)});
  all.push_back(
      {"torus", "psf 1.5", "slide 100 mm/s", "smooth", "torus", {}, soft, slide({49, 3, 1}, heading, 100)});
  all.push_back({"gyroid",
                 "psf 1.5",
                 "slide 100 mm/s",
                 "smooth",
                 "gyroid",
                 {},
                 soft,
                 slide({7.5, 0, 0}, heading, 100)});
  // The sphere, with every motion.
  for (const double speed : {10.0, 100.0, 500.0})
    all.push_back({"sphere",
                   "psf 1.5",
                   "slide " + std::to_string(static_cast<int>(speed)) + " mm/s",
                   "smooth",
                   "sphere",
                   {},
                   soft,
                   slide(45.0 * glm::normalize(over), heading, speed)});
  const auto around = [over](double depth_low, double depth_high, double hz, double tremor) {
    return [=](const Distance&, int samples) {
      std::vector<dvec3> hips;
      for (int i = 0; i < samples; ++i) {
        const double t = 1e-3 * i, phase = 6.283185307179586 * hz * t;
        const double depth =
            i == 0 ? -3 : 0.5 * (depth_low + depth_high) - 0.5 * (depth_high - depth_low) * std::cos(phase);
        dvec3 n = glm::normalize(glm::normalize(over) + 0.05 * t * dvec3(0.3, -0.8, 0.2));
        dvec3 p = (45 - depth) * n;
        for (int a = 0; a < 3; ++a)
          p[a] += tremor * std::sin(6.283185307179586 * (8 + 2 * a) * t + a) +
                  0.1 * tremor * hash_normal(5, static_cast<std::uint64_t>(3 * i + a));
        hips.push_back(p);
      }
      return hips;
    };
  };
  all.push_back({"sphere", "psf 1.5", "modest contact", "smooth", "sphere", {}, soft, around(-2, 2, 0.5, 0)});
  all.push_back({"sphere", "psf 1.5", "rapid contact", "smooth", "sphere", {}, soft, around(-1, 1, 12.5, 0)});
  all.push_back({"sphere", "psf 1.5", "poke", "smooth", "sphere", {}, soft, around(-5, 3, 2, 0)});
  all.push_back({"sphere", "psf 1.5", "tremor", "smooth", "sphere", {}, soft, around(1.5, 2, 1, 0.3)});
  // A compliant hand that slides along and presses: mass, spring and tremor, through an encoder.
  const auto by_hand = [over](const Distance& distance, int samples) {
    std::vector<haptics::PosePath::Sample> request;
    for (int i = 0; i < samples + 400; ++i) {
      const double t = 1e-3 * i, a = 0.9 * t;
      const dvec3 n = glm::normalize(glm::normalize(over) + dvec3(0.6 * a, -0.4 * std::sin(a), 0.1));
      const double depth = i < 300 ? -2 : 1.5 + std::sin(2.5 * t);
      dvec3 p = (45 - depth) * n;
      for (int k = 0; k < 3; ++k) p[k] += 0.1 * std::sin(6.283185307179586 * (8 + k) * t + k);
      request.push_back({t, {p, {1, 0, 0, 0}, true}});
    }
    haptics::VirtualDevice hand(haptics::PosePath::from_samples(std::move(request), "hand").value(), {});
    std::vector<dvec3> hips;
    for (int i = 0; i < samples; ++i) {
      haptics::Pose pose;
      if (!hand.read(1e-3 * i, pose)) break;
      hips.push_back(pose.position_world);
      const double d = distance(pose.position_world);
      hand.write(d < 0 ? -0.5 * d * glm::normalize(gradient_of(distance, pose.position_world)) : dvec3(0));
    }
    return hips;
  };
  all.push_back({"sphere", "psf 1.5", "simulated hand", "smooth", "sphere", {}, soft, by_hand});
  all.push_back({"sphere",
                 "psf 1.5",
                 "slide 100 mm/s, held",
                 "smooth",
                 "sphere",
                 {},
                 soft,
                 held(slide(45.0 * glm::normalize(over), heading, 100))});
  const auto variant = [&](const std::string& name, const Grid& grid, const std::string& group) {
    all.push_back({"sphere",
                   name,
                   "slide 100 mm/s",
                   group,
                   "sphere",
                   {},
                   grid,
                   slide(45.0 * glm::normalize(over), heading, 100)});
  };
  variant("psf 0", {0, 0, 0, false, false}, "rough");
  variant("psf 0.7", {0.7, 0, 0, false, false}, "rough");
  variant("psf 1", {1, 0, 0, false, false}, "rough");
  variant("psf 2", {2, 0, 0, false, false}, "smooth");
  variant("binary", {0, 0, 0, true, false}, "rough");
  variant("noise 20 HU", {1.5, 20, 0, false, false}, "rough");
  variant("0.48 x 0.48 x 1.25", {1.5, 0, 0, false, true}, "smooth");
  variant("sheared 15 degrees", {1.5, 0, 15, false, false}, "smooth");
  // Thin and sharp shapes.
  const double voxel = 120.0 / (is_quick ? 128 : 512);
  for (const double thick : {1.0, 1.5, 2.0})
    all.push_back(
        {"plate",
         std::to_string(thick).substr(0, 3) + " voxels",
         "cross at 2 m/s",
         "sharp",
         "plate",
         {{"thickness", thick * voxel}, {"angle", 37}},
         sharp,
         [](const Distance&, int) {
           return polyline({{0, 0, 45}, {8, 5, -45}, {-12, 3, 45}, {2, 20, -45}, {5, -9, 45}}, 2000);
         }});
  const auto along = [](std::vector<dvec3> corners, double speed) {
    return [corners, speed](const Distance&, int) { return polyline(corners, speed); };
  };
  // The HIP starts at `start` in free space. Then it circles around a point in matter, for example below the
  // bottom of a groove, so that the proxy is pressed across and along the groove.
  const auto circles = [](dvec3 start, dvec3 middle, double radius, double speed) {
    return [=](const Distance&, int samples) {
      std::vector<dvec3> hips{start};
      for (int i = 1; i < samples; ++i) {
        const double a = speed * 1e-3 * i / radius;
        hips.push_back(middle + radius * dvec3(std::cos(a), std::sin(a), 0.3 * std::sin(0.7 * a)));
      }
      return hips;
    };
  };
  for (const double psf : {1.0, 0.0}) {
    const Grid grid{psf, 0, 0, false, false};
    const std::string soft_name = psf > 0 ? "psf 1" : "psf 0";
    for (const double angle : {30.0, 90.0})
      all.push_back({"groove " + std::to_string(static_cast<int>(angle)),
                     soft_name,
                     "circle",
                     "sharp",
                     "groove",
                     {{"angle", angle}},
                     grid,
                     circles({0, 0, -10}, {-1, 4, -24}, 4, 60)});
    all.push_back({"groove 90",
                   soft_name,
                   "circle, held",
                   "sharp",
                   "groove",
                   {{"angle", 90}},
                   grid,
                   held(circles({0, 0, -10}, {-1, 4, -24}, 4, 60))});
    all.push_back({"corner",
                   soft_name,
                   "trap",
                   "sharp",
                   "corner",
                   {},
                   grid,
                   circles({0, 0, 0}, {-22, -24, -23}, 5, 60)});
    all.push_back(
        {"slot", soft_name, "circle", "sharp", "slot", {}, grid, circles({0, 0, -10}, {-1, 4, -22}, 6, 60)});
    all.push_back({"cone",
                   soft_name,
                   "over the tip",
                   "sharp",
                   "cone",
                   {},
                   grid,
                   along({{-20, -8, 18}, {14, 4, 17}, {-6, -16, 16}, {10, 12, 12}}, 100)});
    all.push_back({"steps",
                   soft_name,
                   "slide 60 mm/s",
                   "sharp",
                   "steps",
                   {},
                   grid,
                   along({{-25, 3, 0}, {25, 12, 17}, {-25, 8, -13}}, 60)});
  }
  // Balls in narrow shapes rest on two or three walls above the bottom; over an edge they roll.
  for (const double angle : {15.0, 30.0, 90.0})
    all.push_back({"groove " + std::to_string(static_cast<int>(angle)),
                   "psf 1, radius 1 mm",
                   "circle",
                   "sharp",
                   "groove",
                   {{"angle", angle}},
                   {1, 0, 0, false, false},
                   circles({0, 0, 0}, {-1, 4, -24}, 4, 60),
                   1});
  for (const double angle : {60.0, 90.0})
    all.push_back({"pit " + std::to_string(static_cast<int>(angle)),
                   "psf 1, radius 1 mm",
                   "circle",
                   "sharp",
                   "pit",
                   {{"angle", angle}},
                   {1, 0, 0, false, false},
                   circles({0, 0, 0}, {-1, 4, -24}, 4, 60),
                   1});
  all.push_back({"wedge 60",
                 "psf 1, radius 1 mm",
                 "over the edge",
                 "sharp",
                 "wedge",
                 {{"angle", 60}},
                 {1, 0, 0, false, false},
                 along({{-20, -8, 18}, {14, 4, 17}, {-6, -16, 16}, {10, 12, 12}}, 100),
                 1});
  for (const char* name : {"corner", "slot"})
    all.push_back({name,
                   "psf 1, radius 1 mm",
                   "circle",
                   "sharp",
                   name,
                   {},
                   {1, 0, 0, false, false},
                   std::string(name) == "slot" ? circles({0, 0, -10}, {-1, 4, -22}, 6, 60)
                                               : circles({0, 0, 0}, {-22, -24, -23}, 5, 60),
                   1});
  // Tools in a burr hole that is drilled first. The HIP moves down the axis of the hole, then to its wall,
  // and around the wall between the rim and the round end; with `is_over_rim` also over the rim.
  const auto in_hole = [](double radius, bool is_over_rim = false) {
    return [=](const Distance&, int samples) {
      std::vector<dvec3> hips;
      for (int i = 0; i < samples; ++i) {
        const double a = 0.015 * i, down = std::min(1.0, i / 60.0),
                     out = std::clamp((i - 60) / 40.0, 0.0, 1.0);
        const double reach = out * (k_hole_radius - radius + 2);
        const double z = is_over_rim ? -4 - 5 * std::sin(0.31 * a) : -5 - 3.5 * std::sin(0.31 * a);
        hips.push_back({reach * std::cos(a), reach * std::sin(a), 12 + down * (z - 12)});
      }
      return hips;
    };
  };
  all.push_back({"burr hole",
                 "psf 1.5",
                 "round its wall",
                 "sharp",
                 "plane",
                 {{"angle", 0}},
                 soft,
                 in_hole(0),
                 0,
                 true});
  all.push_back({"burr hole",
                 "psf 1.5",
                 "round its wall, held",
                 "sharp",
                 "plane",
                 {{"angle", 0}},
                 soft,
                 held(in_hole(0)),
                 0,
                 true});
  all.push_back({"burr hole",
                 "psf 1.5, radius 2 mm",
                 "round and over its rim",
                 "sharp",
                 "plane",
                 {{"angle", 0}},
                 soft,
                 in_hole(2, true),
                 2,
                 true});
  // Slices as thick as in clinical scans, drilled as in sessions: on a cut lattice finer than the voxels.
  for (const double radius : {0.0, 2.0}) {
    Grid thick;
    thick.psf = 0.7, thick.slice_mm = 3;
    all.push_back({"burr hole",
                   radius > 0 ? "slices of 3 mm, radius 2 mm" : "slices of 3 mm",
                   "round its wall",
                   "sharp",
                   "plane",
                   {{"angle", 0}},
                   thick,
                   in_hole(radius),
                   radius,
                   true});
  }
  for (const double radius : {0.5, 2.0, 6.0}) {
    const std::string name =
        "psf 1.5, radius " + std::to_string(radius).substr(0, radius < 1 ? 3 : 1) + " mm";
    all.push_back({"sphere",
                   name,
                   "slide 100 mm/s",
                   "smooth",
                   "sphere",
                   {},
                   soft,
                   slide((45 + radius) * glm::normalize(over), heading, 100),
                   radius});
    all.push_back({"burr hole",
                   name,
                   "round its wall",
                   "sharp",
                   "plane",
                   {{"angle", 0}},
                   soft,
                   in_hole(radius),
                   radius,
                   true});
  }
  if (is_quick) {
    std::erase_if(all, [](const SceneRequest& p) {
      return p.name == "plane 45" || p.motion == "modest contact" || p.variant == "psf 2" ||
             p.variant == "1.5 voxels" || (p.group == "sharp" && p.variant == "psf 0" && p.name != "corner");
    });
  }
  return all;
}

constexpr double k_hole_top = 3, k_hole_end = -4;  // z of the centre of the burr, start and end, mm

/// Distance (mm) from p to the half space under z = 0 after drill_hole(): a body of revolution, bounded by
/// the plane outside the hole, the wall and the round end.
double distance_to_drilled(const dvec3& p) {
  const double rho = std::hypot(p.x, p.y), z = p.z;
  const double to_plane = std::hypot(std::max(0.0, k_hole_radius - rho), z);
  const double to_wall = std::hypot(rho - k_hole_radius, z - std::clamp(z, k_hole_end, 0.0));
  double nearest = std::min(to_plane, to_wall);
  if (z < k_hole_end) nearest = std::min(nearest, std::abs(k_hole_radius - std::hypot(rho, z - k_hole_end)));
  const bool is_free =
      z > 0 || (rho < k_hole_radius && z > k_hole_end) || std::hypot(rho, z - k_hole_end) < k_hole_radius;
  return is_free ? nearest : -nearest;
}

/// Drills a burr hole, and updates the offset field of the tool.
void drill_hole(FeelScene& scene) {
  const haptics::TouchItem& shape = scene.scene.items[0];
  volume::RemovalEditor editor(haptics::uncut_version(scene.scene), {shape.field});
  const volume::RemovalReport report = editor.remove({{0, 0, k_hole_top}, {0, 0, k_hole_end}, k_hole_radius});
  volume::OffsetField::Work work;
  const auto drilled = editor.publish();
  haptics::TouchState::OffsetFields offsets;
  if (shape.offset)
    offsets.push_back(
        shape.offset->updated(shape.field, *shape.bits, *drilled, report.box, 1, &work, shape.soft.get()));
  scene.field_update_s = work.seconds;
  scene.drilled = std::make_shared<haptics::TouchState>(drilled, std::move(offsets));
}

}  // namespace

std::string feel_id(const std::string& name, const std::string& variant, const std::string& motion) {
  std::string id;
  for (const char c : name + " " + variant + " " + motion)
    if (std::isalnum(static_cast<unsigned char>(c)) || c == '.')
      id += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    else if (!id.empty() && id.back() != '-')
      id += '-';
  return id;
}

std::vector<std::string> feel_scene_ids(bool is_quick) {
  std::vector<std::string> ids;
  for (const SceneRequest& request : scene_requests(is_quick))
    ids.push_back(feel_id(request.name, request.variant, request.motion));
  return ids;
}

void for_feel_scenes(bool is_quick, const std::string& only, const std::function<bool(FeelScene&&)>& use) {
  const int size = is_quick ? 128 : 512, samples = is_quick ? 1500 : 3100;
  for (const SceneRequest& request : scene_requests(is_quick)) {
    if (feel_id(request.name, request.variant, request.motion).find(only) == std::string::npos) continue;
    // Distance to the region forbidden to the tool's centre.
    const Distance distance = [phantom = request.phantom, parameters = request.parameters,
                               radius = request.radius](const dvec3& p) {
      return data_tools::phantom_distance(phantom, parameters, p) - radius;
    };
    FeelScene scene;
    scene.name = request.name, scene.variant = request.variant, scene.motion = request.motion,
    scene.group = request.group;
    scene.radius_mm = request.radius;
    scene.scene = make_scene(request.phantom, request.parameters, size, request.grid);
    scene.path = path_of(request.hips(distance, samples));
    const auto begin = Clock::now();
    haptics::soften(scene.scene);
    if (request.grid.slice_mm > 0 && haptics::set_smallest_burr(scene.scene, 2)) continue;
    if (haptics::set_tool_radius(scene.scene, request.radius)) continue;
    if (request.radius > 0) scene.field_s = seconds_since(begin);
    scene.distance = distance;
    scene.has_outer_edge = request.phantom == "wedge";
    if (request.phantom == "plate") scene.plate_mm = request.parameters.at("thickness");
    if (request.has_hole) {
      drill_hole(scene);
      scene.distance = [radius = request.radius](const dvec3& p) { return distance_to_drilled(p) - radius; };
    }
    if (!use(std::move(scene))) return;
  }
}

haptics::PosePath slide_over(const haptics::TouchScene& scene, double speed, double depth, int samples) {
  // The HIP follows a line across the middle, back and forth. Below each position, the first solid voxel from
  // above gives the height of the bone. The height is smoothed along the line, and the HIP is `depth` below
  // it.
  const volume::Volume& base = *scene.base;
  const volume::Frame& frame = base.frame;
  const glm::ivec3 size = base.size;
  std::vector<dvec3> hips;
  const double step = 1e-3 * speed / frame.spacing().x;
  double x = 0.3 * size.x, side = 1;
  double height = -1;
  for (int i = 0; i < samples; ++i) {
    x += side * step;
    if (x > 0.7 * size.x || x < 0.3 * size.x) side = -side, x += 2 * side * step;
    const double y = 0.45 * size.y + 0.1 * size.y * (x / size.x);
    int z = size.z - 1;
    while (z > 0 && !scene.items[0].bits->is_solid({static_cast<int>(x), static_cast<int>(y), z})) --z;
    height = height < 0 ? z : height + 0.05 * (z - height);
    hips.push_back(frame.world_from_volume({x, y, height - depth / frame.spacing().z}));
    if (i == 0) hips.back() = frame.world_from_volume({x, y, static_cast<double>(size.z) + 3});
  }
  return path_of(hips);
}

}  // namespace trephine::bench
