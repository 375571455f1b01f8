// Summed-area tables.
#include "rows.h"

namespace chiasm::kernels {
namespace {

__m256d load_four(const float* p) { return _mm256_cvtps_pd(_mm_loadu_ps(p)); }
__m256d load_four(const double* p) { return _mm256_loadu_pd(p); }
void store_four(float* p, __m256d v) { _mm_storeu_ps(p, _mm256_cvtpd_ps(v)); }
void store_four(double* p, __m256d v) { _mm256_storeu_pd(p, v); }
__m256d rounded(__m256d v, float) { return _mm256_cvtps_pd(_mm256_cvtpd_ps(v)); }
__m256d rounded(__m256d v, double) { return v; }

// Running sums of four values.
__m256d running(__m256d v) {
  const __m256d zero = _mm256_setzero_pd();
  v += _mm256_blend_pd(_mm256_permute4x64_pd(v, 0x90), zero, 1);  // one to the right
  return v + _mm256_permute2f128_pd(v, v, 0x08);                  // two to the right
}

// `above` has the columns' sums so far.
template <class T>
void add_row(const T* row, int64_t width, double* above, T* target) {
  __m256d left = _mm256_setzero_pd();
  int64_t k = 0;
  for (; k + 4 <= width; k += 4) {
    const __m256d sums = running(load_four(row + k));
    const __m256d total = _mm256_loadu_pd(above + k) + rounded(sums + left, T{});
    _mm256_storeu_pd(above + k, total);
    store_four(target + k, total);
    left += _mm256_permute4x64_pd(sums, 0xff);
  }
  double sum = _mm256_cvtsd_f64(left);
  for (; k < width; ++k) {
    sum += static_cast<double>(row[k]);
    above[k] += static_cast<double>(static_cast<T>(sum));
    target[k] = static_cast<T>(above[k]);
  }
}

}  // namespace

template <class T>
void integral(const T* x, Planes planes, T* out) {
  const int64_t height = planes.height, width = planes.width;
  const std::unique_ptr<double[]> columns(new double[static_cast<size_t>(width * omp_get_max_threads())]);
#pragma omp parallel
  {
    double* const above = columns.get() + width * omp_get_thread_num();
#pragma omp for
    for (int64_t plane = 0; plane < planes.count; ++plane) {
      std::fill_n(above, width, 0.0);
      for (int64_t y = plane * height; y < (plane + 1) * height; ++y) add_row(x + y * width, width, above, out + y * width);
    }
  }
}

template void integral(const float*, Planes, float*);
template void integral(const double*, Planes, double*);

}  // namespace chiasm::kernels
