/** chiasm and Eigen: views of dense matrices, vectors, arrays and maps. Optional: needs Eigen 3.3 or later.
 *
 *      Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor> axis_angle(100, 3);
 *      auto out = method.run({chiasm::view(axis_angle)});
 *
 *  Eigen's own order is column-major: the view of such a matrix says so in its strides, and run refuses it rather than
 *  misread it. `row_major(m)` makes the copy that engines take.
 */
#ifndef CHIASM_EIGEN_HPP
#define CHIASM_EIGEN_HPP

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <type_traits>

#include "chiasm/chiasm.hpp"

namespace chiasm {

template <> struct DTypeOf<Eigen::half> { static constexpr DType value = DType::Float16; };

namespace detail {

template <class Derived, class Scalar>
Tensor view_eigen(const Derived& matrix, Scalar* data) {
  static_assert((int(Eigen::internal::traits<Derived>::Flags) & Eigen::DirectAccessBit) != 0,
                "an expression has no memory to view: evaluate it first, for example with chiasm::row_major");
  const auto inner = static_cast<int64_t>(matrix.innerStride());
  if constexpr (bool(Derived::IsVectorAtCompileTime)) {
    return Tensor::strided(data, Shape{static_cast<int64_t>(matrix.size())}, Shape{inner});
  } else {
    const auto outer = static_cast<int64_t>(matrix.outerStride());
    return Tensor::strided(data, Shape{static_cast<int64_t>(matrix.rows()), static_cast<int64_t>(matrix.cols())},
                           Derived::IsRowMajor ? Shape{outer, inner} : Shape{inner, outer});
  }
}

}  // namespace detail

/** A view: shape (rows, cols) of a matrix, (size,) of a vector. It does not keep the memory alive. */
template <class Derived>
Tensor view(Eigen::DenseBase<Derived>& matrix) {
  using Pointer = decltype(matrix.derived().data());
  return detail::view_eigen(matrix.derived(), static_cast<Pointer>(matrix.derived().data()));
}
/** The same, read-only: an input, not an output. */
template <class Derived>
Tensor view(const Eigen::DenseBase<Derived>& matrix) {
  return detail::view_eigen(matrix.derived(), static_cast<const typename Derived::Scalar*>(matrix.derived().data()));
}
/** A temporary matrix would be gone before the run. */
template <class Derived>
Tensor view(const Eigen::PlainObjectBase<Derived>&& matrix) = delete;

/** A dense row-major copy of any matrix or expression, which `view` makes a tensor that engines take. */
template <class Derived>
auto row_major(const Eigen::DenseBase<Derived>& matrix) {
  constexpr int rows = Derived::RowsAtCompileTime, cols = Derived::ColsAtCompileTime;
  // Eigen allows a column vector in column-major order only; for a vector the order makes no difference.
  constexpr int order = cols == 1 && rows != 1 ? Eigen::ColMajor : Eigen::RowMajor;
  Eigen::Matrix<typename Derived::Scalar, rows, cols, order> copy = matrix.derived().matrix();
  return copy;
}

/** chiasm's quaternions are (w, x, y, z); Eigen stores (x, y, z, w). Use these, never a view of `coeffs()`. */
template <class Derived>
Eigen::Matrix<typename Derived::Scalar, 4, 1> wxyz(const Eigen::QuaternionBase<Derived>& quaternion) {
  return {quaternion.w(), quaternion.x(), quaternion.y(), quaternion.z()};
}

/** The quaternion from four values (w, x, y, z). */
template <class T>
Eigen::Quaternion<std::remove_const_t<T>> quaternion_from_wxyz(T* values) {
  return {values[0], values[1], values[2], values[3]};
}

}  // namespace chiasm

#endif  // CHIASM_EIGEN_HPP
