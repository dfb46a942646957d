#include "sim/engine/depth_sets.h"

#include <algorithm>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "volume/base/text.h"

namespace trephine::sim {

using glm::dvec3;
using haptics::TouchItem;
using haptics::depth::DepthSet;
using haptics::depth::DepthView;

const Schema& DepthImages::schema() {
  static constexpr Field fields[] = {
      field<&DepthImages::middle>("middle", {.unit = "mm", .low = -1e6, .high = 1e6}),
      field<&DepthImages::touch>("touch", {.unit = "mm", .low = -1e6, .high = 1e6}),
      field<&DepthImages::edge>("edge", {.unit = "mm", .low = 1, .high = 200}),
      field<&DepthImages::time>("time", {.unit = "s", .low = 0, .high = 1e9})};
  static constexpr Schema table{"depth-images", 1, fields};
  return table;
}
const Schema& DepthPixels::schema() {
  using Fields = DepthPixels;
  static constexpr Field fields[] = {
      field<&Fields::touch>("touch", {.unit = "mm", .low = -1e6, .high = 1e6}),
      field<&Fields::edge>("edge", {.unit = "mm", .low = 0.1, .high = 1000}),
      field<&Fields::time>("time", {.unit = "s", .low = 0, .high = 1e9}),
      field<&Fields::width>("width", {.low = 2, .high = 4096}),
      field<&Fields::height>("height", {.low = 2, .high = 4096}),
      field<&Fields::fx>("fx", {.low = 1e-3, .high = 1e6}),
      field<&Fields::fy>("fy", {.low = 1e-3, .high = 1e6}),
      field<&Fields::cx>("cx", {.low = -1e6, .high = 1e6}),
      field<&Fields::cy>("cy", {.low = -1e6, .high = 1e6}),
      field<&Fields::position>("position", {.unit = "mm", .low = -1e6, .high = 1e6}),
      field<&Fields::rotation>("rotation", {.low = -1, .high = 1}),
      field<&Fields::nearest>("nearest", {.unit = "mm", .low = 1e-6, .high = 1e6}),
      field<&Fields::step>("step", {.unit = "mm", .low = 1e-6, .high = 1000}),
      field<&Fields::values>("values")};
  static constexpr Schema table{"depth-picture", 1, fields};
  return table;
}

DepthPixels DepthPixels::of(const haptics::depth::DepthPicture& picture, const dvec3& touch, double edge,
                            double time) {
  const haptics::depth::DepthCamera& c = picture.camera;
  const glm::dquat& q = picture.placement.rotation;
  return {touch,
          edge,
          time,
          c.width,
          c.height,
          c.fx,
          c.fy,
          c.cx,
          c.cy,
          picture.placement.position_world,
          {q.w, q.x, q.y, q.z},
          picture.nearest,
          picture.mm_per_step,
          picture.values};
}

haptics::depth::DepthPicture DepthPixels::picture() const {
  haptics::depth::DepthPicture picture;
  picture.camera = {static_cast<int>(width), static_cast<int>(height), fx, fy, cx, cy};
  picture.placement.position_world = position;
  if (rotation.size() == 4) picture.placement.rotation = {rotation[0], rotation[1], rotation[2], rotation[3]};
  picture.nearest = nearest, picture.mm_per_step = step;
  picture.values = values;
  return picture;
}

namespace {

DerivedData data_of(DepthSet set) {
  DerivedData data;
  data.depths = std::make_shared<const DepthSet>(std::move(set));
  data.hash = data.depths->hash();
  return data;
}

DerivedJob images_job(const DerivedKey& key, std::uint64_t serial, const DepthImages& input,
                      const std::shared_ptr<const haptics::TouchScene>& scene, const DepthView& view) {
  DerivedJob job{key, serial, Value(input).bytes(), scene, view.interval};
  // Takes milliseconds, depending on the visible part.
  job.make = [source = haptics::item_of(*scene, static_cast<int>(key.item)).depth, view](int threads) {
    auto drawn = source->draw(view, threads);
    DepthSet set = drawn ? std::move(drawn).value() : DepthSet();
    set.view = view;
    if (!set.tree) set.tree = std::make_shared<const haptics::MeshTree>();
    DerivedData data = data_of(std::move(set));
    data.is_empty = !drawn;
    return data;
  };
  return job;
}

DepthView view_of(const DepthImages& input, const TouchItem& item) {
  return {input.middle,     input.touch, input.edge,
          item.depth_pixel, input.time,  DepthSets::interval_of(item, input.time)};
}

Error wrong_item(const DerivedKey& key, const char* what, const char* expected) {
  return Error{.what = what, .where = "adopt item", .found = std::to_string(key.item), .expected = expected};
}

}  // namespace

DerivedJob picture_job(const DerivedKey& key, std::uint64_t serial, const DepthPixels& input) {
  DerivedJob job{key, serial, Value(input).bytes()};
  job.make = [input](int /*threads*/) {
    DepthView view;
    view.middle = view.touch = input.touch;
    view.edge = input.edge, view.time = input.time;
    const double far = glm::length(input.touch - input.position);
    view.pixel = std::max(1e-3, far / std::min(input.fx, input.fy));
    return data_of(haptics::depth::set_of(view, input.picture()));
  };
  return job;
}

Result<DerivedJob> depth_job(const DerivedKey& key, std::uint64_t serial, std::string_view input,
                             const std::shared_ptr<const haptics::TouchScene>& scene) {
  if (key.item >= haptics::item_count(*scene) || !haptics::item_of(*scene, static_cast<int>(key.item)).depth)
    return wrong_item(key, "this item has no depth images", "an item with depth images");
  const TouchItem& item = haptics::item_of(*scene, static_cast<int>(key.item));
  if (key.kind == DerivedKind::depth_images) {
    if (item.depth->is_streamed())
      return wrong_item(key, "this item is not drawn: its pictures are submitted by the caller",
                        "an item that is drawn");
    const auto images = Value::from_bytes(value_type<DepthImages>(), input);
    if (!images) return images.error();
    const DepthImages& request = *images.value().as<DepthImages>();
    const DepthView view = view_of(request, item);
    glm::ivec3 size(0);
    const auto frame = view.lattice(size);
    if (!frame) return frame.error();
    return images_job(key, serial, request, scene, view);
  }
  if (!item.depth->is_streamed())
    return wrong_item(key, "this item is not touched by pictures", "an item with submitted pictures");
  const auto pixels = Value::from_bytes(value_type<DepthPixels>(), input);
  if (!pixels) return pixels.error();
  const DepthPixels& request = *pixels.value().as<DepthPixels>();
  if (Status error = check_rotation(request.rotation, "depth-picture rotation")) return *error;
  if (Status error = haptics::depth::check(request.picture())) return *error;
  DerivedJob job = picture_job(key, serial, request);
  job.scene = scene;
  return job;
}

double DepthSets::interval_of(const TouchItem& item, double time) noexcept {
  const double longest = 1 / item.depth_rate;
  return std::clamp(item.depth->next_motion_change(time) - time, 0.2 * longest, longest);
}

namespace {
constexpr double k_usual_speed = 1000;  // mm/s, of a hand
constexpr double k_max_pixels = 800;    // along the edge of a clip volume
constexpr double k_border = 6;          // pixels, between the known part and the edge

/// Returns the edge of the clip volume, mm. `speed`: of the hand, mm/s; `rate`: sets per second; `tick`:
/// period of the hand's poses, s.
double edge_at(double speed, double rate, double tick) noexcept {
  constexpr double k_making = 0.005;  // s, least duration that is assumed for making a set
  const double until_next = 1 / rate, making = std::max({0.5 * until_next, k_making, 2 * tick});
  return haptics::depth::clip_volume({speed, 1 / (until_next + making), 1 / tick});
}
}  // namespace

double DepthSets::edge_of(const TouchItem& item) const noexcept {
  return edge_at(std::max(k_usual_speed, 1.5 * speed_), item.depth_rate, tick_);
}

Status DepthSets::check_pixel(double pixel_mm, double rate, double tool_radius) {
  const double least = edge_at(k_usual_speed, rate, 1e-3) + 2 * tool_radius + k_border * pixel_mm;
  if (k_max_pixels * pixel_mm >= least) return std::nullopt;
  return Error{
      .what = "the pixels of depth images are too small: the images do not cover the reach of a hand",
      .where = "depth pixel",
      .found = text_of(k_max_pixels * pixel_mm) + " mm",
      .expected =
          text_of(least) + " mm or more, for a hand at 1 m/s and " + text_of(rate) + " sets per second",
      .remedy = "use larger pixels, or more sets per second"};
}

void DepthSets::record_positions(const dvec3& hip, const dvec3& proxy) noexcept {
  constexpr double k_decay = 0.98;      // per tick
  constexpr double k_fastest = 20'000;  // mm/s; a faster motion is a jump, which does not count
  const double speed = has_position_ ? glm::length(hip - hip_) / tick_ : 0;
  speed_ = std::max(k_decay * speed_, speed < k_fastest ? speed : 0);
  hip_ = hip, proxy_ = proxy, has_position_ = true;
}

DepthSets::DepthSets(const haptics::TouchScene& scene, double tick) : tick_(tick) {
  for (int i = 0; i < haptics::item_count(scene); ++i)
    if (haptics::item_of(scene, i).depth) items_.push_back(i);
  newest_.resize(items_.size());
}

std::optional<std::size_t> DepthSets::index_of(std::int64_t item) const noexcept {
  const auto found = std::find(items_.begin(), items_.end(), item);
  if (found == items_.end()) return std::nullopt;
  return static_cast<std::size_t>(found - items_.begin());
}

std::uint64_t DepthSets::next_serial(std::size_t index) const noexcept {
  return newest_[index] ? newest_[index]->serial + 1 : 1;
}

std::optional<DerivedJob> DepthSets::job(const haptics::ServoHand& hand, std::uint8_t number,
                                         const std::shared_ptr<const haptics::TouchScene>& scene,
                                         double time) const {
  if (!has_position_) return std::nullopt;
  for (std::size_t d = 0; d < items_.size(); ++d) {
    const TouchItem& item = haptics::item_of(*hand.scene, items_[d]);
    if (item.depth->is_streamed()) continue;
    const DepthSet* set = newest_[d].get();
    const double edge = edge_of(item);
    haptics::Placement item_pose = item.placement;  // without the object's own motion
    if (item.mover >= 0 && static_cast<std::size_t>(item.mover) < hand.placement_count)
      item_pose = hand.placements[static_cast<std::size_t>(item.mover)];
    const haptics::Placement placement = set ? item_pose * set->displacement_at(time) : item_pose;
    const dvec3 hip = placement.local_from_world(hip_), proxy = placement.local_from_world(proxy_);
    const dvec3 local_hip = item_pose.local_from_world(hip_),
                local_proxy = item_pose.local_from_world(proxy_);
    dvec3 low, high;
    item.depth->bounds(low, high);
    const auto is_far = [&](const dvec3& p) {
      return glm::length(p - glm::clamp(p, low, high)) > 0.5 * edge + hand.scene->tool->radius();
    };
    // The bounds contain all of the object's own motion.
    if (!(low.x <= high.x) || (is_far(local_hip) && is_far(local_proxy))) continue;
    // The next set is requested when the known part no longer contains all points around the hand, and around
    // its proxy, up to a third of the edge plus the tool's radius.
    const double reach = edge / 3 + hand.scene->tool->radius();
    // No set is requested before it is due, even if the last set covers little of the surroundings.
    const bool is_due = !set || time >= set->view.time + set->view.interval;
    const bool is_old = !set || set->has_successor || !set->is_known_around(hip, reach) ||
                        !set->is_known_around(proxy, reach);
    if (!is_due || !is_old) continue;
    constexpr double k_widest = 150;  // mm; a hand so deep that it needs more loses contact
    // The known part ends a few pixels before the border.
    const double requested =
        std::min(k_widest, edge + 2 * hand.scene->tool->radius() + glm::length(hip - proxy)) +
        k_border * item.depth_pixel;
    const DepthImages input{0.5 * (local_hip + local_proxy), local_proxy,
                            std::min(requested, k_max_pixels * item.depth_pixel), time};
    // A hand at rest whose surroundings no set can cover gets no further set.
    if (set && !set->has_successor && input.middle == set->view.middle && input.edge == set->view.edge)
      continue;
    return images_job({DerivedKind::depth_images, items_[d], number}, next_serial(d), input, scene,
                      view_of(input, item));
  }
  return std::nullopt;
}

void DepthSets::adopt(std::int64_t item, std::shared_ptr<DepthSet> result) {
  std::shared_ptr<const DepthSet>& current = newest_[*index_of(item)];
  const std::uint64_t serial = result->serial;
  result->follow(current.get());
  result->serial = serial;  // follow() may set another serial: a set that is adopted again keeps its own
  current = std::move(result);
}

}  // namespace trephine::sim
