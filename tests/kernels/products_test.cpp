// Matrix products (runtime/artifact/aoti/products.cpp) against plain loops of doubles, for tensors with
// strides of every kind.
#include <gtest/gtest.h>

#include <functional>
#include <random>

#include "calls.h"
#include "threads.h"

using chiasm::artifact::Dims;
using kernel_calls::Tensor;

namespace {

template <class T>
class Products : public ::testing::Test {
 protected:
  void SetUp() override { use_threads(3); }

  // A random tensor of `sizes`; its last two dimensions are stored in this order or, if `exchanged`, in the
  // other.
  Tensor random(Dims sizes, bool exchanged) {
    const size_t n = sizes.size();
    if (exchanged) std::swap(sizes[n - 2], sizes[n - 1]);
    Tensor tensor = kernel_calls::make(sizes, kernel_calls::kCode<T>);
    std::uniform_real_distribution<double> draw(-1, 1);
    for (int64_t i = 0; i < tensor->numel(); ++i)
      reinterpret_cast<T*>(tensor->data())[i] = static_cast<T>(draw(engine_));
    if (exchanged) {
      std::swap(tensor->sizes[n - 2], tensor->sizes[n - 1]);
      std::swap(tensor->strides[n - 2], tensor->strides[n - 1]);
    }
    return tensor;
  }

  static double at(const AtenTensorOpaque& tensor, int64_t item, int64_t row, int64_t column) {
    const size_t n = tensor.sizes.size();
    const int64_t place = (n == 3 ? item * tensor.strides[0] : 0) + row * tensor.strides[n - 2] +
                          column * tensor.strides[n - 1];
    return static_cast<double>(reinterpret_cast<const T*>(tensor.data())[place]);
  }

  static void expect(const AtenTensorOpaque& out, const AtenTensorOpaque& a, const AtenTensorOpaque& b,
                     const std::function<double(int64_t, int64_t, int64_t)>& added, double alpha) {
    const size_t n = a.sizes.size();
    for (int64_t item = 0; item < (n == 3 ? a.sizes[0] : 1); ++item)
      for (int64_t i = 0; i < out.sizes[n - 2]; ++i)
        for (int64_t j = 0; j < out.sizes[n - 1]; ++j) {
          double sum = 0;
          for (int64_t k = 0; k < a.sizes[n - 1]; ++k) sum += at(a, item, i, k) * at(b, item, k, j);
          ASSERT_NEAR(at(out, item, i, j), alpha * sum + added(item, i, j),
                      (sizeof(T) == 8 ? 1e-14 : 1e-6) * static_cast<double>(a.sizes[n - 1] + 4))
              << item << ", " << i << ", " << j;
        }
  }

  std::mt19937 engine_{31};
};
using Types = ::testing::Types<float, double>;
TYPED_TEST_SUITE(Products, Types);

constexpr int64_t kSizes[][3] = {{1, 1, 1},  {1, 300, 70}, {7, 5, 33},  {50, 64, 16},
                                 {13, 0, 3}, {0, 4, 5},    {30, 3, 200}};

TYPED_TEST(Products, OfMatrices) {
  for (const auto& [m, k, n] : kSizes)
    for (int lies = 0; lies < 8; ++lies) {
      const Tensor a = this->random({m, k}, (lies & 1) != 0), b = this->random({k, n}, (lies & 2) != 0),
                   out = this->random({m, n}, (lies & 4) != 0);
      ASSERT_EQ(aoti_torch_cpu_mm_out(out.get(), a.get(), b.get()), 0) << kernel_calls::last_error;
      this->expect(
          *out, *a, *b, [](int64_t, int64_t, int64_t) { return 0.0; }, 1);
      const Tensor row = this->random({1, n}, false), column = this->random({m, 1}, false),
                   whole = this->random({m, n}, true);
      for (const Tensor* added : {&row, &column, &whole}) {
        ASSERT_EQ(aoti_torch_cpu_addmm_out(out.get(), added->get(), a.get(), b.get(), 0.5, -2), 0)
            << kernel_calls::last_error;
        this->expect(
            *out, *a, *b,
            [&](int64_t, int64_t i, int64_t j) {
              return 0.5 * this->at(**added, 0, added == &row ? 0 : i, added == &column ? 0 : j);
            },
            -2);
      }
      Tensor bias = this->random({1, n}, false);
      bias->sizes = {n};
      bias->strides = {1};
      ASSERT_EQ(aoti_torch_cpu_addmm_out(out.get(), bias.get(), a.get(), b.get(), 1, 1), 0);
      this->expect(
          *out, *a, *b,
          [&](int64_t, int64_t, int64_t j) {
            return static_cast<double>(reinterpret_cast<const TypeParam*>(bias->data())[j]);
          },
          1);
    }
}

TYPED_TEST(Products, OfBatches) {
  for (const auto& [m, k, n] : kSizes)
    for (int lies = 0; lies < 4; ++lies) {
      const Tensor a = this->random({3, m, k}, (lies & 1) != 0), b = this->random({3, k, n}, (lies & 2) != 0),
                   out = this->random({3, m, n}, false), added = this->random({1, m, n}, false);
      ASSERT_EQ(aoti_torch_cpu_bmm_out(out.get(), a.get(), b.get()), 0) << kernel_calls::last_error;
      this->expect(
          *out, *a, *b, [](int64_t, int64_t, int64_t) { return 0.0; }, 1);
      ASSERT_EQ(aoti_torch_cpu_baddbmm_out(out.get(), added.get(), a.get(), b.get(), 2, 1), 0);
      this->expect(
          *out, *a, *b, [&](int64_t, int64_t i, int64_t j) { return 2 * this->at(*added, 0, i, j); }, 1);
    }
}

TYPED_TEST(Products, WhatDoesNotFitIsRefused) {
  const Tensor a = this->random({2, 3}, false), b = this->random({4, 5}, false),
               out = this->random({2, 5}, false), batch = this->random({1, 2, 3}, false),
               good = this->random({3, 5}, false), wide = this->random({1, 4}, false),
               whole = kernel_calls::of<int64_t>({3, 5}, {1});
  for (const auto& [x, y] : {std::pair{&a, &b}, {&batch, &good}, {&a, &whole}}) {
    EXPECT_NE(aoti_torch_cpu_mm_out(out.get(), x->get(), y->get()), 0);
    EXPECT_NE(kernel_calls::last_error.find("matrix product"), std::string::npos) << kernel_calls::last_error;
  }
  EXPECT_NE(aoti_torch_cpu_addmm_out(out.get(), wide.get(), a.get(), good.get(), 1, 1), 0);
  const Tensor whole_a = kernel_calls::of<int64_t>({2, 3}, {1}),
               whole_out = kernel_calls::of<int64_t>({2, 5}, {1});
  EXPECT_NE(aoti_torch_cpu_mm_out(whole_out.get(), whole_a.get(), whole.get()), 0);
}

}  // namespace
