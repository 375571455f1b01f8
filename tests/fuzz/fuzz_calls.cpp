/** Tests the C interface with a grammar: each byte string is a program of calls, with good and bad arguments.
 *  Handles are live or NULL, and pointers have as much memory as declared; everything else is arbitrary. */
#include <fuzzer/FuzzedDataProvider.h>

#include <cstdlib>
#include <cstring>
#include <vector>

#include "core/api.h"
#include "support.h"

namespace {

using namespace chiasm;

const chiasm_api& api() { return *core::api_table(CHIASM_API_VERSION); }

constexpr size_t kMostHandles = 6;

/** One program's state. */
class Program final {
 public:
  explicit Program(FuzzedDataProvider& input) : input_(input) {}
  ~Program() {
    for (chiasm_outputs* outputs : outputs_) api().outputs_free(outputs);
    for (chiasm_method* method : methods_) api().method_close(method);
    for (chiasm_bundle* bundle : bundles_) api().bundle_close(bundle);
  }

  void step() {
    switch (input_.ConsumeIntegralInRange<int>(0, 16)) {
      case 0: open(); break;
      case 1: load(); break;
      case 2: run(); break;
      case 3: run_into(); break;
      case 4: output_shape(); break;
      case 5: close(bundles_, api().bundle_close); break;
      case 6: close(methods_, api().method_close); break;
      case 7: close(outputs_, api().outputs_free); break;
      case 8: read_outputs(); break;
      case 9: bundle_info(); break;
      case 10: self_test(); break;
      case 11: backend_info(); break;
      case 12: set_trust(); break;
      case 13: method_info(); break;
      case 14: check(api().set_num_threads(input_.ConsumeIntegralInRange<int32_t>(-2, 4))); break;
      case 15:
        if (api().get_num_threads() < 1) std::abort();
        break;
      default: load(); run();  // the usual
    }
  }

 private:
  /** Checks that a status has a code and a message. Returns whether there was a status. */
  static bool check(chiasm_status* status) {
    const int32_t code = api().status_code(status);
    if ((status == nullptr) != (code == CHIASM_OK) ||
        (status != nullptr && api().status_message(status)[0] == '\0'))
      std::abort();
    if (code == CHIASM_INTERNAL) std::abort();  // the fake engines do not fail, so nothing may
    api().status_free(status);
    return status != nullptr;
  }

  template <class Handle>
  Handle* any_of(const std::vector<Handle*>& handles) {
    const auto index = input_.ConsumeIntegralInRange<size_t>(0, handles.size());
    return index < handles.size() ? handles[index] : nullptr;
  }

  template <class Handle>
  void keep(std::vector<Handle*>& handles, Handle* handle, bool failed) {
    if (failed != (handle == nullptr)) std::abort();
    if (handle != nullptr) handles.push_back(handle);
  }

  template <class Handle>
  void close(std::vector<Handle*>& handles, void (*function)(Handle*)) {
    const auto index = input_.ConsumeIntegralInRange<size_t>(0, handles.size());
    if (index == handles.size()) return function(nullptr);
    function(handles[index]);
    handles.erase(handles.begin() + static_cast<std::ptrdiff_t>(index));
  }

  void open() {
    if (bundles_.size() >= kMostHandles) return;
    static const std::string good = fuzz::scratch_folder() + "/seed.chiasm";
    const std::string text = input_.ConsumeBool() ? good : input_.ConsumeRandomLengthString(40);
    const bool no_path = input_.ConsumeIntegralInRange(0, 15) == 0,
               no_result = input_.ConsumeIntegralInRange(0, 15) == 0;
    chiasm_bundle* bundle = reinterpret_cast<chiasm_bundle*>(this);
    const bool failed =
        check(api().bundle_open(no_path ? nullptr : text.c_str(), no_result ? nullptr : &bundle));
    if (no_result) return;
    keep(bundles_, bundle, failed);
  }

  chiasm_load_options load_options() {
    static const char* const kBackends[] = {"auto", "native", "torch", "onnx", "", "other"};
    chiasm_load_options options = CHIASM_LOAD_OPTIONS_INIT;
    if (input_.ConsumeBool()) return options;
    options.struct_size = size_of(sizeof options);
    options.backend = input_.ConsumeBool() ? input_.PickValueInArray(kBackends) : nullptr;
    options.device_type = number();
    options.device_index = number();
    options.allow_native_code = number();
    options.dtype = number();
    options.warm_up = number();
    options.fused = number();
    if (options.device_type == CHIASM_CUDA) options.device_type = 2;  // the driver is not tested here
    return options;
  }

