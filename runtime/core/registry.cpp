#include "core/registry.h"

#include <dlfcn.h>
#include <unistd.h>

#include <cstdlib>

#include "core/fork.h"
#include "core/room.h"
#include "core/status.h"

namespace chiasm::core {
namespace {

/** How a user gets what a backend needs. */
constexpr const char* kAdvice[kBackendCount] = {
    "it needs no engine: install it with chiasm, or name its folder in CHIASM_BACKEND_PATH",
    "get libtorch with 'pip install torch' and put its folder site-packages/torch/lib on LD_LIBRARY_PATH",
    "get ONNX Runtime with 'pip install onnxruntime' and put its folder site-packages/onnxruntime/capi on LD_LIBRARY_PATH "
    "(with a link libonnxruntime.so.1 to the library in it), or use an onnxruntime release",
};

std::string advice(BackendKind kind) { return kAdvice[static_cast<int>(kind)]; }

/** The folder of the library that this code is in. */
std::string own_folder() {
  Dl_info info{};
  static const char kHere = 0;
  if (::dladdr(&kHere, &info) == 0 || info.dli_fname == nullptr) return "";
  char* const resolved = ::realpath(info.dli_fname, nullptr);
  std::string path = resolved == nullptr ? info.dli_fname : resolved;
  std::free(resolved);
  const size_t slash = path.rfind('/');
  return slash == std::string::npos ? "." : path.substr(0, slash);
}

/** Whether libtorch is open already or can be: its static objects end the process where an allocation fails. With its mappings they take half of this. */
constexpr size_t kTorchBytes = size_t{768} << 20;

bool has_room_for_torch() {
  if (void* const present = ::dlopen("libtorch_cpu.so", RTLD_NOW | RTLD_LOCAL | RTLD_NOLOAD)) {
    ::dlclose(present);
    return true;
  }
  return has_room(kTorchBytes);
}

std::string last_dl_error() {
  const char* const text = ::dlerror();
  return text == nullptr ? "unknown error of the dynamic linker" : text;
}

}  // namespace

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

Registry::Registry(std::vector<std::string> folders) : folders_(std::move(folders)) {
  for (int32_t i = 0; i < kBackendCount; ++i) backends_[static_cast<size_t>(i)].kind = static_cast<BackendKind>(i);
}

Registry& Registry::instance() {
  static Registry* const registry = [] {
    std::vector<std::string> folders = split_path(std::getenv("CHIASM_BACKEND_PATH"));
    const std::string own = own_folder();
    if (!own.empty()) {
      folders.push_back(own);
      folders.push_back(own + "/chiasm");
    }
    return new Registry(std::move(folders));
  }();
  return *registry;
}

const Backend& Registry::get(BackendKind kind) {
  const auto index = static_cast<size_t>(kind);
  Backend& backend = backends_[index];
  std::call_once(opened_[index], [this, &backend] {
    const ForkGate::Passage passage;  // a child could neither open a library nor begin again while its parent was opening one
    open(backend);
  });
  return backend;
}

void Registry::open(Backend& backend) const {
  const std::string file = std::string("libchiasm_") + backend.name() + ".so";
  const auto unavailable = [&backend](const std::string& what) {
    backend.problem = std::string("the ") + backend.name() + " backend is not available: " + what + "; " + advice(backend.kind);
  };
  std::string path, searched;
  for (const std::string& folder : folders_) {
    const std::string candidate = folder + "/" + file;
    if (::access(candidate.c_str(), F_OK) == 0) {
      path = candidate;
      break;
    }
    searched += (searched.empty() ? "" : ", ") + folder;
  }
  if (path.empty()) return unavailable("there is no " + file + " in " + (searched.empty() ? "any folder" : searched));

  if (backend.kind == BackendKind::torch && !has_room_for_torch())
    return unavailable("opening libtorch needs " + std::to_string(kTorchBytes) + " bytes, which the process may not have");
  void* const library = ::dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) return unavailable(path + ": " + last_dl_error());
  void* const symbol = ::dlsym(library, CHIASM_BACKEND_ENTRY);
  if (symbol == nullptr) return unavailable(path + " is not a chiasm backend: " + last_dl_error());
  const auto entry = reinterpret_cast<chiasm_backend_entry_fn>(symbol);
  const chiasm_backend* const table = entry(CHIASM_BACKEND_ABI);
  if (table == nullptr || table->abi != CHIASM_BACKEND_ABI || table->struct_size < sizeof(chiasm_backend)) {
    return unavailable(path + " was built for another version of chiasm (backend interface " +
                       std::to_string(CHIASM_BACKEND_ABI) + " is needed)");
  }
  if (table->name == nullptr || std::string(table->name) != backend.name()) {
    return unavailable(path + " calls itself '" + (table->name == nullptr ? "" : table->name) + "'");
  }
  chiasm_backend_info info{};
  info.struct_size = sizeof info;
  chiasm_error_text error;
  error.text[0] = '\0';
  if (table->probe(&info, &error) != CHIASM_OK) {
    error.text[sizeof error.text - 1] = '\0';
    return unavailable(error.text[0] == '\0' ? path + " failed its probe" : std::string(error.text));
  }
  backend.has_cuda = info.has_cuda == 1;
  backend.engine_version = info.engine_version == nullptr ? "" : info.engine_version;
  backend.table = table;
}

}  // namespace chiasm::core
