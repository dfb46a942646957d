#include "apps/cli/commands/own_program.h"

#include <chrono>
#include <csignal>
#include <cstdio>
#include <fcntl.h>
#include <memory>
#include <spawn.h>
#include <string_view>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>
#include <vector>

#include "apps/cli/report.h"

extern char** environ;

namespace trephine::cli {

namespace {

/// An unnamed temporary file.
using File = std::unique_ptr<std::FILE, int (*)(std::FILE*)>;

std::string contents_of(std::FILE* file) {
  constexpr std::size_t k_longest = 4000;
  std::string text(k_longest, '\0');
  std::rewind(file);
  text.resize(std::fread(text.data(), 1, text.size(), file));
  while (!text.empty() && text.back() == '\n') text.pop_back();
  return text;
}

Error failed(std::string reason) {
  constexpr std::string_view k_prefix = "error: ";
  if (reason.starts_with(k_prefix)) reason.erase(0, k_prefix.size());
  if (reason.empty()) reason = "the program ended without a message";
  return {.what = std::move(reason), .kind = ErrorKind::missing_here};
}

constexpr auto k_poll = std::chrono::milliseconds(100);

/// Ends a process: requests its end, gives it two seconds to clean up, then kills it.
void end(pid_t process) {
  constexpr int k_polls = 20;
  ::kill(process, SIGTERM);
  for (int i = 0; i < k_polls; ++i) {
    if (waitpid(process, nullptr, WNOHANG) != 0) return;
    std::this_thread::sleep_for(k_poll);
  }
  ::kill(process, SIGKILL);
  waitpid(process, nullptr, 0);
}

}  // namespace

Status run_own_program(const std::vector<std::string>& arguments,
                       const std::function<bool(double share)>& progress) {
  const File errors(std::tmpfile(), &std::fclose), shares(std::tmpfile(), &std::fclose);
  if (!errors || !shares) return failed("no temporary file");
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_adddup2(&actions, fileno(errors.get()), STDERR_FILENO);
  posix_spawn_file_actions_adddup2(&actions, fileno(shares.get()), k_progress_file);
  std::string program = "/proc/self/exe";
  std::vector<std::string> words = arguments;
  std::vector<char*> pointers{program.data()};
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  pid_t process = 0;
  std::string setting = std::string(k_progress_variable) + "=" + std::to_string(k_progress_file);
  std::vector<char*> environment;
  for (char** one = environ; *one != nullptr; ++one) environment.push_back(*one);
  environment.push_back(setting.data());
  environment.push_back(nullptr);
  const int spawned =
      posix_spawn(&process, program.c_str(), &actions, nullptr, pointers.data(), environment.data());
  posix_spawn_file_actions_destroy(&actions);
  if (spawned != 0) return failed("the process could not be started");
  int result = 0;
  while (waitpid(process, &result, WNOHANG) == 0) {
    double share = 0;  // 0 until the process has written one
    if (::pread(fileno(shares.get()), &share, sizeof share, 0) != sizeof share) share = 0;
    if (!progress(share)) {
      end(process);
      return Error{.what = "the work was interrupted", .kind = ErrorKind::interrupted};
    }
    std::this_thread::sleep_for(k_poll);
  }
  if (WIFEXITED(result) && WEXITSTATUS(result) == 0) return std::nullopt;
  return failed(contents_of(errors.get()));
}

}  // namespace trephine::cli
