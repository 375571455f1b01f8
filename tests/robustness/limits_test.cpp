/** Resources that a process may lack: threads, memory, files, /proc. Each case ends with a correct result or
 *  one error, and loaded methods work again when there is enough. */
#include <dlfcn.h>
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mount.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <thread>

#include "calls.h"
#include "child.h"
#include "support.h"

namespace {

/** The number of further threads that the process may have at the same time. */
std::atomic<int> threads_allowed{1 << 20};

struct Start {
  void* (*body)(void*);
  void* argument;
};

void* counted(void* argument) {
  const Start start = *static_cast<Start*>(argument);
  delete static_cast<Start*>(argument);
  void* const result = start.body(start.argument);
  ++threads_allowed;
  return result;
}

}  // namespace

/** Replaces libc's function, also for every library: fails like the system at a limit (RLIMIT_NPROC does not
 *  apply to root). */
extern "C" int pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*body)(void*),
                              void* argument) {
  using Function = int (*)(pthread_t*, const pthread_attr_t*, void* (*)(void*), void*);
  static const auto create = reinterpret_cast<Function>(::dlsym(RTLD_NEXT, "pthread_create"));
  if (threads_allowed.fetch_sub(1) <= 0) {
    ++threads_allowed;
    return EAGAIN;
  }
  auto* const start = new Start{body, argument};
  const int result = create(thread, attributes, counted, start);
  if (result != 0) {
    ++threads_allowed;
    delete start;
  }
  return result;
}

namespace chiasm::testing {
namespace {

using std::chrono::seconds;
using ::testing::HasSubstr;
using ::testing::Not;

class Limits : public ::testing::TestWithParam<std::string> {
 protected:
  const std::string bundle_ = bundle_path("filters.sobel");
  const MethodInfo forward_ = Bundle::open(bundle_).methods().at(0);

  /** The result of a process without limits. */
  std::string answer(const Inputs& inputs) const {
    const Ending child = in_child(seconds(60), [&] { return load(GetParam(), bundle_)(inputs); });
    if (!child.well()) throw std::runtime_error(child.text());
    return child.words;
  }
};

INSTANTIATE_TEST_SUITE_P(Built, Limits, ::testing::ValuesIn(ways_to_call()),
                         [](const auto& info) { return info.param; });

/** The error's text if `body` throws one. A program can be expected to handle only chiasm's and ONNX
 *  Runtime's own errors. */
template <class Body>
std::string error_of(Body&& body, int* code = nullptr) {
  try {
    body();
    return "";
  } catch (const Error& error) {
    if (code != nullptr) *code = error.code();
    return error.what();
  }
}

TEST_P(Limits, TooFewThreads) {
  const Inputs image = make_inputs(forward_, 1, 700);
  const std::string expected = answer(image);
  for (const int allowed : {0, 1, 2}) {
    const Ending child = in_child(seconds(60), [&]() -> std::string {
      set_num_threads(6);
      threads_allowed = allowed;
      try {
        const Callable sobel = load(GetParam(), bundle_);
        for (int i = 0; i < 3; ++i) {
          if (sobel(image) != expected) return "another answer";
        }
      } catch (const std::exception& error) {
        // ONNX Runtime itself rejects the program's own session.
        return GetParam() == "plugin" && std::string(error.what()).find("thread") != std::string::npos
                   ? ""
                   : error.what();
      }
      if (GetParam() == "plugin") return "";
      // One more caller: engines keep threads for each caller.
      threads_allowed = 1;
      const Callable again = load(GetParam(), bundle_);
      bool same = false;
      std::thread([&] { same = again(image) == expected; }).join();
      return same ? "" : "another answer in another thread";
    });
    EXPECT_TRUE(child.well()) << allowed << " threads: " << child.text();
    EXPECT_EQ(child.words, "") << allowed << " threads";
  }
}

/** In its lifetime, the process can use `more` bytes of address space in addition to its current use. */
class LessMemory final {
 public:
  explicit LessMemory(size_t more) {
    size_t pages = 0;
    std::ifstream("/proc/self/statm") >> pages;
    ::getrlimit(RLIMIT_AS, &before_);
    rlimit limit = before_;
    limit.rlim_cur = pages * static_cast<size_t>(::sysconf(_SC_PAGESIZE)) + more;
    ::setrlimit(RLIMIT_AS, &limit);
  }
  LessMemory(const LessMemory&) = delete;
  LessMemory& operator=(const LessMemory&) = delete;
  ~LessMemory() { ::setrlimit(RLIMIT_AS, &before_); }

