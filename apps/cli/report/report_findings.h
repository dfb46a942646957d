// Parts that all pages share: the beginning of a page, sections, verdicts with a shape and a word.
#pragma once

#include <string>

#include "sim/api/finding.h"

namespace trephine::cli {

/// Returns the beginning of a page, up to the opened element `main`. The content policy of the page forbids
/// requests.
std::string page_begin(const std::string& title);
std::string section(std::string_view css_class, std::string_view heading, const std::string& contents);

/// Returns the shape and the word of a verdict: neither depends on colour.
std::string verdict_html(const sim::Finding& finding);

}  // namespace trephine::cli
