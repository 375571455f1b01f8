#include "base/fork.h"

#include <pthread.h>

#include <chrono>
#include <new>
#include <thread>

namespace chiasm::base {
namespace {

/** Longer than any call of an engine should take. A fork that has waited so long goes on, at its own risk. */
constexpr auto kPatience = std::chrono::seconds(10);

}  // namespace

ForkGate::ForkGate() {
  ::pthread_atfork([] { instance().close(); }, [] { instance().open(); },
                   [] {
                     ForkGate& gate = instance();
                     for (Slot& slot : gate.slots_) slot.inside.store(0, std::memory_order_relaxed);
                     gate.generation_.fetch_add(1, std::memory_order_relaxed);
                     gate.open();
                   });
}

ForkGate& ForkGate::instance() {
  static ForkGate& gate = *new ForkGate;
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
}

void ForkGate::open() noexcept {
  closed_.store(false, std::memory_order_release);
  forks_.unlock();
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
