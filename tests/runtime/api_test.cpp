/** The library's interface for programs, with fake backends: errors, lifetimes, threads, self-test. */
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <limits>
#include <random>
#include <thread>

#include "chiasm/chiasm.hpp"
#include "support.h"

namespace chiasm::testing {
namespace {

using Json = nlohmann::json;
using ::testing::AllOf;
using ::testing::HasSubstr;

/** One bundle, its forward loaded on the fake native backend, and good inputs. */
class Call : public ::testing::Test {
 protected:
  TemporaryFolder folder_;
  std::string path_ = write_bundle(folder_);
  Method method_ = Bundle::open(path_).method("forward");
  std::vector<float> image_ = std::vector<float>(2 * 3 * 4 * 5, 1.5f);
  std::vector<float> sigma_ = {1, 2, 3, 4};
  Tensor input_{image_.data(), {2, 3, 4, 5}};
  Tensor sigma_view_{sigma_.data(), {2, 2}};

  std::string refused(std::initializer_list<Tensor> inputs, chiasm_code code = CHIASM_INVALID_ARGUMENT) {
    return refusal(code, [&] { method_.run(inputs); });
  }
};

TEST_F(Call, Runs) {
  const Outputs outputs = method_.run({input_, sigma_view_});
  ASSERT_EQ(outputs.size(), 2u);
  EXPECT_EQ(outputs[0].shape(), (Shape{2, 3, 4, 5}));
  EXPECT_EQ(outputs[1].shape(), (Shape{2, 2}));
  EXPECT_EQ(outputs[0].data<float>()[119], 3.0f);
  EXPECT_EQ(reinterpret_cast<uintptr_t>(outputs[0].data()) % 64, 0u);
  EXPECT_THAT(refusal(CHIASM_INVALID_ARGUMENT, [&] { outputs[2]; }), HasSubstr("there is no output 2"));
  EXPECT_THAT(refusal(CHIASM_INVALID_ARGUMENT, [&] { outputs[0].data<double>(); }),
              HasSubstr("float32, not float64"));
  EXPECT_EQ(method_.backend(), "native");
  EXPECT_THAT(method_.artifact(), HasSubstr("forward.v"));
}

TEST_F(Call, CountAndNull) {
  EXPECT_EQ(refused({input_}), "expected 2 inputs, got 1");
  EXPECT_EQ(refused({}), "expected 2 inputs, got 0");
  EXPECT_EQ(refused({input_, sigma_view_, sigma_view_}), "expected 2 inputs, got 3");
  EXPECT_EQ(refused({input_, Tensor(static_cast<float*>(nullptr), {2, 2})}),
            "input 'sigma': its data is NULL");
}

TEST_F(Call, DtypeAndGenericAgreement) {
  std::vector<double> doubles(120);
  std::vector<int32_t> ints(4);
  EXPECT_THAT(
      refused({Tensor(doubles.data(), {2, 3, 4, 5}), sigma_view_}),
      AllOf(HasSubstr("input 'input': expected float32, got float64"), HasSubstr("loaded for float32")));
  EXPECT_THAT(refused({input_, Tensor(doubles.data(), {2, 2})}),
              HasSubstr("input 'sigma': expected float32, got float64"));
  EXPECT_THAT(refused({input_, Tensor(ints.data(), {2, 2})}),
              HasSubstr("input 'sigma': expected float32, got int32"));
  EXPECT_THAT(refused({input_, Tensor(static_cast<void*>(ints.data()), static_cast<DType>(77), {2, 2})}),
              HasSubstr("input 'sigma': expected float32, got an unknown dtype (77)"));
  const Method wide = Bundle::open(path_).method("forward", LoadOptions().with_dtype(DType::Float64));
  EXPECT_EQ(wide.artifact(), "forward.float64.onnx");
  EXPECT_EQ(wide.info().inputs[0].dtypes, std::vector<DType>{DType::Float64});
  EXPECT_THAT(refusal(CHIASM_INVALID_ARGUMENT,
                      [&] {
                        wide.run({input_, sigma_view_});
                      }),
              HasSubstr("expected float64, got float32"));
  EXPECT_EQ(wide.run({Tensor(doubles.data(), {2, 3, 4, 5}), Tensor(doubles.data(), {2, 2})})[0].dtype(),
            DType::Float64);
}

TEST_F(Call, RankAndShape) {
  EXPECT_EQ(refused({Tensor(image_.data(), {3, 4, 5}), sigma_view_}),
            "input 'input': expected shape (B, 3, H, W), got (3, 4, 5)");
  EXPECT_EQ(refused({Tensor(image_.data(), {2, 4, 3, 5}), sigma_view_}),
            "input 'input': expected shape (B, 3, H, W), got (2, 4, 3, 5)");
  const Tensor three(image_.data(), {3, 3, 3, 3});
  EXPECT_EQ(refused({three, sigma_view_}),
            "input 'sigma': expected shape (B, 2) with B=3 (from input 'input'), got (2, 2)");
  EXPECT_EQ(refused({input_, Tensor(sigma_.data(), {4})}),
            "input 'sigma': expected shape (B, 2) with B=2 (from input 'input'), got (4,)");
  EXPECT_EQ(refused({Tensor(image_.data(), {1, 3, 2, 5}), sigma_view_}),
            "input 'input': expected shape (B, 3, H, W), got (1, 3, 2, 5): H must be from 3 to 4096");
  EXPECT_THAT(refused({Tensor(image_.data(), {0, 3, 4, 5}), sigma_view_}),
              HasSubstr("B must be from 1 to 64"));
  EXPECT_THAT(refused({Tensor(image_.data(), {1, 3, 4, -5}), sigma_view_}),
              HasSubstr("W must be from 3 to 4096"));
  EXPECT_THAT(refused({Tensor(image_.data(), {1, 3, 4, 4097}), sigma_view_}),
              HasSubstr("got (1, 3, 4, 4097)"));
}

/** The method with frames (B, H, W, 3) for its images. */
Method method_of_frames(const TemporaryFolder& folder) {
  return Bundle::open(write_bundle(folder,
                                   [](Json& manifest) {
                                     Json& forward = manifest["methods"]["forward"];
                                     for (Json* frames : {&forward["inputs"][0], &forward["outputs"][0]}) {
                                       (*frames)["layout"] = "NHWC";
                                       (*frames)["shape"] = {"B", "H", "W", "C"};
                                     }
                                     manifest["symbols"]["C"] = {{"min", 1}, {"max", 4}};
                                   }))
      .method("forward");
}

TEST_F(Call, AFrameAloneIsABatchOfOne) {
  const TemporaryFolder folder;
  const Method method = method_of_frames(folder);
  const Tensor sigma(sigma_.data(), {1, 2});
  const auto shapes = [&](const Tensor& frame) {
    const Outputs outputs = method.run({frame, sigma});
    EXPECT_EQ(outputs[0].data<float>()[59], 3.0f);
    return std::vector<Shape>{outputs[0].shape(), outputs[1].shape(),
                              method.output_type({frame, sigma}).shape};
  };
  EXPECT_EQ(shapes({image_.data(), {1, 4, 5, 3}}), (std::vector<Shape>{{1, 4, 5, 3}, {1, 2}, {1, 4, 5, 3}}));
  EXPECT_EQ(shapes({image_.data(), {4, 5, 3}}), (std::vector<Shape>{{4, 5, 3}, {1, 2}, {4, 5, 3}}));
  EXPECT_EQ(shapes({image_.data(), {6, 10}}), (std::vector<Shape>{{6, 10}, {1, 3}, {6, 10}}));
  std::vector<float> out(60), half(2);
  method.run_into({Tensor(image_.data(), {4, 5, 3}), sigma},
                  {Tensor(out.data(), {4, 5, 3}), Tensor(half.data(), {1, 2})});
  EXPECT_EQ(out[59], 3.0f);
}

TEST_F(Call, FramesThatDoNotFitAreNamed) {
  const TemporaryFolder folder;
  const Method method = method_of_frames(folder);
  const Tensor sigma(sigma_.data(), {1, 2});
  const auto says = [&](const Tensor& frame) {
    return refusal(CHIASM_INVALID_ARGUMENT, [&] { method.run({frame, sigma}); });
  };
  EXPECT_EQ(says({image_.data(), {5}}), "input 'input': expected shape (B, H, W, C), got (5,)");
  EXPECT_THAT(says({image_.data(), {4, 5, 5}}), HasSubstr("got (4, 5, 5): C must be from 1 to 4"));
  EXPECT_THAT(says(Tensor::strided(image_.data(), {4, 5, 3}, {12, 3, 1})),
              AllOf(HasSubstr("expected elements in row-major order, none of which share memory, got strides "
                              "(12, 3, 1) for shape (4, 5, 3)"),
                    HasSubstr(".clone()")));
  std::vector<float> out(60), half(2);
  EXPECT_THAT(refusal(CHIASM_INVALID_ARGUMENT,
                      [&] {
                        method.run_into({Tensor(image_.data(), {4, 5, 3}), sigma},
                                        {Tensor(out.data(), {1, 4, 5, 3}), Tensor(half.data(), {1, 2})});
                      }),
              HasSubstr("for these inputs it is (4, 5, 3)"));
}

TEST_F(Call, AnErrorQuotesOnlyWhatThisCallHasGiven) {
  const TemporaryFolder folder;
  const Method square = Bundle::open(write_bundle(folder, [](Json& manifest) {
                          manifest["methods"]["forward"]["inputs"][0]["shape"] = {"B", 3, "H", "H"};
                          manifest["methods"]["forward"]["outputs"][0]["shape"] = {"B", 3, "H", "H"};
                        })).method("forward");
  std::vector<float> image(2 * 3 * 7 * 7, 1.0f);
  square.run({Tensor(image.data(), {2, 3, 7, 7}), sigma_view_});
  EXPECT_EQ(refusal(CHIASM_INVALID_ARGUMENT,
                    [&] {
                      square.run({Tensor(image.data(), {5}), sigma_view_});
                    }),
            "input 'input': expected shape (B, 3, H, H), got (5,)");
  EXPECT_THAT(refusal(CHIASM_INVALID_ARGUMENT,
                      [&] {
                        square.run({Tensor(image.data(), {2, 3, 5, 4}), sigma_view_});
                      }),
              HasSubstr("with H=5 (from dimension 2), got (2, 3, 5, 4)"));
}

TEST_F(Call, AMessageIsOneLine) {
  EXPECT_THAT(refusal(CHIASM_NOT_FOUND, [&] { Bundle::open(path_).method("a\nb\x1b"); }),
              HasSubstr("has no method 'a b?'"));
}

TEST_F(Call, ExpressionsInInputs) {
  const Method vjp = Bundle::open(path_).method("vjp");
  EXPECT_EQ(vjp.run({input_, sigma_view_})[0].shape(), (Shape{2, 3, 4, 5}));
  EXPECT_EQ(refusal(CHIASM_INVALID_ARGUMENT,
                    [&] {
                      vjp.run({input_, Tensor(sigma_.data(), {1, 2})});
                    }),
            "input 'grad_half': expected shape (B, (H+1)//2) with B=2 (from input 'input'), H=4 (from input "
            "'input'), got (1, 2)");
  EXPECT_THAT(refusal(CHIASM_INVALID_ARGUMENT,
                      [&] {
                        vjp.run({input_, Tensor(sigma_.data(), {2, 1})});
                      }),
              HasSubstr("got (2, 1): (H+1)//2 is 2"));
}

TEST_F(Call, Strides) {
  const Shape shape = {2, 3, 4, 5};
  EXPECT_THAT(refused({Tensor::strided(image_.data(), shape, {60, 1, 15, 3}), sigma_view_}),
              AllOf(HasSubstr("input 'input': expected elements in row-major order, none of which share "
                              "memory, got strides (60, 1, 15, 3) for shape (2, 3, 4, 5)"),
                    HasSubstr("channels-last"), HasSubstr(".contiguous()"), HasSubstr(".clone()")));
  EXPECT_THAT(
      refused({Tensor::strided(image_.data(), {1, 3, 4, 4}, {60, 5, 20, 1}), Tensor(sigma_.data(), {1, 2})}),
      AllOf(HasSubstr("row-major"), ::testing::Not(HasSubstr("channels-last"))));
  EXPECT_THAT(refused({Tensor::strided(image_.data(), {2, 3, 4, 5}, {60, 20, 5, -1}), sigma_view_}),
              HasSubstr("(60, 20, 5, -1)"));
  // Tensors that end beyond the address space, or have more elements than can be counted.
  constexpr int64_t kFar = std::numeric_limits<int64_t>::max() / 4;
  for (const int64_t far : {kFar, 2 * kFar, 4 * kFar})
    EXPECT_THAT(refused({Tensor::strided(image_.data(), {2, 3, 4, 5}, {far, 20, 5, 1}), sigma_view_}),
                HasSubstr("row-major"));
  EXPECT_THAT(refused({Tensor::strided(image_.data(), {2, 3, 4, 5}, {0, 20, 5, 1}), sigma_view_}),
              HasSubstr("(0, 20, 5, 1)"));
  method_.run({Tensor::strided(image_.data(), shape, {60, 20, 5, 1}), sigma_view_});
  // Every other column of rows of odd length: behind a row's last element there is no gap.
  std::vector<float> odd(2 * 3 * 4 * 9, 1.0f);
  method_.run({Tensor::strided(odd.data(), shape, {3 * 4 * 9, 4 * 9, 9, 2}), sigma_view_});
  EXPECT_THAT(refused({Tensor::strided(odd.data(), shape, {3 * 4 * 8, 4 * 8, 8, 2}), sigma_view_}),
              HasSubstr("row-major"));
  // A dimension of size 1 may have any stride.
  method_.run({Tensor::strided(image_.data(), {1, 3, 4, 5}, {-7, 20, 5, 1}),
               Tensor::strided(sigma_.data(), {1, 2}, {99, 1})});
}

/** Memory with a mark in every element, and a tensor of random shape and strides in its middle. */
template <class T>
struct Scattered {
  std::vector<T> memory;
  Shape shape, strides;

