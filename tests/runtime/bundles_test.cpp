/** Real bundles on real backends. Only tests that need a GPU are skipped without one. */
#include <dlfcn.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <opencv2/imgproc.hpp>
#include <random>
#include <thread>

#include "base/cuda.h"
#include "chiasm/opencv.hpp"
#include "core/status.h"
#include "on_backend.h"

namespace chiasm::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

INSTANTIATE_TEST_SUITE_P(Built, OnBackend, ::testing::ValuesIn(ways_to_run()),
                         [](const auto& info) { return info.param; });

TEST_P(OnBackend, IsAvailable) {
  for (const BackendInfo& info : backends()) {
    if (info.name != backend()) continue;
    EXPECT_TRUE(info.available) << info.problem;
    EXPECT_NE(info.engine_version, "");
    return;
  }
  FAIL() << "not listed";
}

/** The reference: sqrt(gx^2 + gy^2 + eps) of the normalised Sobel derivatives, with a replicated border. */
cv::Mat sobel_of(const cv::Mat& image) {
  cv::Mat gx, gy, sum;
  cv::Sobel(image, gx, CV_32F, 1, 0, 3, 1.0 / 8, 0, cv::BORDER_REPLICATE);
  cv::Sobel(image, gy, CV_32F, 0, 1, 3, 1.0 / 8, 0, cv::BORDER_REPLICATE);
  cv::sqrt(gx.mul(gx) + gy.mul(gy) + 1e-6, sum);
  return sum;
}

TEST_P(OnBackend, SobelIsThatOfOpenCv) {
  const Method method = open("filters.sobel").method("forward", options());
  EXPECT_EQ(method.backend(), backend());
  for (const Shape& shape : {Shape{1, 1, 8, 8}, Shape{2, 3, 37, 53}, Shape{1, 2, 8, 128}}) {
    std::vector<float> image = random_values(static_cast<size_t>(shape.count()));
    const Outputs outputs = method.run({Tensor(image.data(), shape)});
    ASSERT_EQ(outputs[0].shape(), shape);
    const int height = static_cast<int>(shape[2]), width = static_cast<int>(shape[3]);
    for (int64_t plane = 0; plane < shape[0] * shape[1]; ++plane) {
      const cv::Mat input(height, width, CV_32F, image.data() + plane * height * width);
      const cv::Mat actual(height, width, CV_32F, outputs[0].data<float>() + plane * height * width);
      EXPECT_LT(cv::norm(actual, sobel_of(input), cv::NORM_INF), 2e-5);
    }
  }
}

TEST_P(OnBackend, RunIntoGivesWhatRunGives) {
  const Method method = open("filters.sobel").method("forward", options().with_warm_up());
  const Shape shape = {2, 3, 61, 67};
  std::vector<float> image = random_values(static_cast<size_t>(shape.count())), output(image.size(), -1);
  const Tensor input(image.data(), shape);
  method.run_into({input}, {Tensor(output.data(), shape)});
  const Outputs outputs = method.run({input});
  EXPECT_EQ(output, std::vector<float>(outputs[0].data<float>(), outputs[0].data<float>() + output.size()));
  EXPECT_EQ(method.output_type({input}).shape, shape);
}

TEST_P(OnBackend, RunEachGivesWhatRunsGive) {
  const Bundle bundle = open("filters.sobel");
  for (const int32_t threads : {0, 1}) {
    const Method method = bundle.method("forward", options().with_num_threads(threads));
    std::vector<Shape> shapes;
    std::vector<std::vector<float>> images, results;
    std::vector<std::vector<Tensor>> inputs, outputs;
    for (int64_t i = 0; i < 9; ++i) {
      shapes.push_back({1, i % 3 + 1, 20 + 7 * i, 90 - 5 * i});
      images.push_back(random_values(static_cast<size_t>(shapes.back().count())));
      results.emplace_back(images.back().size(), -1.0f);
    }
    for (size_t i = 0; i < shapes.size(); ++i) {
      inputs.push_back({Tensor(images[i].data(), shapes[i])});
      outputs.push_back({Tensor(results[i].data(), shapes[i])});
    }
    method.run_each(inputs, outputs);
    for (size_t i = 0; i < shapes.size(); ++i) {
      const Outputs alone = method.run(inputs[i]);
      const float* const expected = alone[0].data<float>();
      EXPECT_EQ(results[i], std::vector<float>(expected, expected + results[i].size())) << i;
    }
  }
}

