#include "base/pool.h"

#include <pthread.h>

#include <algorithm>
#include <cstdlib>

#include "base/fork.h"

namespace chiasm::base {
namespace {

// Sizes come in four steps per doubling, so that images of nearly the same size share blocks. At most a
// quarter is wasted.
std::size_t rounded(std::size_t bytes) {
  if (bytes < Pool::kSmallestKept)
    return std::max((bytes + Pool::kAlignment - 1) & ~(Pool::kAlignment - 1), Pool::kAlignment);
  std::size_t step = Pool::kSmallestKept / 4;
  while (step * 8 < bytes) step *= 2;
  return (bytes + step - 1) / step * step;
}

constexpr std::size_t kLargest = std::size_t{1} << 62;

}  // namespace

Pool& Pool::instance() {
  static Pool& pool = []() -> Pool& {
    pthread_atfork(nullptr, nullptr, [] { instance().go_on_in_child(); });
    alignas(Pool) static unsigned char memory[sizeof(Pool)];
    return *new (memory) Pool;  // not allocated: native code calls this, and nothing is thrown through it
  }();
  return pool;
}

void Pool::go_on_in_child() noexcept {
  if (free_in_child(mutex_)) return;
  count_ = 0;  // leaks the blocks: the list may be half changed
  kept_bytes_ = 0;
}

void* Pool::allocate(std::size_t bytes) noexcept {
  if (bytes > kLargest) return nullptr;
  const std::size_t size = rounded(bytes);
  if (size >= kSmallestKept) {
    const std::lock_guard lock(mutex_);
    for (std::size_t i = count_; i-- > 0;) {  // the one released last is the likeliest to be in cache
      if (kept_[i].bytes != size) continue;
      void* data = kept_[i].data;
      std::move(kept_.begin() + i + 1, kept_.begin() + count_, kept_.begin() + i);
      --count_;
      kept_bytes_ -= size;
      return data;
    }
  }
  void* data = std::aligned_alloc(kAlignment, size);
  if (data == nullptr) {
    trim();
    data = std::aligned_alloc(kAlignment, size);
  }
  return data;
}

void Pool::release(void* data, std::size_t bytes) noexcept {
  if (data == nullptr) return;
  const std::size_t size = rounded(bytes);
  if (size < kSmallestKept || size > kKeptLimit) {
    std::free(data);
    return;
  }
  const std::lock_guard lock(mutex_);
  while (count_ == kept_.size() || kept_bytes_ + size > kKeptLimit) drop_oldest();
  kept_[count_++] = {data, size};
  kept_bytes_ += size;
}

void Pool::drop_oldest() noexcept {
  std::free(kept_[0].data);
  kept_bytes_ -= kept_[0].bytes;
  std::move(kept_.begin() + 1, kept_.begin() + count_, kept_.begin());
  --count_;
}

void Pool::trim() noexcept {
  const std::lock_guard lock(mutex_);
  while (count_ > 0) drop_oldest();
}

std::size_t Pool::kept_bytes() noexcept {
  const std::lock_guard lock(mutex_);
  return kept_bytes_;
}

}  // namespace chiasm::base
