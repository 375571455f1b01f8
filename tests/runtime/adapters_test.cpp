/** opencv.hpp and eigen.hpp: views without a copy, read correctly. */
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "chiasm/eigen.hpp"
#include "chiasm/opencv.hpp"
#include "support.h"

namespace chiasm::testing {
namespace {

using ::testing::HasSubstr;

TEST(OpenCv, AViewSharesTheMatsMemory) {
  cv::Mat color(4, 5, CV_8UC3, cv::Scalar(1, 2, 3));
  const Tensor tensor = view(color);
  EXPECT_EQ(tensor.shape(), (Shape{4, 5, 3}));
  EXPECT_EQ(tensor.dtype(), DType::UInt8);
  EXPECT_TRUE(tensor.is_contiguous());
  EXPECT_EQ(tensor.data<uint8_t>(), color.data);
  const cv::Mat gray(4, 5, CV_32F);
  EXPECT_EQ(view(gray).shape(), (Shape{4, 5}));
  EXPECT_EQ(view(gray).dtype(), DType::Float32);
  EXPECT_TRUE(view(gray).read_only());
  EXPECT_EQ(view(gray).data<const float>(), gray.ptr<float>());
  EXPECT_THROW(view(gray).data<float>(), Error);
}

TEST(OpenCv, ARegionOfInterestHasItsStrides) {
  cv::Mat whole(10, 10, CV_8UC3);
  cv::Mat part = whole(cv::Rect(2, 3, 4, 5));
  EXPECT_EQ(view(part).shape(), (Shape{5, 4, 3}));
  EXPECT_EQ(view(part).strides(), (Shape{30, 3, 1}));
  EXPECT_FALSE(view(part).is_contiguous());
  EXPECT_EQ(view(part).data(), whole.ptr(3, 2));
  const cv::Mat copy = part.clone();
  EXPECT_TRUE(view(copy).is_contiguous());
  cv::Mat row = whole(cv::Rect(2, 3, 4, 1));
  EXPECT_TRUE(view(row).is_contiguous());
}

TEST(OpenCv, ManyDimensionsAndTypes) {
  const int sizes[] = {2, 3, 4};
  cv::Mat volume(3, sizes, CV_64FC2);
  EXPECT_EQ(view(volume).shape(), (Shape{2, 3, 4, 2}));
  EXPECT_TRUE(view(volume).is_contiguous());
  cv::Mat unsigned16(2, 2, CV_16U), wide(2, 2, CV_16UC3), empty;
  EXPECT_EQ(view(unsigned16).dtype(), DType::UInt16);
  EXPECT_EQ(to_mat(view(wide)).type(), CV_16UC3);
  EXPECT_THROW(view(empty), Error);
}

TEST(OpenCv, BackToMat) {
  std::vector<uint8_t> pixels(4 * 5 * 3);
  const cv::Mat mat = to_mat(Tensor(pixels.data(), {4, 5, 3}));
  EXPECT_EQ(mat.type(), CV_8UC3);
  EXPECT_EQ(mat.rows, 4);
  EXPECT_EQ(mat.data, pixels.data());
  std::vector<float> values(6);
  EXPECT_EQ(to_mat(Tensor(values.data(), {2, 3})).type(), CV_32FC1);
  cv::Mat whole(10, 10, CV_8UC3);
  cv::Mat part = whole(cv::Rect(2, 3, 4, 5));
  EXPECT_EQ(to_mat(view(part)).step[0], part.step[0]);
  EXPECT_EQ(to_mat(view(part)).data, part.data);
  EXPECT_THROW(to_mat(Tensor(values.data(), {6})), Error);
  EXPECT_THROW(to_mat(Tensor(values.data(), {1, 1, 2, 3})), Error);
  EXPECT_THROW(to_mat(Tensor(values.data(), {1, 1, 600})), Error);
  EXPECT_THROW(to_mat(Tensor::strided(values.data(), {2, 3}, {1, 2})), Error);
  // A Mat would take a step of 0 for rows without gaps, and read behind the only row
  for (const int64_t step : {0, 2, -3})
    EXPECT_THROW(to_mat(Tensor::strided(values.data() + 3, {2, 3}, {step, 1})), Error);
  EXPECT_THROW(to_mat(Tensor(values.data(), {int64_t{1} << 40, 3})), Error);
  EXPECT_THROW(to_mat(Tensor(values.data(), {2, 3}, Device::cuda())), Error);
}

TEST(OpenCv, PlanesAndBack) {
  cv::Mat frame(5, 7, CV_8UC3);
  for (int y = 0; y < 5; ++y) {
    for (int x = 0; x < 7; ++x)
      frame.at<cv::Vec3b>(y, x) = cv::Vec3b(uchar(10 * y + x), uchar(100 + x), uchar(200 + y));
  }
  const Planes bytes = planes(frame);
  EXPECT_EQ(bytes.shape(), (Shape{1, 3, 5, 7}));
  EXPECT_EQ(bytes.dtype(), DType::UInt8);
  const Planes rgb = planes(frame, 1 / 255.0, true);
  EXPECT_EQ(rgb.dtype(), DType::Float32);
  const auto* const values = rgb.tensor().data<const float>();
  for (int c = 0; c < 3; ++c) {
    for (int y = 0; y < 5; ++y) {
      for (int x = 0; x < 7; ++x) {
        EXPECT_FLOAT_EQ(values[(c * 5 + y) * 7 + x], float(frame.at<cv::Vec3b>(y, x)[2 - c] / 255.0));
        EXPECT_EQ(bytes.tensor().data<const uint8_t>()[(c * 5 + y) * 7 + x], frame.at<cv::Vec3b>(y, x)[c]);
      }
    }
  }
  for (const cv::Mat& back : {planes_to_mat(rgb, CV_8U, 255, true), planes_to_mat(bytes)}) {
    ASSERT_EQ(back.type(), CV_8UC3);
    EXPECT_EQ(cv::norm(back, frame, cv::NORM_INF), 0);
  }
  // A region of a frame, whose rows have gaps, with 16 bits, as from depth cameras.
  cv::Mat depth(6, 6, CV_16U, cv::Scalar(40000));
  depth.at<uint16_t>(2, 3) = 65535;
  const Planes part = planes(depth(cv::Rect(2, 1, 3, 4)));
  EXPECT_EQ(part.shape(), (Shape{1, 1, 4, 3}));
  EXPECT_EQ(part.tensor().data<const uint16_t>()[1 * 3 + 1], 65535);
  std::vector<float> batch{0, 1, 2, 3, 4, 5, 6, 7};
  const cv::Mat second = planes_to_mat(Tensor(batch.data(), {2, 1, 2, 2}), -1, 1, false, 1);
  EXPECT_EQ(second.at<float>(1, 1), 7);
}

TEST(OpenCv, PlanesSayWhatIsWrong) {
  std::vector<float> values(24);
  const auto says = [](const std::string& words) {
    return ::testing::ThrowsMessage<Error>(HasSubstr(words));
  };
  EXPECT_THAT([] { planes(cv::Mat()); }, says("empty"));
  EXPECT_THAT([] { planes(cv::Mat(), 1, true); }, says("empty"));
  EXPECT_THAT([] { planes(cv::Mat(2, 2, CV_8U), 1, true); }, says("swap_rb is for 3 or 4 channels"));
  const int sizes[] = {2, 3, 4};
  EXPECT_THAT([&] { planes(cv::Mat(3, sizes, CV_8U)); }, says("2 dimensions, got 3"));
  EXPECT_THAT([&] { planes_to_mat(Tensor(values.data(), {4, 6})); }, says("got one of 2 dimensions"));
  EXPECT_THAT(
      [&] {
        planes_to_mat(Tensor(values.data(), {2, 3, 2, 2}), -1, 1, false, 2);
      },
      says("there is no image 2, only 2"));
  EXPECT_THAT(
      [&] {
        planes_to_mat(Tensor(values.data(), {2, 3, 4}), -1, 1, true);
      },
      says("the tensor has 2"));
  EXPECT_THAT(
      [&] {
        planes_to_mat(Tensor(values.data(), {2, 3, 4}, Device::cuda()));
      },
      says("not in CPU memory"));
  EXPECT_THAT([&] { planes_to_mat(Tensor(values.data(), {3, -1, 5})); }, says("got -1 x 5"));
}

TEST(OpenCv, AnImageWithoutPixelsKeepsItsType) {
  const float none = 0;
  const cv::Mat empty = planes_to_mat(Tensor(&none, {3, 0, 5}), CV_8U);
  EXPECT_EQ(empty.type(), CV_8UC3);
  EXPECT_EQ(empty.size(), cv::Size(5, 0));
}

TEST(OpenCv, AReadOnlyTensorIsNotMadeAMat) {
  const std::vector<float> values(6);
  EXPECT_THAT(
      [&] {
        to_mat(Tensor(values.data(), {2, 3}));
      },
      ::testing::ThrowsMessage<Error>(HasSubstr("read-only")));
  const cv::Mat mat(2, 3, CV_32F, cv::Scalar(0));
  EXPECT_THROW(to_mat(view(mat)), Error);
}

template <class T, class = void>
struct CanBeMat : std::false_type {};
template <class T>
struct CanBeMat<T, std::void_t<decltype(to_mat(std::declval<T>()))>> : std::true_type {};
template <class T, class = void>
struct HasData : std::false_type {};
template <class T>
struct HasData<T, std::void_t<decltype(std::declval<T>().template data<float>())>> : std::true_type {};

TEST(OpenCv, OutputsThatEndWithTheStatementAreNotMadeAMat) {
  using Kept = decltype(std::declval<const Outputs&>()[0]);
  using Temporary = decltype(std::declval<const Method&>().run({})[0]);
  static_assert(CanBeMat<Kept>::value && !CanBeMat<Temporary>::value && !CanBeMat<Temporary&>::value);
  static_assert(HasData<Kept>::value && !HasData<Temporary>::value);
  static_assert(std::is_convertible_v<Temporary, Tensor>, "an argument of another run");
}

TEST(Eigen, RowMajorAndVectorsAreDense) {
  Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor> points(4, 3);
  EXPECT_EQ(view(points).shape(), (Shape{4, 3}));
  EXPECT_TRUE(view(points).is_contiguous());
  EXPECT_EQ(view(points).data<float>(), points.data());
  Eigen::VectorXd vector(5);
  EXPECT_EQ(view(vector).shape(), (Shape{5}));
  EXPECT_TRUE(view(vector).is_contiguous());
  const Eigen::Vector3f fixed(1, 2, 3);
  EXPECT_TRUE(view(fixed).read_only());
  Eigen::RowVector4f row;
  EXPECT_EQ(view(row).shape(), (Shape{4}));
  Eigen::Map<Eigen::Matrix<float, 2, 6, Eigen::RowMajor>> map(points.data());
  EXPECT_EQ(view(map).data(), points.data());
  EXPECT_FALSE(view(map).read_only());
}

TEST(Eigen, ColumnMajorIsSeenAsWhatItIs) {
  Eigen::MatrixXf matrix(2, 3);
  matrix << 1, 2, 3, 4, 5, 6;
  const Tensor tensor = view(matrix);
  EXPECT_EQ(tensor.shape(), (Shape{2, 3}));
  EXPECT_EQ(tensor.strides(), (Shape{1, 2}));
  EXPECT_FALSE(tensor.is_contiguous());
  auto copy = row_major(matrix);
  EXPECT_TRUE(view(copy).is_contiguous());
  EXPECT_THAT(std::vector<float>(copy.data(), copy.data() + 6), ::testing::ElementsAre(1, 2, 3, 4, 5, 6));
  auto of_expression = row_major(matrix.transpose() * 2);
  EXPECT_EQ(view(of_expression).shape(), (Shape{3, 2}));
  EXPECT_EQ(of_expression.data()[1], 8);
  auto block = matrix.block(0, 1, 2, 2);
  EXPECT_EQ(view(block).strides(), (Shape{1, 2}));
  EXPECT_EQ(view(block).data(), matrix.data() + 2);
  const Eigen::VectorXf vector = Eigen::VectorXf::Ones(3);
  auto vector_copy = row_major(vector);
  EXPECT_EQ(view(vector_copy).shape(), (Shape{3}));
}

template <class T, class = void>
struct CanView : std::false_type {};
template <class T>
struct CanView<T, std::void_t<decltype(view(std::declval<T>()))>> : std::true_type {};

TEST(Eigen, TemporariesAreNotViewed) {
  static_assert(CanView<Eigen::MatrixXf&>::value && CanView<const Eigen::MatrixXf&>::value);
  static_assert(!CanView<Eigen::MatrixXf>::value && !CanView<Eigen::MatrixXf&&>::value);
  static_assert(CanView<Eigen::Map<Eigen::MatrixXf>>::value);
}

TEST(Eigen, QuaternionsComeInTheOrderWxyz) {
  const Eigen::Quaternionf quaternion(0.5f, 0.1f, 0.2f, 0.3f);
  const Eigen::Vector4f values = wxyz(quaternion);
  EXPECT_EQ(values, Eigen::Vector4f(0.5f, 0.1f, 0.2f, 0.3f));
  EXPECT_EQ(quaternion_from_wxyz(values.data()).coeffs(), quaternion.coeffs());
}

TEST(Eigen, PackedObjectsLieByRows) {
  Eigen::Matrix3f matrix;
  matrix << 1, 2, 3, 4, 5, 6, 7, 8, 9;
  const auto one = pack(matrix);
  const Tensor tensor = one;
  EXPECT_EQ(tensor.shape(), (Shape{1, 3, 3}));
  EXPECT_TRUE(tensor.read_only());
  EXPECT_THAT(std::vector<float>(tensor.data<const float>(), tensor.data<const float>() + 9),
              ::testing::ElementsAre(1, 2, 3, 4, 5, 6, 7, 8, 9));
  EXPECT_EQ(unpack<Eigen::Matrix3f>(tensor).at(0), matrix);
  const Eigen::Map<const Eigen::Matrix<float, 2, 3>> map(matrix.data());
  const auto from_map = pack(map);
  EXPECT_EQ((unpack<Eigen::Matrix<float, 2, 3>>(from_map).at(0)), map);
  const auto vectors = pack(std::vector<Eigen::Vector2d>{{1, 2}, {3, 4}, {5, 6}});
  EXPECT_EQ(Tensor(vectors).shape(), (Shape{3, 2}));
  EXPECT_EQ(unpack<Eigen::Vector2d>(vectors).at(2), Eigen::Vector2d(5, 6));
  const Eigen::Isometry3d pose =
      Eigen::Translation3d(1, 2, 3) * Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitZ());
  const auto packed = pack(pose);
  EXPECT_EQ(Tensor(packed).shape(), (Shape{1, 4, 4}));
  EXPECT_EQ(Tensor(packed).data<const double>()[3], 1);
  EXPECT_TRUE(unpack<Eigen::Isometry3d>(packed).at(0).isApprox(pose));
  const Eigen::Quaternionf quaternion(0.5f, 0.1f, 0.2f, 0.3f);
  const auto four = pack(quaternion);
  EXPECT_EQ(Tensor(four).data<const float>()[0], 0.5f);
  EXPECT_EQ(unpack<Eigen::Quaternionf>(four).at(0).coeffs(), quaternion.coeffs());
}

TEST(Eigen, WhatDoesNotFitIsNotUnpacked) {
  std::vector<float> values(36);
  EXPECT_THROW(unpack<Eigen::Matrix3f>(Tensor(values.data(), {4, 9})), Error);
  EXPECT_THROW(unpack<Eigen::Matrix3f>(Tensor(values.data(), {2, 2, 3, 3})), Error);
  EXPECT_THROW(unpack<Eigen::Matrix3d>(Tensor(values.data(), {4, 3, 3})), Error);
  EXPECT_THROW(unpack<Eigen::Matrix3f>(Tensor::strided(values.data(), {2, 3, 3}, {9, 1, 3})), Error);
  EXPECT_THROW(unpack<Eigen::Quaternionf>(Tensor(values.data(), {12, 3})), Error);
  EXPECT_EQ(unpack<Eigen::Vector3f>(Tensor(values.data(), {12, 3, 1})).size(), 12u);
}

/** A method runs on a frame (H, W, 3), and on a region of it. */
TEST(Adapters, RunTakesFramesAndRegionsOfThem) {
  const TemporaryFolder folder;
  const std::string path = write_bundle(folder, [](nlohmann::json& m) {
    m["methods"].erase("vjp");
    auto& forward = m["methods"]["forward"];
    for (const char* side : {"inputs", "outputs"}) {
      forward[side].erase(1);
      forward[side][0]["shape"] = {"H", "W", 3};
      forward[side][0]["dtype"] = "uint8";
    }
    m["golden"]["cases"][0]["dtype"] = nullptr;
  });
  const Method method = Bundle::open(path).method("forward");
  cv::Mat frame(480, 640, CV_8UC3, cv::Scalar(10, 20, 30));
  const Outputs outputs = method.run({view(frame)});
  EXPECT_EQ(to_mat(outputs[0]).at<cv::Vec3b>(479, 639), cv::Vec3b(20, 40, 60));
  cv::Mat result(480, 640, CV_8UC3);
  method.run_into({view(frame)}, {view(result)});
  EXPECT_EQ(result.at<cv::Vec3b>(0, 0), cv::Vec3b(20, 40, 60));
  const cv::Rect place(10, 20, 100, 90);
  cv::Mat part = frame(place), expected = frame.clone();
  part.at<cv::Vec3b>(89, 99) = cv::Vec3b(1, 2, 3);
  const Outputs of_part = method.run({view(part)});
  EXPECT_EQ(to_mat(of_part[0]).at<cv::Vec3b>(89, 99), cv::Vec3b(2, 4, 6));
  method.run_into({view(part)}, {view(part)});
  expected(place).setTo(cv::Scalar(20, 40, 60));
  expected.at<cv::Vec3b>(109, 109) = cv::Vec3b(2, 4, 6);
  EXPECT_EQ(cv::norm(frame, expected, cv::NORM_INF), 0);
}

}  // namespace
}  // namespace chiasm::testing
