// libchiasm_ort.so: a custom-op library of ONNX Runtime. In a session that registers it, the nodes
// `chiasm::<function>` of fused models run native code; in other sessions ONNX Runtime runs the functions'
// bodies.
//
// It serves the bundles that the session's configuration entry `chiasm.bundles` names (folders, separated by
// colons), or without such an entry, those in the folder of this library: for servers that accept only the
// name of a library. It follows the process's trust policy (docs/signing.md).
#include <dirent.h>
#include <dlfcn.h>
#include <cstring>

#include <algorithm>
#include <cstdio>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "backends/plugin.h"
#include "base/library.h"
#include "core/registry.h"
#include "core/select.h"
#include "core/status.h"
#include "ort/kernel.h"
#include "ort/node.h"

namespace chiasm::ort {
namespace {

constexpr uint32_t kOldestInterface = 17;
constexpr const char* kEntry = "chiasm.bundles";
/** Set by chiasm's own onnx backend: the hash of the manifest that it was given. */
constexpr const char* kCheckedEntry = "chiasm.checked";
constexpr const char* kDomain = "chiasm";

/** Links are not followed, so that a link to this library serves the bundles beside the link. */
std::vector<std::string> bundles_beside_this_library() {
  const std::string folder = base::own_folder(base::Links::kept), suffix = ".chiasm";
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

/** None if the session has no such entry. */
std::optional<std::string> entry_of(const OrtApi& api, const OrtSessionOptions* options, const char* name) {
  int present = 0;
  check(api.HasSessionConfigEntry(options, name, &present));
  if (present == 0) return std::nullopt;
  size_t size = 0;
  check(api.GetSessionConfigEntry(options, name, nullptr, &size));
  std::string value(size, '\0');
  check(api.GetSessionConfigEntry(options, name, value.data(), &size));
  value.resize(std::strlen(value.c_str()));  // without the NUL at the end, which the size includes
  return value;
}

std::vector<std::string> wanted_bundles(const OrtApi& api, const OrtSessionOptions* options) {
  const std::optional<std::string> entry = entry_of(api, options, kEntry);
  return entry ? core::split_path(entry->c_str()) : bundles_beside_this_library();
}

/** The trust policy of libchiasm if the program has loaded it, since it may have set one; else the
 *  environment's. */
core::Trust trust_of_process() {
  const std::unique_ptr<void, int (*)(void*)> library(
      dlopen(CHIASM_SONAME, RTLD_LAZY | RTLD_LOCAL | RTLD_NOLOAD), dlclose);
  const auto get_api =
      library ? reinterpret_cast<decltype(&chiasm_get_api)>(dlsym(library.get(), "chiasm_get_api")) : nullptr;
  const chiasm_api* const chiasm = get_api == nullptr ? nullptr : get_api(CHIASM_API_VERSION);
  if (chiasm == nullptr) return core::use_trust();
  core::Trust trust;
  const char* const* keys = nullptr;
  size_t key_count = 0;
  const std::unique_ptr<chiasm_status, void (*)(chiasm_status*)> status(
      chiasm->get_trust(&trust.policy, &keys, &key_count), chiasm->status_free);
  if (status)
    core::fail(static_cast<chiasm_code>(chiasm->status_code(status.get())),
               chiasm->status_message(status.get()));
  for (size_t i = 0; i < key_count; ++i)
    trust.keys.push_back(core::read_public_key(keys[i], "a trusted key"));
  return trust;
}

using Bundles = std::vector<std::shared_ptr<const core::Bundle>>;

/** Opens the bundles and checks that they may be run: by the policy and, if `checked` is given, by the hash
 *  of their manifest. */
Bundles open_bundles(const std::vector<std::string>& paths, const core::Trust& trust,
                     const std::optional<std::string>& checked) {
  Bundles bundles;
  for (const std::string& path : paths) {
    auto bundle = std::make_shared<const core::Bundle>(path.c_str(), trust);
    bundle->check_trust(trust);
    if (checked && bundle->manifest_sha256() != *checked) {
      core::fail(CHIASM_UNTRUSTED, path + ": its manifest was changed while the bundle was loaded");
    }
    bundles.push_back(std::move(bundle));
  }
  return bundles;
}

/** The operators of a list of bundles, in one domain. */
struct Domain {
  std::vector<std::unique_ptr<Node>> nodes;
  OrtCustomOpDomain* handle = nullptr;
  std::string report;
};

std::unique_ptr<Domain> make_domain(const OrtApi& api, const Bundles& bundles,
                                    const core::LoadRequest& request) {
  auto domain = std::make_unique<Domain>();
  std::map<std::string, std::string> owners;
  for (const auto& bundle : bundles) {
    const std::string path = bundle->info().path;
    for (auto& node : nodes_of(api, bundle, request, domain->report)) {
      const auto [owner, is_new] = owners.emplace(node->function, path);
      if (!is_new && owner->second != path)
        core::fail(CHIASM_INVALID_ARGUMENT,
                   "both " + owner->second + " and " + path + " have the function " + node->function);
      domain->nodes.push_back(std::move(node));
    }
  }
  check(api.CreateCustomOpDomain(kDomain, &domain->handle));
  try {
    for (const auto& node : domain->nodes) check(api.CustomOpDomain_Add(domain->handle, node.get()));
  } catch (...) {
    api.ReleaseCustomOpDomain(domain->handle);
    throw;
  }
  return domain;
}

void add_domain(const OrtApi& api, OrtSessionOptions* options) {
  const std::optional<std::string> checked = entry_of(api, options, kCheckedEntry);
  const core::Trust trust = trust_of_process();
  const Bundles bundles = open_bundles(wanted_bundles(api, options), trust, checked);
  const core::LoadRequest request = core::under(trust, {});
  // Sessions keep pointers into a domain and do not say when they end, so each is made once and kept. A
  // domain needs only the manifest of a bundle; the code belongs to a kernel and is freed with its session.
  // Never destroyed, like ONNX Runtime's own domains.
  static std::mutex& mutex = *new std::mutex;
  static auto& domains = *new std::map<std::pair<const OrtApi*, std::string>, std::unique_ptr<Domain>>;
  std::string key = request.programs_refused() + "\n";
  for (const auto& bundle : bundles) key += bundle->info().path + ("=" + bundle->manifest_sha256()) + "\n";
  const std::lock_guard<std::mutex> lock(mutex);
  auto& domain = domains[{&api, key}];
  if (domain == nullptr) domain = make_domain(api, bundles, request);
  // chiasm's own backend then loads another artifact. A program that registers this library itself gets the
  // report.
  if (checked && !domain->report.empty()) core::fail(CHIASM_UNAVAILABLE, domain->report);
  std::fputs(domain->report.c_str(), stderr);
  if (!domain->nodes.empty()) check(api.AddCustomOpDomain(options, domain->handle));
}

}  // namespace
}  // namespace chiasm::ort

extern "C" CHIASM_EXPORT OrtStatus* ORT_API_CALL RegisterCustomOps(OrtSessionOptions* options,
                                                                   const OrtApiBase* base) {
  const OrtApi* api = base->GetApi(chiasm::ort::kOldestInterface);
  if (api == nullptr)
    return base->GetApi(1)->CreateStatus(ORT_NOT_IMPLEMENTED,
                                         "chiasm: ONNX Runtime is too old: expected 1.17 or later");
  try {
    chiasm::ort::add_domain(*api, options);
    return nullptr;
  } catch (...) {
    return chiasm::ort::status_from_current_exception(*api);
  }
}
