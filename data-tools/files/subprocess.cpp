#include "data-tools/files/subprocess.h"

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

#include "volume/scan/volume.h"

namespace trephine::data_tools {

namespace {

/// Shared state of a child process: the current item, and the number of finished items.
struct ChildState {
  std::atomic<int> item{-1}, finished{0};
};

void silence() {
  const int null_device = ::open("/dev/null", O_RDWR | O_CLOEXEC);
  if (null_device < 0) return;
  ::dup2(null_device, STDOUT_FILENO);
  ::dup2(null_device, STDERR_FILENO);
}

[[noreturn]] void run_items(int first, int step, int count, const std::function<void(int)>& work,
                            ChildState& progress) {
  for (const int signal : {SIGTERM, SIGHUP, SIGSEGV, SIGABRT, SIGBUS, SIGFPE}) std::signal(signal, SIG_DFL);
  // Ctrl-C reaches all processes of a terminal: the parent handles it and ends its children.
  std::signal(SIGINT, SIG_IGN);
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  silence();
  const struct rlimit no_core { 0, 0 };
  ::setrlimit(RLIMIT_CORE, &no_core);
  try {
    for (int i = first; i < count; i += step) {
      progress.item = i;
      work(i);
      ++progress.finished;
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

SubprocessResult run_in_subprocess(int count, const std::function<void(int)>& work,
                                   const std::function<bool(double)>& on_progress, double seconds_per_item,
                                   int min_items) {
  using Clock = std::chrono::steady_clock;
  using End = SubprocessResult::End;
  const int processes =
      std::clamp(std::min(static_cast<int>(std::thread::hardware_concurrency()), count / min_items), 1, 16);
  const auto shared = SharedBytes::make(sizeof(ChildState) * static_cast<std::size_t>(processes));
  if (!shared) return {End::failed, -1, "not enough memory"};
  auto* progress = reinterpret_cast<ChildState*>(shared->data());
  std::vector<pid_t> children;
  for (int p = 0; p < processes; ++p) {
    new (progress + p) ChildState;
    const pid_t child = ::fork();
    if (child == 0) run_items(p, processes, count, work, progress[p]);
    if (child > 0) children.push_back(child);
    if (child < 0) break;
  }
  const auto kill_children = [&] {
    for (const pid_t child : children)
      if (child > 0) ::kill(child, SIGKILL), ::waitpid(child, nullptr, 0);
  };
  if (static_cast<int>(children.size()) < processes) {
    kill_children();
    return {End::failed, -1, "a child process could not be started"};
  }
  std::vector<int> last_items(children.size(), -1);
  std::vector<Clock::time_point> start_times(children.size(), Clock::now());
  for (std::size_t alive = children.size(); alive > 0;) {
    int finished = 0;
    for (std::size_t p = 0; p < children.size(); ++p) {
      finished += progress[p].finished;
      if (children[p] <= 0) continue;
      int status = 0;
      if (::waitpid(children[p], &status, WNOHANG) == children[p]) {
        children[p] = 0;
        --alive;
        if (WIFEXITED(status) && WEXITSTATUS(status) == 0) continue;
        const int item = progress[p].item;
        kill_children();
        return {End::failed, item,
                WIFSIGNALED(status) ? "the reader ended unexpectedly" : "the reader reported an error"};
      }
      if (progress[p].item != last_items[p]) last_items[p] = progress[p].item, start_times[p] = Clock::now();
      if (std::chrono::duration<double>(Clock::now() - start_times[p]).count() > seconds_per_item) {
        kill_children();
        return {End::failed, last_items[p], "the reader does not end"};
      }
    }
    if (on_progress && !on_progress(static_cast<double>(finished) / std::max(count, 1))) {
      kill_children();
      return {End::stopped, -1, ""};
    }
    if (alive > 0) std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return {};
}

}  // namespace trephine::data_tools
