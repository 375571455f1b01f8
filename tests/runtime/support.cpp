#include "support.h"

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include "core/file.h"

namespace chiasm::testing {
namespace {

using Json = nlohmann::json;

Json tensor(const std::string& name, const Json& shape) {
  return {{"name", name}, {"dtype", "T"}, {"shape", shape},  {"description", "a " + name},
          {"layout", ""}, {"color", ""},  {"range", nullptr}};
}

Json artifact(const std::string& backend, const std::string& format, const std::string& file,
              const Json& dtypes) {
  const std::string content = artifact_content(file, "scale 2");
  return {{"backend", backend},
          {"format", format},
          {"file", file},
          {"size", content.size()},
          {"sha256", sha256_of(content)},
          {"dtypes", dtypes},
          {"device", backend == "native" ? "cpu" : "any"}};
}

}  // namespace

TemporaryFolder::TemporaryFolder() {
  std::string pattern = (std::filesystem::temp_directory_path() / "chiasm-test-XXXXXX").string();
  if (::mkdtemp(pattern.data()) == nullptr) throw std::runtime_error("mkdtemp failed");
  path_ = pattern;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

std::string TemporaryFolder::write(const std::string& name, const std::string& content) const {
  const std::string path = path_ + "/" + name;
  write_text(path, content);
  return path;
}

std::string read_text(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

void write_text(const std::string& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file << text;
  if (!file) throw std::runtime_error("cannot write " + path);
}

std::string artifact_content(const std::string& file, const std::string& words) {
  const bool is_onnx = file.size() > 5 && file.compare(file.size() - 5, 5, ".onnx") == 0;
  return is_onnx ? "2" + std::string(1, static_cast<char>(words.size())) + words : words;
}

std::string sha256_of(const std::string& content) { return core::sha256(content.data(), content.size()); }

std::string safetensors(const std::vector<NamedTensor>& tensors) {
  Json header = Json::object();
  std::string data;
  for (const NamedTensor& tensor : tensors) {
    const size_t bytes = tensor.values.size() * sizeof(float);
    header[tensor.name] = {
        {"dtype", "F32"}, {"shape", tensor.shape}, {"data_offsets", {data.size(), data.size() + bytes}}};
    data.append(reinterpret_cast<const char*>(tensor.values.data()), bytes);
  }
  const std::string text = header.dump();
  std::string file;
  for (int i = 0; i < 8; ++i) file += static_cast<char>((text.size() >> (8 * i)) & 255);
  return file + text + data;
}

Json manifest() {
  const Json image = {"B", 3, "H", "W"};
  Json root = {{"schema_version", 1},
               {"name", "test.scale"},
               {"version", "1.2.3"},
               {"summary", "scales"},
               {"reference", "arithmetic"},
               {"created", "2026-01-01T00:00:00Z"},
               {"producer", {{"test", "1"}}},
               {"config", {{"factor", 2}}},
               {"symbols",
                {{"B", {{"min", 1}, {"max", 64}}},
                 {"H", {{"min", 3}, {"max", 4096}}},
                 {"W", {{"min", 3}, {"max", 4096}}}}},
               {"dtypes", {"float32", "float64"}}};
  const Json tolerances = {{"float32", {{"atol", 1e-5}, {"rtol", 1e-5}}}};
  Json& forward = root["methods"]["forward"];
  forward["inputs"] = {tensor("input", image), tensor("sigma", {"B", 2})};
  forward["outputs"] = {tensor("output", image), tensor("half", {"B", "(H+1)//2"})};
  forward["tolerances"] = tolerances;
  Json v3 = artifact("native", "aotinductor", "forward.v3.so", {"float32"});
  v3["isa"] = "x86-64-v3";
  Json v4 = artifact("native", "aotinductor", "forward.v4.so", {"float32"});
  v4["isa"] = "x86-64-v4";
  forward["artifacts"] = {v3, v4, artifact("torch", "torchscript", "forward.pt", {"float32", "float64"}),
                          artifact("onnx", "onnx", "forward.float32.onnx", {"float32"}),
                          artifact("onnx", "onnx", "forward.float64.onnx", {"float64"})};
  Json& vjp = root["methods"]["vjp"];
  vjp["inputs"] = {tensor("input", image), tensor("grad_half", {"B", "(H+1)//2"})};
  vjp["outputs"] = Json::array({tensor("grad_input", image)});
  vjp["tolerances"] = tolerances;
  vjp["artifacts"] = Json::array({artifact("onnx", "onnx", "vjp.float32.onnx", {"float32"})});

  root["golden"] = {
      {"file", "golden.safetensors"},
      {"size", 1},
      {"sha256", sha256_of("")},
      {"cases", Json::array({{{"prefix", "forward.float32"}, {"method", "forward"}, {"dtype", "float32"}}})}};
  return root;
}

std::string write_bundle(const TemporaryFolder& folder, const std::function<void(Json&)>& change) {
  const std::string bundle = folder.path() + "/test.scale.chiasm";
  std::filesystem::create_directory(bundle);
  Json root = manifest();
#if defined(__aarch64__)
  root["methods"]["forward"]["artifacts"][0]["isa"] = "armv8.2-a";  // one that this CPU runs
#endif
  for (const auto& method : root["methods"]) {
    for (const auto& entry : method["artifacts"]) {
      const auto file = entry["file"].get<std::string>();
      write_text(bundle + "/" + file, artifact_content(file, "scale 2"));
    }
  }
  std::vector<float> input(1 * 3 * 4 * 5), output, half;
  for (size_t i = 0; i < input.size(); ++i) input[i] = static_cast<float>(i) - 7.5f;
  for (const float value : input) output.push_back(2 * value);
  for (size_t i = 0; i < 2; ++i) half.push_back(2 * input[i]);
  const std::string golden = safetensors({{"forward.float32/input", {1, 3, 4, 5}, input},
                                          {"forward.float32/sigma", {1, 2}, {1, 1}},
                                          {"forward.float32/output", {1, 3, 4, 5}, output},
                                          {"forward.float32/half", {1, 2}, half}});
  write_text(bundle + "/golden.safetensors", golden);
  root["golden"]["size"] = golden.size();
  root["golden"]["sha256"] = sha256_of(golden);
  if (change) change(root);
  const std::string text = root.dump(1);
  write_text(bundle + "/manifest.json", text);
  std::vector<std::filesystem::path> unnamed;
  for (const auto& entry : std::filesystem::directory_iterator(bundle)) {
    const std::string name = entry.path().filename().string();
    if (name != "manifest.json" && text.find("\"" + name + "\"") == std::string::npos)
      unnamed.push_back(entry.path());
  }
  for (const auto& path : unnamed) std::filesystem::remove(path);
  return bundle;
}

void set_artifact(const std::string& bundle, const std::string& file, const std::string& words) {
  const std::string content = artifact_content(file, words);
  Json root = Json::parse(read_text(bundle + "/manifest.json"));
  for (auto& method : root["methods"]) {
    for (auto& entry : method["artifacts"]) {
      if (entry["file"] != file) continue;
      entry["size"] = content.size();
      entry["sha256"] = sha256_of(content);
    }
  }
  write_text(bundle + "/" + file, content);
  write_text(bundle + "/manifest.json", root.dump(1));
}

}  // namespace chiasm::testing
