/** Bundles' results for Eigen's objects against Eigen's own, which are an independent reference. */
#include "chiasm/eigen.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "on_backend.h"
#include "support.h"

namespace chiasm::testing {
namespace {

using ::testing::HasSubstr;

class WithEigen : public OnBackend {};
INSTANTIATE_TEST_SUITE_P(Built, WithEigen, ::testing::ValuesIn(ways_to_run()),
                         [](const auto& info) { return info.param; });

/** Eigen is an independent reference for rotations. */
TEST_P(WithEigen, RotationsAreThoseOfEigen) {
  constexpr int kCount = 50;
  using Rows3 = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;
  using Matrix3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
  std::vector<double> values = random_values<double>(3 * kCount, -1.7, 1.7), quaternions;
  values[0] = values[1] = 0;
  values[2] = 1e-9;  // almost no rotation
  const Rows3 axis_angle = Eigen::Map<Rows3>(values.data(), kCount, 3);
  for (int i = 0; i < kCount; ++i) {
    const Eigen::Vector3d axis = axis_angle.row(i);
    const Eigen::Vector4d quaternion =
        wxyz(Eigen::Quaterniond(Eigen::AngleAxisd(axis.norm(), axis.normalized())));
    quaternions.insert(quaternions.end(), quaternion.data(), quaternion.data() + 4);
  }
  const auto run = [this](const std::string& name, const std::vector<double>& input, int64_t columns,
                          double* tolerance) {
    const Method method = load_widest(open(name), "forward", options());
    *tolerance = dtype_of_method(method) == DType::Float64 ? 1e-7 : 1e-4;
    return run_widened(method, {{input, {kCount, columns}}})[0];
  };
  double matrix_tolerance, quaternion_tolerance, from_tolerance;
  auto matrices = run("geometry.conversions.axis_angle_to_rotation_matrix", values, 3, &matrix_tolerance);
  auto actual_quaternions =
      run("geometry.conversions.axis_angle_to_quaternion", values, 3, &quaternion_tolerance);
  auto from_quaternions =
      run("geometry.conversions.quaternion_to_rotation_matrix", quaternions, 4, &from_tolerance);
  for (int i = 0; i < kCount; ++i) {
    const Eigen::Quaterniond expected = quaternion_from_wxyz(&quaternions[4 * static_cast<size_t>(i)]);
    const Matrix3 rotation = expected.toRotationMatrix();
    EXPECT_LT((Eigen::Map<Matrix3>(&matrices[9 * static_cast<size_t>(i)]) - rotation).norm(),
              matrix_tolerance)
        << i;
    EXPECT_LT((Eigen::Map<Matrix3>(&from_quaternions[9 * static_cast<size_t>(i)]) - rotation).norm(),
              from_tolerance)
        << i;
    const Eigen::Quaterniond actual = quaternion_from_wxyz(&actual_quaternions[4 * static_cast<size_t>(i)]);
    EXPECT_LT(actual.angularDistance(expected), 10 * quaternion_tolerance) << i;
    EXPECT_NEAR(actual.norm(), 1, quaternion_tolerance) << i;
  }
}

TEST_P(WithEigen, EigensOwnOrderIsRefusedNotMisread) {
  const Method method =
      open("geometry.conversions.axis_angle_to_rotation_matrix").method("forward", options());
  const Eigen::MatrixXf column_major = Eigen::MatrixXf::Random(5, 3);
  EXPECT_THAT([&] { method.run({view(column_major)}); },
              ::testing::ThrowsMessage<Error>(HasSubstr("row_major")));
  const auto copy = row_major(column_major);
  const Outputs outputs = method.run({view(copy)});
  const Eigen::Vector3f last = column_major.row(4);
  const Eigen::Matrix3f expected = Eigen::AngleAxisf(last.norm(), last.normalized()).toRotationMatrix();
  const Eigen::Map<Eigen::Matrix<float, 3, 3, Eigen::RowMajor>> actual(outputs[0].data<float>() + 36);
  EXPECT_LT((actual - expected).norm(), 1e-4);
}

/** Rigid motions as inputs and outputs, single and many, also as maps. */
TEST_P(WithEigen, RigidMotionsAreThoseOfEigen) {
  std::vector<Eigen::Isometry3f> first, second;
  for (int i = 0; i < 20; ++i) {
    first.push_back(Eigen::Translation3f(Eigen::Vector3f::Random()) * Eigen::Quaternionf::UnitRandom());
    second.push_back(Eigen::Translation3f(Eigen::Vector3f::Random()) * Eigen::Quaternionf::UnitRandom());
  }
  const Method compose = open("geometry.linalg.compose_transformations").method("forward", options());
  const Method invert = open("geometry.linalg.inverse_transformation").method("forward", options());
  const auto products = unpack<Eigen::Isometry3f>(compose.run({pack(first), pack(second)})[0]);
  const auto inverses = unpack<Eigen::Isometry3f>(invert.run({pack(first)})[0]);
  ASSERT_EQ(products.size(), first.size());
  for (size_t i = 0; i < first.size(); ++i) {
    EXPECT_LT((products[i].matrix() - (first[i] * second[i]).matrix()).norm(), 1e-5);
    EXPECT_LT((inverses[i].matrix() - first[i].inverse().matrix()).norm(), 1e-5);
  }
  float memory[16];
  Eigen::Map<Eigen::Matrix4f> map(memory);
  map = first[3].matrix();
  const Outputs one = invert.run({pack(map)});
  EXPECT_LT((unpack<Eigen::Matrix4f>(one[0]).at(0) - first[3].inverse().matrix()).norm(), 1e-5);
}

TEST_P(WithEigen, QuaternionsAreThoseOfEigen) {
  std::vector<Eigen::Quaternionf> quaternions;
  std::vector<Eigen::Matrix3f> matrices;
  for (int i = 0; i < 20; ++i) {
    quaternions.push_back(Eigen::Quaternionf::UnitRandom());
    matrices.push_back(quaternions.back().toRotationMatrix());
  }
  const auto to_matrices = open("geometry.conversions.quaternion_to_rotation_matrix")
                               .method("forward", options())
                               .run({pack(quaternions)});
  const auto to_quaternions = open("geometry.conversions.rotation_matrix_to_quaternion")
                                  .method("forward", options())
                                  .run({pack(matrices)});
  const auto actual = unpack<Eigen::Matrix3f>(to_matrices[0]);
  const auto back = unpack<Eigen::Quaternionf>(to_quaternions[0]);
  for (size_t i = 0; i < matrices.size(); ++i) {
    EXPECT_LT((actual.at(i) - matrices[i]).norm(), 1e-5);
    EXPECT_LT(back.at(i).angularDistance(quaternions[i]), 1e-3);
  }
}

/** Eight equations, solved by Eigen's pivoted LU. */
TEST_P(WithEigen, FourPointHomographiesSolveEigensEquations) {
  using Points = Eigen::Matrix<float, 4, 2>;
  std::vector<Points> src, dst;
  Points square;
  square << 0, 0, 100, 0, 100, 80, 0, 80;
  for (int i = 0; i < 10; ++i) {
    src.push_back(square + 9 * Points::Random());
    dst.push_back(square + 9 * Points::Random());
  }
  const Method method = open("geometry.transform.get_perspective_transform").method("forward", options());
  const auto actual = unpack<Eigen::Matrix3f>(method.run({pack(src), pack(dst)})[0]);
  for (size_t i = 0; i < src.size(); ++i) {
    Eigen::Matrix<double, 8, 8> m = Eigen::Matrix<double, 8, 8>::Zero();
    Eigen::Matrix<double, 8, 1> right;
    for (int k = 0; k < 4; ++k) {
      const double x = src[i](k, 0), y = src[i](k, 1), u = dst[i](k, 0), v = dst[i](k, 1);
      m.row(2 * k) << x, y, 1, 0, 0, 0, -x * u, -y * u;
      m.row(2 * k + 1) << 0, 0, 0, x, y, 1, -x * v, -y * v;
      right.segment<2>(2 * k) << u, v;
    }
    Eigen::Matrix<double, 9, 1> h;
    h << m.partialPivLu().solve(right), 1;
    const Eigen::Matrix3d expected = Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(h.data());
    EXPECT_LT((actual.at(i).cast<double>() - expected).norm(), 1e-3 * expected.norm());
  }
}

/** Rotations and baseline from Eigen's singular value decomposition. */
TEST_P(WithEigen, EssentialMatricesComeApartAsByEigensSvd) {
  std::vector<Eigen::Matrix3f> essentials;
  for (int i = 0; i < 20; ++i) {
    const Eigen::Vector3f t = Eigen::Vector3f::Random().normalized();
    Eigen::Matrix3f skew;
    skew << 0, -t.z(), t.y(), t.z(), 0, -t.x(), -t.y(), t.x(), 0;
    essentials.push_back(skew * Eigen::Quaternionf::UnitRandom().toRotationMatrix());
  }
  const Method method = open("geometry.epipolar.decompose_essential_matrix").method("forward", options());
  const Outputs outputs = method.run({pack(essentials)});
  const auto r1 = unpack<Eigen::Matrix3f>(outputs[0]), r2 = unpack<Eigen::Matrix3f>(outputs[1]);
  const auto t = unpack<Eigen::Matrix<float, 3, 1>>(outputs[2]);
  for (size_t i = 0; i < essentials.size(); ++i) {
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(essentials[i].cast<double>(),
                                                Eigen::ComputeFullU | Eigen::ComputeFullV);
    Eigen::Matrix3d w, u = svd.matrixU(), v = svd.matrixV();
    w << 0, -1, 0, 1, 0, 0, 0, 0, 1;
    u *= u.determinant(), v *= v.determinant();
    const Eigen::Matrix3d a = u * w * v.transpose(), b = u * w.transpose() * v.transpose();
    const Eigen::Matrix3d first = r1.at(i).cast<double>(), second = r2.at(i).cast<double>();
    EXPECT_LT(std::min((first - a).norm() + (second - b).norm(), (first - b).norm() + (second - a).norm()),
              1e-4)
        << i;
    EXPECT_NEAR(std::abs(t.at(i).cast<double>().dot(u.col(2))), 1, 1e-5);
  }
}

TEST(Eigen, BoolsArePackedAndOtherMemoryIsNotRead) {
  using Mask = Eigen::Matrix<bool, 2, 3>;
  Mask mask = Mask::Constant(false);
  mask(1, 2) = true;
  const auto packed = pack(std::vector<Mask>{mask, Mask::Constant(true)});
  const Tensor tensor = packed;
  EXPECT_EQ(tensor.shape(), (Shape{2, 2, 3}));
  EXPECT_EQ(unpack<Mask>(tensor).at(0), mask);
  const Tensor elsewhere(reinterpret_cast<const float*>(64), {1, 3}, Device::cuda(0));
  EXPECT_THAT(refusal(CHIASM_INVALID_ARGUMENT, [&] { unpack<Eigen::Vector3f>(elsewhere); }),
              HasSubstr("expected a tensor in the CPU's memory"));
}

}  // namespace
}  // namespace chiasm::testing
