#include "backends/native/compiled_op.h"

#include <dlfcn.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <exception>
#include <mutex>
#include <string>

#include "backends/native/archive.h"
#include "base/library.h"

namespace chiasm::native {
namespace {

using base::CudaDevice;
using base::Error;
using plugin::MemoryFile;

// dlopen identifies libraries by the text of their path. If a closed file's descriptor is reused, it would
// return the old library for the path of a new file. So each path is unique: "/" and "/." between its parts
// spell a number, made of a counter and of the address of this code, because two of our libraries contain it
// and may be in one process.
std::string unique_path(const MemoryFile& file) {
  static std::atomic<uint64_t> count{0};
  std::string path = "/proc/self/fd";
  const auto spell = [&path](uint64_t number, int bits) {
    for (int i = 0; i < bits; ++i) path += (number >> i) % 2 != 0 ? "/." : "/";
  };
  spell(reinterpret_cast<uintptr_t>(&count), 64);
  spell(++count, 64);
  return path + "/" + std::to_string(file.fd());
}

/** Sealed: nobody can change it while the linker reads it. */
MemoryFile memory_file(const Bytes& library) {
  MemoryFile file("chiasm-native");
  file.write(library.data, library.size);
  file.seal();
  return file;
}

void* open_library(const MemoryFile& file) {
  const std::string path = unique_path(file);
  std::string reason;
  if (void* const library = base::open_library(path.c_str(), reason)) return library;
  // the library's path, 300 slashes and dots, would not help a user
  if (reason.compare(0, path.size(), path) == 0)
    reason.replace(0, path.size(), "/proc/self/fd/" + std::to_string(file.fd()));
  throw Error(CHIASM_UNAVAILABLE, "cannot load the native code: " + reason);
}

// `expected` is the manifest's signature. Code that was compiled for another one would read and write outside
// of its tensors.
void check_signature(const std::string& compiled, const std::string& expected) {
  if (compiled == expected) return;
  size_t start = 0;  // of the first line that differs
  for (size_t i = 0; i < std::min(compiled.size(), expected.size()) && compiled[i] == expected[i]; ++i)
    if (compiled[i] == '\n') start = i + 1;
  const auto line = [start](const std::string& text) {
    return start < text.size() ? "'" + text.substr(start, text.find('\n', start) - start) + "'"
                               : "nothing more";
  };
  throw Error(CHIASM_CORRUPT, "the manifest says " + line(expected) + ", the native code was compiled for " +
                                  line(compiled) +
                                  ": the manifest was changed after the export; export the bundle again");
}

/** Throws what the native code reported. */
void check_result(int32_t result, const char* text) {
  switch (result) {
    case CHIASM_NATIVE_OK: return;
    case CHIASM_NATIVE_BAD_VALUE: throw Error(CHIASM_INVALID_ARGUMENT, text);
    case CHIASM_NATIVE_OUT_OF_MEMORY: throw Error(CHIASM_OUT_OF_MEMORY, text);
    default: throw Error(CHIASM_INTERNAL, text);
  }
}

}  // namespace

Library::Library(const MemoryFile& file) : handle_(open_library(file)) {}

Library::~Library() { dlclose(handle_); }

const chiasm_native_api* Library::api() const {
  const auto entry = reinterpret_cast<chiasm_native_entry_fn>(dlsym(handle_, CHIASM_NATIVE_ENTRY));
  if (entry == nullptr)
    throw Error(CHIASM_CORRUPT, "the native code has no entry point " CHIASM_NATIVE_ENTRY);
  const chiasm_native_api* api = entry(CHIASM_NATIVE_ABI);
  if (api == nullptr || api->abi != CHIASM_NATIVE_ABI || api->struct_size < sizeof(chiasm_native_api))
    throw Error(CHIASM_VERSION_MISMATCH, "the native code was built for another interface version than " +
                                             std::to_string(CHIASM_NATIVE_ABI) + "; export the bundle again");
  return api;
}

CompiledOp::CompiledOp(const Request& request) : request_(request) {
  if (request.input_count > kMaxTensors || request.output_count > kMaxTensors)
    throw Error(CHIASM_INVALID_ARGUMENT, "more than " + std::to_string(kMaxTensors) + " inputs or outputs");
  if (request.device_type == CHIASM_CUDA) cuda_.emplace(request.device_index);
  const auto current = make_current();
  library_.emplace(memory_file(find_library(request.data, request.size)));
  request_.data = nullptr;
  api_ = library_->api();
  check_signature(api_->signature, request.signature);
  request_.signature = nullptr;
  char text[1024] = "";
  check_result(api_->create(request.device_type, request.device_index, &model_, text, sizeof(text)), text);
}

CompiledOp::~CompiledOp() {
  try {
    const auto current = make_current();
    api_->destroy(model_);
  } catch (...) {  // the device is gone, and so is the model's memory there
  }
}

size_t CompiledOp::bytes_of(const chiasm_tensor* inputs, const chiasm_tensor* outputs, uint64_t which_inputs,
                            uint64_t which_outputs) const {
  size_t bytes = 0;
  const auto add = [&bytes](const chiasm_tensor* tensors, int32_t count, uint64_t which) {
    for (int32_t i = 0; i < count; ++i)
      if ((which >> i & 1) != 0) bytes += base::byte_count(tensors[i]);
  };
  add(inputs, request_.input_count, which_inputs);
  add(outputs, request_.output_count, which_outputs);
  return bytes;
}

bool CompiledOp::worth_forking(const chiasm_tensor* inputs, const chiasm_tensor* outputs) const {
  constexpr size_t kLeast = 64 << 10;
  return bytes_of(inputs, outputs, ~uint64_t{0}, ~uint64_t{0}) >= kLeast;
}

int64_t CompiledOp::count_parts(const chiasm_tensor* inputs, const chiasm_tensor* outputs,
                                int32_t threads) const {
  // Bytes of a part's inputs and outputs. An op's intermediate results are several times as large, and should
  // stay in the L2 cache. Smaller parts would repeat the work that all samples share, such as a map or a
  // table, more often.
  constexpr size_t kPart = 4 << 20;
  if (request_.batched_outputs == 0) return 1;
  const int64_t samples = outputs[0].shape[0];
  const auto parts = static_cast<int64_t>(
      (bytes_of(inputs, outputs, request_.batched_inputs, request_.batched_outputs) + kPart - 1) / kPart);
  if (parts < 2 || samples < 2 || samples < threads) return 1;
  return std::min((parts + threads - 1) / threads * threads, samples);  // equally many for each thread
}

void CompiledOp::run(const chiasm_tensor* inputs, const chiasm_tensor* outputs, chiasm_native_host host,
                     Share share) const {
  host.device_type = request_.device_type;
  host.device_index = request_.device_index;
  const auto current = make_current();
  const int64_t parts = host.device_type == CHIASM_CPU ? count_parts(inputs, outputs, host.num_threads) : 1;
  if (parts > 1)
    run_parts(inputs, outputs, host, share, parts);
  else
    run_whole(inputs, outputs, host);
}

void CompiledOp::run_whole(const chiasm_tensor* inputs, const chiasm_tensor* outputs,
                           const chiasm_native_host& host) const {
  char text[1024];
  text[0] = '\0';
  check_result(api_->run(model_, inputs, outputs, &host, text, sizeof(text)), text);
}

/** What the threads that share a batch have in common. */
struct CompiledOp::Parts {
  const CompiledOp& model;
  const chiasm_tensor* inputs;
  const chiasm_tensor* outputs;
  chiasm_native_host host;
  int64_t count;
  std::atomic<int64_t> next{0};
  std::mutex mutex;  // guards `error`, the first
  std::exception_ptr error;

