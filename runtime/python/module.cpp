// chiasm._runtime: the runtime for Python. chiasm.runtime wraps it; nothing here imports torch.
#include <pybind11/native_enum.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/cpu.h"
#include "core/minisign.h"
#include "core/status.h"
#include "error.h"
#include "gil.h"
#include "method.h"
#include "tensors.h"

namespace chiasm::python {
namespace {

// For classes whose objects only this module makes. Without it, pybind11 would accept an object that __new__
// made without __init__, and use its uninitialised memory.
py::custom_type_setup made_here() {
  return py::custom_type_setup([](PyHeapTypeObject* type) {
    type->ht_type.tp_new = [](PyTypeObject* self, PyObject*, PyObject*) -> PyObject* {
      PyErr_Format(PyExc_TypeError, "%s: only chiasm.runtime makes its objects", self->tp_name);
      return nullptr;
    };
  });
}

std::vector<std::string> dtype_names(const TensorInfo& info) {
  std::vector<std::string> names;
  for (const DType dtype : info.dtypes) names.emplace_back(chiasm::name(dtype));
  return names;
}

std::vector<std::string> shape_texts(const TensorInfo& info) {
  std::vector<std::string> texts;
  for (const DimInfo& dim : info.dims) texts.push_back(dim.expression);
  return texts;
}

std::optional<std::pair<double, double>> value_range(const TensorInfo& info) {
  if (info.value_min == 0 && info.value_max == 0) return std::nullopt;
  return std::pair(info.value_min, info.value_max);
}

std::string joined(const std::vector<std::string>& parts, const char* between) {
  std::string text;
  for (size_t i = 0; i < parts.size(); ++i) text += (i > 0 ? between : "") + parts[i];
  return text;
}

std::optional<bool> passed(const SelfTestRow& row) {
  if (row.result == SelfTestRow::Result::NotRun) return std::nullopt;
  return row.result == SelfTestRow::Result::Passed;
}

std::vector<std::string> method_names(const Bundle& bundle) {
  std::vector<std::string> names;
  for (const MethodInfo& method : bundle.methods()) names.push_back(method.name);
  return names;
}

std::pair<std::vector<TensorInfo>, std::vector<TensorInfo>> signature(const Bundle& bundle,
                                                                      const std::string& name) {
  for (MethodInfo& method : bundle.methods()) {
    if (method.name == name) return {std::move(method.inputs), std::move(method.outputs)};
  }
  throw Error(CHIASM_NOT_FOUND, "bundle '" + bundle.info().name + "' has no method '" + name + "'");
}

std::unique_ptr<PythonMethod> load(const Bundle& bundle, const std::string& name,
                                   const LoadOptions& options) {
  const auto method = [&] {
    const WithoutGil released;
    return bundle.method(name, options);
  };
  return std::make_unique<PythonMethod>(method());
}

// The exception's class, with the attribute `code`.
py::handle error_class() {
  static const py::handle instance = [] {
    py::dict members;
    members["__doc__"] = "What the runtime could not do, in words; `code` is the kind of problem, a `Code`.";
    PyObject* type = PyErr_NewException("chiasm.runtime.ChiasmError", PyExc_RuntimeError, members.ptr());
    if (type == nullptr) throw py::error_already_set();
    return py::handle(type);
  }();
  return instance;
}

void translate(std::exception_ptr pointer) {
  try {
    std::rethrow_exception(std::move(pointer));
  } catch (const Error& error) {
    const py::object exception = py::reinterpret_borrow<py::object>(error_class())(decoded(error.what()));
    exception.attr("code") = py::cast(error.code());
    PyErr_SetObject(error_class().ptr(), exception.ptr());
  }
}

constexpr const char* kPolicies[] = {"any", "signed", "data_only"};

void set_trust(const std::string& policy, const std::vector<std::string>& keys) {
  const auto found = std::find(std::begin(kPolicies), std::end(kPolicies), policy);
  if (found == std::end(kPolicies)) {
    throw Error(CHIASM_INVALID_ARGUMENT,
                "policy: expected 'any', 'signed' or 'data_only', got '" + policy + "'");
  }
  chiasm::set_trust(static_cast<TrustPolicy>(found - std::begin(kPolicies)), keys);
}

std::string policy_name() { return kPolicies[static_cast<int32_t>(chiasm::get_trust())]; }

/** The names of the element types. */
std::vector<std::string> dtypes() {
  std::vector<std::string> names;
  for (const base::DTypeEntry& entry : base::kDTypes) names.emplace_back(entry.name);
  return names;
}

/** The instruction sets whose artifacts this CPU runs, the fastest first. */
std::vector<std::string> instruction_sets() {
  std::vector<std::string> found;
  for (const core::Isa isa : core::supported_isas()) found.insert(found.begin(), core::isa_name(isa));
  return found;
}

// For chiasm.export, which signs bundles; a program that runs bundles only has set_trust.
py::bytes sign(const std::string& message, const std::string& secret_key) {
  std::array<unsigned char, 64> key;
  if (secret_key.size() != key.size()) throw Error(CHIASM_INVALID_ARGUMENT, "secret_key: expected 64 bytes");
  std::copy(secret_key.begin(), secret_key.end(), key.begin());
  const auto signature = core::sign(message, key);
  return {reinterpret_cast<const char*>(signature.data()), signature.size()};
}

py::bytes verify_signature(const std::string& message, const std::string& signature, const std::string& key,
                           const std::string& origin, const std::string& key_origin) {
  try {
    return core::verify_signature(message, signature, {core::read_public_key(key, key_origin)}, origin);
  } catch (const core::Error& error) {
    throw Error(error.code(), error.what());
  }
}

// Whether the consumer's greatest version of DLPack is at least 1.
bool is_versioned(const py::object& max_version) {
  if (max_version.is_none()) return false;
  if (py::isinstance<py::tuple>(max_version) && py::len(max_version) == 2) {
    const py::object major = max_version[py::int_(0)];
    if (py::isinstance<py::int_>(major)) return major >= py::int_(1);
  }
  throw py::type_error("max_version: expected a tuple (major, minor), got " + described(max_version));
}

py::object dlpack(const Output& output, const py::object&, const py::object& max_version,
                  const py::object& device, const py::object& copy) {
  if (!device.is_none() && !device.equal(output.device()))
    throw py::buffer_error("this output cannot be exported to another device");
  if (!copy.is_none() && !copy.is(py::bool_(false)))
    throw py::buffer_error("this output is exported without a copy only");
  return output.capsule(is_versioned(max_version));
}

}  // namespace
}  // namespace chiasm::python

