// Reads a manifest member by member: every value has a limit, and an unknown member is an error.
#include "core/manifest.h"

#include <algorithm>
#include <set>

#include "base/dtype.h"
#include "core/json.h"
#include "core/registry.h"
#include "core/status.h"

namespace chiasm::core {
namespace {

constexpr int64_t kMaxDim = int64_t{1} << 40;
constexpr int64_t kMaxFileSize = int64_t{1} << 40;
/** The longest `why`, in characters. */
constexpr size_t kMaxWhy = 4096;

bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }

/** Whether `text` is a letter or underscore, followed by letters, underscores, digits and characters of
 *  `more`. */
bool is_name(std::string_view text, std::string_view more = "") {
  if (text.empty() || !is_letter(text[0])) return false;
  for (const char c : text) {
    if (!is_letter(c) && !is_digit(c) && more.find(c) == std::string_view::npos) return false;
  }
  return true;
}

std::string read_name(const JsonNode& node, std::string_view more = "") {
  const std::string& text = node.string(256);
  if (!is_name(text, more)) node.refuse("'" + text + "' is not a name");
  return text;
}

/** A plain file name: no path out of the bundle's folder, and neither the manifest nor its signature. */
std::string read_file_name(const JsonNode& node) {
  const std::string& text = node.string(255);
  bool good = !text.empty() && (is_letter(text[0]) || is_digit(text[0])) &&
              text.find("..") == std::string::npos && text.rfind("manifest.json", 0) != 0;
  for (const char c : text) good = good && (is_letter(c) || is_digit(c) || c == '.' || c == '-');
  if (!good) node.refuse("'" + text + "' is not the name of a file inside the bundle");
  return text;
}

std::string read_sha256(const JsonNode& node) {
  const std::string& text = node.string(64);
  const bool good = text.size() == 64 && text.find_first_not_of("0123456789abcdef") == std::string::npos;
  if (!good) node.refuse("'" + text + "' is not a sha256: 64 lower-case hexadecimal digits");
  return text;
}

/** The members `file`, `size` and `sha256` of the node. */
BundleFile read_bundle_file(const JsonNode& node) {
  BundleFile file;
  file.file = read_file_name(node.at("file"));
  file.size = static_cast<uint64_t>(node.at("size").integer(1, kMaxFileSize));
  file.sha256 = read_sha256(node.at("sha256"));
  return file;
}

/** The name of a backend, a format or an engine. Any name is accepted here: plug-ins define which exist. */
std::string read_plugin_name(const JsonNode& node) {
  const std::string& text = node.string(64);
  if (!is_backend_name(text))
    node.refuse("'" + text + "' is not a name of lower-case letters, digits and underscores");
  return text;
}

/** "2.31" */
GlibcVersion read_glibc(const JsonNode& node) {
  const std::string& text = node.string(16);
  const size_t dot = text.find('.');
  const auto is_number = [](const std::string& part) {
    return !part.empty() && part.size() <= 4 && part.find_first_not_of("0123456789") == std::string::npos;
  };
  if (dot == std::string::npos || !is_number(text.substr(0, dot)) || !is_number(text.substr(dot + 1))) {
    node.refuse("'" + text + "' is not a version like 2.31");
  }
  return {std::stoi(text.substr(0, dot)), std::stoi(text.substr(dot + 1))};
}

void check_version(const JsonNode& node) {
  const std::string& text = node.string(64);
  int dots = 0;
  bool good = !text.empty() && is_digit(text.front()) && is_digit(text.back());
  for (size_t i = 0; good && i < text.size(); ++i) {
    if (text[i] == '.') {
      ++dots;
      good = text[i + 1] != '.';
    } else {
      good = is_digit(text[i]);
    }
  }
  if (!good || dots != 2) node.refuse("'" + text + "' is not a version like 1.0.0");
}

/** "2026-01-31T23:59:59Z" */
void check_time(const JsonNode& node) {
  static const std::string kForm = "0000-00-00T00:00:00Z";
  const std::string& text = node.string(64);
  bool good = text.size() == kForm.size();
  for (size_t i = 0; good && i < kForm.size(); ++i)
    good = kForm[i] == '0' ? is_digit(text[i]) : text[i] == kForm[i];
  if (!good) node.refuse("'" + text + "' is not a time like 2026-01-31T23:59:59Z");
}

int32_t read_dtype(const JsonNode& node) {
  const std::string& text = node.string(64);
  const int32_t dtype = dtype_from_name(text);
  if (dtype < 0) node.refuse("unknown dtype '" + text + "'");
  return dtype;
}

std::vector<int32_t> read_dtypes(const JsonNode& node) {
  std::vector<int32_t> dtypes;
  for (const JsonNode& element : node.elements(0, kDTypeCount)) {
    const int32_t dtype = read_dtype(element);
    if (std::find(dtypes.begin(), dtypes.end(), dtype) != dtypes.end()) element.refuse("occurs twice");
    dtypes.push_back(dtype);
  }
  return dtypes;
}

/** The index of the node's text in `names`. */
template <size_t N>
size_t read_choice(const JsonNode& node, const char* const (&names)[N]) {
  const std::string& text = node.string(64);
  std::string all;
  for (size_t i = 0; i < N; ++i) {
    if (text == names[i]) return i;
    all += (i == 0 ? "" : ", ") + std::string(names[i]);
  }
  node.refuse("expected one of " + all + "; got '" + text + "'");
}

/** Reads one manifest. The members are the state that its parts share. */
class Reader final {
 public:
  explicit Reader(const JsonNode& root) : root_(root) {}

