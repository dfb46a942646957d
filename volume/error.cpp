#include "volume/error.h"

#include <cstdio>
#include <cstdlib>

namespace trephine::volume {

std::string Error::message() const {
  std::string text = where.empty() ? what : where + ": " + what;
  if (!found.empty()) text += "\n  found:    " + found;
  if (!expected.empty()) text += "\n  expected: " + expected;
  if (!remedy.empty()) text += "\n  remedy:   " + remedy;
  return text;
}

void broken_promise(const char* claim, const char* file, int line) {
  std::fprintf(stderr, "%s:%d: a caller broke the promise (%s)\n", file, line, claim);
  std::abort();
}

}  // namespace trephine::volume
