// Small helpers of the commands: sentences with numbers, and time.
#pragma once

#include <chrono>
#include <cstdarg>
#include <cstdio>
#include <string>

namespace trephine::app {

using Clock = std::chrono::steady_clock;
inline double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// printf into a string, at most 1000 characters.
inline std::string format_text(const char* format, ...) __attribute__((format(printf, 1, 2)));
inline std::string format_text(const char* format, ...) {
  char text[1000];
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  return text;
}

}  // namespace trephine::app
