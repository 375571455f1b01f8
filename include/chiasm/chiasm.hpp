/** \file
 *  chiasm: the C++17 interface of the runtime, header-only over the C interface of chiasm.h.
 *
 *      auto sobel = chiasm::Bundle::open("filters.sobel.chiasm").method("forward");
 *      std::vector<float> image(1 * 3 * 256 * 256, 0.5f);
 *      auto out = sobel.run({chiasm::Tensor(image.data(), {1, 3, 256, 256})});
 *      const float* edges = out[0].data<float>();
 *
 *  Handles (Bundle, Method, Outputs) are move-only and may be destroyed in any order: a Method keeps its
 *  bundle alive, and Outputs own their memory. A moved-from handle may be destroyed, assigned to and tested
 *  with `if (handle)`; its c_handle() is NULL, and any other use throws Error. A Tensor is a view: what it
 *  views must outlive it. Every failure throws Error. No type of the standard library crosses the boundary to
 *  libchiasm, so any compiler and any settings work.
 */
#ifndef CHIASM_CHIASM_HPP
#define CHIASM_CHIASM_HPP

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <initializer_list>
#include <memory>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "chiasm/chiasm.h"

namespace chiasm {

/** The exception of every failure. what() names the argument, the expected and the actual value. */
class Error final : public std::runtime_error {
 public:
  Error(chiasm_code code, const std::string& message) : std::runtime_error(message), code_(code) {}
  chiasm_code code() const noexcept { return code_; }

 private:
  chiasm_code code_;
};

/** Element types; the values are those of chiasm_dtype. */
enum class DType : int32_t {
  Bool = CHIASM_BOOL,
  UInt8 = CHIASM_UINT8,
  Int8 = CHIASM_INT8,
  Int16 = CHIASM_INT16,
  Int32 = CHIASM_INT32,
  Int64 = CHIASM_INT64,
  Float16 = CHIASM_FLOAT16,
  BFloat16 = CHIASM_BFLOAT16,
  Float32 = CHIASM_FLOAT32,
  Float64 = CHIASM_FLOAT64,
  UInt16 = CHIASM_UINT16
};

/** "float32" */
inline const char* name(DType dtype) noexcept {
  constexpr const char* kNames[] = {"bool",    "uint8",    "int8",    "int16",   "int32", "int64",
                                    "float16", "bfloat16", "float32", "float64", "uint16"};
  const auto index = static_cast<size_t>(dtype);
  return index < sizeof kNames / sizeof kNames[0] ? kNames[index] : "unknown";
}

/** The DType of a C++ type. Specialise it for a half-precision type of your own. */
template <class T>
struct DTypeOf {
  static_assert(sizeof(T) == 0, "chiasm has no dtype for this type; pass a void pointer and a DType");
};
template <>
struct DTypeOf<bool> {
  static constexpr DType value = DType::Bool;
};
template <>
struct DTypeOf<uint8_t> {
  static constexpr DType value = DType::UInt8;
};
template <>
struct DTypeOf<uint16_t> {
  static constexpr DType value = DType::UInt16;
};
template <>
struct DTypeOf<int8_t> {
  static constexpr DType value = DType::Int8;
};
template <>
struct DTypeOf<int16_t> {
  static constexpr DType value = DType::Int16;
};
template <>
struct DTypeOf<int32_t> {
  static constexpr DType value = DType::Int32;
};
template <>
struct DTypeOf<int64_t> {
  static constexpr DType value = DType::Int64;
};
template <>
struct DTypeOf<float> {
  static constexpr DType value = DType::Float32;
};
template <>
struct DTypeOf<double> {
  static constexpr DType value = DType::Float64;
};

/** The DType of a C++ type. */
template <class T>
inline constexpr DType dtype_of = DTypeOf<std::remove_cv_t<T>>::value;

/** Where memory lives. */
struct Device {
  chiasm_device_type type = CHIASM_CPU;
  int32_t index = 0;

