// The native backend: runs AOTInductor code that carries its own shim, so that neither libtorch nor any other engine is
// needed. An artifact is a zip archive with one shared library; the library is loaded from memory.
#include <dlfcn.h>

#include <array>
#include <atomic>
#include <memory>
#include <optional>
#include <string>

#include "backends/cuda.h"
#include "backends/native/archive.h"
#include "backends/native/pool.h"
#include "backends/plugin.h"
#include "shim/abi.h"

namespace {

using chiasm::native::extract_library;
using chiasm::native::Pool;
using chiasm::plugin::CudaDevice;
using chiasm::plugin::Error;
using chiasm::plugin::guard;
using chiasm::plugin::MemoryFile;

constexpr int32_t kMaxTensors = 64;  // inputs, and outputs, of one method

Pool& pool() {
  static Pool& instance = *new Pool;  // never destroyed: a thread may still run at exit
  return instance;
}

// dlopen knows libraries by the text of their path, and takes one that it has for one that has just been written where
// the number of a closed file is used again. So each path is new: "/" and "/./" between its parts spell a count.
std::string unique_path(const MemoryFile& file) {
  static std::atomic<unsigned> count{0};
  std::string path = "/proc/self/fd";
  for (unsigned bits = ++count; bits != 0; bits /= 2) path += bits % 2 != 0 ? "/." : "/";
  return path + "/" + std::to_string(file.fd());
}

class Library {
 public:
  explicit Library(const MemoryFile& file) : handle_(dlopen(unique_path(file).c_str(), RTLD_NOW | RTLD_LOCAL)) {
    if (handle_ == nullptr) throw Error(CHIASM_UNAVAILABLE, std::string("cannot load the native code: ") + dlerror());
  }
  Library(const Library&) = delete;
  Library& operator=(const Library&) = delete;
  ~Library() { dlclose(handle_); }

  const chiasm_native_api* api() const {
    const auto entry = reinterpret_cast<chiasm_native_entry_fn>(dlsym(handle_, CHIASM_NATIVE_ENTRY));
    if (entry == nullptr) throw Error(CHIASM_CORRUPT, "the native code has no entry point " CHIASM_NATIVE_ENTRY);
    const chiasm_native_api* api = entry(CHIASM_NATIVE_ABI);
    if (api == nullptr || api->abi != CHIASM_NATIVE_ABI || api->struct_size < sizeof(chiasm_native_api))
      throw Error(CHIASM_VERSION_MISMATCH, "the native code was built for another interface version than " +
                                               std::to_string(CHIASM_NATIVE_ABI) + "; export the bundle again");
    return api;
  }

 private:
  void* handle_;
};

// One loaded artifact. `run` may be called from several threads at once.
class Model {
 public:
  explicit Model(const chiasm_backend_load& request)
      : device_type_(request.device_type),
        device_index_(request.device_index),
        num_threads_(request.num_threads),
        input_count_(request.input_count),
        output_count_(request.output_count) {
    if (std::string(request.format) != "aotinductor")
      throw Error(CHIASM_INVALID_ARGUMENT, std::string("the native backend reads aotinductor artifacts, not ") + request.format);
    if (input_count_ > kMaxTensors || output_count_ > kMaxTensors)
      throw Error(CHIASM_INVALID_ARGUMENT, "more than " + std::to_string(kMaxTensors) + " inputs or outputs");
    if (device_type_ == CHIASM_CUDA) cuda_.emplace(device_index_);
    const auto current = make_current();
    library_.emplace(extract_library(request.data, request.size));
    api_ = library_->api();
    char text[1024] = "";
    if (api_->create(device_type_, device_index_, &model_, text, sizeof(text)) != 0) throw Error(CHIASM_INTERNAL, text);
  }
  Model(const Model&) = delete;
  Model& operator=(const Model&) = delete;
  ~Model() {
    try {
      const auto current = make_current();
      api_->destroy(model_);
    } catch (...) {  // the device is gone: so is what the model held there
    }
  }

  void run(const chiasm_tensor* inputs, const chiasm_tensor* outputs, const chiasm_run_options* options) {
    std::array<chiasm_native_tensor, kMaxTensors> in;
    std::array<chiasm_native_tensor, kMaxTensors> out;
    for (int32_t i = 0; i < input_count_; ++i) in[i] = {inputs[i].data, inputs[i].dtype, inputs[i].ndim, inputs[i].shape};
    for (int32_t i = 0; i < output_count_; ++i) out[i] = {outputs[i].data, outputs[i].dtype, outputs[i].ndim, outputs[i].shape};

    chiasm_native_host host{};
    host.device_type = device_type_;
    host.device_index = device_index_;
    host.num_threads = num_threads_;
    if (device_type_ == CHIASM_CUDA) {
      host.stream = options != nullptr ? options->stream : nullptr;
      host.context = host.stream;
      host.allocate = [](void* stream, size_t bytes) { return CudaDevice::allocate(bytes, stream); };
      host.release = [](void* stream, void* data, size_t) { CudaDevice::release(data, stream); };
    } else {
      host.context = &pool();
      host.allocate = [](void* p, size_t bytes) { return static_cast<Pool*>(p)->allocate(bytes); };
      host.release = [](void* p, void* data, size_t bytes) { static_cast<Pool*>(p)->release(data, bytes); };
    }
    const auto current = make_current();
    char text[1024];
    text[0] = '\0';
    if (api_->run(model_, in.data(), out.data(), &host, text, sizeof(text)) != 0) throw Error(CHIASM_INTERNAL, text);
  }

 private:
  std::optional<CudaDevice::Current> make_current() const {
    return cuda_ ? std::optional<CudaDevice::Current>(std::in_place, *cuda_) : std::nullopt;
  }

  int32_t device_type_, device_index_, num_threads_, input_count_, output_count_;
  std::optional<CudaDevice> cuda_;
  std::optional<Library> library_;  // outlives the model, whose code it is
  const chiasm_native_api* api_ = nullptr;
  void* model_ = nullptr;
};

int32_t probe(chiasm_backend_info* info, chiasm_error_text*) {
  info->engine_version = "native code, interface 1";
  static_assert(CHIASM_NATIVE_ABI == 1, "say the new number above");
  info->has_cuda = chiasm::plugin::cuda_device_present() ? 1 : 0;
  return CHIASM_OK;
}

std::atomic<int> models{0};

int32_t load(const chiasm_backend_load* request, void** model, chiasm_error_text* error) {
  return guard(error, [&] {
    *model = new Model(*request);
    ++models;
  });
}

int32_t run(void* model, const chiasm_tensor* inputs, const chiasm_tensor* outputs, const chiasm_run_options* options,
            chiasm_error_text* error) {
  return guard(error, [&] { static_cast<Model*>(model)->run(inputs, outputs, options); });
}

void unload(void* model) {
  delete static_cast<Model*>(model);
  if (--models == 0) pool().trim();
}

const chiasm_backend backend{sizeof(chiasm_backend), CHIASM_BACKEND_ABI, "native", probe, load, run, unload};

}  // namespace

extern "C" CHIASM_EXPORT const chiasm_backend* chiasm_backend_entry(uint32_t abi) {
  return abi == CHIASM_BACKEND_ABI ? &backend : nullptr;
}