  Scattered(std::mt19937& random, std::vector<int64_t> sizes)
      : shape(sizes.data(), sizes.size()), strides(shape) {
    const auto up_to = [&](uint32_t most) { return static_cast<int64_t>(random() % (most + 1)); };
    int64_t step = 1;
    for (size_t i = sizes.size(); i-- > 0;) {
      step += up_to(1) * up_to(7);
      strides[i] = sizes[i] == 1 ? up_to(100) - 50 : step;
      step *= sizes[i];
    }
    memory.assign(static_cast<size_t>(step) + 16, T(77));
  }

  Tensor tensor() { return Tensor::strided(memory.data() + 8, shape, strides); }

  /** Calls each(element, its number in row-major order). */
  template <class Each>
  void for_elements(const Each& each) {
    for (int64_t n = 0; n < shape.count(); ++n) {
      int64_t at = 8, rest = n;
      for (size_t i = shape.size(); i-- > 0; rest /= shape[i])
        if (shape[i] > 1) at += rest % shape[i] * strides[i];
      each(memory[static_cast<size_t>(at)], n);
    }
  }
};

TEST_F(Call, TensorsWithGapsAreReadAndWrittenWhereTheyAre) {
  std::mt19937 random(1);
  const auto run = [&](auto zero, const Method& method) {
    using T = decltype(zero);
    for (int round = 0; round < 200; ++round) {
      const auto size = [&](int64_t least) { return least + static_cast<int64_t>(random() % 4); };
      const int64_t batch = size(1);
      Scattered<T> image(random, {batch, 3, size(3), size(3)}), sigma(random, {batch, 2}), out = image;
      Scattered<T> half(random, {batch, (image.shape[2] + 1) / 2});
      image.for_elements([](T& value, int64_t n) { value = static_cast<T>(n); });
      const auto check = [](T& value, int64_t n) { ASSERT_EQ(value, static_cast<T>(2 * n)); };
      const Outputs outputs = method.run({image.tensor(), sigma.tensor()});
      for (int64_t n = 0; n < image.shape.count(); ++n) check(outputs[0].template data<T>()[n], n);

      method.run_into({image.tensor(), sigma.tensor()}, {out.tensor(), half.tensor()});
      for (Scattered<T>* result : {&out, &half}) {
        result->for_elements(check);
        result->for_elements([](T& value, int64_t) { value = 77; });
        EXPECT_EQ(result->memory, std::vector<T>(result->memory.size(), 77)) << "a gap was written to";
      }
    }
  };
  run(0.0f, method_);
  run(0.0, Bundle::open(path_).method("forward", LoadOptions().with_dtype(DType::Float64)));
}

TEST_F(Call, RegionsOfOneMatrix) {
  // Two adjacent regions: a result may be next to the input, but results must not overlap.
  std::vector<float> whole(2 * 3 * 4 * 16, 1.5f), half(4), other(4);
  const auto region = [&](size_t column) {
    return Tensor::strided(whole.data() + column, {2, 3, 4, 5}, {192, 64, 16, 1});
  };
  const Tensor half_view(half.data(), {2, 2});
  method_.run_into({region(0), sigma_view_}, {region(8), half_view});
  EXPECT_EQ(whole[8], 3.0f);
  EXPECT_EQ(whole[7], 1.5f);
  method_.run_into({region(0), sigma_view_}, {region(0), half_view});  // in place: it is read first
  EXPECT_EQ(whole[4], 3.0f);
  EXPECT_EQ(whole[5], 1.5f);
  EXPECT_EQ(refusal(CHIASM_INVALID_ARGUMENT,
                    [&] {
                      method_.run_into({region(0), sigma_view_},
                                       {region(8), Tensor::strided(whole.data() + 300, {2, 2}, {16, 1})});
                    }),
            "output 'half': its memory overlaps that of output 'output'");
  const auto run_both = [&](size_t first, size_t second) {
    method_.run_each({{input_, sigma_view_}, {input_, sigma_view_}},
                     {{region(first), half_view}, {region(second), Tensor(other.data(), {2, 2})}});
  };
  run_both(8, 2);
  EXPECT_EQ(whole[6], 3.0f);
  EXPECT_EQ(whole[7], 1.5f);
  EXPECT_EQ(refusal(CHIASM_INVALID_ARGUMENT, [&] { run_both(8, 4); }),
            "run 0: the memory of an output overlaps that of an output of run 1");
}

TEST_F(Call, RunEachInPlace) {
  std::vector<float> canvas(3 * 4 * 10), half(4);
  for (size_t i = 0; i < canvas.size(); ++i) canvas[i] = static_cast<float>(i);
  const auto region = [&](size_t i) {
    return Tensor::strided(&canvas[i * 5], {1, 3, 4, 5}, {120, 40, 10, 1});
  };
  const Tensor sigma(sigma_.data(), {1, 2});
  const std::vector<std::vector<Tensor>> outputs = {{region(0), Tensor(&half[0], {1, 2})},
                                                    {region(1), Tensor(&half[2], {1, 2})}};
  method_.run_each({{region(0), sigma}, {region(1), sigma}}, outputs);
  for (size_t i = 0; i < canvas.size(); ++i) ASSERT_EQ(canvas[i], 2 * static_cast<float>(i));
  EXPECT_EQ(refusal(CHIASM_INVALID_ARGUMENT,
                    [&] {
                      method_.run_each({{region(1), sigma}, {region(1), sigma}}, outputs);
                    }),
            "run 1: the memory of an output overlaps that of an input of run 0");
}

TEST_F(Call, RunEachRefusesRegionsThatShareAnElement) {
  constexpr int64_t kHeight = 12, kWidth = 14;
  constexpr int kRounds = 1000;
  const std::vector<float> image(3 * kHeight * kWidth, 1.5f);
  const Tensor sigma(sigma_.data(), {1, 2});
  std::mt19937 random(1);
  const auto draw = [&](int64_t least, int64_t most) {
    return least + static_cast<int64_t>(random() % static_cast<uint32_t>(most - least + 1));
  };
  int accepted = 0;
  for (int round = 0; round < kRounds; ++round) {
    std::vector<float> canvas(image.size()), expected(image.size()), half(3 * kHeight);
    std::vector<std::vector<Tensor>> inputs, outputs;
    bool apart = true;
    for (int64_t run = 0, runs = draw(2, 3); run < runs; ++run) {
      const int64_t height = draw(3, draw(3, kHeight)), width = draw(3, draw(3, kWidth));
      const int64_t first = draw(0, kHeight - height) * kWidth + draw(0, kWidth - width);
      for (int64_t i = 0; i < 3 * height * width; ++i) {
        const int64_t plane = i / (height * width), row = i / width % height, column = i % width;
        float& value = expected[static_cast<size_t>(first + (plane * kHeight + row) * kWidth + column)];
        apart = apart && value == 0;
        value = 3;
      }
      inputs.push_back({Tensor(image.data(), {1, 3, height, width}), sigma});
      outputs.push_back({Tensor::strided(&canvas[static_cast<size_t>(first)], {1, 3, height, width},
                                         {3 * kHeight * kWidth, kHeight * kWidth, kWidth, 1}),
                         Tensor(&half[static_cast<size_t>(run * kHeight)], {1, (height + 1) / 2})});
    }
    bool taken = true;
    try {
      method_.run_each(inputs, outputs);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), CHIASM_INVALID_ARGUMENT) << error.what();
      taken = false;
    }
    ASSERT_EQ(taken, apart) << "round " << round;
    if (!taken) continue;
    ++accepted;
    EXPECT_EQ(canvas, expected) << "round " << round;
  }
  EXPECT_GT(accepted, kRounds / 10);
  EXPECT_LT(accepted, kRounds / 2);
}

