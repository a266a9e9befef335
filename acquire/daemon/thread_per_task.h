// SPDX-License-Identifier: Apache-2.0
// A thread for each task, which ends with it. What the system's allocator keeps for a thread goes with the
// thread: threads that wait for work in a pool would each keep some of every size that they ever freed, and
// add up for days.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <functional>
#include <list>
#include <mutex>
#include <thread>

namespace dermap {

class ThreadPerTask {
 public:
  // Tasks beyond so many at once wait for one to end.
  explicit ThreadPerTask(std::size_t most_at_once) : most_at_once_(most_at_once) {}
  ~ThreadPerTask() { Join(); }
  ThreadPerTask(const ThreadPerTask&) = delete;
  ThreadPerTask& operator=(const ThreadPerTask&) = delete;
  void Run(std::function<void()> task);
  void Join();  // until all tasks have ended, those that wait as well

 private:
  using Threads = std::list<std::thread>;
  void Work(Threads::iterator self);
  void JoinEnded();  // with the lock held

  std::mutex mutex_;
  std::condition_variable one_ended_;
  std::list<std::function<void()>> waiting_;
  Threads running_, ended_;
  const std::size_t most_at_once_;
};

}  // namespace dermap
