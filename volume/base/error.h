// Error and Result: errors are returned as values, not printed or thrown. Only a failed assertion aborts.
#pragma once

#include <cassert>
#include <optional>
#include <string>
#include <utility>
#include <variant>

/// Checks a precondition; active in debug builds and with TREPHINE_ASSERTS. Not for use per voxel.
#if defined(TREPHINE_ASSERTS) || !defined(NDEBUG)
#define TREPHINE_ASSERT(claim) ((claim) ? void() : ::trephine::fail_assertion(#claim, __FILE__, __LINE__))
#else
#define TREPHINE_ASSERT(claim) ((void)0)
#endif

namespace trephine {

enum class ErrorKind {
  bad_input,     ///< a file, scene, script or argument is wrong
  missing_here,  ///< this machine lacks a resource: memory, a display
  interrupted,   ///< the user requested a stop
  refused,       ///< the state does not allow a command; nothing was changed
  different,     ///< a replay differs from its recording
};

/// Problem, location, found and expected values, and remedy. Initialize the members by name.
struct Error {
  std::string what = {};      ///< one clause: "path is not sorted in time"
  std::string where = {};     ///< file, line, option; never a full path
  std::string found = {};     ///< may be empty
  std::string expected = {};  ///< may be empty
  std::string remedy = {};    ///< imperative: "resample the volume"; may be empty
  ErrorKind kind = ErrorKind::bad_input;

  /// Returns all parts as text, one per line; without trailing newline.
  std::string message() const;
};

/// A value or the error that prevented it. Reading the absent alternative is a bug of the caller.
template <class T, class E = Error>
class [[nodiscard]] Result {
 public:
  Result(T value) : held_(std::move(value)) {}
  Result(E error) : held_(std::move(error)) {}

  bool is_ok() const { return held_.index() == 0; }
  explicit operator bool() const { return is_ok(); }
  T& value() & { return std::get<0>(held_); }
  const T& value() const& { return std::get<0>(held_); }
  T&& value() && { return std::get<0>(std::move(held_)); }
  const E& error() const { return std::get<1>(held_); }

 private:
  std::variant<T, E> held_;
};

/// Success without a value, or an Error.
using Status = std::optional<Error>;

/// Called by a failed TREPHINE_ASSERT: prints the violated claim to stderr and aborts the program.
[[noreturn]] void fail_assertion(const char* claim, const char* file, int line);

}  // namespace trephine
