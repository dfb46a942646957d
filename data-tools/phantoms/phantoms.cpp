#include "data-tools/phantoms/phantoms.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <vector>

#include "data-tools/phantoms/head_phantom.h"
#include "data-tools/phantoms/spine_phantom.h"
#include "volume/base/deterministic_math.h"
#include "volume/base/parallel.h"
#include "volume/base/text.h"
#include "volume/scan/gaussian.h"

namespace trephine::data_tools {

using glm::dvec3;
using volume::Frame;
using volume::Volume;

namespace {

constexpr double k_box_mm = 120, k_air = -1000, k_solid = 1600;
constexpr double k_degree = 3.14159265358979323846 / 180;

const std::vector<PhantomInfo> k_catalogue{
    {"sphere", "a ball", {{"radius", "mm", 45}}},
    {"plane",
     "a half space below a tilted plane",
     {{"angle", "degrees from the xy plane", 30}, {"offset", "mm along the normal", 0}}},
    {"plate", "a tilted plate", {{"thickness", "mm", 6}, {"angle", "degrees from the xy plane", 30}}},
    {"torus", "a ring about z", {{"major", "mm to the tube's middle", 35}, {"minor", "mm, tube radius", 14}}},
    {"gyroid", "a labyrinth", {{"period", "mm", 30}}},
    {"groove",
     "a half space with a V-groove, oblique to the axes",
     {{"angle", "degrees between its walls", 90}, {"depth", "mm", 20}}},
    {"corner",
     "an inner corner of three walls, oblique to the axes",
     {{"offset", "mm from the middle along each wall's normal", 20}}},
    {"slot", "a half space with a slot, oblique to the axes", {{"width", "mm", 8}, {"depth", "mm", 20}}},
    {"pit",
     "a half space with a conical pit, oblique to the axes",
     {{"angle", "degrees between opposite sides", 60}, {"depth", "mm", 20}}},
    {"wedge",
     "a wedge with its edge 20 mm above the middle, oblique to the axes",
     {{"angle", "degrees between its sides", 60}}},
    {"cone",
     "a cone with its tip 20 mm above the middle, oblique to the axes",
     {{"angle", "degrees from its axis to its side", 30}}},
    {"steps", "a staircase, oblique to the axes", {{"rise", "mm", 3}, {"run", "mm", 6}}},
    {"shell",
     "a skull-like shell with radii of 0.36 and 0.42 of the box's edge, and two holes",
     {{"noise", "HU, +- uniform", 20}}},
    {"box", "a box, oblique to the axes", {{"width", "mm", 50}, {"depth", "mm", 40}, {"height", "mm", 30}}},
    {"peg", "a peg on a half space, oblique to the axes", {{"radius", "mm", 6}, {"height", "mm", 20}}},
    {"hole",
     "a half space with a drilled hole, oblique to the axes",
     {{"radius", "mm", 6}, {"depth", "mm", 20}}},
    {"head", "an anatomical head with labels and a tumour", {{"noise", "HU, standard deviation", 12}}},
    {"spine",
     "three lumbar vertebrae with labels, dural sac and nerve roots",
     {{"noise", "HU, standard deviation", 12}}},
};

const PhantomInfo* find(const std::string& name) {
  for (const PhantomInfo& info : k_catalogue)
    if (info.name == name) return &info;
  return nullptr;
}

using Parameters = std::map<std::string, double>;
double parameter(const std::string& phantom, const Parameters& parameters, const std::string& name) {
  if (const auto it = parameters.find(name); it != parameters.end()) return it->second;
  for (const PhantomParameter& p : find(phantom)->parameters)
    if (p.name == name) return p.value;
  return 0;
}

/// Returns the normal of a plane tilted about y.
dvec3 tilted_normal(double degrees) {
  return {deterministic_sin(degrees * k_degree), 0, deterministic_cos(degrees * k_degree)};
}

/// Axes that are not parallel to any lattice plane: x, y and z rotated by 11 degrees about x, then by 17
/// about z.
const dvec3 k_across{0.9563047559630354, 0.29237170472273677, 0.0},
    k_along{-0.2870000130267722, 0.9387347441136001, 0.1908089953765448},
    k_up{0.055787151254673206, -0.18247154975911864, 0.981627183447664};

/// An analytic shape with resolved parameters.
struct AnalyticShape {
  enum class Kind {
    sphere,
    plane,
    plate,
    torus,
    gyroid,
    groove,
    corner,
    slot,
    pit,
    wedge,
    cone,
    steps,
    shell,
    box,
    peg,
    hole
  } kind;
  double a = 0, b = 0;
  dvec3 normal{0, 0, 1}, half{0};
  double sine = 0, cosine = 1;

