/** A CUDA driver for tests of errors. It has one device, whose memory is the host's; a test says which call
 *  fails. */
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <string>

namespace {

using Address = unsigned long long;

std::string failing;
int failure = 0;

int result_of(const char* function) { return function == failing ? failure : 0; }

}  // namespace

extern "C" {

/** From now on `function` gives `result`, a CUresult, and every other one succeeds. */
void fake_cuda_fail(const char* function, int result) {
  failing = function;
  failure = result;
}

int cuInit(unsigned) { return result_of(__func__); }
int cuDeviceGetCount(int* count) {
  *count = 1;
  return result_of(__func__);
}
int cuDeviceGet(int* device, int index) {
  *device = index;
  return result_of(__func__);
}
int cuDeviceGetAttribute(int* value, int, int) {
  *value = 9;
  return result_of(__func__);
}
int cuDevicePrimaryCtxRetain(void** context, int) {
  *context = &failing;
  return result_of(__func__);
}
int cuDevicePrimaryCtxRelease_v2(int) { return result_of(__func__); }
int cuCtxPushCurrent_v2(void*) { return result_of(__func__); }
int cuCtxPopCurrent_v2(void**) { return result_of(__func__); }
int cuCtxSynchronize() { return result_of(__func__); }

int cuMemAlloc_v2(Address* address, std::size_t bytes) {
  const int result = result_of(__func__);
  if (result == 0) *address = reinterpret_cast<Address>(std::malloc(bytes));
  return result;
}
int cuMemFree_v2(Address address) {
  std::free(reinterpret_cast<void*>(address));
  return 0;
}
int cuMemAllocAsync(Address* address, std::size_t bytes, void*) { return cuMemAlloc_v2(address, bytes); }
int cuMemFreeAsync(Address address, void*) { return cuMemFree_v2(address); }
int cuMemcpyHtoD_v2(Address to, const void* from, std::size_t bytes) {
  std::memcpy(reinterpret_cast<void*>(to), from, bytes);
  return result_of(__func__);
}
int cuMemcpyDtoH_v2(void* to, Address from, std::size_t bytes) {
  std::memcpy(to, reinterpret_cast<const void*>(from), bytes);
  return result_of(__func__);
}

int cuStreamCreate(void** stream, unsigned) {
  *stream = &failing;
  return result_of(__func__);
}
int cuStreamDestroy_v2(void*) { return result_of(__func__); }
int cuStreamWaitEvent(void*, void*, unsigned) { return result_of(__func__); }
int cuEventCreate(void** event, unsigned) {
  *event = &failing;
  return result_of(__func__);
}
int cuEventRecord(void*, void*) { return result_of(__func__); }
int cuEventDestroy_v2(void*) { return result_of(__func__); }

int cuGetErrorString(int, const char** text) {
  *text = "what the test asked for";
  return 0;
}

}  // extern "C"
