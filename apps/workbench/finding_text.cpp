#include "apps/workbench/finding_text.h"

#include <algorithm>
#include <cmath>

#include "apps/workbench/text.h"

namespace trephine::workbench {

using sim::Finding;

namespace {

/// Returns a unit with superscripts: "mm/s3" becomes "mm/s\u00b3".
std::string unit_text(std::string_view unit) {
  std::string text;
  for (const char c : unit) text += c == '2' ? "\u00b2" : c == '3' ? "\u00b3" : std::string(1, c);
  return text;
}

}  // namespace

std::string value_text(const Finding& finding) {
  if (!finding.value) return "\u2013";
  if (finding.unit == Finding::k_letter) return std::string(1, static_cast<char>('A' + *finding.value));
  // Whole numbers, such as counts, have no decimals. Other values have about four digits. No value has an
  // exponent.
  const double size = std::abs(*finding.value);
  const int digits = size == std::floor(size) || size >= 1000 ? 0 : size >= 100 ? 1 : 2;
  return format_text("%.*f", digits, *finding.value) +
         (finding.unit.empty() ? "" : "\u00a0" + unit_text(finding.unit));
}

std::string limits_text(const Finding& finding) {
  if (finding.full_at == finding.zero_at) return "";
  return format_text("full at %g, none at %g", finding.full_at, finding.zero_at);
}

std::string points_text(const Finding& finding) {
  if (!(finding.weight > 0)) return "";
  // Points that are rounded up must not look like all points.
  const bool looks_full = finding.points < finding.weight && finding.points >= finding.weight - 0.05;
  return finding.value ? format_text(looks_full ? "%.2f of %g" : "%.1f of %g", finding.points, finding.weight)
                       : format_text("\u2013 of %g", finding.weight);
}

std::string points_of(const sim::Score& score) {
  return score.possible > 0 ? format_text("%.1f of %.1f points", score.points, score.possible)
                            : "no points: nothing was judged";
}

std::string critical_text(const sim::Score& score) {
  std::string text;
  for (const std::string& name : score.critical) {
    const auto finding = std::find_if(score.findings.begin(), score.findings.end(),
                                      [&](const Finding& one) { return one.name == name; });
    text += format_text("%s%s %s (%s %g for full points)", text.empty() ? "critical: " : "; ",
                        words_of(name).c_str(), value_text(*finding).c_str(),
                        finding->full_at > finding->zero_at ? "at least" : "at most", finding->full_at);
  }
  return text;
}

bool is_only_reported(const Finding& finding) noexcept {
  return finding.value && finding.full_at == finding.zero_at;
}

}  // namespace trephine::workbench
