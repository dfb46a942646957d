// Vault: the top of a skull in closed form; outlines on it, and a function that cuts a flap.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include "apps/bench/scenes/scenes.h"
#include "haptics/methods/methods.h"
#include "modules/bone_flap/bone_flap.h"
#include "modules/bone_flap/rim.h"
#include "sim/drivers/lockstep.h"
#include "tests/modules/events_of.h"

namespace trephine::bone_flap {

using glm::dvec3;

inline constexpr double k_pi = 3.14159265358979323846, k_outer = 75, k_inner = 69;  // mm, of the shell

/// The top of a skull: a shell around the origin. `hounsfield`: HU at a world point.
struct Vault {
  haptics::TouchScene scene;
  std::unique_ptr<haptics::ProxyMethod> method;

  using Hounsfield = std::function<double(const dvec3&)>;
  static double shell(const dvec3& p) {
    const double r = glm::length(p);
    return 300 + 400 * std::min(k_outer - r, r - k_inner);
  }
  explicit Vault(const dvec3& spacing, double lattice_burr = 6.5, const Hounsfield& hounsfield = shell,
                 double wide = 48)
      : Vault(scenes::sampled({-wide, -wide, 45}, {wide, wide, 82}, spacing, hounsfield), lattice_burr) {}
  Vault(volume::Volume scan, double lattice_burr) {
    scene.base = std::make_shared<const volume::Volume>(std::move(scan));
    const volume::Shape bone{"bone", 300};
    scene.items.push_back(
        {volume::Field(*scene.base, bone),
         std::make_shared<const volume::Occupancy>(volume::Occupancy::build(*scene.base, bone)),
         {}});
    EXPECT_FALSE(haptics::set_smallest_burr(scene, lattice_burr).has_value());
    method = haptics::make_method("subvoxel").value();
    EXPECT_FALSE(method->prepare(scene).has_value());
  }
  /// Returns a scan whose slices are shifted sideways from one to the next, as from a tilted gantry.
  static volume::Volume sheared() {
    glm::dmat3 axes(0.0);
    axes[0] = dvec3(0.6, 0, 0), axes[1] = dvec3(0, 0.6, 0), axes[2] = dvec3(0.15, 0.3, 0.9);
    volume::Volume v =
        volume::make_volume({110, 110, 42}, volume::Frame::from_axes({-36, -39, 45}, axes).value()).value();
    v.is_hounsfield = true;
    for (int z = 0; z < v.size.z; ++z)
      for (int y = 0; y < v.size.y; ++y)
        for (int x = 0; x < v.size.x; ++x)
          v.voxels[v.index(x, y, z)] = static_cast<std::int16_t>(
              std::clamp(shell(v.frame.world_from_volume({x, y, z})), -1000.0, 3000.0));
    return v;
  }
  sim::Lockstep run() const {
    static const BoneFlap module;
    static const sim::Catalogue catalogue({&module});
    return sim::Lockstep(sim::Engine(scene, *method, {}, 1e-3, catalogue), {}, 1000);
  }
};

/// A regular outline on the shell. `polar`: angle of the anchors from the top, rad. The centre of the outline
/// is over the origin, at `height` (mm).
struct Outline {
  std::vector<dvec3> anchors;
  double polar, height;
  int count;
  explicit Outline(double polar_degrees, int sides, double turn = 0.1)
      : polar(polar_degrees * k_pi / 180), count(sides) {
    for (int i = 0; i < sides; ++i) {
      const double a = turn + 2 * k_pi * i / sides;
      anchors.push_back(k_outer *
                        dvec3(std::sin(polar) * std::cos(a), std::sin(polar) * std::sin(a), std::cos(polar)));
    }
    height = k_outer * std::cos(polar);
  }
  /// Angle of a side (rad): anchors are joined by great circles.
  double side_angle() const {
    const double c = std::cos(polar), s = std::sin(polar);
    return std::acos(c * c + s * s * std::cos(2 * k_pi / count));
  }
  /// Solid angle (sr): the sum of its spherical triangles, which meet at the top.
  double solid_angle() const {
    const double t = std::tan(0.5 * polar), square = t * t, wedge = 2 * k_pi / count;
    return count * 2 * std::atan2(square * std::sin(wedge), 1 + square * std::cos(wedge));
  }
  double area() const { return solid_angle() * k_outer * k_outer; }
  double wall() const { return count * side_angle() * 0.5 * (k_outer * k_outer - k_inner * k_inner); }
  CutFlap request(Saw saw = Saw::w1_6) const {
    CutFlap flap;
    flap.anchors = anchors, flap.saw = saw, flap.distance = height;
    return flap;
  }
};

using sim::events_of;

/// Cuts the flap; returns the reason of a refusal, or "".
inline std::string cut(sim::Lockstep& run, const CutFlap& request) {
  const std::size_t before = events_of<FlapFailed>(run.engine()).size();
  const sim::Outcome outcome = run.apply_and_finish({request, 0});
  if (outcome.refused) return outcome.refused->message();
  const auto refusals = events_of<FlapFailed>(run.engine());
  return refusals.size() > before ? refusals.back().first.reason : std::string();
}

}  // namespace trephine::bone_flap
