#include "apps/workbench/force_text.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "apps/workbench/text.h"

namespace trephine::workbench {

using glm::dvec3;

std::vector<std::string> force_sentences(const haptics::ForceParts& parts, const haptics::TouchScene& scene) {
  const haptics::ServoRecord& record = parts.record;
  std::vector<std::string> lines;
  if (record.is_escaping) {
    lines.emplace_back("The tool is led out of restored matter, with at most 3 N.");
  } else if (!record.has_contact) {
    lines.emplace_back(record.is_buried ? "The tool is inside matter and touches no surface."
                                        : "The tool touches nothing.");
  } else {
    const std::string name = record.shape >= 0 && record.shape < haptics::item_count(scene)
                                 ? words_of(haptics::name_of(haptics::item_of(scene, record.shape)))
                                 : "an object";
    const double stretch = glm::distance(parts.step.proxy_world, record.pose.position_world);
    lines.push_back(
        format_text("The tool touches %s. The hand is %.2f mm beyond the surface. The stiffness is "
                    "%.2f N/mm: the spring force is %.2f N.",
                    name.c_str(), stretch, parts.stiffness, stretch * parts.stiffness));
    const double limit_at_rest = parts.material.static_friction, limit = parts.material.dynamic_friction;
    if (limit_at_rest > 0 || limit > 0)
      lines.push_back(format_text(
          "Friction: the tangential force is %.2f times the normal force. The static coefficient, "
          "above which the tool slips, is %.2f. The dynamic coefficient is %.2f.",
          parts.friction_ratio(), limit_at_rest, limit));
    else
      lines.emplace_back("The surface has no friction.");
  }
  if (record.faults != 0) lines.push_back("Limits and faults: " + haptics::fault_names(record.faults) + ".");
  return lines;
}

sim::Overlay force_lines(const haptics::ForceParts& parts, const haptics::TouchScene& scene) {
  constexpr double k_mm_per_n = 6, k_normal = 8, k_cone = 6;  // mm
  const haptics::ServoRecord& record = parts.record;
  sim::Overlay overlay;
  overlay.kind = sim::Overlay::Kind::measure;
  overlay.is_in_front = true;
  const dvec3 &hand = record.pose.position_world, &proxy = record.proxy_world;
  const auto add = [&](const dvec3& from, const dvec3& to) { overlay.lines.push_back({from, to}); };
  if (glm::distance(hand, proxy) > 0.05) {
    add(hand, proxy);
    overlay.labels.push_back({hand, "hand"});
  }
  for (int i = 1; i < parts.step.waypoint_count; ++i)
    add(scene.base->frame.world_from_volume(parts.step.path_volume[static_cast<std::size_t>(i - 1)]),
        scene.base->frame.world_from_volume(parts.step.path_volume[static_cast<std::size_t>(i)]));
  if (const double newtons = glm::length(record.force_world); newtons > 0.005) {
    const dvec3 end = proxy + k_mm_per_n * record.force_world;
    add(proxy, end);
    overlay.labels.push_back({end, format_text("%.2f N", newtons)});
  }
  if (!record.has_contact) return overlay;
  const dvec3& n = record.normal_world;
  add(proxy, proxy + k_normal * n);
  overlay.labels.push_back({proxy + k_normal * n, "normal"});
  const double slope = std::max(parts.material.static_friction, parts.material.dynamic_friction);
  if (!(slope > 0)) return overlay;
  const dvec3 right = glm::normalize(glm::cross(n, std::abs(n.z) < 0.9 ? dvec3(0, 0, 1) : dvec3(0, 1, 0)));
  const dvec3 up = glm::cross(n, right);
  constexpr int k_segments = 24;
  const auto rim = [&](int i) {
    const double angle = 2 * 3.14159265358979 * i / k_segments;
    return proxy + k_cone * (n + slope * (std::cos(angle) * right + std::sin(angle) * up));
  };
  for (int i = 0; i < k_segments; ++i) {
    add(rim(i), rim(i + 1));
    if (i % 6 == 0) add(proxy, rim(i));
  }
  return overlay;
}

}  // namespace trephine::workbench
