// The torch backend behind its plug-in (plugin.cpp): TorchScript artifacts, AOTInductor artifacts that need
// libtorch, and gradients by autograd.
//
// Only this file, programs.h and cuda.h include torch's headers, which take most of the compile time.
#include <ATen/Context.h>
#include <ATen/Parallel.h>
#include <ATen/TensorIterator.h>
#include <ATen/ops/empty.h>
#include <torch/csrc/autograd/autograd.h>
#include <torch/headeronly/version.h>

#include <algorithm>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "backends/limits.h"
#include "backends/plugin.h"
#include "backends/torch/cuda.h"
#include "backends/torch/programs.h"
#include "base/fork.h"

namespace {

using namespace chiasm::torch_engine;
using chiasm::base::ForkGate;
using chiasm::plugin::guard;

constexpr std::string_view kGradient = "grad_";

at::Device device_of(const chiasm_backend_load& request) {
  if (request.device_type != CHIASM_CUDA) return at::Device(at::kCPU);
  return at::Device(at::kCUDA, static_cast<c10::DeviceIndex>(request.device_index));
}

// One loaded artifact. `run` may be called from several threads at once.
class LoadedProgram {
 public:
  explicit LoadedProgram(const chiasm_backend_load& request)
      : device_(device_of(request)),
        num_threads_(request.num_threads),
        process_threads_(request.process_threads),
        input_count_(static_cast<size_t>(request.input_count)),
        output_count_(static_cast<size_t>(request.output_count)) {
    const std::string format = request.format;
    // A package, and what goes to a GPU, may also fail for what the machine lacks.
    const bool only_reads = format == "torchscript" && !device_.is_cuda();
    translated(only_reads ? CHIASM_CORRUPT : CHIASM_INTERNAL, [&] {
      if (device_.is_cuda()) cuda_ = &Cuda::open(request.device_index);
      const bool autograd = chiasm::plugin::flag(request.artifact_options, "autograd", false);
      if (format == "torchscript") {
        auto script = std::make_unique<Script>(request, device_);
        size_t expected = input_count_;
        if (autograd) expected = plan_gradients(request, script->input_count());
        if (script->input_count() != expected)
          throw Error(CHIASM_CORRUPT, "the program takes " + std::to_string(script->input_count()) +
                                          " inputs, the manifest says " + std::to_string(expected));
        program_ = std::move(script);
      } else if (format == "aotinductor" && !autograd) {
        program_ = std::make_unique<Package>(request, device_);
      } else {
        throw Error(CHIASM_INVALID_ARGUMENT, "the torch backend cannot read a " + format + " artifact" +
                                                 (autograd ? " for autograd" : ""));
      }
    });
  }

  int32_t num_threads() const { return num_threads_; }
  int32_t process_threads() const { return process_threads_; }

  void run(const chiasm_tensor* inputs, const chiasm_tensor* outputs, const chiasm_run_options* options) {
    translated(CHIASM_INTERNAL, [&] {
      const at::NoTF32Guard full_precision;
      std::optional<Cuda::StreamGuard> stream;
      if (cuda_ != nullptr)
        stream.emplace(*cuda_, options != nullptr ? options->stream : nullptr, device_.index());
      if (autograd_) {
        run_gradients(inputs, outputs);
      } else {
        // for programs that compute gradients themselves, such as a step of an optimiser; for others autograd
        // records nothing
        const at::AutoGradMode enabled(true);
        write(program_->forward(views(inputs, input_count_, device_)), outputs);
      }
    });
  }

 private:
  // Turns torch's exceptions into Errors, without the stack traces in their messages. Errors whose kind is
  // unknown get `code`.
  template <class Body>
  static void translated(chiasm_code code, Body&& body) {
    try {
      body();
    } catch (const Error&) {
      throw;
    } catch (const std::bad_alloc&) {
      throw;
    } catch (const c10::Error& e) {
      rethrow(code, e.what_without_backtrace());
    } catch (const std::exception& e) {
      rethrow(code, e.what());  // of TorchScript; it may quote a message with a trace
    }
  }

  [[noreturn]] static void rethrow(chiasm_code code, const std::string& whole) {
    const std::string text =
        whole.substr(0, whole.find("\nException raised from "));  // a stack trace follows
    const auto after = [&text](std::string_view words) {
      const size_t at = text.rfind(words);
      return at == std::string::npos ? std::string() : text.substr(at + words.size());
    };
    const std::string bytes = after("you tried to allocate ");
    if (!bytes.empty())
      throw Error(CHIASM_OUT_OF_MEMORY,
                  "out of memory: " + bytes.substr(0, bytes.find(' ')) + " bytes were asked for");
    if (text.find("bad_alloc") != std::string::npos) throw std::bad_alloc();
    std::string reason = after("\nRuntimeError: ");   // TorchScript's stack comes before it
    const std::string raised = after("\nbuiltins.");  // raised by the op: class, colon, text
    const size_t colon = raised.find(": ");
    if (reason.empty() && colon != std::string::npos) reason = raised.substr(colon + 2);
    if (reason.empty()) reason = text;
    throw Error(code, reason.substr(0, reason.find('\n')));
  }

