#include "method.h"

#include <cstdint>
#include <memory>
#include <optional>

#include "gil.h"

namespace chiasm::python {
namespace {

// The library that `returns` names, if it names one.
std::optional<Library> library_from(const py::object& returns) {
  if (returns.is_none()) return std::nullopt;
  if (py::isinstance<py::str>(returns)) {
    const std::string name = text_of(returns);
    if (name == "numpy") return Library::numpy;
    if (name == "torch") return Library::torch;
    if (name == "dlpack") return Library::dlpack;
  }
  throw Error(CHIASM_INVALID_ARGUMENT,
              "returns: expected 'numpy', 'torch' or 'dlpack', got " + described(returns));
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
    const py::object pair = stream.attr("__cuda_stream__")();
    number = py::isinstance<py::tuple>(pair) && py::len(pair) == 2 ? py::object(pair[py::int_(1)]) : pair;
  }
  if (py::isinstance<py::int_>(number) && !py::isinstance<py::bool_>(number)) {
    const size_t value = PyLong_AsSize_t(number.ptr());
    if (PyErr_Occurred() == nullptr) return reinterpret_cast<void*>(value);
    PyErr_Clear();
  }
  throw Error(CHIASM_INVALID_ARGUMENT,
              "stream: expected a cudaStream_t as an int, a torch.cuda.Stream, or an object with "
              "__cuda_stream__, got " +
                  described(stream));
}

bool is_list(const py::object& object) {
  return py::isinstance<py::tuple>(object) || py::isinstance<py::list>(object);
}

// A list with an item for each run.
py::sequence runs_from(const py::object& items, const char* what) {
  if (!is_list(items))
    throw Error(CHIASM_INVALID_ARGUMENT, std::string(what) +
                                             ": expected a list or a tuple with an item for each run, got " +
                                             described(items));
  return items;
}

}  // namespace

std::string Signature::names() const {
  std::string text;
  for (size_t i = 0; i < count; ++i) text += (i > 0 ? ", '" : "'") + std::string(tensors[i].name) + "'";
  return text;
}

PythonMethod::PythonMethod(Method method)
    : method_(std::move(method)),
      info_(*api().method_get_info(method_.c_handle())),
      inputs_{"input", info_.inputs, static_cast<size_t>(info_.input_count)},
      outputs_{"output", info_.outputs, static_cast<size_t>(info_.output_count)} {}

py::object PythonMethod::call(const py::args& inputs, const py::kwargs& named) const {
  Arguments arguments(Arguments::Role::input, inputs_.count);
  collect(arguments, inputs_, inputs, named);
  return run_collected(arguments, py::none(), py::none());
}

py::object PythonMethod::run(const py::object& inputs, const py::object& returns,
                             const py::object& stream) const {
  Arguments arguments(Arguments::Role::input, inputs_.count);
  collect(arguments, inputs_, inputs);
  return run_collected(arguments, returns, stream);
}

void PythonMethod::run_into(const py::object& inputs, const py::object& outputs,
                            const py::object& stream) const {
  Arguments in(Arguments::Role::input, inputs_.count);
  collect(in, inputs_, inputs);
  run_into_collected(in, outputs, stream_from(stream, in));
}

