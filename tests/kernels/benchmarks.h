// Benchmarks of kernels, each in the file of the kernel's test. Target kernels_bench runs them:
//
//     cmake --build --preset release --target kernels_bench
//     build/release/bin/kernels_bench [--benchmark_filter=median]
//
// `make bench WHAT=kernels` writes docs/benchmarks_kernels.md from it. On one thread. The time of a call is
// the median CPU time. The bandwidth is for inputs that are read once and outputs that are written once; its
// share is relative to a copy of as many bytes, which takes turns with the kernel.
#pragma once

#ifndef CHIASM_BENCHMARKS  // for cross-compiling, without the library
#define KERNEL_BENCHMARK(name, ...) static_assert(true)
#define KERNEL_CALL_BENCHMARK(name, ...) static_assert(true)
#else

#include <benchmark/benchmark.h>
#include <malloc.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <ctime>
#include <random>
#include <utility>
#include <vector>

#include "kernels.h"
#include "threads.h"

namespace kernel_benchmarks {

/** This thread's CPU time so far: on a busy machine, the wall-clock time of a call includes other work. */
inline double cpu_seconds() {
  timespec time;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return double(time.tv_sec) + 1e-9 * double(time.tv_nsec);
}

inline double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + std::ptrdiff_t(values.size() / 2), values.end());
  return values[values.size() / 2];
}

inline std::vector<float> random(int64_t n, float low = 0, float high = 1) {
  std::mt19937 engine(1);
  std::uniform_real_distribution<float> draw(low, high);
  std::vector<float> values(static_cast<size_t>(n));
  std::generate(values.begin(), values.end(), [&] { return draw(engine); });
  return values;
}

/** Measures call() beside copy(), which reads and writes `bytes` in all. */
template <class Call, class Copy>
void take_turns(benchmark::State& state, Call call, Copy copy, double bytes) {
  use_threads(1);
  std::vector<double> calls, copies;
  for (auto _ : state) {
    const double start = cpu_seconds();
    copy();
    const double copied = cpu_seconds();
    call();
    calls.push_back(cpu_seconds() - copied);
    copies.push_back(copied - start);
    state.SetIterationTime(calls.back());
  }
  const double taken = median(calls), copied = median(copies);
  state.counters["ms"] = taken * 1e3;
  state.counters["GB/s"] = bytes / taken * 1e-9;
  state.counters["copy_GB/s"] = bytes / copied * 1e-9;
  state.counters["of_copy_%"] = 100 * copied / taken;
}

template <class Call>
void run(benchmark::State& state, const Call& call) {
  const chiasm::kernels::Planes planes{state.range(0), state.range(1), state.range(2)};
  const std::vector<float> x = random(planes.count * planes.height * planes.width);
  std::vector<float> out(x.size());
  const size_t bytes = x.size() * sizeof(float);
  take_turns(
      state, [&] { call(x.data(), planes, out.data()); }, [&] { std::memcpy(out.data(), x.data(), bytes); },
      2.0 * double(bytes));
}

/** The bytes that the program holds. */
inline size_t held() {
  const auto memory = mallinfo2();
  return memory.uordblks + memory.hblkhd;
}

/** Registers call(x, planes, out) at the sizes of docs/benchmarks.md. */
template <class Call>
benchmark::internal::Benchmark* add(const char* name, const Call& call) {
  return benchmark::RegisterBenchmark(name, [call](benchmark::State& state) { run(state, call); })
      ->Args({3, 1080, 1920})
      ->Args({24, 256, 256})
      ->UseManualTime()
      ->Unit(benchmark::kMillisecond);
}

/** Registers the call that make() returns, which owns its inputs and outputs: their bytes are what make()
 *  allocates. */
template <class Make>
benchmark::internal::Benchmark* add_call(const char* name, const Make& make) {
  const auto run = [make](benchmark::State& state) {
    const size_t before = held();
    auto call = make();
    const size_t half = (held() - before) / 2;
    const std::vector<uint8_t> source(half);
    std::vector<uint8_t> target(half);
    take_turns(
        state, std::move(call), [&] { std::memcpy(target.data(), source.data(), half); }, 2.0 * double(half));
  };
  return benchmark::RegisterBenchmark(name, run)->UseManualTime()->Unit(benchmark::kMillisecond);
}

}  // namespace kernel_benchmarks

/** The benchmark of a kernel with another signature: a name, and a function that sets up and returns the
 *  call. */
#define KERNEL_CALL_BENCHMARK(name, ...)                                       \
  [[maybe_unused]] benchmark::internal::Benchmark* const benchmark_of_##name = \
      kernel_benchmarks::add_call(#name, __VA_ARGS__)

/** A benchmark: a name, which is an identifier, and a function of (const float* x, Planes planes, float*
 *  out). */
#define KERNEL_BENCHMARK(name, ...)                                            \
  [[maybe_unused]] benchmark::internal::Benchmark* const benchmark_of_##name = \
      kernel_benchmarks::add(#name, __VA_ARGS__)
#endif
