#include "backends/onnx/engine.h"

#include <dlfcn.h>
#include <execinfo.h>
#include <stdlib.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <thread>

#include "backends/limits.h"
#include "backends/plugin.h"
#include "base/fork.h"
#include "base/library.h"
#include "base/signals.h"

namespace chiasm::onnx {
namespace {

using base::Error;
using plugin::require_memory;

constexpr uint32_t kOldestApi = 17;

// The memory that must be free to start ONNX Runtime. The schemas of all operators take a third of it.
constexpr size_t kStartBytes = size_t{96} << 20;

void* open_library() {
  constexpr const char* name = "libonnxruntime.so.1";
  if (void* present = dlopen(name, RTLD_NOW | RTLD_LOCAL | RTLD_NOLOAD)) return present;
  std::string problem;
  const char* chosen = std::getenv("CHIASM_ONNXRUNTIME_LIBRARY");
  if (chosen != nullptr && chosen[0] != '\0') {
    if (void* library = base::open_library(chosen, problem)) return library;
    problem += "; ";
  }
  std::string by_name;
  if (void* library = base::open_library(name, by_name)) return library;
  throw Error(CHIASM_UNAVAILABLE, "ONNX Runtime is not found (" + problem + by_name +
                                      "): get it with 'pip install onnxruntime' and name its library, "
                                      "site-packages/onnxruntime/capi/libonnxruntime.so.<version>, in "
                                      "CHIASM_ONNXRUNTIME_LIBRARY, or use an onnxruntime release");
}

// Never closed: ONNX Runtime's threads and static objects do not survive it.
std::string open_and_initialise() {
  require_memory(kStartBytes, "opening ONNX Runtime");
  // ONNX Runtime records the stack with each error. The first time, this loads a library, and if there is no
  // memory for it, the process ends.
  void* frame = nullptr;
  backtrace(&frame, 1);
  void* library = open_library();
  const auto get_base = reinterpret_cast<const OrtApiBase* (*)()>(dlsym(library, "OrtGetApiBase"));
  if (get_base == nullptr) throw Error(CHIASM_UNAVAILABLE, "the ONNX Runtime library has no OrtGetApiBase");
  const OrtApiBase* base = get_base();
  std::string version = base->GetVersionString();
  // Version 1.N has the tables up to N. Asking for a newer one would print a complaint.
  unsigned minor = 0;
  if (std::sscanf(version.c_str(), "1.%u", &minor) != 1 || minor < kOldestApi)
    throw Error(CHIASM_UNAVAILABLE, "ONNX Runtime " + version + " is too old: expected 1." +
                                        std::to_string(kOldestApi) + " or later");
  const OrtApi* api = base->GetApi(std::min<uint32_t>(minor, ORT_API_VERSION));
  if (api == nullptr)
    throw Error(CHIASM_UNAVAILABLE, "ONNX Runtime " + version + " does not offer its own C API");
  Ort::InitApi(api);
  return version;
}

// At exit ONNX Runtime destroys its pool, and waits for ever in a child of fork: the condition variable still
// counts the parent's workers. Such a child flushes its streams and leaves without the exit handlers that
// were registered before ONNX Runtime was opened.
void leave_child(int status, void* generation) {
  if (base::ForkGate::generation() == static_cast<uint32_t>(reinterpret_cast<uintptr_t>(generation))) return;
  std::fflush(nullptr);
  _exit(status);
}

// Spinning threads would hold every core between two frames, so it is off.
Ort::Env make_environment(int32_t num_threads) {
  // If a thread of the pool cannot be created, ONNX Runtime waits for ever. It creates one more, for itself.
  const int32_t workers = std::max(plugin::threads_left(num_threads) - 1, 0);
  // It ends the process if an allocation fails, even if only for the moment in which a new thread maps its
  // arena.
  require_memory(kStartBytes + static_cast<size_t>(2 + workers) * plugin::kArenaBytes,
                 "starting ONNX Runtime");
  Ort::ThreadingOptions threads;
  threads.SetGlobalIntraOpNumThreads(1 + workers).SetGlobalInterOpNumThreads(1).SetGlobalSpinControl(0);
  threads.SetGlobalCustomCreateThreadFn(begin_thread).SetGlobalCustomJoinThreadFn(join_thread);
  // The statuses carry the errors; a lower level would also print them.
  Ort::Env env(threads, ORT_LOGGING_LEVEL_FATAL, "chiasm");
  env.DisableTelemetryEvents();
  constexpr int same_as_requested = 1;  // the default doubles what it holds
  const Ort::ArenaCfg arena(0, same_as_requested, -1, -1);
  env.CreateAndRegisterAllocator(Ort::MemoryInfo::CreateCpu(OrtArenaAllocator, OrtMemTypeDefault), arena);
  if (workers > 0) on_exit(leave_child, reinterpret_cast<void*>(uintptr_t{base::ForkGate::generation()}));
  return env;
}

}  // namespace

namespace {

struct Thread {
  std::thread thread;
  uint32_t generation;
};

}  // namespace

OrtCustomThreadHandle begin_thread(void* /*options*/, OrtThreadWorkerFn work, void* argument) noexcept {
  try {
    auto thread = std::make_unique<Thread>();
    thread->generation = base::ForkGate::generation();
    const base::SignalsBlocked blocked;
    thread->thread = std::thread([work, argument] {
      const base::ForkGate::Worker worker;
      work(argument);
    });
    return reinterpret_cast<OrtCustomThreadHandle>(thread.release());
  } catch (const std::exception&) {
    return nullptr;  // ONNX Runtime reports that it could not create a thread
  }
}

void join_thread(OrtCustomThreadHandle handle) noexcept {
  auto* thread = reinterpret_cast<Thread*>(const_cast<OrtCustomHandleType*>(handle));
  if (thread->generation != base::ForkGate::generation())
    return;  // a thread of the parent does not exist in this child
  thread->thread.join();
  delete thread;
}

const std::string& open_engine() {
  static const std::string version = open_and_initialise();  // tried again at the next call if it throws
  return version;
}

const Ort::Env& environment(int32_t num_threads) {
  open_engine();
  // never destroyed: sessions may outlive statics
  static const Ort::Env& env = *new Ort::Env(make_environment(num_threads));
  return env;
}

namespace {

/** "" if it is not installed. */
std::string find_custom_op_library() {
  const std::string folder = base::own_folder(base::Links::kept);
  for (const std::string& path : {folder + "/libchiasm_ort.so", folder + "/../libchiasm_ort.so"}) {
    if (access(path.c_str(), R_OK) == 0) return path;
  }
  return "";
}

}  // namespace

bool has_custom_op_library() { return !find_custom_op_library().empty(); }

std::string custom_op_library() {
  std::string path = find_custom_op_library();
  if (path.empty())
    throw Error(CHIASM_UNAVAILABLE, "libchiasm_ort.so is not installed beside the onnx backend");
  return path;
}

bool has_provider(const char* name) {
  open_engine();
  const std::vector<std::string> providers = Ort::GetAvailableProviders();
  return std::find(providers.begin(), providers.end(), name) != providers.end();
}

}  // namespace chiasm::onnx
