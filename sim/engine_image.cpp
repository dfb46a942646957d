// An engine as values, and back.
#include "sim/engine.h"

namespace trephine::sim {

using volume::Status;

EngineImage Engine::image() {
  freeze();
  EngineImage all;
  all.now = now_;
  all.serial = serial();
  for (std::size_t h = 0; h < hands_.size(); ++h)
    all.hands.push_back({tools_[h], hands_[h].way, work_[h], trails_[h]});
  all.fields = fields_;
  all.history = history_;
  all.position = position_;
  all.forgotten = forgotten_;
  all.last_entry = last_entry_;
  all.growths = growths_;
  all.edits = edits_;
  all.is_stroke_changed = is_stroke_changed_;
  all.stroke_box = stroke_box_;
  all.ever_cut = ever_cut_;
  all.jobs = jobs_;
  all.last_job = last_job_;
  all.last_body = last_body_;
  return all;
}

Status Engine::restore(const EngineImage& image) {
  for (std::size_t h = 0; h < hands_.size(); ++h) {
    const Instrument& held = image.now.settings.hands[h];
    if (held.type && held.type->check)
      if (Status error = held.type->check(held.parameters.data(), *image.hands[h].tool.scene)) return error;
  }
  now_ = image.now;
  editor_.reset(now_.world.version);
  felt_ = now_.world.version;
  for (std::size_t h = 0; h < hands_.size(); ++h) {
    const EngineImage::Hand& hand = image.hands[h];
    tools_[h] = hand.tool;
    if (hand.tool.scene != hands_[h].scene) hands_[h].set_scene(hand.tool.scene, hand.tool.method);
    work_[h] = hand.work;
    trails_[h] = hand.trail;
  }
  // Effects that ended make room for those that began.
  for (const bool is_ending : {true, false})
    for (const auto& [key, command] : now_.settings.told) {
      const auto* effect = command.what.as<SetEffect>();
      if ((effect && effect->words.empty()) != is_ending || command.what.as<ToolGeometry>()) continue;
      Status error = effect ? Status() : check_setting(command);
      std::int64_t number = 0;
      Change change = Change::cut;
      if (!error) set(command, number, change, error);
      if (error) return error;
    }
  if (!now_.world.bodies.empty()) {
    if (Status error = check_room_for_bodies()) return error;
    use_bodies(Bodies::others);
  }
  for (std::size_t h = 0; h < hands_.size(); ++h) hands_[h].way = image.hands[h].way;
  fields_ = image.fields;
  history_ = image.history;
  position_ = image.position;
  forgotten_ = image.forgotten;
  last_entry_ = image.last_entry;
  growths_ = image.growths;
  edits_ = image.edits;
  is_stroke_changed_ = image.is_stroke_changed;
  stroke_box_ = image.stroke_box;
  ever_cut_ = image.ever_cut;
  jobs_ = image.jobs;
  for (PendingJob& job : jobs_) arm(job);
  last_job_ = image.last_job;
  last_body_ = image.last_body;
  results_.clear();
  made_fields_.clear();
  std::shared_ptr<haptics::ServoScene> seen = make_scene(image.serial);
  seen->hands = hands_;
  seen->has_held = has_held();
  servo_scene_ = std::move(seen);
  return std::nullopt;
}

}  // namespace trephine::sim
