// Runs a native artifact with guards around every tensor, for sanitized_artifacts.py, which sends requests on
// the standard input.
//
//   sanitized_artifacts LIBRARY
//
// A request: threads (int32), placement of the tensors (int32; 0: they end, 1: they begin at the edge of
// memory), numbers of inputs and outputs (int32 each), and for each tensor its chiasm_dtype and rank (int32
// each), its sizes (int64), and for inputs the bytes. The answer: 0 (int32) and the outputs' bytes; 1, the
// length of a message (int32) and the message; or 2, if something was written outside of a tensor. Scratch
// memory for the artifact is guarded too, and filled with NaN.
#include <dlfcn.h>

#include <cstdio>
#include <cstdlib>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <numeric>
#include <string>
#include <thread>
#include <vector>

#include "runtime/artifact/abi.h"
#include "tests/kernels/guarded_memory.h"

namespace {

using guarded::Buffer;
using guarded::Placement;

constexpr size_t kElementSizes[] = {1, 1, 1, 2, 4, 8, 2, 2, 4, 8};  // by chiasm_dtype
constexpr size_t kAlignment = 64;                                   // of scratch, as in abi.h

bool read(void* to, size_t bytes) { return bytes == 0 || std::fread(to, bytes, 1, stdin) == 1; }
void write(const void* from, size_t bytes) { std::fwrite(from, 1, bytes, stdout); }

template <class Number>
Number read_number() {
  Number number;
  if (!read(&number, sizeof number)) std::exit(0);  // the end of the input
  return number;
}

void write_number(int32_t number) { write(&number, sizeof number); }

struct Tensor {
  std::unique_ptr<Buffer> buffer;
  std::vector<int64_t> shape;
  int32_t dtype;
  chiasm_tensor view() const {
    return {sizeof(chiasm_tensor), buffer->data(), dtype, CHIASM_CPU, 0, static_cast<int32_t>(shape.size()),
            shape.data(),          nullptr};
  }
};

Tensor read_tensor(Placement placement, bool with_values) {
  Tensor tensor;
  tensor.dtype = read_number<int32_t>();
  tensor.shape.resize(static_cast<size_t>(read_number<int32_t>()));
  for (int64_t& size : tensor.shape) size = read_number<int64_t>();
  const int64_t count =
      std::accumulate(tensor.shape.begin(), tensor.shape.end(), int64_t{1}, std::multiplies<>());
  tensor.buffer =
      std::make_unique<Buffer>(static_cast<size_t>(count) * kElementSizes[tensor.dtype], placement);
  if (with_values && !read(tensor.buffer->data(), tensor.buffer->bytes())) std::exit(3);
  return tensor;
}

// The host's resources for the artifact: scratch and threads.
struct Host {
  int32_t threads;
  std::mutex mutex;
  std::map<void*, std::unique_ptr<Buffer>> scratch;
  bool intact = true;

  void* allocate(size_t bytes) {
    auto buffer = std::make_unique<Buffer>(bytes, Placement::kEnd, kAlignment);
    void* const data = buffer->data();
    const std::lock_guard<std::mutex> lock(mutex);
    scratch[data] = std::move(buffer);
    return data;
  }

  void release(void* data) {
    const std::lock_guard<std::mutex> lock(mutex);
    intact = intact && scratch.at(data)->is_intact();
    scratch.erase(data);
  }

  void fork(void (*body)(void*, int32_t, int32_t), void* argument) const {
    std::vector<std::thread> others;
    for (int32_t i = 1; i < threads; ++i) others.emplace_back(body, argument, i, threads);
    body(argument, 0, threads);
    for (std::thread& thread : others) thread.join();
  }
};

void answer(const chiasm_native_api& api, void* model) {
  Host host{read_number<int32_t>(), {}, {}};
  const Placement placement = read_number<int32_t>() == 0 ? Placement::kEnd : Placement::kStart;
  const auto input_count = read_number<int32_t>(), output_count = read_number<int32_t>();
  std::vector<Tensor> tensors;
  std::vector<chiasm_tensor> inputs, outputs;
  for (int32_t i = 0; i < input_count; ++i)
    inputs.push_back(tensors.emplace_back(read_tensor(placement, true)).view());
  for (int32_t i = 0; i < output_count; ++i)
    outputs.push_back(tensors.emplace_back(read_tensor(placement, false)).view());

  chiasm_native_host lent{};
  lent.context = &host;
  lent.allocate = [](void* context, size_t bytes) { return static_cast<Host*>(context)->allocate(bytes); };
  lent.release = [](void* context, void* data, size_t) { static_cast<Host*>(context)->release(data); };
  lent.fork = [](void* context, void (*body)(void*, int32_t, int32_t), void* argument) {
    static_cast<Host*>(context)->fork(body, argument);
  };
  lent.num_threads = host.threads;
  char error[1024] = "";
  const int32_t failed = api.run(model, inputs.data(), outputs.data(), &lent, error, sizeof error);
  for (const Tensor& tensor : tensors) host.intact = host.intact && tensor.buffer->is_intact();
  if (!host.intact || !host.scratch.empty()) {
    write_number(2);
  } else if (failed) {
    const std::string text(error);
    write_number(1);
    write_number(static_cast<int32_t>(text.size()));
    write(text.data(), text.size());
  } else {
    write_number(0);
    for (size_t i = inputs.size(); i < tensors.size(); ++i)
      write(tensors[i].buffer->data(), tensors[i].buffer->bytes());
  }
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  void* const library = dlopen(argv[1], RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) {
    std::fprintf(stderr, "%s\n", dlerror());
    return 2;
  }
  const auto entry = reinterpret_cast<chiasm_native_entry_fn>(dlsym(library, CHIASM_NATIVE_ENTRY));
  const chiasm_native_api* const api = entry != nullptr ? entry(CHIASM_NATIVE_ABI) : nullptr;
  void* model = nullptr;
  char error[1024] = "no entry point of this interface";
  if (api == nullptr || api->create(0, 0, &model, error, sizeof error) != 0) {
    std::fprintf(stderr, "%s\n", error);
    return 2;
  }
  for (;;) answer(*api, model);  // until the input ends
}
