/** The functions of the CUDA driver that the core and its plug-ins use. The driver is opened at run time:
 *  nothing is linked, and no CUDA headers are needed to build.
 *
 *  What fails throws Error: UNAVAILABLE if the driver, the device or its context cannot be had, OUT_OF_MEMORY
 *  if the device has none left, INTERNAL for all else, such as a crash on the device. */
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

namespace chiasm::base {

/** A device's primary context, which is the one that the CUDA runtime uses as well. */
class CudaDevice final {
 public:
  explicit CudaDevice(int32_t index);
  CudaDevice(const CudaDevice&) = delete;
  CudaDevice& operator=(const CudaDevice&) = delete;
  ~CudaDevice();

  /** While a Current lives, its device is the calling thread's current device. */
  class Current final {
   public:
    explicit Current(const CudaDevice& device);
    Current(const Current&) = delete;
    Current& operator=(const Current&) = delete;
    ~Current();
  };

  /** The compute capability: 90 for 9.0. */
  int64_t capability() const;

  /** Memory in the order of the stream: it may be released while work that uses it is still enqueued. NULL if
   *  none is left. The device must be current. */
  static void* allocate(std::size_t bytes, void* stream) noexcept;
  static void release(void* data, void* stream) noexcept;

 private:
  int device_ = 0;
  void* context_ = nullptr;
};

/** A stream of our own, ordered with a caller's streams by events. The host never waits. */
class CudaStream final {
 public:
  explicit CudaStream(const CudaDevice& device);
  CudaStream(const CudaStream&) = delete;
  CudaStream& operator=(const CudaStream&) = delete;
  ~CudaStream();

  void* handle() const { return stream_; }
  /** Work enqueued here from now on starts after the work that is on `caller` now. */
  void begin_after(void* caller) { order(caller, stream_); }
  /** Work enqueued on `caller` from now on starts after the work that is here now. */
  void end_before(void* caller) { order(stream_, caller); }

 private:
  void order(void* first, void* then);

  const CudaDevice& device_;
  void* stream_ = nullptr;
};

/** Memory on a device, for tests and first runs: every copy waits for all work on the device. */
class CudaBuffer final {
 public:
  CudaBuffer() = default;
  CudaBuffer(int32_t device_index, std::size_t bytes);
  CudaBuffer(CudaBuffer&& other) noexcept;
  CudaBuffer& operator=(CudaBuffer&& other) noexcept;
  ~CudaBuffer();

  void* data() const { return data_; }
  void copy_from_host(const void* source, std::size_t bytes);
  void copy_to_host(void* target, std::size_t bytes) const;

 private:
  std::shared_ptr<const CudaDevice> device_;
  void* data_ = nullptr;
};

/** Guesses whether this process can see a device, without starting the driver (cuInit takes 100 ms and
 *  more). */
bool cuda_device_present();

}  // namespace chiasm::base
