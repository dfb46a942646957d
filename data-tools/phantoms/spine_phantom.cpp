#include "data-tools/phantoms/spine_phantom.h"

#include <string_view>

#include "data-tools/phantoms/soft_shapes.h"

namespace trephine::data_tools {

using glm::dvec3;

namespace {

// Local frame of a vertebra: origin at the centre of its body, x to a side, y to the back, z up; mm of the
// reference L3.
constexpr double k_body_x = 23, k_body_y = 16.5, k_body_z = 13.5;
constexpr double k_canal_y = 24, k_canal_rx = 11.5, k_canal_ry = 8;
constexpr dvec3 k_pedicle_front{11.5, 10, 6.5}, k_pedicle_back{14.5, 27, 6.5};
constexpr double k_pedicle_height = 0.62;  ///< ratio of a pedicle's width to its height
constexpr double k_joint_gap = 1.6;        ///< gap between facets, mm
constexpr double k_sac = 6.6;              ///< radius of the dural sac, mm
constexpr double k_most_sway = 6;          ///< greatest distance of the sac's centre line from x = 0, mm
constexpr double k_reach_front = -24;      ///< lower limit of y of a vertebra's bone, mm
constexpr double k_reach_z = 46;           ///< upper limit of |z| of a vertebra's bone, mm

/// Returns the distance to the spinal canal, mm, in the local frame.
double canal(const dvec3& p) { return elliptic_cylinder(p.x, p.y - k_canal_y, k_canal_rx, k_canal_ry); }

/// Returns the distance to a capsule that is flattened along a direction (unit) by a factor.
double flattened(const dvec3& p, const dvec3& along, double factor, const dvec3& a, const dvec3& b, double ra,
                 double rb) {
  const auto stretched = [&](const dvec3& q) { return q + (1 / factor - 1) * glm::dot(q, along) * along; };
  return capsule(stretched(p), stretched(a), stretched(b), ra, rb);
}
/// Returns the distance to a box with rounded edges, a superellipsoid of the fourth power around the origin.
double rounded_box(const dvec3& p, const dvec3& half) {
  const dvec3 unit = p / half, square = unit * unit;
  const double k = std::sqrt(std::sqrt(glm::dot(square, square)));
  if (k < 1e-9) return -half.x;
  return (k - 1) * (k * k * k) / glm::length(unit * square / half);
}

/// Returns the distance to the rim of a disc, mm. `above`, `below`: one point, in the frames of the upper and
/// of the lower vertebra.
double disc_rim(const dvec3& above, const dvec3& below) {
  return std::max(elliptic_cylinder(above.x, above.y, k_body_x, k_body_y),
                  elliptic_cylinder(below.x, below.y, k_body_x, k_body_y)) -
         0.5;
}
/// Returns the distance to the ligamentum flavum between two laminae, mm. `above`, `below`: one point, in the
/// frames of the upper and of the lower vertebra, x >= 0.
double flavum(const dvec3& above, const dvec3& below) {
  // A sheet along the inner faces of the laminae, 3.4 mm thick.
  const auto sheet = [](const dvec3& p) { return std::abs(p.y - 37.2 + 0.62 * p.x) / 1.18 - 1.7; };
  const double down = std::max(0.0, -5 - above.z), up = std::max(0.0, below.z + 1);
  const double share = down + up > 1e-9 ? down / (down + up) : 0.5;
  return std::max({sheet(above) + share * (sheet(below) - sheet(above)), 0.5 * (above.x + below.x) - 11.5,
                   above.z + 4, -2 - below.z});
}
/// Returns the distance to the nerve root below a pedicle, mm; p.x >= 0.
double nerve_root(const dvec3& p) {
  return std::min(capsule(p, {5.5, 23.5, -2}, {17, 20.5, -13}, 1.6, 2.6),
                  capsule(p, {17, 20.5, -13}, {30, 9, -27}, 2.6, 2.2));
}

/// Returns the rotation to the frame of a vertebra that is tilted by `angle` about x and by `roll` about y.
glm::dmat3 tilt(double angle, double roll) {
  const double s = deterministic_sin(angle), c = deterministic_cos(angle), sr = deterministic_sin(roll),
               cr = deterministic_cos(roll);
  const glm::dmat3 about_x(dvec3(1, 0, 0), dvec3(0, c, -s), dvec3(0, s, c));
  const glm::dmat3 about_y(dvec3(cr, 0, -sr), dvec3(0, 1, 0), dvec3(sr, 0, cr));
  return about_x * about_y;
}

/// Returns a value of -1 to 1 that depends on seed and stream; 0 for the reference anatomy.
double vary(std::uint64_t seed, std::uint64_t stream) {
  if (seed == 1) return 0;
  return static_cast<double>(hash_bits(hash_bits(seed) ^ stream) >> 11) * 0x1p-52 - 1;
}

}  // namespace

SpinePhantom::SpinePhantom(std::uint64_t seed) {
  const double size = 1 + 0.06 * vary(seed, 1), lordosis = 1 + 0.5 * vary(seed, 2);
  pedicle_ = 4.4 + 0.7 * vary(seed, 3);
  // A scoliosis shifts and tilts the upper vertebrae.
  const double sway = 5 * vary(seed, 7), transverse = 1 + 0.2 * vary(seed, 8),
               spinous = 1 + 0.25 * vary(seed, 9), droop = 0.2 * vary(seed, 10), rise = 0.15 * vary(seed, 11);
  const struct {
    dvec3 centre;
    double degrees, scale, sway, transverse, spinous, droop, rise;
  } reference[3] = {{{0, -1.5, 37}, -5, 1.0, 1, 1.05, 1, 0.24, 0.06},
                    {{0, 0, 0}, 3, 1.03, 0.35, 0.97, 0.96, 0.2, 0.14},
                    {{0, 2.5, -37.5}, 14, 1.06, 0, 0.86, 0.8, 0.12, 0.24}};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto& r = reference[i];
    const double angle = lordosis * r.degrees * 3.14159265358979323846 / 180;
    // The tilt follows the slope of the sway: 5 mm over 37 mm.
    const double roll = -0.9 * sway / 37 * (r.sway > 0 ? 1 : 0.5);
    Vertebra& v = vertebrae_[i];
    v.centre = size * (r.centre + dvec3(sway * r.sway, 0, 0));
    v.to_local = tilt(angle, roll);
    v.scale = size * r.scale * (1 + 0.02 * vary(seed, 4 + i));
    v.transverse = r.transverse * transverse, v.spinous = r.spinous * spinous;
    v.droop = r.droop + droop, v.rise = r.rise + rise;
  }
  sac_[0] = vertebrae_[0].world({0, k_canal_y, 40});
  for (std::size_t i = 0; i < 3; ++i) {
    sac_[1 + 2 * i] = vertebrae_[i].world({0, k_canal_y - 0.5, 12});
    sac_[2 + 2 * i] = vertebrae_[i].world({0, k_canal_y - 0.5, -14});
  }
  sac_[7] = vertebrae_[2].world({0, k_canal_y + 4, -44});
}

