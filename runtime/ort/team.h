/** The team of threads of an ONNX Runtime session that one run of a compiled op has. */
#pragma once

#include <onnxruntime_c_api.h>

#include <atomic>
#include <cstdint>
#include <thread>

namespace chiasm::ort {

/** Runs an op in the session's own thread pool, whatever its size, and adds no thread to it.
 *
 *  ONNX Runtime offers a parallel loop, whose iterations may run one after the other; a compiled op needs
 *  threads that run at the same time, because they wait for each other. So the loop is used to collect
 *  threads: the caller's iteration runs the op, any other thread that turns up serves it until it ends, and
 *  each parallel region runs on the threads that have turned up by then.
 */
class Team final {
 public:
  using Body = void (*)(void* argument, int32_t index, int32_t count);

  /** How many threads turned up in earlier runs, and so are worth waiting for; 0 before the first. Kept by
   *  the kernel. */
  using Experience = std::atomic<int32_t>;
  static constexpr int32_t kMost = 64;

  /** `most`: how many threads a region has at most, 1 to kMost, however many the session's pool has. */
  Team(const OrtApi& api, const OrtKernelContext* context, Experience& experience, int32_t most)
      : api_(api), context_(context), experience_(experience), most_(most), serial_(next_serial()) {}
  Team(const Team&) = delete;
  Team& operator=(const Team&) = delete;

  /** Calls `run` in this thread, during which `fork` may be called. Must not throw. */
  OrtStatus* run(void (*run)(void*), void* argument);

  /** Calls body(argument, i, n) at the same time on n threads, `most` of them or fewer, this one being 0, and
   *  returns when all have returned. */
  void fork(Body body, void* argument);

 private:
  static uint64_t next_serial();
  void take_part();
  void count_this_thread();
  void serve();

  const OrtApi& api_;
  const OrtKernelContext* context_;
  Experience& experience_;
  const int32_t most_;
  const std::thread::id master_ = std::this_thread::get_id();
  void (*run_)(void*) = nullptr;
  void* run_argument_ = nullptr;
  bool started_ = false;

  Body body_ = nullptr;
  void* argument_ = nullptr;
  /** Regions begun so far, times kMost + 1, plus the number of threads in the last: one word, so that they
   *  are read as one. */
  std::atomic<uint64_t> region_{0};
  std::atomic<int32_t> joined_{1};
  std::atomic<int32_t> seen_{1}; /**< how many threads have joined or come too late */
  const uint64_t serial_;        /**< tells this run from others at the same address */
  std::atomic<int32_t> working_{0};
  std::atomic<bool> done_{false};
};

}  // namespace chiasm::ort