  static Device cpu() noexcept { return {}; }
  static Device cuda(int32_t index = 0) noexcept { return {CHIASM_CUDA, index}; }
  friend bool operator==(Device a, Device b) noexcept { return a.type == b.type && a.index == b.index; }
  friend bool operator!=(Device a, Device b) noexcept { return !(a == b); }
};

/** A short list of sizes or strides, at most CHIASM_MAX_DIMS, held in place. */
class Shape final {
 public:
  Shape() = default;
  Shape(std::initializer_list<int64_t> sizes) : Shape(sizes.begin(), sizes.size()) {}
  explicit Shape(const std::vector<int64_t>& sizes) : Shape(sizes.data(), sizes.size()) {}
  /** Throws Error if `count` is more than CHIASM_MAX_DIMS. */
  Shape(const int64_t* sizes, size_t count) : count_(count) {
    if (count > CHIASM_MAX_DIMS) {
      throw Error(CHIASM_INVALID_ARGUMENT, "a tensor has at most " + std::to_string(CHIASM_MAX_DIMS) +
                                               " dimensions, got " + std::to_string(count));
    }
    std::copy(sizes, sizes + count, sizes_);
  }

  size_t size() const noexcept { return count_; }
  bool empty() const noexcept { return count_ == 0; }
  const int64_t* data() const noexcept { return sizes_; }
  const int64_t* begin() const noexcept { return sizes_; }
  const int64_t* end() const noexcept { return sizes_ + count_; }
  /** Not checked. */
  int64_t operator[](size_t i) const noexcept { return sizes_[i]; }
  int64_t& operator[](size_t i) noexcept { return sizes_[i]; }
  /** The number of elements: the product of the sizes. */
  int64_t count() const noexcept {
    int64_t count = 1;
    for (const int64_t size : *this) count *= size;
    return count;
  }
  friend bool operator==(const Shape& a, const Shape& b) noexcept {
    return std::equal(a.begin(), a.end(), b.begin(), b.end());
  }
  friend bool operator!=(const Shape& a, const Shape& b) noexcept { return !(a == b); }

 private:
  int64_t sizes_[CHIASM_MAX_DIMS] = {};
  size_t count_ = 0;
};

/** A non-owning view of a tensor: pointer, dtype, shape, strides, device. Cheap to copy.
 *
 *  The memory must outlive every use of the view. A view made from a pointer to const is read-only: it may be
 *  an input, not an output.
 */
class Tensor {
 public:
  /** A dense row-major tensor in CPU memory, or on `device`. */
  template <class T, class = std::enable_if_t<!std::is_void_v<T>>>
  Tensor(T* data, Shape shape, Device device = {})
      : Tensor(const_cast<std::remove_cv_t<T>*>(data), dtype_of<T>, shape, Shape(), device,
               std::is_const_v<T>) {}
  Tensor(void* data, DType dtype, Shape shape, Device device = {})
      : Tensor(data, dtype, shape, Shape(), device, false) {}
  Tensor(const void* data, DType dtype, Shape shape, Device device = {})
      : Tensor(const_cast<void*>(data), dtype, shape, Shape(), device, true) {}

  /** With strides, counted in elements. A run copies elements in row-major order with gaps between them, and
   *  rejects any other order with a message: see chiasm_tensor in chiasm.h. */
  template <class T>
  static Tensor strided(T* data, Shape shape, Shape strides, Device device = {}) {
    return strided(data, dtype_of<T>, shape, strides, device);
  }
  static Tensor strided(void* data, DType dtype, Shape shape, Shape strides, Device device = {}) {
    return Tensor(data, dtype, shape, check_strides(shape, strides), device, false);
  }
  static Tensor strided(const void* data, DType dtype, Shape shape, Shape strides, Device device = {}) {
    return Tensor(const_cast<void*>(data), dtype, shape, check_strides(shape, strides), device, true);
  }

