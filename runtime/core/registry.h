/** The backends of this process: plug-ins, found in folders by their file names, opened at the first need,
 *  never closed. */
#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "chiasm/backend.h"

namespace chiasm::core {

/** A backend that was found, or the reason why it cannot be used. Lives as long as its registry. */
class Backend final {
 public:
  /** Opens the plug-in, not its engine. Never throws for a bad one: see `engine().problem`; throws for lack
   *  of memory or descriptors. */
  Backend(std::string name, const std::string& path);

  const std::string& name() const { return name_; }
  /** NULL if the library is no plug-in that this core can use. */
  const chiasm_backend* table() const { return table_; }

  bool loads(const std::string& format) const { return format_of(format) != nullptr; }
  /** Whether loading an artifact of that format runs code that came with the bundle. */
  bool is_program(const std::string& format) const;
  bool has_device(int32_t device_type) const {
    return table_ != nullptr && (table_->devices >> device_type & 1u) != 0;
  }
  bool has_option(const std::string& key) const;
  /** Throws Error (INVALID_ARGUMENT) if `option` is not "key=value" with a key that this backend knows. */
  void check_option(const std::string& option) const;

  /** The engine's description of itself. The first call opens the engine, which may take long. */
  struct Engine {
    bool has_cuda = false;
    std::string version;
    std::string problem;                   /**< "" if the backend can be used */
    chiasm_code code = CHIASM_UNAVAILABLE; /**< the kind of problem */
  };
  const Engine& engine() const;

 private:
  const chiasm_backend_format* format_of(const std::string& format) const;
  void open(const std::string& path);
  /** False if there was no memory: the next call tries again. */
  bool probe() const;

  std::string name_;
  const chiasm_backend* table_ = nullptr;
  mutable Engine engine_;
  mutable Engine without_memory_; /**< returned until there is memory; written once */
  // Not std::call_once: if no memory is left, glibc's part of it ends the process.
  mutable std::mutex mutex_;
  mutable bool probed_ = false;
};

/** Finds `libchiasm_<name>.so` in a list of folders. If several have the same name, the first one counts,
 *  even if it cannot be opened: a broken installation is reported, not hidden by an older one.
 *  Thread-safe. */
class Registry final {
 public:
  explicit Registry(std::vector<std::string> folders);
  Registry(const Registry&) = delete;
  Registry& operator=(const Registry&) = delete;

  /** The backends that were found, in the order in which `auto` tries them: by priority, then by name. The
   *  first call opens all plug-ins. */
  const std::vector<std::unique_ptr<Backend>>& all();
  /** NULL if there is no backend of that name. */
  const Backend* find(const std::string& name);
  /** A sentence that says where `libchiasm_<name>.so` was looked for. */
  std::string not_found(const std::string& name) const;

  /** The process's registry: the folders in CHIASM_BACKEND_PATH, then chiasm/ beside this library. */
  static Registry& instance();

 private:
  void scan();

  std::vector<std::string> folders_;
  std::vector<std::unique_ptr<Backend>> backends_;
  std::mutex mutex_;  // as in Backend
  bool scanned_ = false;
};

/** Whether `text` may be a backend's name: 1 to 64 lower-case letters, digits and underscores, the first a
 *  letter. */
bool is_backend_name(const std::string& text);

/** The non-empty parts of a colon-separated list. */
std::vector<std::string> split_path(const char* list);

}  // namespace chiasm::core
