// Opens a bundle: reads the manifest, checks its signature if the policy requires one, then parses it and
// rejects files that it does not name.
#include "core/bundle.h"

#include "core/status.h"

namespace chiasm::core {
namespace {

constexpr const char* kManifest = "manifest.json";
constexpr const char* kSignature = "manifest.json.minisig";

/** None if there is no such file. */
std::optional<std::string> read_text(const Folder& folder, const char* name, uint64_t limit) {
  try {
    const Bytes bytes = folder.read(name, limit);
    return std::string(bytes.begin(), bytes.end());
  } catch (const Error& error) {
    if (error.code() == CHIASM_NOT_FOUND) return std::nullopt;
    throw;
  }
}

}  // namespace

Bundle::Bundle(const char* path, const Trust& trust) : path_(path) {
  while (path_.size() > 1 && path_.back() == '/') path_.pop_back();
  const Folder folder(path_);
  std::optional<std::string> text = read_text(folder, kManifest, kMaxManifestSize);
  if (!text) fail(CHIASM_CORRUPT, path_ + " is not a bundle: there is no manifest.json in it");
  text_ = std::move(*text);
  text_sha256_ = sha256(text_.data(), text_.size());
  signature_ = read_text(folder, kSignature, kMaxSignatureSize);
  check_signature(trust);  // before the manifest is parsed: its author is not yet known
  manifest_ = parse_manifest(text_, file_path(kManifest));
  std::set<std::string> files = manifest_.files;
  files.insert({kManifest, kSignature});
  folder.only(files);
  methods_.reserve(manifest_.methods.size());
  for (const MethodSpec& method : manifest_.methods) {
    methods_.emplace_back(method, manifest_.symbols, manifest_.dtypes);
    method_infos_.push_back(methods_.back().get());
  }
  info_.struct_size = sizeof info_;
  info_.name = manifest_.name.c_str();
  info_.version = manifest_.version.c_str();
  info_.summary = manifest_.summary.c_str();
  info_.path = path_.c_str();
  info_.method_count = static_cast<int32_t>(method_infos_.size());
  info_.methods = method_infos_.data();
  info_.manifest = text_.c_str();
}

void Bundle::check_signature(const Trust& trust) const {
  if (trust.policy != CHIASM_TRUST_SIGNED) return;
  if (!signature_) {
    fail(CHIASM_UNTRUSTED, path_ + ": is not signed, and the trust policy is 'signed': there is no " +
                               kSignature + " in it (`chiasm sign` makes one)");
  }
  verify_signature(text_, *signature_, trust.keys, file_path(kSignature));
}

void Bundle::check_trust(const Trust& trust) const {
  check_signature(trust);
  if (trust.policy != CHIASM_TRUST_SIGNED) return;
  for (const BundleFile& document : manifest_.documents) read(document);
}

const MethodSpec& Bundle::method(const char* name) const {
  std::string all;
  for (const MethodSpec& method : manifest_.methods) {
    if (method.name == name) return method;
    all += (all.empty() ? "" : ", ") + method.name;
  }
  fail(CHIASM_NOT_FOUND, path_ + " has no method '" + name + "'; it has " + all);
}

}  // namespace chiasm::core
