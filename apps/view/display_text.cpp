#include "apps/view/display_text.h"

#include <utility>

namespace trephine::view {

namespace {

std::function<std::string(const std::string&)>& translation() {
  static std::function<std::string(const std::string&)> k_translation;
  return k_translation;
}

}  // namespace

void set_display_translation(std::function<std::string(const std::string&)> translate) {
  translation() = std::move(translate);
}

std::string display_text(const std::string& english) {
  return translation() ? translation()(english) : english;
}

}  // namespace trephine::view
