#include "threads.h"

#include <thread>
#include <vector>

#include "artifact/aoti/tensor.h"

namespace chiasm::artifact {
namespace {

chiasm_native_host host{};

void fork(void*, void (*body)(void* argument, int32_t index, int32_t count), void* argument) {
  std::vector<std::thread> others;
  for (int32_t i = 1; i < host.num_threads; ++i) others.emplace_back(body, argument, i, host.num_threads);
  body(argument, 0, host.num_threads);
  for (std::thread& other : others) other.join();
}

}  // namespace

Run*& current_run() {
  thread_local Run* run = nullptr;
  return run;
}

}  // namespace chiasm::artifact

void use_threads(int count) {
  using namespace chiasm::artifact;
  static Run run(&host, nullptr, 0, nullptr);
  host.num_threads = count;
  host.fork = fork;
  current_run() = &run;
}
