// Start page of the simulator: procedures on built-in cases, recorded sessions, and own scans. For the
// thread of the window.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "volume/base/error.h"

namespace trephine::view {

/// A case to begin with.
struct StartTile {
  std::string title, text;  ///< "Craniotomy"; one or two sentences
  std::string picture;      ///< name of a picture of the window's library, such as "craniotomy"
  std::string source;       ///< "head", a folder or a file
  std::string procedure;    ///< empty: free practice
};

/// A recorded session of the user.
struct StartSession {
  std::string file;
  std::string title;  ///< of its procedure, or of its case
  std::string when;   ///< "2026-11-27 14:03"
  double seconds = 0;
  bool is_interrupted = false;  ///< its program ended without closing it
};

struct StartPageOptions {
  std::string problem;  ///< reason why the last choice could not be opened; empty: no problem
  std::vector<StartTile> tiles;
  std::vector<StartSession> sessions;                           ///< newest first
  std::vector<std::pair<std::string, std::string>> procedures;  ///< names and titles, for an own scan
  std::optional<double> seconds;                                ///< closes the page after this time, s
  std::function<bool()> should_close = [] { return false; };
  /// PNG file at the end; empty: no picture. Without `seconds` it is drawn into memory, without a window.
  std::string screenshot;
  bool is_offscreen() const { return !screenshot.empty() && !seconds; }
};

struct StartChoice {
  enum class Kind { none, operation, resume, replay };
  Kind kind = Kind::none;
  std::string path;       ///< of the scan or the session
  std::string procedure;  ///< of an operation; empty: that of its case
};

/// Shows the page until the user chooses or closes it. Error: no display, or the full window is not
/// installed.
Result<StartChoice> choose_start(const StartPageOptions& options);

/// Entry point of the window's library.
using ChooseStart = Result<StartChoice> (*)(const StartPageOptions&);
inline constexpr const char* k_start_page_entry = "trephine_choose_start";

}  // namespace trephine::view
