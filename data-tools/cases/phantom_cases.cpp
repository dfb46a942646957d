#include "data-tools/cases/phantom_cases.h"

#include <glm/geometric.hpp>
#include <sstream>

#include "data-tools/phantoms/head_phantom.h"
#include "data-tools/phantoms/spine_phantom.h"

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

/// Points of a head, found on its surfaces; world frame, mm.
class HeadPoints {
 public:
  explicit HeadPoints(const HeadAnatomy& anatomy) : anatomy_(anatomy) {}

  /// Returns the point of the vault's outer surface in a direction from the centre of the head.
  dvec3 on_vault(const dvec3& direction) const {
    double low = 0, high = 150;
    while (high - low > 1e-3) {
      const double middle = 0.5 * (low + high);
      (vault_distance(middle * direction, anatomy_) < 0 ? low : high) = middle;
    }
    return low * direction;
  }
  /// Returns the first bone, or the skin, on a line toward the head. `from`: in a head of reference size.
  dvec3 first_point(const dvec3& from, const dvec3& along, bool is_bone) const {
    constexpr double k_step = 0.05, k_fine = 0.05, k_reach = 120;  // mm
    for (double t = 0; t < k_reach; t += k_step) {
      const dvec3 p = (from + t * along) * anatomy_.size;
      const HeadTissue tissue = sample_head(p, k_fine, anatomy_).tissue;
      if (is_bone ? tissue == HeadTissue::cortical_bone : tissue != HeadTissue::air) return p;
    }
    return from * anatomy_.size;
  }
  dvec3 nasion() const { return first_point({0, -110, -26}, {0, 1, 0}, true); }
  dvec3 glabella() const { return on_vault(glm::normalize(dvec3(0, -1, -0.12))); }
  dvec3 inion() const { return on_vault(glm::normalize(dvec3(0, 1, -0.2))); }
  dvec3 tragus(double side) const { return first_point({side * 100, -1, -42}, {-side, 0, 0}, false); }
  dvec3 foramen_of_monro(double side) const { return dvec3(side, 1, 1) * k_foramen_of_monro * anatomy_.size; }
  /// Returns Kocher's point: 11 cm behind the nasion along the midline, 3 cm to a side.
  dvec3 kochers_point(double side) const {
    constexpr double k_behind = 110, k_aside = 30, k_turn = 0.001;  // mm, mm, radians
    const dvec3 start = nasion();
    dvec3 direction = glm::normalize(start), previous = start;
    const auto walk = [&](double length, const auto& toward) {
      for (double gone = 0; gone < length;) {
        direction = glm::normalize(direction + k_turn * toward());
        const dvec3 next = on_vault(direction);
        gone += glm::distance(previous, next);
        previous = next;
      }
    };
    walk(k_behind, [&] { return dvec3(0, direction.z, -direction.y); });
    walk(k_aside, [&] { return dvec3(side, 0, 0); });
    return previous;
  }

 private:
  const HeadAnatomy& anatomy_;
};

CasePlan head_plan(std::uint64_t seed) {
  CasePlan plan = basic_plan("head", k_head_tissue_names);
  plan.structures.push_back(window_structure("bone", 300));
  for (const HeadTissue tissue : {HeadTissue::dura, HeadTissue::brain, HeadTissue::venous_sinus}) {
    const int label = static_cast<int>(tissue);
    plan.structures.push_back(label_structure(k_head_tissue_names[label], label, true));
  }
  const int tumour = static_cast<int>(HeadTissue::tumour);
  plan.structures.push_back(label_structure(k_head_tissue_names[tumour], tumour, false));
  // Burr hole over the tumour on the shortest path: through the bone, to the dura.
  const HeadAnatomy anatomy = head_anatomy(seed);
  const dvec3 middle = anatomy.tumour * anatomy.size,
              outward = glm::normalize(anatomy.tumour - dvec3(0, -5, 0));
  double outside = 0, beyond = 100;
  while (beyond - outside > 1e-3) {
    const double between = 0.5 * (outside + beyond);
    (vault_distance(middle + between * outward, anatomy) < 0 ? outside : beyond) = between;
  }
  double inside = outside;
  constexpr double k_step = 0.05, k_fine = 0.05;  // mm
  while (inside > 0 && sample_head(middle + inside * outward, k_fine, anatomy).tissue != HeadTissue::dura)
    inside -= k_step;
  constexpr double k_margin = 0.5, k_burr_hole = 14;  // mm
  plan.trajectories.push_back({"burr hole over the tumour", middle + outside * outward,
                               middle + (inside + k_margin) * outward, k_burr_hole});
  plan.targets.push_back({"tumour", k_head_tissue_names[tumour]});
  const HeadPoints points(anatomy);
  plan.landmarks.push_back({"vertex", points.on_vault({0, 0, 1})});
  plan.landmarks.push_back({"inion", points.inion()});
  plan.landmarks.push_back({"nasion", points.nasion()});
  plan.landmarks.push_back({"glabella", points.glabella()});
  for (const double side : {1.0, -1.0}) {
    const std::string name = side > 0 ? "left" : "right";
    constexpr double k_catheter = 3;  // mm
    const dvec3 entry = points.kochers_point(side), target = points.foramen_of_monro(side);
    plan.landmarks.push_back({name + " tragus", points.tragus(side)});
    plan.landmarks.push_back({name + " Kocher's point", entry});
    plan.landmarks.push_back({name + " foramen of Monro", target});
    plan.trajectories.push_back(
        {name + " ventriculostomy", entry, target, k_catheter, "ventriculostomy", name, {}});
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
    plan.structures.push_back(
        label_structure(k_spine_tissue_names[label], label, label >= static_cast<int>(SpineTissue::cord)));
  for (const SpineScrew& screw : SpinePhantom(seed).screws()) plan.trajectories.push_back(planned(screw));
  return plan;
}

}  // namespace

std::optional<CasePlan> phantom_plan(const std::string& name, std::uint64_t seed) {
  if (name != "head" && name != "spine") return std::nullopt;
  CasePlan plan = name == "head" ? head_plan(seed) : spine_plan(seed);
  if (seed != 1) plan.name.append("-").append(std::to_string(seed));  // other anatomies have other names
  return plan;
}

}  // namespace trephine::data_tools
