#include "data-tools/apart.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <csignal>
#include <fcntl.h>
#include <new>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>
#include <vector>

#include "volume/volume.h"

namespace trephine::data_tools {

namespace {

/// State of one of the processes.
struct Progress {
  std::atomic<int> at{-1}, done{0};
};

void silence() {
  const int nowhere = ::open("/dev/null", O_RDWR | O_CLOEXEC);
  if (nowhere < 0) return;
  ::dup2(nowhere, STDOUT_FILENO);
  ::dup2(nowhere, STDERR_FILENO);
}

[[noreturn]] void work_through(int first, int step, int count, const std::function<void(int)>& work,
                               Progress& progress) {
  for (const int signal : {SIGTERM, SIGHUP, SIGSEGV, SIGABRT, SIGBUS, SIGFPE}) std::signal(signal, SIG_DFL);
  // Ctrl-C reaches all processes of a terminal: the first one decides what it means, and ends the others.
  std::signal(SIGINT, SIG_IGN);
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  silence();
  const struct rlimit no_core { 0, 0 };
  ::setrlimit(RLIMIT_CORE, &no_core);
  try {
    for (int i = first; i < count; i += step) {
      progress.at = i;
      work(i);
      ++progress.done;
    }
  } catch (...) {
    ::_exit(1);
  }
  ::_exit(0);
}

}  // namespace

std::unique_ptr<SharedBytes> SharedBytes::make(std::size_t bytes) {
  if (bytes > volume::available_memory_bytes()) return nullptr;
  void* data = ::mmap(nullptr, std::max<std::size_t>(bytes, 1), PROT_READ | PROT_WRITE,
                      MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (data == MAP_FAILED) return nullptr;
  return std::unique_ptr<SharedBytes>(
      new SharedBytes(static_cast<char*>(data), std::max<std::size_t>(bytes, 1)));
}

SharedBytes::~SharedBytes() { ::munmap(data_, bytes_); }

ApartResult run_apart(int count, const std::function<void(int)>& work,
                      const std::function<bool(double)>& goes_on, double seconds_each, int least_each) {
  using Clock = std::chrono::steady_clock;
  using End = ApartResult::End;
  const int processes =
      std::clamp(std::min(static_cast<int>(std::thread::hardware_concurrency()), count / least_each), 1, 16);
  const auto room = SharedBytes::make(sizeof(Progress) * static_cast<std::size_t>(processes));
  if (!room) return {End::failed, -1, "there is no memory for it"};
  auto* progress = reinterpret_cast<Progress*>(room->data());
  std::vector<pid_t> children;
  for (int p = 0; p < processes; ++p) {
    new (progress + p) Progress;
    const pid_t child = ::fork();
    if (child == 0) work_through(p, processes, count, work, progress[p]);
    if (child > 0) children.push_back(child);
    if (child < 0) break;
  }
  const auto end_all = [&] {
    for (const pid_t child : children)
      if (child > 0) ::kill(child, SIGKILL), ::waitpid(child, nullptr, 0);
  };
  if (static_cast<int>(children.size()) < processes) {
    end_all();
    return {End::failed, -1, "no process could be started for it"};
  }
  std::vector<int> last(children.size(), -1);
  std::vector<Clock::time_point> since(children.size(), Clock::now());
  for (std::size_t alive = children.size(); alive > 0;) {
    int done = 0;
    for (std::size_t p = 0; p < children.size(); ++p) {
      done += progress[p].done;
      if (children[p] <= 0) continue;
      int status = 0;
      if (::waitpid(children[p], &status, WNOHANG) == children[p]) {
        children[p] = 0;
        --alive;
        if (WIFEXITED(status) && WEXITSTATUS(status) == 0) continue;
        const int at = progress[p].at;
        end_all();
        return {End::failed, at,
                WIFSIGNALED(status) ? "damaged contents, on which its reader stopped" : "it cannot be read"};
      }
      if (progress[p].at != last[p]) last[p] = progress[p].at, since[p] = Clock::now();
      if (std::chrono::duration<double>(Clock::now() - since[p]).count() > seconds_each) {
        end_all();
        return {End::failed, last[p], "reading it does not end"};
      }
    }
    if (goes_on && !goes_on(static_cast<double>(done) / std::max(count, 1))) {
      end_all();
      return {End::stopped, -1, ""};
    }
    if (alive > 0) std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return {};
}

}  // namespace trephine::data_tools