 private:
  rlimit before_{};
};

/** An image of 48 MB. glibc maps blocks larger than 32 MB anew each time, so no tensor of a run fits into
 *  memory that the process already has. */
Inputs large_image() {
  constexpr int64_t kSide = 2000;
  Inputs inputs;
  inputs.bytes.emplace_back(3 * kSide * kSide * sizeof(float));
  float* const values = reinterpret_cast<float*>(inputs.bytes.back().data());
  for (int64_t i = 0; i < 3 * kSide * kSide; ++i) values[i] = static_cast<float>(i * 7919 % 1009) / 1009.0f;
  inputs.tensors.emplace_back(static_cast<void*>(values), DType::Float32, Shape({1, 3, kSide, kSide}));
  return inputs;
}

TEST_P(Limits, TooLittleMemoryForARun) {
  const Inputs small = make_inputs(forward_, 1, 16), large = large_image();
  const std::string expected = answer(large);
  for (const bool first_run : {true, false}) {
    for (const size_t more : {size_t{0}, size_t{1} << 20, size_t{60} << 20, size_t{160} << 20}) {
      const Ending child = in_child(seconds(60), [&]() -> std::string {
        set_num_threads(2);
        const Callable sobel = load(GetParam(), bundle_);
        if (!first_run) sobel(small);
        std::string said;
        int code = CHIASM_OUT_OF_MEMORY;
        {
          const LessMemory less(more);
          for (int i = 0; i < 3 && said.empty(); ++i) {
            try {
              said = error_of([&] { sobel(large); }, &code);
            } catch (const std::bad_alloc&) {
              said = "no bytes for the test itself, which copies the outputs";
            } catch (const std::exception& error) {
              said = error.what();
            }
          }
        }
        if (sobel(large) != expected) return "another answer when there is memory again";
        if (code != CHIASM_OUT_OF_MEMORY) return "code " + std::to_string(code) + ": " + said;
        if (GetParam() == "native" && !said.empty() && said.find(" bytes") == std::string::npos)
          return "does not say how much: " + said;
        return more == 0 && said.empty() ? "ran without memory" : "";
      });
      EXPECT_TRUE(child.well()) << more << " bytes: " << child.text();
      EXPECT_EQ(child.words, "") << more << " bytes more, " << (first_run ? "first" : "later") << " run";
    }
  }
}

TEST_P(Limits, TooLittleMemoryToLoad) {
  if (GetParam() == "plugin")
    // the program's own session may abort in ONNX Runtime; `onnx` covers the native code inside it
    return;
  const Inputs image = make_inputs(forward_, 1, 16);
  const std::string expected = answer(image);
  // Engines end the process in certain windows of a few hundred kilobytes, which differ between processes:
  // hence many steps of irregular sizes.
  for (size_t more = 0; more < size_t{400} << 20; more = more * 5 / 4 + 1111111) {
    for (const bool engine_is_there : {true, false}) {
      const Ending child = in_child(seconds(60), [&]() -> std::string {
        if (engine_is_there) load(GetParam(), bundle_);
        int code = 0;
        {
          const LessMemory less(more);
          try {
            error_of([&] { load(GetParam(), bundle_)(image); }, &code);
          } catch (const std::exception&) {  // of a session
          }
        }
        if (code == CHIASM_CORRUPT || code == CHIASM_NOT_FOUND) return "code " + std::to_string(code);
        return load(GetParam(), bundle_)(image) == expected ? ""
                                                            : "another answer when there is memory again";
      });
      EXPECT_TRUE(child.well()) << more << " bytes: " << child.text();
      EXPECT_EQ(child.words, "") << more << " bytes more";
    }
  }
}

TEST_P(Limits, TooFewFiles) {
  const Inputs image = make_inputs(forward_, 1, 16);
  const std::string expected = answer(image);
  const Ending child = in_child(seconds(60), [&]() -> std::string {
    load(GetParam(), bundle_)(image);
    rlimit before{};
    ::getrlimit(RLIMIT_NOFILE, &before);
    const int highest = ::dup(0);  // the lowest free number
    ::close(highest);
    for (rlim_t more = 0; more < 6; ++more) {
      rlimit limit = before;
      limit.rlim_cur = static_cast<rlim_t>(highest) + more;
      ::setrlimit(RLIMIT_NOFILE, &limit);
      int code = 0;
      std::string said;
      try {
        said = error_of([&] { load(GetParam(), bundle_); }, &code);
      } catch (const std::exception& error) {
        said = error.what();
      }
      ::setrlimit(RLIMIT_NOFILE, &before);
      if (code == CHIASM_CORRUPT || code == CHIASM_NOT_FOUND || code == CHIASM_INTERNAL)
        return std::to_string(code) + ": " + said;
      if (more == 0 && said.find("Too many open files") == std::string::npos)
        return "does not say why: " + said;
    }
    return load(GetParam(), bundle_)(image) == expected ? "" : "another answer when there are files again";
  });
  EXPECT_TRUE(child.well()) << child.text();
  EXPECT_EQ(child.words, "");
}

/** ONNX Runtime writes files itself, and there the signal ends the process. */
TEST(NativeLimits, TooSmallFilesAreOneError) {
  const std::string bundle = bundle_path("filters.sobel");
  const Inputs image = make_inputs(Bundle::open(bundle).methods().at(0), 1, 16);
  const Ending child = in_child(seconds(60), [&]() -> std::string {
    rlimit before{};
    ::getrlimit(RLIMIT_FSIZE, &before);
    rlimit limit = before;
    limit.rlim_cur = 10 << 10;
    ::setrlimit(RLIMIT_FSIZE, &limit);
    int code = 0;
    const std::string said = error_of([&] { load("native", bundle); }, &code);
    ::setrlimit(RLIMIT_FSIZE, &before);
    load("native", bundle)(image);
    return std::to_string(code) + ": " + said;
  });
  ASSERT_TRUE(child.well()) << child.text();
  EXPECT_THAT(child.words, HasSubstr(std::to_string(CHIASM_IO_ERROR) + ": "));
  EXPECT_THAT(child.words, HasSubstr("10240 bytes: raise RLIMIT_FSIZE"));
}

TEST(OnnxLimits, AnErrorIsNotPrintedBesides) {
  const std::vector<std::string> ways = ways_to_call();
  if (std::find(ways.begin(), ways.end(), "onnx_flat") == ways.end()) GTEST_SKIP() << "not built";
  const std::string bundle = bundle_path("filters.sobel");
  const Inputs image = large_image();
  const Ending child = in_child(seconds(60), [&]() -> std::string {
    const TemporaryFolder folder;
    const std::string printed = folder.write("printed", "");
    const int file = ::open(printed.c_str(), O_WRONLY);
    ::dup2(file, 2);
    const Callable sobel = load("onnx_flat", bundle);
    std::string said;
    {
      const LessMemory less(size_t{120} << 20);  // enough for the outputs, which the engine does not allocate
      said = error_of([&] { sobel(image); });
    }
    return said.empty() ? "ran without memory" : read_text(printed);
  });
  EXPECT_TRUE(child.well()) << child.text();
  EXPECT_EQ(child.words, "");
}

/** The guarantee of chiasm.h about stacks, for every bundle. */
TEST(NativeLimits, AStackOf256KiBIsEnough) {
  const std::string folder = bundle_path("filters.sobel") + "/..";
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() != ".chiasm") continue;
    const Ending child = in_child(seconds(60), [&]() -> std::string {
      const Bundle bundle = Bundle::open(entry.path().string());
      const Inputs inputs = make_inputs(bundle.methods().at(0), 1, 64);
      const std::function<void()> body = [&] {
        try {
          load("native", entry.path().string())(inputs);
        } catch (const Error&) {  // has no native code for this machine
        }
      };
      pthread_attr_t attributes;
      ::pthread_attr_init(&attributes);
      ::pthread_attr_setstacksize(&attributes, size_t{256} << 10);
      pthread_t thread;
      const auto call = [](void* argument) -> void* {
        (*static_cast<const std::function<void()>*>(argument))();
        return nullptr;
      };
      if (::pthread_create(&thread, &attributes, call, const_cast<std::function<void()>*>(&body)) != 0)
        return "no thread";
      ::pthread_join(thread, nullptr);
      return "";
    });
    EXPECT_TRUE(child.well()) << entry.path() << ": " << child.text();
    EXPECT_EQ(child.words, "") << entry.path();
  }
}

