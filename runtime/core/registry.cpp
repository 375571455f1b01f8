// Finds plug-ins in folders by their file names, opens them, and probes their engines once.
#include "core/registry.h"

#include <dirent.h>
#include <dlfcn.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <map>
#include <new>

#include "base/fork.h"
#include "base/library.h"
#include "core/status.h"
#include "core/struct_size.h"

namespace chiasm::core {
namespace {

constexpr const char kPrefix[] = "libchiasm_";
constexpr const char kSuffix[] = ".so";

std::string last_dl_error() {
  const char* const text = ::dlerror();
  return text == nullptr ? "unknown error of the dynamic linker" : text;
}

/** The NAME of a file libchiasm_NAME.so; "" for other files. */
std::string backend_of(const std::string& file) {
  constexpr size_t prefix = sizeof kPrefix - 1, suffix = sizeof kSuffix - 1;
  if (file.size() <= prefix + suffix || file.compare(0, prefix, kPrefix) != 0) return "";
  if (file.compare(file.size() - suffix, suffix, kSuffix) != 0) return "";
  const std::string name = file.substr(prefix, file.size() - prefix - suffix);
  return is_backend_name(name) ? name : "";
}

/** What the core needs of a plug-in's table and finds NULL; NULL if there is nothing. */
const char* missing_in(const chiasm_backend& table) {
  if (table.formats == nullptr) return "formats";
  if (table.probe == nullptr) return "probe";
  if (table.load == nullptr) return "load";
  if (table.run == nullptr) return "run";
  if (table.unload == nullptr) return "unload";
  for (const chiasm_backend_option* o = table.options; o != nullptr && o->key != nullptr; ++o) {
    if (o->values == nullptr) return "values of an option";
  }
  return nullptr;
}

/** The paths of a folder's plug-ins, by name; none if the folder cannot be read for a permanent reason. */
std::map<std::string, std::string> plugins_in(const std::string& folder) {
  std::map<std::string, std::string> found;
  const std::unique_ptr<DIR, int (*)(DIR*)> listing(::opendir(folder.c_str()), ::closedir);
  if (listing == nullptr && errno == ENOMEM) throw std::bad_alloc();
  if (listing == nullptr && (errno == EMFILE || errno == ENFILE))
    fail(CHIASM_IO_ERROR, folder + ": " + std::strerror(errno));
  while (const dirent* const entry = listing ? ::readdir(listing.get()) : nullptr) {
    const std::string name = backend_of(entry->d_name);
    if (!name.empty()) found.emplace(name, folder + "/" + entry->d_name);
  }
  return found;
}

}  // namespace

bool is_backend_name(const std::string& text) {
  const auto good = [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_'; };
  return !text.empty() && text.size() <= 64 && text[0] >= 'a' && text[0] <= 'z' &&
         std::all_of(text.begin(), text.end(), good);
}

std::vector<std::string> split_path(const char* list) {
  std::vector<std::string> parts;
  std::string part;
  for (const char* at = list == nullptr ? "" : list;; ++at) {
    if (*at != ':' && *at != '\0') {
      part += *at;
      continue;
    }
    if (!part.empty()) parts.push_back(part);
    part.clear();
    if (*at == '\0') return parts;
  }
}

Backend::Backend(std::string name, const std::string& path) : name_(std::move(name)) { open(path); }

void Backend::open(const std::string& path) {
  const auto unusable = [this](const std::string& what) {
    engine_.problem = "the " + name_ + " backend is not available: " + what;
  };
  std::string problem;
  void* const library = open_library(path.c_str(), problem);
  if (library == nullptr) return unusable(path + ": " + problem);
  void* const symbol = ::dlsym(library, CHIASM_BACKEND_ENTRY);
  if (symbol == nullptr) return unusable(path + " is not a chiasm backend: " + last_dl_error());
  const chiasm_backend* const table = reinterpret_cast<chiasm_backend_entry_fn>(symbol)(CHIASM_BACKEND_ABI);
  if (table == nullptr || table->abi != CHIASM_BACKEND_ABI ||
      table->struct_size < CHIASM_SIZE_THROUGH(chiasm_backend, unload)) {
    return unusable(path + " was built for another version of chiasm (backend interface " +
                    std::to_string(CHIASM_BACKEND_ABI) + " is needed)");
  }
  if (table->name == nullptr || name_ != table->name) {
    return unusable(path + " calls itself '" + (table->name == nullptr ? "" : table->name) + "'");
  }
  if (const char* const missing = missing_in(*table))
    return unusable(path + " is incomplete: its table has no " + missing);
  table_ = table;
}

const chiasm_backend_format* Backend::format_of(const std::string& format) const {
  if (table_ == nullptr) return nullptr;
  for (const chiasm_backend_format* f = table_->formats; f->name != nullptr; ++f) {
    if (format == f->name) return f;
  }
  return nullptr;
}

bool Backend::is_program(const std::string& format) const {
  const chiasm_backend_format* const known = format_of(format);
  return known == nullptr || known->is_program != 0;
}

bool Backend::has_option(const std::string& key) const {
  for (const chiasm_backend_option* o = table_ == nullptr ? nullptr : table_->options;
       o != nullptr && o->key != nullptr; ++o) {
    if (key == o->key) return true;
  }
  return false;
}

void Backend::check_option(const std::string& option) const {
  const size_t equals = option.find('=');
  if (equals == std::string::npos) {
    fail(CHIASM_INVALID_ARGUMENT, "load options: the option '" + option + "' is not of the form key=value");
  }
  if (has_option(option.substr(0, equals))) return;
  std::string known;
  for (const chiasm_backend_option* o = table_ == nullptr ? nullptr : table_->options;
       o != nullptr && o->key != nullptr; ++o) {
    known += (known.empty() ? "" : ", ") + std::string(o->key) + " (" + o->values + ")";
  }
  fail(CHIASM_INVALID_ARGUMENT, "load options: the " + name_ + " backend has no option '" +
                                    option.substr(0, equals) + "'; it has " +
                                    (known.empty() ? "none" : known));
}

const Backend::Engine& Backend::engine() const {
  // a fork in the middle of dlopen would leave the loader's lock held in the child
  const ForkGate::Passage passage;
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!probed_) probed_ = probe();
  return probed_ ? engine_ : without_memory_;
}

bool Backend::probe() const {
  if (table_ == nullptr) return true;
  chiasm_backend_info info{};
  info.struct_size = sizeof info;
  chiasm_error_text error;
  error.text[0] = '\0';
  const int32_t code = table_->probe(&info, &error);
  if (code != CHIASM_OK) {
    error.text[sizeof error.text - 1] = '\0';
    if (code == CHIASM_IO_ERROR) fail(CHIASM_IO_ERROR, error.text);  // may be temporary, so it is tried again
    const bool may_pass = code == CHIASM_OUT_OF_MEMORY;
    Engine& answer = may_pass ? without_memory_ : engine_;
    // callers keep references to the first text
    if (answer.problem.empty()) {
      answer.code = may_pass ? CHIASM_OUT_OF_MEMORY : CHIASM_UNAVAILABLE;
      answer.problem = "the " + name_ + " backend is not available: " +
                       (error.text[0] == '\0' ? "its probe failed" : error.text);
    }
    return !may_pass;
  }
  engine_.has_cuda = info.has_cuda == 1;
  engine_.version = info.engine_version == nullptr ? "" : info.engine_version;
  return true;
}

Registry::Registry(std::vector<std::string> folders) : folders_(std::move(folders)) {}

Registry& Registry::instance() {
  static Registry* const registry = [] {
    std::vector<std::string> folders = split_path(std::getenv("CHIASM_BACKEND_PATH"));
    const std::string own = own_folder(Links::followed);
    if (!own.empty()) folders.push_back(own + "/chiasm");
    return new Registry(std::move(folders));
  }();
  return *registry;
}

void Registry::scan() {
  backends_.clear();  // left by a scan that ran out of memory or file descriptors
  std::map<std::string, std::string> paths;
  for (const std::string& folder : folders_) paths.merge(plugins_in(folder));
  for (const auto& [name, path] : paths) backends_.push_back(std::make_unique<Backend>(name, path));
  const auto priority = [](const auto& backend) {
    return backend->table() == nullptr ? INT32_MIN : backend->table()->priority;
  };
  std::stable_sort(backends_.begin(), backends_.end(),
                   [&](const auto& a, const auto& b) { return priority(a) > priority(b); });
}

const std::vector<std::unique_ptr<Backend>>& Registry::all() {
  const ForkGate::Passage passage;  // as in Backend::engine
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!scanned_) scan();
  scanned_ = true;
  return backends_;
}

const Backend* Registry::find(const std::string& name) {
  for (const auto& backend : all()) {
    if (backend->name() == name) return backend.get();
  }
  return nullptr;
}

std::string Registry::not_found(const std::string& name) const {
  std::string searched;
  for (const std::string& folder : folders_) searched += (searched.empty() ? "" : ", ") + folder;
  return "there is no " + (kPrefix + name + kSuffix) + " in " + (searched.empty() ? "any folder" : searched) +
         "; install the backend, or name its folder in CHIASM_BACKEND_PATH";
}

}  // namespace chiasm::core
