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
#include "tensors.h"

namespace chiasm::python {
namespace {

Library library_from_name(const std::string& name) {
  if (name == "numpy") return Library::numpy;
  if (name == "torch") return Library::torch;
  if (name == "dlpack") return Library::dlpack;
  throw Error(CHIASM_INVALID_ARGUMENT, "returns: expected 'numpy', 'torch' or 'dlpack', got '" + name + "'");
}

// A cudaStream_t from an int, a torch.cuda.Stream, or an object with the protocol `__cuda_stream__`. None
// means torch's current stream for torch tensors, and the default stream for others.
void* stream_from(const py::object& stream, const Arguments& arguments) {
  py::object number = stream;
  if (stream.is_none()) {
    if (arguments.cuda_device() < 0 || !arguments.has_torch()) return nullptr;
    number =
        py::module_::import("torch.cuda").attr("current_stream")(arguments.cuda_device()).attr("cuda_stream");
  } else if (py::hasattr(stream, "cuda_stream")) {
    number = stream.attr("cuda_stream");
  } else if (py::hasattr(stream, "__cuda_stream__")) {
    number = py::object(stream.attr("__cuda_stream__")().cast<py::sequence>()[1]);
  }
  return reinterpret_cast<void*>(number.cast<uintptr_t>());
}

// One side of a method's signature.
struct Signature {
  const char* kind;
  const chiasm_tensor_info* tensors;
  size_t count;

  std::string names() const {
    std::string text;
    for (size_t i = 0; i < count; ++i) text += (i > 0 ? ", '" : "'") + std::string(tensors[i].name) + "'";
    return text;
  }
};

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

class PythonMethod {
 public:
  explicit PythonMethod(Method method)
      : method_(std::move(method)),
        info_(*api().method_get_info(method_.c_handle())),
        inputs_{"input", info_.inputs, static_cast<size_t>(info_.input_count)},
        outputs_{"output", info_.outputs, static_cast<size_t>(info_.output_count)} {}

  std::string name() const { return info_.name; }
  std::string backend() const { return method_.backend(); }
  std::string artifact() const { return method_.artifact(); }
  std::vector<TensorInfo> inputs() const { return method_.info().inputs; }
  std::vector<TensorInfo> outputs() const { return method_.info().outputs; }

  py::object call(const py::args& inputs, const py::kwargs& named) const {
    Arguments arguments(Arguments::Role::input, inputs_.count);
    collect(arguments, inputs_, inputs, named);
    return run_collected(arguments, py::none(), py::none());
  }

  py::object run(const py::object& inputs, const py::object& returns, const py::object& stream) const {
    Arguments arguments(Arguments::Role::input, inputs_.count);
    collect(arguments, inputs_, inputs);
    return run_collected(arguments, returns, stream);
  }

  void run_into(const py::object& inputs, const py::object& outputs, const py::object& stream) const {
    Arguments in(Arguments::Role::input, inputs_.count);
    collect(in, inputs_, inputs);
    run_into_collected(in, outputs, stream);
  }

  void run_each(const py::sequence& inputs, const py::sequence& outputs, const py::object& stream) const {
    const size_t runs = py::len(inputs);
    if (runs != py::len(outputs))
      throw py::value_error("run_each: " + std::to_string(runs) + " sets of inputs and " +
                            std::to_string(py::len(outputs)) + " sets of outputs");
    std::vector<std::unique_ptr<Arguments>> arguments;
    std::vector<chiasm_tensor> in, out;
    void* where = nullptr;
    for (size_t run = 0; run < runs; ++run) {
      arguments.push_back(std::make_unique<Arguments>(Arguments::Role::input, inputs_.count));
      collect(*arguments.back(), inputs_, inputs[run]);
      in.insert(in.end(), arguments.back()->views().begin(), arguments.back()->views().end());
      if (run == 0) where = stream_from(stream, *arguments.back());
      arguments.push_back(std::make_unique<Arguments>(Arguments::Role::output, outputs_.count));
      collect(*arguments.back(), outputs_, outputs[run]);
      out.insert(out.end(), arguments.back()->views().begin(), arguments.back()->views().end());
    }
    const chiasm_run_options options{sizeof(chiasm_run_options), where};
    chiasm_status* status = nullptr;
    {
      const WithoutGil released;
      status = api().method_run_each(method_.c_handle(), runs, in.data(), inputs_.count, out.data(),
                                     outputs_.count, &options);
    }
    check(status);
  }

