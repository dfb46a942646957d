#include "apps/cli/options/display_options.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "apps/view/start_page.h"
#include "volume/base/text.h"

namespace trephine::cli {

namespace {

struct EyesName {
  const char* name;
  view::DisplayMode::Eyes eyes;
};
constexpr EyesName k_eyes[] = {{"one", view::DisplayMode::Eyes::one},
                               {"anaglyph", view::DisplayMode::Eyes::anaglyph},
                               {"side-by-side", view::DisplayMode::Eyes::side_by_side},
                               {"headset", view::DisplayMode::Eyes::headset}};

Status check_distance(double mm, const char* option, const char* remedy) {
  constexpr double k_least = 100, k_most = 5000;
  if (mm >= k_least && mm <= k_most) return {};
  return Error{.what = "the length is out of range",
               .where = option,
               .found = rounded_text(mm) + " mm",
               .expected = "100 to 5000 mm",
               .remedy = remedy};
}

}  // namespace

void add_language(Options& options, std::string& language) {
  options.add("--language", language, "Language of the window: en or de; by default that of the system")
      .type("NAME");
}

Status check_language(const std::string& language) {
  const auto is_language = [&](const char* name) { return language == name; };
  if (language.empty() || std::any_of(view::k_languages.begin(), view::k_languages.end(), is_language))
    return std::nullopt;
  return Error{.what = "the window has no catalogue of this language",
               .where = "--language",
               .found = language,
               .expected = "en or de",
               .remedy = "omit the option for the language of the system"};
}

void add_display(Options& options, DisplayArguments& arguments) {
  add_language(options, arguments.language);
  options
      .add("--eyes", arguments.eyes,
           "Picture for: one; anaglyph (red and cyan glasses); side-by-side (3-D display); headset (OpenXR)")
      .shows_default()
      .type("NAME");
  options.add("--mirror", arguments.mode.is_mirrored,
              "Exchange left and right, for a display seen in a mirror");
  options
      .add(
          "--head-tracker", arguments.head_tracker,
          "Draw the picture for the position of the eyes: udp:PORT (OpenTrack), or a CSV file t,x,y,z (s; mm "
          "right, up and toward the viewer from the middle of the picture)")
      .type("SOURCE");
  options
      .add("--screen-width", arguments.mode.screen_width,
           "Width of the picture on the screen, for --head-tracker")
      .shows_default()
      .type("MM");
  options
      .add("--viewing-distance", arguments.mode.viewing_distance,
           "Distance of the eyes from the screen, for stereo without --head-tracker")
      .shows_default()
      .type("MM");
}

Status choose_display(const DisplayArguments& arguments, view::WindowOptions& options) {
  const auto found = std::find_if(std::begin(k_eyes), std::end(k_eyes),
                                  [&](const EyesName& e) { return arguments.eyes == e.name; });
  if (found == std::end(k_eyes))
    return Error{.what = "no display has this name",
                 .where = "--eyes",
                 .found = arguments.eyes,
                 .expected = "one, anaglyph, side-by-side or headset",
                 .remedy = "pass for example --eyes anaglyph"};
  if (Status error = check_language(arguments.language)) return error;
  options.language = arguments.language;
  if (Status error = check_distance(arguments.mode.screen_width, "--screen-width",
                                    "measure the width of the picture on the screen, in mm"))
    return error;
  if (Status error = check_distance(arguments.mode.viewing_distance, "--viewing-distance",
                                    "measure from the eyes to the screen, in mm"))
    return error;
  options.display = arguments.mode;
  options.display.eyes = found->eyes;
  if (found->eyes == view::DisplayMode::Eyes::headset) {
    auto hmd = view::open_hmd();
    if (!hmd) return hmd.error();
    options.hmd = std::move(hmd).value();
  }
  if (arguments.head_tracker.empty()) return {};
  auto tracker = view::open_head_tracker(arguments.head_tracker);
  if (!tracker) return tracker.error();
  options.head_tracker = std::move(tracker).value();
  return {};
}

}  // namespace trephine::cli
