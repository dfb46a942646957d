#include "modules/fluoroscopy/c_arm.h"

#include <cmath>
#include <cstdio>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

#include "volume/base/deterministic_math.h"

namespace trephine::fluoroscopy {

using glm::dvec2;
using glm::dvec3;
using sim::field;

const sim::Schema& CArm::schema() {
  static constexpr sim::Field fields[] = {
      field<&CArm::primary>("primary",
                            {.unit = "degrees",
                             .low = -180,
                             .high = 180,
                             .help = "0: detector in front of the patient; + toward the left (LAO)",
                             .label = "LAO (+) or RAO (-)"}),
      field<&CArm::secondary>("secondary", {.unit = "degrees",
                                            .low = -90,
                                            .high = 90,
                                            .help = "+ with the detector toward the head (cranial)",
                                            .label = "Cranial (+) or caudal (-)"}),
      field<&CArm::to_detector>("to_detector", {.unit = "mm",
                                                .low = 100,
                                                .high = 5000,
                                                .help = "distance from source to detector",
                                                .label = "Source to detector",
                                                .is_expert = true}),
      field<&CArm::to_patient>("to_patient", {.unit = "mm",
                                              .low = 50,
                                              .high = 5000,
                                              .help = "distance from source to isocentre",
                                              .label = "Source to patient",
                                              .is_expert = true}),
      field<&CArm::isocentre>("isocentre",
                              {.unit = "mm", .help = "world frame", .label = "Centre", .is_expert = true}),
      field<&CArm::pixel>("pixel", {.unit = "mm",
                                    .low = 0.01,
                                    .high = 20,
                                    .help = "pixel size of the detector",
                                    .label = "Pixel",
                                    .is_expert = true}),
      field<&CArm::columns>("columns", {.low = 1, .high = 8192, .label = "Columns", .is_expert = true}),
      field<&CArm::rows>("rows", {.low = 1, .high = 8192, .label = "Rows", .is_expert = true}),
      field<&CArm::width>("width", {.unit = "mm",
                                    .low = 0,
                                    .high = 10000,
                                    .help = "open width of the detector; 0: all",
                                    .label = "Open width",
                                    .is_expert = true}),
      field<&CArm::height>("height", {.unit = "mm",
                                      .low = 0,
                                      .high = 10000,
                                      .help = "open height of the detector; 0: all",
                                      .label = "Open height",
                                      .is_expert = true})};
  static constexpr sim::Schema table{"c-arm", 1, fields};
  return table;
}

namespace {

struct PresetAngles {
  double primary, secondary;  // degrees
};
// In the order of k_presets. Inlet and outlet of a pelvis: 40 degrees (Pennal et al. 1980).
constexpr PresetAngles k_preset_angles[] = {{0, 0}, {90, 0}, {45, 0}, {-45, 0}, {0, 40}, {0, -40}};

}  // namespace

bool set_preset(CArm& arm, std::string_view name) noexcept {
  for (std::size_t i = 0; i < std::size(k_preset_angles); ++i)
    if (name == k_presets[i]) {
      arm.primary = k_preset_angles[i].primary, arm.secondary = k_preset_angles[i].secondary;
      return true;
    }
  return false;
}

int preset_of(const CArm& arm) noexcept {
  for (std::size_t i = 0; i < std::size(k_preset_angles); ++i)
    if (arm.primary == k_preset_angles[i].primary && arm.secondary == k_preset_angles[i].secondary)
      return static_cast<int>(i);
  return -1;
}

Status check(const CArm& arm) {
  if (Status error = sim::check_fields(CArm::schema(), &arm)) return error;
  const auto mm = [](double v) {
    char text[40];
    std::snprintf(text, sizeof text, "%.1f mm", v);
    return std::string(text);
  };
  if (arm.to_patient >= arm.to_detector)
    return Error{.what = "the patient is outside the space between source and detector",
                 .where = "c-arm to_patient",
                 .found = mm(arm.to_patient),
                 .expected = "less than to_detector (" + mm(arm.to_detector) + ")"};
  if (arm.columns * arm.rows > (std::int64_t{1} << 26))
    return Error{.what = "the image is too large",
                 .where = "c-arm columns, rows",
                 .found = std::to_string(arm.columns) + " x " + std::to_string(arm.rows),
                 .expected = "at most 67 million pixels"};
  if (View(arm).open.is_empty())
    return Error{.what = "the collimators are closed",
                 .where = "c-arm width, height",
                 .found = mm(arm.width) + ", " + mm(arm.height),
                 .expected = "at least one pixel of " + mm(arm.pixel)};
  return std::nullopt;
}

View::View(const CArm& arm) : columns(static_cast<int>(arm.columns)), rows(static_cast<int>(arm.rows)) {
  const double p = glm::radians(arm.primary), s = glm::radians(arm.secondary);
  // World is LPS: left +x, back +y, head +z.
  const dvec3 outward(deterministic_sin(p) * deterministic_cos(s),
                      -deterministic_cos(p) * deterministic_cos(s), deterministic_sin(s));
  const dvec3 to_right(deterministic_cos(p), deterministic_sin(p), 0);
  const dvec3 up(-deterministic_sin(p) * deterministic_sin(s), deterministic_cos(p) * deterministic_sin(s),
                 deterministic_cos(s));
  source = arm.isocentre - arm.to_patient * outward;
  right = arm.pixel * to_right, down = -arm.pixel * up;
  const double i = 0.5 * (columns - 1), j = 0.5 * (rows - 1);
  corner = source + arm.to_detector * outward - i * right - j * down;
  const auto set_open_range = [&](double mm, int count, int& low, int& high) {
    const double half = mm > 0 ? std::min(0.5 * mm / arm.pixel, 0.5 * count) : 0.5 * count;
    // Pixels with an open centre.
    low = std::max(0, static_cast<int>(std::ceil(0.5 * (count - 1) - half)));
    high = std::min(count, static_cast<int>(std::floor(0.5 * (count - 1) + half)) + 1);
  };
  set_open_range(arm.width, columns, open.column_low, open.column_high);
  set_open_range(arm.height, rows, open.row_low, open.row_high);
}

std::optional<dvec2> View::project(const dvec3& p_world) const noexcept {
  const dvec3 axis = glm::cross(right, down), to_plane = corner - source, to_point = p_world - source;
  const double depth = glm::dot(to_point, axis) / glm::dot(to_plane, axis);
  if (!(depth > 0)) return std::nullopt;
  const dvec3 on_plane = source + to_point / depth - corner;
  return dvec2(glm::dot(on_plane, right) / glm::dot(right, right),
               glm::dot(on_plane, down) / glm::dot(down, down));
}

View View::refined(int times) const noexcept {
  View fine = *this;
  fine.right = right / static_cast<double>(times), fine.down = down / static_cast<double>(times);
  fine.corner = corner - 0.5 * (times - 1) * (fine.right + fine.down);
  fine.columns = times * columns, fine.rows = times * rows;
  fine.open = {times * open.column_low, times * open.row_low, times * open.column_high,
               times * open.row_high};
  return fine;
}

volume::RayFan View::ray_fan_in(const volume::Frame& frame) const noexcept {
  volume::RayFan fan;
  fan.source = frame.volume_from_world(source), fan.corner = frame.volume_from_world(corner);
  fan.right = frame.vector_volume_from_world(right), fan.down = frame.vector_volume_from_world(down);
  fan.columns = columns, fan.rows = rows;
  return fan;
}

}  // namespace trephine::fluoroscopy
