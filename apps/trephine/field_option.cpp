#include "apps/trephine/field_option.h"

#include <cctype>
#include <variant>

#include "volume/text.h"

namespace trephine::app {

namespace {

/// "Of the spindle (100 to 500000 1/min)".
std::string help_of(const sim::Field& field) {
  std::string text(field.info.help);
  text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
  const sim::FieldInfo& info = field.info;
  if (info.unit.empty()) return text;
  if (!info.choices.empty()) return text.append(" (").append(info.unit).append(")");
  return text.append(" (")
      .append(info.low < 1e-6 ? (info.low > 0 ? "above 0" : "0") : volume::text_of(info.low))
      .append(" to ")
      .append(volume::text_of(info.high))
      .append(" ")
      .append(info.unit)
      .append(")");
}

}  // namespace

Option add_field(Options& options, const sim::Schema& schema, void* of, std::string_view field,
                 const char* called) {
  for (const sim::Field& one : schema.fields) {
    if (one.name != field) continue;
    const std::string means = std::string(schema.name).append(" ").append(field), help = help_of(one);
    const sim::FieldPlace place = one.place(of);
    if (auto* const* number = std::get_if<double*>(&place))
      return options.add(called, **number, help).means(means.c_str());
    if (auto* const* choice = std::get_if<std::uint8_t*>(&place))
      return options.add(called, **choice, one.info.choices, help).means(means.c_str());
    return options.add(called, *std::get<bool*>(place), help).means(means.c_str());
  }
  TREPHINE_ASSERT(false);
  return Option(nullptr, nullptr);
}

}  // namespace trephine::app