  // The method's inputs are the forward's, then the gradient of each floating output; its outputs are the
  // gradients of some of the forward's inputs. Returns how many inputs the forward has.
  size_t plan_gradients(const chiasm_backend_load& request, size_t forward_count) {
    autograd_ = true;
    forward_count_ = std::min(forward_count, input_count_);
    for (size_t i = forward_count_; i < input_count_; ++i) {
      if (std::string_view(request.input_names[i]).substr(0, kGradient.size()) != kGradient)
        throw Error(CHIASM_CORRUPT, std::string("input '") + request.input_names[i] +
                                        "' is neither one of the forward nor a gradient");
    }
    for (size_t k = 0; k < output_count_; ++k) {
      const std::string_view name = request.output_names[k];
      size_t i = 0;
      while (i < forward_count_ && std::string(kGradient) + request.input_names[i] != name) ++i;
      if (i == forward_count_)
        throw Error(CHIASM_CORRUPT,
                    "output '" + std::string(name) + "' is not the gradient of an input of the forward");
      differentiated_.push_back(i);
    }
    return forward_count;
  }

  void run_gradients(const chiasm_tensor* inputs, const chiasm_tensor* outputs) {
    const at::AutoGradMode enabled(true);
    const Tensors all = views(inputs, input_count_, device_);
    const Tensors arguments(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(forward_count_));
    Tensors leaves;
    for (const size_t i : differentiated_) leaves.push_back(arguments[i].requires_grad_());

    Tensors results, gradients;
    size_t next = forward_count_;
    for (const at::Tensor& result : program_->forward(arguments)) {
      if (!result.is_floating_point()) continue;
      if (next == input_count_)
        throw Error(CHIASM_CORRUPT, "the forward has more floating outputs than the method has gradients");
      const at::Tensor& gradient = all[next++];
      if (!result.requires_grad()) continue;  // does not depend on any input with a gradient
      if (gradient.sizes() != result.sizes() || gradient.scalar_type() != result.scalar_type())
        throw Error(CHIASM_INVALID_ARGUMENT,
                    "the gradient of an output has another shape or dtype than the output");
      results.push_back(result);
      gradients.push_back(gradient);
    }
    if (next != input_count_)
      throw Error(CHIASM_CORRUPT, "the forward has fewer floating outputs than the method has gradients");

    constexpr bool allow_unused = true;
    Tensors found(leaves.size());
    if (!results.empty())
      found = torch::autograd::grad(results, leaves, gradients, std::nullopt, false, allow_unused);
    const at::NoGradGuard off;
    for (size_t k = 0; k < found.size(); ++k) {
      at::Tensor target = view(outputs[k], device_);
      if (found[k].defined()) {
        target.copy_(found[k], device_.is_cuda());
      } else {
        target.zero_();
      }
    }
  }

  void write(const Tensors& results, const chiasm_tensor* outputs) const {
    if (results.size() != output_count_)
      throw Error(CHIASM_CORRUPT, "the program returned " + std::to_string(results.size()) +
                                      " tensors, the manifest says " + std::to_string(output_count_));
    const at::NoGradGuard off;
    for (size_t k = 0; k < output_count_; ++k) {
      at::Tensor target = view(outputs[k], device_);
      if (results[k].sizes() != target.sizes() || results[k].scalar_type() != target.scalar_type())
        throw Error(CHIASM_CORRUPT, "output " + std::to_string(k) + " of the program is " +
                                        describe(results[k]) + ", the manifest says " + describe(target));
      target.copy_(results[k], device_.is_cuda());
    }
  }

  static std::string describe(const at::Tensor& tensor) {
    std::string text = c10::toString(tensor.scalar_type());
    text += " [";
    for (const int64_t size : tensor.sizes()) text += (text.back() == '[' ? "" : ", ") + std::to_string(size);
    return text + "]";
  }

