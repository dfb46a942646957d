// Engine: undo, redo and branches.
#include <algorithm>
#include <array>
#include <unordered_set>

#include "sim/engine/core_commands.h"

namespace trephine::sim {

namespace {

template <class Branches>
auto find_branch(Branches& all, const std::string& name) {
  return std::find_if(all.begin(), all.end(), [&](const Branch& one) { return one.name == name; });
}

}  // namespace

struct HistoryCommands {
  /// Checks that a history entry can be restored.
  static Status check_entry(const Engine& engine, const HistoryEntry& entry) {
    const Result<EntryState> state = entry.state();
    if (!state) return state.error();
    return state.value().undoable.bodies.empty() ? Status() : engine.check_room_for_bodies();
  }

  /// Returns the entry to which undo goes; null if nothing can be undone.
  static const HistoryEntry* undo_target(const Engine& engine) {
    if (!engine.can_undo()) return nullptr;
    // If the current stroke changed something, undo() first ends it and adds an entry for it.
    return engine.branch_.history[engine.branch_.position - (engine.is_stroke_changed_ ? 0 : 1)].get();
  }
  static Status check_undo(const Engine& engine, const Undo&, std::uint8_t) {
    const HistoryEntry* target = undo_target(engine);
    return target ? check_entry(engine, *target) : Status();
  }
  static void undo(Engine& engine, const Undo&, std::uint8_t, Outcome& outcome) {
    engine.end_stroke();
    if (engine.branch_.position == 0) return;
    ++engine.state_.chronicle.undos;
    engine.go_to(engine.branch_.position - 1, outcome);
  }

  static const HistoryEntry* redo_target(const Engine& engine) {
    if (!engine.can_redo() || engine.is_stroke_changed_) return nullptr;
    return engine.branch_.history[engine.branch_.position + 1].get();
  }
  static Status check_redo(const Engine& engine, const Redo&, std::uint8_t) {
    const HistoryEntry* target = redo_target(engine);
    return target ? check_entry(engine, *target) : Status();
  }
  static void redo(Engine& engine, const Redo&, std::uint8_t, Outcome& outcome) {
    engine.end_stroke();
    if (!engine.can_redo()) return;
    ++engine.state_.chronicle.redos;
    engine.go_to(engine.branch_.position + 1, outcome);
  }

  static Status check_begin_branch(const Engine& engine, const BeginBranch& request, std::uint8_t) {
    constexpr std::size_t k_longest = 40;
    const std::string& name = request.name;
    const auto is_control = [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; };
    const auto letters = static_cast<std::size_t>(
        std::count_if(name.begin(), name.end(), [](char c) { return (c & 0xc0) != 0x80; }));
    if (name.empty() || letters > k_longest || std::any_of(name.begin(), name.end(), is_control))
      return Error{.what = "the name of the branch is invalid",
                   .where = "begin-branch name",
                   .found = name,
                   .expected = "1 to " + std::to_string(k_longest) + " letters on one line",
                   .remedy = name.empty() ? "enter a name" : "choose a shorter name on one line"};
    const std::vector<Branch>& others = engine.other_branches_;
    if (name == engine.branch_.name || find_branch(others, name) != others.end())
      return Error{.what = "the branch already exists",
                   .where = "begin-branch name",
                   .found = name,
                   .expected = "a name that no branch has",
                   .remedy = "choose another name"};
    if (others.size() + 1 >= Engine::k_max_branches)
      return Error{.what = "too many branches",
                   .where = "begin-branch",
                   .found = std::to_string(others.size() + 1),
                   .expected = "fewer than " + std::to_string(Engine::k_max_branches),
                   .remedy = "continue on an existing branch"};
    return std::nullopt;
  }
  static void begin_branch(Engine& engine, const BeginBranch& request, std::uint8_t, Outcome&) {
    engine.end_stroke();
    engine.other_branches_.push_back(engine.branch_);
    engine.branch_.name = request.name;
    engine.branch_.history.resize(engine.branch_.position + 1);
    ++engine.state_.edits;  // makes jobs in progress outdated: they began on the previous branch
  }

  static Status check_switch_branch(const Engine& engine, const SwitchBranch& request, std::uint8_t) {
    const std::vector<Branch>& others = engine.other_branches_;
    const auto found = find_branch(others, request.name);
    if (found != others.end()) return check_entry(engine, *found->history[found->position]);
    std::string known;
    for (const Branch& one : others) known += (known.empty() ? "" : ", ") + one.name;
    return Error{
        .what = request.name == engine.branch_.name ? "this branch is already active" : "unknown branch",
        .where = "switch-branch name",
        .found = request.name,
        .expected = known.empty() ? "no other branch exists" : "one of " + known};
  }
  static void switch_branch(Engine& engine, const SwitchBranch& request, std::uint8_t, Outcome& outcome) {
    engine.end_stroke();
    Branch& current = engine.branch_;
    Branch& target = *find_branch(engine.other_branches_, request.name);
    // Box of all changes on both branches since their last common entry.
    volume::VoxelBox box = k_no_voxels;
    const auto add = [&box](const Branch& branch, const Branch& reference) {
      for (std::size_t i = 0; i <= branch.position; ++i) {
        const bool is_common = branch.final_strokes == reference.final_strokes && i <= reference.position &&
                               branch.history[i]->number == reference.history[i]->number;
        if (!is_common) box = union_of(box, branch.history[i]->box);
      }
    };
    add(current, target);
    add(target, current);
    if (current.final_strokes != target.final_strokes) box = union_of(box, engine.ever_cut_);
    std::swap(current, target);
    engine.go_to(*current.history[current.position], box, outcome);
  }

