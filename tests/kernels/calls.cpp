// The parts of aoti/entry.cpp that the kernels' calls need, with guards around every tensor.
#include "calls.h"

#include <map>

namespace kernel_calls {

guarded::Placement placement = guarded::Placement::kEnd;
int damaged = 0;
std::string last_error;

namespace {

std::map<void*, std::unique_ptr<guarded::Buffer>> buffers;

void release(void*, void* data, size_t) {
  const auto found = buffers.find(data);
  if (!found->second->is_intact()) ++damaged;
  buffers.erase(found);
}

const chiasm_native_host host{nullptr, nullptr, release, nullptr, 0, 0, nullptr, 1};

}  // namespace

Tensor make(const chiasm::artifact::Dims& sizes, int32_t dtype) {
  return Tensor(chiasm::artifact::allocate(sizes, chiasm::artifact::dense_strides(sizes), dtype));
}

}  // namespace kernel_calls

namespace chiasm::artifact {

AtenTensorOpaque* allocate(Dims sizes, Dims strides, int32_t dtype) {
  auto tensor = std::make_unique<AtenTensorOpaque>();
  tensor->sizes = std::move(sizes);
  tensor->strides = std::move(strides);
  tensor->dtype = dtype;
  if (tensor->numel() < 0 || tensor->numel() > int64_t{1} << 32) throw std::bad_alloc();
  tensor->storage = std::make_shared<Storage>();
  tensor->storage->bytes = static_cast<size_t>(tensor->numel() * element_size(dtype));
  auto buffer = std::make_unique<guarded::Buffer>(tensor->storage->bytes, kernel_calls::placement);
  tensor->storage->data = static_cast<char*>(buffer->data());
  tensor->storage->owner = &kernel_calls::host;
  kernel_calls::buffers[buffer->data()] = std::move(buffer);
  return tensor.release();
}

void copy(const AtenTensorOpaque& source, AtenTensorOpaque& target) {
  Dims index(source.sizes.size(), 0);
  const int64_t size = element_size(source.dtype);
  for (int64_t i = 0; i < source.numel(); ++i) {
    int64_t from = 0;
    for (size_t d = 0; d < index.size(); ++d) from += index[d] * source.strides[d];
    std::memcpy(target.data() + i * size, source.data() + from * size, static_cast<size_t>(size));
    for (size_t d = index.size(); d-- > 0 && ++index[d] == source.sizes[d];) index[d] = 0;
  }
}

int32_t guarded_failure(const char* what) {
  kernel_calls::last_error = what;
  return 1;
}

int32_t guarded_out_of_memory() { return guarded_failure("out of memory"); }

}  // namespace chiasm::artifact