TEST_P(OnBackend, WrongInputsNeverReachTheEngine) {
  const Method method = open("filters.sobel").method("forward", options());
  std::vector<float> image(3 * 8 * 8);
  std::vector<double> doubles(3 * 8 * 8);
  EXPECT_THROW(method.run({Tensor(doubles.data(), {1, 3, 8, 8})}), Error);
  EXPECT_THROW(method.run({Tensor(image.data(), {3, 8, 8})}), Error);
  EXPECT_THROW(method.run({Tensor(image.data(), {1, 3, 0, 8})}), Error);
  EXPECT_THROW(method.run({Tensor::strided(image.data(), {1, 3, 8, 8}, {192, 1, 24, 3})}), Error);
  EXPECT_THROW(method.run_into({Tensor(image.data(), {1, 3, 8, 8})}, {Tensor(image.data(), {1, 3, 8, 8})}),
               Error);
}

/** <u, J v>, by central differences in float64, is <J^T u, v> by vjp. */
TEST_P(OnBackend, VjpIsTheAdjointOfTheDerivative) {
  const Bundle bundle = open("filters.sobel");
  const Method forward = bundle.method("forward", options().with_dtype(DType::Float64));
  const Method vjp = load_widest(bundle, "vjp", options());
  const double tolerance = dtype_of_method(vjp) == DType::Float64 ? 1e-6 : 1e-3;
  const Shape shape = {1, 2, 9, 11};
  const size_t count = static_cast<size_t>(shape.count());
  const auto x = random_values<double>(count), u = random_values<double>(count, -1, 1),
             v = random_values<double>(count, -1, 1);
  constexpr double step = 1e-6;
  std::vector<double> above = x, below = x;
  for (size_t i = 0; i < count; ++i) {
    above[i] += step * v[i];
    below[i] -= step * v[i];
  }
  const auto high = run_widened(forward, {{above, shape}}), low = run_widened(forward, {{below, shape}});
  const auto gradients = run_widened(vjp, {{x, shape}, {u, shape}});
  double expected = 0, actual = 0;
  for (size_t i = 0; i < count; ++i) {
    expected += u[i] * (high[0][i] - low[0][i]) / (2 * step);
    actual += gradients[0][i] * v[i];
  }
  EXPECT_NEAR(actual, expected, tolerance * (1 + std::fabs(expected)));
}

