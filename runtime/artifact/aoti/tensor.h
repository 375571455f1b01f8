// The tensor behind AtenTensorHandle in a torch-free artifact, and the run that it belongs to.
#pragma once

#include <atomic>
#include <cstdint>
#include <cstring>
#include <memory>
#include <new>
#include <stdexcept>
#include <string>
#include <vector>

#include "../abi.h"
#include "base/dtype.h"
#include "memory.h"

namespace chiasm::artifact {

using Dims = std::vector<int64_t>;

// What one call of `run` provides to the code that it runs.
struct Run {
  const chiasm_native_host* host;
  const chiasm_tensor* outputs;
  size_t output_count;
  // For each output, the ordinal of the allocation that became it in the first run, or -1: see entry.cpp.
  const std::vector<int64_t>* plan;
  int64_t allocations = 0;
  // Set if a value is not allowed (chiasm/checked.h): `refuse` keeps the first text of any thread.
  std::atomic<bool> refused{false};
  char refusal[256] = "";

  Run(const chiasm_native_host* the_host, const chiasm_tensor* the_outputs, size_t count,
      const std::vector<int64_t>* the_plan)
      : host(the_host), outputs(the_outputs), output_count(count), plan(the_plan) {}
};

// The run of this thread; null while a model is created.
Run*& current_run();

// The run that this thread works for, also as a member of a team; null if there is none.
Run* run_of_this_thread();
bool in_parallel_region();

// The run returns this text as its error (errors.cpp); the first one counts.
void refuse(const char* text);

// Memory with a known owner: the caller (inputs, outputs, constants: never freed here) or the host's scratch.
struct Storage {
  char* data = nullptr;
  size_t bytes = 0;
  // the number of this allocation in its run; -1: not allocated by the run
  int64_t ordinal = -1;
  const chiasm_native_host* owner = nullptr;  // null: borrowed
  ~Storage() {
    if (owner) owner->release(owner->context, data, bytes);
  }
};

// Codes of c10::ScalarType, as AOTInductor's code writes them: those of the types that kernels and operators
// take.
enum ScalarType : int32_t {
  kBool = base::kDTypes[CHIASM_BOOL].torch,
  kUint8 = base::kDTypes[CHIASM_UINT8].torch,
  kUint16 = base::kDTypes[CHIASM_UINT16].torch,
  kInt16 = base::kDTypes[CHIASM_INT16].torch,
  kInt32 = base::kDTypes[CHIASM_INT32].torch,
  kInt64 = base::kDTypes[CHIASM_INT64].torch,
  kFloat = base::kDTypes[CHIASM_FLOAT32].torch,
  kDouble = base::kDTypes[CHIASM_FLOAT64].torch
};

inline int64_t element_size(int32_t dtype) {
  for (const base::DTypeEntry& known : base::kDTypes)
    if (known.torch == dtype) return static_cast<int64_t>(known.size);
  throw std::runtime_error("the compiled op uses element type " + std::to_string(dtype) +
                           ", which this runtime does not have");
}

}  // namespace chiasm::artifact

// The type that AOTInductor's header declares and keeps opaque.
struct AtenTensorOpaque {
  std::shared_ptr<chiasm::artifact::Storage> storage;
  chiasm::artifact::Dims sizes, strides;
  int64_t offset = 0;  // in elements
  int32_t dtype = chiasm::artifact::kFloat;
  int32_t device_type = 0, device_index = 0;

  char* data() const { return storage->data + offset * chiasm::artifact::element_size(dtype); }
  int64_t numel() const {
    int64_t n = 1;
    for (int64_t s : sizes) n *= s;
    return n;
  }
  bool is_dense() const {
    int64_t expected = 1;
    for (size_t i = sizes.size(); i-- > 0;) {
      if (sizes[i] != 1 && strides[i] != expected) return false;
      expected *= sizes[i];
    }
    return true;
  }
};

namespace chiasm::artifact {

inline Dims dense_strides(const Dims& sizes) {
  Dims strides(sizes.size(), 1);
  for (size_t i = sizes.size(); i-- > 1;) strides[i - 1] = strides[i] * std::max<int64_t>(sizes[i], 1);
  return strides;
}

// The number of elements from a tensor's first to its last, inclusive.
inline int64_t span(const Dims& sizes, const Dims& strides) {
  int64_t elements = 1;
  for (size_t i = 0; i < sizes.size(); ++i) {
    if (sizes[i] < 0 || strides[i] < 0)
      throw std::runtime_error("the compiled op makes a tensor of negative size");
    if (sizes[i] == 0) return 0;
    int64_t reach = 0;
    if (__builtin_mul_overflow(sizes[i] - 1, strides[i], &reach) ||
        __builtin_add_overflow(elements, reach, &elements) || elements > memory::most_elements)
      throw std::runtime_error("the compiled op makes a tensor of more elements than it can count: " +
                               std::to_string(memory::most_elements));
  }
  return elements;
}

// A new tensor in scratch memory, or in the caller's output if the plan says that it will become that output.
AtenTensorOpaque* allocate(Dims sizes, Dims strides, int32_t dtype);

// Copies between tensors of the same sizes and dtype, whatever their strides.
void copy(const AtenTensorOpaque& source, AtenTensorOpaque& target);

// `tensor` itself if it is dense, else a dense copy, which `owner` keeps.
inline const AtenTensorOpaque& dense(const AtenTensorOpaque& tensor,
                                     std::unique_ptr<AtenTensorOpaque>& owner) {
  if (tensor.is_dense()) return tensor;
  owner.reset(allocate(tensor.sizes, dense_strides(tensor.sizes), tensor.dtype));
  copy(tensor, *owner);
  return *owner;
}

// Calls `body` and turns an exception into AOTInductor's error code, keeping the text for `run` to report.
int32_t guarded_failure(const char* what);
int32_t guarded_out_of_memory();
template <class Body>
int32_t guarded(Body body) {
  try {
    body();
    return 0;
  } catch (const std::bad_alloc&) {
    return guarded_out_of_memory();
  } catch (const std::exception& error) {
    return guarded_failure(error.what());
  } catch (...) {
    return guarded_failure("an unknown error");
  }
}

}  // namespace chiasm::artifact
