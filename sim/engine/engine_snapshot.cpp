// Engine: conversion to an EngineSnapshot and back.
#include "sim/api/core_command.h"
#include "sim/engine/engine.h"

namespace trephine::sim {

/// Calls each(engine member, snapshot member) for the members that both have.
template <class SomeEngine, class Snapshot, class Each>
void Engine::for_each_kept(SomeEngine& engine, Snapshot& snapshot, Each&& each) {
  each(engine.state_, snapshot.state);
  each(engine.fields_, snapshot.fields);
  each(engine.branch_, snapshot.branch);
  each(engine.other_branches_, snapshot.other_branches);
  each(engine.last_entry_, snapshot.last_entry);
  each(engine.addition_count_, snapshot.addition_count);
  each(engine.is_stroke_changed_, snapshot.is_stroke_changed);
  each(engine.stroke_box_, snapshot.stroke_box);
  each(engine.ever_cut_, snapshot.all_cuts_box);
  each(engine.jobs_, snapshot.jobs);
  each(engine.last_job_, snapshot.last_job);
  each(engine.last_body_, snapshot.last_body);
}

EngineSnapshot Engine::full_snapshot() {
  freeze();
  EngineSnapshot result;
  for_each_kept(*this, result, [](const auto& member, auto& copy) { copy = member; });
  result.serial = serial();
  for (std::size_t h = 0; h < hands_.size(); ++h)
    result.hands.push_back({tools_[h], hands_[h].escape_path, work_[h], trails_[h]});
  return result;
}

Status Engine::restore(const EngineSnapshot& snapshot) {
  for (std::size_t h = 0; h < hands_.size(); ++h) {
    const Instrument& instrument = snapshot.state.settings.hands[h];
    if (instrument.type && instrument.type->check)
      if (Status error = instrument.type->check(instrument.parameters.data(), *snapshot.hands[h].tool.scene))
        return error;
  }
  for_each_kept(*this, snapshot, [](auto& member, const auto& copy) { member = copy; });
  editor_.reset(state_.undoable.version);
  published_version_ = state_.undoable.version;
  for (std::size_t h = 0; h < hands_.size(); ++h) {
    const EngineSnapshot::Hand& hand = snapshot.hands[h];
    tools_[h] = hand.tool;
    if (hand.tool.scene != hands_[h].scene) hands_[h].set_scene(hand.tool.scene, hand.tool.method);
    work_[h] = hand.work;
    trails_[h] = hand.trail;
    depths_[h] = DepthSets(*hand.tool.scene, state_.dt);
  }
  // Commands that end an effect are applied first. This frees entries of the LawSet for the effects of
  // instruments and for new effects.
  for (const bool is_ending : {true, false}) {
    if (!is_ending)
      for (std::size_t h = 0; h < hands_.size(); ++h) {
        Change change = Change::removal;  // not used: the restored servo state already includes the change
        use_forces_of_instrument(h, change);
      }
    for (const auto& [key, command] : state_.settings.latest_commands) {
      const auto* effect = command.request.as<SetEffect>();
      const CoreCommand* row = find_core_command(command.request.type());
      if ((effect && effect->words.empty()) != is_ending || !row || !row->restore) continue;
      if (Status error = effect ? Status() : row->check(*this, command)) return error;
      if (Status error = row->restore(*this, command)) return error;
    }
  }
  if (!state_.undoable.bodies.empty()) {
    if (Status error = check_room_for_bodies()) return error;
    use_bodies(Bodies::changed);
  }
  for (std::size_t h = 0; h < hands_.size(); ++h) hands_[h].escape_path = snapshot.hands[h].escape_path;
  for (PendingJob& job : jobs_) make_runnable(job);
  are_initial_commands_due_ = false;
  results_.clear();
  submitted_.clear();
  std::shared_ptr<haptics::ServoScene> next = make_scene(snapshot.serial);
  next->hands = hands_;
  next->has_held = has_held();
  servo_scene_ = std::move(next);
  return std::nullopt;
}

}  // namespace trephine::sim
