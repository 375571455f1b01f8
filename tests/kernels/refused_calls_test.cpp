// The kernels' calls reject arguments that the loops do not support: with one sentence that names the
// argument, and without a result. Most calls are made from the kernels' declarations (refused_calls.inc, by
// runtime/artifact/generate.py).
#include <gtest/gtest.h>

#include <functional>

#include "calls.h"
#include "fixture.h"

using namespace chiasm::artifact;
using kernel_calls::of;
using kernel_calls::Tensor;

namespace {

Tensor floats(const Dims& sizes) { return of<float>(sizes, {0.5f}); }

void expect_refused(const std::string& argument, const std::function<Call(Handle*)>& call,
                    const std::string& expected = "") {
  Handle result = nullptr;
  kernel_calls::last_error.clear();
  ASSERT_NE(call(&result), 0) << argument << ": " << expected;
  EXPECT_EQ(result, nullptr) << argument;
  EXPECT_EQ(kernel_calls::last_error.rfind(argument + ": expected " + expected, 0), 0u)
      << kernel_calls::last_error << "; want " << argument << ": " << expected;
}

// An image with more elements than its memory: the call must reject it by its sizes alone.
Tensor claimed(const Dims& sizes, int32_t dtype) {
  Tensor tensor = kernel_calls::make({1}, dtype);
  tensor->sizes = sizes;
  tensor->strides = dense_strides(sizes);
  return tensor;
}

// A tensor for a call that does not read it.
template <class T>
Tensor blank(const Dims& sizes) {
  int64_t count = 1;
  for (const int64_t size : sizes) count *= size;
  return count > 1 << 16 ? claimed(sizes, kernel_calls::kCode<T>)
                         : kernel_calls::make(sizes, kernel_calls::kCode<T>);
}

// A call refuses a tensor of another type, of another rank, and with other sizes at these places from the
// end.
void refuses_altered(const std::string& argument, Tensor& tensor, bool any_rank,
                     std::initializer_list<size_t> fixed, const std::function<Call(Handle*)>& call) {
  const AtenTensorOpaque fits = *tensor;
  tensor->dtype = fits.dtype == kBool ? kFloat : kBool;
  expect_refused(argument, call);
  *tensor = fits;
  if (!any_rank) {
    tensor->sizes = tensor->strides = {};
    expect_refused(argument, call, "shape");
  }
  for (const size_t place : fixed) {
    *tensor = fits;
    ++tensor->sizes[fits.sizes.size() - place];
    tensor->strides = dense_strides(tensor->sizes);
    expect_refused(argument, call, "shape");
  }
  *tensor = fits;
}

TEST(RefusedCalls, TopkOfMoreThanThereIs) {
  const Tensor x = floats({2, 5});
  for (const int64_t k : {int64_t{-1}, int64_t{6}, INT64_MIN}) {
    Handle values = nullptr, indices = nullptr;
    EXPECT_NE(aoti_torch_cpu_topk(x.get(), k, -1, 1, 1, &values, &indices), 0);
    EXPECT_EQ(kernel_calls::last_error,
              "topk: " + std::to_string(k) + " values asked for, the dimension has 5");
  }
}

// A guide with the same address as the image that is not the whole image: its first planes, or its first
// sample.
class KernelCalls : public ::testing::Test {
 protected:
  void SetUp() override { use_threads(3); }
};

TEST_F(KernelCalls, AGuideThatIsAPartOfTheImage) {
  std::vector<float> values(size_t(2 * 3 * 9 * 11));
  for (size_t i = 0; i < values.size(); ++i) values[i] = float(i * 7919 % 101) / 100;
  const Tensor near = floats({1, 3, 3}), fall = of<float>({1}, {-3.0f});
  const auto filtered = [&](const Tensor& x, const Tensor& guide) {
    Handle result = nullptr;
    EXPECT_EQ(aoti_torch_cpu_bilateral(x.get(), guide.get(), near.get(), fall.get(), 0, 0, &result), 0)
        << kernel_calls::last_error;
    const Tensor tensor(result);
    const auto* const data = reinterpret_cast<const float*>(tensor->data());
    return std::vector<float>(data, data + tensor->numel());
  };
  const auto part = [](const Tensor& whole, const Dims& sizes) {
    Tensor view = std::make_unique<AtenTensorOpaque>(*whole);
    view->sizes = sizes;
    view->strides = dense_strides(sizes);
    return view;
  };
  const Tensor image = of({1, 3, 9, 11}, values), batch = of({2, 3, 9, 11}, values);
  const Tensor plane = part(image, {1, 1, 9, 11}), first = part(batch, {1, 3, 9, 11});
  EXPECT_EQ(filtered(plane, image), filtered(of({1, 1, 9, 11}, values), of({1, 3, 9, 11}, values)));
  EXPECT_EQ(filtered(image, plane), filtered(of({1, 3, 9, 11}, values), of({1, 1, 9, 11}, values)));
  EXPECT_EQ(filtered(batch, first), filtered(of({2, 3, 9, 11}, values), of({1, 3, 9, 11}, values)));
}

#include "refused_calls.inc"

}  // namespace