  Manifest read() {
    root_.expect_object();
    const JsonNode schema = root_.at("schema_version");
    version_ = schema.integer(1, INT64_MAX);
    if (version_ > kSchemaVersion) {
      schema.refuse("the bundle was written by a newer chiasm (schema " + std::to_string(version_) +
                        "); this library reads up to " + std::to_string(kSchemaVersion) +
                        ": update chiasm, or export the bundle with the older version",
                    CHIASM_VERSION_MISMATCH);
    }
    if (version_ < 2 && root_.has("documents"))
      root_.refuse("'documents' is for schema version 2, this is 1");
    root_.only({"schema_version", "name", "version", "summary", "reference", "created", "producer", "config",
                "symbols", "dtypes", "methods", "golden", "documents"});
    manifest_.name = read_name(root_.at("name"), ".");
    check_version(root_.at("version"));
    manifest_.version = root_.at("version").string();
    manifest_.summary = root_.at("summary").string();
    root_.at("reference").string();
    check_time(root_.at("created"));
    for (const auto& member : root_.at("producer").members(0, 64)) member.node.string(256);
    root_.at("config").expect_object();
    read_symbols();
    manifest_.dtypes = read_dtypes(root_.at("dtypes"));
    const JsonNode methods = root_.at("methods");
    methods.at("forward");
    for (const auto& member : methods.members(1, 64)) read_method(member);
    read_golden();
    if (root_.has("documents")) read_documents(root_.at("documents"));
    return std::move(manifest_);
  }

 private:
  void read_symbols() {
    for (const auto& member : root_.at("symbols").members(0, kMaxSymbols)) {
      if (!is_name(member.key)) member.node.refuse("'" + member.key + "' is not a name");
      member.node.only({"min", "max"});
      Symbol symbol{member.key, member.node.at("min").integer(1, kMaxDim),
                    member.node.at("max").integer(1, kMaxDim)};
      if (symbol.min > symbol.max) {
        member.node.refuse("min " + std::to_string(symbol.min) + " is greater than max " +
                           std::to_string(symbol.max));
      }
      symbol_names_.push_back(symbol.name);
      manifest_.symbols.push_back(std::move(symbol));
    }
  }

