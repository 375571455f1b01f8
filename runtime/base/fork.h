/** Locks and forks. A child of fork has one thread: locks that other threads of the parent held at that
 *  moment would stay locked in the child for ever. */
#pragma once

#include <sys/types.h>

#include <atomic>
#include <cstdint>
#include <mutex>
#include <vector>

namespace chiasm::base {

/** Counts the threads inside the gate: those that call an engine or open a library. A fork waits until none
 *  is inside, and threads that arrive meanwhile wait until the fork is done; so a child finds the engine's
 *  locks free. A passage takes 4 ns. Passages of two gates must not be nested.
 *
 *  Each library that this code is linked into has one gate. The library must never be unloaded, or only while
 *  no thread is inside. */
class ForkGate final {
 public:
  /** While a Passage lives, its thread is inside. */
  class Passage final {
   public:
    Passage() noexcept : slot_(instance().enter()) {}
    Passage(const Passage&) = delete;
    Passage& operator=(const Passage&) = delete;
    ~Passage() { slot_.fetch_sub(1, std::memory_order_release); }

   private:
    std::atomic<int64_t>& slot_;
  };

  /** For an engine's own thread, which works for calls that are inside and may hold the engine's locks for a
   *  moment after them. While a Worker lives, a fork also waits until its thread sleeps. */
  class Worker final {
   public:
    Worker() noexcept;
    Worker(const Worker&) = delete;
    Worker& operator=(const Worker&) = delete;
    ~Worker();
  };

  /** How many forks lie between the process in which the gate was made and this one. */
  static uint32_t generation() noexcept { return instance().generation_.load(std::memory_order_relaxed); }

 private:
  static constexpr int kSlots = 16;
  struct alignas(64) Slot {
    std::atomic<int64_t> inside{0};
  };

  ForkGate();
  static ForkGate& instance();
  std::atomic<int64_t>& enter() noexcept;
  void close() noexcept;
  void open() noexcept;
  bool workers_sleep() const noexcept;

  Slot slots_[kSlots];
  std::atomic<bool> closed_{false};
  std::atomic<uint32_t> generation_{0};
  std::mutex forks_;  // one after the other
  std::mutex workers_mutex_;
  std::vector<pid_t> workers_;
};

/** Makes a mutex that no gate protects usable in the child; call it in a child handler of pthread_atfork.
 *  Returns false if another thread held the mutex: the data that it guards may be half changed. */
bool free_in_child(std::mutex& mutex) noexcept;

}  // namespace chiasm::base
