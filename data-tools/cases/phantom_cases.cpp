#include "data-tools/cases/phantom_cases.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <sstream>

#include "data-tools/phantoms/head_landmarks.h"
#include "data-tools/phantoms/spine_phantom.h"
#include "volume/base/deterministic_math.h"

namespace trephine::data_tools {

using glm::dvec3;

namespace {

CaseStructure window_structure(const char* name, double low) {
  CaseStructure s;
  s.shape.name = name;
  s.shape.low = low;
  return s;
}
CaseStructure label_structure(const char* name, int label, bool is_forbidden) {
  CaseStructure s;
  s.shape.name = name;
  s.shape.label = label;
  s.is_touchable = false;
  s.is_forbidden = is_forbidden;
  return s;
}

template <std::size_t N>
CasePlan basic_plan(const std::string& name, const char* const (&labels)[N]) {
  CasePlan plan;
  plan.name = name;
  plan.modality = "CT";
  plan.is_hounsfield = true;
  for (const char* label : labels) plan.label_names.emplace_back(label);
  return plan;
}

/// Returns points on the outer surface of the vault at `radius` from an axis. The axis starts at `middle` and
/// leaves the vault after `distance`.
std::vector<dvec3> outline_around(const dvec3& middle, const dvec3& axis, double distance, double radius,
                                  const HeadAnatomy& anatomy) {
  constexpr int k_points = 24;
  const dvec3 u = glm::normalize(glm::cross(axis, dvec3(0, 0, 1))), v = glm::cross(axis, u);
  std::vector<dvec3> points;
  for (int i = 0; i < k_points; ++i) {
    const double angle = 2 * 3.14159265358979323846 * i / k_points;
    const dvec3 aside = middle + radius * (deterministic_cos(angle) * u + deterministic_sin(angle) * v);
    points.push_back(aside + distance_to_vault(aside, axis, distance + radius, anatomy) * axis);
  }
  return points;
}

CasePlan head_plan(std::uint64_t seed, HeadApproach approach) {
  CasePlan plan = basic_plan("head", k_head_tissue_names);
  plan.structures.push_back(window_structure("bone", 300));
  for (const HeadTissue tissue : {HeadTissue::dura, HeadTissue::brain, HeadTissue::venous_sinus}) {
    const int label = static_cast<int>(tissue);
    plan.structures.push_back(label_structure(k_head_tissue_names[label], label, true));
  }
  const int tumour = static_cast<int>(HeadTissue::tumour);
  plan.structures.push_back(label_structure(k_head_tissue_names[tumour], tumour, false));
  // Burr hole over the tumour on the shortest path: through the bone, to the dura.
  const HeadAnatomy anatomy = head_anatomy(seed, approach);
  const dvec3 middle = anatomy.tumour * anatomy.size,
              outward = glm::normalize(anatomy.tumour - k_head_middle);
  const double outside = distance_to_vault(middle, outward, 100, anatomy);
  double inside = outside;
  constexpr double k_step = 0.05, k_fine = 0.05;  // mm
  while (inside > 0 && sample_head(middle + inside * outward, k_fine, anatomy).tissue != HeadTissue::dura)
    inside -= k_step;
  constexpr double k_margin = 0.5, k_burr_hole = 14;  // mm
  plan.trajectories.push_back({"burr hole over the tumour", middle + outside * outward,
                               middle + (inside + k_margin) * outward, k_burr_hole});
  plan.outlines.push_back(
      {"craniotomy",
       outline_around(middle, outward, outside, anatomy.tumour_radius + anatomy.opening_margin, anatomy)});
  plan.targets.push_back({"tumour", k_head_tissue_names[tumour]});
  const HeadLandmarks landmarks = head_landmarks(anatomy);
  plan.landmarks.push_back({"vertex", landmarks.vertex});
  plan.landmarks.push_back({"inion", landmarks.inion});
  plan.landmarks.push_back({"nasion", landmarks.nasion});
  plan.landmarks.push_back({"glabella", landmarks.glabella});
  for (const std::string side : {"left", "right"}) {
    constexpr double k_catheter = 3;  // mm
    const HeadLandmarks::Side& points = side == "left" ? landmarks.left : landmarks.right;
    plan.landmarks.push_back({side + " tragus", points.tragus});
    plan.landmarks.push_back({side + " Kocher's point", points.kochers_point});
    plan.landmarks.push_back({side + " foramen of Monro", points.foramen_of_monro});
    plan.trajectories.push_back({side + " ventriculostomy",
                                 points.kochers_point,
                                 points.foramen_of_monro,
                                 k_catheter,
                                 "ventriculostomy",
                                 side,
                                 {}});
  }
  return plan;
}

/// Returns a screw as a trajectory. Its name consists of vertebra, side and group: "L3 left pedicle".
volume::PlannedTrajectory planned(const SpineScrew& screw) {
  std::istringstream words(screw.name);
  std::string vertebra, side, group;
  words >> vertebra >> side >> group;
  return {screw.name, screw.entry_world, screw.target_world, screw.diameter, group, side, vertebra};
}

CasePlan spine_plan(std::uint64_t seed) {
  CasePlan plan = basic_plan("spine", k_spine_tissue_names);
  plan.structures.push_back(window_structure("bone", 140));
  for (int label = 1; label <= static_cast<int>(SpineTissue::vessel); ++label)
    plan.structures.push_back(label_structure(k_spine_tissue_names[label], label,
                                              label >= static_cast<int>(SpineTissue::dural_sac)));
  for (const SpineScrew& screw : SpinePhantom(seed).screws()) plan.trajectories.push_back(planned(screw));
  return plan;
}

/// Returns the surface of a part of the spine.
CaseSurface surface_of(const SpinePhantom& spine, const SpinePart& part, const std::string& file) {
  constexpr double k_step = 0.5, k_unit = 1e-3;  // mm, of the grid and of its values
  constexpr double k_most = 30;                  // mm
  const volume::Frame frame = volume::Frame::from_spacing(part.low_world, dvec3(k_step)).value();
  volume::Volume grid =
      volume::make_volume(glm::ivec3(glm::ceil((part.high_world - part.low_world) / k_step)) + 1, frame)
          .value();
  std::size_t i = 0;
  for (int z = 0; z < grid.size.z; ++z)
    for (int y = 0; y < grid.size.y; ++y)
      for (int x = 0; x < grid.size.x; ++x, ++i) {
        const double inward = -spine.part_distance(part, frame.world_from_volume(dvec3(x, y, z)));
        grid.voxels[i] =
            static_cast<std::int16_t>(std::floor(std::clamp(inward, -k_most, k_most) / k_unit + 0.5));
      }
  volume::Shape inside;
  inside.low = 0;
  const volume::Field field(grid, inside);
  return {file, volume::surface_net({&field}), frame};
}

/// Replaces the label structures of the spine's soft parts by models.
void add_spine_models(PhantomCase& spine_case, std::uint64_t seed) {
  CasePlan& plan = spine_case.plan;
  std::erase_if(plan.structures, [](const CaseStructure& s) {
    const auto tissue = static_cast<SpineTissue>(s.shape.label);
    return tissue == SpineTissue::disc || tissue == SpineTissue::dural_sac ||
           tissue == SpineTissue::nerve_root;
  });
  const SpinePhantom spine(seed);
  for (const SpinePart& part : spine.parts()) {
    CaseModel& model = plan.models.emplace_back();
    model.name = part.name, model.file = part.name + ".ply";
    std::replace(model.file.begin(), model.file.end(), ' ', '-');
    model.matter = volume::Matter::soft_tissue;
    model.is_touchable = false;
    model.is_forbidden = part.tissue != SpineTissue::disc;
    spine_case.surfaces.push_back(surface_of(spine, part, model.file));
  }
}

}  // namespace

std::optional<CasePlan> phantom_plan(const std::string& name, std::uint64_t seed,
                                     const std::string& approach) {
  if (name != "head" && name != "spine") return std::nullopt;
  const HeadApproach from = head_approach(approach).value_or(HeadApproach::vault);
  CasePlan plan = name == "head" ? head_plan(seed, from) : spine_plan(seed);
  if (from != HeadApproach::vault) plan.name.append("-").append(approach);
  if (seed != 1) plan.name.append("-").append(std::to_string(seed));  // other anatomies have other names
  return plan;
}

std::optional<PhantomCase> phantom_case(const std::string& name, std::uint64_t seed,
                                        const std::string& approach) {
  std::optional<CasePlan> plan = phantom_plan(name, seed, approach);
  if (!plan) return std::nullopt;
  PhantomCase result{std::move(*plan), {}};
  if (name == "spine") add_spine_models(result, seed);
  return result;
}

}  // namespace trephine::data_tools
