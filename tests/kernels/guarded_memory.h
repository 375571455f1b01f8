// Buffers with guards: an inaccessible page is at one end, and changes of the other bytes around them are
// detected (by AddressSanitizer, also reads).
#pragma once

#include <sys/mman.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <new>

#ifdef __SANITIZE_ADDRESS__
#include <sanitizer/asan_interface.h>
#else
#define ASAN_POISON_MEMORY_REGION(p, n) ((void)0)
#define ASAN_UNPOISON_MEMORY_REGION(p, n) ((void)0)
#endif

namespace guarded {

enum class Placement { kEnd, kStart };

constexpr unsigned char kAround = 0xa5, kInside = 0xff;  // 0xff: NaN, or -1

/** `bytes` bytes that end or begin at the edge of accessible memory. */
class Buffer {
 public:
  /** `alignment`, a power of two, moves a buffer away from the edge at which it should end. */
  Buffer(size_t bytes, Placement placement, size_t alignment = 1) : bytes_(bytes) {
    const size_t page = static_cast<size_t>(sysconf(_SC_PAGESIZE));
    room_ = (bytes + alignment + page - 1) / page * page;
    void* const all = mmap(nullptr, room_ + 2 * page, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (all == MAP_FAILED) throw std::bad_alloc();
    base_ = static_cast<unsigned char*>(all) + page;
    if (mprotect(base_, room_, PROT_READ | PROT_WRITE) != 0) throw std::bad_alloc();
    std::memset(base_, kAround, room_);
    data_ = placement == Placement::kEnd ? base_ + (room_ - bytes) / alignment * alignment : base_;
    std::memset(data_, kInside, bytes);
    ASAN_POISON_MEMORY_REGION(base_, static_cast<size_t>(data_ - base_));
    ASAN_POISON_MEMORY_REGION(data_ + bytes, room_ - bytes - static_cast<size_t>(data_ - base_));
  }
  Buffer(const Buffer&) = delete;
  Buffer& operator=(const Buffer&) = delete;

  ~Buffer() {
    const size_t page = static_cast<size_t>(sysconf(_SC_PAGESIZE));
    ASAN_UNPOISON_MEMORY_REGION(base_, room_);
    munmap(base_ - page, room_ + 2 * page);
  }

  void* data() const { return data_; }
  size_t bytes() const { return bytes_; }

  /** Whether nothing has been written outside the buffer. */
  bool is_intact() const {
    ASAN_UNPOISON_MEMORY_REGION(base_, room_);
    for (const unsigned char* p = base_; p < base_ + room_; ++p)
      if ((p < data_ || p >= data_ + bytes_) && *p != kAround) return false;
    return true;
  }

 private:
  size_t bytes_, room_;
  unsigned char *base_, *data_;
};

}  // namespace guarded
