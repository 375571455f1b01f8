// The arguments of a kernel's operator, checked: what the loops assume of shapes, element types and numbers holds, or the call fails with one sentence.
#pragma once

#include <algorithm>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>

#include "tensor.h"
#include "../kernels/kernels.h"

namespace chiasm::kernels {

constexpr int64_t kAny = -1;         // of a size in an expected shape
constexpr int32_t kFloating = -1;    // of element types: float32 or float64
constexpr int64_t kMostIndex = std::numeric_limits<int32_t>::max();  // kernels number pixels and bins by 32 bits

[[noreturn]] inline void refuse(const char* name, const std::string& expected, const std::string& got) {
  throw std::runtime_error(std::string(name) + ": expected " + expected + ", got " + got + "; the compiled op and its inputs do not belong together: export the op again");
}

inline std::string to_text(const int64_t* sizes, size_t count) {
  std::string text = "(";
  for (size_t i = 0; i < count; ++i) text += (i ? ", " : "") + (sizes[i] == kAny ? std::string("any") : std::to_string(sizes[i]));
  return text + ")";
}

// `value`, where it is one of low .. high.
inline int64_t within(const char* name, int64_t value, int64_t low, int64_t high) {
  if (value < low || value > high) refuse(name, std::to_string(low) + " to " + std::to_string(high), std::to_string(value));
  return value;
}

// An enumerator by its number, of `count`.
template <class Enum>
Enum choice(const char* name, int64_t value, int64_t count) {
  return Enum(within(name, value, 0, count - 1));
}

inline Border border_of(int64_t border) { return choice<Border>("border", border, 4); }

// A dense tensor among the arguments, `name` ("operator: argument") in errors.
class Argument {
 public:
  // Of any shape.
  Argument(const char* name, AtenTensorHandle handle, int32_t dtype) : name_(name), tensor_(artifact::dense(typed(name, *handle, dtype), owner_)) {}
  // Of a shape with these sizes.
  Argument(const char* name, AtenTensorHandle handle, int32_t dtype, std::initializer_list<int64_t> shape)
      : name_(name), tensor_(artifact::dense(shaped(name, typed(name, *handle, dtype), shape), owner_)) {}

  template <class T>
  const T* data() const { return reinterpret_cast<const T*>(tensor_.data()); }
  const artifact::Dims& sizes() const { return tensor_.sizes; }
  int32_t dtype() const { return tensor_.dtype; }
  int64_t numel() const { return tensor_.numel(); }
  int64_t size(size_t i) const { return tensor_.sizes[i]; }
  const char* name() const { return name_; }

  // The planes of (..., H, W), which have a pixel or more, and no more than `most`.
  Planes planes(int64_t most = std::numeric_limits<int64_t>::max()) const {
    const artifact::Dims& sizes = tensor_.sizes;
    const size_t n = sizes.size();
    if (n < 2) refuse(name_, "two dimensions or more", to_text(sizes.data(), n));
    Planes planes{1, sizes[n - 2], sizes[n - 1]};
    if (std::min(planes.height, planes.width) < 1 || std::max(planes.height, planes.width) > kMostIndex || planes.height * planes.width > most)
      refuse(name_, "an image of 1 to " + std::to_string(std::min(most, kMostIndex)) + " pixels", std::to_string(planes.height) + " x " + std::to_string(planes.width));
    for (size_t i = 0; i + 2 < n; ++i) planes.count *= sizes[i];
    return planes;
  }

 private:
  static const AtenTensorOpaque& typed(const char* name, const AtenTensorOpaque& tensor, int32_t dtype) {
    if (dtype == kFloating ? tensor.dtype != artifact::kFloat && tensor.dtype != artifact::kDouble : tensor.dtype != dtype)
      refuse(name, dtype == kFloating ? "float32 or float64" : "element type " + std::to_string(dtype), "element type " + std::to_string(tensor.dtype));
    return tensor;
  }

  static const AtenTensorOpaque& shaped(const char* name, const AtenTensorOpaque& tensor, std::initializer_list<int64_t> shape) {
    const artifact::Dims& sizes = tensor.sizes;
    if (sizes.size() != shape.size() || !std::equal(shape.begin(), shape.end(), sizes.begin(), [](int64_t want, int64_t is) { return want == kAny || want == is; }))
      refuse(name, "shape " + to_text(shape.begin(), shape.size()), to_text(sizes.data(), sizes.size()));
    return tensor;
  }

  const char* const name_;
  std::unique_ptr<AtenTensorOpaque> owner_;
  const AtenTensorOpaque& tensor_;
};

// How many rows there are of what is there once for all of `count` images or for each of them.
inline bool is_shared(const Argument& argument, int64_t count) {
  if (argument.size(0) != 1 && argument.size(0) != count) refuse(argument.name(), "1 or " + std::to_string(count) + " rows", std::to_string(argument.size(0)));
  return argument.size(0) == 1;
}

// The size of a window along an axis, which has a middle.
inline int64_t odd_size(const Argument& argument, size_t axis) {
  const int64_t size = argument.size(axis);
  if (size < 1 || size % 2 == 0) refuse(argument.name(), "an odd number of weights", std::to_string(size));
  return size;
}

// The numbers of an argument of int64, each of which must be one of low .. high.
inline const int64_t* indices(const Argument& argument, int64_t low, int64_t high) {
  const int64_t* const data = argument.data<int64_t>();
  for (int64_t i = 0; i < argument.numel(); ++i) within(argument.name(), data[i], low, high);
  return data;
}

}  // namespace chiasm::kernels