dvec3 SpinePhantom::Vertebra::local(const dvec3& world) const noexcept {
  return to_local * ((world - centre) / scale);
}
dvec3 SpinePhantom::Vertebra::world(const dvec3& p) const noexcept {
  return centre + scale * (p * to_local);  // the inverse of a rotation is its transpose
}

double SpinePhantom::body(const dvec3& p) const noexcept {
  const double waist = 1 - 0.09 * std::max(0.0, 1 - p.z * p.z / (k_body_z * k_body_z));
  double side = elliptic_cylinder(p.x, p.y, k_body_x * waist, k_body_y * waist);
  side = carve(side, std::sqrt(p.x * p.x + (p.y - 26) * (p.y - 26)) - 11, 5);  // concave toward the canal
  // End plates are concave.
  const double bowl = 1.3 * std::max(0.0, 1 - (p.x * p.x) / 300 - (p.y * p.y) / 150);
  return carve(side, k_body_z - bowl - std::abs(p.z), 3.0);
}

/// Returns the distance to the bone of one vertebra; p.x >= 0 (left and right are symmetric).
double SpinePhantom::bone(const Vertebra& v, const dvec3& p) const noexcept {
  // Lamina: a plate that slopes backward toward its lower edge.
  const dvec3 sloped(p.x, p.y + 0.16 * (p.z + 2), (p.z + 2) * 0.36);
  double arch = capsule(sloped, {14, 30, 0}, {0, 40.0, 0}, 3.2, 3.4);
  // Spinous process: a blade with a thick posterior edge. `back`: 0 at its root, 1 at this edge.
  const double length = 27 * v.spinous, back = std::clamp((p.y - 42) / length, 0.0, 1.0);
  const dvec3 half(2.3 + 1.4 * back * back, 0.5 * length, 8.3 + 1.7 * back);
  const dvec3 in_blade(p.x, p.y - 42 - half.y, p.z + 4.5 + v.droop * (p.y - 42));
  arch = blend(arch, rounded_box(in_blade, half), 4.5);
  // Transverse process: flat from front to back.
  const double reach = 25 * v.transverse;
  arch = blend(arch,
               flattened(p, {0, 0.99, -0.14}, 0.62, {16, 28.5, 5},
                         {17 + reach, 28.5 + 0.24 * reach, 5.5 + v.rise * reach}, 5.6 / v.transverse,
                         4.1 / v.transverse),
               6);
  // Upper articular process with the mamillary process, and lower articular process, with oblique faces.
  arch = blend(arch, flattened(p, {-0.66, 0.75, 0}, 0.72, {17, 30, 6}, {18.9, 32.6, 17.5}, 6.2, 5.2), 5);
  arch = blend(arch, capsule(p, {20.5, 35, 10}, {21, 36.5, 14.5}, 3.4, 2.6), 4);
  arch =
      blend(arch, flattened(p, {0.66, -0.75, 0}, 0.72, {12.5, 35.5, -4}, {13.6, 38.2, -18.5}, 5.6, 5.6), 6);
  arch = carve(arch, canal(p), 2.5);
  const double pedicle = capsule({p.x, p.y, k_pedicle_front.z + (p.z - k_pedicle_front.z) * k_pedicle_height},
                                 k_pedicle_front, k_pedicle_back, pedicle_ + 0.4, pedicle_);
  return blend(blend(arch, pedicle, 4), body(p), 4);
}

