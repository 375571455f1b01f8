/** An open bundle: its manifest, checked. No engine is involved. */
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/file.h"
#include "core/info.h"
#include "core/manifest.h"

namespace chiasm::core {

/** Immutable once open; shared by its handle and its methods. */
class Bundle final {
 public:
  /** Throws Error: NOT_FOUND, CORRUPT, VERSION_MISMATCH. */
  explicit Bundle(const char* path);
  Bundle(const Bundle&) = delete;
  Bundle& operator=(const Bundle&) = delete;

  const Manifest& manifest() const { return manifest_; }
  const chiasm_bundle_info& info() const { return info_; }
  std::string file_path(const std::string& file) const { return path_ + "/" + file; }

  /** Throws Error (NOT_FOUND) that lists the methods there are. */
  const MethodSpec& method(const char* name) const;

  /** The artifact's bytes, checked against the manifest. */
  Bytes read(const Artifact& artifact) const { return read_checked(file_path(artifact.file), artifact.size, artifact.sha256); }

 private:
  std::string path_, text_;
  Manifest manifest_;
  std::vector<MethodInfo> methods_;
  std::vector<chiasm_method_info> method_infos_;
  chiasm_bundle_info info_{};
};

}  // namespace chiasm::core
