#include "backends/native/workers.h"

#include <pthread.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <new>
#include <system_error>
#include <thread>

#include "artifact/spin.h"
#include "base/floats.h"
#include "base/signals.h"

namespace chiasm::native {
namespace {

/** How long a thread looks for work before it sleeps: longer than the gap between two loops of an op, shorter
 *  than that between two frames. */
constexpr int kSpins = 2000;

/** How long a caller waits for idle workers. A sleeping worker comes in 10 to 50 us, unless its core is busy;
 *  then going on without the worker is faster than waiting. */
constexpr auto kPatience = std::chrono::microseconds(50);

}  // namespace

struct Workers::Job {
  Body body;
  void* argument;
  std::atomic<int32_t> count{0};  // of the team, once it is known
  std::atomic<int32_t> returned{0};

  void wait_for(int32_t others) const {
    for (int spins = 0; returned.load(std::memory_order_acquire) != others; ++spins) {
      // The others began when this thread did, with as much work; a late one has lost its core.
      if (spins < kSpins)
        relax();
      else
        std::this_thread::yield();
    }
  }
};

struct Workers::Worker {
  std::atomic<bool> taken{false};
  // the offered job; the thread that exchanges it for nullptr, the worker or the caller, gets it
  std::atomic<Job*> job{nullptr};
  int32_t index = 0;    // in the team; written before the job's count
  bool asleep = false;  // guarded by the mutex
  std::mutex mutex;
  std::condition_variable wake;

  void offer(Job* work) {
    job.store(work);
    const std::lock_guard<std::mutex> lock(mutex);
    if (asleep) wake.notify_one();
  }

  /** Withdraws the offer; false if the worker has already taken it. */
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
    const base::DefaultFloats floats;
    for (;;) {
      Job* work = next();
      int32_t count;
      while ((count = work->count.load(std::memory_order_acquire)) == 0) relax();
      work->body(work->argument, index, count);
      // Mark this worker idle before signalling: the caller may fork again at once, and may destroy the job.
      taken.store(false, std::memory_order_release);
      work->returned.fetch_add(1, std::memory_order_release);
    }
  }
};

Workers::Workers(int32_t count) : process_(getpid()) {
  // The process may have no more threads, or no memory for one: then runs share those that there are.
  const base::SignalsBlocked blocked;
  try {
    for (int32_t i = 0; i < count; ++i) {
      auto worker = std::make_unique<Worker>();
      workers_.reserve(workers_.size() + 1);
      std::thread(&Worker::serve, worker.get()).detach();
      workers_.push_back(worker.release());
    }
  } catch (const std::system_error&) {
  } catch (const std::bad_alloc&) {}
}

/** The idle workers that a job was offered to. Nobody else can take them until they have returned. */
class Workers::Offers {
 public:
  Offers(const Workers& workers, Job& job, int32_t most) : job_(job) {
    if (getpid() != workers.process_) return;
    for (Worker* worker : workers.workers_) {
      if (count_ == kMost || static_cast<int32_t>(count_) >= most ||
          worker->taken.exchange(true, std::memory_order_acquire))
        continue;
      worker->offer(&job);
      workers_[count_++] = worker;
    }
  }

  bool all_have_come() const {
    return std::all_of(workers_, workers_ + count_,
                       [](const Worker* w) { return w->job.load(std::memory_order_relaxed) == nullptr; });
  }

  /** Withdraws the job from the workers that have not come. Returns how many have come. */
  int32_t close() {
    size_t come = 0;
    for (size_t i = 0; i < count_; ++i) {
      if (workers_[i]->withdraw(&job_))
        workers_[i]->taken.store(false, std::memory_order_release);
      else
        workers_[come++] = workers_[i];
    }
    count_ = come;
    return static_cast<int32_t>(come);
  }

  /** Numbers the workers that have come, from 1 on. They must be waiting for the job's count. */
  void number() {
    for (size_t i = 0; i < count_; ++i) workers_[i]->index = static_cast<int32_t>(i + 1);
  }

 private:
  static constexpr size_t kMost = 256;
  Job& job_;
  Worker* workers_[kMost];
  size_t count_ = 0;
};

void Workers::fork(Body body, void* argument, int32_t others) {
  Job job{body, argument};
  Offers offers(*this, job, others);
  const auto limit = std::chrono::steady_clock::now() + kPatience;
  while (!offers.all_have_come() && std::chrono::steady_clock::now() < limit) relax();
  const int32_t come = offers.close();
  offers.number();
  job.count.store(come + 1, std::memory_order_release);
  body(argument, 0, come + 1);
  job.wait_for(come);
}

void Workers::share(Body body, void* argument, int32_t others) {
  Job job{body, argument};
  job.count.store(1, std::memory_order_release);  // nobody waits for a team
  Offers offers(*this, job, others);
  body(argument, 0, 1);
  job.wait_for(offers.close());
}

Workers& Workers::instance(int32_t count) {
  static std::atomic<Workers*> workers{nullptr};
  static std::mutex mutex;  // never held at a fork, which waits for runs to end (base/fork.h)
  Workers* present = workers.load(std::memory_order_acquire);
  if (present != nullptr) return *present;
  const std::lock_guard<std::mutex> lock(mutex);
  present = workers.load(std::memory_order_acquire);
  if (present == nullptr) {
    static const int handler =
        pthread_atfork(nullptr, nullptr, [] { workers.store(nullptr, std::memory_order_relaxed); });
    static_cast<void>(handler);
    present = new Workers(count);
    workers.store(present, std::memory_order_release);
  }
  return *present;
}

}  // namespace chiasm::native
