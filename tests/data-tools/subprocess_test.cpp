#include "data-tools/files/subprocess.h"

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <gtest/gtest.h>
#include <thread>

namespace trephine::data_tools {
namespace {

using End = SubprocessResult::End;

TEST(Subprocess, OnlySharedBytesAreReturned) {
  const auto shared = SharedBytes::make(100);
  int here = 0;
  const SubprocessResult ended = run_in_subprocess(100,
                                                   [&](int i) {
                                                     shared->data()[i] = static_cast<char>(i + 1);
                                                     ++here;
                                                     std::puts("this is not printed here");
                                                   },
                                                   {});
  EXPECT_EQ(ended.end, End::done);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(shared->data()[i], i + 1);
  EXPECT_EQ(here, 0);
}

/// Each kind of failure, with the number of the task.
TEST(Subprocess, CrashesAreErrorsWithALocation) {
  const std::pair<const char*, void (*)()> failures[] = {
      {"ended unexpectedly", [] { std::raise(SIGSEGV); }},
      {"ended unexpectedly", [] { std::abort(); }},
      {"reported an error", [] { throw 3; }},
      {"reported an error", [] { std::_Exit(7); }},
      {"does not end", [] { std::this_thread::sleep_for(std::chrono::hours(1)); }}};
  for (const auto& [word, fail] : failures) {
    const SubprocessResult ended = run_in_subprocess(
        50,
        [fail = fail](int i) {
          if (i == 31) fail();
        },
        {}, 0.3);
    EXPECT_EQ(ended.end, End::failed);
    EXPECT_EQ(ended.at, 31);
    EXPECT_NE(ended.found.find(word), std::string::npos) << ended.found;
  }
}

TEST(Subprocess, CanBeStopped) {
  int calls = 0;
  const SubprocessResult ended = run_in_subprocess(
      10, [](int) { std::this_thread::sleep_for(std::chrono::hours(1)); },
      [&](double) { return ++calls < 3; });
  EXPECT_EQ(ended.end, End::stopped);
}

}  // namespace
}  // namespace trephine::data_tools