  Expression read_dim(const JsonNode& node) const {
    if (node.is_integer()) return Expression(node.integer(0, kMaxDim));
    const std::string& text = node.string(256);
    try {
      return Expression::parse(text, symbol_names_);
    } catch (const Error& error) {
      node.refuse(error.what());
    }
  }

  TensorSpec read_tensor(const JsonNode& node) const {
    node.only({"name", "dtype", "shape", "description", "layout", "color", "range"});
    TensorSpec tensor;
    tensor.name = read_name(node.at("name"));
    tensor.description = node.at("description").string();
    tensor.layout = node.at("layout").string(64);
    tensor.color = node.at("color").string(64);
    const JsonNode dtype = node.at("dtype");
    tensor.dtype = dtype.string() == "T" ? kGeneric : read_dtype(dtype);
    if (tensor.dtype == kGeneric && manifest_.dtypes.empty())
      dtype.refuse("is T, but the manifest's 'dtypes' is empty");
    for (const JsonNode& dim : node.at("shape").elements(0, CHIASM_MAX_DIMS))
      tensor.shape.push_back(read_dim(dim));
    const JsonNode range = node.at("range");
    if (!range.is_null()) {
      const auto limits = range.elements(2, 2);
      tensor.value_min = limits[0].number();
      tensor.value_max = limits[1].number();
      if (tensor.value_min > tensor.value_max) range.refuse("its minimum is greater than its maximum");
    }
    return tensor;
  }

  Artifact read_artifact(const JsonNode& node, const MethodSpec& method) const {
    static constexpr const char* kDevices[] = {"any", "cpu", "cuda"};
    node.only({"backend", "format", "file", "size", "sha256", "dtypes", "device", "autograd", "isa", "sm",
               "glibc", "opset", "ir_version", "needs", "function", "why", "options"});
    Artifact artifact;
    static_cast<BundleFile&>(artifact) = read_bundle_file(node);
    artifact.backend = read_plugin_name(node.at("backend"));
    artifact.format = read_plugin_name(node.at("format"));
    artifact.dtypes = read_dtypes(node.at("dtypes"));
    for (const int32_t dtype : artifact.dtypes) {
      if (std::find(manifest_.dtypes.begin(), manifest_.dtypes.end(), dtype) == manifest_.dtypes.end()) {
        node.at("dtypes").refuse(std::string(dtype_name(dtype)) + " is not among the manifest's 'dtypes'");
      }
    }
    if (method.generic && artifact.dtypes.empty())
      node.at("dtypes").refuse("empty, but the method has tensors of dtype T");
    artifact.device = static_cast<DevicePlacement>(read_choice(node.at("device"), kDevices));
    if (node.has("isa")) artifact.isa = static_cast<Isa>(1 + read_choice(node.at("isa"), kIsaNames));
    if (node.has("sm")) artifact.sm = node.at("sm").integer(1, 9999);
    if (node.has("glibc")) artifact.glibc = read_glibc(since(node, "glibc", 3));
    if (node.has("opset")) node.at("opset").integer(1, 9999);
    if (node.has("ir_version")) node.at("ir_version").integer(1, 9999);
    if (node.has("needs")) {
      for (const JsonNode& need : node.at("needs").elements(0, 16))
        artifact.needs.push_back(read_plugin_name(need));
    }
    if (node.has("why")) artifact.why = read_why(since(node, "why", 2));
    read_options(node, artifact);
    return artifact;
  }

  /** The member `key`, which exists since this version of the schema. */
  JsonNode since(const JsonNode& node, const char* key, int64_t version) const {
    if (version_ < version) {
      node.refuse("'" + std::string(key) + "' is for schema version " + std::to_string(version) +
                  ", this is " + std::to_string(version_));
    }
    return node.at(key);
  }

