// SPDX-License-Identifier: Apache-2.0
// Parallel loops on oneTBB.
#include "common/core/parallel.h"

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>

#include <thread>

namespace dermap {

void ParallelFor(int count, const std::function<void(int)>& body) {
  // A context of its own: else a loop inside a body would end early, and silently, when another body throws.
  tbb::task_group_context context(tbb::task_group_context::isolated);
  tbb::parallel_for(
      0, count, [&](int i) { body(i); }, context);
}

int AllowedThreads() {
  return static_cast<int>(tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism));
}

struct ThreadLimit::State {
  explicit State(std::size_t threads) : control(tbb::global_control::max_allowed_parallelism, threads) {}
  tbb::global_control control;
};

ThreadLimit::ThreadLimit(int threads)
    : state_(std::make_unique<State>(threads > 0 ? static_cast<std::size_t>(threads)
                                                 : std::max(1u, std::thread::hardware_concurrency()))) {}

ThreadLimit::~ThreadLimit() = default;

}  // namespace dermap
