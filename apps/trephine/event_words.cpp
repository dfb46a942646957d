#include "apps/trephine/event_words.h"

#include "apps/workbench/text.h"
#include "modules/bone_flap/bone_flap.h"
#include "modules/cross_section/cross_section.h"
#include "modules/drilling/perforator.h"
#include "modules/fluoroscopy/fluoroscopy.h"
#include "modules/laminectomy/laminectomy.h"
#include "modules/measurement/measurement.h"
#include "modules/rongeur/rongeur.h"
#include "sim/forbidden.h"

namespace trephine::app {

using workbench::format_text;

std::string words_of(const sim::Event& event) {
  if (const auto* fault = event.what.as<sim::FaultEvent>())
    return fault->is_cleared ? "faults cleared" : "fault: " + fault->names;
  if (const auto* entered = event.what.as<sim::ForbiddenEntered>())
    return "the tool came into " + entered->structure + (entered->is_working ? ", working" : "");
  if (const auto* left = event.what.as<sim::ForbiddenLeft>())
    return format_text("the tool left %s after %.2f s, %.2f mm deep at most", left->structure.c_str(),
                       left->seconds, left->deepest);
  if (const auto* stripped = event.what.as<sim::StructureStripped>())
    return format_text("%s pushed aside, %.2f mm", stripped->structure.c_str(), stripped->deepest);
  if (const auto* touched = event.what.as<sim::StructureTouched>())
    return format_text("%s touched while it worked, %.2f mm deep", touched->structure.c_str(),
                       touched->deepest);
  if (const auto* torn = event.what.as<sim::StructureTorn>())
    return format_text("%s torn, %.2f mm deep", torn->structure.c_str(), torn->deepest);
  if (const auto* flap = event.what.as<bone_flap::FlapCut>())
    return format_text("a bone flap of %.1f cm2 came off, %.0f mm3; the saw took %.0f mm3", flap->area / 100,
                       flap->flap_size, flap->kerf_size);
  if (const auto* piece = event.what.as<bone_flap::FlapPiece>())
    return format_text("piece %lld of the flap: %.0f mm3, %s", static_cast<long long>(piece->number),
                       piece->size, piece->is_taken ? "taken" : "left");
  if (const auto* seen = event.what.as<bone_flap::FlapSeen>())
    return (seen->area > 0 ? "there would be a " : "there would be no flap: ") + seen->says;
  if (const auto* none = event.what.as<bone_flap::NoFlap>()) return "no bone flap: " + none->why;
  if (const auto* cut = event.what.as<cross_section::SectionMeasured>())
    return format_text("section: bone %.1f mm2, models %.1f, of which %.1f outside bone", cut->bone,
                       cut->models, cut->outside);
  if (const auto* m = event.what.as<measurement::Measured>())
    return m->trouble.empty()
               ? format_text("measured: %.1f mm, %.1f degrees, mean %.0f", m->length, m->angle, m->mean)
               : "not measured: " + m->trouble;
  if (const auto* shot = event.what.as<fluoroscopy::XrayTaken>())
    return format_text("X-ray %lld: primary %.0f, secondary %.0f degrees, %.1f mGy cm2",
                       static_cast<long long>(shot->number), shot->primary, shot->secondary,
                       shot->area_product);
  if (const auto* judged = event.what.as<laminectomy::Judgement>())
    return format_text("%s: canal %.0f mm2 (%.0f before), its roof open along %.0f mm",
                       judged->vertebra.empty() ? "the vertebra" : judged->vertebra.c_str(),
                       judged->canal_after, judged->canal_before, judged->opened_length);
  if (const auto* through = event.what.as<drilling::Breakthrough>())
    return format_text("broke through under %.1f N, plunged %.1f mm in %.2f s", through->thrust,
                       through->plunge, through->seconds);
  if (const auto* stopped = event.what.as<drilling::PerforatorStopped>())
    return format_text("the perforator stopped after %.1f mm of bone", stopped->depth);
  if (const auto* bite = event.what.as<rongeur::Bite>()) return format_text("a bite of %.0f mm3", bite->size);
  if (const auto* refused = event.what.as<rongeur::BiteRefused>()) return "no bite: " + refused->why;
  if (const auto* piece = event.what.as<sim::PieceFreed>())
    return format_text("body %u came off, %.0f mm3", piece->body.value, piece->size);
  const std::string words = event.what.words();
  return std::string(event.what.name()) + (words.empty() ? "" : " " + words);
}

}  // namespace trephine::app
