// Work of third-party libraries on untrusted bytes, in processes of their own: a crash,
// an endless loop or a flood of memory ends there, and becomes an error here.
#pragma once

#include <functional>
#include <memory>
#include <string>

namespace trephine::data_tools {

/// Memory that a process of its own fills and this one reads. Zeros at first.
class SharedBytes {
 public:
  /// Null when there is no room.
  static std::unique_ptr<SharedBytes> make(std::size_t bytes);
  ~SharedBytes();
  SharedBytes(const SharedBytes&) = delete;
  SharedBytes& operator=(const SharedBytes&) = delete;
  char* data() const noexcept { return data_; }

 private:
  SharedBytes(char* data, std::size_t bytes) : data_(data), bytes_(bytes) {}
  char* data_;
  std::size_t bytes_;
};

struct ApartResult {
  enum class End { done, stopped, failed } end = End::done;
  int at = -1;        ///< what was being worked on when it failed
  std::string found;  ///< "it crashed the unpacker", ...
};

/// Runs work(0) to work(count - 1) in a few processes, copies of this one that print nothing. What they
/// change is lost, except in SharedBytes. `goes_on` is asked here, with the share done; one piece of work may
/// take `seconds_each`. A process more is worth its start from `least_each` pieces on.
ApartResult run_apart(int count, const std::function<void(int)>& work,
                      const std::function<bool(double)>& goes_on, double seconds_each = 60,
                      int least_each = 1);

}  // namespace trephine::data_tools
