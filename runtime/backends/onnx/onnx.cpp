// The onnx backend: one ONNX Runtime session per artifact, which reads the caller's inputs where they are and
// writes the caller's outputs directly.
//
// On CUDA a run returns when its work is enqueued. ONNX Runtime ties a session to one stream at its creation,
// but each run names its own stream. So the session works on a stream of ours, which events order with the
// caller's: the run starts after the work that is on the caller's stream, and work that the caller enqueues
// later starts after the run. Runs of one model are enqueued one after the other.
#include <algorithm>
#include <cstring>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "backends/limits.h"
#include "backends/onnx/code_in_text.h"
#include "backends/onnx/dtype.h"
#include "backends/onnx/engine.h"
#include "backends/onnx/onnx_file.h"
#include "backends/plugin.h"
#include "base/cuda.h"
#include "base/fork.h"

namespace {

using chiasm::base::CudaDevice;
using chiasm::base::CudaStream;
using chiasm::base::Error;
using chiasm::base::ForkGate;
using chiasm::onnx::custom_op_library;
using chiasm::onnx::element_type;
using chiasm::onnx::environment;
using chiasm::onnx::has_provider;
using chiasm::onnx::open_engine;
using chiasm::plugin::guard;

constexpr const char* kCudaProvider = "CUDAExecutionProvider";
constexpr const char* kFused = "fused_onnx";

chiasm_code code_of(OrtErrorCode code) {
  switch (code) {
    case ORT_INVALID_PROTOBUF:
    case ORT_INVALID_GRAPH: return CHIASM_CORRUPT;
    case ORT_NOT_IMPLEMENTED:
      return CHIASM_UNAVAILABLE;  // no kernel for this op and dtype in this build of the engine
    default: return CHIASM_INTERNAL;
  }
}

// The engine's texts may have several lines, indented.
std::string joined(const char* text) {
  std::string line;
  for (; *text != '\0'; ++text) {
    const bool is_space = *text == '\n' || *text == '\r' || *text == '\t' || *text == ' ';
    if (!is_space)
      line += *text;
    else if (!line.empty() && line.back() != ' ')
      line += ' ';
  }
  while (!line.empty() && line.back() == ' ') line.pop_back();
  return line;
}

// Runs `body`, and maps an error of the engine to our code.
template <class Body>
void translated(Body&& body) {
  try {
    body();
  } catch (const Ort::Exception& e) {
    std::string text = joined(e.what());
    // an error of native code inside ONNX Runtime
    if (const chiasm_code code = chiasm::onnx::take_code(text); code != CHIASM_OK) throw Error(code, text);
    for (const char* words : {"out of memory", "Failed to allocate memory", "bad_alloc", "bad allocation"}) {
      if (text.find(words) != std::string::npos) throw Error(CHIASM_OUT_OF_MEMORY, text);
    }
    throw Error(code_of(e.GetOrtErrorCode()), text);
  }
}

// A tensor of the method that the session has: the exporter prunes inputs that the graph does not read.
struct Binding {
  std::string name;
  int32_t index;  // in the method's order
};

// An input or output of the session.
struct GraphTensor {
  std::string name;
  std::string dtype;  // our name of it
};

std::string dtype_name_of(const Ort::TypeInfo& info) {
  if (info.GetONNXType() != ONNX_TYPE_TENSOR) return "no tensor";
  const auto type = info.GetTensorTypeAndShapeInfo().GetElementType();
  return chiasm::base::dtype_name(chiasm::onnx::dtype_of(type));
}

// One loaded artifact. On the CPU `run` works in several threads at once.
class Session {
 public:
  explicit Session(const chiasm_backend_load& request)
      : memory_(request.device_type == CHIASM_CUDA
                    ? Ort::MemoryInfo("Cuda", OrtDeviceAllocator, request.device_index, OrtMemTypeDefault)
                    : Ort::MemoryInfo::CreateCpu(OrtDeviceAllocator, OrtMemTypeDefault)) {
    chiasm::onnx::check_onnx(static_cast<const unsigned char*>(request.data), request.size, "the model");
    translated([&] {
      const Ort::Env& env = environment(request.process_threads);  // the CUDA provider logs to it
      Ort::SessionOptions options;
      const bool shares_threads = request.num_threads == request.process_threads;
      has_own_threads_ = !shares_threads;
      if (shares_threads)
        options.DisablePerSessionThreads();
      else
        use_own_threads(options, request.num_threads);
      options.AddConfigEntry("session.use_env_allocators", "1");
      // Not ORT_ENABLE_ALL: its blocked layout makes convolutions of few channels, which most ops are, 3 to
      // 18 times slower.
      options.SetGraphOptimizationLevel(ORT_ENABLE_EXTENDED);
      if (std::strcmp(request.format, kFused) == 0)
        append_native_code(options, request.bundle, request.manifest_sha256);
      if (request.device_type == CHIASM_CUDA) append_cuda(options, request.device_index);
      // If an allocation fails, ONNX Runtime may end the process.
      chiasm::plugin::require_memory((size_t{48} << 20) + 8 * request.size + chiasm::plugin::kArenaBytes,
                                     "making a session of ONNX Runtime");
      session_.emplace(env, request.data, request.size, options);
    });
    bind(inputs_, input_names_, graph_inputs(), request.input_names, request.input_count, "input",
         request.signature);
    bind(outputs_, output_names_, graph_outputs(), request.output_names, request.output_count, "output",
         request.signature);
    if (outputs_.size() != static_cast<size_t>(request.output_count))
      throw Error(CHIASM_CORRUPT, "the graph has " + std::to_string(outputs_.size()) +
                                      " outputs, the manifest says " + std::to_string(request.output_count));
  }

