// run_in_subprocess(): runs third-party libraries on untrusted bytes in child processes. A crash, an endless
// loop or a failed allocation ends the child and becomes an error.
#pragma once

#include <functional>
#include <memory>
#include <string>

namespace trephine::data_tools {

/// Memory shared with child processes: they fill it and this process reads it. Initially zero.
class SharedBytes {
 public:
  /// Returns `bytes` bytes; null if there is not enough memory.
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

/// Result of run_in_subprocess().
struct SubprocessResult {
  enum class End { done, stopped, failed } end = End::done;
  int at = -1;        ///< item in progress at the failure; -1: unknown
  std::string found;  ///< reason of the failure, as Error::found
};

/// Runs work(0) to work(count - 1) in forked processes that print nothing. Their changes are lost, except in
/// SharedBytes. `on_progress` is called in this process with the finished share; false stops the work. An
/// item that takes longer than `seconds_per_item` is a failure. The number of processes is at most count /
/// min_items, but at least one.
SubprocessResult run_in_subprocess(int count, const std::function<void(int)>& work,
                                   const std::function<bool(double)>& on_progress,
                                   double seconds_per_item = 60, int min_items = 1);

}  // namespace trephine::data_tools
