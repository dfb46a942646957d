#include "modules/measurement/measurement.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <glm/geometric.hpp>
#include <numeric>

#include "haptics/mesh/surface_line.h"
#include "modules/measurement/marked.h"
#include "sim/api/work.h"
#include "volume/base/deterministic_math.h"
#include "volume/surface/surface_nets.h"

namespace trephine::measurement {

using glm::dvec3;
using sim::field;

namespace {

constexpr double k_farthest = 25;  // mm, largest distance from a requested position to the surface

/// Returns the angle between two vectors, degrees, by bisection: independent of a library's arc cosine.
double angle_between(const dvec3& a, const dvec3& b) noexcept {
  const double size = glm::length(a) * glm::length(b);
  if (!(size > 0)) return 0;
  const double cosine = glm::dot(a, b) / size;
  double low = 0, high = 180;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (deterministic_cos(middle * 3.14159265358979323846 / 180) > cosine ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

/// Returns the shape's surface within `reach` mm of the positions' bounding box, world frame.
haptics::Surface surface_near(const volume::Field& shape, const volume::Version& version,
                              std::span<const dvec3> positions, double reach) {
  const volume::Volume& scan = shape.volume();
  dvec3 low = positions[0], high = positions[0];
  for (const dvec3& p : positions) low = glm::min(low, p), high = glm::max(high, p);
  low -= reach, high += reach;
  const volume::Mesh net = volume::surface_net({&shape, &version});
  std::vector<dvec3> vertices;
  constexpr std::uint32_t k_unused = 0xffffffffu;
  std::vector<std::uint32_t> new_index(net.vertices.size(), k_unused), triangles;
  for (std::size_t t = 0; t + 2 < net.triangles.size(); t += 3) {
    std::array<dvec3, 3> corner;
    bool is_near = true;
    for (std::size_t k = 0; k < 3; ++k) {
      corner[k] = scan.frame.world_from_volume(dvec3(net.vertices[net.triangles[t + k]]));
      is_near = is_near && glm::all(glm::greaterThanEqual(corner[k], low)) &&
                glm::all(glm::lessThanEqual(corner[k], high));
    }
    if (!is_near) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      std::uint32_t& n = new_index[net.triangles[t + k]];
      if (n == k_unused) n = static_cast<std::uint32_t>(vertices.size()), vertices.push_back(corner[k]);
      triangles.push_back(n);
    }
  }
  return {std::move(vertices), std::move(triangles)};
}

/// Returns the depth of a position below the surface of the remaining shape, to first order and at most 1 mm,
/// with the direction out of the shape.
haptics::Inside inside(const volume::Field& shape, const volume::Version& version,
                       const dvec3& position_world) {
  const volume::Frame& frame = shape.volume().frame;
  const dvec3 p = frame.volume_from_world(position_world);
  const dvec3 gradient = frame.gradient_world_from_volume(shape.gradient(p));
  const double steepness = glm::length(gradient), g = shape.value(p);
  if (!(g > 0) || !(steepness > 0)) return {};
  haptics::Inside result{std::min(g / steepness, 1.0), -gradient / steepness};
  if (version.is_uncut()) return result;
  const double d = version.distance(p);
  if (d <= 0) return {};
  const dvec3 away = frame.gradient_world_from_volume(version.distance_gradient(p));
  if (d < result.depth && glm::length(away) > 0) result = {d, -away / glm::length(away)};
  return result;
}

/// Reduces a line to at most 400 points, enough for display.
void thin_out(std::vector<dvec3>& line) {
  constexpr std::size_t k_max = 400;
  if (line.size() <= k_max) return;
  std::vector<dvec3> fewer;
  for (std::size_t i = 0; i < k_max; ++i) fewer.push_back(line[i * (line.size() - 1) / (k_max - 1)]);
  line = std::move(fewer);
}

/// A surface, and the points on it that a line along the surface connects.
struct LineOnSurface {
  haptics::Surface surface;
  std::vector<haptics::Surface::Point> places;
};
/// Finds the line along the shape's surface through the requested positions. Sets `line` and `moved` of
/// `output`. If there is no such line, returns nullopt and sets `problem` of `output`.
std::optional<LineOnSurface> lay_line(const Measure& request, const volume::Field& shape,
                                      const volume::Version& version, bool is_closed, Measured& output) {
  double farthest = 0;
  for (const dvec3& p : request.at) farthest = std::max(farthest, glm::length(p - request.at[0]));
  // Searches the surface near the positions first, then all of it.
  for (const double reach : {0.6 * farthest + 20, 1e6}) {
    haptics::Surface surface = surface_near(shape, version, request.at, reach);
    output.line.clear();
    auto places = surface.nearest_on_one_part(request.at);
    output.moved = 0;
    for (std::size_t i = 0; i < places.size(); ++i)
      output.moved = std::max(output.moved, glm::length(places[i].at - request.at[i]));
    for (std::size_t i = 1; i < places.size() + is_closed; ++i) {
      const std::vector<dvec3> part =
          haptics::surface_line(surface, places[i - 1], places[i % places.size()]);
      if (part.empty()) {
        output.line.clear();
        break;
      }
      output.line.insert(output.line.end(), part.begin() + (output.line.empty() ? 0 : 1), part.end());
    }
    if (output.line.empty()) continue;
    if (output.moved <= k_farthest) return LineOnSurface{std::move(surface), std::move(places)};
    char text[80];
    std::snprintf(text, sizeof text, "a position is %.1f mm from the surface, more than %.0f mm",
                  output.moved, k_farthest);
    output.problem = text;
    output.line = request.at;
    return std::nullopt;
  }
  output.problem = "the positions are on separate surfaces";
  return std::nullopt;
}

void measure_patch(const Measure& request, const volume::Field& shape, const volume::Version& version,
                   Measured& output) {
  const auto line = lay_line(request, shape, version, true, output);
  if (!line) return;
  output.length = haptics::length_of(output.line);
  const auto area = area_within(line->surface, line->places, output.line);
  thin_out(output.line);
  if (area)
    output.area = *area;
  else
    output.problem = "the surface is too curved within the outline: measure it in smaller parts";
}

void measure_part(const Measure& request, const volume::Field& shape, const volume::Version& version,
                  Measured& output) {
  const haptics::Surface surface = surface_near(shape, version, request.at, request.radius + 5);
  haptics::Surface::Point place;
  if (!surface.nearest(request.at[0], place) || glm::length(place.at - request.at[0]) > request.radius) {
    output.problem = "the shape has no surface within the radius";
    return;
  }
  const MarkedPart part = part_of(surface, place.triangle, request.at[0]);
  if (part.farthest > request.radius) {
    output.problem = "the part is larger than the radius: increase the radius";
    return;
  }
  output.area = part.area, output.size = std::abs(part.volume);
}

void measure_tape(const Measure& request, const volume::Field& shape, const volume::Version& version,
                  Measured& output) {
  if (!lay_line(request, shape, version, false, output)) return;
  output.length = haptics::length_of(output.line);
  output.straight = glm::length(output.line.back() - output.line.front());
  output.taut = haptics::length_of(
      haptics::taut_line(output.line, [&](const dvec3& p) { return inside(shape, version, p); }));
  thin_out(output.line);
}

void measure_region(const Measure& request, const volume::Volume& scan, Measured& output) {
  const dvec3 middle = scan.frame.volume_from_world(request.at[0]);
  glm::ivec3 low, high;
  for (int a = 0; a < 3; ++a) {
    // Number of voxels along this axis that the ball may reach, for any inclination of the axes.
    dvec3 unit(0.0);
    unit[a] = 1;
    const double reach = request.radius * glm::length(scan.frame.gradient_world_from_volume(unit));
    low[a] = std::max(0, static_cast<int>(std::floor(middle[a] - reach)));
    high[a] = std::min(scan.size[a] - 1, static_cast<int>(std::ceil(middle[a] + reach)));
  }
  double count = 0, sum = 0, square = 0;
  output.minimum = 1e300, output.maximum = -1e300;
  for (int z = low.z; z <= high.z; ++z)
    for (int y = low.y; y <= high.y; ++y)
      for (int x = low.x; x <= high.x; ++x) {
        const dvec3 offset = scan.frame.vector_world_from_volume(dvec3(x, y, z) - middle);
        if (glm::dot(offset, offset) > request.radius * request.radius) continue;
        const double v = scan.voxels[scan.index(x, y, z)];
        ++count, sum += v, square += v * v;
        output.minimum = std::min(output.minimum, v), output.maximum = std::max(output.maximum, v);
      }
  if (count == 0) {
    output.minimum = output.maximum = 0;
    output.problem = "the region contains no voxel centre: increase its radius";
    return;
  }
  output.mean = sum / count;
  output.deviation = std::sqrt(std::max(0.0, square / count - output.mean * output.mean));
  output.size = count * scan.frame.voxel_mm3();
}

/// Returns the number that is shown next to a measurement, in the unit of its kind.
double value_of(const Measured& measured) noexcept {
  switch (measured.kind) {
    case Kind::angle:
      return measured.angle;
    case Kind::region:
      return measured.mean;
    case Kind::patch:
      return measured.area;
    case Kind::part:
      return measured.size;
    case Kind::ruler:
    case Kind::tape:
      break;
  }
  return measured.length;
}

std::string words_of(Kind kind, double value) {
  constexpr const char* formats[] = {"%.1f mm",   "%.1f\u00b0",    "%.1f mm",
                                     "mean %.0f", "%.0f mm\u00b2", "%.0f mm\u00b3"};
  char text[40];
  std::snprintf(text, sizeof text, formats[static_cast<std::size_t>(kind)], value);
  return text;
}

struct Result final : sim::JobResult {
  Measured measured;
  std::uint64_t fingerprint = 0;
  std::uint64_t hash() const override { return fingerprint; }
  std::string_view failure() const noexcept override { return measured.problem; }
};

std::shared_ptr<const sim::JobResult> run(const void* parameters, const sim::JobInput& input) {
  const auto& request = *static_cast<const Measure*>(parameters);
  auto output = std::make_shared<Result>();
  output->measured = measure(request, input.anatomy.items[static_cast<std::size_t>(request.item)].field,
                             *input.state.undoable.version);
  MixHash mix;
  sim::add_value(mix, output->measured);
  output->fingerprint = mix.value();
  return output;
}

Status check(const void* parameters, const haptics::TouchScene& anatomy) {
  const auto& request = *static_cast<const Measure*>(parameters);
  if (request.item < 0 || static_cast<std::size_t>(request.item) >= anatomy.items.size() ||
      anatomy.items[static_cast<std::size_t>(request.item)].is_mesh())
    return Error{.what = "unknown shape",
                 .where = "measure item",
                 .found = std::to_string(request.item),
                 .expected = "a shape of the anatomy",
                 .remedy = "pass the number of a touchable shape, 0 for the first"};
  return std::nullopt;
}

void adopt(const void*, const sim::JobResult& result, sim::ModuleWork& work) {
  const auto& output = static_cast<const Result&>(result);
  auto& settings = work.change_result<MeasurementState>();
  static_cast<Measured&>(settings) = output.measured;
  if (output.measured.problem.empty()) {
    settings.kinds.push_back(static_cast<double>(output.measured.kind));
    settings.counts.push_back(static_cast<double>(output.measured.line.size()));
    settings.values.push_back(value_of(output.measured));
    settings.lines.insert(settings.lines.end(), output.measured.line.begin(), output.measured.line.end());
  }
  while (settings.kinds.size() > MeasurementState::k_shown) {
    settings.lines.erase(settings.lines.begin(),
                         settings.lines.begin() + static_cast<std::ptrdiff_t>(settings.counts[0]));
    for (std::vector<double>* list : {&settings.kinds, &settings.counts, &settings.values})
      list->erase(list->begin());
  }
  work.raise_event(output.measured, output.measured.line.empty() ? dvec3(0.0) : output.measured.line.front());
}

}  // namespace

std::string words_of(const Measured& measured) { return words_of(measured.kind, value_of(measured)); }

Measured measure(const Measure& request, const volume::Field& shape, const volume::Version& version) {
  Measured output;
  output.kind = request.kind, output.has_value = true;
  output.line = request.at;
  switch (request.kind) {
    case Kind::ruler:
      output.length = output.straight = glm::length(request.at[1] - request.at[0]);
      break;
    case Kind::angle:
      output.angle = angle_between(request.at[0] - request.at[1], request.at[2] - request.at[1]);
      break;
    case Kind::tape:
      measure_tape(request, shape, version, output);
      break;
    case Kind::region:
      measure_region(request, shape.volume(), output);
      break;
    case Kind::patch:
      measure_patch(request, shape, version, output);
      break;
    case Kind::part:
      measure_part(request, shape, version, output);
      break;
  }
  return output;
}

std::span<const sim::JobType* const> Measurement::jobs() const {
  static const sim::JobType job{&sim::value_type<Measure>(), run, nullptr, adopt, check};
  static const std::array<const sim::JobType*, 1> all{&job};
  return all;
}
std::span<const sim::ValueType* const> Measurement::commands() const {
  static const std::array all{&sim::value_type<ClearMeasures>()};
  return all;
}

void Measurement::apply(const sim::Command& command, sim::ModuleWork& work) const {
  if (command.request.as<ClearMeasures>() != nullptr)
    work.change_result<MeasurementState>() = MeasurementState{};
}

std::span<const sim::ValueType* const> Measurement::events() const {
  static const std::array all{&sim::value_type<Measured>()};
  return all;
}

Status Measurement::allows(const sim::Command& command, const sim::OperationState&) const {
  const auto* request = command.request.as<Measure>();
  if (request == nullptr) return std::nullopt;
  const std::size_t count = request->at.size();
  const bool is_valid = request->kind == Kind::ruler                                   ? count == 2
                        : request->kind == Kind::angle                                 ? count == 3
                        : request->kind == Kind::region || request->kind == Kind::part ? count == 1
                        : request->kind == Kind::patch ? count >= 3 && count <= 100
                                                       : count >= 2 && count <= 100;
  if (!is_valid)
    return Error{.what = "wrong number of positions",
                 .where = "measure at",
                 .found = std::to_string(count),
                 .expected =
                     "two for a ruler, three for an angle, one for a region or a part, 2 to 100 for a "
                     "tape, 3 to 100 for a patch"};
  if (request->kind == Kind::angle && count == 3 &&
      (request->at[0] == request->at[1] || request->at[2] == request->at[1]))
    return Error{.what = "the vertex of an angle equals one of its ends",
                 .where = "measure at",
                 .expected = "three different positions"};
  for (const dvec3& p : request->at)
    if (!(glm::dot(p, p) < 1e12))
      return Error{
          .what = "a position is out of range", .where = "measure at", .expected = "coordinates within 1 km"};
  return std::nullopt;
}

std::vector<sim::Measure> Measurement::measures(const sim::OperationState& operation) const {
  const auto* last = operation.result_of<MeasurementState>();
  if (last == nullptr) return {};
  const bool is_stale = operation.is_result_stale<MeasurementState>();
  return {{"measured length", last->length, "mm", is_stale},
          {"measured straight", last->straight, "mm", is_stale},
          {"measured taut", last->taut, "mm", is_stale},
          {"measured angle", last->angle, "degrees", is_stale},
          {"measured mean", last->mean, "", is_stale},
          {"measured deviation", last->deviation, "", is_stale},
          {"measured area", last->area, "mm2", is_stale},
          {"measured size", last->size, "mm3", is_stale}};
}

sim::Overlays Measurement::overlays(const sim::OperationState& operation) const {
  const auto* settings = operation.result_of<MeasurementState>();
  if (settings == nullptr || settings->kinds.empty()) return {};
  sim::Overlay overlay;
  overlay.kind = sim::Overlay::Kind::measure;
  overlay.is_in_front = true;  // bone would hide a straight line between two positions on its surface
  // Dashes of 2 mm and gaps of 1.5 mm, along each whole line.
  constexpr double k_dash = 2, k_period = 3.5;  // mm
  std::size_t first = 0;
  for (std::size_t m = 0; m < settings->kinds.size(); ++m) {
    const auto count = static_cast<std::size_t>(settings->counts[m]);
    double distance = 0;
    for (std::size_t i = first + 1; i < first + count; ++i) {
      const dvec3 &a = settings->lines[i - 1], &b = settings->lines[i];
      const double length = glm::length(b - a);
      for (double from = 0; from < length - 1e-9;) {
        const double phase = distance + from - k_period * std::floor((distance + from) / k_period);
        const double to =
            std::min(length, from + (phase < k_dash ? k_dash - phase : k_period - phase) + 1e-9);
        if (phase < k_dash) overlay.lines.push_back({a + from / length * (b - a), a + to / length * (b - a)});
        from = to;
      }
      distance += length;
    }
    first += count;
    if (count > 0)
      overlay.labels.push_back(
          {settings->lines[first - 1], words_of(static_cast<Kind>(settings->kinds[m]), settings->values[m])});
  }
  return {overlay};
}

const sim::Schema& Measure::schema() {
  static constexpr sim::Field fields[] = {
      field<&Measure::kind>("kind", {.choices = k_kinds}),
      field<&Measure::at>(
          "at", {.unit = "mm", .help = "positions in the world; the second of an angle is its vertex"}),
      field<&Measure::radius>(
          "radius", {.unit = "mm", .low = 0.1, .high = 200, .help = "radius of a region, reach of a part"}),
      field<&Measure::item>("item",
                            {.low = 0, .high = 255, .help = "shape that is measured", .is_expert = true})};
  static constexpr sim::Schema table{"measure", 1, fields};
  return table;
}

const sim::Schema& Measured::schema() {
  static constexpr sim::Field fields[] = {
      field<&Measured::kind>("kind", {.choices = k_kinds}),
      field<&Measured::has_value>("has_value"),
      field<&Measured::length>("length", {.unit = "mm", .help = "length; for a tape, along the surface"}),
      field<&Measured::straight>("straight", {.unit = "mm"}),
      field<&Measured::taut>("taut", {.unit = "mm", .help = "length of a tape pulled taut"}),
      field<&Measured::moved>("moved",
                              {.unit = "mm", .help = "largest distance of a position from the surface"}),
      field<&Measured::angle>("angle", {.unit = "degrees"}),
      field<&Measured::mean>("mean"),
      field<&Measured::deviation>("deviation"),
      field<&Measured::minimum>("least"),
      field<&Measured::maximum>("most"),
      field<&Measured::size>("size", {.unit = "mm3"}),
      field<&Measured::problem>("problem"),
      field<&Measured::line>("line", {.unit = "mm"}),
      field<&Measured::area>("area", {.unit = "mm2", .help = "area of a patch, or of a part's surface"})};
  static constexpr sim::Schema table{"measured", 1, fields};
  return table;
}

const sim::Schema& ClearMeasures::schema() {
  static constexpr sim::Schema table{"clear-measures", 1, {}};
  return table;
}

const sim::Schema& MeasurementState::schema() {
  static constexpr sim::Field own[] = {
      field<&MeasurementState::kinds>("kinds"), field<&MeasurementState::counts>("counts"),
      field<&MeasurementState::values>("values"), field<&MeasurementState::lines>("lines", {.unit = "mm"})};
  static const std::vector<sim::Field> fields = sim::joined(Measured::schema().fields, own);
  static const sim::Schema table{"measurement-state", 1, fields};
  return table;
}

}  // namespace trephine::measurement
