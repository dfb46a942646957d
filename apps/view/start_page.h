// Start page of the simulator: procedures on built-in cases, recorded sessions, and the user's own scans.
// Call on the thread of the window.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "volume/base/error.h"

namespace trephine::view {

/// A case to begin with.
struct StartTile {
  std::string title, text;  ///< such as "Craniotomy"; one or two sentences
  std::string picture;      ///< name of a picture in the library of the window, such as "craniotomy"
  std::string source;       ///< name of a built-in case such as "head", a folder or a file
  std::string procedure;    ///< empty: free practice
};

/// A recorded session of the user.
struct StartSession {
  std::string file;
  std::string title;            ///< title of its procedure, or of its case
  std::string when;             ///< start, such as "2026-11-27 14:03"
  double seconds = 0;           ///< duration, s
  bool is_interrupted = false;  ///< the program ended without closing the session
  bool needs_scan = false;      ///< the file does not contain the scan: the user has to select it
};

/// Languages of the windows.
inline constexpr std::array<const char*, 2> k_languages{"en", "de"};

struct StartPageOptions {
  std::string language;  ///< one of k_languages; empty: that of the system
  std::string problem;   ///< reason why the last choice could not be opened; empty: no problem
  std::vector<StartTile> tiles;
  std::vector<StartSession> sessions;                           ///< newest first
  std::vector<std::pair<std::string, std::string>> procedures;  ///< names and titles, for the user's own scan
  std::optional<double> seconds;                                ///< closes the page after this time, s
  /// Returns true if the page is to be closed; called regularly.
  std::function<bool()> should_close = [] { return false; };
  /// PNG file of the page, written when it closes; empty: no file. Without `seconds`, the page is drawn into
  /// memory and no window is opened.
  std::string screenshot;
  bool is_offscreen() const { return !screenshot.empty() && !seconds; }
};

struct StartChoice {
  enum class Kind { none, operation, resume, replay };
  Kind kind = Kind::none;
  std::string path;       ///< path of the scan or the session
  std::string procedure;  ///< procedure of an operation; empty: that of the case
  std::string scan;       ///< path of the scan of a session that does not contain it
};

/// Shows the page until the user makes a choice or closes the page. Error: no display, or the full window is
/// not installed.
Result<StartChoice> choose_start(const StartPageOptions& options);

/// Entry point of the window's library.
using ChooseStart = Result<StartChoice> (*)(const StartPageOptions&);
inline constexpr const char* k_start_page_entry = "trephine_choose_start";

}  // namespace trephine::view
