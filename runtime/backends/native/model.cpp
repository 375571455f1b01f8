#include "backends/native/model.h"

#include <dlfcn.h>

#include <array>
#include <atomic>
#include <string>

#include "backends/native/archive.h"

namespace chiasm::native {
namespace {

using plugin::CudaDevice;
using plugin::Error;
using plugin::MemoryFile;

// dlopen knows libraries by the text of their path, and takes one that it has for one that has just been written where
// the number of a closed file is used again. So each path is new: "/" and "/./" between its parts spell a number, made of a
// count and of where this code is: it is in two libraries of ours, which may be in one process.
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

}  // namespace

Library::Library(const MemoryFile& file) : handle_(dlopen(unique_path(file).c_str(), RTLD_NOW | RTLD_LOCAL)) {
  if (handle_ == nullptr) throw Error(CHIASM_UNAVAILABLE, std::string("cannot load the native code: ") + dlerror());
}

Library::~Library() { dlclose(handle_); }

const chiasm_native_api* Library::api() const {
  const auto entry = reinterpret_cast<chiasm_native_entry_fn>(dlsym(handle_, CHIASM_NATIVE_ENTRY));
  if (entry == nullptr) throw Error(CHIASM_CORRUPT, "the native code has no entry point " CHIASM_NATIVE_ENTRY);
  const chiasm_native_api* api = entry(CHIASM_NATIVE_ABI);
  if (api == nullptr || api->abi != CHIASM_NATIVE_ABI || api->struct_size < sizeof(chiasm_native_api))
    throw Error(CHIASM_VERSION_MISMATCH, "the native code was built for another interface version than " +
                                             std::to_string(CHIASM_NATIVE_ABI) + "; export the bundle again");
  return api;
}

Model::Model(const Request& request) : request_(request) {
  if (request.input_count > kMaxTensors || request.output_count > kMaxTensors)
    throw Error(CHIASM_INVALID_ARGUMENT, "more than " + std::to_string(kMaxTensors) + " inputs or outputs");
  if (request.device_type == CHIASM_CUDA) cuda_.emplace(request.device_index);
  const auto current = make_current();
  library_.emplace(extract_library(request.data, request.size));
  request_.data = nullptr;
  api_ = library_->api();
  char text[1024] = "";
  if (api_->create(request.device_type, request.device_index, &model_, text, sizeof(text)) != 0) throw Error(CHIASM_INTERNAL, text);
}

Model::~Model() {
  try {
    const auto current = make_current();
    api_->destroy(model_);
  } catch (...) {  // the device is gone: so is what the model held there
  }
}

bool Model::worth_forking(const chiasm_tensor* inputs, const chiasm_tensor* outputs) const {
  constexpr size_t kLeast = 64 << 10;
  size_t bytes = 0;
  for (int32_t i = 0; i < request_.input_count; ++i) bytes += plugin::element_count(inputs[i]) * plugin::element_size(inputs[i].dtype);
  for (int32_t i = 0; i < request_.output_count; ++i) bytes += plugin::element_count(outputs[i]) * plugin::element_size(outputs[i].dtype);
  return bytes >= kLeast;
}

void Model::run(const chiasm_tensor* inputs, const chiasm_tensor* outputs, chiasm_native_host host) const {
  std::array<chiasm_native_tensor, kMaxTensors> in;
  std::array<chiasm_native_tensor, kMaxTensors> out;
  for (int32_t i = 0; i < request_.input_count; ++i) in[i] = {inputs[i].data, inputs[i].dtype, inputs[i].ndim, inputs[i].shape};
  for (int32_t i = 0; i < request_.output_count; ++i)
    out[i] = {outputs[i].data, outputs[i].dtype, outputs[i].ndim, outputs[i].shape};
  host.device_type = request_.device_type;
  host.device_index = request_.device_index;
  const auto current = make_current();
  char text[1024];
  text[0] = '\0';
  if (api_->run(model_, in.data(), out.data(), &host, text, sizeof(text)) != 0) throw Error(CHIASM_INTERNAL, text);
}

std::optional<CudaDevice::Current> Model::make_current() const {
  return cuda_ ? std::optional<CudaDevice::Current>(std::in_place, *cuda_) : std::nullopt;
}

}  // namespace chiasm::native