std::array<double, 3> SpinePhantom::bone_distances(const dvec3& world) const noexcept {
  std::array<double, 3> own{}, separated{};
  for (std::size_t i = 0; i < 3; ++i) {
    dvec3 p = vertebrae_[i].local(world);
    p.x = std::abs(p.x);
    own[i] =
        std::abs(p.z) > k_reach_z || p.y < k_reach_front ? 1e3 : vertebrae_[i].scale * bone(vertebrae_[i], p);
  }
  // Neighbouring vertebrae are separated by a gap, half on each side.
  for (std::size_t i = 0; i < 3; ++i) {
    separated[i] = own[i];
    for (std::size_t k = 0; k < 3; ++k)
      if (k != i) separated[i] = std::max(separated[i], 0.5 * (own[i] - own[k] + k_joint_gap));
  }
  return separated;
}

SpinePhantom::Sample SpinePhantom::sample(const dvec3& world, double voxel_mm) const noexcept {
  Brush brush(-1000, voxel_mm);
  SpineTissue tissue = SpineTissue::background;
  const auto paint = [&](double s, double hounsfield, SpineTissue kind) {
    if (brush.paint(s, hounsfield)) tissue = kind;
  };
  // Parts that are farther away than the width of the soft border paint nothing. They are skipped where this
  // is cheap to decide.
  const double edge = brush.edge();
  const auto paint_waves = [&](double s, double middle, double height, double period) {
    return s <= edge && brush.paint(s, middle + height * wave(world, period));
  };
  const double skin = world.y - 78 + world.x * world.x / 420;
  if (skin > edge) return {-1000, SpineTissue::background};
  brush.paint(skin, 35);
  brush.paint(std::max(skin + 2, -(skin + 13)), -105);                             // fat below the skin
  paint_waves(world.y - 64 + world.x * world.x / 300, 58, 7, 31);                  // muscle
  if (world.y < -18 + edge) brush.paint(world.y + 22 + 4 * wave(world, 43), -95);  // prevertebral fat
  const std::array<dvec3, 3> p = mirrored_points(world);

  // Vessels in front of the spine.
  if (world.y < -18 + edge) {
    const double aorta = capsule(world, {6, -33, 80}, {3, -30, -34}, 8.5, 8.0),
                 cava = capsule(world, {-17, -31, 80}, {-14, -28, -80}, 9.0, 9.5),
                 branch = capsule(world, {3, -30, -34}, {24, -30, -90}, 6.5, 5.5);
    paint(std::min({aorta, cava, branch}), 46, SpineTissue::vessel);
  }

  // Discs fill the space between two bodies.
  for (std::size_t i = 0; i < 2; ++i) {
    const double above = p[i].z + k_body_z - 1, below = k_body_z - 1 - p[i + 1].z;
    if (above > edge || below > edge) continue;
    const double rim = disc_rim(p[i], p[i + 1]);
    const double disc = std::max({above, below, rim});
    paint(disc, 105, SpineTissue::disc);
    paint(std::max(disc + 1.5, rim + 8), 75, SpineTissue::disc);  // nucleus
  }

  // Canal: fat around the dural sac, which contains roots; a root leaves below each pedicle.
  double hollow = 1e3;
  for (const dvec3& q : p)
    if (std::abs(q.z) < 24) hollow = std::min(hollow, canal(q));
  brush.paint(hollow, -85);
  if (std::abs(world.x) < k_sac + k_most_sway + edge) {
    const double distance = sac(world);
    paint(distance, 18, SpineTissue::dural_sac);
    if (paint_waves(distance + 2.2, 40, 8, 5)) tissue = SpineTissue::dural_sac;
  }
  double root = 1e3;
  for (std::size_t i = 0; i < 3; ++i) {
    if (std::max(std::abs(p[i].y - 16) - 11, std::abs(p[i].z + 15) - 16) > edge) continue;
    root = std::min(root, nerve_root(p[i]));
  }
  paint(root, 42, SpineTissue::nerve_root);

  for (std::size_t i = 0; i < 2; ++i)
    if (p[i].z < -4 + edge && p[i + 1].z > -2 - edge)
      paint(flavum(p[i], p[i + 1]), 78, SpineTissue::ligament);

  const std::array<double, 3> bones = bone_distances(world);
  for (std::size_t i = 0; i < 3; ++i) {
    const double bone = bones[i];
    if (bone > edge) continue;
    paint(bone, 1150, static_cast<SpineTissue>(1 + i));
    // A dense shell, thin around the body, and a core of trabeculae.
    const double shell = p[i].y < 14 ? 1.1 : 1.8;
    brush.paint(bone + shell, 235 + 55 * wave(world, 3.3) + 20 * wave(world, 7.9));
  }
  return {brush.hounsfield(), tissue};
}