  at::Device device_;
  int32_t num_threads_, process_threads_;
  const Cuda* cuda_ = nullptr;  // set if the device is a CUDA device
  size_t input_count_, output_count_;
  std::unique_ptr<Program> program_;
  bool autograd_ = false;
  size_t forward_count_ = 0;            // autograd: inputs of the forward
  std::vector<size_t> differentiated_;  // autograd: for each output, the input whose gradient it is
};

void* libtorch_cpu() {
  static void* const library = dlopen("libtorch_cpu.so", RTLD_NOW | RTLD_LOCAL | RTLD_NOLOAD);
  return library;
}

// libtorch's C++ interface changes with every version. With another version than the one it was built for,
// the plug-in would crash without a useful message.
void check_version() {
  // Not by at::show_config: it asks for CUDA's version, and if libtorch_cuda is not open yet, libtorch
  // assumes from then on that there is none.
  const auto version = reinterpret_cast<uint64_t (*)()>(dlsym(libtorch_cpu(), "aoti_torch_abi_version"));
  const uint64_t found = version != nullptr ? version() : 0;
  const auto byte = [](uint64_t number, int place) { return std::to_string(number >> 8 * place & 255); };
  const auto text = [&byte](uint64_t number) { return byte(number, 7) + "." + byte(number, 6); };
  if (found == 0 || text(found) != text(TORCH_ABI_VERSION))
    throw Error(CHIASM_UNAVAILABLE, "the torch backend was built for libtorch " TORCH_VERSION " and found " +
                                        (found == 0 ? "an older one" : text(found) + "." + byte(found, 5)) +
                                        "; install torch " + text(TORCH_ABI_VERSION) +
                                        ", or build chiasm against this one");
}

/** OpenMP's and MKL's numbers of threads, which they keep for each calling thread. At the end they are again
 *  what they were: the caller's own loops use them too. */
class ThreadCounts {
 public:
  ThreadCounts() : openmp_(openmp_count()), mkl_(set_mkl(1)) {}  // MKL says the number only when it is set
  ThreadCounts(const ThreadCounts&) = delete;
  ThreadCounts& operator=(const ThreadCounts&) = delete;
  ~ThreadCounts() {
    set_openmp(openmp_);
    set_mkl(mkl_);
  }

  /** at::set_num_threads would change every thread's. */
  static void set(int count) {
    set_openmp(count);
    set_mkl(count);
  }

 private:
  template <class Function>
  static Function find(const char* name) {
    return reinterpret_cast<Function>(dlsym(libtorch_cpu(), name));
  }

  static int openmp_count() {
    static const auto count = find<int (*)()>("omp_get_max_threads");
    return count == nullptr ? 1 : count();
  }
  static void set_openmp(int count) {
    static const auto set = find<void (*)(int)>("omp_set_num_threads");
    if (set != nullptr) set(count);
  }
  /** Returns the number before; 0 means that of the process. */
  static int set_mkl(int count) {
    static const auto set = find<int (*)(int)>("MKL_Set_Num_Threads_Local");
    return set == nullptr ? 0 : set(count);
  }

  const int openmp_, mkl_;
};

/** A call of libtorch. OpenMP keeps a team of threads for each calling thread. If it cannot create a team it
 *  ends the process, and in a child of fork it waits for the parent's team. So each thread's first call
 *  checks how many threads can be created, and a child's calls work on one thread. */
class Call {
 public:
  Call(int32_t num_threads, int32_t process_threads) {
    thread_local uint32_t prepared = ~uint32_t{0};
    thread_local int32_t most = 1;
    const uint32_t generation = ForkGate::generation();
    if (prepared != generation) {
      // Twice as many, since libtorch may make a second pool, which belongs to XNNPACK.
      most = generation == 0 ? 1 + chiasm::plugin::threads_left(2 * (process_threads - 1)) / 2 : 1;
      at::internal::lazy_init_num_threads();  // the first loop would set this thread's number otherwise
      ThreadCounts::set(most);
      // Create the team now, while threads are available, by a loop that is long enough to use all of it.
      if (most > 1) at::empty({most * at::internal::GRAIN_SIZE}, at::kByte).fill_(1);
      prepared = generation;
    }
    ThreadCounts::set(std::min(num_threads, most));
  }

 private:
  const ForkGate::Passage passage_;
  const ThreadCounts counts_;
};

int32_t probe(chiasm_backend_info* info, chiasm_error_text* error) {
  return guard(error, [&] {
    check_version();
    info->engine_version = "libtorch " TORCH_VERSION;
    info->has_cuda = Cuda::present() ? 1 : 0;
  });
}

int32_t load(const chiasm_backend_load* request, void** model, chiasm_error_text* error) {
  return guard(error, [&] {
    const Call call(request->num_threads, request->process_threads);
    *model = new LoadedProgram(*request);
  });
}

int32_t run(void* model, const chiasm_tensor* inputs, const chiasm_tensor* outputs,
            const chiasm_run_options* options, chiasm_error_text* error) {
  return guard(error, [&] {
    auto& loaded = *static_cast<LoadedProgram*>(model);
    const Call call(loaded.num_threads(), loaded.process_threads());
    loaded.run(inputs, outputs, options);
  });
}

void unload(void* model) {
  const ForkGate::Passage passage;
  delete static_cast<LoadedProgram*>(model);
}

// The members by which the core chooses a backend are in plugin.cpp.
const chiasm_backend engine{sizeof(chiasm_backend),
                            CHIASM_BACKEND_ABI,
                            "torch",
                            0,
                            nullptr,
                            0,
                            nullptr,
                            probe,
                            nullptr,
                            load,
                            run,
                            unload};

}  // namespace

extern "C" CHIASM_EXPORT const chiasm_backend* chiasm_backend_entry(uint32_t abi) {
  return abi == CHIASM_BACKEND_ABI ? &engine : nullptr;
}