PYBIND11_MODULE(_runtime, m, pybind11::multiple_interpreters::not_supported()) {
  using namespace chiasm;
  using namespace chiasm::python;
  using py::arg;
  m.doc() = "The runtime of chiasm. Use chiasm.runtime.";

  py::native_enum<chiasm_code>(m, "Code", "enum.IntEnum", "The kinds of problem; `ChiasmError.code` is one.")
      .value("OK", CHIASM_OK)
      .value("INVALID_ARGUMENT", CHIASM_INVALID_ARGUMENT)
      .value("FAILED_PRECONDITION", CHIASM_FAILED_PRECONDITION)
      .value("NOT_FOUND", CHIASM_NOT_FOUND)
      .value("CORRUPT", CHIASM_CORRUPT)
      .value("VERSION_MISMATCH", CHIASM_VERSION_MISMATCH)
      .value("UNTRUSTED", CHIASM_UNTRUSTED)
      .value("UNAVAILABLE", CHIASM_UNAVAILABLE)
      .value("OUT_OF_MEMORY", CHIASM_OUT_OF_MEMORY)
      .value("IO_ERROR", CHIASM_IO_ERROR)
      .value("INTERNAL", CHIASM_INTERNAL)
      .finalize();
  m.attr("Code").attr("__module__") = "chiasm.runtime";
  m.attr("ChiasmError") = error_class();
  py::register_local_exception_translator(translate);

  py::class_<TensorInfo>(m, "TensorInfo", made_here(), "One input or output in a method's signature.")
      .def_readonly("name", &TensorInfo::name)
      .def_readonly("description", &TensorInfo::description)
      .def_readonly("layout", &TensorInfo::layout, "'NCHW', 'HWC', ... or ''")
      .def_readonly("color", &TensorInfo::color, "'RGB', 'BGR', 'GRAY', 'HSV' or ''")
      .def_property_readonly("dtypes", dtype_names, "The dtypes accepted, by name.")
      .def_property_readonly("shape", shape_texts, "One expression for each dimension: '3', 'H', '2*H'.")
      .def_property_readonly("range", value_range, "Nominal (min, max) of the values, or None.")
      .def("__repr__", [](const TensorInfo& info) {
        return "<" + info.name + ": " + joined(dtype_names(info), "|") + "[" +
               joined(shape_texts(info), ", ") + "]>";
      });

  py::class_<Output>(m, "Output", made_here(), "An output of a run, for any library that speaks DLPack.")
      .def("__dlpack__", dlpack, py::kw_only(), arg("stream") = py::none(), arg("max_version") = py::none(),
           arg("dl_device") = py::none(), arg("copy") = py::none(),
           "A DLPack capsule over the output's memory. On CUDA, use it on the stream that the method ran on.")
      .def("__dlpack_device__", &Output::device)
      .def_property_readonly("shape", &Output::shape)
      .def_property_readonly("dtype", [](const Output& output) { return dtype_name(output.dtype()); });

  py::class_<PythonMethod>(m, "Method", made_here(),
                           R"(An entry point of a bundle, loaded on one backend: call it with arrays.

Inputs are NumPy arrays, torch tensors, or anything else with ``__dlpack__`` or the buffer protocol, and are
read where they are. On the CPU rows and elements may have gaps between them, on CUDA they may not. Python
numbers stand for 0-d inputs. Outputs are torch tensors if any input was one, else NumPy arrays; one output is
returned as itself, several as a tuple. The GIL is released while the method runs, and one method may run in
many threads at once.)")
      .def_property_readonly("name", &PythonMethod::name)
      .def_property_readonly("backend", &PythonMethod::backend,
                             "'native', 'torch', 'onnx', or the name of another plug-in")
      .def_property_readonly("artifact", &PythonMethod::artifact, "The file's name inside the bundle.")
      .def_property_readonly("inputs", &PythonMethod::inputs)
      .def_property_readonly("outputs", &PythonMethod::outputs)
      .def("__call__", &PythonMethod::call, "Run on inputs given by position or by name.")
      .def("run", &PythonMethod::run, arg("inputs"), py::kw_only(), arg("returns") = py::none(),
           arg("stream") = py::none(),
           R"(Run on a sequence of inputs, or a dict of them by name, or the only input itself.

Parameters
----------
returns : {"numpy", "torch", "dlpack"}, optional
    What the outputs are; by default as the inputs. "dlpack" gives objects with ``__dlpack__``. On CUDA they
    are torch tensors; for others, allocate them and call `run_into`.
stream : int or torch.cuda.Stream, optional
    On CUDA, the stream to enqueue on: the call returns when the work is enqueued. By default torch's current
    stream for torch tensors, else the default stream.)")
      .def(
          "run_into", &PythonMethod::run_into, arg("inputs"), arg("outputs"), py::kw_only(),
          arg("stream") = py::none(),
          R"(Run into arrays of the caller, each given as in `run`. They must be writable, on CUDA dense, have
the shapes and dtypes of `output_shapes`, and overlap neither the inputs nor each other.)")
      .def("run_each", &PythonMethod::run_each, arg("inputs"), arg("outputs"), py::kw_only(),
           arg("stream") = py::none(),
           R"(Several runs in one call, several at once: item i of `inputs` and of `outputs` is what
`run_into` takes for run i. Images may differ in their sizes, and become one batch where the outputs are its
parts. Load the method with ``num_threads=1``, and each core takes runs of its own. If some fail, the others
are finished, and the first error is raised, with the run's number.)")
      .def("output_shapes", &PythonMethod::output_shapes,
           "A (shape, dtype) for each output that these inputs would give.")
      .def("__repr__", &PythonMethod::repr);

  py::class_<SelfTestRow>(m, "SelfTestRow", made_here(), "A golden case replayed on one backend.")
      .def_readonly("method", &SelfTestRow::method)
      .def_readonly("backend", &SelfTestRow::backend)
      .def_readonly("artifact", &SelfTestRow::artifact)
      .def_readonly("dtype", &SelfTestRow::dtype)
      .def_property_readonly("passed", passed,
                             "True, False, or None where it was not run: `message` says why.")
      .def_readonly("max_error", &SelfTestRow::max_error)
      .def_readonly("tolerance", &SelfTestRow::tolerance)
      .def_property_readonly("message", [](const SelfTestRow& row) { return decoded(row.message); })
      .def("__repr__", [](const SelfTestRow& row) {
        const std::optional<bool> ok = passed(row);
        const char* state = !ok ? "not run" : *ok ? "passed" : "FAILED";
        return decoded("<" + row.method + " " + row.dtype + " on " + row.backend + ": " + state +
                       (row.message.empty() ? "" : ", " + row.message) + ">");
      });

  py::class_<LoadOptions>(m, "LoadOptions", made_here(),
                          "How to load a method; the members are those of chiasm.hpp.")
      .def_static("make", [] { return LoadOptions(); })
      .def_readwrite("backend", &LoadOptions::backend)
      .def_readwrite("allow_native_code", &LoadOptions::allow_native_code)
      .def_readwrite("fused", &LoadOptions::fused)
      .def_readwrite("warm_up", &LoadOptions::warm_up)
      .def_readwrite("num_threads", &LoadOptions::num_threads)
      .def(
          "with_option",
          [](LoadOptions& self, const std::string& key, const std::string& value) {
            self.with_option(key, value);
          },
          arg("key"), arg("value"))
      .def(
          "with_device",
          [](LoadOptions& self, int32_t type, int32_t index) {
            self.device = {static_cast<chiasm_device_type>(type), index};
          },
          arg("type"), arg("index"))
      .def(
          "with_dtype",
          [](LoadOptions& self, const std::string& name) { self.dtype = dtype_from_name(name); },
          arg("name"));

  const py::call_guard<WithoutGil> without_gil;
  py::class_<Bundle>(m, "Bundle", made_here())
      .def_static("open", &Bundle::open, arg("path"), without_gil)
      .def_property_readonly("name", [](const Bundle& bundle) { return bundle.info().name; })
      .def_property_readonly("version", [](const Bundle& bundle) { return bundle.info().version; })
      .def_property_readonly("summary", [](const Bundle& bundle) { return bundle.info().summary; })
      .def_property_readonly("path", [](const Bundle& bundle) { return bundle.info().path; })
      .def_property_readonly("manifest", [](const Bundle& bundle) { return bundle.info().manifest; })
      .def_property_readonly("methods", method_names)
      .def("signature", signature, arg("name"))
      .def("method", load, arg("name"), arg("options"))
      .def("self_test", &Bundle::self_test, arg("options"), without_gil);

  py::class_<BackendInfo>(m, "BackendInfo", made_here(),
                          "Whether a backend can be used in this process, and if not, why and what to do.")
      .def_readonly("name", &BackendInfo::name)
      .def_readonly("available", &BackendInfo::available)
      .def_readonly("has_cuda", &BackendInfo::has_cuda)
      .def_readonly("engine_version", &BackendInfo::engine_version)
      .def_property_readonly("problem", [](const BackendInfo& info) { return decoded(info.problem); })
      .def("__repr__", [](const BackendInfo& info) {
        return decoded("<" + info.name + ": " + (info.available ? info.engine_version : info.problem) + ">");
      });

  m.def(
      "backends", [] { return chiasm::backends(); }, without_gil);
  m.def("library_version", &chiasm::library_version);
  m.def("set_num_threads", &chiasm::set_num_threads, arg("count"));
  m.def("get_num_threads", &chiasm::get_num_threads);
  m.def("set_trust", &chiasm::python::set_trust, arg("policy"), arg("keys"));
  m.def("get_trust", &policy_name);
  m.def("dtypes", &dtypes);
  m.def("instruction_sets", &instruction_sets);
  m.def("sign", &sign, arg("message"), arg("secret_key"));
  m.def("verify_signature", &verify_signature, arg("message"), arg("signature"), arg("key"), arg("origin"),
        arg("key_origin"));
}