double SpinePhantom::sac(const dvec3& world) const noexcept {
  double sac = 1e3;
  for (std::size_t i = 0; i + 1 < sac_.size(); ++i)
    sac =
        std::min(sac, capsule(world, sac_[i], sac_[i + 1], k_sac, i + 2 < sac_.size() ? k_sac : k_sac - 1.5));
  return sac;
}

std::array<dvec3, 3> SpinePhantom::mirrored_points(const dvec3& world) const noexcept {
  std::array<dvec3, 3> p;
  for (std::size_t i = 0; i < 3; ++i) {
    p[i] = vertebrae_[i].local(world);
    p[i].x = std::abs(p[i].x);
  }
  return p;
}

std::vector<SpinePart> SpinePhantom::parts() const {
  constexpr double k_margin = 3;  // mm
  std::vector<SpinePart> parts;
  const auto add = [&](std::string name, SpineTissue tissue, int vertebra, double side,
                       std::initializer_list<dvec3> around, double radius) {
    SpinePart part{std::move(name), tissue, vertebra, side, dvec3(1e3), dvec3(-1e3)};
    for (const dvec3& p : around) {
      part.low_world = glm::min(part.low_world, p - radius - k_margin);
      part.high_world = glm::max(part.high_world, p + radius + k_margin);
    }
    part.low_world = glm::max(part.low_world, k_spine_low - k_margin);
    part.high_world = glm::min(part.high_world, k_spine_high + k_margin);
    parts.push_back(std::move(part));
  };
  const auto name_of = [](int vertebra) { return std::string(k_spine_tissue_names[vertebra + 1]); };
  for (int i = 0; i < 2; ++i) {
    const dvec3 upper = world_point(i, {0, 0, -k_body_z}), lower = world_point(i + 1, {0, 0, k_body_z});
    add("disc " + name_of(i) + "-" + name_of(i + 1), SpineTissue::disc, i, 0, {upper, lower}, 1.1 * k_body_x);
  }
  add("dural sac", SpineTissue::dural_sac, 0, 0,
      {sac_[0], sac_[1], sac_[2], sac_[3], sac_[4], sac_[5], sac_[6], sac_[7]}, k_sac);
  for (int i = 0; i < 3; ++i)
    for (const double side : {1.0, -1.0})
      add(name_of(i) + (side > 0 ? " left" : " right") + " nerve root", SpineTissue::nerve_root, i, side,
          {world_point(i, {side * 5.5, 23.5, -2}), world_point(i, {side * 30, 9, -27})}, 4);
  return parts;
}