  /** Whether it has threads that are the parent's: destroying their pool would wait for them without end. */
  bool has_threads_of_parent() const noexcept {
    return has_own_threads_ && generation_ != ForkGate::generation();
  }

  void run(const chiasm_tensor* inputs, const chiasm_tensor* outputs, const chiasm_run_options* options) {
    translated([&] {
      std::vector<Ort::Value> in = wrap(inputs_, inputs);
      std::vector<Ort::Value> out = wrap(outputs_, outputs);
      if (!stream_) {
        enqueue(Ort::RunOptions(nullptr), in, out);
        return;
      }
      Ort::RunOptions run_options;
      run_options.AddConfigEntry("disable_synchronize_execution_providers", "1");
      void* caller = options != nullptr ? options->stream : nullptr;
      const std::lock_guard lock(mutex_);
      stream_->begin_after(caller);
      enqueue(run_options, in, out);
      stream_->end_before(caller);
    });
  }

 private:
  // Gives the session its own pool, which does not spin either.
  static void use_own_threads(Ort::SessionOptions& options, int32_t num_threads) {
    const int32_t workers = chiasm::plugin::threads_left(num_threads) - 1;
    options.SetIntraOpNumThreads(1 + std::max(workers, 0));
    options.SetInterOpNumThreads(1);
    options.AddConfigEntry("session.intra_op.allow_spinning", "0");
    options.SetCustomCreateThreadFn(chiasm::onnx::begin_thread);
    options.SetCustomJoinThreadFn(chiasm::onnx::join_thread);
  }

  static void append_native_code(Ort::SessionOptions& options, const std::string& bundle,
                                 const char* manifest_sha256) {
    if (bundle.find(':') != std::string::npos)
      throw Error(CHIASM_UNAVAILABLE, "the entry chiasm.bundles cannot name the folder " + bundle +
                                          ", which has a colon: rename it, or set the option fused to 0");
    options.AddConfigEntry("chiasm.bundles", bundle.c_str());
    options.AddConfigEntry("chiasm.checked",
                           manifest_sha256);  // fails with UNAVAILABLE without code for this CPU
    options.RegisterCustomOpsLibrary(custom_op_library().c_str());
  }

