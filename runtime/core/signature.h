/** The checks between a caller and an engine: a backend gets only tensors that fit its method's signature. */
#pragma once

#include <bitset>
#include <string>
#include <vector>

#include "core/manifest.h"

namespace chiasm::core {

/** One checked call. It is on the stack and allocates no memory.
 *
 *  The tensors have the layout that engines get: dense row-major, strides NULL. Tensors with gaps get dense
 *  memory before the run (DenseCopies). For a batch of frames (layout "NHWC"), the caller may pass a single
 *  frame: (H, W, C), or (H, W) if it has one channel. The engine gets a batch of one, and the caller gets
 *  outputs without the dimensions that the first such input lacks.
 */
struct Call {
  chiasm_tensor inputs[kMaxTensors];
  chiasm_tensor outputs[kMaxTensors]; /**< data NULL until it is supplied */
  int64_t output_shapes[kMaxTensors][CHIASM_MAX_DIMS];
  size_t output_bytes[kMaxTensors];
  int64_t symbols[kMaxSymbols];
  std::bitset<kMaxSymbols> known;       /**< which symbols the inputs have given so far */
  int64_t frame_shapes[kMaxTensors][4]; /**< of inputs that are single frames */
  int32_t missing = 0;                  /**< how many dimensions the first of these lacks */

  /** Output n as the caller sees it: a single frame if the inputs are single frames. */
  chiasm_tensor seen_output(size_t n) const;
  uint64_t frame_outputs = 0;   /**< by bit: which outputs are batches of frames */
  uint64_t gaps_in_inputs = 0;  /**< by bit: the caller's tensors that have gaps (core/gaps.h) */
  uint64_t gaps_in_outputs = 0; /**< likewise */
};

/** A method's signature for one value of T, one device, prepared for fast checks. The specs must outlive
 *  it. */
class Signature final {
 public:
  Signature(const MethodSpec& method, const std::vector<Symbol>& symbols, int32_t generic_dtype,
            int32_t device_type, int32_t device_index);

  size_t input_count() const { return inputs_.size(); }
  size_t output_count() const { return outputs_.size(); }

  /** Check the inputs, and fill `call` except the outputs' data. Throws Error (INVALID_ARGUMENT) whose
   *  message names the tensor, the expected and the actual value. */
  void check_inputs(const chiasm_tensor* inputs, size_t count, Call& call) const;

  /** After check_inputs: check the caller's outputs and take them into `call`. */
  void check_outputs(const chiasm_tensor* outputs, size_t count, Call& call) const;

  /** Once the inputs are dense: rejects a bool that is neither 0 nor 1, because engines convert it to
   *  different numbers. Memory on a device is not read. */
  void check_bools(const Call& call) const;

  /** The call whose every symbol is at its minimum; data is NULL everywhere. `shapes` holds the inputs'
   *  shapes. */
  void smallest_call(Call& call, int64_t (*shapes)[CHIASM_MAX_DIMS]) const;

  /** Bytes of a dense tensor; throws Error if that exceeds the address space. */
  static size_t bytes_of(const chiasm_tensor& tensor, const char* kind, const char* name);

 private:
  /** How a dimension of an input is checked. */
  enum class Rule : uint8_t { constant, bind, same, expression };
  struct DimRule {
    Rule rule;
    int64_t operand; /**< the constant, or the symbol's index */
  };
  struct TensorRule {
    const TensorSpec* spec;
    int32_t dtype;
    std::vector<DimRule> dims;
    bool frames; /**< (B, H, W, C) */
  };
  struct Binding {
    size_t input, dim;
  };

  void check_common(const chiasm_tensor& tensor, const TensorRule& rule, const char* kind) const;
  chiasm_tensor as_batch(const chiasm_tensor& tensor, size_t n, bool first, Call& call) const;
  bool has_gaps(const chiasm_tensor& tensor, const TensorRule& rule, const char* kind) const;
  [[noreturn]] void refuse_shape(const chiasm_tensor& tensor, const TensorRule& rule, const char* kind,
                                 const Call& call, size_t tensor_index, const std::string& why) const;
  int64_t evaluate(const Expression& dim, const TensorRule& rule, const char* kind, const Call& call) const;
  void infer_outputs(Call& call) const;

  const std::vector<Symbol>& symbols_;
  std::vector<TensorRule> inputs_, outputs_;
  std::vector<Binding> bindings_; /**< by symbol: where its value comes from */
  bool has_input_expressions_ = false;
  int32_t device_type_, device_index_;
};

/** "(1, 3, 4, 4)" */
std::string shape_text(const int64_t* shape, int32_t ndim);
/** "the CPU" or "CUDA device 1" */
std::string device_text(int32_t type, int32_t index);

/** The caller's i-th tensor: a newer caller's structs may be longer than ours. */
inline const chiasm_tensor& tensor_at(const chiasm_tensor* tensors, size_t i) {
  const auto* bytes = reinterpret_cast<const char*>(tensors);
  return *reinterpret_cast<const chiasm_tensor*>(bytes + i * tensors->struct_size);
}

}  // namespace chiasm::core
