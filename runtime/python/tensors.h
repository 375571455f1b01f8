/** Python's arrays as chiasm tensors and back, without copies. */
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "error.h"

namespace chiasm::python {

namespace py = pybind11;

/** The dtype's name in a manifest, "float32". */
const char* dtype_name(int32_t dtype);
/** Throws Error if there is no dtype of that name. */
int32_t dtype_from_name(const std::string& name);

/** A text of the core, which may quote bytes of a file that are not UTF-8. */
py::str decoded(const std::string& text);
/** A Python text in UTF-8; what cannot be encoded is escaped. */
std::string text_of(py::handle text);
/** An object that was not expected, in a few words: "5 (int)". Runs no code of its class. */
std::string described(py::handle object);

/** The library whose arrays a run returns. */
enum class Library { numpy, torch, dlpack };

/** The inputs, or the caller's outputs, of one run: views of memory that Python objects own, kept alive with
 *  them. */
class Arguments {
 public:
  enum class Role { input, output };

  Arguments(Role role, size_t count);
  Arguments(const Arguments&) = delete;
  Arguments& operator=(const Arguments&) = delete;

  /** A NumPy array, a torch tensor, anything with `__dlpack__` or the buffer protocol; for an input also a
   *  Python number, which becomes a 0-d tensor. */
  void add(py::handle object, const chiasm_tensor_info& info);

  const std::vector<chiasm_tensor>& views() const { return views_; }
  bool has_torch() const { return has_torch_; }
  /** The CUDA device of the tensors, or -1. */
  int32_t cuda_device() const { return cuda_device_; }

 private:
  struct Storage {
    std::array<int64_t, CHIASM_MAX_DIMS> shape, strides;
  };

  /** A Python number in the dtype of `info`, which must hold it: no part of an integer is left out. */
  py::array number(py::handle object, const chiasm_tensor_info& info) const;
  void add_array(py::array array, const chiasm_tensor_info& info);
  void add_dlpack(py::object capsule, const chiasm_tensor_info& info);
  /** The result of `make`; an exception raised by the object becomes our error, which says `what` failed. */
  template <class Make>
  py::object taken(const chiasm_tensor_info& info, const char* what, const Make& make) const;
  chiasm_tensor& append(const chiasm_tensor_info& info, int64_t ndim);
  int32_t number_dtype(const chiasm_tensor_info& info) const;
  [[noreturn]] void refuse(const chiasm_tensor_info& info, const std::string& why) const;

  Role role_;
  bool has_torch_ = false;
  int32_t cuda_device_ = -1;
  // of the first tensor for which several dtypes are accepted: all such tensors agree
  int32_t generic_dtype_ = -1;
  std::vector<chiasm_tensor> views_;
  std::vector<std::unique_ptr<Storage>> storage_;
  std::vector<py::object> owners_;
};

/** One output of a run. Its memory lives as long as anything that was made from it. */
class Output {
 public:
  using Outputs = std::shared_ptr<chiasm_outputs>;

  Output(Outputs outputs, size_t index);

  /** A capsule in the DLPack protocol; `versioned`: as version 1 of the protocol defines it. */
  py::capsule capsule(bool versioned) const;
  py::tuple device() const;
  py::tuple shape() const;
  int32_t dtype() const { return tensor_->dtype; }
  py::object to(Library library) const;

 private:
  py::object to_numpy() const;

  Outputs outputs_;
  const chiasm_tensor* tensor_;
};

}  // namespace chiasm::python
