/** \file
 *  chiasm and Eigen: views of dense matrices, vectors, arrays and maps, and copies of small objects.
 *  Optional: needs Eigen 3.3 or later.
 *
 *      Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor> axis_angle(100, 3);
 *      auto out = method.run({chiasm::view(axis_angle)});
 *
 *      std::vector<Eigen::Isometry3f> poses = ...;
 *      auto inverses = chiasm::unpack<Eigen::Isometry3f>(invert.run({chiasm::pack(poses)})[0]);
 *
 *  Eigen's default order is column-major. The strides of a view of such a matrix show this, and run rejects
 *  the view instead of misreading it. `row_major(m)` makes a copy that engines accept.
 */
#ifndef CHIASM_EIGEN_HPP
#define CHIASM_EIGEN_HPP

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "chiasm/chiasm.hpp"

namespace chiasm {

template <>
struct DTypeOf<Eigen::half> {
  static constexpr DType value = DType::Float16;
};

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
    return Tensor::strided(data,
                           Shape{static_cast<int64_t>(matrix.rows()), static_cast<int64_t>(matrix.cols())},
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
  return detail::view_eigen(matrix.derived(),
                            static_cast<const typename Derived::Scalar*>(matrix.derived().data()));
}
/** Deleted: a temporary matrix would be destroyed before the run. */
template <class Derived>
Tensor view(const Eigen::PlainObjectBase<Derived>&& matrix) = delete;

/** A dense row-major copy of any matrix or expression. Engines accept a `view` of it. */
template <class Derived>
auto row_major(const Eigen::DenseBase<Derived>& matrix) {
  constexpr int rows = Derived::RowsAtCompileTime, cols = Derived::ColsAtCompileTime;
  // Eigen allows a column vector in column-major order only; for a vector the order makes no difference.
  constexpr int order = cols == 1 && rows != 1 ? Eigen::ColMajor : Eigen::RowMajor;
  Eigen::Matrix<typename Derived::Scalar, rows, cols, order> copy = matrix.derived().matrix();
  return copy;
}

/** chiasm's quaternions are (w, x, y, z); Eigen stores (x, y, z, w). Use these, never a view of
 *  `coeffs()`. */
template <class Derived>
Eigen::Matrix<typename Derived::Scalar, 4, 1> wxyz(const Eigen::QuaternionBase<Derived>& quaternion) {
  return {quaternion.w(), quaternion.x(), quaternion.y(), quaternion.z()};
}

/** The quaternion from four values (w, x, y, z). */
template <class T>
Eigen::Quaternion<std::remove_const_t<T>> quaternion_from_wxyz(T* values) {
  return {values[0], values[1], values[2], values[3]};
}

namespace detail {

/** The layout of one Eigen object in chiasm's memory: matrices by rows, transforms as their matrix,
 *  quaternions as (w, x, y, z). */
template <class T, class = void>
struct EigenLayout;

template <class T>
struct EigenLayout<T, std::enable_if_t<std::is_base_of_v<Eigen::DenseBase<T>, T>>> {
  using Scalar = typename T::Scalar;
  static constexpr int rows = T::RowsAtCompileTime, cols = T::ColsAtCompileTime;
  static_assert(rows != Eigen::Dynamic && cols != Eigen::Dynamic,
                "pack and unpack take types of fixed size: use view or row_major for others");
  using Rows = Eigen::Matrix<Scalar, rows, cols, cols == 1 && rows != 1 ? Eigen::ColMajor : Eigen::RowMajor>;
  static constexpr bool is_vector = bool(T::IsVectorAtCompileTime);
  static Shape shape(int64_t n) { return is_vector ? Shape{n, int64_t{rows} * cols} : Shape{n, rows, cols}; }
  static void put(const T& value, Scalar* out) { Eigen::Map<Rows>{out} = value.matrix(); }
  static T get(const Scalar* values) { return Eigen::Map<const Rows>(values); }
};

template <class S, int dimensions, int mode, int options>
struct EigenLayout<Eigen::Transform<S, dimensions, mode, options>> {
  using Type = Eigen::Transform<S, dimensions, mode, options>;
  using Matrix = EigenLayout<std::decay_t<decltype(std::declval<Type>().matrix())>>;
  using Scalar = S;
  static Shape shape(int64_t n) { return Matrix::shape(n); }
  static void put(const Type& value, Scalar* out) { Matrix::put(value.matrix(), out); }
  static Type get(const Scalar* values) {
    Type value;
    value.matrix() = Matrix::get(values);
    return value;
  }
};

template <class T>
struct EigenLayout<T, std::enable_if_t<std::is_base_of_v<Eigen::QuaternionBase<T>, T>>> {
  using Scalar = typename T::Scalar;
  static Shape shape(int64_t n) { return {n, 4}; }
  static void put(const T& value, Scalar* out) { Eigen::Map<Eigen::Matrix<Scalar, 4, 1>>{out} = wxyz(value); }
  static Eigen::Quaternion<Scalar> get(const Scalar* values) { return quaternion_from_wxyz(values); }
};

}  // namespace detail

/** Copies of Eigen objects in chiasm's layout. Converts to a Tensor, which is valid as long as this
 *  object. */
template <class Scalar>
class Packed final {
 public:
  Packed(std::unique_ptr<Scalar[]> values, Shape shape) : values_(std::move(values)), shape_(shape) {}
  /** A read-only view. */
  operator Tensor() const { return Tensor(static_cast<const Scalar*>(values_.get()), shape_); }

