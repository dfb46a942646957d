#include "modules/measurement/measurement.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <numeric>

#include "haptics/mesh/surface_line.h"
#include "modules/measurement/marked.h"
#include "sim/work.h"
#include "volume/deterministic_math.h"
#include "volume/surface_nets.h"

namespace trephine::measurement {

using glm::dvec3;
using sim::field;

namespace {

constexpr double k_farthest = 25;  // mm, from where a tape's place is said to where it lies

/// degrees between two ways, by halving: no library's arc cosine.
double angle_between(const dvec3& a, const dvec3& b) noexcept {
  const double size = glm::length(a) * glm::length(b);
  if (!(size > 0)) return 0;
  const double cosine = glm::dot(a, b) / size;
  double low = 0, high = 180;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (volume::deterministic_cos(middle * 3.14159265358979323846 / 180) > cosine ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

/// The shape's surface around places, in the world.
haptics::Surface surface_near(const volume::Field& shape, const volume::Version& version,
                              std::span<const dvec3> places, double reach) {
  const volume::Volume& scan = shape.volume();
  dvec3 low = places[0], high = places[0];
  for (const dvec3& p : places) low = glm::min(low, p), high = glm::max(high, p);
  low -= reach, high += reach;
  const volume::Mesh net = volume::surface_net({&shape, &version});
  std::vector<dvec3> vertices;
  std::vector<std::uint32_t> number(net.vertices.size(), 0xffffffffu), triangles;
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
      std::uint32_t& n = number[net.triangles[t + k]];
      if (n == 0xffffffffu) n = static_cast<std::uint32_t>(vertices.size()), vertices.push_back(corner[k]);
      triangles.push_back(n);
    }
  }
  return {std::move(vertices), std::move(triangles)};
}

/// Depth of a place within what is left of a shape, to first order.
haptics::Inside inside(const volume::Field& shape, const volume::Version& version, const dvec3& world) {
  const volume::Frame& frame = shape.volume().frame;
  const dvec3 p = frame.volume_from_world(world);
  const dvec3 rise = frame.gradient_world_from_volume(shape.gradient(p));
  const double steepness = glm::length(rise), g = shape.value(p);
  if (!(g > 0) || !(steepness > 0)) return {};
  haptics::Inside is{std::min(g / steepness, 1.0), -rise / steepness};
  if (version.is_untouched()) return is;
  const double d = version.distance(p);
  if (d <= 0) return {};
  const dvec3 away = frame.gradient_world_from_volume(version.distance_gradient(p));
  if (d < is.depth && glm::length(away) > 0) is = {d, -away / glm::length(away)};
  return is;
}

/// Kept measurements have their location, no more.
void thin_out(std::vector<dvec3>& line) {
  constexpr std::size_t k_most = 400;
  if (line.size() <= k_most) return;
  std::vector<dvec3> fewer;
  for (std::size_t i = 0; i < k_most; ++i) fewer.push_back(line[i * (line.size() - 1) / (k_most - 1)]);
  line = std::move(fewer);
}

/// A line along the surface from place to place, back to the first of a closed one; the surface on which it
/// lies.
struct LineOnSurface {
  haptics::Surface surface;
  std::vector<haptics::Surface::Place> places;
};
std::optional<LineOnSurface> lay_line(const Measure& request, const volume::Field& shape,
                                      const volume::Version& version, bool is_closed, Measured& made) {
  double farthest = 0;
  for (const dvec3& p : request.at) farthest = std::max(farthest, glm::length(p - request.at[0]));
  // Looks around the way first; at all of it where nothing is there.
  for (const double reach : {0.6 * farthest + 20, 1e6}) {
    haptics::Surface surface = surface_near(shape, version, request.at, reach);
    made.line.clear();
    auto places = surface.nearest_on_one_part(request.at);
    made.moved = 0;
    for (std::size_t i = 0; i < places.size(); ++i)
      made.moved = std::max(made.moved, glm::length(places[i].at - request.at[i]));
    for (std::size_t i = 1; i < places.size() + is_closed; ++i) {
      const std::vector<dvec3> part =
          haptics::surface_line(surface, places[i - 1], places[i % places.size()]);
      if (part.empty()) {
        made.line.clear();
        break;
      }
      made.line.insert(made.line.end(), part.begin() + (made.line.empty() ? 0 : 1), part.end());
    }
    if (made.line.empty()) continue;
    if (made.moved <= k_farthest) return LineOnSurface{std::move(surface), std::move(places)};
    char text[80];
    std::snprintf(text, sizeof text, "a place lies %.1f mm from the surface; at most %.0f", made.moved,
                  k_farthest);
    made.trouble = text;
    made.line = request.at;
    return std::nullopt;
  }
  made.trouble = "no surface joins these places";
  return std::nullopt;
}

void measure_patch(const Measure& request, const volume::Field& shape, const volume::Version& version,
                   Measured& made) {
  const auto laid = lay_line(request, shape, version, true, made);
  if (!laid) return;
  made.length = haptics::length_of(made.line);
  const auto area = area_within(laid->surface, laid->places, made.line);
  thin_out(made.line);
  if (area)
    made.area = *area;
  else
    made.trouble = "the surface turns away within the outline: mark it in smaller parts";
}

void measure_part(const Measure& request, const volume::Field& shape, const volume::Version& version,
                  Measured& made) {
  const haptics::Surface surface = surface_near(shape, version, request.at, request.radius + 5);
  haptics::Surface::Place place;
  if (!surface.nearest(request.at[0], place) || glm::length(place.at - request.at[0]) > request.radius) {
    made.trouble = "nothing of the shape is so near";
    return;
  }
  const MarkedPart part = part_of(surface, place.triangle, request.at[0]);
  if (part.farthest > request.radius) {
    made.trouble = "the part reaches farther than the radius";
    return;
  }
  made.area = part.area, made.size = std::abs(part.volume);
}

void measure_tape(const Measure& request, const volume::Field& shape, const volume::Version& version,
                  Measured& made) {
  if (!lay_line(request, shape, version, false, made)) return;
  made.length = haptics::length_of(made.line);
  made.straight = glm::length(made.line.back() - made.line.front());
  made.taut = haptics::length_of(
      haptics::taut_line(made.line, [&](const dvec3& p) { return inside(shape, version, p); }));
  thin_out(made.line);
}

void measure_region(const Measure& request, const volume::Volume& scan, Measured& made) {
  const dvec3 middle = scan.frame.volume_from_world(request.at[0]);
  glm::ivec3 low, high;
  for (int a = 0; a < 3; ++a) {
    // Number of voxels of this axis that the ball may reach over, whichever way the axes lean.
    dvec3 unit(0.0);
    unit[a] = 1;
    const double reach = request.radius * glm::length(scan.frame.gradient_world_from_volume(unit));
    low[a] = std::max(0, static_cast<int>(std::floor(middle[a] - reach)));
    high[a] = std::min(scan.size[a] - 1, static_cast<int>(std::ceil(middle[a] + reach)));
  }
  double count = 0, sum = 0, square = 0;
  made.least = 1e300, made.most = -1e300;
  for (int z = low.z; z <= high.z; ++z)
    for (int y = low.y; y <= high.y; ++y)
      for (int x = low.x; x <= high.x; ++x) {
        const dvec3 off = scan.frame.vector_world_from_volume(dvec3(x, y, z) - middle);
        if (glm::dot(off, off) > request.radius * request.radius) continue;
        const double v = scan.voxels[scan.index(x, y, z)];
        ++count, sum += v, square += v * v;
        made.least = std::min(made.least, v), made.most = std::max(made.most, v);
      }
  if (count == 0) {
    made.least = made.most = 0;
    made.trouble = "no voxel's middle lies in it";
    return;
  }
  made.mean = sum / count;
  made.deviation = std::sqrt(std::max(0.0, square / count - made.mean * made.mean));
  made.size = count * scan.frame.voxel_mm3();
}

/// The number that is written next to it.
double value_of(const Measured& what) noexcept {
  switch (what.kind) {
    case Kind::angle:
      return what.angle;
    case Kind::region:
      return what.mean;
    case Kind::patch:
      return what.area;
    case Kind::part:
      return what.size;
    case Kind::ruler:
    case Kind::tape:
      break;
  }
  return what.length;
}

std::string words_of(Kind kind, double value) {
  constexpr const char* units[] = {"%.1f mm",   "%.1f\u00b0",    "%.1f mm",
                                   "mean %.0f", "%.0f mm\u00b2", "%.0f mm\u00b3"};
  char text[40];
  std::snprintf(text, sizeof text, units[static_cast<std::size_t>(kind)], value);
  return text;
}

struct Result final : sim::JobResult {
  Measured what;
  std::uint64_t fingerprint = 0;
  std::uint64_t hash() const override { return fingerprint; }
};

std::shared_ptr<const sim::JobResult> run(const void* parameters, const sim::JobInput& input) {
  const auto& request = *static_cast<const Measure*>(parameters);
  auto made = std::make_shared<Result>();
  made->what = measure(request, input.anatomy.items[static_cast<std::size_t>(request.item)].field,
                       *input.state.world.version);
  volume::MixHash all;
  sim::add_value(all, made->what);
  made->fingerprint = all.value();
  return made;
}

volume::Status check(const void* parameters, const haptics::TouchScene& anatomy) {
  const auto& request = *static_cast<const Measure*>(parameters);
  if (request.item < 0 || static_cast<std::size_t>(request.item) >= anatomy.items.size() ||
      anatomy.items[static_cast<std::size_t>(request.item)].is_mesh())
    return volume::Error{"there is no such shape of a volume", "measure item", std::to_string(request.item),
                         "a shape of the anatomy", ""};
  return std::nullopt;
}

void adopt(const void*, const sim::JobResult& result, sim::ModuleWork& work) {
  const auto& made = static_cast<const Result&>(result);
  auto& kept = work.change_settings<MeasurementState>();
  static_cast<Measured&>(kept) = made.what;
  if (made.what.trouble.empty()) {
    kept.kinds.push_back(static_cast<double>(made.what.kind));
    kept.counts.push_back(static_cast<double>(made.what.line.size()));
    kept.values.push_back(value_of(made.what));
    kept.lines.insert(kept.lines.end(), made.what.line.begin(), made.what.line.end());
  }
  while (kept.kinds.size() > MeasurementState::k_shown) {
    kept.lines.erase(kept.lines.begin(), kept.lines.begin() + static_cast<std::ptrdiff_t>(kept.counts[0]));
    for (std::vector<double>* list : {&kept.kinds, &kept.counts, &kept.values}) list->erase(list->begin());
  }
  work.raise_event(made.what, made.what.line.empty() ? dvec3(0.0) : made.what.line.front());
}

}  // namespace

std::string words_of(const Measured& what) { return words_of(what.kind, value_of(what)); }

Measured measure(const Measure& request, const volume::Field& shape, const volume::Version& version) {
  Measured made;
  made.kind = request.kind, made.is_any = true;
  made.line = request.at;
  switch (request.kind) {
    case Kind::ruler:
      made.length = made.straight = glm::length(request.at[1] - request.at[0]);
      break;
    case Kind::angle:
      made.angle = angle_between(request.at[0] - request.at[1], request.at[2] - request.at[1]);
      break;
    case Kind::tape:
      measure_tape(request, shape, version, made);
      break;
    case Kind::region:
      measure_region(request, shape.volume(), made);
      break;
    case Kind::patch:
      measure_patch(request, shape, version, made);
      break;
    case Kind::part:
      measure_part(request, shape, version, made);
      break;
  }
  return made;
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
  if (command.what.as<ClearMeasures>() != nullptr)
    work.change_settings<MeasurementState>() = MeasurementState{};
}

std::span<const sim::ValueType* const> Measurement::events() const {
  static const std::array all{&sim::value_type<Measured>()};
  return all;
}

volume::Status Measurement::allows(const sim::Command& command, const sim::OperationState&) const {
  const auto* request = command.what.as<Measure>();
  if (request == nullptr) return std::nullopt;
  const std::size_t count = request->at.size();
  const bool is_good = request->kind == Kind::ruler                                   ? count == 2
                       : request->kind == Kind::angle                                 ? count == 3
                       : request->kind == Kind::region || request->kind == Kind::part ? count == 1
                       : request->kind == Kind::patch ? count >= 3 && count <= 100
                                                      : count >= 2 && count <= 100;
  if (!is_good)
    return volume::Error{"these are not as many places as it takes", "measure at", std::to_string(count),
                         "two for a ruler, three for an angle, one for a region or a part, 2 to 100 for a "
                         "tape, 3 to 100 for a patch",
                         ""};
  if (request->kind == Kind::angle && count == 3 &&
      (request->at[0] == request->at[1] || request->at[2] == request->at[1]))
    return volume::Error{"an angle's corner is one of its ends", "measure at", "", "three places", ""};
  for (const dvec3& p : request->at)
    if (!(glm::dot(p, p) < 1e12))
      return volume::Error{"a place lies nowhere", "measure at", "", "finite numbers, mm", ""};
  return std::nullopt;
}

std::vector<sim::Measure> Measurement::measures(const sim::OperationState& now) const {
  const auto* last = now.settings_of<MeasurementState>();
  if (last == nullptr) return {};
  return {{"measured length", last->length, "mm"}, {"measured straight", last->straight, "mm"},
          {"measured taut", last->taut, "mm"},     {"measured angle", last->angle, "degrees"},
          {"measured mean", last->mean, ""},       {"measured deviation", last->deviation, ""},
          {"measured area", last->area, "mm2"},    {"measured size", last->size, "mm3"}};
}

sim::Overlays Measurement::overlays(const sim::OperationState& now) const {
  const auto* kept = now.settings_of<MeasurementState>();
  if (kept == nullptr || kept->kinds.empty()) return {};
  sim::Overlay overlay;
  overlay.kind = sim::Overlay::Kind::plan;
  // Dashed: 2 mm and 1.5 mm of nothing, along each whole line.
  constexpr double k_dash = 2, k_period = 3.5;  // mm
  std::size_t first = 0;
  for (std::size_t m = 0; m < kept->kinds.size(); ++m) {
    const auto count = static_cast<std::size_t>(kept->counts[m]);
    double at = 0;
    for (std::size_t i = first + 1; i < first + count; ++i) {
      const dvec3 &a = kept->lines[i - 1], &b = kept->lines[i];
      const double length = glm::length(b - a);
      for (double from = 0; from < length - 1e-9;) {
        const double phase = at + from - k_period * std::floor((at + from) / k_period);
        const double to =
            std::min(length, from + (phase < k_dash ? k_dash - phase : k_period - phase) + 1e-9);
        if (phase < k_dash) overlay.lines.push_back({a + from / length * (b - a), a + to / length * (b - a)});
        from = to;
      }
      at += length;
    }
    first += count;
    if (count > 0)
      overlay.labels.push_back(
          {kept->lines[first - 1], words_of(static_cast<Kind>(kept->kinds[m]), kept->values[m])});
  }
  return {overlay};
}

const sim::Schema& Measure::schema() {
  static constexpr sim::Field fields[] = {
      field<&Measure::kind>("kind", {.choices = k_kinds}),
      field<&Measure::at>(
          "at", {.unit = "mm", .help = "places in the world; of an angle the second is its corner"}),
      field<&Measure::radius>("radius", {.unit = "mm", .low = 0.1, .high = 200, .help = "of a region"}),
      field<&Measure::item>(
          "item", {.low = 0, .high = 255, .help = "the shape on which a tape lies", .is_expert = true})};
  static constexpr sim::Schema table{"measure", 1, fields};
  return table;
}

const sim::Schema& Measured::schema() {
  static constexpr sim::Field fields[] = {
      field<&Measured::kind>("kind", {.choices = k_kinds}),
      field<&Measured::is_any>("is_any"),
      field<&Measured::length>("length", {.unit = "mm", .help = "of a tape along the surface"}),
      field<&Measured::straight>("straight", {.unit = "mm"}),
      field<&Measured::taut>("taut", {.unit = "mm", .help = "of a tape pulled taut"}),
      field<&Measured::moved>("moved",
                              {.unit = "mm", .help = "from a tape's places to the surface, at most"}),
      field<&Measured::angle>("angle", {.unit = "degrees"}),
      field<&Measured::mean>("mean"),
      field<&Measured::deviation>("deviation"),
      field<&Measured::least>("least"),
      field<&Measured::most>("most"),
      field<&Measured::size>("size", {.unit = "mm3"}),
      field<&Measured::trouble>("trouble"),
      field<&Measured::line>("line", {.unit = "mm"}),
      field<&Measured::area>("area", {.unit = "mm2", .help = "of a patch, or of a part's surface"})};
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
