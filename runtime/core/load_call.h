/** The request that a backend gets when it ranks or loads an artifact. */
#pragma once

#include <string>
#include <vector>

#include "core/bundle.h"
#include "core/select.h"

namespace chiasm::core {

/** Owns what one chiasm_backend_load points to. The bundle, the specs and the backend must outlive it. */
class LoadCall final {
 public:
  LoadCall(const Bundle& bundle, const MethodSpec& method, const Artifact& artifact, const Backend& backend,
           const LoadRequest& request, int32_t dtype);
  LoadCall(const LoadCall&) = delete;
  LoadCall& operator=(const LoadCall&) = delete;

  /** Without the artifact's bytes. */
  const chiasm_backend_load& get() const { return load_; }
  chiasm_backend_load with(const Bytes& bytes) const;

  const std::string& path() const { return path_; }

 private:
  std::string path_, signature_;
  std::vector<const char*> inputs_, outputs_, artifact_options_, options_;
  std::vector<std::string> texts_;
  chiasm_backend_load load_{};
};

}  // namespace chiasm::core