  void load() {
    if (methods_.size() >= kMostHandles) return;
    static const char* const kNames[] = {"forward", "vjp", ""};
    const chiasm_load_options options = load_options();
    const bool no_result = input_.ConsumeIntegralInRange(0, 15) == 0;
    chiasm_method* method = reinterpret_cast<chiasm_method*>(this);
    const bool failed = check(api().method_load(
        any_of(bundles_),
        input_.ConsumeIntegralInRange(0, 15) == 0 ? nullptr : input_.PickValueInArray(kNames),
        input_.ConsumeBool() ? &options : nullptr, no_result ? nullptr : &method));
    if (!no_result) keep(methods_, method, failed);
  }

  int32_t number() {
    static constexpr int32_t kNumbers[] = {0, 1, -1, 2, 3, 4, 8, 9, 64, INT32_MAX, INT32_MIN};
    return input_.PickValueInArray(kNumbers);
  }

  size_t size_of(size_t right) {
    const size_t sizes[] = {right, right, right, right + 8, right - 8, right + 4,
                            0,     8,     1024,  4096,      SIZE_MAX,  SIZE_MAX - 7};
    return input_.PickValueInArray(sizes);
  }

  /** Tensors in the layout of a newer caller: `struct_size` of the first is the distance between them. */
  struct Tensors {
    std::vector<std::vector<int64_t>> dims;
    std::vector<std::vector<char>> memory;
    std::vector<char> structs;
    const chiasm_tensor* data = nullptr;
    size_t count = 0;
  };

  void make(Tensors& tensors, size_t memory_size) {
    static constexpr int64_t kDims[] = {1,         1,        2, 3, 3, 4, 8, 16, 0, -1, int64_t{1} << 40,
                                        INT64_MAX, INT64_MIN};
    static constexpr int64_t kImage[] = {1, 3, 8, 8};
    tensors.count = input_.ConsumeIntegralInRange<size_t>(0, 3);
    const size_t first_size = size_of(sizeof(chiasm_tensor));
    const size_t step =
        first_size > 4096 ? sizeof(chiasm_tensor) : std::max(first_size, sizeof(chiasm_tensor));
    tensors.structs.resize(step * (tensors.count + 1));
    for (size_t i = 0; i < tensors.count; ++i) {
      tensors.memory.emplace_back(memory_size + 8);
      chiasm_tensor tensor{i == 0 ? first_size : size_of(sizeof tensor),
                           tensors.memory.back().data(),
                           CHIASM_FLOAT32,
                           CHIASM_CPU,
                           0,
                           4,
                           kImage,
                           nullptr};
      if (input_.ConsumeIntegralInRange(0, 3) == 0) {
        tensor.dtype = number();
        tensor.ndim = number();
        tensor.device_type = number();
        tensor.device_index = number();
        tensors.dims.emplace_back(CHIASM_MAX_DIMS);
        for (int64_t& dim : tensors.dims.back()) dim = input_.PickValueInArray(kDims);
        tensor.shape = input_.ConsumeBool() ? tensors.dims.back().data() : nullptr;
        if (input_.ConsumeBool()) {
          tensors.dims.emplace_back(CHIASM_MAX_DIMS);
          for (int64_t& dim : tensors.dims.back()) dim = input_.PickValueInArray(kDims);
          tensor.strides = tensors.dims.back().data();
        }
        const int skew = input_.ConsumeIntegralInRange(-1, 7);
        tensor.data = skew < 0 ? nullptr : tensors.memory.back().data() + skew;
      }
      std::memcpy(tensors.structs.data() + i * step, &tensor, sizeof tensor);
    }
    tensors.data = input_.ConsumeIntegralInRange(0, 15) == 0
                       ? nullptr
                       : reinterpret_cast<const chiasm_tensor*>(tensors.structs.data());
  }

  chiasm_run_options run_options() { return {size_of(sizeof(chiasm_run_options)), nullptr}; }

  void run() {
    if (outputs_.size() >= kMostHandles) return;
    Tensors inputs;
    make(inputs, kMemory);
    const chiasm_run_options options = run_options();
    chiasm_outputs* outputs = reinterpret_cast<chiasm_outputs*>(this);
    const bool no_result = input_.ConsumeIntegralInRange(0, 15) == 0;
    const bool failed =
        check(api().method_run(any_of(methods_), inputs.data, inputs.count,
                               input_.ConsumeBool() ? nullptr : &options, no_result ? nullptr : &outputs));
    if (!no_result) keep(outputs_, outputs, failed);
  }

