// Who is told what was assumed, and how far long work is. Nobody, unless a program says who.
#pragma once

#include <functional>
#include <string>

namespace trephine::workbench {

struct Listener {
  /// A sentence for a person.
  std::function<void(const std::string& text)> notice = [](const std::string&) {};
  /// Long work begins: what is told its share from then on, until it is let go; false from it stops the work.
  std::function<std::function<bool(double share)>(const char* what)> progress = [](const char*) {
    return [](double) { return true; };
  };
};

}  // namespace trephine::workbench
