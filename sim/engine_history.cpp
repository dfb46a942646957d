// Back and forth: strokes and commands that are taken back, and branches.
#include <algorithm>
#include <unordered_set>

#include "sim/engine.h"

namespace trephine::sim {

using volume::Error;
using volume::Status;

namespace {

template <class Branches>
auto find_branch(Branches& all, const std::string& name) {
  return std::find_if(all.begin(), all.end(), [&](const Branch& one) { return one.name == name; });
}

}  // namespace

Status Engine::check_branch(const Command& command) const {
  const auto* begin = command.what.as<BeginBranch>();
  const auto* other = command.what.as<SwitchBranch>();
  if (!begin && !other) return std::nullopt;
  const std::string& name = begin ? begin->name : other->name;
  const bool is_there = find_branch(left_branches_, name) != left_branches_.end();
  if (other && !is_there) {
    std::string known;
    for (const Branch& one : left_branches_) known += (known.empty() ? "" : ", ") + one.name;
    return Error{name == branch_.name ? "that is the branch that goes on" : "there is no such branch",
                 "switch-branch name", name, known.empty() ? "there are no others" : "one of " + known, ""};
  }
  if (other) return std::nullopt;
  constexpr std::size_t k_longest = 40;
  const auto letters = static_cast<std::size_t>(
      std::count_if(name.begin(), name.end(), [](char c) { return (c & 0xc0) != 0x80; }));
  const bool is_word = !name.empty() && letters <= k_longest &&
                       std::none_of(name.begin(), name.end(),
                                    [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; });
  if (!is_word)
    return Error{"a branch needs a name", "begin-branch name", name,
                 "1 to " + std::to_string(k_longest) + " letters on one line", ""};
  if (is_there || name == branch_.name)
    return Error{"there is a branch of that name", "begin-branch name", name, "another name", ""};
  if (left_branches_.size() + 1 >= k_most_branches)
    return Error{"there are branches enough", "begin-branch", std::to_string(left_branches_.size() + 1),
                 "at most " + std::to_string(k_most_branches), ""};
  return std::nullopt;
}

/// Can the place be read that the command leads to?
Status Engine::check_way_back(const Command& command) const {
  std::size_t to = branch_.position;
  if (command.what.as<Undo>() && can_undo())
    to -= is_stroke_changed_ ? 0 : 1;  // the stroke will end first
  else if (command.what.as<Redo>() && can_redo() && !is_stroke_changed_)
    ++to;
  else if (const auto* request = command.what.as<SwitchBranch>())
    return check_place(*[&] {
      const Branch& branch = *find_branch(left_branches_, request->name);
      return branch.history[branch.position];
    }());
  else
    return std::nullopt;
  return check_place(*branch_.history[to]);
}

Status Engine::check_place(const HistoryEntry& entry) const {
  const volume::Result<HistoryPlace> place = entry.place();
  if (!place) return place.error();
  return place.value().world.bodies.empty() ? Status() : check_room_for_bodies();
}

/// False: the command is about something else.
bool Engine::change_branch(const Command& command, Outcome& outcome) {
  const Value& what = command.what;
  if (what.as<Undo>()) {
    end_stroke();
    if (branch_.position > 0) {
      ++now_.chronicle.undos;
      go_to(branch_.position - 1, outcome);
    }
  } else if (what.as<Redo>()) {
    end_stroke();
    if (can_redo()) {
      ++now_.chronicle.redos;
      go_to(branch_.position + 1, outcome);
    }
  } else if (const auto* begin = what.as<BeginBranch>()) {
    end_stroke();
    left_branches_.push_back(branch_);
    branch_.name = begin->name;
    branch_.history.resize(branch_.position + 1);
    ++edits_;  // what a job makes of before belongs there
  } else if (const auto* other = what.as<SwitchBranch>()) {
    end_stroke();
    Branch& there = *find_branch(left_branches_, other->name);
    // All that was done on either since they went apart.
    volume::VoxelBox box = k_no_voxels;
    const auto add = [&box](const Branch& one, const Branch& from) {
      for (std::size_t i = 0; i <= one.position; ++i) {
        const bool is_common = one.forgotten == from.forgotten && i <= from.position &&
                               one.history[i]->number == from.history[i]->number;
        if (!is_common) box = united(box, one.history[i]->box);
      }
    };
    add(branch_, there);
    add(there, branch_);
    if (branch_.forgotten != there.forgotten) box = united(box, ever_cut_);
    std::swap(branch_, there);
    go_to(*branch_.history[branch_.position], box, outcome);
  } else {
    return false;
  }
  return true;
}

/// The world as it is now becomes the newest place of the history; what was undone is gone for good.
void Engine::remember(const volume::VoxelBox& box) {
  branch_.history.erase(branch_.history.begin() + static_cast<std::ptrdiff_t>(branch_.position) + 1,
                        branch_.history.end());
  branch_.history.push_back(entry_here(box));
  if (++branch_.position <= k_most_strokes) return;
  branch_.history.erase(branch_.history.begin());
  --branch_.position;
  ++branch_.forgotten;
}

HistoryPlace Engine::here() const {
  HistoryPlace place{now_.world, {}};
  for (const TouchFields& fields : fields_) place.fields.emplace_back(fields.scene(), fields.keep());
  return place;
}

std::shared_ptr<const HistoryEntry> Engine::entry_here(const volume::VoxelBox& box) {
  return std::make_shared<const HistoryEntry>(HistoryEntry{++last_entry_, box, here()});
}

void Engine::go_to(std::size_t position, Outcome& outcome) {
  const std::size_t from = std::exchange(branch_.position, position);
  go_to(*branch_.history[position], branch_.history[std::max(position, from)]->box, outcome);
}

/// `box`: what looks different there.
void Engine::go_to(const HistoryEntry& place, const volume::VoxelBox& box, Outcome& outcome) {
  const HistoryPlace entry = place.place().value();  // which check_way_back() has seen
  outcome.is_changed = outcome.is_edit = true;
  outcome.box = box;
  editor_.reset(entry.world.version);
  const std::vector<Body> before = std::exchange(now_.world, entry.world).bodies;
  const bool has_bodies = !before.empty() || !now_.world.bodies.empty();
  // A held body stays in its hand, if it is there at all then: holding is of the moment.
  for (Body& body : now_.world.bodies) {
    body.holder = -1, body.grip = {};
    for (const Body& was : before)
      if (was.id == body.id) body.holder = was.holder, body.grip = was.grip;
  }
  ++edits_;
  if (has_bodies) use_bodies(Bodies::others);
  now_.world.version = published_version_ = editor_.publish();
  for (TouchFields& fields : fields_) {
    const auto kept = std::find_if(entry.fields.begin(), entry.fields.end(),
                                   [&](const auto& one) { return one.first == fields.scene(); });
    // A tool that came later: as if nothing had been cut, until a job updates it.
    fields.go_back(kept == entry.fields.end() ? TouchFields::Kept{{}, ever_cut_} : kept->second, current(),
                   serial() + 1);
  }
  publish(Change::growth);
}

std::size_t Engine::history_bytes() const {
  std::unordered_set<const void*> seen;
  std::size_t bytes = 0;
  const auto add = [&](const Branch& branch) {
    for (const auto& entry : branch.history)
      if (!entry->load && entry->here.world.version) bytes += entry->here.world.version->add_bytes(seen);
  };
  add(branch_);
  for (const Branch& one : left_branches_) add(one);
  return bytes + now_.world.version->add_bytes(seen);
}

}  // namespace trephine::sim