  /** A view of a tensor of the C interface. */
  explicit Tensor(const chiasm_tensor& tensor)
      : data_(tensor.data),
        dtype_(static_cast<DType>(tensor.dtype)),
        shape_(tensor.shape, static_cast<size_t>(tensor.ndim)),
        strides_(tensor.strides, tensor.strides == nullptr ? 0 : static_cast<size_t>(tensor.ndim)),
        device_{static_cast<chiasm_device_type>(tensor.device_type), tensor.device_index},
        has_strides_(tensor.strides != nullptr) {}

  /** The elements. Throws Error if T is not the tensor's type, or if the view is read-only and T is not
   *  const. */
  template <class T>
  T* data() const {
    if (dtype_of<T> != dtype_) {
      throw Error(CHIASM_INVALID_ARGUMENT, std::string("the tensor is ") + chiasm::name(dtype_) + ", not " +
                                               chiasm::name(dtype_of<T>));
    }
    if (read_only_ && !std::is_const_v<T>)
      throw Error(CHIASM_INVALID_ARGUMENT, "the tensor is read-only: ask for a const type");
    return static_cast<T*>(data_);
  }
  void* data() const noexcept { return data_; }
  DType dtype() const noexcept { return dtype_; }
  const Shape& shape() const noexcept { return shape_; }
  /** In elements; those of dense row-major memory if none were given. */
  Shape strides() const noexcept {
    if (has_strides_) return strides_;
    Shape dense = shape_;
    int64_t step = 1;
    for (size_t i = shape_.size(); i-- > 0;) {
      dense[i] = step;
      step *= shape_[i];
    }
    return dense;
  }
  Device device() const noexcept { return device_; }
  bool read_only() const noexcept { return read_only_; }
  /** The number of elements. */
  int64_t count() const noexcept { return shape_.count(); }
  /** Whether the memory is dense and row-major, as engines take it. */
  bool is_contiguous() const noexcept {
    if (!has_strides_) return true;
    int64_t step = 1;
    for (size_t i = shape_.size(); i-- > 0;) {
      if (shape_[i] != 1 && strides_[i] != step) return false;
      step *= shape_[i];
    }
    return true;
  }

  /** For the C interface; points into this object. */
  chiasm_tensor c_tensor() const noexcept {
    return {sizeof(chiasm_tensor),
            data_,
            static_cast<int32_t>(dtype_),
            static_cast<int32_t>(device_.type),
            device_.index,
            static_cast<int32_t>(shape_.size()),
            shape_.data(),
            has_strides_ ? strides_.data() : nullptr};
  }

 private:
  Tensor(void* data, DType dtype, Shape shape, Shape strides, Device device, bool read_only)
      : data_(data),
        dtype_(dtype),
        shape_(shape),
        strides_(strides),
        device_(device),
        has_strides_(!strides.empty()),
        read_only_(read_only) {}

  static const Shape& check_strides(const Shape& shape, const Shape& strides) {
    if (shape.size() != strides.size())
      throw Error(CHIASM_INVALID_ARGUMENT, "shape and strides differ in length");
    return strides;
  }

  void* data_ = nullptr;
  DType dtype_ = DType::Float32;
  Shape shape_, strides_;
  Device device_;
  bool has_strides_ = false;
  bool read_only_ = false;
};

namespace detail {

/** The function table. Throws Error if the library is older than this header. */
inline const chiasm_api& api() {
  static const chiasm_api* const table = chiasm_get_api(CHIASM_API_VERSION);
  if (table == nullptr) {
    throw Error(CHIASM_VERSION_MISMATCH,
                "libchiasm is older than the header chiasm.hpp: it has no interface version " +
                    std::to_string(CHIASM_API_VERSION));
  }
  return *table;
}

/** Frees the status, and throws its error if it holds one. */
inline void check(chiasm_status* status) {
  if (status == nullptr) return;
  const std::unique_ptr<chiasm_status, void (*)(chiasm_status*)> owned(status, api().status_free);
  throw Error(static_cast<chiasm_code>(api().status_code(status)), api().status_message(status));
}

/** The i-th struct of an array. A newer library's structs may be longer than those of this header. */
template <class T>
const T& element(const T* array, size_t i) noexcept {
  return *reinterpret_cast<const T*>(reinterpret_cast<const char*>(array) + i * array->struct_size);
}

/** The C form of a list of tensors; on the stack unless there are many. Points into the tensors. */
class TensorList final {
 public:
  TensorList(const Tensor* tensors, size_t count) : count_(count) {
    if (count > kInPlace) many_.resize(count);
    chiasm_tensor* const out = count > kInPlace ? many_.data() : few_;
    for (size_t i = 0; i < count; ++i) out[i] = tensors[i].c_tensor();
  }
  const chiasm_tensor* data() const noexcept { return count_ > kInPlace ? many_.data() : few_; }
  size_t size() const noexcept { return count_; }