  std::vector<std::pair<py::tuple, std::string>> output_shapes(const py::args& inputs,
                                                               const py::kwargs& named) const {
    Arguments arguments(Arguments::Role::input, inputs_.count);
    collect(arguments, inputs_, inputs, named);
    return shapes_for(arguments);
  }

  std::string repr() const {
    return "<chiasm method " + name() + "(" + inputs_.names() + ") -> " + outputs_.names() + ", " +
           backend() + ": " + artifact() + ">";
  }

 private:
  // Positions first, then names; every tensor exactly once.
  void collect(Arguments& arguments, const Signature& signature, const py::sequence& given,
               const py::dict& named) const {
    const auto fail = [&](const std::string& what) {
      return py::type_error("method '" + name() + "' " + what + " (its " + signature.kind + "s are " +
                            signature.names() + ")");
    };
    const size_t given_count = given.size();
    if (given_count > signature.count)
      throw fail("takes " + std::to_string(signature.count) + " " + signature.kind + "s, got " +
                 std::to_string(given_count));
    for (size_t i = 0; i < signature.count; ++i) {
      const char* tensor = signature.tensors[i].name;
      const bool is_named = !named.empty() && named.contains(tensor);
      if (i < given_count && is_named)
        throw fail(std::string("got '") + tensor + "' by position and by name");
      if (i >= given_count && !is_named) throw fail(std::string("needs '") + tensor + "', which is missing");
      arguments.add(i < given_count ? py::object(given[i]) : py::object(named[tensor]), signature.tensors[i]);
    }
    if (given_count + named.size() == signature.count) return;
    for (const auto& item : named) {
      const auto key = py::repr(item.first).cast<std::string>();  // it may be anything
      bool known = false;
      for (size_t i = 0; i < signature.count; ++i)
        known = known || key == "'" + std::string(signature.tensors[i].name) + "'";
      if (!known) throw fail(std::string("has no ") + signature.kind + " " + key);
    }
  }

  // A sequence in the method's order, a mapping by name, or the only tensor itself.
  void collect(Arguments& arguments, const Signature& signature, const py::object& given) const {
    if (py::isinstance<py::dict>(given)) {
      collect(arguments, signature, py::tuple(), given.cast<py::dict>());
    } else if (py::isinstance<py::tuple>(given) || py::isinstance<py::list>(given)) {
      collect(arguments, signature, given.cast<py::sequence>(), py::dict());
    } else {
      collect(arguments, signature, py::make_tuple(given), py::dict());
    }
  }

  std::vector<std::pair<py::tuple, std::string>> shapes_for(const Arguments& arguments) const {
    std::vector<std::pair<py::tuple, std::string>> result;
    for (size_t k = 0; k < outputs_.count; ++k) {
      int64_t shape[CHIASM_MAX_DIMS];
      int32_t ndim = 0;
      int32_t dtype = 0;
      check(api().method_output_shape(method_.c_handle(), arguments.views().data(), arguments.views().size(),
                                      k, shape, &ndim, &dtype));
      py::tuple dims(ndim);
      for (int32_t i = 0; i < ndim; ++i) dims[static_cast<size_t>(i)] = py::int_(shape[i]);
      result.emplace_back(std::move(dims), dtype_name(dtype));
    }
    return result;
  }

  void run_into_collected(const Arguments& in, const py::object& outputs, const py::object& stream) const {
    Arguments out(Arguments::Role::output, outputs_.count);
    collect(out, outputs_, outputs);
    const chiasm_run_options options{sizeof(chiasm_run_options), stream_from(stream, in)};
    chiasm_status* status = nullptr;
    {
      const WithoutGil released;
      status = api().method_run_into(method_.c_handle(), in.views().data(), in.views().size(),
                                     out.views().data(), out.views().size(), &options);
    }
    check(status);
  }

  // torch allocates for its current stream, so record_stream tells it about another one.
  py::object run_on_cuda(const Arguments& arguments, const py::object& stream) const {
    using py::literals::operator""_a;
    const py::module_ torch = py::module_::import("torch");
    const py::object device = torch.attr("device")("cuda", arguments.cuda_device());
    py::tuple outputs(outputs_.count);
    size_t k = 0;
    for (const auto& [shape, dtype] : shapes_for(arguments)) {
      outputs[k] = torch.attr("empty")(shape, "dtype"_a = torch.attr(dtype.c_str()), "device"_a = device);
      if (!stream.is_none()) {
        const bool is_number = py::isinstance<py::int_>(stream);
        outputs[k].attr("record_stream")(is_number ? torch.attr("cuda").attr("ExternalStream")(stream)
                                                   : stream);
      }
      ++k;
    }
    run_into_collected(arguments, outputs, stream);
    return outputs_.count == 1 ? py::object(outputs[0]) : py::object(outputs);
  }

