/** Each allocation of a call fails once, in a child process: the call ends with a result or one error, and
 *  works when there is memory again. */
#include <dlfcn.h>
#include <gtest/gtest.h>
#include <pthread.h>
#include <sys/auxv.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <cstdint>
#include <cstdlib>

#include "calls.h"
#include "child.h"

namespace {

/** The number of allocations that succeed before one fails; negative: none fails. */
std::atomic<int64_t> left{-1};

/** Whether this thread opens a library or creates a thread: there, failed allocations of the dynamic linker
 *  are harmless. Elsewhere, the linker allocates a thread's copy of a library's thread_local variables at
 *  their first use, and ends the process if it cannot: docs/decisions/07-process.md. */
thread_local bool linking = false;

class Linking final {
 public:
  Linking() : before_(linking) { linking = true; }
  Linking(const Linking&) = delete;
  Linking& operator=(const Linking&) = delete;
  ~Linking() { linking = before_; }

 private:
  const bool before_;
};

bool fails(const void* caller) {
  int64_t now = left.load();
  while (now > 0) {
    if (left.compare_exchange_weak(now, now - 1)) return false;
  }
  if (now < 0) return false;
  Dl_info info{};
  if (!linking && ::dladdr(caller, &info) != 0 &&
      reinterpret_cast<uintptr_t>(info.dli_fbase) == ::getauxval(AT_BASE))
    return false;
  if (!left.compare_exchange_strong(now, -1)) return false;
  errno = ENOMEM;
  return true;
}

template <class Function>
Function next(const char* name) {
  return reinterpret_cast<Function>(::dlsym(RTLD_NEXT, name));
}

}  // namespace

extern "C" {

// glibc's own functions, under names that remain available when this program replaces the others.
void* __libc_malloc(size_t size);
void* __libc_calloc(size_t count, size_t size);
void* __libc_realloc(void* data, size_t size);
void* __libc_memalign(size_t alignment, size_t size);

void* malloc(size_t size) { return fails(__builtin_return_address(0)) ? nullptr : __libc_malloc(size); }
void* calloc(size_t count, size_t size) {
  return fails(__builtin_return_address(0)) ? nullptr : __libc_calloc(count, size);
}
void* realloc(void* data, size_t size) {
  return fails(__builtin_return_address(0)) ? nullptr : __libc_realloc(data, size);
}
void* aligned_alloc(size_t alignment, size_t size) {
  return fails(__builtin_return_address(0)) ? nullptr : __libc_memalign(alignment, size);
}
int posix_memalign(void** data, size_t alignment, size_t size) {
  if (fails(__builtin_return_address(0))) return ENOMEM;
  *data = __libc_memalign(alignment, size);
  return *data == nullptr ? ENOMEM : 0;
}

void* dlopen(const char* path, int flags) {
  static const auto open = next<void* (*)(const char*, int)>("dlopen");
  const Linking now;
  return open(path, flags);
}

int pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*body)(void*),
                   void* argument) {
  using Create = int (*)(pthread_t*, const pthread_attr_t*, void* (*)(void*), void*);
  static const auto create = next<Create>("pthread_create");
  const Linking now;
  return create(thread, attributes, body, argument);
}

}  // extern "C"

namespace chiasm::testing {
namespace {

using std::chrono::seconds;

const chiasm_api& api() { return *chiasm_get_api(CHIASM_API_VERSION); }

/** The arguments of a call. Calls use the C interface, so that the test itself does not allocate in them. */
struct Scene {
  static constexpr size_t kRuns = 3;
  std::string path = bundle_path("filters.sobel");
  chiasm_load_options options = CHIASM_LOAD_OPTIONS_INIT;
  std::vector<float> values = std::vector<float>(3 * 300 * 300, 0.5f), results[kRuns];
  std::array<int64_t, 4> shape{1, 3, 300, 300}, result_shape{};
  chiasm_tensor inputs[kRuns]{}, outputs[kRuns]{};
  chiasm_bundle* bundle = nullptr;
  chiasm_method* method = nullptr;

  void open() { need(api().bundle_open(path.c_str(), &bundle)); }
  void load(int32_t num_threads) {
    open();
    options.num_threads = num_threads;
    need(api().method_load(bundle, "forward", &options, &method));
    for (size_t i = 0; i < kRuns; ++i) {
      inputs[i] = {sizeof(chiasm_tensor), values.data(), CHIASM_FLOAT32, CHIASM_CPU, 0, 4,
                   shape.data(),          nullptr};
      int32_t ndim = 0, dtype = 0;
      need(api().method_output_shape(method, inputs, 1, 0, result_shape.data(), &ndim, &dtype));
      results[i].resize(values.size());
      outputs[i] = {
          sizeof(chiasm_tensor), results[i].data(), dtype, CHIASM_CPU, 0, ndim, result_shape.data(), nullptr};
    }
  }

 private:
  static void need(chiasm_status* status) {
    if (status != nullptr) throw std::runtime_error(api().status_message(status));
  }
};

struct Step {
  const char* name;
  void (*prepare)(Scene& scene);
  chiasm_status* (*call)(Scene& scene);
};

const Step kSteps[] = {
    {"open", [](Scene&) {},
     [](Scene& scene) { return api().bundle_open(scene.path.c_str(), &scene.bundle); }},
    {"load", [](Scene& scene) { scene.open(); },
     [](Scene& scene) { return api().method_load(scene.bundle, "forward", &scene.options, &scene.method); }},
    {"run", [](Scene& scene) { scene.load(0); },
     [](Scene& scene) {
       chiasm_outputs* outputs = nullptr;
       chiasm_status* const status = api().method_run(scene.method, scene.inputs, 1, nullptr, &outputs);
       api().outputs_free(outputs);
       return status;
     }},
    {"run_each", [](Scene& scene) { scene.load(1); },
     [](Scene& scene) {
       return api().method_run_each(scene.method, Scene::kRuns, scene.inputs, 1, scene.outputs, 1, nullptr);
     }},
    {"self_test", [](Scene& scene) { scene.open(); },
     [](Scene& scene) {
       return api().bundle_self_test(scene.bundle, &scene.options, nullptr, nullptr, nullptr);
     }},
};

class Allocations : public ::testing::TestWithParam<Step> {};

TEST_P(Allocations, EachMayFailOnce) {
  const Step& step = GetParam();
  bool all = false;
  for (int64_t n = 0; !all; ++n) {
    const Ending child = in_child(seconds(30), [&]() -> std::string {
      set_num_threads(3);
      Scene scene;
      scene.options.backend = "native";
      step.prepare(scene);
      left = n;
      chiasm_status* const status = step.call(scene);
      const bool none_failed = left.exchange(-1) >= 0;
      const int32_t code = api().status_code(status);
      const std::string said = api().status_message(status);
      if (code != CHIASM_OK && code != CHIASM_OUT_OF_MEMORY) return std::to_string(code) + ": " + said;
      chiasm_status* const again = step.call(scene);
      if (again != nullptr) return std::string("again: ") + api().status_message(again);
      return none_failed ? "all" : "";
    });
    all = child.words == "all";
    ASSERT_TRUE(child.well()) << "allocation " << n << ": " << child.text();
    ASSERT_TRUE(all || child.words.empty()) << "allocation " << n << ": " << child.words;
  }
}

INSTANTIATE_TEST_SUITE_P(Of, Allocations, ::testing::ValuesIn(kSteps),
                         [](const auto& info) { return info.param.name; });

}  // namespace
}  // namespace chiasm::testing
