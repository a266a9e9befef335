// SPDX-License-Identifier: Apache-2.0
// Parallel loops. Every iteration writes only its own outputs, so results are the same for any number of
// threads.
#pragma once

#include <functional>
#include <memory>

namespace dermap {

// Calls body(0) ... body(count - 1), in any order, on the threads that ThreadLimit allows.
// The first exception thrown by a body is rethrown here.
void ParallelFor(int count, const std::function<void(int)>& body);

// How many threads may work right now.
int AllowedThreads();

// While alive, at most `threads` threads work in ParallelFor and in the libraries below (0: all cores).
class ThreadLimit {
 public:
  explicit ThreadLimit(int threads);
  ~ThreadLimit();
  ThreadLimit(const ThreadLimit&) = delete;
  ThreadLimit& operator=(const ThreadLimit&) = delete;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace dermap