  void set_angle(double radians) {
    sine = deterministic_sin(radians);
    cosine = deterministic_cos(radians);
  }
  AnalyticShape(const std::string& name, const Parameters& parameters) {
    const auto get = [&](const char* key) { return parameter(name, parameters, key); };
    if (name == "sphere")
      kind = Kind::sphere, a = get("radius");
    else if (name == "plane")
      kind = Kind::plane, normal = tilted_normal(get("angle")), a = get("offset");
    else if (name == "plate")
      kind = Kind::plate, normal = tilted_normal(get("angle")), a = 0.5 * get("thickness");
    else if (name == "torus")
      kind = Kind::torus, a = get("major"), b = get("minor");
    else if (name == "gyroid")
      kind = Kind::gyroid, a = 360 * k_degree / get("period");
    else if (name == "groove")
      kind = Kind::groove, a = 0.5 * get("angle") * k_degree, b = get("depth"), set_angle(a);
    else if (name == "corner")
      kind = Kind::corner, a = get("offset");
    else if (name == "slot")
      kind = Kind::slot, a = 0.5 * get("width"), b = get("depth");
    else if (name == "pit")
      kind = Kind::pit, b = get("depth"), set_angle(0.5 * get("angle") * k_degree);
    else if (name == "wedge")
      kind = Kind::wedge, set_angle(0.5 * get("angle") * k_degree);
    else if (name == "cone")
      kind = Kind::cone, a = get("angle") * k_degree, set_angle(a);
    else if (name == "steps")
      kind = Kind::steps, a = get("rise"), b = get("run");
    else if (name == "box")
      kind = Kind::box, half = 0.5 * dvec3(get("width"), get("depth"), get("height"));
    else if (name == "peg" || name == "hole")
      kind = name == "peg" ? Kind::peg : Kind::hole, a = get("radius"),
      b = get(name == "peg" ? "height" : "depth");
    else
      kind = Kind::shell;
  }

