/** An open bundle: its manifest, checked. No engine is involved. */
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/file.h"
#include "core/info.h"
#include "core/manifest.h"
#include "core/trust.h"

namespace chiasm::core {

/** Immutable once open; shared by its handle and its methods. */
class Bundle final {
 public:
  /** Throws Error: NOT_FOUND, CORRUPT, VERSION_MISMATCH, UNTRUSTED, OUT_OF_MEMORY, IO_ERROR. */
  Bundle(const char* path, const Trust& trust);
  Bundle(const Bundle&) = delete;
  Bundle& operator=(const Bundle&) = delete;

  const Manifest& manifest() const { return manifest_; }
  const chiasm_bundle_info& info() const { return info_; }
  /** Of the manifest as it was read. It identifies every file of the bundle, whose hashes the manifest
   *  holds. */
  const std::string& manifest_sha256() const { return text_sha256_; }
  std::string file_path(const std::string& file) const { return path_ + "/" + file; }

  /** Throws Error (NOT_FOUND) that lists the bundle's methods. */
  const MethodSpec& method(const char* name) const;

  /** The file's bytes, checked against the manifest. */
  Bytes read(const BundleFile& file) const {
    return Folder(path_).read_checked(file.file, file.size, file.sha256);
  }

  /** To be called before any code of the bundle runs. Throws Error: UNTRUSTED, or the error of a damaged
   *  document. */
  void check_trust(const Trust& trust) const;

 private:
  void check_signature(const Trust& trust) const;

  std::string path_, text_, text_sha256_;
  /** read together with the manifest, so that both are of one version */
  std::optional<std::string> signature_;
  Manifest manifest_;
  std::vector<MethodInfo> methods_;
  std::vector<chiasm_method_info> method_infos_;
  chiasm_bundle_info info_{};
};

}  // namespace chiasm::core
