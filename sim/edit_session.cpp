#include "sim/edit_session.h"

#include <algorithm>
#include <array>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "haptics/walls/free_place.h"

namespace trephine::sim {

namespace {
constexpr volume::VoxelBox k_nothing{glm::ivec3(0), glm::ivec3(-1)};

std::vector<volume::Field> fields_of(const haptics::TouchScene& scene) {
  std::vector<volume::Field> fields;
  for (const haptics::TouchItem& shape : haptics::base_shapes(scene)) fields.push_back(shape.field);
  return fields;
}

/// Keeps places farther than half a voxel from the last one; when there are too many the older half is
/// dropped.
void remember_place(std::vector<glm::dvec3>& places, const glm::dvec3& place) {
  constexpr std::size_t k_most = 4096;
  if (!places.empty() && glm::length(places.back() - place) < 0.5) return;
  if (places.size() >= k_most) places.erase(places.begin(), places.begin() + k_most / 2);
  places.push_back(place);
}
}  // namespace

volume::VoxelBox united(const volume::VoxelBox& a, const volume::VoxelBox& b) noexcept {
  if (a.low.x > a.high.x) return b;
  if (b.low.x > b.high.x) return a;
  return {glm::min(a.low, b.low), glm::max(a.high, b.high)};
}

EditSession::EditSession(std::vector<haptics::ServoHand> hands, std::span<Tool* const> tools, double dt)
    : scene_(hands.at(0).scene), dt_(dt), editor_(haptics::untouched(*scene_), fields_of(*scene_)) {
  TREPHINE_ASSERT(hands.size() == tools.size());
  for (Tool* tool : tools) hands_.push_back({tool, false, {}});
  servo_scene_ = std::make_shared<haptics::ServoScene>(haptics::ServoScene{0, std::move(hands)});
  publish({}, Change::cut);
  history_.push_back({state(), k_nothing, k_nothing});
}

EditSession::EditSession(const haptics::TouchScene& scene, const haptics::ProxyMethod& method,
                         std::span<Tool* const> tools, double dt)
    : EditSession(
          std::vector(tools.size(), haptics::ServoHand(haptics::borrowed(scene), haptics::borrowed(method),
                                                       haptics::TouchState(nullptr))),
          tools, dt) {}

EditSession::EditSession(const haptics::TouchScene& scene, const haptics::ProxyMethod& method, Tool* tool,
                         double dt)
    : EditSession(scene, method, std::array{tool}, dt) {}

EditOutcome EditSession::consume(const haptics::ServoRecord& tick) {
  Hand& hand = hands_[tick.hand];
  const bool is_at_home = !tick.is_led && !tick.is_buried && (tick.faults & haptics::k_latched_faults) == 0;
  if (is_at_home) remember_place(hand.places, scene_->base->frame.volume_from_world(tick.proxy_world));
  if (!tick.pose.is_pressed() || hand.tool == nullptr) {
    if (hand.is_pressed) {
      hand.is_pressed = false;
      hand.tool->lift();
      if (std::none_of(hands_.begin(), hands_.end(), [](const Hand& h) { return h.is_pressed; }))
        end_stroke();
    }
    return {};
  }
  hand.is_pressed = is_pressed_ = true;
  const volume::RemovalReport report = hand.tool->apply(tick, dt_, editor_);
  if (report.bricks_changed == 0) return {};
  publish(state().offsets, Change::cut);
  note_cut(report.box);
  is_stroke_changed_ = true;
  stroke_box_ = united(stroke_box_, report.box);
  return {true, report.box};
}

EditOutcome EditSession::apply(const Command& command) {
  switch (command.kind) {
    case Command::Kind::undo:
      return undo();
    case Command::Kind::redo:
      return redo();
    case Command::Kind::set_tool:
      if (command.hand < hands_.size() && hands_[command.hand].tool)
        hands_[command.hand].tool->set(command.name, command.value);
      return {};
    case Command::Kind::resume:
      end_stroke();
      return {};
    case Command::Kind::offsets:
      if (const auto serial = static_cast<std::uint64_t>(command.value);
          const std::optional<OffsetJob> job = job_of(serial))
        return attach(serial, job->make(*scene_, 0));
      return {};
    case Command::Kind::note:
      break;
  }
  return {};
}

void EditSession::end_stroke() {
  for (Hand& hand : hands_) {
    if (hand.tool) hand.tool->lift();
    hand.is_pressed = false;
  }
  is_pressed_ = false;
  if (!is_stroke_changed_) return;
  editor_.end_stroke();
  history_.erase(history_.begin() + static_cast<std::ptrdiff_t>(position_) + 1,
                 history_.end());  // a new stroke ends the redo line
  volume::VoxelBox owed = owed_;
  for (const Cut& cut : cuts_) owed = united(owed, cut.box);
  history_.push_back({state(), stroke_box_, owed});
  ++position_;
  if (position_ > k_most_strokes) {
    history_.erase(history_.begin());
    --position_;
    ++forgotten_;
  }
  is_stroke_changed_ = false;
  stroke_box_ = k_nothing;
}

/// The working state, by a serial of its own, for servos to adopt. Where matter may have grown each hand is
/// told the way out of it.
void EditSession::publish(OffsetJob::Offsets offsets, Change change) {
  const haptics::TouchState now(editor_.publish(), std::move(offsets));
  auto next = std::make_shared<haptics::ServoScene>(*servo_scene_);
  next->serial = now.version->serial();
  for (haptics::ServoHand& hand : next->hands) hand.state = now;
  servo_scene_ = next;
  if (change == Change::growth)
    for (std::size_t h = 0; h < hands_.size(); ++h) {
      haptics::WayOut none;
      none.serial = next->serial;
      next->hands[h].way = std::make_shared<const haptics::WayOut>(way_out(h).value_or(none));
    }
}

EditOutcome EditSession::go_to(std::size_t position) {
  const volume::VoxelBox box = history_[std::max(position, position_)].box;
  position_ = position;
  editor_.reset(history_[position].state.version);
  owed_ = history_[position].owed;
  cuts_.clear();
  // A fresh serial for the old contents, so that every adopted version has its own.
  publish(history_[position].state.offsets, Change::growth);
  if (owed_.low.x <= owed_.high.x) cuts_.push_back({current(), k_nothing});
  return {true, box};
}

OffsetJob::Offsets OffsetJob::make(const haptics::TouchScene& scene, int threads) const {
  Offsets made;
  for (std::size_t s = 0; s < before.size(); ++s)
    made.push_back(before[s]->updated(scene.items[s].field, *scene.items[s].bits, *version, box, threads,
                                      nullptr, scene.items[s].soft.get()));
  return made;
}

void EditSession::note_cut(const volume::VoxelBox& box) {
  if (scene_->tool_radius <= 0) return;
  // Fields that never come must not keep every version.
  constexpr std::size_t k_most = 4096;
  if (cuts_.size() == k_most) {
    owed_ = united(owed_, cuts_.front().box);
    cuts_.erase(cuts_.begin());
  }
  cuts_.push_back({current(), box});
}

std::optional<OffsetJob> EditSession::job_of(std::uint64_t serial) const {
  OffsetJob job;
  job.box = owed_;
  for (const Cut& cut : cuts_) {
    job.box = united(job.box, cut.box);
    if (cut.version->serial() == serial) {
      job.version = cut.version;
      break;
    }
  }
  if (!job.version) return std::nullopt;
  job.before = state().offsets;
  if (job.before.empty())
    for (const haptics::TouchItem& shape : haptics::base_shapes(*scene_)) job.before.push_back(shape.offset);
  return job;
}

std::optional<OffsetJob> EditSession::offset_job() const {
  return cuts_.empty() ? std::nullopt : job_of(cuts_.back().version->serial());
}

EditOutcome EditSession::attach(std::uint64_t serial, OffsetJob::Offsets offsets) {
  const auto made_from = std::find_if(cuts_.begin(), cuts_.end(),
                                      [serial](const Cut& cut) { return cut.version->serial() == serial; });
  if (made_from == cuts_.end()) return {};
  cuts_.erase(cuts_.begin(), std::next(made_from));
  owed_ = k_nothing;
  publish(std::move(offsets), Change::cut);
  // The state between strokes keeps what it has now, for whoever comes back to it.
  if (!is_stroke_changed_) {
    Entry& here = history_[position_];
    here.state = state();
    here.owed = k_nothing;
    for (const Cut& cut : cuts_) here.owed = united(here.owed, cut.box);
  }
  return {true, k_nothing};
}

EditOutcome EditSession::undo() {
  end_stroke();
  if (position_ == 0) return {};
  return go_to(position_ - 1);
}

EditOutcome EditSession::redo() {
  end_stroke();
  if (!can_redo()) return {};
  return go_to(position_ + 1);
}

double EditSession::removed_mm3() const noexcept { return current()->mm3_of(current()->ledger().total()); }

std::vector<double> EditSession::removed_mm3_by_label() const {
  std::vector<double> result;
  for (const std::int64_t units : current()->ledger().units_by_label)
    result.push_back(current()->mm3_of(units));
  return result;
}

const glm::dvec3* EditSession::last_free(std::size_t hand) const noexcept {
  const std::vector<glm::dvec3>& places = hands_[hand].places;
  for (std::size_t i = places.size(); i-- > 0;)
    if (haptics::is_free(*scene_, state(), places[i])) return &places[i];
  return nullptr;
}

std::optional<haptics::WayOut> EditSession::way_out(std::size_t hand) const {
  const glm::dvec3* free = last_free(hand);
  if (free == nullptr) return std::nullopt;
  const std::vector<glm::dvec3>& places = hands_[hand].places;
  // Back along the path; from each place straight on to the oldest one that lies beside it.
  constexpr double k_beside = 1;  // voxels
  const auto last = static_cast<std::size_t>(free - places.data());
  std::vector<glm::dvec3> way;
  for (std::size_t i = places.size() - 1;;) {
    way.push_back(places[i]);
    if (i == last) break;
    std::size_t next = last;
    while (next + 1 < i && glm::length(places[next] - places[i]) > k_beside) ++next;
    i = next;
  }
  haptics::WayOut result;
  result.serial = servo_scene_->serial;
  const std::size_t stride =
      (way.size() + haptics::WayOut::k_most_places - 1) / haptics::WayOut::k_most_places;
  for (std::size_t i = stride - 1; i < way.size(); i += stride) result.places_volume[result.count++] = way[i];
  if (way.size() % stride != 0) {
    if (result.count == haptics::WayOut::k_most_places) --result.count;
    result.places_volume[result.count++] = way.back();
  }
  return result;
}

}  // namespace trephine::sim
