// Checks the tensors of a call against the method's signature, binds the symbols to sizes and derives the
// outputs' shapes.
#include "core/signature.h"

#include <algorithm>

#include "base/dtype.h"
#include "core/gaps.h"
#include "core/status.h"
#include "core/struct_size.h"

namespace chiasm::core {
namespace {

[[noreturn]] void refuse(const char* kind, const std::string& name, const std::string& what) {
  fail(CHIASM_INVALID_ARGUMENT, std::string(kind) + " '" + name + "': " + what);
}

/** "1 input", "2 inputs" */
std::string counted(size_t count, const char* kind) {
  return std::to_string(count) + " " + kind + (count == 1 ? "" : "s");
}

/** The size of chiasm_tensor when it was first published. */
constexpr size_t kFirstSize = CHIASM_SIZE_THROUGH(chiasm_tensor, strides);

void check_array(const chiasm_tensor* tensors, size_t count, size_t expected, const char* kind) {
  if (count != expected) {
    fail(CHIASM_INVALID_ARGUMENT, "expected " + counted(expected, kind) + ", got " + std::to_string(count));
  }
  if (tensors == nullptr) fail(CHIASM_INVALID_ARGUMENT, std::string("the array of ") + kind + "s is NULL");
  // No version of the struct is longer than this. A larger size means that the caller has not set it, and it
  // would lead to a wrong address for the next struct.
  constexpr size_t kLongest = 1024;
  const size_t size = tensors->struct_size;
  if (size < kFirstSize || size > kLongest || size % alignof(chiasm_tensor) != 0) {
    fail(CHIASM_INVALID_ARGUMENT,
         std::string(kind) + " 0: struct_size is " + std::to_string(tensors->struct_size) +
             ", expected sizeof(chiasm_tensor), " + std::to_string(sizeof(chiasm_tensor)));
  }
}

/** Dense in the order N, H, W, C while the shape says N, C, H, W (or the same without N). */
bool looks_channels_last(const chiasm_tensor& tensor) {
  const int32_t n = tensor.ndim;
  if (n < 3) return false;
  const int64_t* shape = tensor.shape + n - 3;
  const int64_t* strides = tensor.strides + n - 3;
  return strides[0] == 1 && strides[2] == shape[0] && strides[1] == shape[0] * shape[2];
}

/** Whether a tensor is a batch of frames, for which the caller may pass a single frame. */
bool is_frames(const TensorSpec& spec) { return spec.layout == "NHWC" && spec.shape.size() == 4; }

}  // namespace

std::string shape_text(const int64_t* shape, int32_t ndim) {
  std::string text = "(";
  for (int32_t i = 0; i < ndim; ++i) text += (i == 0 ? "" : ", ") + std::to_string(shape[i]);
  return text + (ndim == 1 ? ",)" : ")");
}

std::string device_text(int32_t type, int32_t index) {
  if (type == CHIASM_CPU && index == 0) return "the CPU";
  if (type == CHIASM_CPU) return "the CPU with index " + std::to_string(index);
  if (type == CHIASM_CUDA) return "CUDA device " + std::to_string(index);
  return "an unknown device type " + std::to_string(type);
}

chiasm_tensor Call::seen_output(size_t n) const {
  chiasm_tensor tensor = outputs[n];
  if (missing == 0 || (frame_outputs >> n & 1) == 0 || tensor.shape[0] != 1) return tensor;
  tensor.ndim -= missing == 2 && tensor.shape[3] == 1 ? 2 : 1;
  ++tensor.shape;
  return tensor;
}

Signature::Signature(const MethodSpec& method, const std::vector<Symbol>& symbols, int32_t generic_dtype,
                     int32_t device_type, int32_t device_index)
    : symbols_(symbols), device_type_(device_type), device_index_(device_index) {
  std::vector<bool> bound(symbols.size(), false);
  bindings_.resize(symbols.size());
  const auto dtype_of = [generic_dtype](const TensorSpec& spec) {
    return spec.dtype == kGeneric ? generic_dtype : spec.dtype;
  };
  for (const TensorSpec& spec : method.inputs) {
    TensorRule rule{&spec, dtype_of(spec), {}, is_frames(spec)};
    for (const Expression& dim : spec.shape) {
      if (dim.is_constant()) {
        rule.dims.push_back({Rule::constant, dim.operand()});
      } else if (!dim.is_symbol()) {
        rule.dims.push_back({Rule::expression, 0});
        has_input_expressions_ = true;
      } else {
        const auto symbol = static_cast<size_t>(dim.operand());
        rule.dims.push_back({bound[symbol] ? Rule::same : Rule::bind, dim.operand()});
        if (!bound[symbol]) bindings_[symbol] = {inputs_.size(), rule.dims.size() - 1};
        bound[symbol] = true;
      }
    }
    inputs_.push_back(std::move(rule));
  }
  for (const TensorSpec& spec : method.outputs)
    outputs_.push_back({&spec, dtype_of(spec), {}, is_frames(spec)});
}

void Signature::check_common(const chiasm_tensor& tensor, const TensorRule& rule, const char* kind) const {
  const std::string& name = rule.spec->name;
  if (tensor.struct_size < kFirstSize) {
    refuse(kind, name,
           "struct_size is " + std::to_string(tensor.struct_size) + ", expected sizeof(chiasm_tensor), " +
               std::to_string(sizeof(chiasm_tensor)));
  }
  if (tensor.dtype != rule.dtype) {
    std::string what =
        std::string("expected ") + dtype_name(rule.dtype) + ", got " + dtype_name(tensor.dtype);
    if (!is_dtype(tensor.dtype)) what += " (" + std::to_string(tensor.dtype) + ")";
    if (rule.spec->dtype == kGeneric) {
      what += "; the method was loaded for " + std::string(dtype_name(rule.dtype)) +
              ", which all its tensors of type T have: convert, or load it with another dtype in the load "
              "options";
    }
    refuse(kind, name, what);
  }
  if (tensor.device_type != device_type_ || tensor.device_index != device_index_) {
    refuse(kind, name,
           "expected memory on " + device_text(device_type_, device_index_) +
               ", where the method was loaded, got " + device_text(tensor.device_type, tensor.device_index));
  }
  const auto rank = static_cast<int32_t>(rule.spec->shape.size());
  if (tensor.ndim < 0 || tensor.ndim > CHIASM_MAX_DIMS) {
    refuse(kind, name, "ndim is " + std::to_string(tensor.ndim) + ", expected " + std::to_string(rank));
  }
  if (tensor.shape == nullptr && tensor.ndim > 0) refuse(kind, name, "its shape is NULL");
  if (tensor.data == nullptr) refuse(kind, name, "its data is NULL");
  const size_t size = kDTypes[rule.dtype].size;
  if ((reinterpret_cast<uintptr_t>(tensor.data) & (size - 1)) != 0) {
    refuse(kind, name,
           "its data is not aligned to " + std::to_string(size) + " bytes, the size of its elements");
  }
}

// An input that may be a single frame, as a batch. In a call either all frames are single or none is. The
// `first` one decides whether outputs with one channel lack the channel dimension.
chiasm_tensor Signature::as_batch(const chiasm_tensor& tensor, size_t n, bool first, Call& call) const {
  const TensorRule& rule = inputs_[n];
  if (!rule.frames) return tensor;
  const int32_t missing = 4 - tensor.ndim;
  if (missing < 0 || missing > 2) return tensor;
  if (first) call.missing = missing;
  if ((missing == 0) != (call.missing == 0)) {
    refuse_shape(tensor, rule, "input", call, n,
                 ": frames alone and batches of frames do not go together in a call");
  }
  if (missing == 0) return tensor;
  int64_t* const shape = call.frame_shapes[n];
  shape[0] = shape[3] = 1;
  std::copy_n(tensor.shape, tensor.ndim, shape + 1);
  chiasm_tensor batch = tensor;
  batch.ndim = 4;
  batch.shape = shape;
  return batch;
}

bool Signature::has_gaps(const chiasm_tensor& tensor, const TensorRule& rule, const char* kind) const {
  if (tensor.strides == nullptr) return false;
  const int64_t* const end = tensor.shape + tensor.ndim;
  if (std::find(tensor.shape, end, 0) != end) return false;  // no elements, so the strides do not matter
  const Order order = order_of(tensor);
  if (order == Order::dense || (order == Order::gaps && device_type_ == CHIASM_CPU))
    return order == Order::gaps;
  refuse(kind, rule.spec->name,
         std::string("expected ") +
             (device_type_ == CHIASM_CPU ? "elements in row-major order, none of which share memory"
                                         : "dense row-major memory") +
             ", got strides " + shape_text(tensor.strides, tensor.ndim) + " for shape " +
             shape_text(tensor.shape, tensor.ndim) +
             (looks_channels_last(tensor) ? ", which is the channels-last layout" : "") +
             ": pass a dense copy (torch: .contiguous(), numpy: ascontiguousarray, cv::Mat: .clone(), Eigen: "
             "chiasm::row_major)");
}

void Signature::refuse_shape(const chiasm_tensor& tensor, const TensorRule& rule, const char* kind,
                             const Call& call, size_t tensor_index, const std::string& why) const {
  std::string shape = "(", known;
  std::vector<size_t> told;
  const bool is_input = kind[0] == 'i';
  const auto& dims = rule.spec->shape;
  for (size_t i = 0; i < dims.size(); ++i) {
    shape += (i == 0 ? "" : ", ") + dims[i].text();
    for (const size_t symbol : dims[i].symbols()) {
      const Binding& from = bindings_[symbol];
      // Leave out symbols whose value comes from the failing tensor itself: the message has its shape anyway.
      // When outputs are checked, all symbols are known; outputs give none a value.
      const bool gives = is_input && from.input == tensor_index && rule.dims[i].rule == Rule::bind;
      if (gives || (is_input && !call.known[symbol]) ||
          std::find(told.begin(), told.end(), symbol) != told.end())
        continue;
      told.push_back(symbol);
      known += (known.empty() ? " with " : ", ") + symbols_[symbol].name + "=" +
               std::to_string(call.symbols[symbol]) + " (from ";
      known += is_input && from.input == tensor_index ? "dimension " + std::to_string(from.dim) + ")"
                                                      : "input '" + inputs_[from.input].spec->name + "')";
    }
  }
  shape += dims.size() == 1 ? ",)" : ")";
  refuse(kind, rule.spec->name,
         "expected shape " + shape + known + ", got " + shape_text(tensor.shape, tensor.ndim) + why);
}

int64_t Signature::evaluate(const Expression& dim, const TensorRule& rule, const char* kind,
                            const Call& call) const {
  int64_t value = 0;
  const Expression::Fault fault = dim.evaluate(call.symbols, &value);
  if (fault == Expression::Fault::none && value >= 0) return value;
  const char* const what = fault == Expression::Fault::division_by_zero ? " divides by zero"
                           : fault == Expression::Fault::overflow       ? " overflows"
                                                                        : " is negative";
  std::string values;
  for (const size_t symbol : dim.symbols()) {
    values += (values.empty() ? " with " : ", ") + symbols_[symbol].name + "=" +
              std::to_string(call.symbols[symbol]);
  }
  refuse(kind, rule.spec->name, "its dimension '" + dim.text() + "'" + what + values);
}

void Signature::check_inputs(const chiasm_tensor* inputs, size_t count, Call& call) const {
  check_array(inputs, count, inputs_.size(), "input");
  bool first_frames = true;
  call.known.reset();
  for (size_t n = 0; n < count; ++n) {
    const TensorRule& rule = inputs_[n];
    const chiasm_tensor& given = tensor_at(inputs, n);
    check_common(given, rule, "input");
    const chiasm_tensor tensor = as_batch(given, n, first_frames, call);
    first_frames = first_frames && !rule.frames;
    call.inputs[n] = tensor;
    if (static_cast<size_t>(tensor.ndim) != rule.dims.size()) {
      refuse_shape(given, rule, "input", call, n, "");
    }
    for (size_t i = 0; i < rule.dims.size(); ++i) {
      const int64_t got = tensor.shape[i];
      const DimRule& dim = rule.dims[i];
      if (dim.rule == Rule::bind) {
        const Symbol& symbol = symbols_[static_cast<size_t>(dim.operand)];
        if (got < symbol.min || got > symbol.max) {
          refuse_shape(given, rule, "input", call, n,
                       ": " + symbol.name + " must be from " + std::to_string(symbol.min) + " to " +
                           std::to_string(symbol.max));
        }
        call.symbols[dim.operand] = got;
        call.known.set(static_cast<size_t>(dim.operand));
      } else if (dim.rule != Rule::expression) {
        const int64_t expected = dim.rule == Rule::constant ? dim.operand : call.symbols[dim.operand];
        if (got != expected) refuse_shape(given, rule, "input", call, n, "");
      }
    }
  }
  if (has_input_expressions_) {
    for (size_t n = 0; n < count; ++n) {
      const chiasm_tensor& tensor = call.inputs[n];
      for (size_t i = 0; i < inputs_[n].dims.size(); ++i) {
        if (inputs_[n].dims[i].rule != Rule::expression) continue;
        const int64_t expected = evaluate(inputs_[n].spec->shape[i], inputs_[n], "input", call);
        if (tensor.shape[i] != expected) {
          refuse_shape(tensor_at(inputs, n), inputs_[n], "input", call, n,
                       ": " + inputs_[n].spec->shape[i].text() + " is " + std::to_string(expected));
        }
      }
    }
  }
  for (size_t n = 0; n < count; ++n) {
    bytes_of(call.inputs[n], "input", inputs_[n].spec->name.c_str());
    if (has_gaps(tensor_at(inputs, n), inputs_[n], "input")) call.gaps_in_inputs |= uint64_t{1} << n;
    call.inputs[n].struct_size = sizeof(chiasm_tensor);
    call.inputs[n].strides = nullptr;
  }
  infer_outputs(call);
}

void Signature::infer_outputs(Call& call) const {
  for (size_t n = 0; n < outputs_.size(); ++n) {
    const TensorRule& rule = outputs_[n];
    if (rule.frames) call.frame_outputs |= uint64_t{1} << n;
    const auto& dims = rule.spec->shape;
    for (size_t i = 0; i < dims.size(); ++i)
      call.output_shapes[n][i] = evaluate(dims[i], rule, "output", call);
    call.outputs[n] = {sizeof(chiasm_tensor), nullptr,       rule.dtype,
                       device_type_,          device_index_, static_cast<int32_t>(dims.size()),
                       call.output_shapes[n], nullptr};
    call.output_bytes[n] = bytes_of(call.outputs[n], "output", rule.spec->name.c_str());
  }
}

size_t Signature::bytes_of(const chiasm_tensor& tensor, const char* kind, const char* name) {
  int64_t bytes = static_cast<int64_t>(kDTypes[tensor.dtype].size);
  bool empty = false, overflow = false;
  for (int32_t i = 0; i < tensor.ndim; ++i) {
    empty = empty || tensor.shape[i] == 0;
    overflow = overflow || __builtin_mul_overflow(bytes, tensor.shape[i], &bytes);
  }
  if (empty) return 0;
  if (overflow) refuse(kind, name, "shape " + shape_text(tensor.shape, tensor.ndim) + " is too large");
  return static_cast<size_t>(bytes);
}

void Signature::check_outputs(const chiasm_tensor* outputs, size_t count, Call& call) const {
  check_array(outputs, count, outputs_.size(), "output");
  for (size_t n = 0; n < count; ++n) {
    const chiasm_tensor& tensor = tensor_at(outputs, n);
    const TensorRule& rule = outputs_[n];
    check_common(tensor, rule, "output");
    const chiasm_tensor expected = call.seen_output(n);
    if (tensor.ndim != expected.ndim ||
        !std::equal(tensor.shape, tensor.shape + tensor.ndim, expected.shape)) {
      refuse_shape(tensor, rule, "output", call, n,
                   "; for these inputs it is " + shape_text(expected.shape, expected.ndim));
    }
    if (has_gaps(tensor, rule, "output")) call.gaps_in_outputs |= uint64_t{1} << n;
    call.outputs[n].data = tensor.data;
  }
  const auto overlap = [](const chiasm_tensor& a, const chiasm_tensor& b) {
    const size_t a_size = bytes_spanned(a), b_size = bytes_spanned(b);
    const auto x = reinterpret_cast<uintptr_t>(a.data), y = reinterpret_cast<uintptr_t>(b.data);
    return a_size > 0 && b_size > 0 && x < y + b_size && y < x + a_size;
  };
  for (size_t n = 0; n < count; ++n) {
    const char* const name = outputs_[n].spec->name.c_str();
    for (size_t i = 0; i < inputs_.size(); ++i) {
      // Tensors with gaps are copied before or after the run, so they may overlap.
      if ((call.gaps_in_outputs >> n & 1) != 0 || (call.gaps_in_inputs >> i & 1) != 0) continue;
      if (overlap(call.outputs[n], call.inputs[i])) {
        refuse("output", name, "its memory overlaps that of input '" + inputs_[i].spec->name + "'");
      }
    }
    for (size_t i = 0; i < n; ++i) {
      if (overlap(tensor_at(outputs, n), tensor_at(outputs, i))) {
        refuse("output", name, "its memory overlaps that of output '" + outputs_[i].spec->name + "'");
      }
    }
  }
}

void Signature::check_bools(const Call& call) const {
  if (device_type_ != CHIASM_CPU) return;
  for (size_t n = 0; n < inputs_.size(); ++n) {
    if (inputs_[n].dtype != CHIASM_BOOL) continue;
    const auto* const bytes = static_cast<const uint8_t*>(call.inputs[n].data);
    const size_t count = byte_count(call.inputs[n]);
    uint8_t any = 0;
    for (size_t i = 0; i < count; ++i) any |= bytes[i];
    if (any <= 1) continue;
    const size_t wrong = static_cast<size_t>(
        std::find_if(bytes, bytes + count, [](uint8_t byte) { return byte > 1; }) - bytes);
    refuse("input", inputs_[n].spec->name,
           "a bool is a byte that is 0 or 1, got " + std::to_string(bytes[wrong]) + " at element " +
               std::to_string(wrong) + ": compare with 0 first (mask != 0)");
  }
}

void Signature::smallest_call(Call& call, int64_t (*shapes)[CHIASM_MAX_DIMS]) const {
  for (size_t i = 0; i < symbols_.size(); ++i) call.symbols[i] = symbols_[i].min;
  for (size_t n = 0; n < inputs_.size(); ++n) {
    const TensorRule& rule = inputs_[n];
    const auto& dims = rule.spec->shape;
    for (size_t i = 0; i < dims.size(); ++i) shapes[n][i] = evaluate(dims[i], rule, "input", call);
    call.inputs[n] = {sizeof(chiasm_tensor),
                      nullptr,
                      rule.dtype,
                      device_type_,
                      device_index_,
                      static_cast<int32_t>(dims.size()),
                      shapes[n],
                      nullptr};
  }
  infer_outputs(call);
}

}  // namespace chiasm::core
