// libchiasm_ort.so: a custom-op library of ONNX Runtime. Where it is registered with a session, the nodes `chiasm::<function>`
// of fused models run native code; elsewhere ONNX Runtime runs the functions' bodies.
//
// It serves the bundles that the session's configuration entry `chiasm.bundles` names (folders, separated by colons), or
// where there is no such entry, those in the folder that this library is in: for servers that take a library's name and no more.
#include <dirent.h>
#include <dlfcn.h>

#include <algorithm>
#include <cstdio>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "backends/plugin.h"
#include "core/registry.h"
#include "core/status.h"
#include "ort/kernel.h"
#include "ort/node.h"

namespace chiasm::ort {
namespace {

constexpr uint32_t kOldestInterface = 17;
constexpr const char* kEntry = "chiasm.bundles";
constexpr const char* kDomain = "chiasm";

/** Links are not followed: a link to this library, put beside bundles, serves those. */
std::string folder_of_this_library() {
  Dl_info info{};
  if (dladdr(reinterpret_cast<const void*>(&folder_of_this_library), &info) == 0) return ".";
  const std::string path = info.dli_fname;
  const size_t slash = path.rfind('/');
  return slash == std::string::npos ? "." : path.substr(0, slash);
}

std::vector<std::string> bundles_beside_this_library() {
  const std::string folder = folder_of_this_library(), suffix = ".chiasm";
  std::vector<std::string> found;
  const std::unique_ptr<DIR, int (*)(DIR*)> listing(opendir(folder.c_str()), closedir);
  if (!listing) return found;
  while (const dirent* entry = readdir(listing.get())) {
    const std::string name = entry->d_name;
    if (name.size() > suffix.size() && name.compare(name.size() - suffix.size(), suffix.size(), suffix) == 0)
      found.push_back(folder + "/" + name);
  }
  std::sort(found.begin(), found.end());
  return found;
}

std::vector<std::string> wanted_bundles(const OrtApi& api, const OrtSessionOptions* options) {
  int present = 0;
  check(api.HasSessionConfigEntry(options, kEntry, &present));
  if (present == 0) return bundles_beside_this_library();
  size_t size = 0;
  check(api.GetSessionConfigEntry(options, kEntry, nullptr, &size));
  std::string value(size, '\0');
  check(api.GetSessionConfigEntry(options, kEntry, value.data(), &size));
  return core::split_path(value.c_str());
}

/** The operators of a list of bundles, in one domain. */
struct Domain {
  std::vector<std::unique_ptr<Node>> nodes;
  OrtCustomOpDomain* handle = nullptr;
  std::string report;
};

std::unique_ptr<Domain> make_domain(const OrtApi& api, const std::vector<std::string>& bundles) {
  auto domain = std::make_unique<Domain>();
  std::map<std::string, std::string> owners;
  for (const std::string& bundle : bundles) {
    for (auto& node : nodes_of(api, bundle, domain->report)) {
      const auto [owner, is_new] = owners.emplace(node->function, bundle);
      if (!is_new && owner->second != bundle)
        core::fail(CHIASM_INVALID_ARGUMENT, "both " + owner->second + " and " + bundle + " have the function " + node->function);
      domain->nodes.push_back(std::move(node));
    }
  }
  check(api.CreateCustomOpDomain(kDomain, &domain->handle));
  for (const auto& node : domain->nodes) check(api.CustomOpDomain_Add(domain->handle, node.get()));
  return domain;
}

void add_domain(const OrtApi& api, OrtSessionOptions* options) {
  const std::vector<std::string> bundles = wanted_bundles(api, options);
  // Sessions keep pointers into a domain and do not say when they end, so each is made once and kept. What a session needs of
  // a bundle is only its manifest; the code is a kernel's, and goes with the session. Never destroyed, like ONNX Runtime's own.
  static std::mutex& mutex = *new std::mutex;
  static auto& domains = *new std::map<std::pair<const OrtApi*, std::string>, std::unique_ptr<Domain>>;
  std::string key;
  for (const std::string& bundle : bundles) {
    const core::Bytes manifest = core::read_file(bundle + "/manifest.json", core::kMaxManifestSize);
    key += bundle + "=" + core::sha256(manifest.data(), manifest.size()) + "\n";
  }
  const std::lock_guard<std::mutex> lock(mutex);
  auto& domain = domains[{&api, key}];
  if (domain == nullptr) domain = make_domain(api, bundles);
  std::fputs(domain->report.c_str(), stderr);
  if (!domain->nodes.empty()) check(api.AddCustomOpDomain(options, domain->handle));
}

}  // namespace
}  // namespace chiasm::ort

extern "C" CHIASM_EXPORT OrtStatus* ORT_API_CALL RegisterCustomOps(OrtSessionOptions* options, const OrtApiBase* base) {
  const OrtApi* api = base->GetApi(chiasm::ort::kOldestInterface);
  if (api == nullptr) return base->GetApi(1)->CreateStatus(ORT_NOT_IMPLEMENTED, "chiasm: ONNX Runtime is too old: expected 1.17 or later");
  try {
    chiasm::ort::add_domain(*api, options);
    return nullptr;
  } catch (...) {
    return chiasm::ort::status_from_current_exception(*api);
  }
}
