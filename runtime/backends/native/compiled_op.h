/** One loaded native artifact, which the native backend or a node of ONNX Runtime runs. */
#pragma once

#include <optional>

#include "artifact/abi.h"
#include "backends/plugin.h"
#include "base/cuda.h"

namespace chiasm::native {

/** A shared library, loaded from memory. */
class Library final {
 public:
  explicit Library(const plugin::MemoryFile& file);
  Library(const Library&) = delete;
  Library& operator=(const Library&) = delete;
  ~Library();

  /** Throws Error if the library is no native artifact of this version. */
  const chiasm_native_api* api() const;

 private:
  void* handle_;
};

/** `run` may be called from several threads at once. */
class CompiledOp final {
 public:
  static constexpr int32_t kMaxTensors = 64;  // inputs, and outputs

  struct Request {
    const void* data;  // the artifact, a `.pt2`; not needed after the constructor
    size_t size;
    int32_t input_count, output_count;
    uint64_t batched_inputs = 0, batched_outputs = 0;  // as in chiasm_backend_load
    int32_t device_type = CHIASM_CPU, device_index = 0;
    const char* signature = "";  // core::signature_text; not needed after the constructor
  };

  /** Throws Error: CORRUPT (also if the code has another signature), VERSION_MISMATCH, UNAVAILABLE. */
  explicit CompiledOp(const Request& request);
  CompiledOp(const CompiledOp&) = delete;
  CompiledOp& operator=(const CompiledOp&) = delete;
  ~CompiledOp();

  /** Whether a call is worth more than one thread: below some size, waking another takes longer than the
   *  work. */
  bool worth_forking(const chiasm_tensor* inputs, const chiasm_tensor* outputs) const;

  /** Calls body(argument, ...) on this thread and on others, which may come late or not at all, and returns
   *  when all have returned. The context is the host's. */
  using Share = void (*)(void* context, void (*body)(void* argument, int32_t index, int32_t count),
                         void* argument);

  /** Dense tensors that fit the method's signature. The device of `host` is filled in here.
   *
   *  A large batch of independent samples is run in parts. A part stays in the caches from an op's first loop
   *  to its last, and the threads `share` the parts: they wait for each other once, not after each loop. */
  void run(const chiasm_tensor* inputs, const chiasm_tensor* outputs, chiasm_native_host host,
           Share share) const;

 private:
  struct Parts;

  std::optional<base::CudaDevice::Current> make_current() const;
  size_t bytes_of(const chiasm_tensor* inputs, const chiasm_tensor* outputs, uint64_t which_inputs,
                  uint64_t which_outputs) const;
  int64_t count_parts(const chiasm_tensor* inputs, const chiasm_tensor* outputs, int32_t threads) const;
  void run_whole(const chiasm_tensor* inputs, const chiasm_tensor* outputs,
                 const chiasm_native_host& host) const;
  void run_parts(const chiasm_tensor* inputs, const chiasm_tensor* outputs, const chiasm_native_host& host,
                 Share share, int64_t parts) const;

  Request request_;
  std::optional<base::CudaDevice> cuda_;
  std::optional<Library> library_;  // has the model's code, so it outlives the model
  const chiasm_native_api* api_ = nullptr;
  void* model_ = nullptr;
};

}  // namespace chiasm::native
