#include "core/pool.h"

#include <pthread.h>

#include <cstdlib>
#include <new>

#include "core/fork.h"

namespace chiasm::core {
namespace {

constexpr size_t kAlignment = 64;
constexpr size_t kMaxCachedBlocks = 32;
#if defined(__SANITIZE_ADDRESS__)
constexpr size_t kMaxCachedBytes = 0;  // so that a write past an output or after its end is seen
#else
constexpr size_t kMaxCachedBytes = size_t{256} << 20;
#endif
/** Smaller blocks come fast enough from malloc. */
constexpr size_t kMinCached = size_t{64} << 10;

}  // namespace

BufferPool::BufferPool() { cached_.reserve(kMaxCachedBlocks + 1); }

BufferPool::~BufferPool() {
  for (const Block& block : cached_) std::free(block.data);
}

BufferPool::Block BufferPool::take(size_t bytes) {
  if (bytes >= kMinCached) {
    const std::lock_guard<std::mutex> lock(mutex_);
    size_t best = cached_.size();
    for (size_t i = 0; i < cached_.size(); ++i) {
      // Not one much larger than asked for: that would hold memory which nobody uses.
      const bool fits = cached_[i].capacity >= bytes && cached_[i].capacity / 2 <= bytes;
      if (fits && (best == cached_.size() || cached_[i].capacity < cached_[best].capacity)) best = i;
    }
    if (best < cached_.size()) {
      const Block block = cached_[best];
      cached_.erase(cached_.begin() + static_cast<std::ptrdiff_t>(best));
      cached_bytes_ -= block.capacity;
      return block;
    }
  }
  Block block;
  block.capacity = bytes == 0 ? 1 : bytes;
  if (::posix_memalign(&block.data, kAlignment, block.capacity) != 0) throw std::bad_alloc();
  return block;
}

void BufferPool::give(Block block) noexcept {
  if (block.data == nullptr) return;
  if (block.capacity < kMinCached || block.capacity > kMaxCachedBytes) {
    std::free(block.data);
    return;
  }
  const std::lock_guard<std::mutex> lock(mutex_);
  cached_.push_back(block);  // within the reserved capacity
  cached_bytes_ += block.capacity;
  while (cached_bytes_ > kMaxCachedBytes || cached_.size() > kMaxCachedBlocks) {
    std::free(cached_.front().data);
    cached_bytes_ -= cached_.front().capacity;
    cached_.erase(cached_.begin());
  }
}

size_t BufferPool::cached_bytes() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return cached_bytes_;
}

void BufferPool::go_on_in_child() noexcept {
  if (free_in_child(mutex_)) return;
  cached_bytes_ = 0;  // the blocks are lost: which are whose is not known
  new (&cached_) std::vector<Block>;
  cached_.reserve(kMaxCachedBlocks + 1);
}

BufferPool& BufferPool::instance() {
  static BufferPool* const pool = [] {
    ::pthread_atfork(nullptr, nullptr, [] { instance().go_on_in_child(); });
    return new BufferPool;
  }();
  return *pool;
}

}  // namespace chiasm::core