 private:
  static constexpr size_t kInPlace = 8;
  size_t count_;
  chiasm_tensor few_[kInPlace];
  std::vector<chiasm_tensor> many_;
};

struct CloseBundle {
  void operator()(chiasm_bundle* bundle) const noexcept { api().bundle_close(bundle); }
};
struct CloseMethod {
  void operator()(chiasm_method* method) const noexcept { api().method_close(method); }
};
struct FreeOutputs {
  void operator()(chiasm_outputs* outputs) const noexcept { api().outputs_free(outputs); }
};

/** The handle. Throws Error if it was moved from. */
template <class Handle>
auto* use(const Handle& handle, const char* what) {
  if (handle == nullptr)
    throw Error(CHIASM_FAILED_PRECONDITION, std::string("this ") + what + " was moved from");
  return handle.get();
}

}  // namespace detail

/** One dimension of a signature: a constant, a symbol with limits, or an expression ("2*H", without
 *  limits). */
struct DimInfo {
  std::string expression;
  int64_t min = 0, max = 0;
};

/** One input or output of a signature. */
struct TensorInfo {
  std::string name, description, layout, color;
  std::vector<DType> dtypes; /**< the dtypes accepted; if several, all generic tensors of a call agree */
  std::vector<DimInfo> dims;
  double value_min = 0, value_max = 0; /**< nominal range; both 0 if not stated */
};

/** A method's signature. */
struct MethodInfo {
  std::string name;
  std::vector<TensorInfo> inputs, outputs;
};

/** A bundle's description of itself. */
struct BundleInfo {
  std::string name, version, summary, path;
  std::string manifest; /**< its JSON text */
};

/** A backend, and whether it can be used in this process. */
struct BackendInfo {
  std::string name;
  bool available = false;
  bool has_cuda = false;
  std::string engine_version; /**< "" if not available */
  std::string problem;        /**< "" if available; else what is missing and how to get it */
};

/** One row of a self-test. */
struct SelfTestRow {
  enum class Result { NotRun = -1, Failed = 0, Passed = 1 };
  std::string method, backend, artifact, dtype;
  Result result = Result::NotRun;
  double max_error = 0; /**< largest absolute difference to the golden output */
  double tolerance = 0; /**< the absolute part of the tolerance */
  std::string message;  /**< "" or what went wrong */
};

/** How to load a method. */
struct LoadOptions {
  /** "native", "torch", "onnx", ...; "auto": the first, by priority, that can run it here */
  std::string backend = "auto";
  Device device;
  /** false: only artifacts that are data (ONNX, or what a backend declares as data); see chiasm.h */
  bool allow_native_code = true;
  int32_t dtype = -1; /**< for generic methods; -1: float32, else the first available */
  /** onnx: run native code inside ONNX Runtime if the bundle has it; see chiasm.h */
  bool fused = true;
  /** run once on the smallest input, so that the first real run is not the slow one */
  bool warm_up = false;
  /** threads of a run of this method; 0: as many as the process may use; see chiasm.h */
  int32_t num_threads = 0;
  std::vector<std::string> options; /**< options of the backend named above, each "key=value" */

