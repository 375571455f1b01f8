#include "core/cuda.h"

#include <dlfcn.h>

#include <map>
#include <mutex>
#include <string>
#include <utility>

#include "core/status.h"

namespace chiasm::core {
namespace {

/** libcuda.so.1, by its documented C interface: results are int, devices int, contexts pointers. */
class Driver final {
 public:
  using Address = unsigned long long;
  using Context = void*;

  static Driver& instance() {
    static Driver* const driver = new Driver;
    return *driver;
  }

  /** The device's compute capability. */
  int64_t capability(int32_t index) {
    const int device = get_device(index);
    constexpr int kMajor = 75, kMinor = 76;
    int major = 0, minor = 0;
    check(get_attribute_(&major, kMajor, device), "cuDeviceGetAttribute");
    check(get_attribute_(&minor, kMinor, device), "cuDeviceGetAttribute");
    return 10 * major + minor;
  }

  /** The primary context of a device, retained once for the process. */
  Context context(int32_t index) {
    const int device = get_device(index);
    const std::lock_guard<std::mutex> lock(mutex_);
    Context& context = contexts_[index];
    if (context == nullptr) check(retain_(&context, device), "cuDevicePrimaryCtxRetain");
    return context;
  }

  static void check(int result, const char* call) {
    if (result != 0) fail(CHIASM_UNAVAILABLE, std::string("CUDA: ") + call + " failed with error " + std::to_string(result));
  }

  int (*push_)(Context) = nullptr;
  int (*pop_)(Context*) = nullptr;
  int (*allocate_)(Address*, size_t) = nullptr;
  int (*release_)(Address) = nullptr;
  int (*to_device_)(Address, const void*, size_t) = nullptr;
  int (*to_host_)(void*, Address, size_t) = nullptr;
  int (*synchronize_)() = nullptr;

 private:
  Driver() {
    library_ = ::dlopen("libcuda.so.1", RTLD_NOW | RTLD_LOCAL);
    if (library_ == nullptr) {
      problem_ = "there is no CUDA driver on this machine (libcuda.so.1 cannot be opened)";
      return;
    }
    int (*init)(unsigned) = nullptr;
    bind(init, "cuInit");
    bind(get_device_, "cuDeviceGet");
    bind(get_count_, "cuDeviceGetCount");
    bind(get_attribute_, "cuDeviceGetAttribute");
    bind(retain_, "cuDevicePrimaryCtxRetain");
    bind(push_, "cuCtxPushCurrent_v2");
    bind(pop_, "cuCtxPopCurrent_v2");
    bind(allocate_, "cuMemAlloc_v2");
    bind(release_, "cuMemFree_v2");
    bind(to_device_, "cuMemcpyHtoD_v2");
    bind(to_host_, "cuMemcpyDtoH_v2");
    bind(synchronize_, "cuCtxSynchronize");
    if (!problem_.empty()) return;
    const int result = init(0);
    if (result != 0) problem_ = "the CUDA driver found no device it can use (cuInit: error " + std::to_string(result) + ")";
  }

  template <class Function>
  void bind(Function& function, const char* name) {
    function = reinterpret_cast<Function>(::dlsym(library_, name));
    if (function == nullptr) problem_ = std::string("the CUDA driver has no ") + name;
  }

  int get_device(int32_t index) {
    if (!problem_.empty()) fail(CHIASM_UNAVAILABLE, problem_);
    int count = 0, device = 0;
    check(get_count_(&count), "cuDeviceGetCount");
    if (index < 0 || index >= count) {
      fail(CHIASM_UNAVAILABLE, "there is no CUDA device " + std::to_string(index) + "; this machine has " + std::to_string(count));
    }
    check(get_device_(&device, index), "cuDeviceGet");
    return device;
  }

  void* library_ = nullptr;
  std::string problem_;
  std::mutex mutex_;
  std::map<int32_t, Context> contexts_;
  int (*get_device_)(int*, int) = nullptr;
  int (*get_count_)(int*) = nullptr;
  int (*get_attribute_)(int*, int, int) = nullptr;
  int (*retain_)(Context*, int) = nullptr;
};

/** Makes a device's primary context current in this thread for a while. */
class Current final {
 public:
  explicit Current(int32_t index) { Driver::check(Driver::instance().push_(Driver::instance().context(index)), "cuCtxPushCurrent"); }
  Current(const Current&) = delete;
  Current& operator=(const Current&) = delete;
  ~Current() {
    Driver::Context previous = nullptr;
    Driver::instance().pop_(&previous);
  }
};

}  // namespace

int64_t cuda_compute_capability(int32_t device_index) { return Driver::instance().capability(device_index); }

CudaBuffer::CudaBuffer(int32_t device_index, size_t bytes) : device_index_(device_index) {
  Driver& driver = Driver::instance();
  driver.context(device_index);  // says what is missing before any function of the driver is called
  const Current current(device_index);
  Driver::check(driver.allocate_(&address_, bytes == 0 ? 1 : bytes), "cuMemAlloc");
}

CudaBuffer::CudaBuffer(CudaBuffer&& other) noexcept
    : address_(std::exchange(other.address_, 0)), device_index_(other.device_index_) {}

CudaBuffer& CudaBuffer::operator=(CudaBuffer&& other) noexcept {
  std::swap(address_, other.address_);
  std::swap(device_index_, other.device_index_);
  return *this;
}

CudaBuffer::~CudaBuffer() {
  if (address_ == 0) return;
  try {
    const Current current(device_index_);
    Driver::instance().release_(address_);
  } catch (const Error&) {
    // The context is gone, and the memory with it.
  }
}

void CudaBuffer::copy_from_host(const void* source, size_t bytes) {
  const Current current(device_index_);
  Driver::check(Driver::instance().to_device_(address_, source, bytes), "cuMemcpyHtoD");
}

void CudaBuffer::copy_to_host(void* target, size_t bytes) const {
  const Current current(device_index_);
  Driver::check(Driver::instance().synchronize_(), "cuCtxSynchronize");
  Driver::check(Driver::instance().to_host_(target, address_, bytes), "cuMemcpyDtoH");
}

}  // namespace chiasm::core
