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

#include "core/minisign.h"
#include "core/status.h"
#include "error.h"
#include "tensors.h"

namespace chiasm::python {
namespace {

struct CloseBundle {
  void operator()(chiasm_bundle* bundle) const { api().bundle_close(bundle); }
};

struct CloseMethod {
  void operator()(chiasm_method* method) const { api().method_close(method); }
};

Library library_from_name(const std::string& name) {
  if (name == "numpy") return Library::numpy;
  if (name == "torch") return Library::torch;
  if (name == "dlpack") return Library::dlpack;
  throw Error(CHIASM_INVALID_ARGUMENT, "returns: expected 'numpy', 'torch' or 'dlpack', got '" + name + "'");
}

// A cudaStream_t from an int, or from what has one: torch.cuda.Stream, or the protocol `__cuda_stream__`. None stands for
// torch's current stream where tensors are torch's, and for the default stream elsewhere.
void* stream_from(const py::object& stream, const Arguments& arguments) {
  py::object number = stream;
  if (stream.is_none()) {
    if (arguments.cuda_device() < 0 || !arguments.has_torch()) return nullptr;
    number = py::module_::import("torch.cuda").attr("current_stream")(arguments.cuda_device()).attr("cuda_stream");
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

struct TensorInfo {
  explicit TensorInfo(const chiasm_tensor_info& info)
      : name(info.name), description(info.description), layout(info.layout), color(info.color) {
    for (int32_t i = 0; i < info.dtype_count; ++i) dtypes.emplace_back(dtype_name(info.dtypes[i]));
    for (int32_t i = 0; i < info.ndim; ++i) shape.emplace_back(info.dims[i].expression);
    if (info.value_min != 0 || info.value_max != 0) range.emplace(info.value_min, info.value_max);
  }

  std::string repr() const {
    std::string text = name + ": ";
    for (size_t i = 0; i < dtypes.size(); ++i) text += (i > 0 ? "|" : "") + dtypes[i];
    text += "[";
    for (size_t i = 0; i < shape.size(); ++i) text += (i > 0 ? ", " : "") + shape[i];
    return "<" + text + "]>";
  }

  std::string name, description, layout, color;
  std::vector<std::string> dtypes, shape;
  std::optional<std::pair<double, double>> range;
};

std::vector<TensorInfo> describe(const Signature& signature) {
  std::vector<TensorInfo> result;
  for (size_t i = 0; i < signature.count; ++i) result.emplace_back(signature.tensors[i]);
  return result;
}

class Method {
 public:
  explicit Method(chiasm_method* handle)
      : handle_(handle),
        info_(*api().method_get_info(handle)),
        inputs_{"input", info_.inputs, static_cast<size_t>(info_.input_count)},
        outputs_{"output", info_.outputs, static_cast<size_t>(info_.output_count)} {}

  std::string name() const { return info_.name; }
  std::string backend() const { return api().method_backend(handle_.get()); }
  std::string artifact() const { return api().method_artifact(handle_.get()); }
  std::vector<TensorInfo> inputs() const { return describe(inputs_); }
  std::vector<TensorInfo> outputs() const { return describe(outputs_); }

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
    Arguments out(Arguments::Role::output, outputs_.count);
    collect(in, inputs_, inputs);
    collect(out, outputs_, outputs);
    const chiasm_run_options options{sizeof(chiasm_run_options), stream_from(stream, in)};
    chiasm_status* status = nullptr;
    {
      const py::gil_scoped_release release;
      status = api().method_run_into(handle_.get(), in.views().data(), in.views().size(), out.views().data(),
                                     out.views().size(), &options);
    }
    check(status);
  }

  std::vector<std::pair<py::tuple, std::string>> output_shapes(const py::args& inputs, const py::kwargs& named) const {
    Arguments arguments(Arguments::Role::input, inputs_.count);
    collect(arguments, inputs_, inputs, named);
    std::vector<std::pair<py::tuple, std::string>> result;
    for (size_t k = 0; k < outputs_.count; ++k) {
      int64_t shape[CHIASM_MAX_DIMS];
      int32_t ndim = 0;
      int32_t dtype = 0;
      check(api().method_output_shape(handle_.get(), arguments.views().data(), arguments.views().size(), k, shape, &ndim, &dtype));
      py::tuple dims(ndim);
      for (int32_t i = 0; i < ndim; ++i) dims[static_cast<size_t>(i)] = py::int_(shape[i]);
      result.emplace_back(std::move(dims), dtype_name(dtype));
    }
    return result;
  }

  std::string repr() const {
    return "<chiasm method " + name() + "(" + inputs_.names() + ") -> " + outputs_.names() + ", " + backend() + ": " +
           artifact() + ">";
  }

 private:
  // Positions first, then names; every tensor exactly once.
  void collect(Arguments& arguments, const Signature& signature, const py::sequence& given, const py::dict& named) const {
    const auto fail = [&](const std::string& what) {
      return py::type_error("method '" + name() + "' " + what + " (its " + signature.kind + "s are " + signature.names() + ")");
    };
    const size_t given_count = given.size();
    if (given_count > signature.count)
      throw fail("takes " + std::to_string(signature.count) + " " + signature.kind + "s, got " + std::to_string(given_count));
    for (size_t i = 0; i < signature.count; ++i) {
      const char* tensor = signature.tensors[i].name;
      const bool is_named = !named.empty() && named.contains(tensor);
      if (i < given_count && is_named) throw fail(std::string("got '") + tensor + "' by position and by name");
      if (i >= given_count && !is_named) throw fail(std::string("needs '") + tensor + "', which is missing");
      arguments.add(i < given_count ? py::object(given[i]) : py::object(named[tensor]), signature.tensors[i]);
    }
    if (given_count + named.size() == signature.count) return;
    for (const auto& item : named) {
      const auto key = item.first.cast<std::string>();
      bool known = false;
      for (size_t i = 0; i < signature.count; ++i) known = known || key == signature.tensors[i].name;
      if (!known) throw fail(std::string("has no ") + signature.kind + " '" + key + "'");
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

  py::object run_collected(const Arguments& arguments, const py::object& returns, const py::object& stream) const {
    Library library = arguments.has_torch() ? Library::torch : Library::numpy;
    if (!returns.is_none()) library = library_from_name(returns.cast<std::string>());
    const chiasm_run_options options{sizeof(chiasm_run_options), stream_from(stream, arguments)};
    chiasm_outputs* raw = nullptr;
    chiasm_status* status = nullptr;
    {
      const py::gil_scoped_release release;
      status = api().method_run(handle_.get(), arguments.views().data(), arguments.views().size(), &options, &raw);
    }
    check(status);
    const Output::Outputs outputs(raw, [](chiasm_outputs* p) { api().outputs_free(p); });
    if (outputs_.count == 1) return Output(outputs, 0).to(library);
    py::tuple result(outputs_.count);
    for (size_t k = 0; k < outputs_.count; ++k) result[k] = Output(outputs, k).to(library);
    return result;
  }

  std::unique_ptr<chiasm_method, CloseMethod> handle_;
  const chiasm_method_info& info_;  // the handle's
  Signature inputs_, outputs_;
};

chiasm_load_options load_options(const std::string& backend, int32_t device_type, int32_t device_index, bool allow_native_code) {
  chiasm_load_options options = CHIASM_LOAD_OPTIONS_INIT;
  options.backend = backend.c_str();
  options.device_type = device_type;
  options.device_index = device_index;
  options.allow_native_code = allow_native_code ? 1 : 0;
  return options;
}

struct Row {
  std::string method, backend, artifact, dtype;
  std::optional<bool> passed;
  double max_error, tolerance;
  std::string message;
};

class Bundle {
 public:
  explicit Bundle(const std::string& path) {
    chiasm_bundle* raw = nullptr;
    chiasm_status* status = nullptr;
    {
      const py::gil_scoped_release release;
      status = api().bundle_open(path.c_str(), &raw);
    }
    check(status);
    handle_.reset(raw);
  }

  const chiasm_bundle_info& info() const { return *api().bundle_get_info(handle_.get()); }

  std::vector<std::string> methods() const {
    std::vector<std::string> result;
    for (int32_t i = 0; i < info().method_count; ++i) result.emplace_back(info().methods[i].name);
    return result;
  }

  std::pair<std::vector<TensorInfo>, std::vector<TensorInfo>> signature(const std::string& name) const {
    for (int32_t i = 0; i < info().method_count; ++i) {
      const chiasm_method_info& method = info().methods[i];
      if (name != method.name) continue;
      return {describe({"input", method.inputs, static_cast<size_t>(method.input_count)}),
              describe({"output", method.outputs, static_cast<size_t>(method.output_count)})};
    }
    throw Error(CHIASM_NOT_FOUND, "bundle '" + std::string(info().name) + "' has no method '" + name + "'");
  }

  std::unique_ptr<Method> load(const std::string& name, const std::string& backend, int32_t device_type, int32_t device_index,
                               const std::optional<std::string>& dtype, bool allow_native_code, bool fused, bool warm_up) const {
    chiasm_load_options options = load_options(backend, device_type, device_index, allow_native_code);
    if (dtype) options.dtype = dtype_from_name(*dtype);
    options.fused = fused ? 1 : 0;
    options.warm_up = warm_up ? 1 : 0;
    chiasm_method* raw = nullptr;
    chiasm_status* status = nullptr;
    {
      const py::gil_scoped_release release;
      status = api().method_load(handle_.get(), name.c_str(), &options, &raw);
    }
    check(status);
    return std::make_unique<Method>(raw);
  }

  std::vector<Row> self_test(const std::string& backend, int32_t device_type, int32_t device_index, bool allow_native_code) const {
    const chiasm_load_options options = load_options(backend, device_type, device_index, allow_native_code);
    std::vector<Row> rows;
    int32_t failed = 0;
    chiasm_status* status = nullptr;
    {
      const py::gil_scoped_release release;
      const auto collect = [](const chiasm_self_test_row* row, void* user) {
        std::optional<bool> passed;
        if (row->passed >= 0) passed = row->passed == 1;
        static_cast<std::vector<Row>*>(user)->push_back(
            {row->method, row->backend, row->artifact, row->dtype, passed, row->max_error, row->tolerance, row->message});
      };
      status = api().bundle_self_test(handle_.get(), &options, collect, &rows, &failed);
    }
    check(status);
    return rows;
  }

 private:
  std::unique_ptr<chiasm_bundle, CloseBundle> handle_;
};

std::vector<py::tuple> backends() {
  std::vector<py::tuple> result;
  for (size_t i = 0; i < api().backend_count(); ++i) {
    chiasm_backend_info info{};
    info.struct_size = sizeof(info);
    chiasm_status* status = nullptr;
    {
      const py::gil_scoped_release release;
      status = api().backend_info(i, &info);
    }
    check(status);
    result.push_back(py::make_tuple(info.name, info.available != 0, info.has_cuda != 0, info.engine_version, info.problem));
  }
  return result;
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
    const py::object exception = py::reinterpret_borrow<py::object>(error_class())(error.what());
    exception.attr("code") = py::cast(error.code());
    PyErr_SetObject(error_class().ptr(), exception.ptr());
  }
}

constexpr const char* kPolicies[] = {"any", "signed", "data_only"};

void set_trust(const std::string& policy, const std::vector<std::string>& keys) {
  const auto found = std::find(std::begin(kPolicies), std::end(kPolicies), policy);
  if (found == std::end(kPolicies)) {
    throw Error(CHIASM_INVALID_ARGUMENT, "policy: expected 'any', 'signed' or 'data_only', got '" + policy + "'");
  }
  std::vector<const char*> texts;
  for (const std::string& key : keys) texts.push_back(key.c_str());
  check(api().set_trust(static_cast<int32_t>(found - std::begin(kPolicies)), texts.data(), texts.size()));
}

std::string get_trust() {
  int32_t policy = 0;
  check(api().get_trust(&policy, nullptr, nullptr));
  return kPolicies[policy];
}

// What chiasm.export signs with; a program that runs bundles has set_trust.
py::bytes sign(const std::string& message, const std::string& secret_key) {
  std::array<unsigned char, 64> key;
  if (secret_key.size() != key.size()) throw Error(CHIASM_INVALID_ARGUMENT, "secret_key: expected 64 bytes");
  std::copy(secret_key.begin(), secret_key.end(), key.begin());
  const auto signature = core::sign(message, key);
  return {reinterpret_cast<const char*>(signature.data()), signature.size()};
}

py::bytes verify_signature(const std::string& message, const std::string& signature, const std::string& key, const std::string& origin) {
  try {
    return core::verify_signature(message, signature, {core::read_public_key(key, "the key")}, origin);
  } catch (const core::Error& error) {
    throw Error(error.code(), error.what());
  }
}

py::object dlpack(const Output& output, const py::object&, const py::object& max_version, const py::object& device, const py::object& copy) {
  if (!device.is_none() && !device.equal(output.device())) throw py::buffer_error("this output cannot be exported to another device");
  if (!copy.is_none() && copy.cast<bool>()) throw py::buffer_error("this output is exported without a copy only");
  const bool versioned = !max_version.is_none() && max_version.cast<py::sequence>()[0].cast<int>() >= 1;
  return output.capsule(versioned);
}

}  // namespace
}  // namespace chiasm::python

PYBIND11_MODULE(_runtime, m, pybind11::multiple_interpreters::not_supported()) {
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
      .def_readonly("dtypes", &TensorInfo::dtypes, "The dtypes accepted, by name.")
      .def_readonly("shape", &TensorInfo::shape, "One expression for each dimension: '3', 'H', '2*H'.")
      .def_readonly("range", &TensorInfo::range, "Nominal (min, max) of the values, or None.")
      .def("__repr__", &TensorInfo::repr);

  py::class_<Output>(m, "Output", "An output of a run, for any library that speaks DLPack.")
      .def("__dlpack__", dlpack, py::kw_only(), arg("stream") = py::none(), arg("max_version") = py::none(),
           arg("dl_device") = py::none(), arg("copy") = py::none(),
           "A DLPack capsule over the output's memory. On CUDA, use it on the stream that the method ran on.")
      .def("__dlpack_device__", &Output::device)
      .def_property_readonly("shape", &Output::shape)
      .def_property_readonly("dtype", [](const Output& output) { return dtype_name(output.dtype()); });

  py::class_<Method>(m, "Method", R"(An entry point of a bundle, loaded on one backend: call it with arrays.

Inputs are NumPy arrays, torch tensors, or anything else with ``__dlpack__`` or the buffer protocol, and are read where
they are: they must be dense. Python numbers stand for 0-d inputs. Outputs are torch tensors if any input was one, else
NumPy arrays; one output is returned as itself, several as a tuple. The GIL is released while the method runs, and one
method may run in many threads at once.)")
      .def_property_readonly("name", &Method::name)
      .def_property_readonly("backend", &Method::backend, "'native', 'torch' or 'onnx'")
      .def_property_readonly("artifact", &Method::artifact, "The file's name inside the bundle.")
      .def_property_readonly("inputs", &Method::inputs)
      .def_property_readonly("outputs", &Method::outputs)
      .def("__call__", &Method::call, "Run on inputs given by position or by name.")
      .def("run", &Method::run, arg("inputs"), py::kw_only(), arg("returns") = py::none(), arg("stream") = py::none(),
           R"(Run on a sequence of inputs, or a dict of them by name, or the only input itself.

Parameters
----------
returns : {"numpy", "torch", "dlpack"}, optional
    What the outputs are; by default as the inputs. "dlpack" gives objects with ``__dlpack__``.
stream : int or torch.cuda.Stream, optional
    On CUDA, the stream to enqueue on: the call returns when the work is enqueued. By default torch's current stream for
    torch tensors, else the default stream.)")
      .def("run_into", &Method::run_into, arg("inputs"), arg("outputs"), py::kw_only(), arg("stream") = py::none(),
           R"(Run into arrays of the caller, each given as in `run`. They must be dense and writable, have the shapes and
dtypes of `output_shapes`, and overlap neither the inputs nor each other.)")
      .def("output_shapes", &Method::output_shapes, "A (shape, dtype) for each output that these inputs would give.")
      .def("__repr__", &Method::repr);

  py::class_<Row>(m, "SelfTestRow", "A golden case replayed on one backend.")
      .def_readonly("method", &Row::method)
      .def_readonly("backend", &Row::backend)
      .def_readonly("artifact", &Row::artifact)
      .def_readonly("dtype", &Row::dtype)
      .def_readonly("passed", &Row::passed, "True, False, or None where it was not run: `message` says why.")
      .def_readonly("max_error", &Row::max_error)
      .def_readonly("tolerance", &Row::tolerance)
      .def_readonly("message", &Row::message)
      .def("__repr__", [](const Row& row) {
        const char* state = !row.passed ? "not run" : *row.passed ? "passed" : "FAILED";
        return "<" + row.method + " " + row.dtype + " on " + row.backend + ": " + state + (row.message.empty() ? "" : ", " + row.message) + ">";
      });

  py::class_<Bundle>(m, "Bundle")
      .def(py::init<const std::string&>(), arg("path"))
      .def_property_readonly("name", [](const Bundle& bundle) { return bundle.info().name; })
      .def_property_readonly("version", [](const Bundle& bundle) { return bundle.info().version; })
      .def_property_readonly("summary", [](const Bundle& bundle) { return bundle.info().summary; })
      .def_property_readonly("path", [](const Bundle& bundle) { return bundle.info().path; })
      .def_property_readonly("manifest", [](const Bundle& bundle) { return bundle.info().manifest; })
      .def_property_readonly("methods", &Bundle::methods)
      .def("signature", &Bundle::signature, arg("name"))
      .def("load", &Bundle::load, arg("name"), arg("backend"), arg("device_type"), arg("device_index"), arg("dtype"),
           arg("allow_native_code"), arg("fused"), arg("warm_up"))
      .def("self_test", &Bundle::self_test, arg("backend"), arg("device_type"), arg("device_index"), arg("allow_native_code"));

  m.def("backends", &backends);
  m.def("library_version", [] { return api().library_version(); });
  m.def("set_num_threads", [](int32_t count) { check(api().set_num_threads(count)); }, arg("count"));
  m.def("get_num_threads", [] { return api().get_num_threads(); });
  m.def("set_trust", &set_trust, arg("policy"), arg("keys"));
  m.def("get_trust", &get_trust);
  m.def("sign", &sign, arg("message"), arg("secret_key"));
  m.def("verify_signature", &verify_signature, arg("message"), arg("signature"), arg("key"), arg("origin"));
}
