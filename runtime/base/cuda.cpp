#include "base/cuda.h"

#include <dlfcn.h>
#include <unistd.h>

#include <cstdlib>
#include <string>
#include <utility>

#include "base/error.h"

namespace chiasm::base {
namespace {

// The driver's own types, as its ABI has them.
using Result = int;                  // CUresult
using Address = unsigned long long;  // CUdeviceptr
constexpr Result kOutOfMemory = 2;   // CUDA_ERROR_OUT_OF_MEMORY
constexpr unsigned kNonBlocking = 1;
constexpr unsigned kDisableTiming = 2;
constexpr int kCapabilityMajor = 75, kCapabilityMinor = 76;  // CUdevice_attribute

struct Driver {
  Result (*init)(unsigned);
  Result (*device_count)(int*);
  Result (*device_get)(int*, int);
  Result (*device_attribute)(int*, int, int);
  Result (*context_retain)(void**, int);
  Result (*context_release)(int);
  Result (*context_push)(void*);
  Result (*context_pop)(void**);
  Result (*context_synchronize)();
  Result (*memory_allocate)(Address*, std::size_t);
  Result (*memory_free)(Address);
  Result (*memory_allocate_on)(Address*, std::size_t, void*);
  Result (*memory_free_on)(Address, void*);
  Result (*copy_to_device)(Address, const void*, std::size_t);
  Result (*copy_to_host)(void*, Address, std::size_t);
  Result (*stream_create)(void**, unsigned);
  Result (*stream_destroy)(void*);
  Result (*stream_wait)(void*, void*, unsigned);
  Result (*event_create)(void**, unsigned);
  Result (*event_record)(void*, void*);
  Result (*event_destroy)(void*);
  Result (*error_string)(Result, const char**);
};

template <class Function>
void find(void* library, const char* name, Function* function) {
  *function = reinterpret_cast<Function>(dlsym(library, name));
  if (*function == nullptr)
    throw Error(CHIASM_UNAVAILABLE, std::string("the CUDA driver is too old: it has no ") + name);
}

Driver open_driver() {
  void* library = dlopen("libcuda.so.1", RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) {
    throw Error(CHIASM_UNAVAILABLE,
                std::string("there is no CUDA driver on this machine (") + dlerror() + ")");
  }
  Driver d{};
  find(library, "cuInit", &d.init);
  find(library, "cuDeviceGetCount", &d.device_count);
  find(library, "cuDeviceGet", &d.device_get);
  find(library, "cuDeviceGetAttribute", &d.device_attribute);
  find(library, "cuDevicePrimaryCtxRetain", &d.context_retain);
  find(library, "cuDevicePrimaryCtxRelease_v2", &d.context_release);
  find(library, "cuCtxPushCurrent_v2", &d.context_push);
  find(library, "cuCtxPopCurrent_v2", &d.context_pop);
  find(library, "cuCtxSynchronize", &d.context_synchronize);
  find(library, "cuMemAlloc_v2", &d.memory_allocate);
  find(library, "cuMemFree_v2", &d.memory_free);
  find(library, "cuMemAllocAsync", &d.memory_allocate_on);
  find(library, "cuMemFreeAsync", &d.memory_free_on);
  find(library, "cuMemcpyHtoD_v2", &d.copy_to_device);
  find(library, "cuMemcpyDtoH_v2", &d.copy_to_host);
  find(library, "cuStreamCreate", &d.stream_create);
  find(library, "cuStreamDestroy_v2", &d.stream_destroy);
  find(library, "cuStreamWaitEvent", &d.stream_wait);
  find(library, "cuEventCreate", &d.event_create);
  find(library, "cuEventRecord", &d.event_record);
  find(library, "cuEventDestroy_v2", &d.event_destroy);
  find(library, "cuGetErrorString", &d.error_string);
  return d;
}

const Driver& driver() {
  static const Driver instance = open_driver();  // tried again at the next call if it throws
  return instance;
}

/** Throws Error for a call that failed: OUT_OF_MEMORY if the device has none left, else `code`. */
void check(Result result, const char* what, chiasm_code code = CHIASM_INTERNAL) {
  if (result == 0) return;
  const char* text = nullptr;
  driver().error_string(result, &text);
  throw Error(result == kOutOfMemory ? CHIASM_OUT_OF_MEMORY : code,
              std::string(what) + ": " + (text != nullptr ? text : "unknown CUDA error"));
}

}  // namespace

CudaDevice::CudaDevice(int32_t index) {
  check(driver().init(0), "the CUDA driver found no device it can use (cuInit)", CHIASM_UNAVAILABLE);
  int count = 0;
  check(driver().device_count(&count), "cuDeviceGetCount", CHIASM_UNAVAILABLE);
  if (index < 0 || index >= count)
    throw Error(CHIASM_UNAVAILABLE, "there is no CUDA device " + std::to_string(index) +
                                        "; this machine has " + std::to_string(count));
  check(driver().device_get(&device_, index), "cuDeviceGet", CHIASM_UNAVAILABLE);
  check(driver().context_retain(&context_, device_), "cuDevicePrimaryCtxRetain", CHIASM_UNAVAILABLE);
}

CudaDevice::~CudaDevice() { driver().context_release(device_); }

int64_t CudaDevice::capability() const {
  int major = 0, minor = 0;
  check(driver().device_attribute(&major, kCapabilityMajor, device_), "cuDeviceGetAttribute");
  check(driver().device_attribute(&minor, kCapabilityMinor, device_), "cuDeviceGetAttribute");
  return 10 * major + minor;
}

CudaDevice::Current::Current(const CudaDevice& device) {
  check(driver().context_push(device.context_), "cuCtxPushCurrent");
}

CudaDevice::Current::~Current() {
  void* popped = nullptr;
  driver().context_pop(&popped);
}

void* CudaDevice::allocate(std::size_t bytes, void* stream) noexcept {
  Address address = 0;
  if (driver().memory_allocate_on(&address, bytes > 0 ? bytes : 1, stream) != 0) return nullptr;
  return reinterpret_cast<void*>(address);
}

void CudaDevice::release(void* data, void* stream) noexcept {
  if (data != nullptr) driver().memory_free_on(reinterpret_cast<Address>(data), stream);
}

CudaStream::CudaStream(const CudaDevice& device) : device_(device) {
  const CudaDevice::Current current(device_);
  check(driver().stream_create(&stream_, kNonBlocking), "cuStreamCreate");
}

CudaStream::~CudaStream() {
  try {
    const CudaDevice::Current current(device_);
    driver().stream_destroy(stream_);
  } catch (const Error&) {  // the driver is shutting down, and the stream with it
  }
}

void CudaStream::order(void* first, void* then) {
  const CudaDevice::Current current(device_);
  void* event = nullptr;
  check(driver().event_create(&event, kDisableTiming), "cuEventCreate");
  Result result = driver().event_record(event, first);
  if (result == 0) result = driver().stream_wait(then, event, 0);
  driver().event_destroy(event);  // the driver keeps it until the streams have passed it
  check(result, "ordering of CUDA streams");
}

CudaBuffer::CudaBuffer(int32_t device_index, std::size_t bytes)
    : device_(std::make_shared<const CudaDevice>(device_index)) {
  const CudaDevice::Current current(*device_);
  Address address = 0;
  check(driver().memory_allocate(&address, bytes > 0 ? bytes : 1),
        ("cuMemAlloc of " + std::to_string(bytes) + " bytes").c_str());
  data_ = reinterpret_cast<void*>(address);
}

CudaBuffer::CudaBuffer(CudaBuffer&& other) noexcept
    : device_(std::move(other.device_)), data_(std::exchange(other.data_, nullptr)) {}

CudaBuffer& CudaBuffer::operator=(CudaBuffer&& other) noexcept {
  std::swap(device_, other.device_);
  std::swap(data_, other.data_);
  return *this;
}

CudaBuffer::~CudaBuffer() {
  if (data_ == nullptr) return;
  try {
    const CudaDevice::Current current(*device_);
    driver().memory_free(reinterpret_cast<Address>(data_));
  } catch (const Error&) {  // the context is gone, and the memory with it
  }
}

void CudaBuffer::copy_from_host(const void* source, std::size_t bytes) {
  const CudaDevice::Current current(*device_);
  check(driver().copy_to_device(reinterpret_cast<Address>(data_), source, bytes), "cuMemcpyHtoD");
}

void CudaBuffer::copy_to_host(void* target, std::size_t bytes) const {
  const CudaDevice::Current current(*device_);
  check(driver().context_synchronize(), "cuCtxSynchronize");
  check(driver().copy_to_host(target, reinterpret_cast<Address>(data_), bytes), "cuMemcpyDtoH");
}

bool cuda_device_present() {
  const char* visible = std::getenv("CUDA_VISIBLE_DEVICES");
  if (visible != nullptr && (visible[0] == '\0' || visible[0] == '-')) return false;
  return access("/dev/nvidiactl", F_OK) == 0 || access("/dev/nvgpu", F_OK) == 0 ||
         access("/dev/dxg", F_OK) == 0;
}

}  // namespace chiasm::base