TEST_F(Call, RunEachCountsGapsBetweenCloserRows) {
  std::vector<float> canvas(3 * 8 * 12), elsewhere(3 * 4 * 5), half(4);
  const std::vector<Tensor> given{Tensor(image_.data(), {1, 3, 4, 5}), Tensor(sigma_.data(), {1, 2})};
  const std::vector<Tensor> region{Tensor::strided(canvas.data(), {1, 3, 4, 5}, {288, 96, 12, 1}),
                                   Tensor(&half[0], {1, 2})};
  // One row fits between those of the region.
  method_.run_each({given, given},
                   {region, {Tensor(elsewhere.data(), {1, 3, 4, 5}), Tensor(&canvas[10], {1, 2})}});
  EXPECT_EQ(canvas[10], 3.0f);
  // Rows twice as far apart would fit too.
  EXPECT_EQ(refusal(CHIASM_INVALID_ARGUMENT,
                    [&] {
                      method_.run_each({given, given},
                                       {region,
                                        {Tensor::strided(&canvas[6], {1, 3, 4, 5}, {288, 96, 24, 1}),
                                         Tensor(&half[2], {1, 2})}});
                    }),
            "run 1: the memory of an output overlaps that of an output of run 0");
}

TEST_F(Call, DeviceAndAlignment) {
  EXPECT_THAT(
      refused({Tensor(image_.data(), {2, 3, 4, 5}, Device::cuda(1)), sigma_view_}),
      HasSubstr("input 'input': expected memory on the CPU, where the method was loaded, got CUDA device 1"));
  EXPECT_THAT(refused({input_, Tensor(sigma_.data(), {2, 2}, Device{CHIASM_CPU, 3})}),
              HasSubstr("input 'sigma'"));
  char* const odd = reinterpret_cast<char*>(image_.data()) + 1;
  EXPECT_THAT(refused({Tensor(static_cast<void*>(odd), DType::Float32, {1, 3, 3, 3}), sigma_view_}),
              HasSubstr("not aligned to 4 bytes"));
}

