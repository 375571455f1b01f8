// What the calls of the kernels (calls.cpp, made by ../generate.py) are written with: arguments checked for
// types, shapes and numbers, or one sentence.
#pragma once

#include <torch/csrc/inductor/aoti_torch/c/shim.h>

#include <algorithm>
#include <cstdint>
#include <initializer_list>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>

#include "kernels.h"
#include "tensor.h"

namespace chiasm::kernels {

constexpr int64_t kAny = -1;  // of a size in an expected shape
// Of element types: float32 or float64, uint8 or int32, a pixel's, uint8 or uint16.
constexpr int32_t kT = -1, kI = -2, kP = -3, kU = -4;

[[noreturn]] inline void refuse(const char* name, const std::string& expected, const std::string& got) {
  throw std::runtime_error(std::string(name) + ": expected " + expected + ", got " + got +
                           "; the compiled op and its inputs do not belong together: export the op again");
}

inline std::string values_text(std::initializer_list<std::pair<const char*, int64_t>> values) {
  std::string text;
  for (const auto& [name, value] : values)
    text += (text.empty() ? "" : ", ") + std::string(name) + " = " + std::to_string(value);
  return text;
}

inline void within(const char* name, int64_t value, int64_t low, int64_t high) {
  if (value < low || value > high)
    refuse(name, std::to_string(low) + " to " + std::to_string(high), std::to_string(value));
}

// A dense tensor among the arguments, `name` ("kernel: argument") in errors, of an element type and with
// these sizes; with `leading`, more may stand before them.
class Argument {
 public:
  Argument(const char* name, AtenTensorHandle handle, int32_t dtype, std::initializer_list<int64_t> shape,
           bool leading)
      : count_(shape.size()),
        tensor_(artifact::dense(checked(name, *handle, dtype, shape, leading), owner_)) {}

  template <class T>
  const T* data() const {
    return reinterpret_cast<const T*>(tensor_.data());
  }
  int32_t dtype() const { return tensor_.dtype; }
  int64_t numel() const { return tensor_.numel(); }
  // The i-th size from the end.
  int64_t trailing(size_t i) const { return tensor_.sizes[tensor_.sizes.size() - i]; }
  // How many of what the shape names there are.
  int64_t leading() const {
    const auto first = tensor_.sizes.begin(),
               last = tensor_.sizes.end() - static_cast<std::ptrdiff_t>(count_);
    if (std::find(first, last, 0) != last) return 0;
    int64_t product = 1;
    for (auto size = first; size != last; ++size) product *= *size;
    return product;
  }
  // Sizes with this tensor's leading ones before them.
  artifact::Dims with_leading(std::initializer_list<int64_t> sizes) const {
    artifact::Dims all(tensor_.sizes.begin(), tensor_.sizes.end() - static_cast<std::ptrdiff_t>(count_));
    all.insert(all.end(), sizes);
    return all;
  }
  std::string shape_text() const { return text(tensor_.sizes.data(), tensor_.sizes.size()); }

 private:
  static std::string text(const int64_t* sizes, size_t count, bool leading = false) {
    std::string text = leading ? "(..." : "(";
    for (size_t i = 0; i < count; ++i)
      text += (i || leading ? ", " : "") + (sizes[i] == kAny ? std::string("any") : std::to_string(sizes[i]));
    return text + ")";
  }

  static const AtenTensorOpaque& checked(const char* name, const AtenTensorOpaque& tensor, int32_t dtype,
                                         std::initializer_list<int64_t> shape, bool leading) {
    using namespace artifact;
    const auto one_of = [&](std::initializer_list<int32_t> types) {
      return std::find(types.begin(), types.end(), tensor.dtype) != types.end();
    };
    const bool fits = dtype == kT   ? one_of({kFloat, kDouble})
                      : dtype == kI ? one_of({kUint8, kInt32})
                      : dtype == kU ? one_of({kUint8, kUint16})
                      : dtype == kP ? one_of({kUint8, kInt16, kUint16, kFloat, kDouble})
                                    : tensor.dtype == dtype;
    if (!fits) {
      const std::string expected = dtype == kT   ? "float32 or float64"
                                   : dtype == kI ? "uint8 or int32"
                                   : dtype == kU ? "uint8 or uint16"
                                   : dtype == kP ? "uint8, int16, uint16, float32 or float64"
                                                 : "element type " + std::to_string(dtype);
      refuse(name, expected, "element type " + std::to_string(tensor.dtype));
    }
    const Dims& sizes = tensor.sizes;
    const bool counts = leading ? sizes.size() >= shape.size() : sizes.size() == shape.size();
    if (!counts ||
        !std::equal(shape.begin(), shape.end(), sizes.end() - static_cast<std::ptrdiff_t>(shape.size()),
                    [](int64_t want, int64_t is) { return want == kAny || want == is; }))
      refuse(name, "shape " + text(shape.begin(), shape.size(), leading), text(sizes.data(), sizes.size()));
    return tensor;
  }

  const size_t count_;
  std::unique_ptr<AtenTensorOpaque> owner_;
  const AtenTensorOpaque& tensor_;
};

using Result = std::unique_ptr<AtenTensorOpaque>;

inline Result make(const artifact::Dims& sizes, int32_t dtype) {
  return Result(artifact::allocate(sizes, artifact::dense_strides(sizes), dtype));
}

template <class T>
T* data(Result& tensor) {
  return reinterpret_cast<T*>(tensor->data());
}

template <class T>
constexpr int32_t kCode = -1;
template <>
inline constexpr int32_t kCode<uint8_t> = artifact::kUint8;
template <>
inline constexpr int32_t kCode<int16_t> = artifact::kInt16;
template <>
inline constexpr int32_t kCode<uint16_t> = artifact::kUint16;
template <>
inline constexpr int32_t kCode<int32_t> = artifact::kInt32;
template <>
inline constexpr int32_t kCode<float> = artifact::kFloat;
template <>
inline constexpr int32_t kCode<double> = artifact::kDouble;

// Calls body(T{}) with the one of the types that `dtype` is.
template <class... Types, class Body>
void for_type(int32_t dtype, const Body& body) {
  (void)((dtype == kCode<Types> && (body(Types{}), true)) || ...);
}

}  // namespace chiasm::kernels
