#include "backends/native/workers.h"

#include <unistd.h>

#include <condition_variable>
#include <mutex>
#include <thread>

#include "shim/spin.h"

namespace chiasm::native {
namespace {

/** How long a thread looks for work before it sleeps: longer than the gap between two loops of an op, shorter than that
 *  between two frames. */
constexpr int kSpins = 2000;

}  // namespace

struct Workers::Job {
  Body body;
  void* argument;
  int32_t count;
  std::atomic<int32_t> running;
};

struct Workers::Worker {
  std::atomic<bool> taken{false};
  std::atomic<Job*> job{nullptr};  // set by who took the worker, cleared by the worker when it begins
  int32_t index = 0;               // in the job
  bool asleep = false;             // guarded by the mutex
  std::mutex mutex;
  std::condition_variable wake;

  void give(Job* work, int32_t place) {
    index = place;
    job.store(work);
    const std::lock_guard<std::mutex> lock(mutex);
    if (asleep) wake.notify_one();
  }

  Job* next() {
    for (int i = 0; i < kSpins; ++i) {
      if (Job* work = job.load(std::memory_order_acquire)) return work;
      relax();
    }
    std::unique_lock<std::mutex> lock(mutex);
    asleep = true;
    wake.wait(lock, [this] { return job.load() != nullptr; });
    asleep = false;
    return job.load();
  }

  void serve() {
    for (;;) {
      Job* work = next();
      job.store(nullptr, std::memory_order_relaxed);
      work->body(work->argument, index, work->count);
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
  int32_t count = 0;
  if (getpid() == process_) {
    for (Worker* worker : workers_) {
      if (static_cast<size_t>(count) < kMost && !worker->taken.exchange(true, std::memory_order_acquire)) mine[count++] = worker;
    }
  }
  Job job{body, argument, count + 1, {count}};
  for (int32_t i = 0; i < count; ++i) mine[i]->give(&job, i + 1);
  body(argument, 0, count + 1);
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