  void work() noexcept {
    try {
      for (int64_t part; (part = next++) < count;) run(part);
    } catch (...) {
      next = count;
      const std::lock_guard<std::mutex> lock(mutex);
      if (!error) error = std::current_exception();
    }
  }

  void run(int64_t part) const {
    const int64_t samples = outputs[0].shape[0], begin = samples * part / count,
                  end = samples * (part + 1) / count;
    const Request& request = model.request_;
    std::array<chiasm_tensor, kMaxTensors> in, out;
    std::array<std::array<int64_t, CHIASM_MAX_DIMS>, kMaxTensors> in_shapes, out_shapes;
    const auto cut = [begin, end](const chiasm_tensor& whole, std::array<int64_t, CHIASM_MAX_DIMS>& shape) {
      std::copy_n(whole.shape, whole.ndim, shape.begin());
      shape[0] = end - begin;
      chiasm_tensor part = whole;
      part.shape = shape.data();
      if (whole.shape[0] > 0)
        part.data = static_cast<char*>(whole.data) +
                    static_cast<int64_t>(base::byte_count(whole)) / whole.shape[0] * begin;
      return part;
    };
    for (int32_t i = 0; i < request.input_count; ++i)
      in[i] = (request.batched_inputs >> i & 1) != 0 ? cut(inputs[i], in_shapes[i]) : inputs[i];
    for (int32_t i = 0; i < request.output_count; ++i) out[i] = cut(outputs[i], out_shapes[i]);
    model.run_whole(in.data(), out.data(), host);
  }
};

void CompiledOp::run_parts(const chiasm_tensor* inputs, const chiasm_tensor* outputs,
                           const chiasm_native_host& host, Share share, int64_t parts) const {
  Parts shared{*this, inputs, outputs, host, parts, {}, {}, {}};
  shared.host.num_threads = 1;
  if (host.num_threads > 1)
    share(
        host.context, [](void* all, int32_t, int32_t) { static_cast<Parts*>(all)->work(); }, &shared);
  else
    shared.work();
  if (shared.error) std::rethrow_exception(shared.error);
}

std::optional<CudaDevice::Current> CompiledOp::make_current() const {
  return cuda_ ? std::optional<CudaDevice::Current>(std::in_place, *cuda_) : std::nullopt;
}

}  // namespace chiasm::native
