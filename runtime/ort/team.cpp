#include "ort/team.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "artifact/spin.h"
#include "base/floats.h"

namespace chiasm::ort {
namespace {

using Clock = std::chrono::steady_clock;

/** A pool thread that is awake comes within microseconds, a sleeping one within tens of them. */
constexpr auto kPatience = std::chrono::microseconds(60);
constexpr int kSpins = 4000;

/** Waits for threads that are all at work: pauses, then yields this core in case one of them has lost its
 *  own. */
class Waiting {
 public:
  void step() {
    if (++steps_ < kSpins)
      relax();
    else
      std::this_thread::yield();
  }

 private:
  int steps_ = 0;
};

}  // namespace

OrtStatus* Team::run(void (*run)(void*), void* argument) {
  run_ = run;
  run_argument_ = argument;
  const auto iteration = [](void* self, size_t) { static_cast<Team*>(self)->take_part(); };
  OrtStatus* status = api_.KernelContext_ParallelFor(context_, iteration, kMost, 0, this);
  const int32_t before = experience_.load(std::memory_order_relaxed), now = seen_.load();
  // Decrease slowly, so that after one run with a busy pool the next one still waits for threads.
  experience_.store(before == 0 || now > before ? now
                    : before > now              ? before - 1
                                                : now,
                    std::memory_order_relaxed);
  return status;
}

uint64_t Team::next_serial() {
  static std::atomic<uint64_t> next{1};
  return next.fetch_add(1, std::memory_order_relaxed);
}

void Team::count_this_thread() {
  thread_local uint64_t counted = 0;
  if (std::exchange(counted, serial_) != serial_) seen_.fetch_add(1, std::memory_order_relaxed);
}

void Team::take_part() {
  if (std::this_thread::get_id() != master_) {
    count_this_thread();
    if (!done_.load(std::memory_order_acquire)) serve();
    return;
  }
  if (started_) return;  // a later iteration of this thread
  started_ = true;
  run_(run_argument_);
  done_.store(true, std::memory_order_release);
}

void Team::fork(Body body, void* argument) {
  const int32_t known = experience_.load(std::memory_order_relaxed);
  const int32_t expected = known == 0 ? most_ : std::min(known, most_);
  int32_t count = joined_.load(std::memory_order_acquire);
  if (count < expected) {
    const auto limit = Clock::now() + kPatience;
    do relax();
    while ((count = joined_.load(std::memory_order_acquire)) < expected && Clock::now() < limit);
  }
  // A larger pool has more threads than the op has prepared for.
  count = std::min(count, most_);
  if (count == 1) {
    body(argument, 0, 1);
    return;
  }
  body_ = body;
  argument_ = argument;
  working_.store(count - 1, std::memory_order_relaxed);
  const uint64_t begun = region_.load(std::memory_order_relaxed) / (kMost + 1) + 1;
  region_.store(begun * (kMost + 1) + static_cast<uint64_t>(count), std::memory_order_release);
  body(argument, 0, count);
  for (Waiting waiting; working_.load(std::memory_order_acquire) != 0;) waiting.step();
}

void Team::serve() {
  const base::DefaultFloats floats;
  uint64_t last = region_.load(std::memory_order_acquire);
  const int32_t index = joined_.fetch_add(1, std::memory_order_acq_rel);
  Waiting waiting;
  while (!done_.load(std::memory_order_acquire)) {
    const uint64_t region = region_.load(std::memory_order_acquire);
    if (region == last) {
      waiting.step();
      continue;
    }
    last = region;
    waiting = Waiting();
    const auto count = static_cast<int32_t>(region % (kMost + 1));
    if (index >= count) continue;  // this thread came after the region had begun
    body_(argument_, index, count);
    working_.fetch_sub(1, std::memory_order_release);
  }
}

}  // namespace chiasm::ort
