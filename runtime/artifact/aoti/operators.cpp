// The ATen operators that AOTInductor calls instead of compiling, for the ops that need one (declared in
// torch/csrc/inductor/aoti_torch/generated/c_shim_cpu.h). CPU only.
#include <torch/csrc/inductor/aoti_torch/generated/c_shim_cpu.h>

#include <algorithm>

#include "sorting.h"
#include "tensor.h"

using namespace chiasm::artifact;

namespace {

// Running sums along the middle dimension of (outer, n, inner). Floats are summed in double, as in PyTorch;
// integers wrap around, signed ones too.
template <class T, class Sum>
void running_sums(const T* values, int64_t outer, int64_t n, int64_t inner, T* sums) {
  std::vector<Sum> total(inner);
  for (int64_t o = 0; o < outer; ++o) {
    std::fill(total.begin(), total.end(), Sum(0));
    for (int64_t i = 0; i < n; ++i, values += inner, sums += inner)
      for (int64_t k = 0; k < inner; ++k) sums[k] = static_cast<T>(total[k] += static_cast<Sum>(values[k]));
  }
}

}  // namespace

extern "C" AOTITorchError aoti_torch_cpu_cumsum(AtenTensorHandle self, int64_t dim, int32_t* dtype,
                                                AtenTensorHandle* result) {
  return guarded([&] {
    const int64_t ndim = static_cast<int64_t>(self->sizes.size());
    if (dim < 0) dim += ndim;
    if (dim < 0 || dim >= ndim)
      throw std::runtime_error("cumsum: there is no dimension " + std::to_string(dim));
    if (dtype && *dtype != self->dtype)
      throw std::runtime_error("cumsum is not there for a change of element type");
    int64_t outer = 1, inner = 1;
    for (int64_t d = 0; d < dim; ++d) outer *= self->sizes[d];
    for (int64_t d = dim + 1; d < ndim; ++d) inner *= self->sizes[d];
    std::unique_ptr<AtenTensorOpaque> packed;
    const AtenTensorOpaque& source = dense(*self, packed);
    std::unique_ptr<AtenTensorOpaque> sums(allocate(self->sizes, dense_strides(self->sizes), self->dtype));
    const auto fill = [&](auto zero, auto sum) {
      using T = decltype(zero);
      running_sums<T, decltype(sum)>(reinterpret_cast<const T*>(source.data()), outer, self->sizes[dim],
                                     inner, reinterpret_cast<T*>(sums->data()));
    };
    switch (self->dtype) {
      case kFloat: fill(float{}, double{}); break;
      case kDouble: fill(double{}, double{}); break;
      case kInt64: fill(int64_t{}, uint64_t{}); break;
      case kInt32: fill(int32_t{}, uint32_t{}); break;
      default:
        throw std::runtime_error("cumsum is not there for element type " + std::to_string(self->dtype));
    }
    *result = sums.release();
  });
}

extern "C" AOTITorchError aoti_torch_cpu_topk(AtenTensorHandle self, int64_t k, int64_t dim, int32_t largest,
                                              int32_t, AtenTensorHandle* values, AtenTensorHandle* indices) {
  return guarded([&] {
    const int64_t ndim = static_cast<int64_t>(self->sizes.size());
    if (ndim == 0 || (dim != -1 && dim != ndim - 1))
      throw std::runtime_error("topk is compiled for the last dimension only");
    const int64_t n = self->sizes.back();
    if (k < 0 || k > n)
      throw std::runtime_error("topk: " + std::to_string(k) + " values asked for, the dimension has " +
                               std::to_string(n));
    std::unique_ptr<AtenTensorOpaque> packed;
    const AtenTensorOpaque& source = dense(*self, packed);
    Dims sizes = self->sizes;
    sizes.back() = k;
    const int64_t rows = n ? self->numel() / n : 0;
    std::unique_ptr<AtenTensorOpaque> top(allocate(sizes, dense_strides(sizes), self->dtype));
    std::unique_ptr<AtenTensorOpaque> index(allocate(sizes, dense_strides(sizes), kInt64));
    auto* positions = reinterpret_cast<int64_t*>(index->data());
    const auto fill = [&](auto zero) {
      using T = decltype(zero);
      topk_rows(reinterpret_cast<const T*>(source.data()), rows, n, k, largest != 0,
                reinterpret_cast<T*>(top->data()), positions);
    };
    switch (self->dtype) {
      case kFloat: fill(float{}); break;
      case kDouble: fill(double{}); break;
      case kInt64: fill(int64_t{}); break;
      case kInt32: fill(int32_t{}); break;
      default: throw std::runtime_error("topk is not there for element type " + std::to_string(self->dtype));
    }
    *values = top.release();
    *indices = index.release();
  });
}
