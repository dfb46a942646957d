// Listener: receives notices about assumptions, and progress of long work; ignores both by default.
#pragma once

#include <functional>
#include <string>

namespace trephine::workbench {

struct Listener {
  /// Receives a sentence for the user.
  std::function<void(const std::string& text)> notice = [](const std::string&) {};
  /// Begins long work; `what` describes it, such as "reading". The returned function is called with the
  /// completed share, 0 to 1. If that function returns false, the work stops.
  std::function<std::function<bool(double share)>(const char* what)> progress = [](const char*) {
    return [](double) { return true; };
  };
  /// Returns true if a wait for the user should end, such as the wait for a device to be homed.
  std::function<bool()> should_stop = [] { return false; };
};

}  // namespace trephine::workbench
