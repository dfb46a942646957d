// Background: the order in which longer work starts and ends. The tests wait for events, never for a time.
#include "sim/drivers/background.h"

#include <atomic>
#include <chrono>
#include <future>
#include <gtest/gtest.h>
#include <string>

namespace trephine::sim {
namespace {

/// A promise for which work waits. wait() returns false after two minutes, so that a test fails instead of
/// waiting forever.
struct Gate {
  std::promise<void> promise;
  std::shared_future<void> is_open{promise.get_future()};
  void open() { promise.set_value(); }
  bool wait() const { return is_open.wait_for(std::chrono::minutes(2)) == std::future_status::ready; }
};

TEST(Background, AJobStartsWhileASearchRuns) {
  Gate is_searching, is_job_done;
  std::atomic<bool> has_waited{false};
  Background background;
  // The search ends only after the job. If the job waited for the search, the search would end by its
  // timeout, and has_waited would be false.
  background.submit(Priority::search, [&]() -> Background::Result {
    is_searching.open();
    has_waited = is_job_done.wait();
    return {};
  });
  ASSERT_TRUE(is_searching.wait());
  background.submit(Priority::search, []() -> Background::Result { return {}; });  // queued
  background.submit(Priority::jobs, [&]() -> Background::Result {
    is_job_done.open();
    return {};
  });
  ASSERT_TRUE(is_job_done.wait());
  while (!background.is_idle(Priority::search)) std::this_thread::yield();
  EXPECT_TRUE(has_waited);
}

TEST(Background, EachPriorityProceedsWhileAllOthersAreBusy) {
  for (std::size_t free = 0; free < Background::k_priorities; ++free) {
    Gate is_done;
    Background background;
    for (std::size_t p = 0; p < Background::k_priorities; ++p)
      if (p != free)
        background.submit(static_cast<Priority>(p), [&]() -> Background::Result {
          EXPECT_TRUE(is_done.wait());
          return {};
        });
    background.submit(static_cast<Priority>(free), [&]() -> Background::Result {
      is_done.open();
      return {};
    });
    EXPECT_TRUE(is_done.wait()) << free;
  }
}

TEST(Background, WorkOfOnePriorityRunsInOrderOneAtATime) {
  Gate has_begun;
  std::atomic<int> running{0};
  std::string started, ended;
  Background background;
  for (char name = 'a'; name <= 'h'; ++name)
    background.submit(Priority::jobs, [&, name]() -> Background::Result {
      EXPECT_TRUE(has_begun.wait());
      EXPECT_EQ(++running, 1);
      started += name;
      --running;
      return [&ended, name] { ended += name; };
    });
  EXPECT_FALSE(background.is_idle(Priority::jobs));
  EXPECT_TRUE(background.is_idle(Priority::depths));
  has_begun.open();
  while (ended.size() < 8) {
    for (const Background::Result& result : background.fetch_results()) result();
    std::this_thread::yield();
  }
  EXPECT_EQ(started, "abcdefgh");
  EXPECT_EQ(ended, "abcdefgh");
  EXPECT_TRUE(background.is_idle(Priority::jobs));
}

TEST(Background, AResultKeepsItsPriorityBusyUntilItIsTaken) {
  Gate has_run;
  Background background;
  background.submit(Priority::fields, [&]() -> Background::Result {
    has_run.open();
    return [] {};
  });
  ASSERT_TRUE(has_run.wait());
  std::vector<Background::Result> results;
  while (results.empty()) {
    EXPECT_FALSE(background.is_idle(Priority::fields));
    results = background.fetch_results();
  }
  EXPECT_EQ(results.size(), 1u);
  EXPECT_TRUE(background.is_idle(Priority::fields));
}

TEST(Background, StopWaitsForRunningWorkAndMoreWorkCanFollow) {
  Gate has_begun, may_end, is_again;
  std::atomic<bool> has_ended{false};
  Background background;
  background.submit(Priority::jobs, [&]() -> Background::Result {
    has_begun.open();
    EXPECT_TRUE(may_end.wait());
    has_ended = true;
    return [] {};
  });
  ASSERT_TRUE(has_begun.wait());
  std::thread opener([&] { may_end.open(); });
  background.stop();
  EXPECT_TRUE(has_ended);
  opener.join();
  EXPECT_TRUE(background.fetch_results().empty());
  EXPECT_TRUE(background.is_idle(Priority::jobs));
  background.submit(Priority::jobs, [&]() -> Background::Result {
    is_again.open();
    return {};
  });
  EXPECT_TRUE(is_again.wait());
}

}  // namespace
}  // namespace trephine::sim
