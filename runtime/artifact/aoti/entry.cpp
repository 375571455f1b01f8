// Stands in for libtorch in a torch-free native artifact: the exporter links this statically with
// AOTInductor's code.
//
// Outputs without a copy: AOTInductor allocates its outputs itself. Except for loops, the generated code is
// straight-line, so the n-th allocation of a run is always the same buffer. The first run notes which
// allocation became which output (the *plan*) and copies; in later runs that allocation returns the caller's
// memory, and the op writes into it directly. If a loop ran for more or fewer iterations, another buffer may
// get that memory; the results are then copied to the right outputs.
//
// AOTInductor writes its interface of C functions into the code of every op, where it took three quarters of
// the compile time. The exporter omits it, and this file has the part that is needed: an op's code is only
// the class AOTInductorModel.
#include <torch/csrc/inductor/aoti_runtime/model_container.h>
#include <torch/csrc/inductor/aoti_torch/c/shim.h>

#include <algorithm>
#include <cstdio>
#include <mutex>
#include <new>
#include <utility>

#include "base/dtype.h"
#include "memory.h"
#include "tensor.h"

namespace __gnu_cxx {
void __freeres();  // NOLINT(bugprone-reserved-identifier): the name is libstdc++'s
}

namespace chiasm::artifact {
namespace {

// Every artifact has its own libstdc++, which reserves 72 KB for exceptions that are thrown when memory is
// short. It does not free them when the artifact is closed, so a server that loads and unloads models would
// lose 72 KB each time.
__attribute__((destructor)) void give_back_reserve() { __gnu_cxx::__freeres(); }

// Plain memory: a thread_local with a destructor would pin the library in the process.
thread_local char last_error[1024];
thread_local bool out_of_memory;

// How many threads may be inside a model before the next waits; a runner holds no memory between runs. On
// CUDA one is enough: each runner would load the op's code into the device, and a run only enqueues.
const size_t kRunners = memory::host_can_read ? 16 : 1;

struct CompiledModel {
  explicit CompiledModel(const std::string& device) : container(kRunners, device) {}

  torch::aot_inductor::AOTInductorModelContainer container;
  std::mutex mutex;  // guards `plan`, which is null until the first run ends, and then never changes
  std::shared_ptr<const std::vector<int64_t>> plan;

