#include "mutate.h"

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <random>

#include "support.h"

namespace chiasm::testing {
namespace {

using Json = nlohmann::json;

constexpr const char* kManifest = "manifest.json";

bool ends_with(const std::string& text, const std::string& end) {
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

bool is_code(const std::string& file) { return ends_with(file, ".pt") || ends_with(file, ".pt2"); }

class Mutator {
 public:
  Mutator(const std::vector<Files>& bundles, size_t which, uint64_t number)
      : bundles_(bundles), random_(number * 1000003 + which), result_{bundles[which], "", false} {}

  Mutant make() {
    const size_t times = below(4) == 0 ? 1 + below(3) : 1;
    for (size_t i = 0; i < times; ++i) {
      switch (below(10)) {
        case 0: damage_file(false); break;
        case 1:
        case 2: damage_file(true); break;
        case 3: damage_text(); break;
        case 4: swap_files(); break;
        case 5: swap_artifact_fields(); break;
        default: edit_manifest(); break;
      }
    }
    return std::move(result_);
  }

 private:
  size_t below(size_t count) { return std::uniform_int_distribution<size_t>(0, count - 1)(random_); }
  void say(const std::string& text) {
    result_.description += (result_.description.empty() ? "" : "; ") + text;
  }

  std::string any_file() {
    auto at = result_.files.begin();
    std::advance(at, static_cast<std::ptrdiff_t>(below(result_.files.size())));
    return at->first;
  }

  Json manifest() const {
    const std::string& text = result_.files.at(kManifest);
    return Json::accept(text) ? Json::parse(text) : Json::object();
  }

  void damage(std::string& bytes) {
    if (bytes.empty()) return;
    const size_t at = below(bytes.size()), length = std::min(bytes.size() - at, size_t{1} << below(12));
    switch (below(6)) {
      case 0:
        bytes[at] = static_cast<char>(bytes[at] ^ (1 << below(8)));
        return say("bit " + std::to_string(at));
      case 1: bytes.resize(at); return say("cut at " + std::to_string(at));
      case 2:
        bytes.erase(at, length);
        return say("without " + std::to_string(length) + " at " + std::to_string(at));
      case 3:
        bytes.insert(at, bytes.substr(below(bytes.size()), length));
        return say("inserted at " + std::to_string(at));
      case 4:
        std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(at), length,
                    static_cast<char>(below(2) == 0 ? 0 : 0xff));
        return say("filled at " + std::to_string(at));
      default:
        for (size_t i = 0; i < length; ++i) bytes[at + i] = static_cast<char>(below(256));
        return say("noise at " + std::to_string(at));
    }
  }

  void damage_file(bool with_hash) {
    std::string name = any_file();
    for (int tries = 0; with_hash && (is_code(name) || name == kManifest) && tries < 20; ++tries)
      name = any_file();
    with_hash = with_hash && !is_code(name) && name != kManifest;
    say(name + (with_hash ? ", hash corrected" : ""));
    damage(result_.files[name]);
    if (with_hash) correct(name);
  }

  /** Updates the manifest's hash and size of a file that has changed. */
  void correct(const std::string& name) {
    Json root = manifest();
    const std::string& bytes = result_.files[name];
    const auto fix = [&](Json& entry) {
      if (!entry.is_object() || entry.value("file", Json()) != name) return;
      entry["size"] = bytes.size();
      entry["sha256"] = sha256_of(bytes);
      result_.other_data = true;
    };
    if (root.contains("golden")) fix(root["golden"]);
    if (root.contains("documents") && root["documents"].is_object()) {
      for (Json& document : root["documents"]) fix(document);
    }
    if (root.contains("methods") && root["methods"].is_object()) {
      for (Json& method : root["methods"]) {
        if (!method.is_object() || !method.contains("artifacts")) continue;
        for (Json& artifact : method["artifacts"]) fix(artifact);
      }
    }
    result_.files[kManifest] = root.dump(1);
  }

  /** Damages the manifest's text: duplicated keys, deep nesting, broken syntax. */
  void damage_text() {
    std::string& text = result_.files[kManifest];
    const size_t at = below(std::max<size_t>(text.size(), 1));
    switch (below(5)) {
      case 0: {
        const size_t depth = size_t{1} << (4 + below(16));
        const size_t value = text.find(": ", at);
        if (value == std::string::npos) break;
        text.insert(value + 2, std::string(depth, '[') + std::string(below(2) == 0 ? depth : 0, ']') +
                                   (below(2) == 0 ? "," : ""));
        return say("nested " + std::to_string(depth));
      }
      case 1: {
        const size_t line = text.find('\n', at),
                     end = line == std::string::npos ? line : text.find('\n', line + 1);
        if (end == std::string::npos) break;
        text.insert(end, text.substr(line, end - line));
        return say("a line twice");
      }
      case 2: {
        const size_t digit = text.find_first_of("0123456789", at);
        if (digit == std::string::npos) break;
        static constexpr const char* kNumbers[] = {"99999999999999999999999999",
                                                   "1e400",
                                                   "-0",
                                                   "0x10",
                                                   "1e-400",
                                                   "NaN",
                                                   "01",
                                                   "18446744073709551615",
                                                   "9223372036854775807"};
        text.replace(digit, text.find_first_not_of("0123456789", digit) - digit,
                     kNumbers[below(std::size(kNumbers))]);
        return say("a number at " + std::to_string(digit));
      }
      case 3: text.insert(at, std::string("\0\xff\xfe\\u0000\"", 12)); return say("bytes in the manifest");
      default: damage(text); return;
    }
  }

  /** Puts a file's content under another file's name, from this bundle or another, with a correct hash. */
  void swap_files() {
    const std::string name = any_file();
    const Files& other = bundles_[below(bundles_.size())];
    auto from = other.begin();
    std::advance(from, static_cast<std::ptrdiff_t>(below(other.size())));
    if (name == kManifest || from->first == kManifest) return;
    // A program that replaces another with the same signature may give other results.
    result_.files[name] = from->second;
    say(name + " is " + from->first);
    correct(name);
  }

  /** Exchanges a field between the entries of two artifacts: file, format, backend, device, ... */
  void swap_artifact_fields() {
    Json root = manifest();
    std::vector<Json*> artifacts;
    if (root.contains("methods") && root["methods"].is_object()) {
      for (Json& method : root["methods"]) {
        if (!method.is_object() || !method.contains("artifacts") || !method["artifacts"].is_array()) continue;
        for (Json& artifact : method["artifacts"]) artifacts.push_back(&artifact);
      }
    }
    if (artifacts.size() < 2) return;
    Json &one = *artifacts[below(artifacts.size())], &two = *artifacts[below(artifacts.size())];
    if (!one.is_object() || !two.is_object()) return;
    static constexpr const char* kFields[] = {"file",   "backend", "format",   "dtypes",
                                              "device", "isa",     "function", "autograd"};
    const std::string field = kFields[below(std::size(kFields))];
    const std::vector<std::string> moved = field == "file"
                                               ? std::vector<std::string>{"file", "size", "sha256"}
                                               : std::vector<std::string>{field};
    for (const std::string& key : moved) std::swap(one[key], two[key]);
    for (Json* artifact : {&one, &two}) {
      for (const std::string& key : moved)
        if ((*artifact)[key].is_null()) artifact->erase(key);
    }
    result_.files[kManifest] = root.dump(1);
    result_.other_data = result_.other_data || field == "file" ||
                         field == "function";  // another dtype's file, or another method's
    say("two artifacts exchange " + field);
  }

  void edit_manifest() {
    Json root = manifest();
    std::vector<Json*> nodes, signature;
    collect(root, nodes, signature, "", false);
    if (nodes.size() < 2) return;
    // The part of the manifest with which native code must agree is small.
    Json& node = signature.empty() || below(2) == 0 ? *nodes[1 + below(nodes.size() - 1)]
                                                    : *signature[below(signature.size())];
    const std::string before = node.dump().substr(0, 60);
    change(node, nodes);
    say("manifest: " + before + " -> " +
        node.dump(-1, ' ', false, Json::error_handler_t::replace).substr(0, 60));
    result_.files[kManifest] = root.dump(1, ' ', false, Json::error_handler_t::replace);
  }

  /** Collects all nodes except purely descriptive ones, and those of them that define a signature. */
  static void collect(Json& node, std::vector<Json*>& nodes, std::vector<Json*>& signature,
                      const std::string& key, bool inside) {
    if (key == "description" || key == "summary" || key == "reference" || key == "producer" ||
        key == "config" || key == "sha256")
      return;
    nodes.push_back(&node);
    inside = inside || key == "inputs" || key == "outputs" || key == "symbols" || key == "samples";
    if (inside) signature.push_back(&node);
    if (node.is_object()) {
      for (const auto& [name, child] : node.items()) collect(child, nodes, signature, name, inside);
    } else if (node.is_array()) {
      for (Json& child : node) collect(child, nodes, signature, key, inside);
    }
  }

  void change(Json& node, const std::vector<Json*>& nodes) {
    const Json other = *nodes[below(nodes.size())];
    if (below(6) == 0) {
      node = other;
    } else if (node.is_number()) {
      static const Json kNumbers[] = {
          0,         -1,        1,          2,    3,     5,       7,
          8,         64,        255,        4096, 65536, 1 << 20, int64_t{1} << 33,
          INT64_MAX, INT64_MIN, UINT64_MAX, 0.5,  -0.0,  1e308};
      const bool near = below(3) == 0 && node.is_number_integer();
      node = near ? Json(node.get<int64_t>() + static_cast<int64_t>(below(5)) - 2)
                  : kNumbers[below(std::size(kNumbers))];
    } else if (node.is_string()) {
      static constexpr const char* kTexts[] = {"",
                                               "H",
                                               "W",
                                               "B",
                                               "C",
                                               "N",
                                               "2*H",
                                               "H//0",
                                               "H-9999999",
                                               "(H",
                                               "9223372036854775807*H",
                                               "-1",
                                               "0",
                                               "1",
                                               "3",
                                               "T",
                                               "float32",
                                               "float64",
                                               "uint8",
                                               "bool",
                                               "int64",
                                               "float16",
                                               "bfloat16",
                                               "native",
                                               "onnx",
                                               "torch",
                                               "any",
                                               "cuda",
                                               "torchscript",
                                               "aotinductor",
                                               "x86-64-v4",
                                               "../x",
                                               "/etc/passwd",
                                               "input",
                                               "output",
                                               "forward",
                                               "vjp"};
      node = kTexts[below(std::size(kTexts))];
    } else if (node.is_boolean()) {
      node = !node.get<bool>();
    } else if (node.is_array()) {
      switch (below(4)) {
        case 0: node.push_back(node.empty() ? other : node[below(node.size())]); break;
        case 1:
          if (!node.empty()) node.erase(node.begin() + static_cast<std::ptrdiff_t>(below(node.size())));
          break;
        case 2: std::shuffle(node.begin(), node.end(), random_); break;
        default: node = Json::array(); break;
      }
    } else if (node.is_object() && !node.empty()) {
      auto member = node.begin();
      std::advance(member, static_cast<std::ptrdiff_t>(below(node.size())));
      const std::string key = member.key();
      const Json value = member.value();
      if (below(3) != 0) node.erase(key);
      if (below(2) == 0) node[key + "x"] = value;
    } else {
      node = other;
    }
  }

  const std::vector<Files>& bundles_;
  std::mt19937_64 random_;
  Mutant result_;
};

}  // namespace

Files read_bundle(const std::string& folder) {
  Files files;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    files[entry.path().filename()] = read_text(entry.path());
  return files;
}

void write_bundle(const std::string& folder, const Files& files) {
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  for (const auto& [name, bytes] : files) write_text(folder + "/" + name, bytes);
}

Mutant mutant_of(const std::vector<Files>& bundles, size_t which, uint64_t number) {
  return Mutator(bundles, which, number).make();
}

}  // namespace chiasm::testing
