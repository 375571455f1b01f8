// Eight floats or four doubles, so that a kernel is written once for both.
#pragma once

#include <immintrin.h>

#include <cstdint>

namespace chiasm::kernels {

template <class T>
struct Vector;

template <>
struct Vector<float> {
  using Type = __m256;
  static constexpr int64_t kLanes = 8;
  static Type load(const float* p) { return _mm256_loadu_ps(p); }
  static void store(float* p, Type v) { _mm256_storeu_ps(p, v); }
  static Type gather(const float* p, const int32_t* index) { return _mm256_i32gather_ps(p, _mm256_loadu_si256(reinterpret_cast<const __m256i*>(index)), 4); }
  /** The values of `v` that `lanes`, of eight integers, says; of two vectors where it does. */
  static Type pick(Type v, __m256i lanes) { return _mm256_permutevar8x32_ps(v, lanes); }
  static Type pick(Type a, Type b, __m256i lanes) { return _mm256_blendv_ps(pick(a, lanes), pick(b, lanes), _mm256_castsi256_ps(lanes)); }
  static Type all(float v) { return _mm256_set1_ps(v); }
  static Type max(Type a, Type b) { return _mm256_max_ps(a, b); }
  static Type min(Type a, Type b) { return _mm256_min_ps(a, b); }
  static Type sqrt(Type v) { return _mm256_sqrt_ps(v); }
  static Type floor(Type v) { return _mm256_floor_ps(v); }
  static void store_whole(int32_t* p, Type v) { _mm256_storeu_si256(reinterpret_cast<__m256i*>(p), _mm256_cvttps_epi32(v)); }
  using Mask = decltype(Type{} > Type{});
  static bool any(Mask m) { return _mm256_movemask_ps((Type)m) != 0; }
  static bool all_of(Mask m) { return _mm256_movemask_ps((Type)m) == 0xff; }
  static Type where(Mask m, Type v) { return _mm256_and_ps((Type)m, v); }  // 0 elsewhere
};

template <>
struct Vector<double> {
  using Type = __m256d;
  static constexpr int64_t kLanes = 4;
  static Type load(const double* p) { return _mm256_loadu_pd(p); }
  static void store(double* p, Type v) { _mm256_storeu_pd(p, v); }
  static Type gather(const double* p, const int32_t* index) { return _mm256_i32gather_pd(p, _mm_loadu_si128(reinterpret_cast<const __m128i*>(index)), 8); }
  static Type pick(Type v, __m256i lanes) { return _mm256_castps_pd(Vector<float>::pick(_mm256_castpd_ps(v), lanes)); }
  static Type pick(Type a, Type b, __m256i lanes) { return _mm256_castps_pd(Vector<float>::pick(_mm256_castpd_ps(a), _mm256_castpd_ps(b), lanes)); }
  static Type all(double v) { return _mm256_set1_pd(v); }
  static Type max(Type a, Type b) { return _mm256_max_pd(a, b); }
  static Type min(Type a, Type b) { return _mm256_min_pd(a, b); }
  static Type sqrt(Type v) { return _mm256_sqrt_pd(v); }
  static Type floor(Type v) { return _mm256_floor_pd(v); }
  static void store_whole(int32_t* p, Type v) { _mm_storeu_si128(reinterpret_cast<__m128i*>(p), _mm256_cvttpd_epi32(v)); }
  using Mask = decltype(Type{} > Type{});
  static bool any(Mask m) { return _mm256_movemask_pd((Type)m) != 0; }
  static bool all_of(Mask m) { return _mm256_movemask_pd((Type)m) == 0xf; }
  static Type where(Mask m, Type v) { return _mm256_and_pd((Type)m, v); }  // 0 elsewhere
};

// What `pick` takes for n lanes of numbers below 2 n: halves of a double are eight lanes too, and a sign says that it is the second vector's.
template <class T>
inline void store_lanes(const int32_t* numbers, int32_t* out) {
  constexpr int64_t kParts = 8 / Vector<T>::kLanes;
  for (int64_t i = 0; i < 8; ++i) {
    const int64_t lane = numbers[i / kParts] * kParts + i % kParts;
    out[i] = static_cast<int32_t>(lane % 8) | (lane < 8 ? 0 : INT32_MIN);
  }
}

// The first n lanes.
template <class T>
inline void store_part(T* p, typename Vector<T>::Type v, int64_t n) {
  T lanes[Vector<T>::kLanes];
  Vector<T>::store(lanes, v);
  for (int64_t i = 0; i < n; ++i) p[i] = lanes[i];
}

}  // namespace chiasm::kernels
