// The ATen operators that AOTInductor calls instead of compiling, for the ops that need one (declared in
// torch/csrc/inductor/aoti_torch/generated/c_shim_cpu.h). CPU only.
#include <torch/csrc/inductor/aoti_torch/generated/c_shim_cpu.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "tensor.h"

using namespace chiasm::shim;

namespace {

// NaN sorts as the largest value, as in PyTorch; equal values keep their order, so that every backend picks the same ones.
template <class T>
void topk_rows(const T* values, int64_t rows, int64_t n, int64_t k, bool largest, T* top, int64_t* index) {
  std::vector<int64_t> order(n);
  for (int64_t row = 0; row < rows; ++row, values += n, top += k, index += k) {
    const auto before = [&](int64_t a, int64_t b) {
      const T x = values[a], y = values[b];
      const bool x_nan = x != x, y_nan = y != y;
      if (x_nan != y_nan) return largest == x_nan;
      if (!x_nan && x != y) return largest ? x > y : x < y;
      return a < b;
    };
    std::iota(order.begin(), order.end(), 0);
    std::partial_sort(order.begin(), order.begin() + k, order.end(), before);
    for (int64_t i = 0; i < k; ++i) {
      index[i] = order[i];
      top[i] = values[order[i]];
    }
  }
}

}  // namespace

extern "C" AOTITorchError aoti_torch_cpu_topk(AtenTensorHandle self, int64_t k, int64_t dim, int32_t largest, int32_t,
                                              AtenTensorHandle* values, AtenTensorHandle* indices) {
  return guarded([&] {
    const int64_t ndim = static_cast<int64_t>(self->sizes.size());
    if (ndim == 0 || (dim != -1 && dim != ndim - 1)) throw std::runtime_error("topk is compiled for the last dimension only");
    const int64_t n = self->sizes.back();
    if (k > n) throw std::runtime_error("topk: " + std::to_string(k) + " values asked for, the dimension has " + std::to_string(n));
    std::unique_ptr<AtenTensorOpaque> packed;
    if (!self->is_dense()) {
      packed.reset(allocate(self->sizes, dense_strides(self->sizes), self->dtype));
      copy(*self, *packed);
    }
    const AtenTensorOpaque& source = packed ? *packed : *self;
    Dims sizes = self->sizes;
    sizes.back() = k;
    const int64_t rows = n ? self->numel() / n : 0;
    std::unique_ptr<AtenTensorOpaque> top(allocate(sizes, dense_strides(sizes), self->dtype));
    std::unique_ptr<AtenTensorOpaque> index(allocate(sizes, dense_strides(sizes), kInt64));
    auto* positions = reinterpret_cast<int64_t*>(index->data());
    const auto fill = [&](auto zero) {
      using T = decltype(zero);
      topk_rows(reinterpret_cast<const T*>(source.data()), rows, n, k, largest != 0, reinterpret_cast<T*>(top->data()), positions);
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
