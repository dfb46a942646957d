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

std::shared_ptr<const DepthSet> DepthJob::make(int threads) const {
  auto drawn = source->draw(view, threads);
  if (!drawn) return nullptr;
  return std::make_shared<const DepthSet>(std::move(drawn).value());
}

AdoptDepths DepthJob::command(const DepthSet& result) const {
  AdoptDepths request;
  request.item = item;
  request.serial = static_cast<std::int64_t>(serial);
  request.middle = view.middle, request.touch = view.touch;
  request.edge = view.edge, request.time = view.time;
  request.hash = static_cast<std::int64_t>(result.hash());
  return request;
}

AdoptPicture adopt_picture_command(const haptics::depth::DepthPicture& picture, std::int64_t item,
                                   const dvec3& touch, double edge) {
  const haptics::depth::DepthCamera& c = picture.camera;
  const glm::dquat& q = picture.place.rotation;
  AdoptPicture request;
  request.item = item;
  request.touch = touch, request.edge = edge;
  request.width = c.width, request.height = c.height;
  request.fx = c.fx, request.fy = c.fy, request.cx = c.cx, request.cy = c.cy;
  request.position = picture.place.position_world;
  request.rotation = {q.w, q.x, q.y, q.z};
  request.nearest = picture.nearest, request.step = picture.mm_per_step;
  request.values = picture.values;
  return request;
}

haptics::depth::DepthPicture picture_of(const AdoptPicture& request) {
  haptics::depth::DepthPicture picture;
  picture.camera = {static_cast<int>(request.width),
                    static_cast<int>(request.height),
                    request.fx,
                    request.fy,
                    request.cx,
                    request.cy};
  const std::vector<double>& q = request.rotation;
  picture.place.position_world = request.position;
  if (q.size() == 4) picture.place.rotation = {q[0], q[1], q[2], q[3]};
  picture.nearest = request.nearest, picture.mm_per_step = request.step;
  picture.values = request.values;
  return picture;
}

std::shared_ptr<const DepthSet> set_of(const AdoptPicture& request) {
  const haptics::depth::DepthPicture picture = picture_of(request);
  DepthView view;
  view.middle = view.touch = request.touch;
  view.edge = request.edge, view.time = request.time;
  const double far = glm::length(request.touch - request.position);
  view.pixel = std::max(1e-3, far / std::min(request.fx, request.fy));
  return std::make_shared<const DepthSet>(haptics::depth::set_of(view, picture));
}

DepthJob job_of(const AdoptDepths& request, std::uint8_t hand, const haptics::TouchScene& scene) {
  const TouchItem& item = haptics::item_of(scene, static_cast<int>(request.item));
  DepthJob job{hand, request.item, static_cast<std::uint64_t>(request.serial), item.depth, {}};
  job.view = {request.middle,   request.touch, request.edge,
              item.depth_pixel, request.time,  DepthSets::interval_of(item, request.time)};
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

/// Returns the edge of the clip volume for a hand's speed in mm/s, mm.
double edge_at(double speed, double rate, double tick) noexcept {
  constexpr double k_making = 0.005;  // s
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
  return Error{.what = "depth images with so small pixels cover too little around a hand",
               .where = "depth pixel",
               .found = text_of(k_max_pixels * pixel_mm) + " mm",
               .expected = text_of(least) + " mm or more, for a hand at 1 m/s and " + text_of(rate) +
                           " sets per second",
               .remedy = "use larger pixels, or more sets per second"};
}

void DepthSets::see(const dvec3& hip, const dvec3& proxy) noexcept {
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

std::uint64_t DepthSets::next_serial(std::size_t place) const noexcept {
  return newest_[place] ? newest_[place]->serial + 1 : 1;
}

std::optional<DepthJob> DepthSets::job(const haptics::ServoHand& hand, std::uint8_t number,
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
    const haptics::Placement place = set ? item_pose * set->displacement_at(time) : item_pose;
    const dvec3 hip = place.local_from_world(hip_), proxy = place.local_from_world(proxy_);
    const dvec3 local_hip = item_pose.local_from_world(hip_),
                local_proxy = item_pose.local_from_world(proxy_);
    dvec3 low, high;
    item.depth->bounds(low, high);
    const auto is_far = [&](const dvec3& p) {
      return glm::length(p - glm::clamp(p, low, high)) > 0.5 * edge + hand.scene->tool_radius;
    };
    // The bounds contain all of the object's own motion.
    if (!(low.x <= high.x) || (is_far(local_hip) && is_far(local_proxy))) continue;
    // The next set is requested when a third of the distance to the border is left.
    const double reach = edge / 3 + hand.scene->tool_radius;
    // Never before the next set is due, however little the last one shows.
    const bool is_due = !set || time >= set->view.time + set->view.interval;
    const bool is_old = !set || set->has_successor || !set->knows(hip, reach) || !set->knows(proxy, reach);
    if (!is_due || !is_old) continue;
    constexpr double k_widest = 150;  // mm; a hand so deep that it needs more loses contact
    DepthJob job{number, items_[d], next_serial(d), item.depth, {}};
    job.view.touch = local_proxy;
    job.view.middle = 0.5 * (local_hip + local_proxy);
    // The known part ends a few pixels before the border.
    const double requested =
        std::min(k_widest, edge + 2 * hand.scene->tool_radius + glm::length(hip - proxy)) +
        k_border * item.depth_pixel;
    job.view.edge = std::min(requested, k_max_pixels * item.depth_pixel);
    job.view.pixel = item.depth_pixel;
    job.view.time = time;
    job.view.interval = interval_of(item, time);
    // A hand at rest whose surroundings no set can cover gets no further one.
    if (set && !set->has_successor && job.view.middle == set->view.middle && job.view.edge == set->view.edge)
      continue;
    return job;
  }
  return std::nullopt;
}

void DepthSets::take(std::int64_t item, std::shared_ptr<DepthSet> result) {
  std::shared_ptr<const DepthSet>& current = newest_[*index_of(item)];
  const std::uint64_t serial = result->serial;
  result->follow(current.get());
  result->serial = serial;  // a set that is sent again keeps its serial
  current = std::move(result);
}

}  // namespace trephine::sim