  LoadOptions& with_backend(std::string value) {
    backend = std::move(value);
    return *this;
  }
  LoadOptions& with_device(Device value) {
    device = value;
    return *this;
  }
  LoadOptions& with_dtype(DType value) {
    dtype = static_cast<int32_t>(value);
    return *this;
  }
  LoadOptions& with_allow_native_code(bool value) {
    allow_native_code = value;
    return *this;
  }
  LoadOptions& with_fused(bool value) {
    fused = value;
    return *this;
  }
  LoadOptions& with_warm_up(bool value = true) {
    warm_up = value;
    return *this;
  }
  LoadOptions& with_num_threads(int32_t value) {
    num_threads = value;
    return *this;
  }
  LoadOptions& with_option(const std::string& key, const std::string& value) {
    options.push_back(key + "=" + value);
    return *this;
  }
};

namespace detail {

/** LoadOptions for the C interface; points into them. */
class CLoadOptions final {
 public:
  explicit CLoadOptions(const LoadOptions& from) {
    for (const std::string& option : from.options) texts_.push_back(option.c_str());
    texts_.push_back(nullptr);
    options_.backend = from.backend.c_str();
    options_.device_type = from.device.type;
    options_.device_index = from.device.index;
    options_.allow_native_code = from.allow_native_code ? 1 : 0;
    options_.dtype = from.dtype;
    options_.fused = from.fused ? 1 : 0;
    options_.warm_up = from.warm_up ? 1 : 0;
    options_.num_threads = from.num_threads;
    options_.options = texts_.data();
  }
  CLoadOptions(const CLoadOptions&) = delete;
  CLoadOptions& operator=(const CLoadOptions&) = delete;
  const chiasm_load_options* get() const noexcept { return &options_; }

 private:
  std::vector<const char*> texts_;
  chiasm_load_options options_ = CHIASM_LOAD_OPTIONS_INIT;
};

}  // namespace detail

/** A view of an output of temporary Outputs, whose memory is freed at the end of the statement:
 *  `b.run({a.run({x})[0]})`. Functions that return a pointer to the memory are deleted: `float* p =
 *  a.run({x})[0].data<float>()` does not compile. Keep the Outputs in a variable. */
class TemporaryTensor final : public Tensor {
 public:
  explicit TemporaryTensor(const Tensor& tensor) : Tensor(tensor) {}
  template <class T>
  T* data() const = delete;
  void* data() const = delete;
  chiasm_tensor c_tensor() const = delete;
};

/** Output tensors that the library allocated; they own their memory and need neither method nor bundle. */
class Outputs final {
 public:
  explicit Outputs(chiasm_outputs* outputs) noexcept : handle_(outputs) {}
  explicit operator bool() const noexcept { return handle_ != nullptr; }

  size_t size() const { return detail::api().outputs_count(detail::use(handle_, "Outputs")); }
  /** A view, valid as long as these Outputs. Throws Error if there is no such output. */
  Tensor operator[](size_t i) const& {
    const chiasm_tensor* const tensor = detail::api().outputs_get(detail::use(handle_, "Outputs"), i);
    if (tensor == nullptr) {
      throw Error(CHIASM_INVALID_ARGUMENT,
                  "there is no output " + std::to_string(i) + ", only " + std::to_string(size()));
    }
    return Tensor(*tensor);
  }
  TemporaryTensor operator[](size_t i) const&& { return TemporaryTensor((*this)[i]); }

 private:
  std::unique_ptr<chiasm_outputs, detail::FreeOutputs> handle_;
};

/** The shape and dtype of an output, known before the run. */
struct TensorType {
  Shape shape;
  DType dtype = DType::Float32;
};

/** A loaded method. run, run_into and run_each may be called from many threads at once. */
class Method final {
 public:
  explicit Method(chiasm_method* method) noexcept : handle_(method) {}
  explicit operator bool() const noexcept { return handle_ != nullptr; }