  double distance(const dvec3& p) const {
    switch (kind) {
      case Kind::sphere:
        return glm::length(p) - a;
      case Kind::plane:
        return glm::dot(p, normal) - a;
      case Kind::plate:
        return std::abs(glm::dot(p, normal)) - a;
      case Kind::torus: {
        const double ring = std::sqrt(p.x * p.x + p.y * p.y) - a;
        return std::sqrt(ring * ring + p.z * p.z) - b;
      }
      case Kind::gyroid: {
        const dvec3 s(deterministic_sin(a * p.x), deterministic_sin(a * p.y), deterministic_sin(a * p.z));
        const dvec3 c(deterministic_cos(a * p.x), deterministic_cos(a * p.y), deterministic_cos(a * p.z));
        const double f = s.x * c.y + s.y * c.z + s.z * c.x;
        const dvec3 gradient(c.x * c.y - s.z * s.x, c.y * c.z - s.x * s.y, c.z * c.x - s.y * s.z);
        return f / std::max(a * glm::length(gradient), 1e-9);
      }
      case Kind::groove: {
        const double x = std::abs(glm::dot(p, k_across)), z = glm::dot(p, k_up);
        return std::max(z, (z + b) * sine - x * cosine);
      }
      case Kind::corner:
        return std::min({glm::dot(p, k_across), glm::dot(p, k_along), glm::dot(p, k_up)}) + a;
      case Kind::slot: {
        const double x = std::abs(glm::dot(p, k_across)), z = glm::dot(p, k_up);
        return std::max(z, std::min(a - x, z + b));
      }
      case Kind::pit: {
        const double x = glm::dot(p, k_across), y = glm::dot(p, k_along), z = glm::dot(p, k_up);
        return std::max(z, (z + b) * sine - std::sqrt(x * x + y * y) * cosine);
      }
      case Kind::wedge: {
        const double x = std::abs(glm::dot(p, k_across)), z = glm::dot(p, k_up) - 20;
        const bool is_beyond_edge = x * sine < z * cosine;
        return is_beyond_edge ? std::sqrt(x * x + z * z) : x * cosine + z * sine;
      }
      case Kind::cone: {
        const double x = glm::dot(p, k_across), y = glm::dot(p, k_along), z = glm::dot(p, k_up);
        return std::sqrt(x * x + y * y) * cosine + (z - 20) * sine;
      }
      case Kind::steps: {
        const double x = glm::dot(p, k_across), z = glm::dot(p, k_up), middle = std::floor(x / b);
        double nearest = 1e9;
        for (int k = -2; k <= 2; ++k)
          nearest = std::min(nearest, std::max((middle + k) * b - x, z - (middle + k) * a));
        return nearest;
      }
      case Kind::box: {
        const dvec3 q =
            glm::abs(dvec3(glm::dot(p, k_across), glm::dot(p, k_along), glm::dot(p, k_up))) - half;
        return std::max({q.x, q.y, q.z});
      }
      case Kind::peg:
      case Kind::hole: {
        const double x = glm::dot(p, k_across), y = glm::dot(p, k_along), z = glm::dot(p, k_up);
        const double side = std::sqrt(x * x + y * y) - a;
        return kind == Kind::peg ? std::min(z, std::max(side, z - b)) : std::max(z, -std::max(side, -b - z));
      }
      case Kind::shell: {
        const double r = glm::length(p);
        const double shell = std::max(r - 0.42 * k_box_mm, 0.36 * k_box_mm - r);
        const double top = p.z > 0 ? std::sqrt(p.x * p.x + p.y * p.y) - 9 : 1e3;
        const double side = p.x > 0 ? std::sqrt((p.y - 10) * (p.y - 10) + p.z * p.z) - 6 : 1e3;
        return std::max({shell, -top, -side});
      }
    }
    return 0;
  }
};

/// Returns the share of the unit cube around 0 in which value + gradient . x <= 0: exact for a plane.
double covered_share(double value, dvec3 gradient) {
  gradient = glm::abs(gradient);
  const double largest = std::max({gradient.x, gradient.y, gradient.z});
  const dvec3 m = glm::max(gradient, dvec3(1e-3 * largest));  // keeps the closed form well conditioned
  const double alpha = -value + 0.5 * (m.x + m.y + m.z);
  if (alpha <= 0) return 0;
  if (alpha >= m.x + m.y + m.z) return 1;
  const auto cube = [](double x) { return x > 0 ? x * x * x : 0.0; };
  const double sum = cube(alpha) - cube(alpha - m.x) - cube(alpha - m.y) - cube(alpha - m.z) +
                     cube(alpha - m.x - m.y) + cube(alpha - m.y - m.z) + cube(alpha - m.x - m.z);
  return std::clamp(sum / (6 * m.x * m.y * m.z), 0.0, 1.0);
}

/// Computes the share of every voxel that the shape covers; its surface is assumed flat within a voxel.
void fill_coverage(const AnalyticShape& shape, const Volume& volume, std::span<float> out, int threads) {
  const dvec3 dx = volume.frame.axes()[0], dy = volume.frame.axes()[1], dz = volume.frame.axes()[2];
  const double reach = 0.5 * volume.frame.diagonal_mm() + 1e-9;
  parallel_for(volume.size.z, threads, [&](int z) {
    for (int y = 0; y < volume.size.y; ++y)
      for (int x = 0; x < volume.size.x; ++x) {
        const dvec3 p = volume.frame.world_from_volume(dvec3(x, y, z));
        const double s = shape.distance(p);
        double share = s < 0 ? 1 : 0;
        if (std::abs(s) < reach) {
          const auto gradient = [&](const dvec3& d) {
            return shape.distance(p + 0.5 * d) - shape.distance(p - 0.5 * d);
          };
          share = covered_share(s, {gradient(dx), gradient(dy), gradient(dz)});
        }
        out[volume.index(x, y, z)] = static_cast<float>(share);
      }
  });
}

Result<Frame> phantom_frame(const dvec3& low, const dvec3& high, const glm::ivec3& size, const dvec3& spacing,
                            double shear) {
  glm::dmat3 axes(0.0);
  for (int i = 0; i < 3; ++i) axes[i][i] = spacing[i];
  axes[2][1] = spacing.z * deterministic_sin(shear * k_degree) / deterministic_cos(shear * k_degree);
  return Frame::from_axes(0.5 * (low + high) - axes * (0.5 * dvec3(size - 1)), axes);
}

}  // namespace

std::span<const PhantomInfo> phantom_catalogue() { return k_catalogue; }

double phantom_distance(const std::string& name, const Parameters& parameters, const dvec3& p_world) {
  return AnalyticShape(name, parameters).distance(p_world);
}

Result<Volume> make_phantom(const std::string& name, const PhantomOptions& options) {
  const PhantomInfo* info = find(name);
  if (info == nullptr) {
    std::string known;
    for (const PhantomInfo& i : k_catalogue) known += (known.empty() ? "" : ", ") + i.name;
    return Error{.what = "unknown phantom",
                 .found = name,
                 .expected = "one of " + known,
                 .remedy = "choose one of these"};
  }
  for (const auto& [key, value] : options.parameters) {
    std::string known;
    bool is_known = false;
    for (const PhantomParameter& p : info->parameters) {
      known += (known.empty() ? "" : ", ") + p.name;
      is_known = is_known || p.name == key;
    }
    if (!is_known)
      return Error{.what = "phantom " + name + " has no such parameter",
                   .where = "parameter",
                   .found = key,
                   .expected = "one of " + known};
    const bool may_be_zero = key == "angle" || key == "offset" || key == "noise";
    if (!std::isfinite(value) || std::abs(value) > 1e4 || (!may_be_zero && value <= 0) ||
        (key == "noise" && value < 0))
      return Error{.what = "the parameter is out of range",
                   .where = "parameter " + key,
                   .found = rounded_text(value),
                   .expected = may_be_zero ? key == "noise" ? "0 to 10000" : "-10000 to 10000"
                                           : "a positive number up to 10000"};
  }
  if (!(options.psf_sigma_voxels >= 0 && options.psf_sigma_voxels <= 2))
    return Error{.what = "the blur is out of range",
                 .where = "psf",
                 .found = rounded_text(options.psf_sigma_voxels),
                 .expected = "0 to 2 voxels"};
  if (!(std::abs(options.shear_degrees) <= 45))
    return Error{.what = "the shear is out of range",
                 .where = "shear",
                 .found = rounded_text(options.shear_degrees),
                 .expected = "-45 to 45 degrees"};
  const auto approach =
      options.approach.empty() ? std::optional(HeadApproach::vault) : head_approach(options.approach);
  if (!approach || (!options.approach.empty() && name != "head"))
    return Error{.what = approach ? "only a head has approaches" : "unknown approach",
                 .where = "approach",
                 .found = approach ? name : options.approach,
                 .expected = approach ? "head" : "vault, frontotemporal, suboccipital or keyhole"};

  // Grid: size and spacing, one derived from the other and the box.
  const bool is_head = name == "head", is_anatomy = is_head || name == "spine";
  const dvec3 low = is_head      ? k_head_low
                    : is_anatomy ? k_spine_low
                                 : dvec3(-0.5 * k_box_mm),
              high = is_head      ? k_head_high
                     : is_anatomy ? k_spine_high
                                  : dvec3(0.5 * k_box_mm);
  glm::ivec3 size(0);
  dvec3 spacing(0);
  if (options.spacing_mm) {
    spacing = *options.spacing_mm;
    for (int i = 0; i < 3; ++i)
      if (!(spacing[i] > 0) || !std::isfinite(spacing[i]))
        return Error{.what = "the spacing is not a positive number",
                     .where = "spacing",
                     .found = rounded_text(spacing[i]),
                     .expected = "mm above 0"};
  }
  if (options.size) size = *options.size;
  for (int i = 0; i < 3; ++i) {
    if (!options.size && !options.spacing_mm) {
      spacing[i] = is_head ? 0.8 : is_anatomy ? 0.7 : k_box_mm / 128;
    } else if (!options.spacing_mm) {
      if (size[i] < 1) break;  // make_volume returns the error below
      spacing[i] = (high[i] - low[i]) / size[i];
    }
    if (!options.size)
      size[i] = static_cast<int>(std::clamp(std::floor((high[i] - low[i]) / spacing[i] + 0.5), 1.0, 1e9));
  }
  if (is_anatomy && options.size && !options.spacing_mm)
    spacing = dvec3(std::max({spacing.x, spacing.y, spacing.z}));  // cubic voxels; the whole anatomy fits
  for (int i = 0; i < 3; ++i)
    if (!(spacing[i] > 0)) spacing[i] = 1;
  Result<Frame> frame = phantom_frame(low, high, size, spacing, options.shear_degrees);
  if (!frame) return frame.error();
  Result<Volume> output = volume::make_volume(size, frame.value(), is_anatomy);
  if (!output) return output;
  Volume& result = output.value();
  result.is_hounsfield = true;

  std::vector<float> values(result.voxels.size());
  const double voxel_mm = std::max({spacing.x, spacing.y, spacing.z});
  if (is_head) {
    const HeadAnatomy anatomy = head_anatomy(options.seed, *approach);
    for (const char* tissue : k_head_tissue_names) result.label_names.emplace_back(tissue);
    const double step_mm = glm::length(result.frame.axes()[0]);
    parallel_for(size.z, options.threads, [&](int z) {
      for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x;) {
          const HeadSample s = sample_head(result.frame.world_from_volume(dvec3(x, y, z)), voxel_mm, anatomy);
          // The next voxels of the row, up to the skin, are open air, too.
          const int run = 1 + static_cast<int>(s.clear_mm / (k_head_steepness * step_mm));
          for (const int end = std::min(x + run, size.x); x < end; ++x) {
            const std::size_t i = result.index(x, y, z);
            values[i] = static_cast<float>(s.hounsfield);
            result.labels[i] = static_cast<std::uint8_t>(s.tissue);
          }
        }
    });
  } else if (is_anatomy) {
    const SpinePhantom spine(options.seed);
    for (const char* tissue : k_spine_tissue_names) result.label_names.emplace_back(tissue);
    parallel_for(size.z, options.threads, [&](int z) {
      for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x) {
          const auto s = spine.sample(result.frame.world_from_volume(dvec3(x, y, z)), voxel_mm);
          const std::size_t i = result.index(x, y, z);
          values[i] = static_cast<float>(s.hounsfield);
          result.labels[i] = static_cast<std::uint8_t>(s.tissue);
        }
    });
  } else {
    fill_coverage(AnalyticShape(name, options.parameters), result, values, options.threads);
  }

  const double sigma =
      options.psf_sigma_voxels > 0 || options.is_psf_given || !is_anatomy ? options.psf_sigma_voxels : 1.0;
  volume::gaussian_blur(values, size, dvec3(sigma), options.threads);

  // Noise and rounding; HU are clamped to the range of 12-bit scanners.
  const double noise = parameter(name, options.parameters, "noise");
  parallel_for(size.z, options.threads, [&](int z) {
    const std::size_t begin = result.index(0, 0, z),
                      end = begin + static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y);
    for (std::size_t i = begin; i < end; ++i) {
      double hu = is_anatomy ? static_cast<double>(values[i])
                             : k_air + (k_solid - k_air) * static_cast<double>(values[i]);
      if (noise > 0) {
        const double uniform =
            static_cast<double>(hash_bits(hash_bits(options.seed) ^ i) >> 11) * 0x1p-52 - 1;
        hu += noise * (is_anatomy ? hash_normal(options.seed, i) : uniform);
      }
      result.voxels[i] = static_cast<std::int16_t>(std::floor(std::clamp(hu, -1024.0, 3071.0) + 0.5));
    }
  });
  return output;
}

}  // namespace trephine::data_tools
