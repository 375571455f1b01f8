// The native backend: runs AOTInductor code that contains its own replacement of libtorch, so that no engine
// is needed. An artifact is a zip archive with one shared library; the library is loaded from memory.
#include <atomic>
#include <string>

#include "backends/native/compiled_op.h"
#include "backends/native/workers.h"
#include "base/fork.h"
#include "base/pool.h"

namespace {

using chiasm::base::CudaDevice;
using chiasm::base::ForkGate;
using chiasm::base::Pool;
using chiasm::native::CompiledOp;
using chiasm::native::Workers;
using chiasm::plugin::guard;

/** A method's share of the process's threads. */
struct Team {
  Workers* workers = nullptr;
  int32_t others = 0;  // how many besides the caller's
};

// One loaded artifact. `run` may be called from several threads at once.
class NativeMethod {
 public:
  explicit NativeMethod(const chiasm_backend_load& request)
      : num_threads_(request.num_threads),
        process_threads_(request.process_threads),
        device_type_(request.device_type),
        op_({request.data, request.size, request.input_count, request.output_count, request.batched_inputs,
             request.batched_outputs, request.device_type, request.device_index, request.signature}) {}

  void run(const chiasm_tensor* inputs, const chiasm_tensor* outputs,
           const chiasm_run_options* options) const {
    chiasm_native_host host{};
    Team team;
    host.num_threads = num_threads_ > 1 && op_.worth_forking(inputs, outputs) ? num_threads_ : 1;
    if (device_type_ == CHIASM_CUDA) {
      host.num_threads = 1;
      host.stream = options != nullptr ? options->stream : nullptr;
      host.context = host.stream;
      host.allocate = [](void* stream, size_t bytes) { return CudaDevice::allocate(bytes, stream); };
      host.release = [](void* stream, void* data, size_t) { CudaDevice::release(data, stream); };
    } else {
      if (host.num_threads > 1) team = {&Workers::instance(process_threads_ - 1), num_threads_ - 1};
      host.context = &team;
      host.allocate = [](void*, size_t bytes) { return Pool::instance().allocate(bytes); };
      host.release = [](void*, void* data, size_t bytes) { Pool::instance().release(data, bytes); };
      host.fork = [](void* context, Workers::Body body, void* argument) {
        const Team& team = *static_cast<const Team*>(context);
        team.workers->fork(body, argument, team.others);
      };
    }
    op_.run(inputs, outputs, host, [](void* context, Workers::Body body, void* argument) {
      const Team& team = *static_cast<const Team*>(context);
      team.workers->share(body, argument, team.others);
    });
  }

 private:
  int32_t num_threads_, process_threads_, device_type_;
  CompiledOp op_;
};

int32_t probe(chiasm_backend_info* info, chiasm_error_text*) {
  info->engine_version = "native code, interface 4";
  static_assert(CHIASM_NATIVE_ABI == 4, "say the new number above");
  info->has_cuda = chiasm::base::cuda_device_present() ? 1 : 0;
  return CHIASM_OK;
}

std::atomic<int> methods{0};

int32_t load(const chiasm_backend_load* request, void** model, chiasm_error_text* error) {
  return guard(error, [&] {
    const ForkGate::Passage passage;
    *model = new NativeMethod(*request);
    ++methods;
  });
}

int32_t run(void* model, const chiasm_tensor* inputs, const chiasm_tensor* outputs,
            const chiasm_run_options* options, chiasm_error_text* error) {
  return guard(error, [&] {
    const ForkGate::Passage passage;
    static_cast<const NativeMethod*>(model)->run(inputs, outputs, options);
  });
}

void unload(void* model) {
  const ForkGate::Passage passage;
  delete static_cast<NativeMethod*>(model);
  if (--methods == 0) Pool::instance().trim();
}

constexpr chiasm_backend_format kFormats[] = {{"aotinductor", 1}, {nullptr, 0}};
constexpr chiasm_backend_option kOptions[] = {{nullptr, nullptr, nullptr}};
constexpr int32_t kPriority = 300;  // the fastest to load and to run

const chiasm_backend backend{sizeof(chiasm_backend),
                             CHIASM_BACKEND_ABI,
                             "native",
                             kPriority,
                             kFormats,
                             1u << CHIASM_CPU | 1u << CHIASM_CUDA,
                             kOptions,
                             probe,
                             nullptr,
                             load,
                             run,
                             unload};

}  // namespace

extern "C" CHIASM_EXPORT const chiasm_backend* chiasm_backend_entry(uint32_t abi) {
  return abi == CHIASM_BACKEND_ABI ? &backend : nullptr;
}