 private:
  std::unique_ptr<Scalar[]> values_;
  Shape shape_;
};

/** Copies objects of one type and fixed size: matrices, transforms and their maps become (N, rows, cols),
 *  vectors (N, size), and quaternions (N, 4) in the order (w, x, y, z), whatever their order in Eigen. */
template <class T, class Allocator>
auto pack(const std::vector<T, Allocator>& items) {
  using Layout = detail::EigenLayout<T>;
  const Shape shape = Layout::shape(static_cast<int64_t>(items.size()));
  auto values = std::make_unique<typename Layout::Scalar[]>(static_cast<size_t>(shape.count()));
  const size_t each = static_cast<size_t>(Layout::shape(1).count());
  for (size_t i = 0; i < items.size(); ++i) Layout::put(items[i], values.get() + i * each);
  return Packed<typename Layout::Scalar>(std::move(values), shape);
}

/** One object, as a batch of one. */
template <class T, class Layout = detail::EigenLayout<T>>
auto pack(const T& item) {
  auto values = std::make_unique<typename Layout::Scalar[]>(static_cast<size_t>(Layout::shape(1).count()));
  Layout::put(item, values.get());
  return Packed<typename Layout::Scalar>(std::move(values), Layout::shape(1));
}

/** The objects in a dense tensor of T's scalars: matrices or transforms from (N, rows, cols) or (rows, cols),
 *  the other types as in `pack`; column vectors also from (N, rows, 1). Throws Error for any other tensor. */
template <class T>
auto unpack(const Tensor& tensor) {
  using Layout = detail::EigenLayout<T>;
  const Shape one = Layout::shape(1);
  const int64_t each = one.count();
  if (tensor.device() != Device::cpu())
    throw Error(CHIASM_INVALID_ARGUMENT,
                "unpack: expected a tensor in the CPU's memory: copy it there first");
  const Shape& shape = tensor.shape();
  // The last dimensions must be those of an object; vectors may have one more dimension, of size 1.
  size_t left = shape.size(), wanted = one.size();
  if (left > 1 && wanted == 2 && shape[left - 1] == 1 && one[1] != 1) --left;
  bool fits = tensor.is_contiguous();
  for (; fits && wanted > 1; --wanted, --left) fits = left > 0 && shape[left - 1] == one[wanted - 1];
  if (!fits || left > 1) {
    throw Error(CHIASM_INVALID_ARGUMENT, "unpack: expected dense objects of " + std::to_string(each) +
                                             " values in a batch of at most one dimension, got a tensor of " +
                                             std::to_string(shape.size()) + " dimensions and " +
                                             std::to_string(shape.count()) + " values");
  }
  std::vector<decltype(Layout::get(nullptr))> items;
  const auto* values = tensor.data<const typename Layout::Scalar>();
  for (int64_t i = 0; i < tensor.count() / each; ++i) items.push_back(Layout::get(values + i * each));
  return items;
}

}  // namespace chiasm

#endif  // CHIASM_EIGEN_HPP
