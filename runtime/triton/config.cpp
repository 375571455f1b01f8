#include "triton/config.h"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <limits>
#include <vector>

#include "base/dtype.h"
#include "triton/errors.h"
#include "triton/types.h"

namespace chiasm::triton {
namespace {

using nlohmann::json;

/** Dimensions as in config.pbtxt: `[-1, -1, 3]`. */
std::string shown(const std::vector<int64_t>& dims) {
  std::string text = "[";
  for (const int64_t dim : dims) text += (text.size() > 1 ? ", " : "") + std::to_string(dim);
  return text + "]";
}

bool read_flag(const std::string& name, const std::string& value) {
  if (value == "true") return true;
  if (value == "false") return false;
  refuse("parameter '" + name + "': expected true or false, got '" + value + "'");
}

int32_t read_threads(const std::string& value) {
  constexpr int32_t kMost = 1024;
  int32_t count = -1;
  const char* const end = value.data() + value.size();
  const auto [stop, error] = std::from_chars(value.data(), end, count);
  if (error != std::errc() || stop != end || count < 0 || count > kMost)
    refuse("parameter 'threads': expected a number from 0 (all that the process may use) to " +
           std::to_string(kMost) + ", got '" + value + "'");
  return count;
}

int32_t read_dtype(const std::string& value) {
  const int32_t dtype = base::dtype_from_name(value);
  if (dtype >= 0) return dtype;
  std::string all;
  for (const base::DTypeEntry& entry : base::kDTypes)
    all += (all.empty() ? "" : ", ") + std::string(entry.name);
  refuse("parameter 'dtype': expected one of " + all + ", got '" + value + "'");
}

/** An integer of a configuration. Triton writes it as a number, or as a text if it has 64 bits. */
int64_t integer(const json& value) {
  if (value.is_number_integer()) return value.get<int64_t>();
  const std::string text = value.is_string() ? value.get<std::string>() : "";
  int64_t number = 0;
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (text.empty() || error != std::errc() || stop != text.data() + text.size())
    refuse("the configuration has " + value.dump() + " where a number is expected");
  return number;
}

/** The dimensions that a configuration gives: numbers, and -1 for sizes that differ between requests. */
std::vector<int64_t> config_dims(const TensorInfo& tensor, bool batched) {
  std::vector<int64_t> dims;
  for (size_t i = batched ? 1 : 0; i < tensor.dims.size(); ++i) {
    const DimInfo& dim = tensor.dims[i];
    dims.push_back(dim.min == dim.max && dim.min > 0 ? dim.min : -1);
  }
  return dims;
}

json described(const TensorInfo& tensor, bool is_input, bool batched) {
  const std::vector<int64_t> dims = config_dims(tensor, batched);
  json entry = {{"name", tensor.name}, {"data_type", config_type_of(tensor.dtypes.at(0))}, {"dims", dims}};
  if (dims.empty()) {  // Triton requires a dimension; for a batch `reshape` removes it again
    entry["dims"] = {1};
    if (batched) entry["reshape"] = {{"shape", json::array()}};
  }
  // Triton does not concatenate the requests of a batch, so they may differ in shape
  if (is_input && batched) entry["allow_ragged_batch"] = true;
  return entry;
}

/** The dimensions that the backend gets by an entry of the user's configuration. */
std::vector<int64_t> given_dims(const json& entry) {
  const json& list = entry.contains("reshape") ? entry["reshape"].value("shape", json::array())
                                               : entry.value("dims", json::array());
  std::vector<int64_t> dims;
  for (const json& dim : list) dims.push_back(integer(dim));
  return dims;
}

/** Whether the user's dimensions are the manifest's, or narrower: a size in place of a symbol. */
bool fits(const std::vector<int64_t>& given, const TensorInfo& tensor, bool batched) {
  const std::vector<int64_t> expected = config_dims(tensor, batched);
  if (expected.empty() && !batched) return given == std::vector<int64_t>{1};
  if (given.size() != expected.size()) return false;
  for (size_t i = 0; i < given.size(); ++i) {
    const DimInfo& dim = tensor.dims[i + (batched ? 1 : 0)];
    const bool limited = dim.max > 0;
    if (given[i] == -1 || given[i] == expected[i]) continue;
    if (expected[i] > 0 || (limited && (given[i] < dim.min || given[i] > dim.max))) return false;
  }
  return true;
}

void check_entry(const json& entry, const char* kind, const TensorInfo& tensor, bool batched) {
  const std::string where = std::string(kind) + " '" + tensor.name + "' of the configuration: ";
  const std::string type = entry.value("data_type", "");
  const std::string expected_type = config_type_of(tensor.dtypes.at(0));
  if (type != expected_type) refuse(where + "the bundle has " + expected_type + ", got " + type);
  const std::vector<int64_t> dims = given_dims(entry);
  if (fits(dims, tensor, batched)) return;
  std::vector<int64_t> expected = config_dims(tensor, batched);
  if (expected.empty() && !batched) expected = {1};
  refuse(where + "the bundle has dims " + shown(expected) + (batched ? " besides the batch's" : "") +
         ", got " + shown(dims));
}

/** The list "input" or "output" of a configuration: filled in if it is empty, else checked. */
void complete_list(json& config, const char* kind, const std::vector<TensorInfo>& tensors, bool batched) {
  json& list = config[kind];
  if (list.empty()) {
    list = json::array();
    for (const TensorInfo& tensor : tensors)
      list.push_back(described(tensor, kind == std::string("input"), batched));
    return;
  }
  std::string names;
  for (const TensorInfo& tensor : tensors) {
    names += (names.empty() ? "" : ", ") + tensor.name;
    const auto entry = std::find_if(list.begin(), list.end(),
                                    [&](const json& each) { return each.value("name", "") == tensor.name; });
    if (entry == list.end())
      refuse(std::string("the configuration lacks the bundle's ") + kind + " '" + tensor.name + "'");
    check_entry(*entry, kind, tensor, batched);
  }
  for (const json& entry : list) {
    const std::string name = entry.value("name", "");
    if (std::none_of(tensors.begin(), tensors.end(), [&](const TensorInfo& t) { return t.name == name; }))
      refuse(std::string("the configuration has an ") + kind + " '" + name + "'; the bundle has " + names);
  }
}

}  // namespace

Parameters read_parameters(const json& config) {
  Parameters parameters;
  const json given = config.value("parameters", json::object());
  for (const auto& [name, entry] : given.items()) {
    const std::string value = entry.value("string_value", "");
    if (name == "method") {
      parameters.method = value;
    } else if (name == "backend") {
      parameters.load.backend = value;
    } else if (name == "dtype") {
      parameters.load.dtype = read_dtype(value);
    } else if (name == "threads") {
      parameters.load.num_threads = read_threads(value);
    } else if (name == "allow_native_code") {
      parameters.load.allow_native_code = read_flag(name, value);
    } else if (name == "warm_up") {
      parameters.load.warm_up = read_flag(name, value);
    } else if (name.rfind("TRITON_", 0) != 0) {  // the server has parameters of its own
      refuse("unknown parameter '" + name +
             "'; there are method, backend, dtype, threads, allow_native_code, warm_up");
    }
  }
  return parameters;
}

Signature read_signature(const MethodInfo& method, const std::string& manifest) {
  const json parsed = json::parse(manifest);  // which the core has checked
  const json& about = parsed.at("methods").at(method.name);
  const std::string samples = about.value("samples", "");
  const auto counts = [&](const TensorInfo& tensor) {
    return !tensor.dims.empty() && tensor.dims[0].expression == samples;
  };
  Signature signature{method, 0};
  if (!samples.empty() && std::all_of(method.inputs.begin(), method.inputs.end(), counts) &&
      std::all_of(method.outputs.begin(), method.outputs.end(), counts)) {
    signature.most_samples =
        std::min<int64_t>(method.inputs.at(0).dims[0].max, std::numeric_limits<int32_t>::max());
  }
  return signature;
}

json complete(json config, const Signature& signature) {
  const bool says_tensors =
      !config.value("input", json::array()).empty() || !config.value("output", json::array()).empty();
  int64_t batch = integer(config.value("max_batch_size", json(0)));
  if (batch > 0 && signature.most_samples == 0)
    refuse("max_batch_size is " + std::to_string(batch) + ", but by the bundle's manifest the inputs of '" +
           signature.method.name + "' do not all count independent samples: leave it out");
  if (batch > 0 && batch > signature.most_samples)
    refuse("max_batch_size is " + std::to_string(batch) + ", the bundle takes at most " +
           std::to_string(signature.most_samples) + " samples at once");
  // Without max_batch_size, tensors in the user's configuration include the batch dimension in their dims
  if (batch == 0 && !says_tensors) batch = signature.most_samples;
  config["max_batch_size"] = batch;
  complete_list(config, "input", signature.method.inputs, batch > 0);
  complete_list(config, "output", signature.method.outputs, batch > 0);
  return config;
}

}  // namespace chiasm::triton
