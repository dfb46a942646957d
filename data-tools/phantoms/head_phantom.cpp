#include "data-tools/phantoms/head_phantom.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>

#include "data-tools/phantoms/soft_shapes.h"
#include "volume/base/deterministic_math.h"

namespace trephine::data_tools {

namespace {

using glm::dvec3;

/// Returns the distance, mm, to the cranium reduced by `inward` mm: narrower in front, flat below.
double cranium(const dvec3& p, double inward) {
  const double narrow = 1.0 + 0.10 * std::clamp(-p.y / 90.0, -0.6, 1.0);
  const dvec3 q(p.x * narrow, p.y, p.z);
  const double dome = ellipsoid(q, dvec3(71, 89, 69) - inward);
  const double base = -(p.z + 46.0 + 0.10 * (p.y + 20)) + inward;  // the skull base slopes down to the back
  return carve(dome, -base, 14.0);
}

/// Distances, mm, to bone, teeth and air of face and jaws below the brain case; p.x >= 0 (symmetric).
struct Face {
  double bone = 1e3, tooth = 1e3, air = 1e3;
};
void upper_face(const dvec3& p, Face& f) {
  // Brow, cheek bone, zygomatic arch and upper jaw.
  double bone = capsule(p, {4, -84, -25}, {44, -70, -24}, 6.5, 5.5);
  bone = blend(bone, capsule(p, {44, -70, -24}, {48, -66, -46}, 5.0, 7.0), 6);
  bone = blend(bone, capsule(p, {48, -66, -48}, {20, -78, -56}, 7.0, 6.0), 6);
  bone = blend(bone, capsule(p, {50, -62, -48}, {65, -30, -45}, 4.5, 3.2), 5);
  bone = blend(bone, capsule(p, {65, -30, -45}, {63, -2, -43}, 3.2, 5.0), 5);
  bone = blend(bone, capsule(p, {2, -87, -26}, {3, -98, -43}, 4.2, 3.0), 5);   // nasal bones
  bone = blend(bone, capsule(p, {9, -82, -30}, {14, -84, -56}, 4.0, 4.5), 5);  // sides of the nose
  bone = blend(bone, capsule(p, {0, -89, -78}, {21, -78, -77}, 4.5, 5.0), 6);  // alveolar ridge
  bone = blend(bone, capsule(p, {21, -78, -77}, {29, -54, -75}, 5.0, 5.5), 6);
  bone = blend(bone, ellipsoid(p - dvec3(0, -63, -62), {31, 29, 22}), 9);   // maxilla
  bone = blend(bone, ellipsoid(p - dvec3(0, -52, -36), {11, 30, 15}), 6);   // between the orbits
  bone = blend(bone, ellipsoid(p - dvec3(30, -52, -36), {18, 26, 12}), 6);  // floor and walls of the orbit
  // Holes: orbit, nose, sinus.
  const dvec3 eye = p - dvec3(29, -84, -35);
  const double orbit = ellipsoid(dvec3(eye.x + 0.28 * eye.y, eye.y, eye.z + 0.05 * eye.y), {16.5, 40, 15});
  bone = carve(bone, orbit, 3);
  const double nose = ellipsoid(p - dvec3(0, -92, -57), {8.5, 24, 13});
  bone = carve(bone, nose, 3);
  bone = carve(bone, ellipsoid(p - dvec3(17, -58, -60), {7, 12, 9}), 2);
  f.bone = bone;
  f.air = std::min(nose + 1.5, ellipsoid(p - dvec3(17, -58, -60), {6.5, 11.5, 8.5}));
}

double lower_jaw(const dvec3& p) {
  // Lower jaw: condyle, ramus, body, chin.
  double jaw = capsule(p, {50, -14, -50}, {49, -20, -72}, 5.0, 6.0);
  jaw = blend(jaw, capsule(p, {52, -42, -58}, {48, -30, -82}, 2.6, 6.0), 8);
  jaw = blend(jaw, capsule(p, {49, -20, -72}, {46, -26, -96}, 6.0, 6.5), 6);
  jaw = blend(jaw, capsule(p, {46, -26, -96}, {30, -66, -108}, 6.5, 7.0), 6);
  jaw = blend(jaw, capsule(p, {30, -66, -108}, {0, -91, -113}, 7.0, 7.5), 8);
  jaw = blend(jaw, capsule(p, {36, -50, -95}, {22, -80, -99}, 4.5, 4.5), 8);
  jaw = blend(jaw, capsule(p, {22, -80, -99}, {0, -90, -100}, 4.5, 4.5), 6);
  return jaw;
}

Face face(const dvec3& p) {
  Face f;
  if (p.z > -8 || p.z < -124 || p.y > 25) return f;  // too far from the face to blend
  if (p.z > -102) upper_face(p, f);
  if (p.z < -30) f.bone = std::min(f.bone, lower_jaw(p));
  // Eight teeth per quadrant, along an arch.
  if (p.z < -74 && p.z > -104 && p.y < -40 && p.x < 34) {
    for (int i = 0; i < 8; ++i) {
      const double u = (i + 0.5) / 8.0, x = 29.0 * deterministic_sin(1.45 * u);
      const double y = -94.0 + 44.0 * u * u, r = i < 3 ? 2.7 : i < 5 ? 3.1 : 4.3;
      f.tooth = std::min(f.tooth, capsule(p, {x, y + 1.5, -78}, {x, y - 0.5, -87.2}, 2.2, r));
      f.tooth = std::min(f.tooth, capsule(p, {x, y + 2.5, -99}, {x, y + 1.0, -92.4}, 2.2, r - 0.2));
    }
  }
  return f;
}

/// Returns the distance, mm, to the nearest of the wavy coronal, sagittal and lambdoid sutures.
double suture(const dvec3& p, double side_x) {
  const double jag = 1.6 * deterministic_sin(side_x * 0.9) + 1.1 * deterministic_sin(side_x * 2.3 + 0.7);
  const double coronal = std::abs(p.y + 24 + 0.10 * std::abs(side_x) + jag);
  const double jag_y = 1.5 * deterministic_sin(p.y * 0.8) + 1.2 * deterministic_sin(p.y * 2.1 + 1.1);
  const double sagittal = p.y > -24 && p.y < 66 ? std::abs(side_x + jag_y) : 1e3;
  const double back = std::abs(p.y - 66 - 0.0 + 0.55 * std::abs(side_x) * -1.0 + jag);
  const double lambdoid = p.y > 40 ? back : 1e3;
  return p.z > 2 ? std::min({coronal, sagittal, lambdoid}) : 1e3;
}

}  // namespace

double vault_distance(const dvec3& p_world, const HeadAnatomy& anatomy) noexcept {
  const dvec3 p = p_world / anatomy.size;
  return cranium({std::abs(p.x), p.y, p.z}, 0);
}

double distance_to_vault(const dvec3& from_world, const dvec3& direction, double farthest,
                         const HeadAnatomy& anatomy) noexcept {
  double inside = 0, outside = farthest;
  while (outside - inside > 1e-3) {
    const double middle = 0.5 * (inside + outside);
    (vault_distance(from_world + middle * direction, anatomy) < 0 ? inside : outside) = middle;
  }
  return inside;
}

std::optional<HeadApproach> head_approach(std::string_view name) noexcept {
  for (std::size_t i = 0; i < std::size(k_head_approach_names); ++i)
    if (name == k_head_approach_names[i]) return static_cast<HeadApproach>(i);
  return std::nullopt;
}

namespace {

HeadAnatomy varied_anatomy(std::uint64_t seed) {
  if (seed == 1) return {};
  const auto share = [seed](std::uint64_t stream) {
    return static_cast<double>(hash_bits(hash_bits(seed) ^ stream) >> 11) * 0x1p-53;
  };
  HeadAnatomy a;
  for (int i = 0; i < 3; ++i) a.size[i] = 1 - 0.07 * share(static_cast<std::uint64_t>(i) + 1);
  a.thickness = 0.8 + 0.4 * share(4);
  a.frontal_sinus = 0.5 + 0.8 * share(5);
  a.tumour_radius = 9 + 8 * share(6);
  // The tumour is on either side of the vault, between front and back.
  const double angle = 0.5 + 2.0 * share(7), side = share(8) < 0.5 ? -1 : 1;
  a.tumour = {side * (24 + 14 * share(9)), -52 * deterministic_cos(angle) + 6, 30 + 8 * share(10)};
  return a;
}

/// Places a tumour below the vault, in a direction from the middle of the head. `radius`: of the tumour, mm.
void place_tumour(HeadAnatomy& anatomy, const dvec3& direction, double radius, double opening_margin) {
  constexpr double k_below = 11;  // mm, from the outer surface: bone, dura and fluid
  const double reach = distance_to_vault(k_head_middle, direction, 150, {});
  anatomy.tumour = k_head_middle + (reach - k_below - radius) * direction;
  anatomy.tumour_radius = radius, anatomy.opening_margin = opening_margin;
}

}  // namespace

HeadAnatomy head_anatomy(std::uint64_t seed, HeadApproach approach) {
  HeadAnatomy anatomy = varied_anatomy(seed);
  if (approach == HeadApproach::frontotemporal)
    place_tumour(anatomy, glm::normalize(dvec3(0.8, -0.52, 0.1)), 13, 16);
  else if (approach == HeadApproach::suboccipital)
    place_tumour(anatomy, glm::normalize(dvec3(0.4, 0.82, -0.4)), 8, 10);
  else if (approach == HeadApproach::keyhole)
    place_tumour(anatomy, glm::normalize(dvec3(0.44, -0.88, 0.2)), 5, 10);
  return anatomy;
}

HeadSample sample_head(const dvec3& p_world, double voxel_mm, const HeadAnatomy& anatomy) noexcept {
  const dvec3 world = p_world / anatomy.size;
  const dvec3 p(std::abs(world.x), world.y, world.z);  // symmetric except for sutures, folds and noise
  Brush brush(-1000, voxel_mm);
  const double edge = brush.edge();
  HeadTissue tissue = HeadTissue::air;
  const auto paint = [&](double s, double value, HeadTissue kind) {
    if (brush.paint(s, value)) tissue = kind;
  };

  // Inside the brain case: dura, fluid, folded brain, ventricles.
  const auto paint_brain_case = [&](double inside) {
    if (inside >= edge) return;
    paint(std::max(inside, -(inside + 1.1)), 85, HeadTissue::dura);
    paint(inside + 1.1, 9, HeadTissue::cerebrospinal_fluid);
    const double fissure = 1.1 - p.x;  // between the hemispheres
    // Deeper than any fold the point is wholly brain, so the fold need not be computed.
    const double fold =
        inside < -8.1 - edge
            ? 0.0
            : 1.9 * std::abs(wave(world + 5.0 * dvec3(wave(world, 47), wave(world, 53), 0), 24)) * 2.0;
    double brain = inside + 2.2 + std::max(0.0, 2.4 - fold);
    if (p.z > -5) brain = std::max(brain, fissure);
    paint(brain, 37, HeadTissue::brain);
    if (brain < -3.5) paint(brain + 3.5, 27, HeadTissue::brain);  // white matter
    const double ventricle = std::min(capsule(p, {7, -26, 8}, {10, 18, 12}, 4.5, 6.0),
                                      capsule(p, {10, 18, 12}, {22, 30, -6}, 6.0, 3.0));
    paint(ventricle, 6, world.x > 0 ? HeadTissue::left_ventricle : HeadTissue::right_ventricle);
    // Tumour attached to the dura, denser than brain, with an irregular border.
    const double to_tumour = glm::length(world - anatomy.tumour);
    if (to_tumour < 1.08 * anatomy.tumour_radius + edge)
      paint(std::max(to_tumour - anatomy.tumour_radius * (1 + 0.08 * wave(world, 17)), inside + 1.1),
            62 + 5 * wave(world, 6), HeadTissue::tumour);
  };
  // The sagittal sinus is in the dura, below the vault's midline.
  const auto paint_sinus = [&](double inside) {
    if (p.x > 9 || p.z < -30 || (p.z < 0 && p.y < 40)) return;
    const double width = p.x / 5.0, depth = (inside + 2.4) / 3.2;
    paint(3.2 * (std::sqrt(width * width + depth * depth) - 1), 68, HeadTissue::venous_sinus);
  };

  // Deep in the upper brain only soft tissue is near; the exact thickness of bone has no effect.
  const double outer = cranium(p, 0);
  if (outer < -24 && p.z > -8) {
    paint(outer, 45, HeadTissue::soft_tissue);
    paint_brain_case(outer + 4);
    paint_sinus(outer + 4);
    return {brush.hounsfield(), tissue, 0};
  }

  // Skin: dome, face and neck. Below the fat the exact depth has no effect. A blend only increases the depth,
  // so the remaining blends are skipped there.
  const double deep = -5.0 - 2 * edge;
  double skin = ellipsoid(p - dvec3(0, 2, 1), {77, 96, 76});
  if (skin > deep) skin = blend(skin, ellipsoid(p - dvec3(0, -46, -62), {60, 60, 66}), 20);
  if (skin > deep) skin = blend(skin, ellipsoid(p - dvec3(0, 6, -36), {79, 78, 46}), 16);
  if (skin > deep) skin = blend(skin, capsule(p, {0, -94, -36}, {0, -104, -58}, 7, 8), 10);
  if (skin > deep) skin = blend(skin, capsule(p, {0, 12, -60}, {0, 20, -140}, 56, 54), 20);
  if (skin > 2 * edge)
    return {brush.hounsfield(), tissue,
            (skin - 2 * edge) * std::min({anatomy.size.x, anatomy.size.y, anatomy.size.z})};
  paint(skin, 45, HeadTissue::soft_tissue);
  if (skin < -1.8)
    paint(std::max(skin + 1.8, -(skin + 5.0)), -70, HeadTissue::soft_tissue);  // fat below the skin

  // Vault: two tables with diploe between them, thinner at the temples, with grooves at the sutures.
  const double temple =
      std::clamp((p.x - 45) / 25, 0.0, 1.0) * std::clamp(1 - std::abs(p.z + 8) / 42, 0.0, 1.0);
  const double occiput =
      std::clamp((p.y - 45) / 35, 0.0, 1.0) * std::clamp(1 - std::abs(p.z + 4) / 46, 0.0, 1.0);
  const double thickness =
      anatomy.thickness * (6.6 - 4.4 * temple + 1.8 * occiput * (1 - temple) + 0.45 * wave(world, 62));
  const double groove = p.z > 2 && outer > -1.6 ? 0.9 * std::max(0.0, 1 - suture(world, world.x) / 1.1) : 0.0;
  const double outside = outer + groove, inside = outer + thickness;
  double shell = std::max(outside, -inside);
  const double magnum = std::max(std::sqrt(p.x * p.x + (p.y - 22) * (p.y - 22)) - 16.0, p.z + 20);
  shell = carve(shell, magnum, 4);
  const double mastoid = capsule(p, {58, 17, -40}, {55, 13, -56}, 10.5, 5.0);
  const bool is_near_face = inside > -7 - edge;  // the face ends at the brain case
  const Face f = is_near_face ? face(p) : Face{};
  double bone = blend(shell, mastoid, 10);
  if (f.bone < 50) {
    const double in_brain_case = inside + 2.0;  // keeps the face out of the brain case
    bone = blend(bone, std::max(f.bone, -in_brain_case), 5);
  }
  // Foramina of the base and the face.
  if (p.z < -20 && bone < edge) {
    bone = carve(bone, capsule(p, {23, -14, -70}, {23, -14, -28}, 2.6, 2.4), 1.5);  // foramen ovale
    bone = carve(bone, capsule(p, {25, 12, -75}, {20, 6, -30}, 4.0, 2.8), 1.5);     // jugular foramen
    bone = carve(bone, capsule(p, {17, -40, -36}, {11, -26, -33}, 2.4, 2.2), 1.5);  // optic canal
    bone = carve(bone, capsule(p, {27, -86, -57}, {27, -66, -50}, 1.5, 1.3), 1);    // infraorbital
    bone = carve(bone, capsule(p, {25, -86, -105}, {23, -62, -102}, 1.5, 1.3), 1);  // mental
  }
  if (bone < edge) {
    const dvec3 ear = p - dvec3(66, 4, -42);
    bone = carve(bone, std::max(std::sqrt(ear.y * ear.y + ear.z * ear.z) - 3.6, 46 - p.x), 2);
  }

  if (bone < edge) {
    paint(bone, 1480, HeadTissue::cortical_bone);
    // Diploe between the tables of the vault and in the core of thick bones; trabeculae are a fine wave.
    const double table = 1.7;
    const double core = std::max(std::max(outside + table, -(inside - table)), bone + table);
    const double thick = bone + 2.6;
    const double marrow = inside > 0 && outside < 0 ? core : thick;
    if (marrow < edge)
      paint(marrow, 520 + 190 * wave(world, 3.7) + 60 * wave(world, 9.1), HeadTissue::diploe);
  }
  if (f.tooth < edge) paint(f.tooth, 2250, HeadTissue::tooth);
  if (f.air < edge && tissue == HeadTissue::soft_tissue) paint(f.air, -950, HeadTissue::air);
  // The frontal sinus: air between the tables above the nose, with a septum in the middle.
  const double frontal =
      std::max(ellipsoid(p - dvec3(13, -79, -19), anatomy.frontal_sinus * dvec3(11.5, 5.5, 9.5)), 0.7 - p.x);
  if (frontal < edge && bone < 0) paint(std::max(frontal, bone + 1.3), -960, HeadTissue::air);
  if (mastoid < -3 && outside > -2) paint(1.2 - 2.4 * std::abs(wave(world, 9)), -500, HeadTissue::air);

  paint_brain_case(inside);
  paint_sinus(inside);
  return {brush.hounsfield(), tissue, 0};
}

}  // namespace trephine::data_tools