double SpinePhantom::part_distance(const SpinePart& part, const dvec3& world) const noexcept {
  const std::array<dvec3, 3> p = mirrored_points(world);
  const auto vertebra = static_cast<std::size_t>(part.vertebra);
  double distance =
      std::max(std::max({k_spine_low.x - world.x, k_spine_low.y - world.y, k_spine_low.z - world.z}),
               std::max({world.x - k_spine_high.x, world.y - k_spine_high.y, world.z - k_spine_high.z}));
  if (part.tissue == SpineTissue::disc) {
    const dvec3 &above = p[vertebra], &below = p[vertebra + 1];
    distance = std::max({distance, above.z + k_body_z - 1, k_body_z - 1 - below.z, disc_rim(above, below)});
  } else if (part.tissue == SpineTissue::dural_sac) {
    distance = std::max(distance, sac(world));
  } else {
    distance =
        std::max({distance, nerve_root(p[vertebra]), -part.side * vertebrae_[vertebra].local(world).x});
  }
  // Far outside the part, the parts that cover it are not considered: they only increase the distance.
  constexpr double k_far = 2;  // mm
  if (distance > k_far) return distance;
  // As in sample(): bone covers nerve roots, which cover the dural sac, which covers discs.
  for (const double bone : bone_distances(world)) distance = std::max(distance, -bone);
  if (part.tissue == SpineTissue::nerve_root) return distance;
  for (const dvec3& q : p) distance = std::max(distance, -nerve_root(q));
  return part.tissue == SpineTissue::disc ? std::max(distance, -sac(world)) : distance;
}