TEST_P(OnBackend, EightThreadsOnOneMethod) {
  const Method method = open("filters.sobel").method("forward", options());
  std::vector<std::thread> threads;
  for (int t = 0; t < 8; ++t) {
    threads.emplace_back([&method, t] {
      const Shape shape = {1, 1 + t % 3, 16 + t, 40};
      std::vector<float> image(static_cast<size_t>(shape.count()));
      for (size_t i = 0; i < image.size(); ++i)
        image[i] = static_cast<float>((i * 7919 + static_cast<size_t>(t)) % 256) / 255;
      const cv::Mat expected = sobel_of(cv::Mat(16 + t, 40, CV_32F, image.data()));
      for (int i = 0; i < 20; ++i) {
        const Outputs outputs = method.run({Tensor(image.data(), shape)});
        EXPECT_LT(cv::norm(cv::Mat(16 + t, 40, CV_32F, outputs[0].data<float>()), expected, cv::NORM_INF),
                  2e-5);
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
}

// Large enough to be run in parts, whose number is not a multiple of the threads' number.
TEST_P(OnBackend, LargeBatchesGiveWhatTheirSamplesGive) {
  const Bundle bundle = open("filters.sobel");
  const int64_t batch = 13;
  const Shape one = {1, 3, 161, 203}, all = {batch, 3, 161, 203};
  const auto size = static_cast<size_t>(one.count());
  std::vector<float> image = random_values(size * batch), cotangent = random_values(size * batch);
  for (const char* name : {"forward", "vjp"}) {
    const Method method = bundle.method(name, options());
    const auto inputs = [&](size_t sample, const Shape& shape) {
      std::vector<Tensor> tensors = {Tensor(image.data() + sample * size, shape)};
      if (name == std::string("vjp")) tensors.emplace_back(cotangent.data() + sample * size, shape);
      return tensors;
    };
    const Outputs together = method.run(inputs(0, all));
    ASSERT_EQ(together[0].shape(), all);
    for (size_t sample = 0; sample < batch; ++sample) {
      const Outputs alone = method.run(inputs(sample, one));
      const cv::Mat expected(1, static_cast<int>(size), CV_32F, alone[0].data<float>());
      const cv::Mat actual(1, static_cast<int>(size), CV_32F, together[0].data<float>() + sample * size);
      EXPECT_LT(cv::norm(actual, expected, cv::NORM_INF), 1e-5) << name << ", sample " << sample;
    }
  }
}

TEST_P(OnBackend, GrayscaleIsThatOfOpenCv) {
  const Method method = open("color.rgb_to_grayscale").method("forward", options());
  std::vector<float> image = random_values(3 * 20 * 30);
  std::vector<cv::Mat> planes;
  for (int c = 0; c < 3; ++c) planes.emplace_back(20, 30, CV_32F, image.data() + c * 600);
  cv::Mat interleaved, expected;
  cv::merge(planes, interleaved);
  cv::cvtColor(interleaved, expected, cv::COLOR_RGB2GRAY);
  const Outputs outputs = method.run({Tensor(image.data(), {1, 3, 20, 30})});
  EXPECT_EQ(outputs[0].shape(), (Shape{1, 1, 20, 30}));
  EXPECT_LT(cv::norm(cv::Mat(20, 30, CV_32F, outputs[0].data<float>()), expected, cv::NORM_INF), 2e-5);
}

TEST_P(OnBackend, AMatOfBytesGoesInAndComesOut) {
  const Method blur = open("filters.gaussian_blur2d.constant.frames").method("forward", options());
  const Method median = open("filters.median_blur.frames").method("forward", options());
  for (const int channels : {1, 3, 4}) {
    cv::Mat frame(61, 83, CV_8UC(channels)), blurred, padded, sorted;
    cv::randu(frame, 0, 256);
    cv::GaussianBlur(frame, blurred, cv::Size(5, 5), 1.1);
    const Outputs smooth = blur.run({view(frame)});
    EXPECT_EQ(cv::norm(to_mat(smooth[0]), blurred, cv::NORM_INF), 0) << channels;
    cv::copyMakeBorder(frame, padded, 1, 1, 1, 1, cv::BORDER_REFLECT_101);
    cv::medianBlur(padded, sorted, 3);
    cv::Mat out(frame.size(), frame.type());
    median.run_into({view(frame)}, {view(out)});
    EXPECT_EQ(cv::norm(out, sorted(cv::Rect(1, 1, frame.cols, frame.rows)), cv::NORM_INF), 0) << channels;
  }
  cv::Mat large(80, 100, CV_8UC3), mosaic(80, 100, CV_8UC3, cv::Scalar(1, 2, 3)), blurred;
  cv::randu(large, 0, 256);
  const cv::Rect place(3, 4, 50, 60);
  cv::Mat part = large(place), expected = mosaic.clone();  // with gaps between its rows
  cv::GaussianBlur(part.clone(), blurred, cv::Size(5, 5), 1.1);
  blurred.copyTo(expected(place));
  cv::Mat target = mosaic(place);
  blur.run_into({view(part)}, {view(target)});
  EXPECT_EQ(cv::norm(mosaic, expected, cv::NORM_INF), 0);
}

TEST_P(OnBackend, ABufferOfACameraIsItsParts) {
  const Method nv12 = open("color.nv12_to_rgb.frames").method("forward", options());
  const Method yuyv = open("color.yuyv_to_rgb.frames").method("forward", options());
  cv::Mat buffer(48 * 3 / 2, 66, CV_8UC1), expected;
  cv::randu(buffer, 0, 256);
  cv::cvtColor(buffer, expected, cv::COLOR_YUV2RGB_NV12);
  // One channel and two: each part lacks other dimensions of a batch of frames.
  const cv::Mat luma = buffer.rowRange(0, 48), chroma = buffer.rowRange(48, 72).reshape(2);
  const Outputs outputs = nv12.run({view(luma), view(chroma)});
  EXPECT_EQ(outputs[0].shape(), (Shape{48, 66, 3}));
  EXPECT_EQ(cv::norm(to_mat(outputs[0]), expected, cv::NORM_INF), 0);

  cv::Mat packed(30, 46, CV_8UC2), out(30, 46, CV_8UC3);
  cv::randu(packed, 0, 256);
  cv::cvtColor(packed, expected, cv::COLOR_YUV2RGB_YUYV);
  yuyv.run_into({view(packed.reshape(4))}, {view(out)});
  EXPECT_EQ(cv::norm(out, expected, cv::NORM_INF), 0);
}

TEST_P(OnBackend, ALetterboxIsResizeAndBorder) {
  const Method letterbox = open("pipelines.letterbox").method("forward", options());
  cv::Mat frame(121, 203, CV_8UC3), resized, bordered, blob;
  cv::randu(frame, 0, 256);
  cv::resize(frame, resized, cv::Size(640, 381), 0, 0, cv::INTER_LINEAR_EXACT);
  cv::copyMakeBorder(resized, bordered, 129, 130, 0, 0, cv::BORDER_CONSTANT, cv::Scalar::all(114));
  const Outputs outputs = letterbox.run({view(frame)});
  std::vector<cv::Mat> planes;
  cv::split(bordered, planes);
  for (size_t c = 0; c < 3; ++c) {
    planes[2 - c].convertTo(blob, CV_32F, 1.0 / 255);
    const cv::Mat actual(640, 640, CV_32F, outputs[0].data<float>() + c * 640 * 640);
    EXPECT_LT(cv::norm(actual, blob, cv::NORM_INF), 1e-6);
  }
  const float* const to_frame = outputs[1].data<float>();
  EXPECT_NEAR(to_frame[0] * 640 + to_frame[2], 203, 1e-3);
  EXPECT_NEAR(to_frame[4] * (129 + 381) + to_frame[5], 121, 1e-3);
}

TEST_P(OnBackend, EdgesOfAFrameWithoutACopy) {
  const Method method = open("pipelines.edges").method("forward", options());
  cv::Mat frame(121, 163, CV_8UC3), gray, blurred, gx, gy, magnitude, expected;
  cv::theRNG().state = 3;
  cv::randu(frame, 0, 256);
  cv::GaussianBlur(frame, frame, cv::Size(9, 9), 3);  // unblurred noise would saturate everywhere
  cv::Mat as_float;
  frame.convertTo(as_float, CV_32F);
  cv::cvtColor(as_float, gray, cv::COLOR_BGR2GRAY);
  cv::GaussianBlur(gray, blurred, cv::Size(5, 5), 1, 1, cv::BORDER_REFLECT_101);
  cv::Sobel(blurred, gx, CV_32F, 1, 0, 3, 1, 0, cv::BORDER_REPLICATE);
  cv::Sobel(blurred, gy, CV_32F, 0, 1, 3, 1, 0, cv::BORDER_REPLICATE);
  cv::magnitude(gx, gy, magnitude);
  magnitude.convertTo(expected, CV_8U);

  const Tensor input = view(frame);
  EXPECT_EQ(input.data(), frame.data);
  const Outputs outputs = method.run({input});
  const cv::Mat actual = to_mat(outputs[0]);
  ASSERT_EQ(actual.size(), frame.size());
  EXPECT_EQ(actual.data, outputs[0].data());
  EXPECT_LE(cv::norm(actual, expected, cv::NORM_INF), 1);
  EXPECT_GT(cv::mean(actual)[0], 1);

  cv::Mat target(121, 163, CV_8U);
  method.run_into({view(frame)}, {view(target)});
  EXPECT_EQ(cv::norm(target, actual, cv::NORM_INF), 0);
  const cv::Mat part = frame(cv::Rect(5, 5, 50, 40)), copy = part.clone();
  const Outputs of_part = method.run({view(part)}), of_copy = method.run({view(copy)});
  EXPECT_EQ(cv::norm(to_mat(of_part[0]), to_mat(of_copy[0]), cv::NORM_INF), 0);
}

TEST_P(OnBackend, TheArtifactSaysWhichFormRuns) {
  const std::string artifact = open("filters.sobel").method("forward", options()).artifact();
  const bool fused = artifact.find(".fused.onnx") != std::string::npos;
  const std::vector<std::string> built = built_backends();
  const bool has_native = std::find(built.begin(), built.end(), "native") != built.end();
  EXPECT_EQ(fused, GetParam() == "onnx" && has_native) << artifact;
}

TEST(Bundles, AutoTakesNativeFirst) {
  if (built_backends().front() != "native") GTEST_SKIP() << "built without the native backend";
  EXPECT_EQ(open("filters.sobel").method("forward").backend(), "native");
  EXPECT_EQ(open("filters.sobel").method("forward", LoadOptions().with_allow_native_code(false)).backend(),
            "onnx");
}

TEST(Bundles, TorchLeavesTheCallersNumbersOfThreads) {
  const std::vector<std::string> built = built_backends();
  if (std::find(built.begin(), built.end(), "torch") == built.end())
    GTEST_SKIP() << "built without the torch backend";
  ASSERT_FALSE(backends().empty());  // opens libtorch
  void* const libtorch = ::dlopen("libtorch_cpu.so", RTLD_NOW | RTLD_NOLOAD);
  ASSERT_NE(libtorch, nullptr) << ::dlerror();
  const auto get = reinterpret_cast<int (*)()>(::dlsym(libtorch, "omp_get_max_threads"));
  const auto set = reinterpret_cast<void (*)(int)>(::dlsym(libtorch, "omp_set_num_threads"));
  const auto exchange_mkl = reinterpret_cast<int (*)(int)>(::dlsym(libtorch, "MKL_Set_Num_Threads_Local"));
  ASSERT_TRUE(get != nullptr && set != nullptr);
  set(3);
  if (exchange_mkl != nullptr) exchange_mkl(4);  // not in libtorch for ARM
  const LoadOptions options = LoadOptions().with_backend("torch").with_num_threads(1);
  const Method method = open("filters.sobel").method("forward", options);
  EXPECT_EQ(get(), 3) << "after a load";
  const std::vector<float> image = random_values(3 * 64 * 64);
  method.run({Tensor(image.data(), {1, 3, 64, 64})});
  EXPECT_EQ(get(), 3) << "after a run";
  if (exchange_mkl != nullptr) EXPECT_EQ(exchange_mkl(0), 4);
}

TEST(Bundles, EveryOneProvesItself) {
  const std::vector<std::string> built = built_backends();
  std::map<std::string, int> passed;
  ASSERT_TRUE(std::filesystem::is_directory(bundle_folder()))
      << "CHIASM_TEST_BUNDLES is '" << bundle_folder() << "'";
  for (const auto& entry : std::filesystem::directory_iterator(bundle_folder())) {
    if (entry.path().extension() != ".chiasm") continue;
    SCOPED_TRACE(entry.path().string());
    const Bundle bundle = Bundle::open(entry.path().string());
    for (const SelfTestRow& row : bundle.self_test()) {
      SCOPED_TRACE(row.method + " " + row.artifact + " " + row.dtype);
      EXPECT_NE(row.result, SelfTestRow::Result::Failed)
          << row.message << " (largest difference " << row.max_error << ")";
      if (row.result == SelfTestRow::Result::Passed) ++passed[row.backend];
      const bool is_built = std::find(built.begin(), built.end(), row.backend) != built.end();
      if (row.result == SelfTestRow::Result::NotRun && is_built) {
        EXPECT_THAT(row.message, ::testing::AnyOf(HasSubstr("needs a CPU with"), HasSubstr("is for CUDA"),
                                                  HasSubstr("the bundle has no artifact for it")));
      }
    }
  }
  for (const std::string& backend : built) EXPECT_GT(passed[backend], 0) << backend;
}

/** The reason why a test on CUDA cannot run with this backend; empty if it can. */
std::string cuda_obstacle(const std::string& backend) {
  try {
    const base::CudaDevice device(0);
  } catch (const core::Error& error) {
    return error.what();
  }
  for (const BackendInfo& info : backends()) {
    if (info.name == backend && !info.has_cuda) return info.engine_version + " cannot use CUDA";
  }
  return "";
}

TEST_P(OnBackend, CudaMemoryStaysOnTheDevice) {
  const std::string obstacle = cuda_obstacle(backend());
  if (!obstacle.empty()) GTEST_SKIP() << obstacle;
  const Bundle bundle = open("filters.sobel");
  const Shape shape = {1, 3, 64, 64};
  std::vector<float> image = random_values(static_cast<size_t>(shape.count())), output(image.size());
  const size_t bytes = image.size() * sizeof(float);
  core::CudaBuffer input(0, bytes), result(0, bytes);
  input.copy_from_host(image.data(), bytes);
  const Method method = bundle.method("forward", options().with_device(Device::cuda()));
  const Tensor in(input.data(), DType::Float32, shape, Device::cuda()),
      out(result.data(), DType::Float32, shape, Device::cuda());
  method.run_into({in}, {out});
  result.copy_to_host(output.data(), bytes);
  EXPECT_LT(cv::norm(cv::Mat(64, 64, CV_32F, output.data()), sobel_of(cv::Mat(64, 64, CV_32F, image.data())),
                     cv::NORM_INF),
            2e-5);
  EXPECT_THAT([&] { method.run({in}); }, ::testing::ThrowsMessage<Error>(HasSubstr("run_into")));
  EXPECT_THAT([&] { method.run_into({Tensor(image.data(), shape)}, {out}); },
              ::testing::ThrowsMessage<Error>(HasSubstr("CUDA device 0")));
  for (const SelfTestRow& row : bundle.self_test(options().with_device(Device::cuda()))) {
    EXPECT_NE(row.result, SelfTestRow::Result::Failed) << row.artifact << ": " << row.message;
  }
}

}  // namespace
}  // namespace chiasm::testing
