/** The backends of this process: plug-ins, opened when first asked for and never closed. */
#pragma once

#include <array>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "core/backend.h"
#include "core/manifest.h"

namespace chiasm::core {

/** A backend, or the reason why there is none. Lives as long as its registry. */
struct Backend {
  BackendKind kind = BackendKind::native;
  const chiasm_backend* table = nullptr; /**< NULL where the backend is not available */
  bool has_cuda = false;
  std::string engine_version;
  std::string problem; /**< "" where available */

  const char* name() const { return kBackendNames[static_cast<int>(kind)]; }
};

/** Looks for `libchiasm_<name>.so` in a list of folders. The first that is found counts, also where it cannot be opened: a
 *  broken installation is reported, not hidden by an older one. Thread-safe. */
class Registry final {
 public:
  explicit Registry(std::vector<std::string> folders);
  Registry(const Registry&) = delete;
  Registry& operator=(const Registry&) = delete;

  /** Opens the plug-in if this is the first time. Never throws for a missing one: see Backend::problem. */
  const Backend& get(BackendKind kind);

  /** The process's registry: the folders in CHIASM_BACKEND_PATH, the folder of this library, its subfolder chiasm/. */
  static Registry& instance();

 private:
  void open(Backend& backend) const;

  std::vector<std::string> folders_;
  std::array<Backend, kBackendCount> backends_;
  std::array<std::once_flag, kBackendCount> opened_;
};

/** The parts of a list that is separated by colons; empty ones are left out. */
std::vector<std::string> split_path(const char* list);

}  // namespace chiasm::core
