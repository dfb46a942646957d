// Errors of libraries: an Error travels with the value, nothing is printed, thrown or aborted.
#pragma once

#include <cassert>
#include <optional>
#include <string>
#include <utility>
#include <variant>

/// Checks a caller's promise; active in debug and in builds with TREPHINE_ASSERTS. Never per voxel.
#if defined(TREPHINE_ASSERTS) || !defined(NDEBUG)
#define TREPHINE_ASSERT(claim) \
  ((claim) ? void() : ::trephine::volume::broken_promise(#claim, __FILE__, __LINE__))
#else
#define TREPHINE_ASSERT(claim) ((void)0)
#endif

namespace trephine::volume {

enum class ErrorKind {
  bad_input,     ///< a file, scene, script or argument is wrong
  missing_here,  ///< this machine lacks something: memory, a display
  interrupted,   ///< the person asked to stop
};

/// Problem, location, found and expected values, and remedy.
struct Error {
  std::string what;      ///< one clause: "path is not sorted in time"
  std::string where;     ///< file, line, option; never a full path
  std::string found;     ///< may be empty
  std::string expected;  ///< may be empty
  std::string remedy;    ///< what the person can do; may be empty
  ErrorKind kind = ErrorKind::bad_input;

  /// All parts in one readable paragraph.
  std::string message() const;
};

/// A value or the Error that prevented it. Asking the wrong half is a caller's bug.
template <class T>
class [[nodiscard]] Result {
 public:
  Result(T value) : held_(std::move(value)) {}
  Result(Error error) : held_(std::move(error)) {}

  bool is_ok() const { return held_.index() == 0; }
  explicit operator bool() const { return is_ok(); }
  T& value() & { return std::get<0>(held_); }
  const T& value() const& { return std::get<0>(held_); }
  T&& value() && { return std::get<0>(std::move(held_)); }
  const Error& error() const { return std::get<1>(held_); }

 private:
  std::variant<T, Error> held_;
};

/// Success without a value, or an Error.
using Status = std::optional<Error>;

/// The end of TREPHINE_ASSERT: says which promise broke on stderr and stops the program.
[[noreturn]] void broken_promise(const char* claim, const char* file, int line);

}  // namespace trephine::volume
