// SPDX-License-Identifier: Apache-2.0
// A thread that has ended is joined when the next task comes.
#include "acquire/daemon/thread_per_task.h"

#include <utility>

namespace dermap {

void ThreadPerTask::Run(std::function<void()> task) {
  const std::lock_guard lock(mutex_);
  JoinEnded();
  waiting_.push_back(std::move(task));
  if (running_.size() == most_at_once_) return;
  const auto self = running_.emplace(running_.end());
  *self = std::thread([this, self] { Work(self); });
}

void ThreadPerTask::Work(Threads::iterator self) {
  std::unique_lock lock(mutex_);
  while (!waiting_.empty()) {
    {
      const std::function<void()> task = std::move(waiting_.front());
      waiting_.pop_front();
      lock.unlock();
      task();
    }
    lock.lock();
  }
  ended_.splice(ended_.end(), running_, self);
  one_ended_.notify_all();
}

void ThreadPerTask::JoinEnded() {
  for (std::thread& thread : ended_) thread.join();  // each has done all but return
  ended_.clear();
}

void ThreadPerTask::Join() {
  std::unique_lock lock(mutex_);
  one_ended_.wait(lock, [&] { return running_.empty(); });
  JoinEnded();
}

}  // namespace dermap
