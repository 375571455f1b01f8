// The number of threads: set by the program, else the CPUs of the process's affinity, and fixed when the
// first method is loaded.
#include "core/threads.h"

#include <pthread.h>
#include <sched.h>

#include <mutex>
#include <new>
#include <string>
#include <thread>

#include "base/fork.h"
#include "core/status.h"

namespace chiasm::core {
namespace {

constexpr int32_t kMaxThreads = 1024;

struct Policy {
  std::mutex mutex;
  int32_t count = 0;
  bool used = false;
};

Policy& policy() {
  static Policy* const instance = [] {
    ::pthread_atfork(nullptr, nullptr, [] { free_in_child(policy().mutex); });
    alignas(Policy) static unsigned char memory[sizeof(Policy)];
    return new (memory) Policy;  // not allocated: get_num_threads has no error
  }();
  return *instance;
}

int32_t cores() {
  cpu_set_t set;
  CPU_ZERO(&set);
  if (::sched_getaffinity(0, sizeof set, &set) == 0) return CPU_COUNT(&set);
  const unsigned count = std::thread::hardware_concurrency();
  return count == 0 ? 1 : static_cast<int32_t>(count);
}

}  // namespace

void check_num_threads(int32_t count, const std::string& what) {
  if (count >= 0 && count <= kMaxThreads) return;
  fail(CHIASM_INVALID_ARGUMENT,
       what + " is " + std::to_string(count) + ", expected 0 to " + std::to_string(kMaxThreads));
}

void set_num_threads(int32_t count) {
  check_num_threads(count, "the number of threads");
  Policy& state = policy();
  const std::lock_guard<std::mutex> lock(state.mutex);
  if (state.used)
    fail(CHIASM_FAILED_PRECONDITION, "the number of threads cannot change after the first method was loaded");
  state.count = count;
}

int32_t get_num_threads() {
  Policy& state = policy();
  const std::lock_guard<std::mutex> lock(state.mutex);
  return state.count > 0 ? state.count : cores();
}

int32_t use_num_threads() {
  Policy& state = policy();
  const std::lock_guard<std::mutex> lock(state.mutex);
  // Fixed here, because the affinity of the process may change later.
  if (!state.used && state.count == 0) state.count = cores();
  state.used = true;
  return state.count;
}

}  // namespace chiasm::core