  /** Run into memory that the library allocates (on the CPU; with CUDA use run_into). Throws Error for inputs
   *  that do not fit the method's signature, before any engine reads them. `stream`: the cudaStream_t to
   *  enqueue on. */
  Outputs run(std::initializer_list<Tensor> inputs, void* stream = nullptr) const {
    return run(inputs.begin(), inputs.size(), stream);
  }
  Outputs run(const std::vector<Tensor>& inputs, void* stream = nullptr) const {
    return run(inputs.data(), inputs.size(), stream);
  }
  Outputs run(const Tensor* inputs, size_t count, void* stream = nullptr) const {
    const detail::TensorList list(inputs, count);
    const chiasm_run_options options{sizeof(chiasm_run_options), stream};
    chiasm_outputs* outputs = nullptr;
    detail::check(detail::api().method_run(handle(), list.data(), list.size(), &options, &outputs));
    return Outputs(outputs);
  }

  /** Run into the caller's memory: no allocation, no copy. Shapes and dtypes must be those of output_type,
   *  and the memory must not overlap the inputs or other outputs. */
  void run_into(std::initializer_list<Tensor> inputs, std::initializer_list<Tensor> outputs,
                void* stream = nullptr) const {
    run_into(inputs.begin(), inputs.size(), outputs.begin(), outputs.size(), stream);
  }
  void run_into(const std::vector<Tensor>& inputs, const std::vector<Tensor>& outputs,
                void* stream = nullptr) const {
    run_into(inputs.data(), inputs.size(), outputs.data(), outputs.size(), stream);
  }
  void run_into(const Tensor* inputs, size_t input_count, const Tensor* outputs, size_t output_count,
                void* stream = nullptr) const {
    for (size_t i = 0; i < output_count; ++i) {
      if (outputs[i].read_only())
        throw Error(CHIASM_INVALID_ARGUMENT, "output " + std::to_string(i) + " is read-only");
    }
    const detail::TensorList in(inputs, input_count), out(outputs, output_count);
    const chiasm_run_options options{sizeof(chiasm_run_options), stream};
    detail::check(
        detail::api().method_run_into(handle(), in.data(), in.size(), out.data(), out.size(), &options));
  }

  /** Several runs in one call, several of them at once: run i reads `inputs[i]` and writes `outputs[i]`. Load
   *  the method with one thread (LoadOptions::with_num_threads), so that each core does runs of its own.
   *  Frames of different sizes become one batch if the outputs are parts of one tensor:
   *
   *      std::vector<float> batch(frames.size() * 3 * 640 * 640);
   *      for (size_t i = 0; i < frames.size(); ++i) {
   *        inputs.push_back({chiasm::view(frames[i])});
   *        outputs.push_back({chiasm::Tensor(&batch[i * 3 * 640 * 640], {1, 3, 640, 640})});
   *      }
   *      method.run_each(inputs, outputs);
   *
   *  See method_run_each in chiasm.h for what is checked. */
  void run_each(const std::vector<std::vector<Tensor>>& inputs,
                const std::vector<std::vector<Tensor>>& outputs, void* stream = nullptr) const {
    if (inputs.size() != outputs.size())
      throw Error(CHIASM_INVALID_ARGUMENT, "run_each: " + std::to_string(inputs.size()) +
                                               " sets of inputs and " + std::to_string(outputs.size()) +
                                               " sets of outputs");
    const size_t runs = inputs.size();
    const size_t input_count = runs == 0 ? 0 : inputs[0].size(),
                 output_count = runs == 0 ? 0 : outputs[0].size();
    std::vector<Tensor> in, out;
    for (size_t i = 0; i < runs; ++i) {
      if (inputs[i].size() != input_count || outputs[i].size() != output_count)
        throw Error(CHIASM_INVALID_ARGUMENT,
                    "run_each: run " + std::to_string(i) + " has other numbers of tensors than run 0");
      in.insert(in.end(), inputs[i].begin(), inputs[i].end());
      for (const Tensor& tensor : outputs[i]) {
        if (tensor.read_only())
          throw Error(CHIASM_INVALID_ARGUMENT,
                      "run_each: an output of run " + std::to_string(i) + " is read-only");
        out.push_back(tensor);
      }
    }
    const detail::TensorList in_list(in.data(), in.size()), out_list(out.data(), out.size());
    const chiasm_run_options options{sizeof(chiasm_run_options), stream};
    detail::check(detail::api().method_run_each(handle(), runs, in_list.data(), input_count, out_list.data(),
                                                output_count, &options));
  }