TEST_F(Call, StructSizesAndNullPointersOfTheCInterface) {
  const chiasm_api& api = *chiasm_get_api(CHIASM_API_VERSION);
  chiasm_method* const method = method_.c_handle();
  chiasm_outputs* outputs = nullptr;
  const auto run = [&](const chiasm_tensor* inputs, size_t count,
                       const chiasm_run_options* options = nullptr) {
    return refusal(CHIASM_INVALID_ARGUMENT,
                   [&] { detail::check(api.method_run(method, inputs, count, options, &outputs)); });
  };
  chiasm_tensor inputs[] = {input_.c_tensor(), sigma_view_.c_tensor()};
  EXPECT_THAT(run(nullptr, 2), HasSubstr("NULL"));
  inputs[0].struct_size = 0;
  EXPECT_THAT(run(inputs, 2), HasSubstr("struct_size is 0, expected sizeof(chiasm_tensor)"));
  inputs[0] = input_.c_tensor();
  inputs[1].struct_size = 8;
  EXPECT_THAT(run(inputs, 2), HasSubstr("input 'sigma': struct_size is 8"));
  inputs[1] = sigma_view_.c_tensor();
  inputs[1].shape = nullptr;
  EXPECT_THAT(run(inputs, 2), HasSubstr("input 'sigma': its shape is NULL"));
  inputs[1] = sigma_view_.c_tensor();
  inputs[1].device_type = 9;
  EXPECT_THAT(run(inputs, 2), HasSubstr("input 'sigma': expected memory on the CPU, where the method was "
                                        "loaded, got an unknown device type 9"));
  inputs[1] = sigma_view_.c_tensor();
  for (const int32_t ndim : {-1, 9, INT32_MAX}) {
    inputs[1].ndim = ndim;
    EXPECT_THAT(run(inputs, 2), HasSubstr("input 'sigma': ndim is "));
  }
  inputs[1] = sigma_view_.c_tensor();
  const chiasm_run_options short_options{4, nullptr};
  EXPECT_THAT(run(inputs, 2, &short_options), HasSubstr("run options: struct_size is 4"));
  EXPECT_THAT(
      refusal(CHIASM_INVALID_ARGUMENT,
              [&] { detail::check(api.method_run_each(method, 0, nullptr, 2, nullptr, 2, &short_options)); }),
      HasSubstr("run options: struct_size is 4"));
  EXPECT_THAT(refusal(CHIASM_INVALID_ARGUMENT,
                      [&] { detail::check(api.method_run(method, inputs, 2, nullptr, nullptr)); }),
              HasSubstr("outputs is NULL"));
  EXPECT_THAT(refusal(CHIASM_INVALID_ARGUMENT,
                      [&] { detail::check(api.method_run(nullptr, inputs, 2, nullptr, &outputs)); }),
              HasSubstr("method is NULL"));
  api.status_free(nullptr);
  EXPECT_EQ(api.status_code(nullptr), CHIASM_OK);
  EXPECT_STREQ(api.status_message(nullptr), "");
  EXPECT_EQ(api.outputs_get(nullptr, 0), nullptr);
  EXPECT_EQ(api.outputs_count(nullptr), 0u);
  api.outputs_free(nullptr);
  api.bundle_close(nullptr);
  api.method_close(nullptr);
  EXPECT_EQ(api.bundle_get_info(nullptr), nullptr);
  EXPECT_EQ(api.method_get_info(nullptr), nullptr);
  EXPECT_EQ(chiasm_get_api(0), nullptr);
  EXPECT_EQ(chiasm_get_api(CHIASM_API_VERSION + 1), nullptr);
  EXPECT_GE(api.struct_size, sizeof(chiasm_api));
}

