#include "triton/execute.h"

#include <algorithm>
#include <chrono>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include "base/pool.h"
#include "triton/errors.h"
#include "triton/types.h"

namespace chiasm::triton {
namespace {

uint64_t now() noexcept {
  const auto time = std::chrono::steady_clock::now().time_since_epoch();
  return static_cast<uint64_t>(std::chrono::duration_cast<std::chrono::nanoseconds>(time).count());
}

/** A request's times for the statistics: begin, begin of the run, end of the run, end. */
struct Times {
  uint64_t begin = 0, run = 0, ran = 0, end = 0;
  uint64_t samples = 1;
  bool good = false;
};

/** The data of tensors without elements: the core does not accept NULL. */
alignas(base::Pool::kAlignment) char nothing[base::Pool::kAlignment];

[[noreturn]] void refuse_gpu(const char* kind, const std::string& name) {
  throw Failure(TRITONSERVER_ERROR_UNSUPPORTED,
                std::string(kind) + " '" + name + "': this backend runs on the CPU, got a buffer on a GPU");
}

bool is_aligned(const void* data, DType dtype) {
  return reinterpret_cast<uintptr_t>(data) % size_of(dtype) == 0;
}

/** The bytes of an input. Clients may send them in pieces and at any address, but engines need them
 *  contiguous and aligned. */
class InputMemory final {
 public:
  const void* gather(TRITONBACKEND_Input* input, const std::string& name, DType dtype, uint64_t bytes,
                     uint32_t pieces) {
    if (bytes == 0) return nothing;
    if (pieces == 1) {
      const auto [data, size] = piece(input, name, 0);
      if (size == bytes && is_aligned(data, dtype)) return data;
    }
    char* const joined = static_cast<char*>(copies_.emplace_back(bytes).data());
    uint64_t filled = 0;
    for (uint32_t i = 0; i < pieces; ++i) {
      const auto [data, size] = piece(input, name, i);
      if (size > bytes - filled) refuse("input '" + name + "': more bytes came than were announced");
      if (size > 0) std::memcpy(joined + filled, data, size);
      filled += size;
    }
    if (filled != bytes) refuse("input '" + name + "': fewer bytes came than were announced");
    return joined;
  }

 private:
  static std::pair<const void*, uint64_t> piece(TRITONBACKEND_Input* input, const std::string& name,
                                                uint32_t index) {
    const void* data = nullptr;
    uint64_t size = 0;
    TRITONSERVER_MemoryType memory = TRITONSERVER_MEMORY_CPU;
    int64_t device = 0;
    check(TRITONBACKEND_InputBuffer(input, index, &data, &size, &memory, &device));
    if (memory == TRITONSERVER_MEMORY_GPU) refuse_gpu("input", name);
    return {data, size};
  }

  std::vector<base::PooledMemory> copies_;
};

/** The shape of a 0-d tensor in Triton's protocols, which have no 0-d tensors. */
const Shape kNumber{1};

/** The bytes of a dense tensor. */
uint64_t byte_count(const char* kind, const std::string& name, const Shape& shape, DType dtype) {
  uint64_t bytes = size_of(dtype);
  for (const int64_t size : shape) {
    if (size < 0 || __builtin_mul_overflow(bytes, static_cast<uint64_t>(size), &bytes))
      refuse(std::string(kind) + " '" + name + "': its shape has a size that no tensor can have");
  }
  return bytes;
}

Tensor read_input(TRITONBACKEND_Request* request, const TensorInfo& info, InputMemory& memory) {
  TRITONBACKEND_Input* input = nullptr;
  check(TRITONBACKEND_RequestInput(request, info.name.c_str(), &input));
  TRITONSERVER_DataType type{};
  const int64_t* sizes = nullptr;
  uint32_t ndim = 0, pieces = 0;
  uint64_t bytes = 0;
  check(TRITONBACKEND_InputProperties(input, nullptr, &type, &sizes, &ndim, &bytes, &pieces));
  const DType dtype = info.dtypes.at(0);
  if (type != type_of(dtype))
    refuse("input '" + info.name + "': expected " + TRITONSERVER_DataTypeString(type_of(dtype)) + ", got " +
           TRITONSERVER_DataTypeString(type));
  Shape shape(sizes, ndim);
  if (info.dims.empty() && shape == kNumber) shape = Shape();
  if (const uint64_t expected = byte_count("input", info.name, shape, dtype); bytes != expected)
    refuse("input '" + info.name + "': its shape has " + std::to_string(expected) + " bytes, got " +
           std::to_string(bytes));
  return Tensor(memory.gather(input, info.name, dtype, bytes, pieces), dtype, shape);
}

/** The memory that a run writes: the response's own buffer, or a temporary one if the client did not ask for
 *  the output or placed it at an unaligned address. */
class OutputMemory final {
 public:
  Tensor add(TRITONBACKEND_Response* response, const std::string& name, bool wanted, const TensorType& type) {
    const uint64_t bytes = byte_count("output", name, type.shape, type.dtype);
    void* const buffer = wanted ? response_buffer(response, name, type, bytes) : nullptr;
    if (bytes == 0) return Tensor(static_cast<void*>(nothing), type.dtype, type.shape);
    if (buffer != nullptr && is_aligned(buffer, type.dtype)) return Tensor(buffer, type.dtype, type.shape);
    void* const beside = others_.emplace_back(bytes).data();
    if (buffer != nullptr) copies_.push_back({buffer, beside, bytes});
    return Tensor(beside, type.dtype, type.shape);
  }

