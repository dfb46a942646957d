#include "apps/cli/options/field_option.h"

#include <cctype>
#include <variant>

#include "volume/base/text.h"

namespace trephine::cli {

namespace {

/// Returns the help of a field with its range and unit: "Speed of the spindle (100 to 500000 1/min)".
std::string help_of(const sim::Field& field) {
  std::string text(field.info.help);
  text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
  const sim::FieldInfo& info = field.info;
  if (info.unit.empty()) return text;
  if (!info.choices.empty()) return text.append(" (").append(info.unit).append(")");
  return text.append(" (")
      .append(info.low < 1e-6 ? (info.low > 0 ? "above 0" : "0") : text_of(info.low))
      .append(" to ")
      .append(text_of(info.high))
      .append(" ")
      .append(info.unit)
      .append(")");
}

}  // namespace

Option add_field(Options& options, const sim::Schema& schema, void* object, std::string_view field,
                 const char* names) {
  for (const sim::Field& candidate : schema.fields) {
    if (candidate.name != field) continue;
    const std::string meaning = std::string(schema.name).append(" ").append(field), help = help_of(candidate);
    const sim::FieldPointer pointer = candidate.pointer_in(object);
    if (auto* const* number = std::get_if<double*>(&pointer))
      return options.add(names, **number, help).means(meaning.c_str());
    if (auto* const* choice = std::get_if<std::uint8_t*>(&pointer))
      return options.add(names, **choice, candidate.info.choices, help).means(meaning.c_str());
    return options.add(names, *std::get<bool*>(pointer), help).means(meaning.c_str());
  }
  TREPHINE_ASSERT(false);
  return Option(nullptr, nullptr, nullptr);
}

}  // namespace trephine::cli