  /** The type that output `index` will have for these inputs, which are checked as for a run. */
  TensorType output_type(const std::vector<Tensor>& inputs, size_t index = 0) const {
    const detail::TensorList list(inputs.data(), inputs.size());
    int64_t shape[CHIASM_MAX_DIMS];
    int32_t ndim = 0, dtype = 0;
    detail::check(
        detail::api().method_output_shape(handle(), list.data(), list.size(), index, shape, &ndim, &dtype));
    return {Shape(shape, static_cast<size_t>(ndim)), static_cast<DType>(dtype)};
  }

  /** The signature, with the dtype for which the method was loaded. */
  MethodInfo info() const;
  /** "native", "torch", "onnx", or the name of another plug-in. */
  std::string backend() const { return detail::api().method_backend(handle()); }
  /** The artifact's file name inside the bundle. */
  std::string artifact() const { return detail::api().method_artifact(handle()); }

  /** For the C interface; stays this object's. */
  chiasm_method* c_handle() const noexcept { return handle_.get(); }

 private:
  chiasm_method* handle() const { return detail::use(handle_, "Method"); }

  std::unique_ptr<chiasm_method, detail::CloseMethod> handle_;
};

namespace detail {

inline TensorInfo tensor_info(const chiasm_tensor_info& from) {
  TensorInfo to{from.name, from.description, from.layout, from.color, {}, {}, from.value_min, from.value_max};
  for (int32_t i = 0; i < from.dtype_count; ++i) to.dtypes.push_back(static_cast<DType>(from.dtypes[i]));
  for (int32_t i = 0; i < from.ndim; ++i) {
    const chiasm_dim_info& dim = element(from.dims, static_cast<size_t>(i));
    to.dims.push_back({dim.expression, dim.min, dim.max});
  }
  return to;
}

inline MethodInfo method_info(const chiasm_method_info& from) {
  MethodInfo to{from.name, {}, {}};
  for (int32_t i = 0; i < from.input_count; ++i)
    to.inputs.push_back(tensor_info(element(from.inputs, static_cast<size_t>(i))));
  for (int32_t i = 0; i < from.output_count; ++i)
    to.outputs.push_back(tensor_info(element(from.outputs, static_cast<size_t>(i))));
  return to;
}

/** Collects self-test rows behind a C callback, through which no exception may pass. */
struct RowCollector {
  std::vector<SelfTestRow> rows;
  std::exception_ptr error;

  static void add(const chiasm_self_test_row* row, void* user) noexcept {
    auto* const self = static_cast<RowCollector*>(user);
    try {
      self->rows.push_back({row->method, row->backend, row->artifact, row->dtype,
                            static_cast<SelfTestRow::Result>(row->passed), row->max_error, row->tolerance,
                            row->message});
    } catch (...) {
      self->error = std::current_exception();
    }
  }
};

}  // namespace detail

inline MethodInfo Method::info() const {
  return detail::method_info(*detail::api().method_get_info(handle()));
}

/** An open bundle. */
class Bundle final {
 public:
  /** Read and check the manifest of the folder `path`; no engine is loaded. */
  static Bundle open(const std::string& path) {
    chiasm_bundle* bundle = nullptr;
    detail::check(detail::api().bundle_open(path.c_str(), &bundle));
    return Bundle(bundle);
  }
  explicit Bundle(chiasm_bundle* bundle) noexcept : handle_(bundle) {}
  explicit operator bool() const noexcept { return handle_ != nullptr; }