  static void resume(Engine& engine, const Resume&, std::uint8_t, Outcome& outcome) {
    engine.end_stroke();
    engine.release_all_bodies(outcome);
    // Poses are outdated: devices may have moved.
    for (HandWork& hand : engine.work_) hand.instrument_ball.reset(), hand.placement.reset();
  }
};

std::span<const CoreCommand> history_commands() noexcept {
  using Group = HistoryCommands;
  constexpr CoreCommand k_history{.step_rule = StepRule::every_step, .causes_transitions = false};
  static const std::array all{
      core_command<Undo, &Group::undo, &Group::check_undo>(k_history),
      core_command<Redo, &Group::redo, &Group::check_redo>(k_history),
      core_command<BeginBranch, &Group::begin_branch, &Group::check_begin_branch>(k_history),
      core_command<SwitchBranch, &Group::switch_branch, &Group::check_switch_branch>(k_history),
      core_command<Note, nullptr>({.step_rule = StepRule::every_step}),
      core_command<Resume, &Group::resume>(
          {.is_for_users = false, .is_guarded = false, .causes_transitions = false})};
  return all;
}

/// Returns the history entry that an undo, a redo or a switch of branches would restore. Null if the command
/// restores no entry.
const HistoryEntry* Engine::target_of(const Command& command) const {
  if (command.request.as<Undo>()) return HistoryCommands::undo_target(*this);
  if (command.request.as<Redo>()) return HistoryCommands::redo_target(*this);
  const auto* request = command.request.as<SwitchBranch>();
  if (request == nullptr) return nullptr;
  const auto found = find_branch(other_branches_, request->name);
  return found == other_branches_.end() ? nullptr : found->history[found->position].get();
}

/// Adds the current state as the newest entry of the history; discards undone entries.
void Engine::add_entry(const volume::VoxelBox& box) {
  branch_.history.erase(branch_.history.begin() + static_cast<std::ptrdiff_t>(branch_.position) + 1,
                        branch_.history.end());
  branch_.history.push_back(make_entry(box));
  if (++branch_.position <= k_max_strokes) return;
  branch_.history.erase(branch_.history.begin());
  --branch_.position;
  ++branch_.final_strokes;
}

EntryState Engine::current_entry_state() const {
  EntryState state{state_.undoable, {}};
  for (const TouchFields& fields : fields_) state.fields.emplace_back(fields.scene(), fields.keep());
  return state;
}

std::shared_ptr<const HistoryEntry> Engine::make_entry(const volume::VoxelBox& box) {
  return std::make_shared<const HistoryEntry>(HistoryEntry{++last_entry_, box, current_entry_state()});
}

void Engine::go_to(std::size_t position, Outcome& outcome) {
  const std::size_t from = std::exchange(branch_.position, position);
  go_to(*branch_.history[position], branch_.history[std::max(position, from)]->box, outcome);
}

/// Restores an entry of the history. `box`: voxels that may look different in the restored state.
void Engine::go_to(const HistoryEntry& entry, const volume::VoxelBox& box, Outcome& outcome) {
  const EntryState state = entry.state().value();  // valid: HistoryCommands::check_entry() has checked it
  outcome.is_changed = outcome.is_edit = true;
  outcome.box = box;
  editor_.reset(state.undoable.version);
  const std::vector<Body> previous_bodies = std::exchange(state_.undoable, state.undoable).bodies;
  if (has_procedure()) state_.undoable.procedure.first_event = state_.chronicle.size();
  const bool has_bodies = !previous_bodies.empty() || !state_.undoable.bodies.empty();
  // A held body that exists in the restored state stays in its hand: grasps are not undoable.
  for (Body& body : state_.undoable.bodies) {
    body.holder = -1, body.grip = {};
    for (const Body& previous : previous_bodies)
      if (previous.id == body.id) body.holder = previous.holder, body.grip = previous.grip;
  }
  ++state_.edits;
  if (has_bodies) use_bodies(Bodies::changed);
  state_.undoable.version = published_version_ = editor_.publish();
  for (TouchFields& fields : fields_) {
    const auto kept = std::find_if(state.fields.begin(), state.fields.end(),
                                   [&](const auto& one) { return one.first == fields.scene(); });
    // The entry has no fields of a tool that is newer than the entry. Such a tool uses the fields of the
    // uncut anatomy until a job updates them.
    fields.go_back(kept == state.fields.end() ? TouchFields::Kept{{}, ever_cut_} : kept->second, version(),
                   serial() + 1);
  }
  publish(Change::addition);
}

std::size_t Engine::history_bytes() const {
  std::unordered_set<const void*> counted;
  std::size_t bytes = 0;
  const auto add = [&](const Branch& branch) {
    for (const auto& entry : branch.history)
      if (!entry->load && entry->stored.undoable.version)
        bytes += entry->stored.undoable.version->add_bytes(counted);
  };
  add(branch_);
  for (const Branch& one : other_branches_) add(one);
  return bytes + state_.undoable.version->add_bytes(counted);
}

}  // namespace trephine::sim