TEST(NativeLimits, WithoutProcOneErrorSaysSo) {
  const std::string bundle = bundle_path("filters.sobel");
  const Ending child = in_child(seconds(60), [&]() -> std::string {
    if (::unshare(CLONE_NEWNS) != 0 && ::unshare(CLONE_NEWUSER | CLONE_NEWNS) != 0)
      return "may not hide /proc";
    ::mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr);
    if (::mount("none", "/proc", "tmpfs", 0, nullptr) != 0) return "may not hide /proc";
    return error_of([&] { load("native", bundle); });
  });
  ASSERT_TRUE(child.well()) << child.text();
  if (child.words == "may not hide /proc") GTEST_SKIP() << "this process may not change its mounts";
  EXPECT_THAT(child.words, HasSubstr("/proc"));
  EXPECT_THAT(child.words, Not(HasSubstr("//")));
}

/** Makes memfd_create fail from now on, as in a sandbox. */
bool forbid_files_in_memory() {
  sock_filter steps[] = {BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr)),
                         BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_memfd_create, 0, 1),
                         BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | EPERM),
                         BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW)};
  const sock_fprog program{static_cast<unsigned short>(std::size(steps)), steps};
  return ::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 &&
         ::prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program) == 0;
}

TEST(NativeLimits, WithoutFilesInMemoryAnotherBackendRuns) {
  const std::vector<std::string> ways = ways_to_call();
  const std::string path = bundle_path("filters.sobel");
  const Ending child = in_child(seconds(60), [&]() -> std::string {
    if (!forbid_files_in_memory()) return "may not filter system calls";
    int code = 0;
    const std::string said = error_of([&] { load("native", path); }, &code);
    if (code != CHIASM_UNAVAILABLE || said.find("not allowed here (memfd_create") == std::string::npos)
      return std::to_string(code) + ": " + said;
    return Bundle::open(path).method("forward").backend();
  });
  ASSERT_TRUE(child.well()) << child.text();
  if (child.words == "may not filter system calls") GTEST_SKIP() << child.words;
  if (std::find(ways.begin(), ways.end(), "onnx_flat") == ways.end()) GTEST_SKIP() << "no other backend";
  EXPECT_THAT(child.words, ::testing::AnyOf("torch", "onnx"));
}

/** MKL, in libtorch, would end the process. */
TEST_P(Limits, ADeletedFolderIsNoneToStartIn) {
  const Inputs image = make_inputs(forward_, 1, 16);
  const std::string expected = answer(image);
  const Ending child = in_child(seconds(60), [&]() -> std::string {
    const std::string bundle = std::filesystem::absolute(bundle_).string();
    {
      const TemporaryFolder gone;
      if (::chdir(gone.path().c_str()) != 0) return "no folder";
    }
    std::string given;
    const std::string said = error_of([&] { given = load(GetParam(), bundle)(image); });
    const bool good = said.empty() ? given == expected : said.find("change to another") != std::string::npos;
    return good ? "" : said.empty() ? "another answer" : said;
  });
  EXPECT_TRUE(child.well()) << child.text();
  EXPECT_EQ(child.words, "");
}

}  // namespace
}  // namespace chiasm::testing
