// The functions of AOTInductor's C interface that a compiled op calls, over chiasm::artifact's tensors.
// Declared, with their contracts, in torch/csrc/inductor/aoti_torch/c/shim.h; only those that compiled ops
// were seen to need.
#include <torch/csrc/inductor/aoti_torch/c/shim.h>

#include <algorithm>

#include "memory.h"
#include "tensor.h"

using namespace chiasm::artifact;

namespace {

template <class T>
AOTITorchError item(AtenTensorHandle tensor, T* value) {
  return guarded([&] {
    if (tensor->numel() != 1 || element_size(tensor->dtype) != sizeof(T))
      throw std::runtime_error("the compiled op reads a number from a tensor of another size");
    memory::read(value, tensor->data(), sizeof(T));
  });
}

}  // namespace

extern "C" {

int32_t aoti_torch_device_type_cpu() { return 0; }
int32_t aoti_torch_device_type_cuda() { return 1; }
#define CHIASM_DTYPE_FUNCTION(dtype, name, ...) \
  int32_t aoti_torch_dtype_##name() { return chiasm::base::kDTypes[dtype].torch; }
CHIASM_DTYPES(CHIASM_DTYPE_FUNCTION)
#undef CHIASM_DTYPE_FUNCTION
int32_t aoti_torch_layout_strided() { return 0; }

void aoti_torch_check(bool condition, const char*, const char*, uint32_t, const char* message) {
  if (condition) return;
  if (!in_parallel_region()) throw std::runtime_error(message);
  refuse(message);  // an exception must not leave a parallel region
}

AOTITorchError aoti_torch_delete_tensor_object(AtenTensorHandle tensor) {
  delete tensor;
  return AOTI_TORCH_SUCCESS;
}

AOTITorchError aoti_torch_get_data_ptr(AtenTensorHandle tensor, void** result) {
  *result = tensor->data();
  return AOTI_TORCH_SUCCESS;
}

AOTITorchError aoti_torch_get_storage_size(AtenTensorHandle tensor, int64_t* result) {
  *result = static_cast<int64_t>(tensor->storage->bytes);
  return AOTI_TORCH_SUCCESS;
}

AOTITorchError aoti_torch_get_dim(AtenTensorHandle tensor, int64_t* result) {
  *result = static_cast<int64_t>(tensor->sizes.size());
  return AOTI_TORCH_SUCCESS;
}

AOTITorchError aoti_torch_get_numel(AtenTensorHandle tensor, int64_t* result) {
  *result = tensor->numel();
  return AOTI_TORCH_SUCCESS;
}

AOTITorchError aoti_torch_get_sizes(AtenTensorHandle tensor, int64_t** result) {
  *result = tensor->sizes.data();
  return AOTI_TORCH_SUCCESS;
}

AOTITorchError aoti_torch_get_size(AtenTensorHandle tensor, int64_t dim, int64_t* result) {
  return guarded([&] { *result = tensor->sizes.at(dim); });
}

AOTITorchError aoti_torch_get_strides(AtenTensorHandle tensor, int64_t** result) {
  *result = tensor->strides.data();
  return AOTI_TORCH_SUCCESS;
}

AOTITorchError aoti_torch_get_stride(AtenTensorHandle tensor, int64_t dim, int64_t* result) {
  return guarded([&] { *result = tensor->strides.at(dim); });
}

AOTITorchError aoti_torch_get_dtype(AtenTensorHandle tensor, int32_t* result) {
  *result = tensor->dtype;
  return AOTI_TORCH_SUCCESS;
}

AOTITorchError aoti_torch_get_device_type(AtenTensorHandle tensor, int32_t* result) {
  *result = tensor->device_type;
  return AOTI_TORCH_SUCCESS;
}

AOTITorchError aoti_torch_get_device_index(AtenTensorHandle tensor, int32_t* result) {
  *result = tensor->device_index;
  return AOTI_TORCH_SUCCESS;
}

AOTITorchError aoti_torch_get_storage_offset(AtenTensorHandle tensor, int64_t* result) {
  *result = tensor->offset;
  return AOTI_TORCH_SUCCESS;
}

AOTITorchError aoti_torch_new_tensor_handle(AtenTensorHandle tensor, AtenTensorHandle* result) {
  return guarded([&] { *result = new AtenTensorOpaque(*tensor); });
}

AOTITorchError aoti_torch_empty_strided(int64_t ndim, const int64_t* sizes, const int64_t* strides,
                                        int32_t dtype, int32_t, int32_t, AtenTensorHandle* result) {
  return guarded(
      [&] { *result = allocate(Dims(sizes, sizes + ndim), Dims(strides, strides + ndim), dtype); });
}

AOTITorchError aoti_torch__reinterpret_tensor(AtenTensorHandle self, int64_t ndim, const int64_t* sizes,
                                              const int64_t* strides, int64_t offset,
                                              AtenTensorHandle* result) {
  return guarded([&] {
    auto view = std::make_unique<AtenTensorOpaque>(*self);
    view->sizes.assign(sizes, sizes + ndim);
    view->strides.assign(strides, strides + ndim);
    view->offset += offset;
    if (view->offset < 0 || (view->offset + span(view->sizes, view->strides)) * element_size(view->dtype) >
                                static_cast<int64_t>(view->storage->bytes))
      throw std::runtime_error("the compiled op views memory outside of a tensor");
    *result = view.release();
  });
}

// Constants embedded in the artifact, and scalars on the stack of the generated code.
AOTITorchError aoti_torch_create_tensor_from_blob_v2(void* data, int64_t ndim, const int64_t* sizes,
                                                     const int64_t* strides, int64_t offset, int32_t dtype,
                                                     int32_t device_type, int32_t device_index,
                                                     AtenTensorHandle* result, int32_t, const uint8_t*,
                                                     int64_t) {
  return guarded([&] {
    auto tensor = std::make_unique<AtenTensorOpaque>();
    tensor->sizes.assign(sizes, sizes + ndim);
    tensor->strides.assign(strides, strides + ndim);
    tensor->offset = offset;
    tensor->dtype = dtype;
    tensor->device_type = device_type;
    tensor->device_index = device_index;
    tensor->storage = std::make_shared<Storage>();
    tensor->storage->data = static_cast<char*>(data);
    tensor->storage->bytes = (tensor->numel() + offset) * element_size(dtype);
    *result = tensor.release();
  });
}

AOTITorchError aoti_torch_create_tensor_from_blob(void* data, int64_t ndim, const int64_t* sizes,
                                                  const int64_t* strides, int64_t offset, int32_t dtype,
                                                  int32_t device_type, int32_t device_index,
                                                  AtenTensorHandle* result) {
  return aoti_torch_create_tensor_from_blob_v2(data, ndim, sizes, strides, offset, dtype, device_type,
                                               device_index, result, 0, nullptr, 0);
}

AOTITorchError aoti_torch_assign_tensors_out(AtenTensorHandle source, AtenTensorHandle* result) {
  return aoti_torch_new_tensor_handle(source, result);
}

AOTITorchError aoti_torch_copy_(AtenTensorHandle self, AtenTensorHandle source, int32_t) {
  return guarded([&] {
    if (self->dtype != source->dtype || self->sizes != source->sizes)
      throw std::runtime_error("the compiled op copies between tensors of different shape or dtype");
    copy(*source, *self);
  });
}

AOTITorchError aoti_torch_clone(AtenTensorHandle self, AtenTensorHandle* result) {
  return guarded([&] {
    std::unique_ptr<AtenTensorOpaque> target(allocate(self->sizes, dense_strides(self->sizes), self->dtype));
    copy(*self, *target);
    *result = target.release();
  });
}

AOTITorchError aoti_torch_item_bool(AtenTensorHandle tensor, bool* result) { return item(tensor, result); }

AOTITorchError aoti_torch_item_int64(AtenTensorHandle tensor, int64_t* result) {
  return item(tensor, result);
}

AOTITorchError aoti_torch_item_float32(AtenTensorHandle tensor, float* result) {
  return item(tensor, result);
}

AOTITorchError aoti_torch_item_float64(AtenTensorHandle tensor, double* result) {
  return item(tensor, result);
}

AOTITorchError aoti_torch_zero_(AtenTensorHandle self) {
  return guarded([&] {
    if (!self->is_dense()) throw std::runtime_error("the compiled op zeroes a strided tensor");
    memory::zero(self->data(), self->numel() * element_size(self->dtype));
  });
}

}  // extern "C"
