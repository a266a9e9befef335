// SPDX-License-Identifier: Apache-2.0
// Parallel loops: each iteration once, exceptions come out, limits hold.
#include "common/core/parallel.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <stdexcept>
#include <thread>
#include <vector>

namespace dermap {
namespace {

// By definition of a loop.
TEST(ParallelFor, CallsEveryIndexOnce) {
  std::vector<std::atomic<int>> calls(1000);
  ParallelFor(1000, [&](int i) { ++calls[i]; });
  for (const auto& count : calls) EXPECT_EQ(count, 1);
  ParallelFor(0, [](int) { FAIL(); });
}

// What parallel.h promises: the exception arrives with its type and its message.
TEST(ParallelFor, RethrowsWhatABodyThrows) {
  try {
    ParallelFor(100, [](int i) {
      if (i == 37) throw std::out_of_range("index 37");
    });
    FAIL() << "nothing was thrown";
  } catch (const std::out_of_range& error) {
    EXPECT_STREQ(error.what(), "index 37");
  }
}

// A loop inside a loop's body (tables inside bands) must neither deadlock nor skip: 20 x 30 by arithmetic.
TEST(ParallelFor, MayBeNested) {
  std::atomic<int> calls = 0;
  ParallelFor(20, [&](int) { ParallelFor(30, [&](int) { ++calls; }); });
  EXPECT_EQ(calls, 600);
}

// The contract: every body of a loop is called unless one of its own throws, whatever happens around it.
TEST(ParallelFor, InnerLoopsAreWholeWhenAnOuterBodyThrows) {
  std::atomic<int> broken = 0, inner_loops = 0;
  const auto outer = [&](int i) {
    if (i % 2 == 1) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
      throw std::runtime_error("outer");
    }
    std::atomic<int> calls = 0;
    ParallelFor(50, [&](int) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      ++calls;
    });
    ++inner_loops;
    if (calls != 50) ++broken;
  };
  for (int repeat = 0; repeat < 5; ++repeat) EXPECT_THROW(ParallelFor(2, outer), std::runtime_error);
  EXPECT_GT(inner_loops, 0);
  EXPECT_EQ(broken, 0);
}

int MostAtOnce(int count) {
  std::atomic<int> now = 0, most = 0;
  ParallelFor(count, [&](int) {
    const int running = ++now;
    int seen = most;
    while (running > seen && !most.compare_exchange_weak(seen, running)) {
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
    --now;
  });
  return most;
}

// The limit itself is the expected number.
TEST(ThreadLimit, BoundsHowManyBodiesRunAtOnce) {
  const ThreadLimit limit(1);
  EXPECT_EQ(MostAtOnce(20), 1);
  EXPECT_EQ(AllowedThreads(), 1);
}

// A limit ends with its scope; on a machine of one core there is nothing to see.
TEST(ThreadLimit, EndsWithItsScope) {
  if (std::thread::hardware_concurrency() < 2) GTEST_SKIP() << "one core";
  { const ThreadLimit limit(1); }
  EXPECT_GE(MostAtOnce(100), 2);
}

}  // namespace
}  // namespace dermap