  void run_into() {
    Tensors inputs, outputs;
    make(inputs, kMemory);
    make(outputs, kMemory);
    const chiasm_run_options options = run_options();
    const chiasm_tensor* into = input_.ConsumeIntegralInRange(0, 7) == 0 ? inputs.data : outputs.data;
    check(api().method_run_into(any_of(methods_), inputs.data, inputs.count, into,
                                into == inputs.data ? inputs.count : outputs.count,
                                input_.ConsumeBool() ? nullptr : &options));
  }

  void output_shape() {
    Tensors inputs;
    make(inputs, kMemory);
    int64_t shape[CHIASM_MAX_DIMS];
    int32_t ndim = 0, dtype = 0;
    const auto index = input_.PickValueInArray<size_t>({0, 1, SIZE_MAX});
    check(api().method_output_shape(any_of(methods_), inputs.data, inputs.count, index,
                                    input_.ConsumeIntegralInRange(0, 9) == 0 ? nullptr : shape,
                                    input_.ConsumeIntegralInRange(0, 9) == 0 ? nullptr : &ndim,
                                    input_.ConsumeIntegralInRange(0, 9) == 0 ? nullptr : &dtype));
  }

  void read_outputs() {
    const chiasm_outputs* const outputs = any_of(outputs_);
    const size_t count = api().outputs_count(outputs);
    for (size_t i = 0; i <= count; ++i) {
      const chiasm_tensor* const tensor = api().outputs_get(outputs, i);
      if ((tensor == nullptr) != (i == count)) std::abort();
      if (tensor != nullptr && tensor->shape[tensor->ndim - 1] > 0)
        sum_ += *static_cast<const volatile char*>(tensor->data);
    }
  }

  void bundle_info() {
    const chiasm_bundle_info* const info = api().bundle_get_info(any_of(bundles_));
    if (info != nullptr) sum_ += static_cast<char>(std::strlen(info->manifest) + std::strlen(info->path));
  }

  void method_info() {
    const chiasm_method* const method = any_of(methods_);
    const chiasm_method_info* const info = api().method_get_info(method);
    if (info != nullptr) sum_ += static_cast<char>(info->inputs[0].dtypes[0]);
    sum_ += static_cast<char>(std::strlen(api().method_backend(method)) +
                              std::strlen(api().method_artifact(method)));
  }

  void self_test() {
    const chiasm_load_options options = load_options();
    int32_t failed = -1;
    check(api().bundle_self_test(any_of(bundles_), input_.ConsumeBool() ? nullptr : &options, nullptr,
                                 nullptr, input_.ConsumeBool() ? nullptr : &failed));
  }

  void backend_info() {
    chiasm_backend_info info{};
    info.struct_size = size_of(sizeof info);
    check(api().backend_info(input_.PickValueInArray<size_t>({0, 1, 2, 3, SIZE_MAX}),
                             input_.ConsumeBool() ? &info : nullptr));
  }

  void set_trust() {
    const std::string key = input_.ConsumeBool() ? "RWTw5+M+30ejPJL8tKbwCcT38wi9MhKN6gMYCUvWEFLwjJgIr0gKPa8T"
                                                 : input_.ConsumeRandomLengthString(60);
    const char* const keys[] = {key.c_str(), input_.ConsumeBool() ? nullptr : key.c_str()};
    check(api().set_trust(number(), input_.ConsumeBool() ? keys : nullptr,
                          input_.PickValueInArray<size_t>({0, 1, 2, SIZE_MAX})));
    int32_t policy = 0;
    check(api().get_trust(input_.ConsumeBool() ? &policy : nullptr, nullptr, nullptr));
    check(api().set_trust(CHIASM_TRUST_ANY, nullptr, 0));  // or nothing more could be loaded
  }

  static constexpr size_t kMemory = 16 * 16 * 16 * 16 * 8;  // enough for dimensions up to 16

  FuzzedDataProvider& input_;
  std::vector<chiasm_bundle*> bundles_;
  std::vector<chiasm_method*> methods_;
  std::vector<chiasm_outputs*> outputs_;
  volatile char sum_ = 0;
};

}  // namespace

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  fuzz::use_fake_backends();
  fuzz::write_seed(fuzz::fresh_folder("seed.chiasm"));
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  FuzzedDataProvider input(data, size);
  Program program(input);
  for (int i = 0; i < 64 && input.remaining_bytes() > 0; ++i) program.step();
  return 0;
}