  static std::string read_why(const JsonNode& node) {
    std::string why = node.string(4 * kMaxWhy);
    const auto is_first_byte = [](char c) { return (c & 0xC0) != 0x80; };  // of a character in UTF-8
    if (std::count_if(why.begin(), why.end(), is_first_byte) > static_cast<std::ptrdiff_t>(kMaxWhy)) {
      node.refuse("longer than " + std::to_string(kMaxWhy) + " characters");
    }
    return why;
  }

  /** `autograd` and `function` are options of the torch and the onnx backend. They have members of their own
   *  because they are older than `options`. */
  void read_options(const JsonNode& node, Artifact& artifact) const {
    if (node.has("autograd")) {
      const bool autograd = node.at("autograd").boolean();
      if (autograd && artifact.format != "torchscript")
        node.refuse("'autograd' is for format torchscript only");
      if (autograd) artifact.options["autograd"] = "1";
    }
    if (node.has("function")) {
      if (artifact.format != "onnx") node.refuse("'function' is for format onnx only");
      artifact.options["function"] = read_name(node.at("function"));
      artifact.format = kFusedOnnx;
    }
    if (!node.has("options")) return;
    for (const auto& member : since(node, "options", 3).members(0, 64)) {
      if (!is_backend_name(member.key))
        member.node.refuse("'" + member.key + "' is not the name of an option");
      if (!artifact.options.emplace(member.key, member.node.string(4096)).second)
        member.node.refuse("is given twice");
    }
  }

  void read_method(const JsonNode::Member& member) {
    const JsonNode& node = member.node;
    if (!is_name(member.key)) node.refuse("'" + member.key + "' is not a name");
    node.only({"inputs", "outputs", "samples", "tolerances", "artifacts"});
    MethodSpec method;
    method.name = member.key;
    std::set<std::string> names;
    for (const char* side : {"inputs", "outputs"}) {
      for (const JsonNode& element : node.at(side).elements(1, kMaxTensors)) {
        TensorSpec tensor = read_tensor(element);
        if (!names.insert(tensor.name).second)
          element.at("name").refuse("a second tensor of the name '" + tensor.name + "'");
        method.generic = method.generic || tensor.dtype == kGeneric;
        (side[0] == 'i' ? method.inputs : method.outputs).push_back(std::move(tensor));
      }
    }
    check_symbols_bound(node, method);
    if (node.has("samples")) read_samples(node.at("samples"), method);
    read_tolerances(node.at("tolerances"), method);
    for (const JsonNode& element : node.at("artifacts").elements(1, 256)) {
      method.artifacts.push_back(read_artifact(element, method));
      manifest_.files.insert(method.artifacts.back().file);
    }
    manifest_.methods.push_back(std::move(method));
  }

  /** Each symbol of a method must be a whole dimension of some input, which gives the symbol its value. */
  void check_symbols_bound(const JsonNode& node, const MethodSpec& method) const {
    std::set<size_t> bound;
    for (const TensorSpec& tensor : method.inputs) {
      for (const Expression& dim : tensor.shape) {
        if (dim.is_symbol()) bound.insert(static_cast<size_t>(dim.operand()));
      }
    }
    for (const auto* tensors : {&method.inputs, &method.outputs}) {
      for (const TensorSpec& tensor : *tensors) {
        for (const Expression& dim : tensor.shape) {
          for (const size_t symbol : dim.symbols()) {
            if (bound.count(symbol) == 0) {
              node.refuse("'" + tensor.name + "' has the dimension '" + dim.text() +
                          "', but no input has the dimension '" + symbol_names_[symbol] + "'");
            }
          }
        }
      }
    }
  }

