// An artifact for CUDA: implements, by the CUDA driver, the functions of the CUDA runtime, the driver and
// libtorch that AOTInductor's code calls. The native backend has opened the driver in the process; no CUDA
// library is linked.
//
// The contracts are those of cuda.h, cuda_runtime_api.h and torch/csrc/inductor/aoti_torch/c/shim.h.
#include <cuda.h>
#include <cuda_runtime_api.h>
#include <dlfcn.h>
#include <torch/csrc/inductor/aoti_torch/c/shim.h>

#include <string>

#include "memory.h"
#include "tensor.h"

// The driver's function of a name that cuda.h declares.
#define CHIASM_DRIVER(function) ::chiasm::artifact::driver<decltype(&::function)>(#function)

namespace chiasm::artifact {
namespace {

void* find_in_driver(const char* name) {
  static void* const library = dlopen("libcuda.so.1", RTLD_NOW | RTLD_LOCAL);
  void* found = library != nullptr ? dlsym(library, name) : nullptr;
  if (found == nullptr) throw std::runtime_error(std::string("the CUDA driver has no ") + name);
  return found;
}

template <class Function>
Function driver(const char* name) {
  return reinterpret_cast<Function>(find_in_driver(name));
}

void check(CUresult result, const char* what) {
  if (result == CUDA_SUCCESS) return;
  const char* text = nullptr;
  CHIASM_DRIVER(cuGetErrorString)(result, &text);
  throw std::runtime_error(std::string("CUDA: ") + what + ": " + (text != nullptr ? text : "unknown error"));
}

CUstream stream() {
  const Run* run = current_run();
  return run != nullptr ? static_cast<CUstream>(run->host->stream) : nullptr;
}

CUdeviceptr address(const void* data) { return reinterpret_cast<CUdeviceptr>(data); }

}  // namespace

// Only Inductor's loops on the CPU have teams.
Run* run_of_this_thread() { return current_run(); }
bool in_parallel_region() { return false; }

namespace memory {

const bool host_can_read = false;
const int64_t most_elements = INT32_MAX;  // indices of 64 bits cost several times as much

void copy(void* to, const void* from, size_t bytes) {
  static const auto call = CHIASM_DRIVER(cuMemcpyAsync);
  check(call(address(to), address(from), bytes, stream()), "copy");
}

void zero(void* data, size_t bytes) {
  static const auto call = CHIASM_DRIVER(cuMemsetD8Async);
  check(call(address(data), 0, bytes, stream()), "fill");
}

void read(void* to, const void* from, size_t bytes) {
  static const auto copy = CHIASM_DRIVER(cuMemcpyDtoHAsync_v2);
  static const auto wait = CHIASM_DRIVER(cuStreamSynchronize);
  check(copy(to, address(from), bytes, stream()), "read");
  check(wait(stream()), "read");
}

void wait_for_all() { CHIASM_DRIVER(cuCtxSynchronize)(); }

}  // namespace memory
}  // namespace chiasm::artifact

using chiasm::artifact::address;