void PythonMethod::run_each(const py::object& inputs, const py::object& outputs,
                            const py::object& stream) const {
  const py::sequence from = runs_from(inputs, "inputs"), to = runs_from(outputs, "outputs");
  const size_t runs = from.size();
  if (runs != to.size())
    throw py::value_error("run_each: " + std::to_string(runs) + " sets of inputs and " +
                          std::to_string(to.size()) + " sets of outputs");
  std::vector<std::unique_ptr<Arguments>> arguments;
  std::vector<chiasm_tensor> in, out;
  void* where = nullptr;
  for (size_t run = 0; run < runs; ++run) {
    arguments.push_back(std::make_unique<Arguments>(Arguments::Role::input, inputs_.count));
    collect(*arguments.back(), inputs_, py::object(from[run]));
    in.insert(in.end(), arguments.back()->views().begin(), arguments.back()->views().end());
    if (run == 0) where = stream_from(stream, *arguments.back());
    arguments.push_back(std::make_unique<Arguments>(Arguments::Role::output, outputs_.count));
    collect(*arguments.back(), outputs_, py::object(to[run]));
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

std::vector<std::pair<py::tuple, std::string>> PythonMethod::output_shapes(const py::args& inputs,
                                                                           const py::kwargs& named) const {
  Arguments arguments(Arguments::Role::input, inputs_.count);
  collect(arguments, inputs_, inputs, named);
  return shapes_for(arguments);
}

std::string PythonMethod::repr() const {
  return "<chiasm method " + name() + "(" + inputs_.names() + ") -> " + outputs_.names() + ", " + backend() +
         ": " + artifact() + ">";
}

void PythonMethod::collect(Arguments& arguments, const Signature& signature, const py::sequence& given,
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
    if (i < given_count && is_named) throw fail(std::string("got '") + tensor + "' by position and by name");
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

void PythonMethod::collect(Arguments& arguments, const Signature& signature, const py::object& given) const {
  if (py::isinstance<py::dict>(given)) {
    collect(arguments, signature, py::tuple(), given.cast<py::dict>());
  } else if (is_list(given)) {
    collect(arguments, signature, given.cast<py::sequence>(), py::dict());
  } else {
    collect(arguments, signature, py::make_tuple(given), py::dict());
  }
}

std::vector<std::pair<py::tuple, std::string>> PythonMethod::shapes_for(const Arguments& arguments) const {
  std::vector<std::pair<py::tuple, std::string>> result;
  for (size_t k = 0; k < outputs_.count; ++k) {
    int64_t shape[CHIASM_MAX_DIMS];
    int32_t ndim = 0;
    int32_t dtype = 0;
    check(api().method_output_shape(method_.c_handle(), arguments.views().data(), arguments.views().size(), k,
                                    shape, &ndim, &dtype));
    py::tuple dims(ndim);
    for (int32_t i = 0; i < ndim; ++i) dims[static_cast<size_t>(i)] = py::int_(shape[i]);
    result.emplace_back(std::move(dims), dtype_name(dtype));
  }
  return result;
}

void PythonMethod::run_into_collected(const Arguments& in, const py::object& outputs, void* where) const {
  Arguments out(Arguments::Role::output, outputs_.count);
  collect(out, outputs_, outputs);
  const chiasm_run_options options{sizeof(chiasm_run_options), where};
  chiasm_status* status = nullptr;
  {
    const WithoutGil released;
    status = api().method_run_into(method_.c_handle(), in.views().data(), in.views().size(),
                                   out.views().data(), out.views().size(), &options);
  }
  check(status);
}

// torch allocates for its current stream, so record_stream tells it about another one. It takes torch's own
// streams only. ExternalStream(0) would be a new stream, not the default one.
py::object PythonMethod::run_on_cuda(const Arguments& arguments, const py::object& stream) const {
  using py::literals::operator""_a;
  void* const where = stream_from(stream, arguments);
  const py::module_ torch = py::module_::import("torch");
  const py::object cuda = torch.attr("cuda");
  const py::object device = torch.attr("device")("cuda", arguments.cuda_device());
  py::object used = stream;
  if (!stream.is_none() && !py::isinstance(stream, cuda.attr("Stream"))) {
    const py::int_ number(reinterpret_cast<size_t>(where));
    used = where == nullptr ? cuda.attr("default_stream")(device)
                            : cuda.attr("ExternalStream")(number, "device"_a = device);
  }
  py::tuple outputs(outputs_.count);
  size_t k = 0;
  for (const auto& [shape, dtype] : shapes_for(arguments)) {
    outputs[k] = torch.attr("empty")(shape, "dtype"_a = torch.attr(dtype.c_str()), "device"_a = device);
    if (!stream.is_none()) outputs[k].attr("record_stream")(used);
    ++k;
  }
  run_into_collected(arguments, outputs, where);
  return outputs_.count == 1 ? py::object(outputs[0]) : py::object(outputs);
}

py::object PythonMethod::run_collected(const Arguments& arguments, const py::object& returns,
                                       const py::object& stream) const {
  const Library library =
      library_from(returns).value_or(arguments.has_torch() ? Library::torch : Library::numpy);
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

}  // namespace chiasm::python
