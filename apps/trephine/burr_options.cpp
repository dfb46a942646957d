#include "apps/trephine/burr_options.h"

#include <cctype>
#include <variant>

#include "volume/text.h"

namespace trephine::app {

namespace {

/// "Of the spindle, 100 to 500000 1/min".
std::string help_of(const sim::Field& field) {
  std::string text(field.info.help);
  text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
  const sim::FieldInfo& info = field.info;
  if (info.unit.empty()) return text;
  return text.append(" (")
      .append(info.low < 1e-6 ? (info.low > 0 ? "above 0" : "0") : volume::text_of(info.low))
      .append(" to ")
      .append(volume::text_of(info.high))
      .append(" ")
      .append(info.unit)
      .append(")");
}

/// The option of a field of a burr, called as it is, or otherwise.
Option add_field(Options& options, drilling::Burr& burr, std::string_view name, const char* called) {
  for (const sim::Field& field : drilling::Burr::schema().fields) {
    if (field.name != name) continue;
    const std::string means = std::string("burr ").append(name), help = help_of(field);
    const sim::FieldPlace place = field.place(&burr);
    if (auto* const* number = std::get_if<double*>(&place))
      return options.add(called, **number, help).means(means.c_str());
    if (auto* const* choice = std::get_if<std::uint8_t*>(&place))
      return options.add(called, **choice, field.info.choices, help).means(means.c_str());
    return options.add(called, *std::get<bool*>(place), help).means(means.c_str());
  }
  TREPHINE_ASSERT(false);
  return Option(nullptr, nullptr);
}

}  // namespace

Option add_burr(Options& options, drilling::Burr& burr) {
  const Option diameter = add_field(options, burr, "diameter", "--burr-diameter").type("MM");
  add_field(options, burr, "shape", "--burr-shape");
  add_field(options, burr, "length", "--burr-length").type("MM");
  add_field(options, burr, "grade", "--grade");
  add_field(options, burr, "rpm", "--rpm").shows_default();
  add_field(options, burr, "dry", "--dry");
  add_field(options, burr, "removal_rate", "--removal-rate").shows_default();
  add_field(options, burr, "feed_limit", "--feed-limit").shows_default();
  options
      .add("--round", burr.is_round,
           "The bone is touched with all of the burr, not with its lowest point; the hand holds a ball's "
           "middle, "
           "and the tip of other burrs; what touches is a voxel or a twelfth smaller than what cuts, so that "
           "it "
           "has room in its own hole; to 12 mm")
      .means("tool radius");
  add_field(options, burr, "shaft", "--shaft").type("MM");
  return diameter;
}

}  // namespace trephine::app
