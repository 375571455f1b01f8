// The torch backend's plug-in. Like every plug-in, it must open without its engine: only the library
// chiasm_torch_engine.so beside it uses libtorch, and the first probe opens that library.
#include <dlfcn.h>
#include <unistd.h>

#include <cerrno>
#include <climits>
#include <cstring>
#include <string>

#include "backends/limits.h"
#include "backends/plugin.h"
#include "base/library.h"

namespace {

using chiasm::base::Error;
using chiasm::plugin::guard;

constexpr const char* kEngine = "chiasm_torch_engine.so";
constexpr const char* kAdvice =
    "get libtorch with 'pip install torch' and put its folder site-packages/torch/lib on LD_LIBRARY_PATH";

/** The memory that must be free to open libtorch: twice what its mappings and static objects take, because
 *  they end the process if an allocation fails. */
constexpr size_t kLibtorchBytes = size_t{768} << 20;

bool is_open(const char* library) {
  void* const present = dlopen(library, RTLD_NOW | RTLD_LOCAL | RTLD_NOLOAD);
  if (present != nullptr) dlclose(present);
  return present != nullptr;
}

/** Throws if the current folder was deleted: MKL, a part of libtorch, would end the process. */
void require_folder() {
  char folder[PATH_MAX];
  if (getcwd(folder, sizeof folder) == nullptr)
    throw Error(CHIASM_UNAVAILABLE, std::string("the current folder is not there (") + std::strerror(errno) +
                                        "), and libtorch opens in no such one: change to another first");
}

const chiasm_backend& open_engine() {
  if (!is_open("libtorch_cpu.so")) {
    chiasm::plugin::require_memory(kLibtorchBytes, "opening libtorch");
    require_folder();
  }
  const std::string path = chiasm::base::own_folder(chiasm::base::Links::kept) + "/" + kEngine;
  std::string problem;
  void* const library = chiasm::base::open_library(path.c_str(), problem);
  if (library == nullptr) throw Error(CHIASM_UNAVAILABLE, problem + "; " + kAdvice);
  const auto entry = reinterpret_cast<chiasm_backend_entry_fn>(dlsym(library, CHIASM_BACKEND_ENTRY));
  const chiasm_backend* const table = entry == nullptr ? nullptr : entry(CHIASM_BACKEND_ABI);
  if (table == nullptr) throw Error(CHIASM_UNAVAILABLE, path + " was built for another version of chiasm");
  return *table;
}

/** Never closed: libtorch does not survive it. Throws Error if it cannot be opened. */
const chiasm_backend& engine() {
  static const chiasm_backend& table = open_engine();
  return table;
}

int32_t probe(chiasm_backend_info* info, chiasm_error_text* error) {
  int32_t result = CHIASM_OK;
  const int32_t opened = guard(error, [&] { result = engine().probe(info, error); });
  return opened == CHIASM_OK ? result : opened;
}

int32_t load(const chiasm_backend_load* request, void** model, chiasm_error_text* error) {
  return engine().load(request, model, error);
}

int32_t run(void* model, const chiasm_tensor* inputs, const chiasm_tensor* outputs,
            const chiasm_run_options* options, chiasm_error_text* error) {
  return engine().run(model, inputs, outputs, options, error);
}

void unload(void* model) { engine().unload(model); }

constexpr chiasm_backend_format kFormats[] = {{"torchscript", 1}, {"aotinductor", 1}, {nullptr, 0}};
constexpr chiasm_backend_option kOptions[] = {{nullptr, nullptr, nullptr}};
constexpr int32_t kPriority = 200;

const chiasm_backend backend{sizeof(chiasm_backend),
                             CHIASM_BACKEND_ABI,
                             "torch",
                             kPriority,
                             kFormats,
                             1u << CHIASM_CPU | 1u << CHIASM_CUDA,
                             kOptions,
                             probe,
                             nullptr,
                             load,
                             run,
                             unload};

}  // namespace

extern "C" CHIASM_EXPORT const chiasm_backend* chiasm_backend_entry(uint32_t abi) {
  return abi == CHIASM_BACKEND_ABI ? &backend : nullptr;
}
