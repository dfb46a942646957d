#include "apps/workbench/script_watch.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <glm/geometric.hpp>

#include "apps/workbench/text.h"
#include "modules/catalogue.h"
#include "sim/engine/measurement.h"
#include "volume/base/text.h"

namespace trephine::workbench {

using data_tools::ScriptCommand;
using data_tools::ScriptExpectation;
using data_tools::ScriptPicture;

namespace {

/// Measurements of a hand, in addition to sim::measurement_names(), and the prefixes of measurements whose
/// names contain a place: "open PLACE".
constexpr const char* k_names[] = {"force_n", "strongest_force_n", "torque_nmm", "contact",
                                   "proxy_x", "proxy_y",           "proxy_z"};
constexpr std::string_view k_open = "open ", k_thickness = "thickness_mm ";

const Place* find(const std::vector<Place>& places, std::string_view name) {
  for (const Place& place : places)
    if (place.name == name) return &place;
  return nullptr;
}

/// A name between braces in a caption, with a number of decimals, as in "{force_n:2} N".
struct Slot {
  std::size_t begin = 0, end = 0;  ///< indices of the braces in the caption
  std::string name;
  int digits = 0;
  bool is_valid = true;
};
std::vector<Slot> slots_of(const std::string& caption) {
  std::vector<Slot> slots;
  for (std::size_t at = caption.find('{'); at != std::string::npos; at = caption.find('{', at + 1)) {
    const std::size_t end = caption.find('}', at);
    if (end == std::string::npos) {
      slots.push_back({at, at, caption.substr(at), 0, false});
      break;
    }
    Slot slot{at, end, caption.substr(at + 1, end - at - 1)};
    if (const std::size_t colon = slot.name.rfind(':'); colon != std::string::npos) {
      const char* const text_end = slot.name.data() + slot.name.size();
      const auto read = std::from_chars(slot.name.data() + colon + 1, text_end, slot.digits);
      slot.is_valid = read.ec == std::errc() && read.ptr == text_end && slot.digits >= 0 && slot.digits <= 9;
      slot.name.resize(colon);
    }
    slots.push_back(std::move(slot));
  }
  return slots;
}

/// Checks the place of a measurement such as "open PLACE", which must not be on a body.
Status check_place(const std::string& measurement, const std::vector<Place>& places) {
  const std::string prefix = measurement.substr(0, measurement.find(' ') + 1);
  const Place* const found = find(places, measurement.substr(prefix.size()));
  if (found && found->body == 0) return std::nullopt;
  std::string known;
  for (const Place& place : places)
    if (place.body == 0) known.append(known.empty() ? "" : ", ").append(prefix + place.name);
  return Error{.what = "unknown measurement",
               .found = measurement,
               .expected = known.empty() ? "a place of the anatomy in [[places]]" : known,
               .remedy = known.empty() ? "add the place to [[places]]" : "choose one of these"};
}

std::string one_line_text(const Error& error) {
  std::string text = error.what;
  const auto add = [&text](const char* prefix, const std::string& part) {
    if (!part.empty()) text.append(prefix).append(part);
  };
  add("; found: ", error.found);
  add("; expected: ", error.expected);
  add("; remedy: ", error.remedy);
  return text;
}

}  // namespace

std::vector<std::string> quantity_names() {
  std::vector<std::string> all = sim::measurement_names();
  all.insert(all.end(), std::begin(k_names), std::end(k_names));
  all.push_back(std::string(k_open) + "PLACE");
  all.push_back(std::string(k_thickness) + "PLACE");
  return all;
}

Status check_names(const data_tools::Script& script, const std::vector<Place>& places,
                   const sim::Engine& engine, const std::string& where) {
  const auto check = [&](const std::string& measurement, int line) -> Status {
    Status error;
    if (measurement.starts_with(k_open) || measurement.starts_with(k_thickness)) {
      error = check_place(measurement, places);
    } else if (std::find(std::begin(k_names), std::end(k_names), measurement) == std::end(k_names)) {
      error = sim::check_measurement(measurement, engine, modules::catalogue());
      if (error && measurement.find(' ') == std::string::npos)
        for (const char* name : k_names) error->expected.append(", ").append(name);
    }
    if (error) error->where = where + ", line " + std::to_string(line);
    return error;
  };
  for (const ScriptExpectation& request : script.expectations)
    if (Status error = check(request.what, request.line)) return error;
  for (const ScriptPicture& picture : script.pictures)
    for (const Slot& slot : slots_of(picture.caption)) {
      if (!slot.is_valid)
        return Error{.what = "invalid caption",
                     .where = where + ", line " + std::to_string(picture.line),
                     .found = picture.caption.substr(slot.begin, slot.end - slot.begin + 1),
                     .expected = "{name} or {name:digits}, 0 to 9 digits"};
      if (Status error = check(slot.name, picture.line)) return error;
    }
  return std::nullopt;
}

bool ScriptReport::is_met() const {
  return std::all_of(checks.begin(), checks.end(), [](const ScriptCheck& check) { return check.is_met; });
}

double ScriptReport::measure(std::string_view name) const {
  for (const sim::Measure& one : measures)
    if (one.name == name) return one.value;
  return std::nan("");
}

ScriptWatch::ScriptWatch(const data_tools::Script& script, const std::vector<Place>& places, double end,
                         PictureTaker take_picture)
    : script_(&script), places_(&places), take_picture_(std::move(take_picture)), end_(end) {
  for (const ScriptExpectation& request : script.expectations) requests_.push_back(&request);
  for (const ScriptPicture& picture : script.pictures) pictures_.push_back(&picture);
  // Checks and pictures without a time are due at the end, after all others.
  const auto by_time = [end](const auto* a, const auto* b) {
    return a->at.value_or(2 * end) < b->at.value_or(2 * end);
  };
  std::stable_sort(requests_.begin(), requests_.end(), by_time);
  std::stable_sort(pictures_.begin(), pictures_.end(), by_time);
  report_.strongest_of.resize(script.hands.size());
  report_.contact_ticks.resize(script.hands.size());
  report_.seconds = end;
}

Status ScriptWatch::tick(double t, std::span<const haptics::ServoRecord> hands, const sim::Engine& engine,
                         const volume::VoxelBox& changed) {
  hands_.assign(hands.begin(), hands.end());
  changed_ = sim::union_of(changed_, changed);
  ++report_.ticks;
  for (std::size_t h = 0; h < hands.size(); ++h) {
    const double force = glm::length(hands[h].force_world);
    report_.strongest_of[h] = std::max(report_.strongest_of[h], force);
    report_.strongest_force_n = std::max(report_.strongest_force_n, force);
    report_.contact_ticks[h] += hands[h].has_contact;
  }
  return take_due(t, {t, hands_, engine, changed_});
}

/// Returns the time (s) at which a check or picture is due. Commands at or before its time that ended later
/// delay it by the same duration; see wait_for().
double ScriptWatch::due(const std::optional<double>& at) const {
  double when = at.value_or(2 * end_);
  for (const auto& [issued_at, done_at] : waits_)
    if (at && issued_at <= *at) when = std::max(when, done_at + *at - issued_at);
  return when;
}

/// Makes the checks and pictures that are due at `t` (s) or before.
Status ScriptWatch::take_due(double t, const ScriptMoment& moment) {
  const auto is_due = [&](const auto& all, std::size_t next) {
    return next < all.size() && due(all[next]->at) <= t;
  };
  for (; is_due(requests_, next_request_); ++next_request_) check(*requests_[next_request_], moment);
  for (; take_picture_ && is_due(pictures_, next_picture_); ++next_picture_) {
    const ScriptPicture& picture = *pictures_[next_picture_];
    Status error = take_picture_(picture, moment, caption_of(picture, moment));
    if (error && error->kind != ErrorKind::refused) return error;
    if (error)  // for example, the picture is of a place on a body that does not exist
      report_.checks.push_back({picture.line, picture.file + " is taken", t, false, one_line_text(*error)});
    changed_ = sim::k_no_voxels;
  }
  return std::nullopt;
}

void ScriptWatch::record_command(const ScriptCommand& command, double t, const Status& refused) {
  if (!refused && !command.refusal) return;
  const std::string reason = refused ? one_line_text(*refused) : "the command was carried out";
  std::string request = command.name + (command.refusal ? " is refused" : " is done");
  if (command.refusal && !command.refusal->empty()) request += ": " + *command.refusal;
  const bool is_met = refused && command.refusal && reason.find(*command.refusal) != std::string::npos;
  report_.checks.push_back({command.line, std::move(request), t, is_met, reason});
}

void ScriptWatch::check(const ScriptExpectation& request, const ScriptMoment& moment) {
  // A value that was never measured, or is stale because of a later cut, meets no limits.
  const std::optional<double> value = value_of(request.what, request.hand, moment, false);
  std::string words = request.what;
  if (request.minimum) words = text_of(*request.minimum) + " <= " + words;
  if (request.maximum) words += " <= " + text_of(*request.maximum);
  const bool is_met =
      value && *value >= request.minimum.value_or(*value) && *value <= request.maximum.value_or(*value);
  report_.checks.push_back(
      {request.line, words, moment.t, is_met,
       value ? text_of(*value) : "no value: it was not measured, or a later cut made it stale"});
}

std::optional<double> ScriptWatch::value_of(const std::string& measurement, int hand,
                                            const ScriptMoment& moment, bool accepts_stale) const {
  const sim::Engine& engine = moment.engine;
  const auto h = static_cast<std::size_t>(hand);
  const haptics::ServoRecord& record = moment.hands[h];
  if (measurement == "force_n") return glm::length(record.force_world);
  if (measurement == "torque_nmm") return glm::length(record.torque_world);
  if (measurement == "strongest_force_n") return report_.strongest_of[h];
  if (measurement == "contact") return record.has_contact;
  for (int axis = 0; axis < 3; ++axis)
    if (measurement == std::string("proxy_") + "xyz"[axis]) return record.proxy_world[axis];
  if (measurement.starts_with(k_open))
    if (const Place* place = find(*places_, measurement.substr(k_open.size())))
      return is_open(*place, engine.scene(), *engine.version());
  if (measurement.starts_with(k_thickness))
    if (const Place* place = find(*places_, measurement.substr(k_thickness.size()))) return place->thickness;
  return sim::Measurements(engine, {.hand = h, .accepts_stale = accepts_stale}).value_of(measurement);
}

std::string ScriptWatch::caption_of(const ScriptPicture& picture, const ScriptMoment& moment) const {
  std::string caption = picture.caption;
  const std::vector<Slot> slots = slots_of(caption);
  for (auto slot = slots.rbegin(); slot != slots.rend(); ++slot)
    caption.replace(slot->begin, slot->end - slot->begin + 1,
                    format_text("%.*f", slot->digits,
                                value_of(slot->name, picture.hand, moment, true).value_or(std::nan(""))));
  return caption;
}

Result<ScriptReport> ScriptWatch::finish(sim::Engine& engine) {
  if (hands_.size() == script_->hands.size())
    if (Status error = take_due(3 * end_ + 1, {end_, hands_, engine, changed_})) return *error;
  std::stable_sort(report_.checks.begin(), report_.checks.end(),
                   [](const ScriptCheck& a, const ScriptCheck& b) { return a.line < b.line; });
  report_.state = engine.snapshot();
  report_.measures = engine.measures();
  report_.removed_mm3_by_label = engine.removed_mm3_by_label();
  return report_;
}

}  // namespace trephine::workbench