TEST_F(Call, ANewerCallersLongerStructsAreStepped) {
  struct Longer {
    chiasm_tensor tensor;
    int64_t more;
  };
  Longer inputs[] = {{input_.c_tensor(), 1}, {sigma_view_.c_tensor(), 1}};
  for (Longer& input : inputs) input.tensor.struct_size = sizeof(Longer);
  chiasm_outputs* outputs = nullptr;
  detail::check(detail::api().method_run(method_.c_handle(), &inputs[0].tensor, 2, nullptr, &outputs));
  detail::api().outputs_free(outputs);
}

TEST_F(Call, RunInto) {
  std::vector<float> output(120), half(4);
  const Tensor output_view(output.data(), {2, 3, 4, 5}), half_view(half.data(), {2, 2});
  method_.run_into({input_, sigma_view_}, {output_view, half_view});
  EXPECT_EQ(output[7], 3.0f);
  EXPECT_EQ(half[3], 3.0f);
  const auto refused_into = [&](std::initializer_list<Tensor> outputs) {
    return refusal(CHIASM_INVALID_ARGUMENT, [&] { method_.run_into({input_, sigma_view_}, outputs); });
  };
  EXPECT_EQ(refused_into({output_view}), "expected 2 outputs, got 1");
  EXPECT_EQ(refused_into({Tensor(output.data(), {2, 3, 4, 4}), half_view}),
            "output 'output': expected shape (B, 3, H, W) with B=2 (from input 'input'), H=4 (from input "
            "'input'), W=5 (from input "
            "'input'), got (2, 3, 4, 4); for these inputs it is (2, 3, 4, 5)");
  std::vector<double> doubles(120);
  EXPECT_THAT(refused_into({Tensor(doubles.data(), {2, 3, 4, 5}), half_view}),
              HasSubstr("output 'output': expected float32, got float64"));
  EXPECT_THAT(refused_into({output_view, Tensor(static_cast<float*>(nullptr), {2, 2})}),
              HasSubstr("output 'half': its data is NULL"));
  EXPECT_THAT(refused_into({Tensor::strided(output.data(), {2, 3, 4, 5}, {60, 1, 15, 3}), half_view}),
              HasSubstr("channels-last"));
  EXPECT_EQ(refused_into({input_, half_view}), "output 'output': its memory overlaps that of input 'input'");
  EXPECT_EQ(refused_into({output_view, Tensor(sigma_.data(), {2, 2})}),
            "output 'half': its memory overlaps that of input 'sigma'");
  EXPECT_EQ(refused_into({output_view, Tensor(output.data() + 116, {2, 2})}),
            "output 'half': its memory overlaps that of output 'output'");
  EXPECT_THAT(refused_into({output_view, Tensor(static_cast<const float*>(half.data()), {2, 2})}),
              HasSubstr("output 1 is read-only"));
}

