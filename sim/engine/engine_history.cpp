// Engine: undo, redo and branches.
#include <algorithm>
#include <unordered_set>

#include "sim/engine/engine.h"

namespace trephine::sim {

namespace {

template <class Branches>
auto find_branch(Branches& all, const std::string& name) {
  return std::find_if(all.begin(), all.end(), [&](const Branch& one) { return one.name == name; });
}

}  // namespace

Status Engine::check_branch(const Command& command) const {
  const auto* begin = command.request.as<BeginBranch>();
  const auto* other = command.request.as<SwitchBranch>();
  if (!begin && !other) return std::nullopt;
  const std::string& name = begin ? begin->name : other->name;
  const bool is_there = find_branch(left_branches_, name) != left_branches_.end();
  if (other && !is_there) {
    std::string known;
    for (const Branch& one : left_branches_) known += (known.empty() ? "" : ", ") + one.name;
    return Error{.what = name == branch_.name ? "this branch is already active" : "unknown branch",
                 .where = "switch-branch name",
                 .found = name,
                 .expected = known.empty() ? "there are no others" : "one of " + known};
  }
  if (other) return std::nullopt;
  constexpr std::size_t k_longest = 40;
  const auto letters = static_cast<std::size_t>(
      std::count_if(name.begin(), name.end(), [](char c) { return (c & 0xc0) != 0x80; }));
  const bool is_word = !name.empty() && letters <= k_longest &&
                       std::none_of(name.begin(), name.end(),
                                    [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; });
  if (!is_word)
    return Error{.what = "a branch needs a name",
                 .where = "begin-branch name",
                 .found = name,
                 .expected = "1 to " + std::to_string(k_longest) + " letters on one line"};
  if (is_there || name == branch_.name)
    return Error{.what = "the branch already exists",
                 .where = "begin-branch name",
                 .found = name,
                 .expected = "another name"};
  if (left_branches_.size() + 1 >= k_max_branches)
    return Error{.what = "too many branches",
                 .where = "begin-branch",
                 .found = std::to_string(left_branches_.size() + 1),
                 .expected = "at most " + std::to_string(k_max_branches)};
  return std::nullopt;
}

/// Checks that the history entry to which the command leads can be read.
Status Engine::check_target_entry(const Command& command) const {
  std::size_t target = branch_.position;
  if (command.request.as<Undo>() && can_undo())
    target -= is_stroke_changed_ ? 0 : 1;  // the stroke will end first
  else if (command.request.as<Redo>() && can_redo() && !is_stroke_changed_)
    ++target;
  else if (const auto* request = command.request.as<SwitchBranch>())
    return check_entry(*[&] {
      const Branch& branch = *find_branch(left_branches_, request->name);
      return branch.history[branch.position];
    }());
  else
    return std::nullopt;
  return check_entry(*branch_.history[target]);
}

Status Engine::check_entry(const HistoryEntry& entry) const {
  const Result<EntryState> state = entry.state();
  if (!state) return state.error();
  return state.value().world.bodies.empty() ? Status() : check_room_for_bodies();
}

/// Returns false for other commands.
bool Engine::change_branch(const Command& command, Outcome& outcome) {
  const Value& request = command.request;
  if (request.as<Undo>()) {
    end_stroke();
    if (branch_.position > 0) {
      ++now_.chronicle.undos;
      go_to(branch_.position - 1, outcome);
    }
  } else if (request.as<Redo>()) {
    end_stroke();
    if (can_redo()) {
      ++now_.chronicle.redos;
      go_to(branch_.position + 1, outcome);
    }
  } else if (const auto* begin = request.as<BeginBranch>()) {
    end_stroke();
    left_branches_.push_back(branch_);
    branch_.name = begin->name;
    branch_.history.resize(branch_.position + 1);
    ++now_.edits;  // results of earlier jobs belong to the previous branch
  } else if (const auto* other = request.as<SwitchBranch>()) {
    end_stroke();
    Branch& target = *find_branch(left_branches_, other->name);
    // All changes on both branches since their last common entry.
    volume::VoxelBox box = k_no_voxels;
    const auto add = [&box](const Branch& branch, const Branch& reference) {
      for (std::size_t i = 0; i <= branch.position; ++i) {
        const bool is_common = branch.forgotten == reference.forgotten && i <= reference.position &&
                               branch.history[i]->number == reference.history[i]->number;
        if (!is_common) box = united(box, branch.history[i]->box);
      }
    };
    add(branch_, target);
    add(target, branch_);
    if (branch_.forgotten != target.forgotten) box = united(box, ever_cut_);
    std::swap(branch_, target);
    go_to(*branch_.history[branch_.position], box, outcome);
  } else {
    return false;
  }
  return true;
}

/// Adds the current state as the newest entry of the history; discards undone entries.
void Engine::add_entry(const volume::VoxelBox& box) {
  branch_.history.erase(branch_.history.begin() + static_cast<std::ptrdiff_t>(branch_.position) + 1,
                        branch_.history.end());
  branch_.history.push_back(make_entry(box));
  if (++branch_.position <= k_max_strokes) return;
  branch_.history.erase(branch_.history.begin());
  --branch_.position;
  ++branch_.forgotten;
}

EntryState Engine::current_entry_state() const {
  EntryState state{now_.world, {}};
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

/// `box`: voxels that look different there.
void Engine::go_to(const HistoryEntry& entry, const volume::VoxelBox& box, Outcome& outcome) {
  const EntryState state = entry.state().value();  // read by check_target_entry()
  outcome.is_changed = outcome.is_edit = true;
  outcome.box = box;
  editor_.reset(state.world.version);
  const std::vector<Body> previous_bodies = std::exchange(now_.world, state.world).bodies;
  const bool has_bodies = !previous_bodies.empty() || !now_.world.bodies.empty();
  // A held body stays in its hand, if it exists in that state: grasps are not undoable.
  for (Body& body : now_.world.bodies) {
    body.holder = -1, body.grip = {};
    for (const Body& previous : previous_bodies)
      if (previous.id == body.id) body.holder = previous.holder, body.grip = previous.grip;
  }
  ++now_.edits;
  if (has_bodies) use_bodies(Bodies::others);
  now_.world.version = published_version_ = editor_.publish();
  for (TouchFields& fields : fields_) {
    const auto kept = std::find_if(state.fields.begin(), state.fields.end(),
                                   [&](const auto& one) { return one.first == fields.scene(); });
    // A tool that is newer than the entry has uncut fields, until a job updates them.
    fields.go_back(kept == state.fields.end() ? TouchFields::Kept{{}, ever_cut_} : kept->second, current(),
                   serial() + 1);
  }
  publish(Change::addition);
}

std::size_t Engine::history_bytes() const {
  std::unordered_set<const void*> counted;
  std::size_t bytes = 0;
  const auto add = [&](const Branch& branch) {
    for (const auto& entry : branch.history)
      if (!entry->load && entry->stored.world.version)
        bytes += entry->stored.world.version->add_bytes(counted);
  };
  add(branch_);
  for (const Branch& one : left_branches_) add(one);
  return bytes + now_.world.version->add_bytes(counted);
}

}  // namespace trephine::sim