  BundleInfo info() const {
    const chiasm_bundle_info& info = c_info();
    return {info.name, info.version, info.summary, info.path, info.manifest};
  }

  /** The signatures of all methods. */
  std::vector<MethodInfo> methods() const {
    const chiasm_bundle_info& info = c_info();
    std::vector<MethodInfo> methods;
    for (int32_t i = 0; i < info.method_count; ++i) {
      methods.push_back(detail::method_info(detail::element(info.methods, static_cast<size_t>(i))));
    }
    return methods;
  }

  /** Load a method: "forward", "vjp", ... */
  Method method(const std::string& name, const LoadOptions& options = {}) const {
    const detail::CLoadOptions c_options(options);
    chiasm_method* method = nullptr;
    detail::check(detail::api().method_load(handle(), name.c_str(), c_options.get(), &method));
    return Method(method);
  }

  /** Replay the golden vectors on every backend that is present here, or on the one in `options`. */
  std::vector<SelfTestRow> self_test(const LoadOptions& options = {}) const {
    const detail::CLoadOptions c_options(options);
    detail::RowCollector collector;
    detail::check(detail::api().bundle_self_test(handle(), c_options.get(), &detail::RowCollector::add,
                                                 &collector, nullptr));
    if (collector.error) std::rethrow_exception(collector.error);
    return std::move(collector.rows);
  }

  /** For the C interface; stays this object's. */
  chiasm_bundle* c_handle() const noexcept { return handle_.get(); }

 private:
  chiasm_bundle* handle() const { return detail::use(handle_, "Bundle"); }
  const chiasm_bundle_info& c_info() const { return *detail::api().bundle_get_info(handle()); }

  std::unique_ptr<chiasm_bundle, detail::CloseBundle> handle_;
};

/** The version of the library, "0.1.0". */
inline std::string library_version() { return detail::api().library_version(); }

/** The installed backends, including those whose engine is missing, in the order in which "auto" tries them.
 *  Opens the engine of each, which may take a while. */
inline std::vector<BackendInfo> backends() {
  std::vector<BackendInfo> all;
  for (size_t i = 0; i < detail::api().backend_count(); ++i) {
    chiasm_backend_info info{};
    info.struct_size = sizeof info;
    detail::check(detail::api().backend_info(i, &info));
    all.push_back({info.name, info.available == 1, info.has_cuda == 1, info.engine_version, info.problem});
  }
  return all;
}

/** How many threads a run may use, in every backend, 0 to 1024; 0: all cores of this process. Call it before
 *  the first method is loaded. */
inline void set_num_threads(int32_t count) { detail::check(detail::api().set_num_threads(count)); }
/** How many threads a run may use; more than 0. */
inline int32_t get_num_threads() { return detail::api().get_num_threads(); }

/** Which bundles this process runs; the values are those of chiasm_trust_policy. */
enum class TrustPolicy : int32_t {
  Any = CHIASM_TRUST_ANY,
  Signed = CHIASM_TRUST_SIGNED,
  DataOnly = CHIASM_TRUST_DATA_ONLY
};

/** Sets the trust policy of the process, which replaces the environment's. Call it before the first load.
 *  `keys`, for Signed: minisign public keys, or paths of files that hold one; see chiasm.h. */
inline void set_trust(TrustPolicy policy, const std::vector<std::string>& keys = {}) {
  std::vector<const char*> c_keys;
  for (const std::string& key : keys) c_keys.push_back(key.c_str());
  detail::check(detail::api().set_trust(static_cast<int32_t>(policy), c_keys.data(), c_keys.size()));
}
/** The trust policy of the process: the one that was set, or else the environment's. */
inline TrustPolicy get_trust() {
  int32_t policy = 0;
  detail::check(detail::api().get_trust(&policy, nullptr, nullptr));
  return static_cast<TrustPolicy>(policy);
}

}  // namespace chiasm

#endif  // CHIASM_CHIASM_HPP