TEST_F(Call, RunEach) {
  std::vector<float> batch(3 * 120), half(3 * 4);
  const auto output = [&](size_t i) { return Tensor(&batch[i * 120], {2, 3, 4, 5}); };
  const auto second = [&](size_t i) { return Tensor(&half[i * 4], {2, 2}); };
  const std::vector<Tensor> given{input_, sigma_view_};
  method_.run_each({given, given, given},
                   {{output(0), second(0)}, {output(1), second(1)}, {output(2), second(2)}});
  for (size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(batch[i * 120 + 7], 3.0f);
    EXPECT_EQ(half[i * 4 + 3], 3.0f);
  }
  method_.run_each({}, {});
  std::fill(batch.begin(), batch.end(), 0.0f);
  const auto refused = [&](std::vector<std::vector<Tensor>> inputs,
                           std::vector<std::vector<Tensor>> outputs) {
    return refusal(CHIASM_INVALID_ARGUMENT, [&] { method_.run_each(inputs, outputs); });
  };
  const std::vector<Tensor> first{output(0), second(0)}, other{output(1), second(1)};
  EXPECT_EQ(refused({given}, {}), "run_each: 1 sets of inputs and 0 sets of outputs");
  EXPECT_EQ(refused({given, {input_}}, {first, other}),
            "run_each: run 1 has other numbers of tensors than run 0");
  EXPECT_EQ(refused({{input_}}, {first}), "run 0: expected 2 inputs, got 1");
  chiasm_tensor tensors[4] = {input_.c_tensor(), sigma_view_.c_tensor(), input_.c_tensor(),
                              sigma_view_.c_tensor()};
  tensors[2].struct_size = 1024;
  chiasm_tensor outputs[4] = {first[0].c_tensor(), first[1].c_tensor(), other[0].c_tensor(),
                              other[1].c_tensor()};
  EXPECT_EQ(
      refusal(CHIASM_INVALID_ARGUMENT,
              [&] {
                const chiasm_api& api = detail::api();
                detail::check(api.method_run_each(method_.c_handle(), 2, tensors, 2, outputs, 2, nullptr));
              }),
      "run 1: its first tensor's struct_size is 1024, that of run 0 " +
          std::to_string(sizeof(chiasm_tensor)));
  EXPECT_THAT(refused({given, {Tensor(image_.data(), {4, 5, 3}), sigma_view_}}, {first, other}),
              ::testing::StartsWith("run 1: input 'input': expected"));
  EXPECT_EQ(refused({given, given}, {first, first}),
            "run 1: the memory of an output overlaps that of an output of run 0");
  EXPECT_EQ(refused({given, given}, {first, {output(1), Tensor(&half[3], {2, 2})}}),
            "run 1: the memory of an output overlaps that of an output of run 0");
  EXPECT_EQ(refused({given, {output(0), sigma_view_}}, {first, other}),
            "run 0: the memory of an output overlaps that of an input of run 1");
  EXPECT_THAT(refused({given}, {{output(0), Tensor(static_cast<const float*>(half.data()), {2, 2})}}),
              HasSubstr("is read-only"));
  EXPECT_EQ(batch, std::vector<float>(batch.size())) << "nothing was run";
}

TEST_F(Call, OutputType) {
  const TensorType type = method_.output_type({input_, sigma_view_}, 1);
  EXPECT_EQ(type.shape, (Shape{2, 2}));
  EXPECT_EQ(type.dtype, DType::Float32);
  EXPECT_THAT(refusal(CHIASM_INVALID_ARGUMENT,
                      [&] {
                        method_.output_type({input_, sigma_view_}, 2);
                      }),
              HasSubstr("there is no output 2"));
  EXPECT_THROW(method_.output_type({input_}, 0), Error);
}

