/** A loaded method for Python: it takes arrays, and returns arrays. */
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "error.h"
#include "tensors.h"

namespace chiasm::python {

/** One side of a method's signature. */
struct Signature {
  const char* kind;
  const chiasm_tensor_info* tensors;
  size_t count;

  std::string names() const;
};

class PythonMethod {
 public:
  explicit PythonMethod(Method method);

  std::string name() const { return info_.name; }
  std::string backend() const { return method_.backend(); }
  std::string artifact() const { return method_.artifact(); }
  std::vector<TensorInfo> inputs() const { return method_.info().inputs; }
  std::vector<TensorInfo> outputs() const { return method_.info().outputs; }

  py::object call(const py::args& inputs, const py::kwargs& named) const;
  py::object run(const py::object& inputs, const py::object& returns, const py::object& stream) const;
  void run_into(const py::object& inputs, const py::object& outputs, const py::object& stream) const;
  void run_each(const py::object& inputs, const py::object& outputs, const py::object& stream) const;
  std::vector<std::pair<py::tuple, std::string>> output_shapes(const py::args& inputs,
                                                               const py::kwargs& named) const;
  std::string repr() const;

 private:
  /** Positions first, then names; every tensor exactly once. */
  void collect(Arguments& arguments, const Signature& signature, const py::sequence& given,
               const py::dict& named) const;
  /** A sequence in the method's order, a mapping by name, or the only tensor itself. */
  void collect(Arguments& arguments, const Signature& signature, const py::object& given) const;
  std::vector<std::pair<py::tuple, std::string>> shapes_for(const Arguments& arguments) const;
  py::object run_collected(const Arguments& arguments, const py::object& returns,
                           const py::object& stream) const;
  void run_into_collected(const Arguments& in, const py::object& outputs, void* where) const;
  py::object run_on_cuda(const Arguments& arguments, const py::object& stream) const;

  Method method_;
  const chiasm_method_info& info_;  // the handle's
  Signature inputs_, outputs_;
};

}  // namespace chiasm::python
