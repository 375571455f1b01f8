#include "backends/native/workers.h"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>

#include "shim/spin.h"

namespace chiasm::native {
namespace {

/** How long a thread looks for work before it sleeps: longer than the gap between two loops of an op, shorter than that
 *  between two frames. */
constexpr int kSpins = 2000;

/** How long a caller waits for idle workers: one that sleeps comes in 10 to 50 us, unless other work has its core; and to wait
 *  for that would take longer than to go on without it. */
constexpr auto kPatience = std::chrono::microseconds(50);

}  // namespace

struct Workers::Job {
  Body body;
  void* argument;
  std::atomic<int32_t> count{0};  // of the team, once it is known
  std::atomic<int32_t> running{0};
};

struct Workers::Worker {
  std::atomic<bool> taken{false};
  std::atomic<Job*> job{nullptr};  // on offer: whoever exchanges it for nullptr, the worker or the caller, has it
  int32_t index = 0;               // in the team; written before the job's count
  bool asleep = false;             // guarded by the mutex
  std::mutex mutex;
  std::condition_variable wake;

  void offer(Job* work) {
    job.store(work);
    const std::lock_guard<std::mutex> lock(mutex);
    if (asleep) wake.notify_one();
  }

  /** True where the worker has not seen the offer, and now will not. */
  bool withdraw(Job* work) { return job.compare_exchange_strong(work, nullptr); }

  Job* next() {
    for (;;) {
      for (int i = 0; i < kSpins; ++i) {
        if (job.load(std::memory_order_relaxed) != nullptr) {
          if (Job* work = job.exchange(nullptr)) return work;
        }
        relax();
      }
      std::unique_lock<std::mutex> lock(mutex);
      asleep = true;
      wake.wait(lock, [this] { return job.load() != nullptr; });
      asleep = false;
    }
  }

  void serve() {
    for (;;) {
      Job* work = next();
      int32_t count;
      while ((count = work->count.load(std::memory_order_acquire)) == 0) relax();
      work->body(work->argument, index, count);
      // Free before the caller goes on: he may fork again at once. The job may be gone after the second line.
      taken.store(false, std::memory_order_release);
      work->running.fetch_sub(1, std::memory_order_release);
    }
  }
};

Workers::Workers(int32_t count) : process_(getpid()) {
  for (int32_t i = 0; i < count; ++i) {
    workers_.push_back(new Worker);
    std::thread(&Worker::serve, workers_.back()).detach();
  }
}

void Workers::fork(Body body, void* argument) {
  constexpr size_t kMost = 256;
  Worker* mine[kMost];
  size_t offered = 0;
  Job job{body, argument};
  if (getpid() == process_) {
    for (Worker* worker : workers_) {
      if (offered == kMost || worker->taken.exchange(true, std::memory_order_acquire)) continue;
      worker->offer(&job);
      mine[offered++] = worker;
    }
  }
  const auto limit = std::chrono::steady_clock::now() + kPatience;
  const auto has_come = [](const Worker* worker) { return worker->job.load(std::memory_order_relaxed) == nullptr; };
  while (!std::all_of(mine, mine + offered, has_come) && std::chrono::steady_clock::now() < limit) relax();
  int32_t count = 1;
  for (size_t i = 0; i < offered; ++i) {
    if (mine[i]->withdraw(&job)) {
      mine[i]->taken.store(false, std::memory_order_release);
    } else {
      mine[i]->index = count++;
    }
  }
  job.running.store(count - 1, std::memory_order_relaxed);
  job.count.store(count, std::memory_order_release);
  body(argument, 0, count);
  for (int spins = 0; job.running.load(std::memory_order_acquire) != 0; ++spins) {
    // The others began when this thread did and have as much to do; one that is late has lost its core.
    if (spins < kSpins) relax();
    else std::this_thread::yield();
  }
}

Workers& Workers::instance(int32_t count) {
  static Workers& workers = *new Workers(count);
  return workers;
}

}  // namespace chiasm::native
