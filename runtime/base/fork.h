/** Locks and forks. A child of fork has one thread: what the parent's others held at that moment would stay
 *  held in it for ever. */
#pragma once

#include <sys/types.h>

#include <atomic>
#include <cstdint>
#include <mutex>
#include <vector>

namespace chiasm::base {

/** Counts who is inside: a call of an engine, an opening of a library. A fork waits until nobody is, and who
 *  comes in the meantime waits until it is done; so a child finds the locks inside free. A passage takes 4
 *  ns. Passages of two gates must not be nested.
 *
 *  There is one gate in each library that this code is linked into, which is never unloaded or holds none at
 *  its end. */
class ForkGate final {
 public:
  /** While one lives, its thread is inside. */
  class Passage final {
   public:
    Passage() noexcept : slot_(instance().enter()) {}
    Passage(const Passage&) = delete;
    Passage& operator=(const Passage&) = delete;
    ~Passage() { slot_.fetch_sub(1, std::memory_order_release); }

   private:
    std::atomic<int64_t>& slot_;
  };

  /** While one lives, a fork waits also until its thread sleeps: one of an engine's own, which works for calls
   *  that are inside and may hold the engine's locks for a moment after them. */
  class Worker final {
   public:
    Worker();
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

/** For a mutex that guards what has no gate, in a handler of pthread_atfork that runs in the child: makes it
 *  usable. False where another thread held it: what it guards may be half changed. */
bool free_in_child(std::mutex& mutex) noexcept;

}  // namespace chiasm::base