  void append_cuda(Ort::SessionOptions& options, int32_t device_index) {
    if (!has_provider(kCudaProvider))
      throw Error(CHIASM_UNAVAILABLE, "this ONNX Runtime has no CUDA provider; install onnxruntime-gpu");
    device_.emplace(device_index);
    stream_.emplace(*device_);
    OrtCUDAProviderOptionsV2* raw = nullptr;
    Ort::ThrowOnError(Ort::GetApi().CreateCUDAProviderOptions(&raw));
    const std::unique_ptr<OrtCUDAProviderOptionsV2, void (*)(OrtCUDAProviderOptionsV2*)> cuda(
        raw, Ort::GetApi().ReleaseCUDAProviderOptions);
    const std::string device = std::to_string(device_index);
    const char* keys[] = {"device_id", "use_tf32"};
    const char* values[] = {device.c_str(), "0"};
    Ort::ThrowOnError(Ort::GetApi().UpdateCUDAProviderOptions(cuda.get(), keys, values, 2));
    Ort::ThrowOnError(Ort::GetApi().UpdateCUDAProviderOptionsWithValue(cuda.get(), "user_compute_stream",
                                                                       stream_->handle()));
    options.AppendExecutionProvider_CUDA_V2(*cuda);
  }

  std::vector<GraphTensor> graph_inputs() const {
    return graph_tensors(session_->GetInputCount(), &Ort::Session::GetInputNameAllocated,
                         &Ort::Session::GetInputTypeInfo);
  }

  std::vector<GraphTensor> graph_outputs() const {
    return graph_tensors(session_->GetOutputCount(), &Ort::Session::GetOutputNameAllocated,
                         &Ort::Session::GetOutputTypeInfo);
  }

  // The session's functions say the name and the type of each.
  std::vector<GraphTensor> graph_tensors(
      size_t count, Ort::AllocatedStringPtr (Ort::Session::*name_of)(size_t, OrtAllocator*) const,
      Ort::TypeInfo (Ort::Session::*type_of)(size_t) const) const {
    Ort::AllocatorWithDefaultOptions allocator;
    std::vector<GraphTensor> tensors;
    for (size_t i = 0; i < count; ++i) {
      tensors.push_back(
          {((*session_).*name_of)(i, allocator).get(), dtype_name_of(((*session_).*type_of)(i))});
    }
    return tensors;
  }

  void bind(std::vector<Binding>& bindings, std::vector<const char*>& names,
            const std::vector<GraphTensor>& has, const char* const* method, int32_t count,
            const std::string& kind, const std::string& signature) const {
    std::unordered_map<std::string, int32_t> index;
    for (int32_t i = 0; i < count; ++i) index.emplace(method[i], i);
    for (const GraphTensor& tensor : has) {
      const auto found = index.find(tensor.name);
      if (found == index.end())
        throw Error(CHIASM_CORRUPT,
                    "the graph has the " + kind + " '" + tensor.name + "', the manifest does not");
      // A line of the signature is "input NAME DTYPE [SHAPE]".
      const std::string line = "\n" + kind + " " + tensor.name + " ";
      const size_t dtype = signature.find(line) + line.size();
      if (signature.compare(dtype, tensor.dtype.size() + 1, tensor.dtype + " ") != 0)
        throw Error(CHIASM_CORRUPT, "the graph's " + kind + " '" + tensor.name + "' is " + tensor.dtype +
                                        ", the manifest says " +
                                        signature.substr(dtype, signature.find(' ', dtype) - dtype));
      bindings.push_back({tensor.name, found->second});
    }
    for (const Binding& binding : bindings) names.push_back(binding.name.c_str());
  }

