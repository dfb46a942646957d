// display_text: texts of the libraries in the language of the window, for texts that the picture draws
// itself.
#pragma once

#include <functional>
#include <string>

namespace trephine::view {

/// Sets the translation of texts in pictures; an empty function selects English. Drawing thread only.
void set_display_translation(std::function<std::string(const std::string& english)> translate);
/// Returns the text in the language of the window. Drawing thread only.
std::string display_text(const std::string& english);

}  // namespace trephine::view
