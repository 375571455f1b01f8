/** Real bundles on real backends. The bundles are in the folder CHIASM_TEST_BUNDLES; one that is missing is a failure, and so
 *  is a backend that was built and cannot be used. Only what needs a GPU is skipped without one. */
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

#include "chiasm/eigen.hpp"
#include "chiasm/opencv.hpp"
#include "core/cuda.h"
#include "core/registry.h"
#include "core/status.h"

namespace chiasm::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

std::string bundle_folder() {
  const char* const folder = std::getenv("CHIASM_TEST_BUNDLES");
  return folder == nullptr ? "" : folder;
}

/** Fails, through the exception, where the bundle is missing. */
Bundle open(const std::string& name) { return Bundle::open(bundle_folder() + "/" + name + ".chiasm"); }

/** The backends that this build has. */
std::vector<std::string> built_backends() { return core::split_path(CHIASM_TEST_BACKENDS); }

/** These, and "onnx_flat": ONNX Runtime on standard operators, where "onnx" runs native code as one node. */
std::vector<std::string> ways_to_run() {
  std::vector<std::string> ways = built_backends();
  if (std::find(ways.begin(), ways.end(), "onnx") != ways.end()) ways.push_back("onnx_flat");
  return ways;
}

template <class T = float>
std::vector<T> random_values(size_t count, T low = 0, T high = 1) {
  static std::mt19937 generator(7);
  std::uniform_real_distribution<T> distribution(low, high);
  std::vector<T> values(count);
  for (T& value : values) value = distribution(generator);
  return values;
}

class OnBackend : public ::testing::TestWithParam<std::string> {
 protected:
  std::string backend() const { return GetParam().substr(0, GetParam().find('_')); }
  LoadOptions options() const { return LoadOptions().with_backend(backend()).with_fused(backend() == GetParam()); }
};

INSTANTIATE_TEST_SUITE_P(Built, OnBackend, ::testing::ValuesIn(ways_to_run()), [](const auto& info) { return info.param; });

TEST_P(OnBackend, IsAvailable) {
  for (const BackendInfo& info : backends()) {
    if (info.name != backend()) continue;
    EXPECT_TRUE(info.available) << info.problem;
    EXPECT_NE(info.engine_version, "");
    return;
  }
  FAIL() << "not listed";
}

/** The reference: sqrt(gx^2 + gy^2 + eps) of the normalised Sobel derivatives, the border replicated. */
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

TEST_P(OnBackend, WrongInputsNeverReachTheEngine) {
  const Method method = open("filters.sobel").method("forward", options());
  std::vector<float> image(3 * 8 * 8);
  std::vector<double> doubles(3 * 8 * 8);
  EXPECT_THROW(method.run({Tensor(doubles.data(), {1, 3, 8, 8})}), Error);
  EXPECT_THROW(method.run({Tensor(image.data(), {3, 8, 8})}), Error);
  EXPECT_THROW(method.run({Tensor(image.data(), {1, 3, 0, 8})}), Error);
  EXPECT_THROW(method.run({Tensor::strided(image.data(), {1, 3, 8, 8}, {192, 1, 24, 3})}), Error);
  EXPECT_THROW(method.run_into({Tensor(image.data(), {1, 3, 8, 8})}, {Tensor(image.data(), {1, 3, 8, 8})}), Error);
}

/** Load a method in float64, or in float32 where this backend has no more. */
Method load_widest(const Bundle& bundle, const std::string& name, LoadOptions options) {
  try {
    return bundle.method(name, options.with_dtype(DType::Float64));
  } catch (const Error& error) {
    if (error.code() != CHIASM_NOT_FOUND) throw;
    return bundle.method(name, options.with_dtype(DType::Float32));
  }
}

DType dtype_of_method(const Method& method) { return method.info().inputs[0].dtypes[0]; }

/** Runs a method of floating inputs in its own dtype, on and to doubles. */
std::vector<std::vector<double>> run_widened(const Method& method, const std::vector<std::pair<std::vector<double>, Shape>>& inputs) {
  const bool wide = dtype_of_method(method) == DType::Float64;
  std::vector<std::vector<float>> narrowed;
  std::vector<Tensor> tensors;
  for (const auto& [values, shape] : inputs) {
    narrowed.emplace_back(values.begin(), values.end());
    tensors.push_back(wide ? Tensor(values.data(), shape) : Tensor(narrowed.back().data(), shape));
  }
  const Outputs outputs = method.run(tensors);
  std::vector<std::vector<double>> results;
  for (size_t i = 0; i < outputs.size(); ++i) {
    const auto count = outputs[i].count();
    if (wide) {
      results.emplace_back(outputs[i].data<double>(), outputs[i].data<double>() + count);
    } else {
      results.emplace_back(outputs[i].data<float>(), outputs[i].data<float>() + count);
    }
  }
  return results;
}