  std::vector<Ort::Value> wrap(const std::vector<Binding>& bindings, const chiasm_tensor* tensors) const {
    static char nothing = 0;  // an empty tensor may have no memory, but a value must point somewhere
    std::vector<Ort::Value> values;
    values.reserve(bindings.size());
    for (const Binding& binding : bindings) {
      const chiasm_tensor& tensor = tensors[binding.index];
      const size_t bytes = chiasm::base::byte_count(tensor);
      values.push_back(Ort::Value::CreateTensor(memory_, tensor.data != nullptr ? tensor.data : &nothing,
                                                bytes, tensor.shape, static_cast<size_t>(tensor.ndim),
                                                element_type(tensor.dtype)));
    }
    return values;
  }

  void enqueue(const Ort::RunOptions& options, std::vector<Ort::Value>& in, std::vector<Ort::Value>& out) {
    session_->Run(options, input_names_.data(), in.data(), in.size(), output_names_.data(), out.data(),
                  out.size());
  }

  const uint32_t generation_ = ForkGate::generation();
  bool has_own_threads_ = false;
  Ort::MemoryInfo memory_;
  std::optional<CudaDevice> device_;
  std::optional<CudaStream> stream_;  // outlives the session, which works on it
  std::optional<Ort::Session> session_;
  std::vector<Binding> inputs_, outputs_;
  std::vector<const char*> input_names_, output_names_;  // of the bindings
  std::mutex mutex_;                                     // CUDA: one run is enqueued at a time
};

int32_t probe(chiasm_backend_info* info, chiasm_error_text* error) {
  return guard(error, [&] {
    static const std::string version = "onnxruntime " + open_engine();
    info->engine_version = version.c_str();
    info->has_cuda = has_provider(kCudaProvider) && chiasm::base::cuda_device_present() ? 1 : 0;
  });
}

int32_t load(const chiasm_backend_load* request, void** model, chiasm_error_text* error) {
  return guard(error, [&] {
    const ForkGate::Passage passage;
    open_engine();
    chiasm::plugin::flag(request->options, "fused", true);  // rejects values other than 0 and 1
    *model = new Session(*request);
  });
}

int32_t run(void* model, const chiasm_tensor* inputs, const chiasm_tensor* outputs,
            const chiasm_run_options* options, chiasm_error_text* error) {
  return guard(error, [&] {
    const ForkGate::Passage passage;
    static_cast<Session*>(model)->run(inputs, outputs, options);
  });
}

void unload(void* model) {
  const ForkGate::Passage passage;
  auto* const session = static_cast<Session*>(model);
  if (!session->has_threads_of_parent()) delete session;
}

// Ranks the fused form above the flat one, if it can run here and is wanted.
int32_t rank(const chiasm_backend_load* request) {
  if (std::strcmp(request->format, kFused) != 0) return 0;
  try {
    const bool wanted = chiasm::plugin::flag(request->options, "fused", true);
    return wanted && request->device_type == CHIASM_CPU && chiasm::onnx::has_custom_op_library() ? 1 : -1;
  } catch (const std::exception&) {
    return 1;  // `load` reports what is wrong with the option
  }
}

constexpr chiasm_backend_format kFormats[] = {{"onnx", 0}, {kFused, 1}, {nullptr, 0}};
constexpr chiasm_backend_option kOptions[] = {{"fused", "0 or 1",
                                               "1, the default, runs a method's native code as one node "
                                               "inside ONNX Runtime, where the bundle has both forms"},
                                              {nullptr, nullptr, nullptr}};
constexpr int32_t kPriority = 100;

const chiasm_backend backend{sizeof(chiasm_backend),
                             CHIASM_BACKEND_ABI,
                             "onnx",
                             kPriority,
                             kFormats,
                             1u << CHIASM_CPU | 1u << CHIASM_CUDA,
                             kOptions,
                             probe,
                             rank,
                             load,
                             run,
                             unload};

}  // namespace

extern "C" CHIASM_EXPORT const chiasm_backend* chiasm_backend_entry(uint32_t abi) {
  return abi == CHIASM_BACKEND_ABI ? &backend : nullptr;
}