  py::object run_collected(const Arguments& arguments, const py::object& returns,
                           const py::object& stream) const {
    Library library = arguments.has_torch() ? Library::torch : Library::numpy;
    if (!returns.is_none()) library = library_from_name(returns.cast<std::string>());
    if (library == Library::torch && arguments.cuda_device() >= 0) return run_on_cuda(arguments, stream);
    const chiasm_run_options options{sizeof(chiasm_run_options), stream_from(stream, arguments)};
    chiasm_outputs* raw = nullptr;
    chiasm_status* status = nullptr;
    {
      const WithoutGil released;
      status = api().method_run(method_.c_handle(), arguments.views().data(), arguments.views().size(),
                                &options, &raw);
    }
    check(status);
    const Output::Outputs outputs(raw, [](chiasm_outputs* p) { api().outputs_free(p); });
    if (outputs_.count == 1) return Output(outputs, 0).to(library);
    py::tuple result(outputs_.count);
    for (size_t k = 0; k < outputs_.count; ++k) result[k] = Output(outputs, k).to(library);
    return result;
  }

  Method method_;
  const chiasm_method_info& info_;  // the handle's
  Signature inputs_, outputs_;
};

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

// A text of the core, which may quote bytes of a file that are no UTF-8.
py::str text_of(const std::string& text) {
  PyObject* decoded =
      PyUnicode_DecodeUTF8(text.data(), static_cast<Py_ssize_t>(text.size()), "backslashreplace");
  if (decoded == nullptr) throw py::error_already_set();
  return py::reinterpret_steal<py::str>(decoded);
}

void translate(std::exception_ptr pointer) {
  try {
    std::rethrow_exception(std::move(pointer));
  } catch (const Error& error) {
    const py::object exception = py::reinterpret_borrow<py::object>(error_class())(text_of(error.what()));
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

std::string get_trust() { return kPolicies[static_cast<int32_t>(chiasm::trust_policy())]; }

/** The names of the element types. */
std::vector<std::string> dtypes() {
  std::vector<std::string> names;
  for (const base::DTypeEntry& entry : base::kDTypes) names.emplace_back(entry.name);
  return names;
}

/** The instruction sets whose artifacts this CPU runs, the fastest first. */
std::vector<std::string> instruction_sets() {
  std::vector<std::string> found;
  for (const core::Isa isa :
       {core::Isa::x86_64_v4, core::Isa::x86_64_v3, core::Isa::x86_64_v2, core::Isa::armv8_2_a}) {
    if (core::cpu_supports(isa)) found.emplace_back(core::kIsaNames[static_cast<int>(isa)]);
  }
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

py::object dlpack(const Output& output, const py::object&, const py::object& max_version,
                  const py::object& device, const py::object& copy) {
  if (!device.is_none() && !device.equal(output.device()))
    throw py::buffer_error("this output cannot be exported to another device");
  if (!copy.is_none() && copy.cast<bool>())
    throw py::buffer_error("this output is exported without a copy only");
  const bool versioned = !max_version.is_none() && max_version.cast<py::sequence>()[0].cast<int>() >= 1;
  return output.capsule(versioned);
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

  py::class_<TensorInfo>(m, "TensorInfo", "One input or output in a method's signature.")
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

  py::class_<Output>(m, "Output", "An output of a run, for any library that speaks DLPack.")
      .def("__dlpack__", dlpack, py::kw_only(), arg("stream") = py::none(), arg("max_version") = py::none(),
           arg("dl_device") = py::none(), arg("copy") = py::none(),
           "A DLPack capsule over the output's memory. On CUDA, use it on the stream that the method ran on.")
      .def("__dlpack_device__", &Output::device)
      .def_property_readonly("shape", &Output::shape)
      .def_property_readonly("dtype", [](const Output& output) { return dtype_name(output.dtype()); });

  py::class_<PythonMethod>(m, "Method",
                           R"(An entry point of a bundle, loaded on one backend: call it with arrays.

Inputs are NumPy arrays, torch tensors, or anything else with ``__dlpack__`` or the buffer protocol, and are
read where they are: they must be dense. Python numbers stand for 0-d inputs. Outputs are torch tensors if any
input was one, else NumPy arrays; one output is returned as itself, several as a tuple. The GIL is released
while the method runs, and one method may run in many threads at once.)")
      .def_property_readonly("name", &PythonMethod::name)
      .def_property_readonly("backend", &PythonMethod::backend, "'native', 'torch' or 'onnx'")
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
      .def("run_into", &PythonMethod::run_into, arg("inputs"), arg("outputs"), py::kw_only(),
           arg("stream") = py::none(),
           R"(Run into arrays of the caller, each given as in `run`. They must be dense and writable, have the
shapes and dtypes of `output_shapes`, and overlap neither the inputs nor each other.)")
      .def(
          "run_each", &PythonMethod::run_each, arg("inputs"), arg("outputs"), py::kw_only(),
          arg("stream") = py::none(),
          R"(Several runs in one call, several at once: item i of `inputs` and of `outputs` is what `run_into` takes
for run i. Images may differ in their sizes, and become one batch where the outputs are its parts. Load the
method with ``num_threads=1``, and each core takes runs of its own. If some fail, the others are finished, and
the first error is raised, with the run's number.)")
      .def("output_shapes", &PythonMethod::output_shapes,
           "A (shape, dtype) for each output that these inputs would give.")
      .def("__repr__", &PythonMethod::repr);

  py::class_<SelfTestRow>(m, "SelfTestRow", "A golden case replayed on one backend.")
      .def_readonly("method", &SelfTestRow::method)
      .def_readonly("backend", &SelfTestRow::backend)
      .def_readonly("artifact", &SelfTestRow::artifact)
      .def_readonly("dtype", &SelfTestRow::dtype)
      .def_property_readonly("passed", passed,
                             "True, False, or None where it was not run: `message` says why.")
      .def_readonly("max_error", &SelfTestRow::max_error)
      .def_readonly("tolerance", &SelfTestRow::tolerance)
      .def_property_readonly("message", [](const SelfTestRow& row) { return text_of(row.message); })
      .def("__repr__", [](const SelfTestRow& row) {
        const std::optional<bool> ok = passed(row);
        const char* state = !ok ? "not run" : *ok ? "passed" : "FAILED";
        return text_of("<" + row.method + " " + row.dtype + " on " + row.backend + ": " + state +
                       (row.message.empty() ? "" : ", " + row.message) + ">");
      });

  py::class_<LoadOptions>(m, "LoadOptions", "How to load a method; the members are those of chiasm.hpp.")
      .def(py::init<>())
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
  py::class_<Bundle>(m, "Bundle")
      .def(py::init([](const std::string& path) { return Bundle::open(path); }), arg("path"), without_gil)
      .def_property_readonly("name", [](const Bundle& bundle) { return bundle.info().name; })
      .def_property_readonly("version", [](const Bundle& bundle) { return bundle.info().version; })
      .def_property_readonly("summary", [](const Bundle& bundle) { return bundle.info().summary; })
      .def_property_readonly("path", [](const Bundle& bundle) { return bundle.info().path; })
      .def_property_readonly("manifest", [](const Bundle& bundle) { return bundle.info().manifest; })
      .def_property_readonly("methods", method_names)
      .def("signature", signature, arg("name"))
      .def("method", load, arg("name"), arg("options"))
      .def("self_test", &Bundle::self_test, arg("options"), without_gil);

  py::class_<BackendInfo>(m, "BackendInfo",
                          "Whether a backend can be used in this process, and if not, why and what to do.")
      .def_readonly("name", &BackendInfo::name)
      .def_readonly("available", &BackendInfo::available)
      .def_readonly("has_cuda", &BackendInfo::has_cuda)
      .def_readonly("engine_version", &BackendInfo::engine_version)
      .def_readonly("problem", &BackendInfo::problem)
      .def("__repr__", [](const BackendInfo& info) {
        return "<" + info.name + ": " + (info.available ? info.engine_version : info.problem) + ">";
      });

  m.def(
      "backends", [] { return chiasm::backends(); }, without_gil);
  m.def("library_version", &chiasm::library_version);
  m.def("set_num_threads", &chiasm::set_num_threads, arg("count"));
  m.def("get_num_threads", &chiasm::get_num_threads);
  m.def("set_trust", &chiasm::python::set_trust, arg("policy"), arg("keys"));
  m.def("get_trust", &get_trust);
  m.def("dtypes", &dtypes);
  m.def("instruction_sets", &instruction_sets);
  m.def("sign", &sign, arg("message"), arg("secret_key"));
  m.def("verify_signature", &verify_signature, arg("message"), arg("signature"), arg("key"), arg("origin"),
        arg("key_origin"));
}
