#include "base/fork.h"

#include <fcntl.h>
#include <pthread.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <new>
#include <thread>

namespace chiasm::base {
namespace {

/** Longer than any call of an engine should take. After this time a fork goes on, at its own risk. */
constexpr auto kPatience = std::chrono::seconds(10);

/** How often a sleeping thread has gone to sleep; -1 if it is awake; 0 if that is unknown, as without
 *  /proc. */
int64_t sleeps_of(pid_t thread) noexcept {
  char path[64], text[4096];
  std::snprintf(path, sizeof path, "/proc/self/task/%d/status", static_cast<int>(thread));
  const int file = ::open(path, O_RDONLY | O_CLOEXEC);
  if (file < 0) return 0;
  const ssize_t size = ::read(file, text, sizeof text - 1);
  ::close(file);
  text[std::max<ssize_t>(size, 0)] = '\0';
  const char* state = std::strstr(text, "State:\t");
  const char* count = std::strstr(text, "\nvoluntary_ctxt_switches:");
  if (state == nullptr || count == nullptr) return 0;
  return state[7] == 'S' ? std::strtoll(std::strchr(count, ':') + 1, nullptr, 10) : -1;
}

}  // namespace

ForkGate::ForkGate() {
  ::pthread_atfork([] { instance().close(); }, [] { instance().open(); },
                   [] {
                     ForkGate& gate = instance();
                     for (Slot& slot : gate.slots_) slot.inside.store(0, std::memory_order_relaxed);
                     gate.generation_.fetch_add(1, std::memory_order_relaxed);
                     gate.workers_.clear();
                     gate.open();
                   });
}

ForkGate& ForkGate::instance() {
  // Never destroyed, and not allocated: a passage cannot say that there is no memory.
  alignas(ForkGate) static unsigned char memory[sizeof(ForkGate)];
  static ForkGate& gate = *new (memory) ForkGate;
  return gate;
}

std::atomic<int64_t>& ForkGate::enter() noexcept {
  static std::atomic<uint32_t> threads{0};
  thread_local const uint32_t mine = threads.fetch_add(1, std::memory_order_relaxed) % kSlots;
  std::atomic<int64_t>& inside = slots_[mine].inside;
  for (;;) {
    // Sequentially consistent, as in close(): either the fork sees this thread, or this thread sees the fork.
    inside.fetch_add(1);
    if (!closed_.load()) return inside;
    inside.fetch_sub(1);
    while (closed_.load(std::memory_order_acquire))
      std::this_thread::sleep_for(std::chrono::microseconds(50));
  }
}

void ForkGate::close() noexcept {
  forks_.lock();
  closed_.store(true);
  const auto limit = std::chrono::steady_clock::now() + kPatience;
  for (const Slot& slot : slots_) {
    while (slot.inside.load() != 0 && std::chrono::steady_clock::now() < limit)
      std::this_thread::sleep_for(std::chrono::microseconds(20));
  }
  workers_mutex_.lock();
  while (!workers_sleep() && std::chrono::steady_clock::now() < limit)
    std::this_thread::sleep_for(std::chrono::microseconds(20));
}

bool ForkGate::workers_sleep() const noexcept {
  // A thread may wake one that was checked before it. So all must be asleep in two checks, and none may have
  // been awake between them.
  int64_t sleeps[2] = {0, 0};
  for (int64_t& sum : sleeps) {
    for (const pid_t worker : workers_) {
      const int64_t count = sleeps_of(worker);
      if (count < 0) return false;
      sum += count;
    }
  }
  return sleeps[0] == sleeps[1];
}

void ForkGate::open() noexcept {
  workers_mutex_.unlock();
  closed_.store(false, std::memory_order_release);
  forks_.unlock();
}

ForkGate::Worker::Worker() noexcept {
  ForkGate& gate = instance();
  const std::lock_guard lock(gate.workers_mutex_);
  try {
    gate.workers_.push_back(::gettid());
  } catch (const std::bad_alloc&) {  // a fork does not wait for this one
  }
}

ForkGate::Worker::~Worker() {
  ForkGate& gate = instance();
  const std::lock_guard lock(gate.workers_mutex_);
  gate.workers_.erase(std::remove(gate.workers_.begin(), gate.workers_.end(), ::gettid()),
                      gate.workers_.end());
}

bool free_in_child(std::mutex& mutex) noexcept {
  if (mutex.try_lock()) {
    mutex.unlock();
    return true;
  }
  new (&mutex) std::mutex;
  return false;
}

}  // namespace chiasm::base
