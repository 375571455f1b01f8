/** The little that the core itself needs of CUDA, through the driver's library, opened when first needed. */
#pragma once

#include <cstddef>
#include <cstdint>

namespace chiasm::core {

/** 90 for 9.0. Throws Error (UNAVAILABLE) where there is no driver or no such device. */
int64_t cuda_compute_capability(int32_t device_index);

/** Memory on a device, in the context that the engines share (the primary one). */
class CudaBuffer final {
 public:
  CudaBuffer() = default;
  CudaBuffer(int32_t device_index, size_t bytes);
  CudaBuffer(CudaBuffer&& other) noexcept;
  CudaBuffer& operator=(CudaBuffer&& other) noexcept;
  ~CudaBuffer();

  void* data() const { return reinterpret_cast<void*>(address_); }
  void copy_from_host(const void* source, size_t bytes);
  /** Waits for all work on the device first. */
  void copy_to_host(void* target, size_t bytes) const;

 private:
  unsigned long long address_ = 0;
  int32_t device_index_ = 0;
};

}  // namespace chiasm::core
