#include "apps/workbench/event_text.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <utility>

#include "apps/workbench/text.h"
#include "haptics/force/faults.h"
#include "modules/bone_flap/bone_flap.h"
#include "modules/bone_flap/judgement.h"
#include "modules/cross_section/cross_section.h"
#include "modules/drilling/craniotome.h"
#include "modules/drilling/perforator.h"
#include "modules/fluoroscopy/fluoroscopy.h"
#include "modules/laminectomy/laminectomy.h"
#include "modules/measurement/measurement.h"
#include "modules/pedicle/pedicle.h"
#include "modules/rongeur/rongeur.h"
#include "modules/skull_clamp/skull_clamp.h"
#include "modules/ventriculostomy/ventriculostomy.h"
#include "sim/api/forbidden.h"

namespace trephine::workbench {

namespace {

using Level = EventLevel;

/// Returns the direction in which a tool or a screw exits the bone: "toward the canal".
std::string wall_text(pedicle::Wall wall) {
  switch (wall) {
    case pedicle::Wall::medial:
      return "toward the canal";
    case pedicle::Wall::lateral:
      return "to the outer side";
    case pedicle::Wall::above:
      return "toward the head";
    case pedicle::Wall::below:
      return "toward the feet";
    case pedicle::Wall::front:
      return "to the front";
    case pedicle::Wall::none:
      break;
  }
  return "inside bone";
}

/// A latched fault has the level of a record, because a window displays the fault as long as it lasts.
EventText text_of(const sim::FaultEvent& e) {
  if (e.is_cleared) return {"The force is on again.", Level::record};
  std::uint32_t faults = 0;
  for (const std::uint32_t bit : {haptics::fault_lost_device, haptics::fault_not_finite,
                                  haptics::fault_full_ring, haptics::fault_stale_scene})
    if (e.names.find(haptics::fault_names(bit)) != std::string::npos) faults |= bit;
  return {"The force is off: " + (faults == 0 ? e.names : fault_reasons(faults)) + ".", Level::record};
}
EventText text_of(const sim::JobDiscarded& e) {
  return {"A computation was not finished: " + e.reason + ".", Level::refusal};
}
/// The entry has the level of a record, because a window displays the structure while the tool is in it, and
/// ForbiddenLeft reports the result.
EventText text_of(const sim::ForbiddenEntered& e) {
  return {"The tool reached the " + words_of(e.structure) + (e.is_working ? " while it was running." : "."),
          Level::record};
}
/// StructureTorn states the depth at which a structure tore; this event states the greatest depth.
EventText text_of(const sim::ForbiddenLeft& e) {
  return {format_text("The tool left the %s after %.1f s, at most %.2f mm deep.",
                      words_of(e.structure).c_str(), e.seconds, e.deepest),
          e.deepest > sim::k_blunt_tear_depth ? Level::danger : Level::record};
}
EventText text_of(const sim::StructureStripped& e) {
  return {format_text("The %s was pushed aside by %.2f mm and did not tear.", words_of(e.structure).c_str(),
                      e.deepest),
          Level::outcome};
}
EventText text_of(const sim::StructureTouched& e) {
  return {format_text("The running tool touched the %s, %.2f mm deep, and did not tear it.",
                      words_of(e.structure).c_str(), e.deepest),
          Level::danger};
}
EventText text_of(const sim::StructureTorn& e) {
  return {
      format_text("The tool tore the %s at a depth of %.2f mm.", words_of(e.structure).c_str(), e.deepest),
      Level::danger};
}
EventText text_of(const sim::BodyAdded& e) {
  return {format_text("Implant %u added, %.0f mm³.", e.body.value, e.size), Level::outcome};
}
EventText text_of(const sim::PieceFreed& e) {
  return {format_text("Piece %u detached, %.0f mm³.", e.body.value, e.size), Level::outcome};
}
EventText text_of(const sim::DebrisFreed& e) {
  return {format_text("%lld small part%s removed as debris, %.1f mm³.", static_cast<long long>(e.count),
                      e.count == 1 ? "" : "s", e.size),
          Level::record};
}
/// Returns the title of a step in quotes; its name if it has no title.
std::string step_words(const volume::SurgicalProcedure& procedure, const std::string& name) {
  const int step = procedure.find(name);
  if (step < 0 || procedure.steps[static_cast<std::size_t>(step)].title.empty()) return words_of(name);
  return "\"" + procedure.steps[static_cast<std::size_t>(step)].title + "\"";
}
EventText text_of(const sim::StepEntered& e, const volume::SurgicalProcedure& procedure = {}) {
  return {"The step " + step_words(procedure, e.step) + " began.", Level::outcome};
}
EventText text_of(const sim::StepRefused& e, const volume::SurgicalProcedure& procedure = {}) {
  // The reason of sim::Engine::check_held().
  constexpr std::string_view k_held = "a hand holds an instrument that the step ", k_end = " does not allow";
  if (const std::size_t end = e.reason.find(k_end); e.reason.starts_with(k_held) && end != std::string::npos)
    return {
        format_text("%s was refused: the step %s does not allow the tool in the hand. Choose No tool first.",
                    words_of(e.request).c_str(),
                    step_words(procedure, e.reason.substr(k_held.size(), end - k_held.size())).c_str()),
        Level::refusal};
  return {format_text("%s was refused in the step %s: %s.", words_of(e.request).c_str(),
                      step_words(procedure, e.step).c_str(), with_step_titles(e.reason, procedure).c_str()),
          Level::refusal};
}
EventText text_of(const bone_flap::FlapCut& e) {
  return {format_text("Bone flap of %.1f cm² cut, %.0f mm³; the saw removed %.0f mm³.", e.area / 100,
                      e.flap_size, e.kerf_size),
          Level::outcome};
}
EventText text_of(const bone_flap::FlapPiece& e) {
  return {format_text("Piece %lld of the flap: %.0f mm³, %s.", static_cast<long long>(e.number), e.size,
                      e.is_detached ? "detached" : "left in place"),
          Level::record};
}
EventText text_of(const bone_flap::FlapPreviewed& e) {
  return {(e.area > 0 ? "Preview: " : "Preview: no flap. ") + e.summary,
          e.area > 0 ? Level::outcome : Level::refusal};
}
EventText text_of(const bone_flap::FlapJudged& e) {
  std::string text = format_text("Flap of %.0f by %.0f mm", e.length, e.width);
  if (e.has_target)
    text += format_text("; %.0f %% of %s exposed, margin %.1f mm", e.exposed, words_of(e.target).c_str(),
                        e.margin);
  if (e.has_plan)
    text += format_text("; distance from the plan %.1f mm on average, %.1f mm at most", e.plan_mean,
                        e.plan_worst);
  return {text + ".", Level::outcome};
}
EventText text_of(const bone_flap::FlapClearance& e) {
  const std::string name = words_of(e.structure);
  return {e.is_stripped ? format_text("The saw's foot stripped the %s off the bone.", name.c_str())
          : e.distance < 0
              ? format_text("The saw cut %.1f mm into the %s.", -e.distance, name.c_str())
              : format_text("The saw stayed %.1f mm or more from the %s.", e.distance, name.c_str()),
          Level::record};
}
EventText text_of(const bone_flap::FlapFailed& e) { return {"No bone flap: " + e.reason, Level::refusal}; }
EventText text_of(const cross_section::SectionMeasured& e) {
  return {format_text("Section: bone %.1f mm², models %.1f mm², of which %.1f mm² outside bone.", e.bone,
                      e.models, e.outside),
          Level::outcome};
}
EventText text_of(const measurement::Measured& e) {
  if (!e.problem.empty()) return {"Not measured: " + e.problem, Level::refusal};
  return {"Measured: " + measurement::words_of(e) + ".", Level::outcome};
}
EventText text_of(const fluoroscopy::XrayTaken& e) {
  return {format_text("X-ray %lld: C-arm %.0f° %s, %.0f° %s, %.1f mGy cm².", static_cast<long long>(e.number),
                      std::abs(e.primary), e.primary < 0 ? "RAO" : "LAO", std::abs(e.secondary),
                      e.secondary < 0 ? "caudal" : "cranial", e.area_product),
          Level::record};
}
EventText text_of(const laminectomy::Judgement& e) {
  return {format_text("%s: canal %.0f mm² (%.0f mm² before), its roof open along %.0f mm.",
                      e.vertebra.empty() ? "Vertebra" : e.vertebra.c_str(), e.canal_after, e.canal_before,
                      e.opened_length),
          Level::outcome};
}
EventText text_of(const laminectomy::JudgementFailed& e) {
  return {(e.vertebra.empty() ? "The laminectomy" : "Vertebra " + e.vertebra) +
              " was not judged: " + e.reason + (e.reason.ends_with('.') ? "" : "."),
          Level::refusal};
}
EventText text_of(const drilling::Breakthrough& e) {
  return {format_text("The burr broke through at a thrust of %.1f N and plunged %.1f mm in %.2f s.", e.thrust,
                      e.plunge, e.seconds),
          Level::outcome};
}
EventText text_of(const drilling::PerforatorStopped& e) {
  if (e.was_open)
    return {"The hole here is through the bone already: the clutch does not engage. Widen it with a burr.",
            Level::refusal};
  return {format_text("The clutch released after %.1f mm of bone.", e.depth), Level::outcome};
}
EventText text_of(const drilling::CraniotomeRefused& e) {
  return {"The craniotome did not cut: " + e.reason, Level::refusal};
}
EventText text_of(const rongeur::Bite& e) {
  return {format_text("Bite of %.0f mm³.", e.size), Level::outcome};
}
EventText text_of(const rongeur::BiteRefused& e) { return {"No bite: " + e.reason, Level::refusal}; }
EventText text_of(const pedicle::ProbeEntered&) { return {"The probe entered bone.", Level::record}; }
EventText text_of(const pedicle::ProbeOut& e) {
  const std::string text = format_text("The probe left %s at a depth of %.1f mm, %s.",
                                       e.label.empty() ? "the bone" : words_of(e.label).c_str(), e.depth,
                                       wall_text(e.wall).c_str());
  if (!e.label.empty()) return {text, Level::danger};
  return {text + " The scan has no labels: soft bone below the threshold also counts as outside.",
          Level::refusal};
}
EventText text_of(const pedicle::ProbeIn& e) {
  return {format_text("The probe is in bone again, %.1f mm deep.", e.depth), Level::outcome};
}
EventText text_of(const pedicle::TrackMade& e) {
  std::string text = format_text("Track of %.1f mm", e.depth);
  if (e.outside > 0) text += format_text(", %.1f mm of it beyond the bone", e.outside);
  return {text + ".", Level::outcome};
}
constexpr double k_length_difference = 2;  // mm; larger differences of screw and track are reported
EventText text_of(const pedicle::ScrewPlaced& e) {
  std::string text =
      format_text("Screw %u placed: %.1f mm in diameter, %.0f mm long.", e.body.value, e.diameter, e.length);
  if (e.beyond_track > k_length_difference)
    text += format_text(" It is %.0f mm longer than its track.", e.beyond_track);
  return {text, Level::outcome};
}
EventText text_of(const pedicle::ScrewFailed& e) {
  return {"The screw was not placed: " + e.reason + ".", Level::refusal};
}
EventText text_of(const pedicle::ScrewJudged& e) {
  const auto grade = [](pedicle::Grade one) {
    return std::string(pedicle::k_grade_names[static_cast<std::size_t>(one)]);
  };
  std::string text = std::string(pedicle::k_side_names[static_cast<std::size_t>(e.side)]) + " screw" +
                     (e.vertebra.empty() ? "" : " in " + e.vertebra) + ": grade " + grade(e.grade);
  text += e.breach > 0 ? format_text(", breach of %.1f mm %s", e.breach, wall_text(e.wall).c_str())
                       : ", no breach";
  if (e.front > 0) text += format_text(", %.1f mm in front of the bone", e.front);
  if (e.is_uncertain)
    text += ". At this voxel size, grades " + grade(e.grade_of_larger) + " to " + grade(e.grade_of_smaller) +
            " are possible";
  if (e.has_score)
    text += format_text(". Entry %.1f mm, tip %.1f mm from the plan; %.0f of 100 points", e.entry_error,
                        e.target_error, e.score);
  if (e.has_track && std::abs(e.depth_error) > k_length_difference)
    text += format_text(". The screw is %.0f mm %s than its track", std::abs(e.depth_error),
                        e.depth_error > 0 ? "longer" : "shorter");
  return {text + ".", e.grade >= pedicle::Grade::c ? Level::danger : Level::outcome};
}
EventText text_of(const pedicle::ScrewNotJudged& e) {
  return {"The screw was not judged: " + e.reason + ".", Level::refusal};
}
EventText text_of(const ventriculostomy::CatheterEntered&) {
  return {"The catheter reached the dura.", Level::record};
}
EventText text_of(const ventriculostomy::CatheterPopped& e) {
  return {format_text("The catheter popped into %s, %.0f mm below the outer surface of the dura.",
                      words_of(e.structure).c_str(), e.depth),
          Level::outcome};
}
EventText text_of(const ventriculostomy::CatheterWithdrawn& e) {
  return {
      format_text(
          "The catheter was drawn out of the head. Its tip was %.0f mm below the outer surface of the dura.",
          e.depth),
      Level::record};
}
EventText text_of(const ventriculostomy::CatheterRefused& e) {
  return {"The catheter did not enter: " + e.reason, Level::refusal};
}
EventText text_of(const ventriculostomy::CatheterJudged& e) {
  std::string text = e.ventricle.empty() ? "The tip of the catheter is outside the ventricles"
                                         : "The tip of the catheter is in " + words_of(e.ventricle);
  if (e.has_plan)
    text += format_text("; compared with %s: %.1f mm from its target, entry %.1f mm from the plan",
                        words_of(e.trajectory).c_str(), e.target_error, e.entry_error);
  if (e.has_table) text += format_text("; %.0f mm below the outer table", e.depth_from_table);
  return {text + ".", e.clearance < 0       ? Level::danger
                      : e.ventricle.empty() ? Level::refusal
                                            : Level::outcome};
}
EventText text_of(const ventriculostomy::CatheterClearance& e) {
  const std::string name = words_of(e.structure);
  if (e.distance < 0)
    return {format_text("%.1f mm of the catheter are in %s, up to %.1f mm deep.", e.length, name.c_str(),
                        -e.distance),
            Level::danger};
  if (e.distance >= sim::Forbidden::k_reach)
    return {format_text("The catheter is more than 20 mm away from %s.", name.c_str()), Level::record};
  return {format_text("The catheter is %.1f mm away from %s.", e.distance, name.c_str()), Level::record};
}
EventText text_of(const ventriculostomy::CatheterLeftInPlace& e) {
  return {
      format_text("The catheter was left in place, %.0f mm below the outer surface of the dura.", e.depth),
      Level::record};
}
EventText text_of(const ventriculostomy::CatheterNotLeft& e) {
  return {"The catheter was not left in place: " + e.reason + ".", Level::refusal};
}
EventText text_of(const ventriculostomy::CatheterCrossed& e) {
  return {format_text("The path of the catheter crosses %.1f mm of %s (in the scan before the operation).",
                      e.length, words_of(e.structure).c_str()),
          e.is_forbidden ? Level::danger : Level::record};
}
EventText text_of(const skull_clamp::ClampFitted& e) {
  std::string text = format_text("Clamp fitted: open %.0f mm, its axis %.1f mm from the centre of the skull",
                                 e.opening, e.axis_miss);
  if (!e.trouble.empty()) text += "; " + e.trouble;
  return {text + ".", e.trouble.empty() ? Level::outcome : Level::danger};
}
EventText text_of(const skull_clamp::ClampTouchesHead& e) {
  return {format_text(
              "The clamp touches the head: %.0f mm of its arms are inside the head, at most %.0f mm deep.",
              e.length, e.depth),
          Level::danger};
}
EventText text_of(const skull_clamp::ClampFailed& e) {
  return {"The clamp was not fitted: " + e.reason + ".", Level::refusal};
}

struct Row {
  const sim::ValueType* type;
  EventText (*describe)(const sim::Value& what);
};

template <class E>
Row row() {
  return {&sim::value_type<E>(), [](const sim::Value& what) { return text_of(*what.as<E>()); }};
}

const auto& rows() {
  static const std::array k_rows{row<sim::FaultEvent>(),
                                 row<sim::JobDiscarded>(),
                                 row<sim::ForbiddenEntered>(),
                                 row<sim::ForbiddenLeft>(),
                                 row<sim::StructureStripped>(),
                                 row<sim::StructureTouched>(),
                                 row<sim::StructureTorn>(),
                                 row<sim::PieceFreed>(),
                                 row<sim::BodyAdded>(),
                                 row<sim::DebrisFreed>(),
                                 row<sim::StepEntered>(),
                                 row<sim::StepRefused>(),
                                 row<bone_flap::FlapCut>(),
                                 row<bone_flap::FlapPiece>(),
                                 row<bone_flap::FlapPreviewed>(),
                                 row<bone_flap::FlapFailed>(),
                                 row<bone_flap::FlapJudged>(),
                                 row<bone_flap::FlapClearance>(),
                                 row<cross_section::SectionMeasured>(),
                                 row<measurement::Measured>(),
                                 row<fluoroscopy::XrayTaken>(),
                                 row<laminectomy::Judgement>(),
                                 row<laminectomy::JudgementFailed>(),
                                 row<drilling::Breakthrough>(),
                                 row<drilling::PerforatorStopped>(),
                                 row<drilling::CraniotomeRefused>(),
                                 row<pedicle::ProbeEntered>(),
                                 row<pedicle::ProbeOut>(),
                                 row<pedicle::ProbeIn>(),
                                 row<pedicle::TrackMade>(),
                                 row<pedicle::ScrewPlaced>(),
                                 row<pedicle::ScrewFailed>(),
                                 row<pedicle::ScrewJudged>(),
                                 row<pedicle::ScrewNotJudged>(),
                                 row<rongeur::Bite>(),
                                 row<rongeur::BiteRefused>(),
                                 row<ventriculostomy::CatheterEntered>(),
                                 row<ventriculostomy::CatheterPopped>(),
                                 row<ventriculostomy::CatheterWithdrawn>(),
                                 row<ventriculostomy::CatheterRefused>(),
                                 row<ventriculostomy::CatheterJudged>(),
                                 row<ventriculostomy::CatheterCrossed>(),
                                 row<ventriculostomy::CatheterClearance>(),
                                 row<ventriculostomy::CatheterLeftInPlace>(),
                                 row<ventriculostomy::CatheterNotLeft>(),
                                 row<skull_clamp::ClampFitted>(),
                                 row<skull_clamp::ClampTouchesHead>(),
                                 row<skull_clamp::ClampFailed>()};
  return k_rows;
}

const Row* find_row(const sim::ValueType& type) {
  const auto& all = rows();
  const auto it = std::find_if(all.begin(), all.end(), [&](const Row& row) { return row.type == &type; });
  return it == all.end() ? nullptr : &*it;
}

}  // namespace

bool has_event_text(const sim::ValueType& type) { return find_row(type) != nullptr; }

EventText describe_event(const sim::Event& event, const volume::SurgicalProcedure& procedure) {
  EventText result;
  if (const auto* entered = event.value.as<sim::StepEntered>()) {
    result = text_of(*entered, procedure);
  } else if (const auto* refused = event.value.as<sim::StepRefused>()) {
    result = text_of(*refused, procedure);
  } else if (const Row* row = find_row(event.value.type())) {
    result = row->describe(event.value);
  } else {
    const std::string words = event.value.words();
    result.text = std::string(event.value.name()) + (words.empty() ? "" : " " + words);
  }
  if (!result.text.empty() && result.text[0] >= 'a' && result.text[0] <= 'z')
    result.text[0] = static_cast<char>(result.text[0] - 'a' + 'A');
  return result;
}

std::string with_step_titles(std::string text, const volume::SurgicalProcedure& procedure) {
  const auto is_letter = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-'; };
  for (const volume::ProcedureStep& step : procedure.steps) {
    if (step.title.empty()) continue;
    const std::string name = "the step " + step.name, title = "the step \"" + step.title + "\"";
    for (std::size_t at = text.find(name); at != std::string::npos; at = text.find(name, at + title.size()))
      if (at + name.size() == text.size() || !is_letter(text[at + name.size()]))
        text.replace(at, name.size(), title);
  }
  return text;
}

std::string fault_reasons(std::uint32_t faults) {
  std::string reasons;
  for (const auto& [bit, reason] :
       {std::pair(haptics::fault_lost_device, "the haptic device does not respond"),
        std::pair(haptics::fault_not_finite, "a pose or a force was invalid"),
        std::pair(haptics::fault_full_ring, "the computation of cuts is too slow"),
        std::pair(haptics::fault_stale_scene, "the computer is too busy")})
    if (faults & bit) reasons += (reasons.empty() ? "" : ", ") + std::string(reason);
  return reasons;
}

}  // namespace trephine::workbench