  std::shared_ptr<const std::vector<int64_t>> get_plan() {
    std::lock_guard<std::mutex> lock(mutex);
    return plan;
  }
};

int32_t fail(const char* text, char* error, size_t size, int32_t result = CHIASM_NATIVE_FAILED) {
  if (size) std::snprintf(error, size, "%s", text);
  return result;
}

// What an earlier call noted on this thread is not an error of this call.
void forget_errors() {
  *last_error = 0;
  out_of_memory = false;
}

// Calls AOTInductor's code. The error that it reports is the text noted in this file, else the exception's.
// Reporting allocates nothing, because there may be no memory.
template <class Call>
int32_t engine(Call call, char* error, size_t size) {
  try {
    call();
    return 0;
  } catch (const std::bad_alloc&) {
    guarded_out_of_memory();
  } catch (const std::exception& e) {
    if (!*last_error) guarded_failure(e.what());
  } catch (...) {
    if (!*last_error) guarded_failure("the compiled op failed without a message");
  }
  return fail(last_error, error, size, out_of_memory ? CHIASM_NATIVE_OUT_OF_MEMORY : CHIASM_NATIVE_FAILED);
}

int32_t create(int32_t device_type, int32_t device_index, void** result, char* error, size_t error_size) {
  forget_errors();
  return engine(
      [&] { *result = new CompiledModel(device_type == 0 ? "cpu" : "cuda:" + std::to_string(device_index)); },
      error, error_size);
}

void destroy(void* handle) {
  memory::wait_for_all();
  delete static_cast<CompiledModel*>(handle);
}

AtenTensorOpaque* borrow(const chiasm_tensor& view, const chiasm_native_host& host) {
  auto tensor = std::make_unique<AtenTensorOpaque>();
  tensor->dtype = base::kDTypes[view.dtype].torch;
  tensor->sizes.assign(view.shape, view.shape + view.ndim);
  tensor->strides = dense_strides(tensor->sizes);
  tensor->device_type = host.device_type;
  tensor->device_index = host.device_index;
  tensor->storage = std::make_shared<Storage>();
  tensor->storage->data = static_cast<char*>(view.data);
  tensor->storage->bytes = tensor->numel() * element_size(tensor->dtype);
  if (tensor->numel() > memory::most_elements)
    throw std::runtime_error("a tensor of " + std::to_string(tensor->numel()) +
                             " elements is larger than the compiled op takes, " +
                             std::to_string(memory::most_elements) + ": split the batch");
  return tensor.release();
}

// Deletes the handles it holds, so that an error in the middle of a run leaks nothing.
struct Handles {
  std::vector<AtenTensorHandle> list;
  explicit Handles(size_t n) : list(n, nullptr) {}
  ~Handles() {
    for (auto* handle : list) delete handle;
  }
};

struct CurrentRun {
  explicit CurrentRun(Run* run) { current_run() = run; }
  ~CurrentRun() { current_run() = nullptr; }
};

int32_t run(void* handle, const chiasm_tensor* inputs, const chiasm_tensor* outputs,
            const chiasm_native_host* host, char* error, size_t error_size) {
  forget_errors();
  try {
    auto& model = *static_cast<CompiledModel*>(handle);
    const size_t n_in = model.container.num_inputs(), n_out = model.container.num_outputs();
    const auto plan = model.get_plan();
    Run state(host, outputs, n_out, plan.get());
    CurrentRun scope(&state);

    Handles arguments(n_in), results(n_out);
    for (size_t i = 0; i < n_in; ++i) arguments.list[i] = borrow(inputs[i], *host);
    auto stolen = std::exchange(arguments.list, {});  // from here on the engine owns them, even if it fails
    const auto work = [&] {
      model.container.run(stolen.data(), results.list.data(),
                          static_cast<torch::aot_inductor::DeviceStreamType>(host->stream), nullptr);
    };
    if (const int32_t failed = engine(work, error, error_size)) return failed;
    if (state.refused.load(std::memory_order_acquire))
      return fail(state.refusal, error, error_size, CHIASM_NATIVE_BAD_VALUE);

    state.plan = nullptr;  // later allocations are scratch
    for (size_t k = 0; k < n_out; ++k)
      for (size_t other = 0; other < n_out; ++other) {
        auto*& result = results.list[k];
        if (result->storage->data != outputs[other].data || !outputs[other].data) continue;
        if (other == k && result->is_dense() && result->offset == 0) continue;
        // The result is in the memory of another output, or in its own with other strides (a transposed
        // result is dense if a size is 1, as it may have been in the run that made the plan): move it away
        // before the outputs are written.
        std::unique_ptr<AtenTensorOpaque> moved(
            allocate(result->sizes, dense_strides(result->sizes), result->dtype));
        copy(*result, *moved);
        delete std::exchange(result, moved.release());
        break;
      }
    std::vector<int64_t> found(n_out, -1);
    for (size_t k = 0; k < n_out; ++k) {
      const AtenTensorOpaque& result = *results.list[k];
      std::unique_ptr<AtenTensorOpaque> target(borrow(outputs[k], *host));
      if (result.dtype != target->dtype || result.sizes != target->sizes)
        throw std::runtime_error("output " + std::to_string(k) +
                                 " of the compiled op differs from the manifest in shape or dtype");
      if (result.data() == target->data()) continue;
      if (result.is_dense() && result.offset == 0) found[k] = result.storage->ordinal;
      copy(result, *target);
    }
    if (!plan) {
      std::lock_guard<std::mutex> lock(model.mutex);
      if (!model.plan) model.plan = std::make_shared<std::vector<int64_t>>(std::move(found));
    }
    return 0;
  } catch (const std::bad_alloc&) {
    return fail("out of memory", error, error_size, CHIASM_NATIVE_OUT_OF_MEMORY);
  } catch (const std::exception& e) {
    return fail(e.what(), error, error_size,
                out_of_memory ? CHIASM_NATIVE_OUT_OF_MEMORY : CHIASM_NATIVE_FAILED);
  }
}

}  // namespace

Run*& current_run() {
  thread_local Run* run = nullptr;
  return run;
}

int32_t guarded_failure(const char* what) {
  std::snprintf(last_error, sizeof last_error, "%s", what);
  return AOTI_TORCH_FAILURE;
}

int32_t guarded_out_of_memory() {
  out_of_memory = true;
  return guarded_failure("out of memory");
}

AtenTensorOpaque* allocate(Dims sizes, Dims strides, int32_t dtype) {
  Run* run = current_run();
  if (!run) throw std::runtime_error("the compiled op allocates outside of a run");
  auto tensor = std::make_unique<AtenTensorOpaque>();
  const int64_t elements = span(sizes, strides);
  tensor->sizes = std::move(sizes);
  tensor->strides = std::move(strides);
  tensor->dtype = dtype;
  tensor->device_type = run->host->device_type;
  tensor->device_index = run->host->device_index;
  tensor->storage = std::make_shared<Storage>();
  auto& storage = *tensor->storage;
  storage.bytes = elements * element_size(dtype);
  storage.ordinal = run->allocations++;
  for (size_t k = 0; run->plan && k < run->output_count; ++k) {
    if ((*run->plan)[k] != storage.ordinal) continue;
    const auto& output = run->outputs[k];
    if (base::byte_count(output) != storage.bytes) break;
    storage.data = static_cast<char*>(output.data);
    return tensor.release();
  }
  storage.data = static_cast<char*>(run->host->allocate(run->host->context, storage.bytes));
  if (!storage.data && storage.bytes) {
    out_of_memory = true;
    throw std::runtime_error("out of memory: the op asked for " + std::to_string(storage.bytes) +
                             " bytes to work in");
  }
  storage.owner = run->host;
  return tensor.release();
}

void copy(const AtenTensorOpaque& source, AtenTensorOpaque& target) {
  const int64_t size = element_size(source.dtype), n = source.numel();
  if (n == 0) return;
  if (source.is_dense() && target.is_dense()) {
    memory::copy(target.data(), source.data(), n * size);
    return;
  }
  if (!memory::host_can_read)  // the exporter makes results dense (python/chiasm/export/patches/cuda.py)
    throw std::runtime_error("the compiled op copies a strided tensor, which is not done on CUDA");
  Dims index(source.sizes.size(), 0);
  for (int64_t i = 0; i < n; ++i) {
    int64_t from = 0, to = 0;
    for (size_t d = 0; d < index.size(); ++d) {
      from += index[d] * source.strides[d];
      to += index[d] * target.strides[d];
    }
    std::memcpy(target.data() + to * size, source.data() + from * size, size);
    for (size_t d = index.size(); d-- > 0 && ++index[d] == source.sizes[d];) index[d] = 0;
  }
}

}  // namespace chiasm::artifact

// Compiled for each artifact (python/chiasm/export/formats/native.py).
extern "C" const char chiasm_native_signature[];

extern "C" __attribute__((visibility("default"))) const chiasm_native_api* chiasm_native_entry(uint32_t abi) {
  using namespace chiasm::artifact;
  static const chiasm_native_api api{sizeof(chiasm_native_api), CHIASM_NATIVE_ABI, create, run, destroy,
                                     chiasm_native_signature};
  return abi == CHIASM_NATIVE_ABI ? &api : nullptr;
}
