// SPDX-License-Identifier: Apache-2.0
// Tasks that end when they are told to.
#include "acquire/daemon/thread_per_task.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <future>
#include <thread>

namespace dermap {
namespace {

TEST(ThreadPerTask, RunsEveryTaskAtOnceUpToItsLimit) {
  constexpr int kMost = 3, kTasks = 10;
  std::atomic<int> begun{0}, ended{0};
  std::promise<void> go_on;
  const std::shared_future<void> may_end = go_on.get_future().share();
  ThreadPerTask threads(kMost);
  for (int i = 0; i < kTasks; ++i) {
    threads.Run([&] {
      ++begun;
      may_end.wait();
      ++ended;
    });
  }
  while (begun < kMost) std::this_thread::yield();
  EXPECT_EQ(begun, kMost);
  EXPECT_EQ(ended, 0);
  go_on.set_value();
  threads.Join();
  EXPECT_EQ(ended, kTasks);
}

// One for each thread that has run a task and not ended.
struct OfAThread {
  static inline std::atomic<int> living{0};
  OfAThread() { ++living; }
  ~OfAThread() { --living; }
};

TEST(ThreadPerTask, KeepsNoThreadThatHasNothingToDo) {
  constexpr int kTasks = 5, kMostTries = 1000;  // of 10 ms; beyond it one is kept
  std::promise<void> go_on;
  const std::shared_future<void> may_end = go_on.get_future().share();
  ThreadPerTask threads(kTasks);
  for (int i = 0; i < kTasks; ++i) {
    threads.Run([&] {
      thread_local const OfAThread here;
      static_cast<void>(&here);
      may_end.wait();
    });
  }
  while (OfAThread::living < kTasks) std::this_thread::yield();
  go_on.set_value();
  for (int i = 0; i < kMostTries && OfAThread::living > 0; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  EXPECT_EQ(OfAThread::living, 0);
}

}  // namespace
}  // namespace dermap