extern "C" {

// --- the driver --------------------------------------------------------------------------------------------

CUresult cuGetErrorString(CUresult error, const char** text) {
  return CHIASM_DRIVER(cuGetErrorString)(error, text);
}

CUresult cuModuleLoad(CUmodule*, const char*) {
  return CUDA_ERROR_NOT_SUPPORTED;
}  // from files: code is in the artifact

CUresult cuModuleLoadData(CUmodule* module, const void* image) {
  return CHIASM_DRIVER(cuModuleLoadData)(module, image);
}

CUresult cuModuleUnload(CUmodule module) { return CHIASM_DRIVER(cuModuleUnload)(module); }

CUresult cuModuleGetFunction(CUfunction* function, CUmodule module, const char* name) {
  return CHIASM_DRIVER(cuModuleGetFunction)(function, module, name);
}

CUresult cuFuncSetAttribute(CUfunction function, CUfunction_attribute attribute, int value) {
  return CHIASM_DRIVER(cuFuncSetAttribute)(function, attribute, value);
}

CUresult cuLaunchKernel(CUfunction function, unsigned grid_x, unsigned grid_y, unsigned grid_z,
                        unsigned block_x, unsigned block_y, unsigned block_z, unsigned shared_bytes,
                        CUstream stream, void** arguments, void** extra) {
  static const auto call = CHIASM_DRIVER(cuLaunchKernel);
  return call(function, grid_x, grid_y, grid_z, block_x, block_y, block_z, shared_bytes, stream, arguments,
              extra);
}

// --- the runtime -------------------------------------------------------------------------------------------
// Since CUDA 10.1 the driver and the runtime number their errors alike. The native backend makes the device
// current.

const char* cudaGetErrorString(cudaError_t error) {
  const char* text = nullptr;
  CHIASM_DRIVER(cuGetErrorString)(static_cast<CUresult>(error), &text);
  return text != nullptr ? text : "unknown error";
}

cudaError_t cudaGetLastError() { return cudaSuccess; }
cudaError_t cudaGetDevice(int* device) {
  return static_cast<cudaError_t>(CHIASM_DRIVER(cuCtxGetDevice)(device));
}
cudaError_t cudaSetDevice(int) { return cudaSuccess; }

cudaError_t cudaMalloc(void** data, size_t bytes) {
  return static_cast<cudaError_t>(CHIASM_DRIVER(cuMemAlloc_v2)(reinterpret_cast<CUdeviceptr*>(data), bytes));
}

cudaError_t cudaFree(void* data) {
  return static_cast<cudaError_t>(CHIASM_DRIVER(cuMemFree_v2)(address(data)));
}

cudaError_t cudaMemcpy(void* to, const void* from, size_t bytes, cudaMemcpyKind) {
  return static_cast<cudaError_t>(CHIASM_DRIVER(cuMemcpy)(address(to), address(from), bytes));
}

// By these events AOTInductor waits until an instance's work has run before it uses the instance again. A run
// changes nothing in an instance, so there is nothing to wait for; and querying an event would end the
// capture of a graph.
cudaError_t cudaEventCreate(cudaEvent_t* event) {
  *event = nullptr;
  return cudaSuccess;
}
cudaError_t cudaEventDestroy(cudaEvent_t) { return cudaSuccess; }
cudaError_t cudaEventRecord(cudaEvent_t, cudaStream_t) { return cudaSuccess; }
cudaError_t cudaEventQuery(cudaEvent_t) { return cudaSuccess; }
cudaError_t cudaEventSynchronize(cudaEvent_t) { return cudaSuccess; }

// --- libtorch ----------------------------------------------------------------------------------------------
// Guards make a device and a stream current. The native backend has made the device current, and all
// functions here take a stream.

AOTITorchError aoti_torch_create_cuda_guard(int32_t, CUDAGuardHandle* guard) {
  *guard = nullptr;
  return AOTI_TORCH_SUCCESS;
}
AOTITorchError aoti_torch_delete_cuda_guard(CUDAGuardHandle) { return AOTI_TORCH_SUCCESS; }
AOTITorchError aoti_torch_cuda_guard_set_index(CUDAGuardHandle, int32_t) { return AOTI_TORCH_SUCCESS; }
AOTITorchError aoti_torch_create_cuda_stream_guard(void*, int32_t, CUDAStreamGuardHandle* guard) {
  *guard = nullptr;
  return AOTI_TORCH_SUCCESS;
}
AOTITorchError aoti_torch_delete_cuda_stream_guard(CUDAStreamGuardHandle) { return AOTI_TORCH_SUCCESS; }

AOTITorchError aoti_torch_get_current_cuda_stream(int32_t, void** stream) {
  *stream = chiasm::artifact::stream();
  return AOTI_TORCH_SUCCESS;
}

// Copies an input that is not aligned for vectors to memory that is.
AOTITorchError aoti_torch_clone_preserve_strides(AtenTensorHandle self, AtenTensorHandle* result) {
  return aoti_torch_clone(self, result);  // inputs are dense
}

void aoti_torch_warn(const char*, const char*, uint32_t, const char*) {}

}  // extern "C"
