#include "apps/cli/report/report_findings.h"

#include "apps/cli/report/report_html.h"
#include "apps/cli/report/report_texts.h"
#include "apps/workbench/session_score.h"
#include "apps/workbench/text.h"

namespace trephine::cli {

using sim::Finding;
using workbench::format_text;

std::string page_begin(const std::string& title) {
  return "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
         "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
         "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; style-src "
         "'unsafe-inline'; script-src 'unsafe-inline'; form-action 'none'; base-uri 'none'\">\n<title>" +
         escaped(title) + "</title>\n<style>\n" + std::string(k_report_css) +
         "</style></head>\n<body><main>\n";
}

std::string section(std::string_view css_class, std::string_view heading, const std::string& contents) {
  return "<section class=\"" + std::string(css_class) + "\"><h2>" + escaped(heading) + "</h2>\n" + contents +
         "</section>\n";
}

std::string verdict_html(const Finding& finding) {
  static constexpr const char* k_shapes[] = {
      "<circle cx=\"7\" cy=\"7\" r=\"5\" fill=\"none\" stroke=\"currentColor\" stroke-width=\"1.5\"/>",
      "<circle cx=\"7\" cy=\"7\" r=\"6\"/>", "<path d=\"M7 1l6.5 12h-13z\"/>",
      "<path d=\"M1.5 1.5h11v11h-11z\"/>"};
  static constexpr const char* k_classes[] = {"open", "good", "fair", "bad"};
  const auto verdict = static_cast<std::size_t>(finding.verdict);
  return format_text("<span class=\"verdict %s\"><svg viewBox=\"0 0 14 14\" aria-hidden=\"true\">%s</svg>",
                     k_classes[verdict], k_shapes[verdict]) +
         escaped(workbench::verdict_name(finding)) + "</span>";
}

}  // namespace trephine::cli