double SpinePhantom::bone_margin(int vertebra, const dvec3& entry, const dvec3& target) const noexcept {
  // Positions nearer to the entry are skipped, because the outer surface of bone is there.
  constexpr double k_in = 6, k_step = 0.5;  // mm
  const double length = glm::length(target - entry);
  double least = 1e3;
  for (double t = k_in; t <= length; t += k_step)
    least = std::min(
        least, -bone_distances(glm::mix(entry, target, t / length))[static_cast<std::size_t>(vertebra)]);
  return least;
}

std::vector<SpineScrew> SpinePhantom::screws() const {
  constexpr double k_wall = 0.4, k_sizes = 0.5;  // mm
  // Pedicle screw: along the axis of the pedicle. Cortical screw: through the middle of the pedicle, from
  // caudal and medial.
  const dvec3 axis = k_pedicle_front - k_pedicle_back, middle = 0.5 * (k_pedicle_front + k_pedicle_back);
  const auto on_axis = [&](double y) { return k_pedicle_back + axis * ((y - k_pedicle_back.y) / axis.y); };
  const dvec3 low(11.6, 35.5, 0.5), outward = (middle - low) / (middle.y - low.y);
  const struct {
    const char* kind;
    dvec3 entry, target;
    double diameter, reach;
  } initial[] = {{"pedicle", on_axis(37), on_axis(-9), 6.0, 4.0},
                 {"cortical", low, low + outward * (6 - low.y), 4.5, 1.5}};
  std::vector<SpineScrew> screws;
  for (int i = 0; i < 3; ++i) {
    const Vertebra& v = vertebrae_[static_cast<std::size_t>(i)];
    for (const char* side : {"left", "right"}) {
      const dvec3 mirror(std::string_view(side) == "left" ? 1 : -1, 1, 1);
      for (std::size_t k = 0; k < 2; ++k) {
        // Local search for the line with the most bone around it: the ends move alone, together and in
        // opposite directions, as long as the thickness of the bone increases.
        using Move = std::array<double, 4>;  // shift of the entry along x and z, then of the target
        constexpr std::array<Move, 8> k_moves{{{1, 0, 0, 0},
                                               {0, 1, 0, 0},
                                               {0, 0, 1, 0},
                                               {0, 0, 0, 1},
                                               {1, 0, 1, 0},
                                               {0, 1, 0, 1},
                                               {1, 0, -1, 0},
                                               {0, 1, 0, -1}}};
        Move at{};
        const auto ends_at = [&](const Move& m) {
          return std::pair(initial[k].entry + dvec3(m[0], 0, m[1]), initial[k].target + dvec3(m[2], 0, m[3]));
        };
        const auto margin_at = [&](const Move& m) {
          for (const double shift : m)
            if (std::abs(shift) > initial[k].reach) return -1e3;
          const auto [entry, target] = ends_at(m);
          // A cortical screw points laterally and cranially.
          const dvec3 direction = target - entry;
          if (k == 1 && (direction.x < 2.5 || direction.z < 7)) return -1e3;
          return bone_margin(i, v.world(mirror * entry), v.world(mirror * target));
        };
        double best = margin_at(at);
        for (double step = 2; step > 0.05; step *= 0.5)
          for (bool has_moved = true; has_moved;) {
            has_moved = false;
            for (const Move& move : k_moves)
              for (const double change : {step, -step}) {
                Move next = at;
                for (std::size_t c = 0; c < 4; ++c) next[c] += change * move[c];
                if (const double next_margin = margin_at(next); next_margin > best + 1e-6)
                  best = next_margin, at = next, has_moved = true;
              }
          }
        const double largest_diameter = std::floor(2 * (best - k_wall) / k_sizes) * k_sizes;
        const auto [entry, target] = ends_at(at);
        std::string name = k_spine_tissue_names[i + 1];
        screws.push_back({name.append(" ").append(side).append(" ").append(initial[k].kind),
                          v.world(mirror * entry), v.world(mirror * target),
                          std::clamp(largest_diameter, k_sizes, initial[k].diameter)});
      }
    }
  }
  return screws;
}

}  // namespace trephine::data_tools
