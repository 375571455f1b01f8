/** Memory for outputs and scratch, reused: the page faults of a fresh big block cost more than a stencil. */
#pragma once

#include <cstddef>
#include <mutex>
#include <vector>

namespace chiasm::core {

/** Blocks aligned to 64 bytes. Thread-safe. */
class BufferPool final {
 public:
  struct Block {
    void* data = nullptr;
    size_t capacity = 0;
  };

  /** At least `bytes` bytes, uninitialised. Throws std::bad_alloc. */
  Block take(size_t bytes);
  void give(Block block) noexcept;
  /** Bytes held for reuse. */
  size_t cached_bytes() const;

  /** The process's pool; it lives until the process ends, so that outputs may outlive everything. */
  static BufferPool& instance();

  BufferPool();
  ~BufferPool();
  BufferPool(const BufferPool&) = delete;
  BufferPool& operator=(const BufferPool&) = delete;

 private:
  /** In a child of fork, whose parent's other threads may have been at work here. */
  void go_on_in_child() noexcept;

  mutable std::mutex mutex_;
  std::vector<Block> cached_; /**< oldest first */
  size_t cached_bytes_ = 0;
};

}  // namespace chiasm::core
