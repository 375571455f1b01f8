/** Damages a real bundle: the input is a list of changes, after which the bundle is opened, loaded, run and
 *  tested on backends without an engine. A bundle that opens under the policy 'signed' must have exactly the
 *  signed manifest. */
#include <fuzzer/FuzzedDataProvider.h>
#include <sodium.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>

#include "chiasm/chiasm.hpp"
#include "core/bundle.h"
#include "core/status.h"
#include "support.h"

namespace {

using namespace chiasm;
using Json = nlohmann::json;
namespace fs = std::filesystem;

constexpr size_t kMostValues = 1 << 16;  // in an input of a run

/** The bundle's files during the changes. */
struct Damaged {
  std::map<std::string, std::string> files = fuzz::seed_bundle();
  std::map<std::string, std::string> links;
  std::set<std::string> signed_manifests;
};

std::string name_of(FuzzedDataProvider& input, const Damaged& bundle) {
  const auto index = input.ConsumeIntegralInRange<size_t>(0, bundle.files.size());
  auto file = bundle.files.begin();
  for (size_t i = 0; i < index && file != bundle.files.end(); ++i) ++file;
  return file == bundle.files.end() ? input.ConsumeRandomLengthString(20) : file->first;
}

Json value_of(FuzzedDataProvider& input) {
  static const Json kValues[] = {nullptr,
                                 true,
                                 -1,
                                 0,
                                 1,
                                 2,
                                 3,
                                 64,
                                 4096,
                                 INT64_MAX,
                                 INT64_MIN,
                                 UINT64_MAX,
                                 int64_t{1} << 40,
                                 1e300,
                                 -0.5,
                                 "",
                                 "T",
                                 "H",
                                 "B*H",
                                 "H//0",
                                 "-H",
                                 "H*H*H*H*H",
                                 "float32",
                                 "uint8",
                                 "native",
                                 "torch",
                                 "onnx",
                                 "forward.pt",
                                 "manifest.json",
                                 "../x",
                                 Json::array(),
                                 Json::object(),
                                 {1, 2, 3},
                                 {"H", "W"}};
  const auto index = input.ConsumeIntegralInRange<size_t>(0, std::size(kValues));
  return index < std::size(kValues) ? kValues[index] : Json(input.ConsumeRandomLengthString(24));
}

/** Changes or removes a value at one of the manifest's places. */
void edit_manifest(FuzzedDataProvider& input, std::string& text) {
  Json root = Json::parse(text, nullptr, false);
  if (root.is_discarded() || !root.is_structured()) return;
  Json* node = &root;
  for (int depth = 0; depth < 12; ++depth) {
    const auto index = input.ConsumeIntegralInRange<size_t>(0, node->size());
    if (index == node->size()) break;  // here
    auto child = node->begin();
    std::advance(child, index);
    if (child->is_structured() && !child->empty()) {
      node = &*child;
      continue;
    }
    if (input.ConsumeBool())
      *child = value_of(input);
    else
      node->erase(child);
    text = root.dump(-1, ' ', false, Json::error_handler_t::replace);
    return;
  }
  if (node->is_object())
    (*node)[input.ConsumeRandomLengthString(12)] = value_of(input);
  else
    node->push_back(node->empty() || input.ConsumeBool() ? value_of(input) : node->front());
  text = root.dump(-1, ' ', false, Json::error_handler_t::replace);
}

/** Updates sizes and hashes to match the files, so that later code is reached. */
void fit_hashes(Damaged& bundle) {
  std::string& text = bundle.files["manifest.json"];
  Json root = Json::parse(text, nullptr, false);
  if (root.is_discarded()) return;
  const std::function<void(Json&)> fit = [&](Json& node) {
    if (node.is_object() && node.contains("file") && node["file"].is_string()) {
      const auto file = bundle.files.find(node["file"].get<std::string>());
      if (file != bundle.files.end()) {
        node["size"] = file->second.size();
        node["sha256"] = core::sha256(file->second.data(), file->second.size());
      }
    }
    if (node.is_structured())
      for (Json& child : node) fit(child);
  };
  fit(root);
  text = root.dump(-1, ' ', false, Json::error_handler_t::replace);
}

const core::PublicKey& signing_key(std::array<unsigned char, 64>& secret) {
  static core::PublicKey key{{1, 2, 3, 4, 5, 6, 7, 8}, {}};
  const unsigned char seed[32] = {42};
  crypto_sign_seed_keypair(key.key.data(), secret.data(), seed);
  return key;
}

std::string base64(const std::string& bytes) {
  std::string text(sodium_base64_ENCODED_LEN(bytes.size(), sodium_base64_VARIANT_ORIGINAL), '\0');
  sodium_bin2base64(text.data(), text.size(), reinterpret_cast<const unsigned char*>(bytes.data()),
                    bytes.size(), sodium_base64_VARIANT_ORIGINAL);
  text.pop_back();
  return text;
}

void sign(Damaged& bundle) {
  std::array<unsigned char, 64> secret;
  const core::PublicKey& key = signing_key(secret);
  const auto raw = [&](const std::string& message) {
    const auto made = core::sign(message, secret);
    return std::string(made.begin(), made.end());
  };
  const std::string& manifest = bundle.files["manifest.json"];
  const std::string signature = raw(manifest);
  bundle.files["manifest.json.minisig"] =
      "untrusted comment: \n" + base64("Ed" + std::string(key.id.begin(), key.id.end()) + signature) +
      "\ntrusted comment: \n" + base64(raw(signature)) + "\n";
  bundle.signed_manifests.insert(manifest);
}

void damage(FuzzedDataProvider& input, Damaged& bundle) {
  static const char* const kTargets[] = {
      "forward.float32.onnx", "../outside", "/dev/zero", "/etc/passwd", "nothing", "manifest.json", "."};
  switch (input.ConsumeIntegralInRange<int>(0, 9)) {
    case 0: {
      std::string& file = bundle.files[name_of(input, bundle)];
      const std::string bytes = input.ConsumeRandomLengthString(16);
      const auto at = input.ConsumeIntegralInRange<size_t>(0, file.size());
      file.replace(at, input.ConsumeBool() ? bytes.size() : 0, bytes);
      break;
    }
    case 1: {
      std::string& file = bundle.files[name_of(input, bundle)];
      file.resize(input.ConsumeIntegralInRange<size_t>(0, file.size()));
      break;
    }
    case 2: bundle.files.erase(name_of(input, bundle)); break;
    case 3: bundle.links[name_of(input, bundle)] = input.PickValueInArray(kTargets); break;
    case 4: bundle.files[name_of(input, bundle)] = bundle.files[name_of(input, bundle)]; break;
    case 5: fit_hashes(bundle); break;
    case 6: sign(bundle); break;
    default: edit_manifest(input, bundle.files["manifest.json"]);
  }
}

void write(const Damaged& bundle, const std::string& folder) {
  const auto fits = [](const std::string& name) {
    return !name.empty() && name.find('/') == std::string::npos && name.find('\0') == std::string::npos;
  };
  for (const auto& [name, content] : bundle.files) {
    if (fits(name) && bundle.links.count(name) == 0) fuzz::write_file(folder + "/" + name, content);
  }
  for (const auto& [name, target] : bundle.links) {
    if (fits(name) && ::symlink(target.c_str(), (folder + "/" + name).c_str()) != 0)
      continue;  // skip "." and ".."
  }
}

void run(const Method& method) {
  const MethodInfo info = method.info();
  std::vector<std::vector<double>> memory;
  std::vector<Tensor> inputs;
  for (const TensorInfo& tensor : info.inputs) {
    std::vector<int64_t> shape;
    size_t values = 1;
    for (const DimInfo& dim : tensor.dims) {
      shape.push_back(dim.min);
      if (dim.min > static_cast<int64_t>(kMostValues) ||
          (values *= static_cast<size_t>(dim.min)) > kMostValues)
        return;
    }
    memory.emplace_back(values + 1);
    inputs.emplace_back(static_cast<void*>(memory.back().data()), tensor.dtypes.at(0),
                        Shape(shape.data(), shape.size()));
  }
  const Outputs outputs = method.run(inputs);
  for (size_t i = 0; i < outputs.size(); ++i) static_cast<void>(outputs[i].shape());
}

void use(const std::string& folder, FuzzedDataProvider& input) {
  try {
    const Bundle bundle = Bundle::open(folder);
    static const char* const kBackends[] = {"auto", "native", "torch", "onnx"};
    LoadOptions options;
    options.backend = input.PickValueInArray(kBackends);
    options.fused = input.ConsumeBool();
    options.warm_up = input.ConsumeIntegralInRange(0, 7) == 0;
    for (const MethodInfo& info : bundle.methods()) {
      try {
        run(bundle.method(info.name, options));
      } catch (const Error&) {}
    }
    bundle.self_test(options);
  } catch (const Error&) {}
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  fuzz::use_fake_backends();
  fuzz::write_file(fuzz::scratch_folder() + "/outside", "x");
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  FuzzedDataProvider input(data, size);
  Damaged bundle;
  for (int i = 0; i < 16 && input.remaining_bytes() > 2; ++i) damage(input, bundle);
  const std::string folder = fuzz::fresh_folder("b.chiasm");
  write(bundle, folder);
  use(folder, input);
  try {
    std::array<unsigned char, 64> secret;
    const core::Bundle opened(folder.c_str(), {CHIASM_TRUST_SIGNED, {signing_key(secret)}});
    if (bundle.signed_manifests.count(opened.info().manifest) == 0) std::abort();
  } catch (const core::Error&) {}
  return 0;
}