/** <u, J v>, by central differences in float64, is <J^T u, v> by vjp. */
TEST_P(OnBackend, VjpIsTheAdjointOfTheDerivative) {
  const Bundle bundle = open("filters.sobel");
  const Method forward = bundle.method("forward", options().with_dtype(DType::Float64));
  const Method vjp = load_widest(bundle, "vjp", options());
  const double tolerance = dtype_of_method(vjp) == DType::Float64 ? 1e-6 : 1e-3;
  const Shape shape = {1, 2, 9, 11};
  const size_t count = static_cast<size_t>(shape.count());
  const auto x = random_values<double>(count), u = random_values<double>(count, -1, 1), v = random_values<double>(count, -1, 1);
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
      for (size_t i = 0; i < image.size(); ++i) image[i] = static_cast<float>((i * 7919 + static_cast<size_t>(t)) % 256) / 255;
      const cv::Mat expected = sobel_of(cv::Mat(16 + t, 40, CV_32F, image.data()));
      for (int i = 0; i < 20; ++i) {
        const Outputs outputs = method.run({Tensor(image.data(), shape)});
        EXPECT_LT(cv::norm(cv::Mat(16 + t, 40, CV_32F, outputs[0].data<float>()), expected, cv::NORM_INF), 2e-5);
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
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

TEST_P(OnBackend, EdgesOfAFrameWithoutACopy) {
  const Method method = open("pipelines.edges").method("forward", options());
  cv::Mat frame(121, 163, CV_8UC3), gray, blurred, gx, gy, magnitude, expected;
  cv::theRNG().state = 3;
  cv::randu(frame, 0, 256);
  cv::GaussianBlur(frame, frame, cv::Size(9, 9), 3);  // noise alone would saturate everywhere
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
  cv::Mat part = frame(cv::Rect(5, 5, 50, 40));
  EXPECT_THAT([&] { method.run({view(part)}); }, ::testing::ThrowsMessage<Error>(AllOf(HasSubstr("'frame'"), HasSubstr("clone()"))));
}

/** Eigen knows nothing of us: an independent truth for rotations. */
TEST_P(OnBackend, RotationsAreThoseOfEigen) {
  constexpr int kCount = 50;
  using Rows3 = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;
  using Matrix3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
  std::vector<double> values = random_values<double>(3 * kCount, -1.7, 1.7), quaternions;
  values[0] = values[1] = 0;
  values[2] = 1e-9;  // almost no rotation
  const Rows3 axis_angle = Eigen::Map<Rows3>(values.data(), kCount, 3);
  for (int i = 0; i < kCount; ++i) {
    const Eigen::Vector3d axis = axis_angle.row(i);
    const Eigen::Vector4d quaternion = wxyz(Eigen::Quaterniond(Eigen::AngleAxisd(axis.norm(), axis.normalized())));
    quaternions.insert(quaternions.end(), quaternion.data(), quaternion.data() + 4);
  }
  const auto run = [this](const std::string& name, const std::vector<double>& input, int64_t columns, double* tolerance) {
    const Method method = load_widest(open(name), "forward", options());
    *tolerance = dtype_of_method(method) == DType::Float64 ? 1e-7 : 1e-4;
    return run_widened(method, {{input, {kCount, columns}}})[0];
  };
  double matrix_tolerance, quaternion_tolerance, from_tolerance;
  auto matrices = run("geometry.conversions.axis_angle_to_rotation_matrix", values, 3, &matrix_tolerance);
  auto actual_quaternions = run("geometry.conversions.axis_angle_to_quaternion", values, 3, &quaternion_tolerance);
  auto from_quaternions = run("geometry.conversions.quaternion_to_rotation_matrix", quaternions, 4, &from_tolerance);
  for (int i = 0; i < kCount; ++i) {
    const Eigen::Quaterniond expected = quaternion_from_wxyz(&quaternions[4 * static_cast<size_t>(i)]);
    const Matrix3 rotation = expected.toRotationMatrix();
    EXPECT_LT((Eigen::Map<Matrix3>(&matrices[9 * static_cast<size_t>(i)]) - rotation).norm(), matrix_tolerance) << i;
    EXPECT_LT((Eigen::Map<Matrix3>(&from_quaternions[9 * static_cast<size_t>(i)]) - rotation).norm(), from_tolerance) << i;
    const Eigen::Quaterniond actual = quaternion_from_wxyz(&actual_quaternions[4 * static_cast<size_t>(i)]);
    EXPECT_LT(actual.angularDistance(expected), 10 * quaternion_tolerance) << i;
    EXPECT_NEAR(actual.norm(), 1, quaternion_tolerance) << i;
  }
}

TEST_P(OnBackend, EigensOwnOrderIsRefusedNotMisread) {
  const Method method = open("geometry.conversions.axis_angle_to_rotation_matrix").method("forward", options());
  const Eigen::MatrixXf column_major = Eigen::MatrixXf::Random(5, 3);
  EXPECT_THAT([&] { method.run({view(column_major)}); }, ::testing::ThrowsMessage<Error>(HasSubstr("row_major")));
  const auto copy = row_major(column_major);
  const Outputs outputs = method.run({view(copy)});
  const Eigen::Vector3f last = column_major.row(4);
  const Eigen::Matrix3f expected = Eigen::AngleAxisf(last.norm(), last.normalized()).toRotationMatrix();
  const Eigen::Map<Eigen::Matrix<float, 3, 3, Eigen::RowMajor>> actual(outputs[0].data<float>() + 36);
  EXPECT_LT((actual - expected).norm(), 1e-4);
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
  EXPECT_EQ(open("filters.sobel").method("forward", LoadOptions().with_native_code(false)).backend(), "onnx");
}

TEST(Bundles, EveryOneProvesItself) {
  const std::vector<std::string> built = built_backends();
  std::map<std::string, int> passed;
  ASSERT_TRUE(std::filesystem::is_directory(bundle_folder())) << "CHIASM_TEST_BUNDLES is '" << bundle_folder() << "'";
  for (const auto& entry : std::filesystem::directory_iterator(bundle_folder())) {
    if (entry.path().extension() != ".chiasm") continue;
    SCOPED_TRACE(entry.path().string());
    const Bundle bundle = Bundle::open(entry.path().string());
    for (const SelfTestRow& row : bundle.self_test()) {
      SCOPED_TRACE(row.method + " " + row.artifact + " " + row.dtype);
      EXPECT_NE(row.result, SelfTestRow::Result::Failed) << row.message << " (largest difference " << row.max_error << ")";
      if (row.result == SelfTestRow::Result::Passed) ++passed[row.backend];
      const bool is_built = std::find(built.begin(), built.end(), row.backend) != built.end();
      if (row.result == SelfTestRow::Result::NotRun && is_built) {
        EXPECT_THAT(row.message, ::testing::AnyOf(HasSubstr("needs a CPU with"), HasSubstr("is for CUDA")));
      }
    }
  }
  for (const std::string& backend : built) EXPECT_GT(passed[backend], 0) << backend;
}

/** Whether a test on CUDA can be made with this backend; else why not. */
std::string cuda_obstacle(const std::string& backend) {
  try {
    core::cuda_compute_capability(0);
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
  const Tensor in(input.data(), DType::Float32, shape, Device::cuda()), out(result.data(), DType::Float32, shape, Device::cuda());
  method.run_into({in}, {out});
  result.copy_to_host(output.data(), bytes);
  EXPECT_LT(cv::norm(cv::Mat(64, 64, CV_32F, output.data()), sobel_of(cv::Mat(64, 64, CV_32F, image.data())), cv::NORM_INF), 2e-5);
  EXPECT_THAT([&] { method.run({in}); }, ::testing::ThrowsMessage<Error>(HasSubstr("run_into")));
  EXPECT_THAT([&] { method.run_into({Tensor(image.data(), shape)}, {out}); }, ::testing::ThrowsMessage<Error>(HasSubstr("CUDA device 0")));
  for (const SelfTestRow& row : bundle.self_test(options().with_device(Device::cuda()))) {
    EXPECT_NE(row.result, SelfTestRow::Result::Failed) << row.artifact << ": " << row.message;
  }
}

}  // namespace
}  // namespace chiasm::testing
