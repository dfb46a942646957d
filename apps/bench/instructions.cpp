#include "apps/bench/instructions.h"

#include <csignal>
#include <sys/ptrace.h>
#include <sys/wait.h>
#include <unistd.h>

namespace trephine::bench {

namespace {

/// Counts the instructions that the child executes between its two signals, including those that send the
/// second one.
std::optional<long> count_steps(const std::function<void()>& work) {
  const pid_t child = ::fork();
  if (child < 0) return std::nullopt;
  if (child == 0) {
    if (::ptrace(PTRACE_TRACEME, 0, nullptr, nullptr) != 0) ::_exit(1);
    ::raise(SIGSTOP);
    work();
    ::raise(SIGSTOP);
    ::_exit(0);
  }
  int status = 0;
  std::optional<long> result;
  if (::waitpid(child, &status, 0) == child && WIFSTOPPED(status)) {
    for (long steps = 0;; ++steps) {
      if (::ptrace(PTRACE_SINGLESTEP, child, nullptr, nullptr) != 0 ||
          ::waitpid(child, &status, 0) != child || !WIFSTOPPED(status))
        break;
      if (WSTOPSIG(status) == SIGSTOP) {
        result = steps;
        break;
      }
      if (WSTOPSIG(status) != SIGTRAP) break;  // the child failed
    }
  }
  if (!WIFEXITED(status) && !WIFSIGNALED(status)) {
    ::kill(child, SIGKILL);
    ::waitpid(child, &status, 0);
  }
  return result;
}

}  // namespace

std::optional<long> count_instructions(const std::function<void()>& work) {
  const std::optional<long> nothing = count_steps([] {}), all = count_steps(work);
  if (!nothing || !all) return std::nullopt;
  return *all - *nothing;
}

}  // namespace trephine::bench
