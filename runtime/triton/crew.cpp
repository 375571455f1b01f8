#include "triton/crew.h"

#include <algorithm>
#include <system_error>

#include "base/signals.h"

namespace chiasm::triton {

Crew::~Crew() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  work_there_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

void Crew::run(size_t count, const std::function<void(size_t)>& work) {
  if (count == 0) return;
  if (count == 1) return work(0);
  std::unique_lock lock(mutex_);
  start();
  const auto job = jobs_.insert(jobs_.end(), Job{work, count});
  for (size_t i = 0; i < std::min(count - 1, threads_.size()); ++i) work_there_.notify_one();
  while (job->next < count) do_next(job, lock);
  job_done_.wait(lock, [&] { return job->done == count; });
  jobs_.erase(job);
}

void Crew::start() {
  if (started_) return;
  threads_.reserve(size_);
  started_ = true;
  const base::SignalsBlocked blocked;  // in the new threads
  try {
    while (threads_.size() < size_) threads_.emplace_back([this] { help(); });
  } catch (const std::system_error&) {
    return;  // with the threads that could be created, or none: the callers work too
  }
}

void Crew::help() {
  std::unique_lock lock(mutex_);
  for (;;) {
    const auto job =
        std::find_if(jobs_.begin(), jobs_.end(), [](const Job& each) { return each.next < each.count; });
    if (job != jobs_.end()) {
      do_next(job, lock);
    } else if (ending_) {
      return;
    } else {
      work_there_.wait(lock);
    }
  }
}

void Crew::do_next(std::list<Job>::iterator job, std::unique_lock<std::mutex>& lock) {
  const size_t index = job->next++;
  lock.unlock();
  job->work(index);
  lock.lock();
  // The job's owner does not erase it before the last piece is counted
  if (++job->done == job->count) job_done_.notify_all();
}

}  // namespace chiasm::triton
