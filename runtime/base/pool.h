/** Memory for outputs and scratch on the CPU. */
#pragma once

#include <array>
#include <cstddef>
#include <mutex>
#include <new>
#include <utility>

namespace chiasm::base {

/** Blocks of memory aligned to 64 bytes. Released big blocks are kept for reuse, the latest ones up to a
 *  limit: the page faults on a fresh block of 6 MB cost more than a stencil over it. Thread-safe. */
class Pool final {
 public:
  static constexpr std::size_t kAlignment = 64;
  static constexpr std::size_t kSmallestKept = std::size_t{32} << 10;  // below, malloc does as well
#if defined(__SANITIZE_ADDRESS__)
  static constexpr std::size_t kKeptLimit = 0;  // so that AddressSanitizer sees wrong accesses
#else
  static constexpr std::size_t kKeptLimit = std::size_t{256} << 20;
#endif

  /** The pool of the library that this code is in. Never destroyed: a thread may still run at exit. */
  static Pool& instance();

  /** NULL if no memory is left. */
  void* allocate(std::size_t bytes) noexcept;
  /** `bytes` is what the block was allocated with. */
  void release(void* data, std::size_t bytes) noexcept;
  /** Returns all kept blocks to the system. */
  void trim() noexcept;
  std::size_t kept_bytes() noexcept;

 private:
  /** For a child of fork: other threads of the parent may have been using the pool. */
  void go_on_in_child() noexcept;

  struct Block {
    void* data;
    std::size_t bytes;
  };

  void drop_oldest() noexcept;

  std::mutex mutex_;
  std::array<Block, 64> kept_;  // oldest first
  std::size_t count_ = 0;
  std::size_t kept_bytes_ = 0;
};

/** A block of the process's pool, given back at the end. */
class PooledMemory final {
 public:
  PooledMemory() = default;
  /** Uninitialised. Throws std::bad_alloc. */
  explicit PooledMemory(std::size_t bytes) : data_(Pool::instance().allocate(bytes)), bytes_(bytes) {
    if (data_ == nullptr) throw std::bad_alloc();
  }
  PooledMemory(PooledMemory&& other) noexcept
      : data_(std::exchange(other.data_, nullptr)), bytes_(other.bytes_) {}
  PooledMemory& operator=(PooledMemory&& other) noexcept {
    std::swap(data_, other.data_);
    std::swap(bytes_, other.bytes_);
    return *this;
  }
  ~PooledMemory() { Pool::instance().release(data_, bytes_); }

  void* data() const { return data_; }

 private:
  void* data_ = nullptr;
  std::size_t bytes_ = 0;
};

}  // namespace chiasm::base
