// The native backend: runs AOTInductor code that carries what it needs of libtorch, so that neither libtorch nor any other engine is
// needed. An artifact is a zip archive with one shared library; the library is loaded from memory.
#include <atomic>
#include <string>

#include "backends/native/model.h"
#include "backends/native/pool.h"
#include "backends/native/workers.h"
#include "core/fork.h"

namespace {

using chiasm::native::Pool;
using chiasm::core::ForkGate;
using chiasm::native::Workers;
using chiasm::plugin::CudaDevice;
using chiasm::plugin::Error;
using chiasm::plugin::guard;

class Model {
 public:
  explicit Model(const chiasm_backend_load& request)
      : num_threads_(request.num_threads),
        device_type_(request.device_type),
        artifact_({request.data, request.size, request.input_count, request.output_count, request.sample_inputs,
                   request.sample_outputs, request.device_type, request.device_index, request.signature}) {
    if (std::string(request.format) != "aotinductor")
      throw Error(CHIASM_INVALID_ARGUMENT, std::string("the native backend reads aotinductor artifacts, not ") + request.format);
  }

  void run(const chiasm_tensor* inputs, const chiasm_tensor* outputs, const chiasm_run_options* options) const {
    chiasm_native_host host{};
    host.num_threads = num_threads_ > 1 && artifact_.worth_forking(inputs, outputs) ? num_threads_ : 1;
    if (device_type_ == CHIASM_CUDA) {
      host.num_threads = 1;
      host.stream = options != nullptr ? options->stream : nullptr;
      host.context = host.stream;
      host.allocate = [](void* stream, size_t bytes) { return CudaDevice::allocate(bytes, stream); };
      host.release = [](void* stream, void* data, size_t) { CudaDevice::release(data, stream); };
    } else {
      if (host.num_threads > 1) host.context = &Workers::instance(num_threads_ - 1);
      host.allocate = [](void*, size_t bytes) { return Pool::instance().allocate(bytes); };
      host.release = [](void*, void* data, size_t bytes) { Pool::instance().release(data, bytes); };
      host.fork = [](void* workers, Workers::Body body, void* argument) { static_cast<Workers*>(workers)->fork(body, argument); };
    }
    artifact_.run(inputs, outputs, host, [](void* workers, Workers::Body body, void* argument) { static_cast<Workers*>(workers)->share(body, argument); });
  }

 private:
  int32_t num_threads_, device_type_;
  chiasm::native::Model artifact_;
};

int32_t probe(chiasm_backend_info* info, chiasm_error_text*) {
  info->engine_version = "native code, interface 3";
  static_assert(CHIASM_NATIVE_ABI == 3, "say the new number above");
  info->has_cuda = chiasm::plugin::cuda_device_present() ? 1 : 0;
  return CHIASM_OK;
}

std::atomic<int> models{0};

int32_t load(const chiasm_backend_load* request, void** model, chiasm_error_text* error) {
  return guard(error, [&] {
    const ForkGate::Passage passage;
    *model = new Model(*request);
    ++models;
  });
}

int32_t run(void* model, const chiasm_tensor* inputs, const chiasm_tensor* outputs, const chiasm_run_options* options,
            chiasm_error_text* error) {
  return guard(error, [&] {
    const ForkGate::Passage passage;
    static_cast<const Model*>(model)->run(inputs, outputs, options);
  });
}

void unload(void* model) {
  const ForkGate::Passage passage;
  delete static_cast<Model*>(model);
  if (--models == 0) Pool::instance().trim();
}

const chiasm_backend backend{sizeof(chiasm_backend), CHIASM_BACKEND_ABI, "native", probe, load, run, unload};

}  // namespace

extern "C" CHIASM_EXPORT const chiasm_backend* chiasm_backend_entry(uint32_t abi) {
  return abi == CHIASM_BACKEND_ABI ? &backend : nullptr;
}
