// Notices about assumptions, and progress of long work; ignored by default.
#pragma once

#include <functional>
#include <string>

namespace trephine::workbench {

struct Listener {
  /// A sentence for a person.
  std::function<void(const std::string& text)> notice = [](const std::string&) {};
  /// Begins long work: the result is called with its share until it is released; false from it stops the
  /// work.
  std::function<std::function<bool(double share)>(const char* what)> progress = [](const char*) {
    return [](double) { return true; };
  };
};

}  // namespace trephine::workbench
