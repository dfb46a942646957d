#include "volume/base/error.h"

#include <cstdio>
#include <cstdlib>

namespace trephine {

std::string Error::message() const {
  std::string text = where.empty() ? what : where + ": " + what;
  if (!found.empty()) text += "\n  found:    " + found;
  if (!expected.empty()) text += "\n  expected: " + expected;
  if (!remedy.empty()) text += "\n  remedy:   " + remedy;
  return text;
}

void fail_assertion(const char* claim, const char* file, int line) {
  std::fprintf(stderr, "%s:%d: precondition violated: %s\n", file, line, claim);
  std::abort();
}

}  // namespace trephine