  /** The symbol that counts samples must be the first dimension of every output and of some inputs, and occur
   *  nowhere else. */
  void read_samples(const JsonNode& node, MethodSpec& method) const {
    const std::string& name = node.string(64);
    const auto found = std::find(symbol_names_.begin(), symbol_names_.end(), name);
    if (found == symbol_names_.end()) node.refuse("there is no symbol '" + name + "'");
    const auto symbol = static_cast<size_t>(found - symbol_names_.begin());
    if (manifest_.symbols[symbol].min != 1)
      node.refuse("'" + name + "' cannot be 1, so a batch has no parts");
    const auto mask = [&](const std::vector<TensorSpec>& tensors) {
      uint64_t first = 0;
      for (size_t i = 0; i < tensors.size(); ++i) {
        for (size_t d = 0; d < tensors[i].shape.size(); ++d) {
          const std::vector<size_t> used = tensors[i].shape[d].symbols();
          if (std::find(used.begin(), used.end(), symbol) == used.end()) continue;
          if (d != 0 || !tensors[i].shape[d].is_symbol()) {
            node.refuse("'" + name + "' must be a first dimension, but '" + tensors[i].name +
                        "' has it elsewhere");
          }
          first |= uint64_t{1} << i;
        }
      }
      return first;
    };
    method.batched_inputs = mask(method.inputs);
    method.batched_outputs = mask(method.outputs);
    if (method.batched_outputs != (~uint64_t{0} >> (64 - method.outputs.size())))
      node.refuse("an output has no first dimension '" + name + "'");
  }

  static void read_tolerances(const JsonNode& node, MethodSpec& method) {
    for (const auto& member : node.members(0, kDTypeCount)) {
      const int32_t dtype = dtype_from_name(member.key);
      if (dtype < 0) member.node.refuse("unknown dtype '" + member.key + "'");
      member.node.only({"atol", "rtol"});
      const Tolerance tolerance{member.node.at("atol").number(), member.node.at("rtol").number()};
      if (tolerance.atol < 0 || tolerance.rtol < 0) member.node.refuse("a tolerance must not be negative");
      method.tolerances[static_cast<size_t>(dtype)] = tolerance;
    }
  }

  void read_golden() {
    const JsonNode node = root_.at("golden");
    node.only({"file", "size", "sha256", "cases"});
    manifest_.golden = read_bundle_file(node);
    manifest_.files.insert(manifest_.golden.file);
    for (const JsonNode& element : node.at("cases").elements(1, 4096)) {
      element.only({"prefix", "method", "dtype"});
      GoldenCase one;
      one.prefix = element.at("prefix").string(256);
      const std::string& name = element.at("method").string(256);
      const auto found = std::find_if(manifest_.methods.begin(), manifest_.methods.end(),
                                      [&name](const MethodSpec& method) { return method.name == name; });
      if (found == manifest_.methods.end()) element.at("method").refuse("there is no method '" + name + "'");
      one.method = static_cast<size_t>(found - manifest_.methods.begin());
      const JsonNode dtype = element.at("dtype");
      if (!dtype.is_null()) one.dtype = read_dtype(dtype);
      if (found->generic && one.dtype == kGeneric)
        dtype.refuse("is null, but the method has tensors of dtype T");
      manifest_.golden_cases.push_back(std::move(one));
    }
  }

  /** Each document must be a file of its own. */
  void read_documents(const JsonNode& node) {
    for (const auto& member : node.members(0, 64)) {
      member.node.only({"file", "size", "sha256"});
      BundleFile document = read_bundle_file(member.node);
      if (!manifest_.files.insert(document.file).second) {
        member.node.at("file").refuse("'" + document.file + "' is the name of another file of the bundle");
      }
      manifest_.documents.push_back(std::move(document));
    }
  }

  JsonNode root_;
  int64_t version_ = 0;
  Manifest manifest_;
  std::vector<std::string> symbol_names_;
};

}  // namespace

Manifest parse_manifest(std::string_view text, const std::string& origin) {
  if (text.size() > kMaxManifestSize) {
    fail(CHIASM_CORRUPT, origin + ": longer than " + std::to_string(kMaxManifestSize) + " bytes");
  }
  const JsonDocument document = parse_json(text, origin);
  return Reader(JsonNode(document.value, origin)).read();
}

}  // namespace chiasm::core