TEST_F(Call, EightThreadsOnOneMethod) {
  std::vector<std::thread> threads;
  for (int t = 0; t < 8; ++t) {
    threads.emplace_back([this, t] {
      const int64_t height = 3 + t;
      std::vector<float> image(static_cast<size_t>(3 * height * 64), static_cast<float>(t));
      const Tensor input(image.data(), {1, 3, height, 64}), sigma(sigma_.data(), {1, 2});
      for (int i = 0; i < 200; ++i) {
        const Outputs outputs = method_.run({input, sigma});
        ASSERT_EQ(outputs[0].count(), 3 * height * 64);
        ASSERT_EQ(outputs[0].data<float>()[i % 64], 2.0f * static_cast<float>(t));
        EXPECT_THROW(method_.run({input, input}), Error);
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
}

TEST_F(Call, ThreadsLoadAndCloseMethods) {
  std::vector<std::thread> threads;
  for (int t = 0; t < 8; ++t) {
    threads.emplace_back([this] {
      for (int i = 0; i < 20; ++i) Bundle::open(path_).method("forward").run({input_, sigma_view_});
    });
  }
  for (std::thread& thread : threads) thread.join();
}

TEST(Lifetime, HandlesCloseInAnyOrder) {
  const TemporaryFolder folder;
  auto bundle = std::make_unique<Bundle>(Bundle::open(write_bundle(folder)));
  auto method = std::make_unique<Method>(bundle->method("forward"));
  bundle.reset();
  std::vector<float> image(27, 1), sigma(2);
  auto outputs = method->run({Tensor(image.data(), {1, 3, 3, 3}), Tensor(sigma.data(), {1, 2})});
  EXPECT_EQ(method->info().name, "forward");
  method.reset();
  EXPECT_EQ(outputs[0].data<float>()[26], 2.0f);
}

TEST(Lifetime, MovedFromHandlesThrow) {
  const TemporaryFolder folder;
  Bundle bundle = Bundle::open(write_bundle(folder));
  Method method = bundle.method("forward");
  std::vector<float> image(27, 1), sigma(2);
  const std::vector<Tensor> inputs = {Tensor(image.data(), {1, 3, 3, 3}), Tensor(sigma.data(), {1, 2})};
  Outputs outputs = method.run(inputs);
  const Bundle other_bundle = std::move(bundle);
  const Method other_method = std::move(method);
  const Outputs other_outputs = std::move(outputs);
  EXPECT_FALSE(bundle);
  EXPECT_TRUE(other_bundle);
  EXPECT_THAT(refusal(CHIASM_FAILED_PRECONDITION, [&] { bundle.info(); }),
              HasSubstr("this Bundle was moved from"));
  EXPECT_THROW(bundle.method("forward"), Error);
  EXPECT_THROW(method.run(inputs), Error);
  EXPECT_THROW(method.info(), Error);
  EXPECT_THROW(outputs.size(), Error);
  EXPECT_THROW(outputs[0], Error);
  bundle = Bundle::open(other_bundle.info().path);
  EXPECT_EQ(bundle.methods().size(), 2u);
}

TEST(Info, IsKnownWithoutLoading) {
  const TemporaryFolder folder;
  const Bundle bundle = Bundle::open(write_bundle(folder) + "/");
  EXPECT_EQ(bundle.info().name, "test.scale");
  EXPECT_EQ(bundle.info().version, "1.2.3");
  EXPECT_EQ(Json::parse(bundle.info().manifest)["config"]["factor"], 2);
  const MethodInfo forward = bundle.methods()[0];
  EXPECT_EQ(forward.name, "forward");
  ASSERT_EQ(forward.inputs.size(), 2u);
  EXPECT_EQ(forward.inputs[0].dtypes, (std::vector<DType>{DType::Float32, DType::Float64}));
  EXPECT_EQ(forward.inputs[0].dims[1].expression, "3");
  EXPECT_EQ(forward.inputs[0].dims[1].min, 3);
  EXPECT_EQ(forward.inputs[0].dims[2].expression, "H");
  EXPECT_EQ(forward.inputs[0].dims[2].max, 4096);
  EXPECT_EQ(forward.outputs[1].dims[1].expression, "(H+1)//2");
  EXPECT_EQ(forward.outputs[1].dims[1].max, 0);
  EXPECT_EQ(library_version(), "0.1.0");
}

TEST(Backends, AreListedWithTheirProblems) {
  const std::vector<BackendInfo> all = backends();
  ASSERT_EQ(all.size(), 3u);
  EXPECT_EQ(all[0].name, "native");
  EXPECT_TRUE(all[0].available);
  EXPECT_EQ(all[0].engine_version, "fake 1.0");
  EXPECT_FALSE(all[1].available);
  EXPECT_THAT(all[1].problem, HasSubstr("libfake_engine.so"));
  chiasm_backend_info info{};
  EXPECT_THAT(refusal(CHIASM_INVALID_ARGUMENT, [&] { detail::check(detail::api().backend_info(0, &info)); }),
              HasSubstr("struct_size"));
  info.struct_size = sizeof info;
  EXPECT_THROW(detail::check(detail::api().backend_info(3, &info)), Error);
}

TEST(Threads, ThePolicyIsFixedByTheFirstLoad) {
  EXPECT_GT(get_num_threads(), 0);
  EXPECT_THROW(set_num_threads(-1), Error);
  const TemporaryFolder folder;
  const Bundle bundle = Bundle::open(write_bundle(folder));
  bundle.method("forward");
  EXPECT_GT(get_num_threads(), 0);
  EXPECT_THAT(refusal(CHIASM_FAILED_PRECONDITION, [] { set_num_threads(1); }),
              HasSubstr("after the first method was loaded"));
}

class Loading : public ::testing::Test {
 protected:
  TemporaryFolder folder_;
  std::string path_ = write_bundle(folder_);

  std::string refused(chiasm_code code, const LoadOptions& options = LoadOptions().with_backend("onnx")) {
    return refusal(code, [&] { Bundle::open(path_).method("forward", options); });
  }
};

TEST_F(Loading, NoSuchBundle) {
  EXPECT_THAT(refusal(CHIASM_NOT_FOUND, [] { Bundle::open("/nowhere.chiasm"); }),
              HasSubstr("/nowhere.chiasm"));
  EXPECT_THAT(refusal(CHIASM_CORRUPT, [&] { Bundle::open(path_ + "/manifest.json"); }),
              HasSubstr("is a folder"));
  EXPECT_THAT(refusal(CHIASM_CORRUPT, [&] { Bundle::open(folder_.path()); }), HasSubstr("no manifest.json"));
  chiasm_bundle* bundle = nullptr;
  EXPECT_THAT(
      refusal(CHIASM_INVALID_ARGUMENT, [&] { detail::check(detail::api().bundle_open(nullptr, &bundle)); }),
      HasSubstr("path is NULL"));
}

TEST_F(Loading, NewerSchema) {
  write_bundle(folder_, [](Json& m) { m["schema_version"] = 4; });
  EXPECT_THAT(refusal(CHIASM_VERSION_MISMATCH, [&] { Bundle::open(path_); }),
              HasSubstr("manifest.json: schema_version"));
}

TEST_F(Loading, TruncatedTamperedAndMissingArtifacts) {
  const std::string file = path_ + "/forward.float32.onnx";
  write_text(file, "scale");
  EXPECT_THAT(refused(CHIASM_CORRUPT),
              AllOf(HasSubstr(file), HasSubstr("truncated: has 5 bytes, the manifest says 9")));
  write_text(file, artifact_content(file, "scale 3"));
  EXPECT_THAT(refused(CHIASM_CORRUPT),
              AllOf(HasSubstr(file), HasSubstr("changed since the bundle was made")));
  write_text(file, "scale 2 and more");
  EXPECT_THAT(refused(CHIASM_CORRUPT), HasSubstr(file));
  std::filesystem::remove(file);
  EXPECT_THAT(refused(CHIASM_NOT_FOUND), HasSubstr(file));
  std::filesystem::create_directory(file);
  EXPECT_THAT(refused(CHIASM_CORRUPT), HasSubstr("not a regular file"));
}

TEST_F(Loading, EnginesThatFail) {
  set_artifact(path_, "forward.float32.onnx", "broken");
  EXPECT_THAT(refused(CHIASM_CORRUPT),
              AllOf(HasSubstr("forward.float32.onnx"), HasSubstr("the fake engine cannot read this"),
                    HasSubstr("onnx backend")));
  set_artifact(path_, "forward.float32.onnx", "failing");
  const Method method = Bundle::open(path_).method("forward", LoadOptions().with_backend("onnx"));
  std::vector<float> image(27), sigma(2);
  EXPECT_THAT(refusal(CHIASM_INTERNAL,
                      [&] {
                        method.run({Tensor(image.data(), {1, 3, 3, 3}), Tensor(sigma.data(), {1, 2})});
                      }),
              HasSubstr("the fake engine fails in every run"));
  EXPECT_THAT(refused(CHIASM_INTERNAL, LoadOptions().with_backend("onnx").with_warm_up()),
              HasSubstr("the fake engine fails"));
}

TEST_F(Loading, Options) {
  EXPECT_THAT(refused(CHIASM_UNAVAILABLE, LoadOptions().with_backend("tensorrt")),
              HasSubstr("there is no libchiasm_tensorrt.so in "));
  EXPECT_THAT(refused(CHIASM_INVALID_ARGUMENT, LoadOptions().with_backend("../x")),
              HasSubstr("'../x' cannot be the name of a backend"));
  EXPECT_THAT(refused(CHIASM_INVALID_ARGUMENT, LoadOptions().with_num_threads(-1)),
              HasSubstr("num_threads is -1, expected 0 to 1024"));
  EXPECT_THAT(refused(CHIASM_INVALID_ARGUMENT, LoadOptions().with_option("fused", "0")),
              HasSubstr("name it, not auto"));
  EXPECT_THAT(refused(CHIASM_INVALID_ARGUMENT, LoadOptions().with_backend("onnx").with_option("speed", "11")),
              HasSubstr("the onnx backend has no option 'speed'; it has fused (0 or 1)"));
  for (const char* second : {"0", "1"}) {
    EXPECT_THAT(
        refused(CHIASM_INVALID_ARGUMENT,
                LoadOptions().with_backend("onnx").with_option("fused", "1").with_option("fused", second)),
        HasSubstr("the option 'fused' is given twice"));
  }
  EXPECT_EQ(
      Bundle::open(path_)
          .method("forward", LoadOptions().with_backend("onnx").with_option("fused", "0").with_num_threads(1))
          .backend(),
      "onnx");
  EXPECT_THAT(refused(CHIASM_UNAVAILABLE, LoadOptions().with_backend("torch")),
              HasSubstr("libfake_engine.so"));
  EXPECT_THAT(
      refused(CHIASM_FAILED_PRECONDITION, LoadOptions().with_backend("native").with_allow_native_code(false)),
      HasSubstr("allow_native_code"));
  EXPECT_THAT(refused(CHIASM_NOT_FOUND, LoadOptions().with_dtype(DType::Int8)),
              HasSubstr("has no artifact for int8; it has float32, float64"));
  EXPECT_THAT(refusal(CHIASM_NOT_FOUND, [&] { Bundle::open(path_).method("backward"); }),
              HasSubstr("it has forward, vjp"));
  EXPECT_EQ(Bundle::open(path_).method("forward", LoadOptions().with_allow_native_code(false)).backend(),
            "onnx");
  EXPECT_EQ(Bundle::open(path_).method("forward", LoadOptions().with_warm_up()).backend(), "native");
  chiasm_load_options options = CHIASM_LOAD_OPTIONS_INIT;
  chiasm_method* method = nullptr;
  const Bundle bundle = Bundle::open(path_);
  const auto load = [&] {
    return refusal(CHIASM_INVALID_ARGUMENT, [&] {
      detail::check(detail::api().method_load(bundle.c_handle(), "forward", &options, &method));
    });
  };
  options.struct_size = 0;
  EXPECT_THAT(load(), HasSubstr("CHIASM_LOAD_OPTIONS_INIT"));
  options = CHIASM_LOAD_OPTIONS_INIT;
  options.device_type = 5;
  EXPECT_THAT(load(), HasSubstr("device_type 5"));
  options = CHIASM_LOAD_OPTIONS_INIT;
  options.device_index = 1;
  EXPECT_THAT(load(), HasSubstr("device_index is 1"));
  options = CHIASM_LOAD_OPTIONS_INIT;
  options.dtype = 11;
  EXPECT_THAT(load(), HasSubstr("unknown dtype 11"));
  options = CHIASM_LOAD_OPTIONS_INIT;
  options.backend = "onnx";
  const char* const texts[] = {"fused", nullptr};
  options.options = texts;
  EXPECT_THAT(load(), HasSubstr("'fused' is not of the form key=value"));
}

TEST_F(Loading, CudaIsRefusedWithoutADeviceOrEngine) {
  EXPECT_THROW(
      {
        try {
          Bundle::open(path_).method("forward", LoadOptions().with_device(Device::cuda()));
        } catch (const Error& error) {
          EXPECT_EQ(error.code(), CHIASM_UNAVAILABLE) << error.what();
          EXPECT_THAT(error.what(), HasSubstr("CUDA"));
          throw;
        }
      },
      Error);
}

TEST_F(Loading, SelfTest) {
  int passed = 0, not_run = 0;
  for (const SelfTestRow& row : Bundle::open(path_).self_test()) {
    EXPECT_NE(row.result, SelfTestRow::Result::Failed) << row.artifact << ": " << row.message;
    EXPECT_EQ(row.method, "forward");
    EXPECT_EQ(row.dtype, "float32");
    if (row.result == SelfTestRow::Result::Passed) {
      ++passed;
      EXPECT_EQ(row.max_error, 0);
      EXPECT_EQ(row.tolerance, 1e-5);
    } else {
      ++not_run;
      EXPECT_NE(row.message, "");
    }
  }
  EXPECT_GE(passed, 2);   // native v3, onnx
  EXPECT_GE(not_run, 1);  // torch
  EXPECT_EQ(passed + not_run, 4);
  EXPECT_EQ(Bundle::open(path_).self_test(LoadOptions().with_backend("onnx")).size(), 1u);
  EXPECT_EQ(Bundle::open(path_).self_test(LoadOptions().with_dtype(DType::Float64)).size(), 0u);
}

TEST_F(Loading, SelfTestFindsWrongNumbersAndDamage) {
  set_artifact(path_, "forward.float32.onnx", "scale 2.5");
  const SelfTestRow row = Bundle::open(path_).self_test(LoadOptions().with_backend("onnx")).at(0);
  EXPECT_EQ(row.result, SelfTestRow::Result::Failed);
  EXPECT_THAT(row.message,
              AllOf(HasSubstr("output 'output': 60 of 60 values differ"), HasSubstr("output 'half'")));
  EXPECT_NEAR(row.max_error, 0.5 * 51.5, 1e-4);
  write_text(path_ + "/forward.float32.onnx", "scale 2");
  EXPECT_THAT(Bundle::open(path_).self_test(LoadOptions().with_backend("onnx")).at(0).message,
              HasSubstr("truncated"));
  const std::string golden = read_text(path_ + "/golden.safetensors");
  write_text(path_ + "/golden.safetensors", golden.substr(0, golden.size() - 1));
  EXPECT_THAT(refusal(CHIASM_CORRUPT, [&] { Bundle::open(path_).self_test(); }),
              HasSubstr("golden.safetensors: truncated"));
}

TEST_F(Loading, SelfTestShowsSmallAndLargeNumbers) {
  const auto says = [&](const std::string& words) {
    set_artifact(path_, "forward.float32.onnx", words);
    return Bundle::open(path_).self_test(LoadOptions().with_backend("onnx")).at(0).message;
  };
  EXPECT_THAT(says("scale 1e-9"), AllOf(HasSubstr("e-08, golden 103;"), HasSubstr("golden -15")));
  EXPECT_THAT(says("scale 1e30"), HasSubstr("e+31, golden 103;"));
}

TEST_F(Loading, SelfTestNamesAMissingGoldenTensor) {
  const std::string golden = safetensors({{"forward.float32/input", {1, 3, 3, 3}, std::vector<float>(27)}});
  write_text(path_ + "/golden.safetensors", golden);
  Json root = Json::parse(read_text(path_ + "/manifest.json"));
  root["golden"]["size"] = golden.size();
  root["golden"]["sha256"] = sha256_of(golden);
  write_text(path_ + "/manifest.json", root.dump());
  EXPECT_THAT(Bundle::open(path_).self_test(LoadOptions().with_backend("onnx")).at(0).message,
              HasSubstr("no tensor 'forward.float32/sigma'"));
}

}  // namespace
}  // namespace chiasm::testing
