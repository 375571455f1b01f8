// Checks all runs of a call, and that no output shares memory with another tensor of any run; then a few
// threads take the runs from a queue.
#include "core/run_each.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <new>
#include <system_error>
#include <thread>

#include "base/signals.h"
#include "core/gaps.h"
#include "core/status.h"
#include "core/threads.h"

namespace chiasm::core {
namespace {

/** The bytes of a tensor. */
struct Memory {
  uintptr_t begin, end;
  size_t run;
  bool is_output;
};

/** Throws if the memory of an output overlaps that of another tensor. Rows of one batch do not overlap. */
void check_apart(std::vector<Memory>& all) {
  std::sort(all.begin(), all.end(), [](const Memory& a, const Memory& b) { return a.begin < b.begin; });
  // Of the tensors before this one in memory: the one that ends last, and the output that ends last
  const Memory *last = nullptr, *last_output = nullptr;
  for (const Memory& memory : all) {
    const Memory* const other = memory.is_output ? last : last_output;
    if (other != nullptr && other->end > memory.begin) {
      const Memory &output = memory.is_output ? memory : *other, &second = memory.is_output ? *other : memory;
      fail(CHIASM_INVALID_ARGUMENT,
           "run " + std::to_string(output.run) + ": the memory of an output overlaps that of an " +
               (second.is_output ? "output" : "input") + " of run " + std::to_string(second.run));
    }
    if (last == nullptr || memory.end > last->end) last = &memory;
    if (memory.is_output && (last_output == nullptr || memory.end > last_output->end)) last_output = &memory;
  }
}

/** Throws a run's error again, with the run's number. */
[[noreturn]] void fail_in(size_t run, const std::exception_ptr& error) {
  try {
    std::rethrow_exception(error);
  } catch (const Error& e) {
    fail(e.code(), "run " + std::to_string(run) + ": " + e.what());
  }
}

/** The runs of a call. Each thread takes the next run until none is left. */
class Queue {
 public:
  explicit Queue(size_t runs) : runs_(runs) {}

  template <class Run>
  void work(const Run& run) {
    for (size_t i = next_.fetch_add(1); i < runs_; i = next_.fetch_add(1)) {
      try {
        run(i);
      } catch (...) {
        const std::lock_guard<std::mutex> lock(mutex_);
        if (i < failed_) {
          failed_ = i;
          error_ = std::current_exception();
        }
      }
    }
  }

  void check() const {
    if (error_ != nullptr) fail_in(failed_, error_);
  }

 private:
  const size_t runs_;
  std::atomic<size_t> next_{0};
  std::mutex mutex_;
  size_t failed_ = SIZE_MAX;
  std::exception_ptr error_;
};

}  // namespace

void run_each(const Method& method, size_t runs, const chiasm_tensor* inputs, size_t input_count,
              const chiasm_tensor* outputs, size_t output_count, const chiasm_run_options* options) {
  const auto of_run = [](const chiasm_tensor* all, size_t run, size_t count) {
    if (all == nullptr || count == 0) return all;
    const chiasm_tensor* const first = &tensor_at(all, run * count);
    if (first->struct_size != all->struct_size)
      fail(CHIASM_INVALID_ARGUMENT, "its first tensor's struct_size is " +
                                        std::to_string(first->struct_size) + ", that of run 0 " +
                                        std::to_string(all->struct_size));
    return first;
  };
  check_run_options(options);  // even if there are no runs
  std::vector<Memory> memory;
  const auto note = [&](const chiasm_tensor& tensor, size_t run, bool is_output) {
    const auto begin = reinterpret_cast<uintptr_t>(tensor.data);
    const size_t bytes = bytes_spanned(tensor);
    if (bytes > 0) memory.push_back({begin, begin + bytes, run, is_output});
  };
  for (size_t run = 0; run < runs; ++run) {
    Call call;
    try {
      method.check(of_run(inputs, run, input_count), input_count, of_run(outputs, run, output_count),
                   output_count, options, call);
    } catch (const Error&) {
      fail_in(run, std::current_exception());
    }
    for (size_t i = 0; i < input_count; ++i) note(tensor_at(inputs, run * input_count + i), run, false);
    for (size_t i = 0; i < output_count; ++i) note(tensor_at(outputs, run * output_count + i), run, true);
  }
  check_apart(memory);

  Queue queue(runs);
  const auto work = [&] {
    queue.work([&](size_t run) {
      method.run_into(of_run(inputs, run, input_count), input_count, of_run(outputs, run, output_count),
                      output_count, options);
    });
  };
  std::vector<std::thread> others;
  const size_t at_once = std::min(runs, method.runs_at_once());
  try {
    const SignalsBlocked blocked;
    others.reserve(at_once);
    while (others.size() + 1 < at_once) others.emplace_back(work);
  } catch (const std::system_error&) {
    // The process can create no more threads: the existing ones do the work.
  } catch (const std::bad_alloc&) {
    // No memory is left for another thread: likewise.
  }
  work();
  for (std::thread& other : others) other.join();
  queue.check();
}

}  // namespace chiasm::core
