/** CUDA's part of libtorch, opened when it is asked for. */
#pragma once

#include <ATen/Parallel.h>
#include <c10/core/impl/DeviceGuardImplInterface.h>

#include <dlfcn.h>
#include <unistd.h>

#include <string>

#include "base/cuda.h"
#include "base/error.h"

namespace chiasm::torch_engine {

using base::Error;

// libtorch_cuda. It and its dependencies are large, so they are opened for the first CUDA method and not
// linked: one plug-in works with the CPU and the CUDA builds of torch, and needs no CUDA headers. Once
// opened, libtorch_cuda registers itself with libtorch_cpu.
class Cuda {
 public:
  // Throws if there is no such device.
  static const Cuda& open(int32_t device_index) {
    static const Cuda instance;
    const int count = static_cast<uint8_t>(c10::impl::getDeviceGuardImpl(at::kCUDA)->deviceCount());
    if (device_index < 0 || device_index >= count)
      throw Error(CHIASM_UNAVAILABLE, "libtorch sees no CUDA device " + std::to_string(device_index) +
                                          ", it sees " + std::to_string(count));
    return instance;
  }

  // Whether libtorch_cuda is there; does not open it.
  static bool present() {
    Dl_info cpu{};
    if (!chiasm::base::cuda_device_present() ||
        dladdr(reinterpret_cast<void*>(&at::get_num_threads), &cpu) == 0)
      return false;
    const std::string path = cpu.dli_fname;
    return access((path.substr(0, path.rfind('/') + 1) + "libtorch_cuda.so").c_str(), R_OK) == 0;
  }

  // While a StreamGuard lives, torch enqueues the calling thread's work on its stream.
  class StreamGuard {
   public:
    StreamGuard(const Cuda& cuda, void* stream, int32_t device_index) : cuda_(cuda) {
      if (cuda_.create_(stream, device_index, &guard_) != 0)
        throw Error(CHIASM_INTERNAL, "cannot enqueue on the given CUDA stream");
    }
    StreamGuard(const StreamGuard&) = delete;
    StreamGuard& operator=(const StreamGuard&) = delete;
    ~StreamGuard() { cuda_.destroy_(guard_); }

   private:
    const Cuda& cuda_;
    void* guard_ = nullptr;
  };

 private:
  Cuda() {
    void* library = dlopen("libtorch_cuda.so", RTLD_NOW | RTLD_LOCAL);
    if (library == nullptr)
      throw Error(CHIASM_UNAVAILABLE, std::string("this libtorch was built without CUDA: ") + dlerror());
    create_ = reinterpret_cast<decltype(create_)>(dlsym(library, "aoti_torch_create_cuda_stream_guard"));
    destroy_ = reinterpret_cast<decltype(destroy_)>(dlsym(library, "aoti_torch_delete_cuda_stream_guard"));
    if (create_ == nullptr || destroy_ == nullptr)
      throw Error(CHIASM_UNAVAILABLE, "this libtorch_cuda has no stream guards");
  }

  // C functions of torch's stable interface
  int32_t (*create_)(void* stream, int32_t device_index, void** guard) = nullptr;
  int32_t (*destroy_)(void* guard) = nullptr;
};

}  // namespace chiasm::torch_engine