  void copy_back() const {
    for (const Copy& copy : copies_) std::memcpy(copy.to, copy.from, copy.bytes);
  }

 private:
  struct Copy {
    void* to;
    const void* from;
    uint64_t bytes;
  };

  static void* response_buffer(TRITONBACKEND_Response* response, const std::string& name,
                               const TensorType& type, uint64_t bytes) {
    const Shape& shape = type.shape.empty() ? kNumber : type.shape;
    TRITONBACKEND_Output* output = nullptr;
    check(TRITONBACKEND_ResponseOutput(response, &output, name.c_str(), type_of(type.dtype), shape.data(),
                                       static_cast<uint32_t>(shape.size())));
    void* buffer = nullptr;
    TRITONSERVER_MemoryType memory = TRITONSERVER_MEMORY_CPU;
    int64_t device = 0;
    check(TRITONBACKEND_OutputBuffer(output, &buffer, bytes, &memory, &device));
    if (memory == TRITONSERVER_MEMORY_GPU) refuse_gpu("output", name);
    return buffer;
  }

  std::vector<base::PooledMemory> others_;
  std::vector<Copy> copies_;
};

std::vector<std::string> wanted_outputs(TRITONBACKEND_Request* request) {
  uint32_t count = 0;
  check(TRITONBACKEND_RequestOutputCount(request, &count));
  std::vector<std::string> names;
  for (uint32_t i = 0; i < count; ++i) {
    const char* name = nullptr;
    check(TRITONBACKEND_RequestOutputName(request, i, &name));
    names.emplace_back(name);
  }
  return names;
}

void compute(const Model& model, TRITONBACKEND_Request* request, TRITONBACKEND_Response* response,
             Times& times) {
  const MethodInfo& method = model.signature().method;
  InputMemory input_memory;
  std::vector<Tensor> inputs, outputs;
  for (const TensorInfo& info : method.inputs) inputs.push_back(read_input(request, info, input_memory));
  const std::vector<std::string> wanted = wanted_outputs(request);
  OutputMemory output_memory;
  for (size_t i = 0; i < method.outputs.size(); ++i) {
    const std::string& name = method.outputs[i].name;
    const bool is_wanted = std::find(wanted.begin(), wanted.end(), name) != wanted.end();
    outputs.push_back(output_memory.add(response, name, is_wanted, model.method().output_type(inputs, i)));
  }
  if (model.signature().most_samples > 0) times.samples = static_cast<uint64_t>(inputs[0].shape()[0]);
  times.run = now();
  model.method().run_into(inputs, outputs);
  output_memory.copy_back();
  times.ran = now();
}

void answer(const Model& model, TRITONBACKEND_Request* request, Times& times) noexcept {
  times.begin = times.run = times.ran = now();
  TRITONBACKEND_Response* response = nullptr;
  TRITONSERVER_Error* error = TRITONBACKEND_ResponseNew(&response, request);
  if (error != nullptr) {
    log_failure(error);
    return;
  }
  error = guarded([&] { compute(model, request, response, times); });
  times.good = error == nullptr;
  if (!times.good) times.ran = std::max(times.ran, times.run);
  log_failure(TRITONBACKEND_ResponseSend(response, TRITONSERVER_RESPONSE_COMPLETE_FINAL, error));
  if (error != nullptr) TRITONSERVER_ErrorDelete(error);
  times.end = now();
}

void report(TRITONBACKEND_ModelInstance* instance, TRITONBACKEND_Request** requests,
            const std::vector<Times>& all, uint64_t begin) noexcept {
  Times batch{begin, 0, 0, now(), 0, true};
  for (size_t i = 0; i < all.size(); ++i) {
    const Times& times = all[i];
    log_failure(TRITONBACKEND_ModelInstanceReportStatistics(instance, requests[i], times.good, times.begin,
                                                            times.run, times.ran, times.end));
    if (!times.good) continue;
    batch.run = batch.samples == 0 ? times.run : std::min(batch.run, times.run);
    batch.ran = std::max(batch.ran, times.ran);
    batch.samples += times.samples;
  }
  if (batch.samples == 0) return;  // Triton itself counts no batch in which all requests failed
  log_failure(TRITONBACKEND_ModelInstanceReportBatchStatistics(instance, batch.samples, batch.begin,
                                                               batch.run, batch.ran, batch.end));
}

}  // namespace

void execute(const Model& model, Crew& crew, TRITONBACKEND_ModelInstance* instance,
             TRITONBACKEND_Request** requests, uint32_t count) {
  const uint64_t begin = now();
  std::vector<Times> times(count);
  crew.run(count, [&](size_t i) { answer(model, requests[i], times[i]); });
  report(instance, requests, times, begin);
  for (uint32_t i = 0; i < count; ++i)
    log_failure(TRITONBACKEND_RequestRelease(requests[i], TRITONSERVER_REQUEST_RELEASE_ALL));
}

}  // namespace chiasm::triton
