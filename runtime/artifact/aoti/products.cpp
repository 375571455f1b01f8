// Matrix products that AOTInductor leaves to libtorch (declared in
// torch/csrc/inductor/aoti_torch/generated/c_shim_cpu.h). CPU only.
#include <omp.h>
#include <torch/csrc/inductor/aoti_torch/generated/c_shim_cpu.h>

#include <algorithm>

#include "artifact/kernels/products.h"
#include "tensor.h"

using namespace chiasm::artifact;

namespace {

using chiasm::kernels::Block;
using chiasm::kernels::kPanel;
namespace hn = chiasm::kernels::hn;

// A strided matrix; a stride of 0 broadcasts.
template <class T>
struct Matrix {
  T* data;
  int64_t rows, columns, down, along;

  T& at(int64_t row, int64_t column) const { return data[row * down + column * along]; }
};

// Matrix `item` of a batch, or the only one.
template <class T>
Matrix<T> matrix(const AtenTensorOpaque& tensor, int64_t item) {
  const size_t n = tensor.sizes.size();
  T* const data = reinterpret_cast<T*>(tensor.data()) + (n == 3 ? item * tensor.strides[0] : 0);
  return {data, tensor.sizes[n - 2], tensor.sizes[n - 1], tensor.strides[n - 2], tensor.strides[n - 1]};
}

// The summand, broadcast to the shape of `batch` products.
template <class T>
Matrix<T> broadcast(const AtenTensorOpaque& tensor, int64_t item, int64_t batch, const Matrix<T>& like) {
  Matrix<T> added{reinterpret_cast<T*>(tensor.data()), like.rows, like.columns, 0, 0};
  const int64_t wanted[] = {batch, like.rows, like.columns};
  int64_t strides[3] = {0, 0, 0};
  const size_t n = tensor.sizes.size(), missing = 3 - std::min<size_t>(n, 3);
  if (n > 3) throw std::runtime_error("a matrix product adds a tensor of another shape");
  for (size_t d = 0; d < n; ++d) {
    const int64_t size = tensor.sizes[d];
    if (size != 1 && size != wanted[missing + d])
      throw std::runtime_error("a matrix product adds a tensor of another shape");
    strides[missing + d] = size == 1 ? 0 : tensor.strides[d];
  }
  added.data += item * strides[0];
  added.down = strides[1];
  added.along = strides[2];
  return added;
}

// Number of values of a matrix; throws if it overflows.
template <class T>
size_t count(int64_t rows, int64_t columns) {
  int64_t bytes = 0;
  if (__builtin_mul_overflow(rows, columns, &bytes) ||
      __builtin_mul_overflow(bytes, static_cast<int64_t>(sizeof(T)), &bytes))
    throw std::runtime_error("a matrix product of more values than memory can hold");
  return static_cast<size_t>(bytes) / sizeof(T);
}

// out = beta added + alpha a b. Without `added` nothing is added.
template <class T>
void multiply(const Matrix<T>& a, const Matrix<T>& b, const Matrix<T>& out, const Matrix<T>* added, T beta,
              T alpha) {
  constexpr int64_t rows = Block<T>::kRows;
  const int64_t depth = a.columns, panels = (b.columns + kPanel - 1) / kPanel;
  const int64_t blocks = (a.rows + rows - 1) / rows;
  std::vector<T> packed(count<T>(panels * kPanel, depth)), dense(a.along == 1 ? 0 : count<T>(a.rows, depth));
#pragma omp parallel for
  for (int64_t panel = 0; panel < panels; ++panel) {
    T* const to = packed.data() + panel * depth * kPanel;
    const int64_t there = std::min(kPanel, b.columns - panel * kPanel);
    for (int64_t k = 0; k < depth; ++k)
      for (int64_t n = 0; n < there; ++n) to[k * kPanel + n] = b.at(k, panel * kPanel + n);
  }
  if (!dense.empty()) {
#pragma omp parallel for
    for (int64_t row = 0; row < a.rows; ++row)
      for (int64_t k = 0; k < depth; ++k) dense[static_cast<size_t>(row * depth + k)] = a.at(row, k);
  }
  const T* const values = dense.empty() ? a.data : dense.data();
  const int64_t down = dense.empty() ? a.down : depth;
  // A task is a block of rows times a few panels, so that even a product with few rows has work for all
  // threads.
  constexpr int64_t some = 8;
  const int64_t chunks = (panels + some - 1) / some;
#pragma omp parallel for
  for (int64_t task = 0; task < blocks * chunks; ++task) {
    const int64_t first = task / chunks * rows, there = std::min(rows, a.rows - first);
    const T* pieces[rows];
    for (int64_t r = 0; r < rows; ++r) pieces[r] = values + (first + std::min(r, there - 1)) * down;
    const auto put = [&](int64_t row, int64_t column, auto sums) {
      constexpr int64_t lanes = chiasm::kernels::kLanes<T>;
      T each[lanes];
      hn::StoreU(sums, chiasm::kernels::Lanes<T>(), each);
      for (int64_t n = 0; row < there && n < std::min(lanes, out.columns - column); ++n)
        out.at(first + row, column + n) =
            added ? beta * added->at(first + row, column + n) + alpha * each[n] : alpha * each[n];
    };
    const int64_t begin = task % chunks * some, size = depth * kPanel;
    chiasm::kernels::multiply_panels<T>(
        begin, std::min(begin + some, panels), [&](auto together, int64_t panel) {
          const T nothing[together * kPanel] = {};
          chiasm::kernels::multiply<together>(
              pieces, 1, depth, 0, packed.data() + panel * size, size, nothing,
              [&](int64_t row, int64_t k, auto sums) { put(row, panel * kPanel + k, sums); });
        });
  }
}

// The same for tensors: matrices, or batches of them.
AOTITorchError product(AtenTensorHandle out, AtenTensorHandle added, AtenTensorHandle a, AtenTensorHandle b,
                       size_t dimensions, double beta, double alpha) {
  return guarded([&] {
    const auto fits = [&](const AtenTensorOpaque& tensor) {
      return tensor.sizes.size() == dimensions && tensor.dtype == a->dtype;
    };
    const size_t last = dimensions - 1;
    if (!fits(*a) || !fits(*b) || !fits(*out) || (added && added->dtype != a->dtype) ||
        a->sizes[last] != b->sizes[last - 1] || a->sizes[last - 1] != out->sizes[last - 1] ||
        b->sizes[last] != out->sizes[last] ||
        (dimensions == 3 && (a->sizes[0] != b->sizes[0] || a->sizes[0] != out->sizes[0])))
      throw std::runtime_error(
          "a matrix product's shapes or types do not belong together: export the op again");
    const auto all = [&](auto zero) {
      using T = decltype(zero);
      const int64_t batch = dimensions == 3 ? a->sizes[0] : 1;
      for (int64_t item = 0; item < batch; ++item) {
        const auto result = matrix<T>(*out, item);
        const auto sum = added ? broadcast<T>(*added, item, batch, result) : result;
        multiply<T>(matrix<T>(*a, item), matrix<T>(*b, item), result, added && beta != 0 ? &sum : nullptr,
                    static_cast<T>(beta), static_cast<T>(alpha));
      }
    };
    switch (a->dtype) {
      case kFloat: all(float{}); break;
      case kDouble: all(double{}); break;
      default:
        throw std::runtime_error("a matrix product is not there for element type " +
                                 std::to_string(a->dtype));
    }
  });
}

}  // namespace

extern "C" AOTITorchError aoti_torch_cpu_mm_out(AtenTensorHandle out, AtenTensorHandle self,
                                                AtenTensorHandle mat2) {
  return product(out, nullptr, self, mat2, 2, 0, 1);
}

extern "C" AOTITorchError aoti_torch_cpu_addmm_out(AtenTensorHandle out, AtenTensorHandle self,
                                                   AtenTensorHandle mat1, AtenTensorHandle mat2, double beta,
                                                   double alpha) {
  return product(out, self, mat1, mat2, 2, beta, alpha);
}

extern "C" AOTITorchError aoti_torch_cpu_bmm_out(AtenTensorHandle out, AtenTensorHandle self,
                                                 AtenTensorHandle mat2) {
  return product(out, nullptr, self, mat2, 3, 0, 1);
}

extern "C" AOTITorchError aoti_torch_cpu_baddbmm_out(AtenTensorHandle out, AtenTensorHandle self,
                                                     AtenTensorHandle batch1, AtenTensorHandle batch2,
                                                     double beta, double alpha) {
  return product(out, self, batch1, batch2, 3, beta, alpha);
}
