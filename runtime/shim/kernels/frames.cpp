// Interleaved bytes as planes of numbers: a shuffle puts every third byte where an integer of 32 bits has its lowest.
#include "rows.h"

namespace chiasm::kernels {
namespace {

constexpr int64_t kBlock = 8192;

// Of eight pixels the numbers at `channel` of each.
inline __m256 numbers(__m256i pixels, int channel) {
  const auto at = [channel](int pixel) { return static_cast<int>(0xffffff00u) | (3 * pixel + channel); };
  const __m256i lanes = _mm256_setr_epi32(at(0), at(1), at(2), at(3), at(0), at(1), at(2), at(3));
  return _mm256_cvtepi32_ps(_mm256_shuffle_epi8(pixels, lanes));
}

// Calls eight(i, first, second, third) with vectors for pixels i to i + 7, and one(i, ...) with numbers for what is left of n pixels.
template <class Eight, class One>
void for_pixels(const uint8_t* frame, int64_t n, const Eight& eight, const One& one) {
#pragma omp parallel for
  for (int64_t first = 0; first < n; first += kBlock) {
    const int64_t last = std::min(first + kBlock, n);
    int64_t i = first;
    // Both halves are loads of 16 bytes, of which 12 are theirs.
    for (; i + 8 <= last && 3 * i + 28 <= 3 * n; i += 8) {
      const auto* const low = reinterpret_cast<const __m128i*>(frame + 3 * i);
      const auto* const high = reinterpret_cast<const __m128i*>(frame + 3 * i + 12);
      const __m256i pixels = _mm256_set_m128i(_mm_loadu_si128(high), _mm_loadu_si128(low));
      eight(i, numbers(pixels, 0), numbers(pixels, 1), numbers(pixels, 2));
    }
    for (; i < last; ++i) one(i, static_cast<float>(frame[3 * i]), static_cast<float>(frame[3 * i + 1]), static_cast<float>(frame[3 * i + 2]));
  }
}

}  // namespace

void frame_to_rgb(const uint8_t* frame, int64_t n, float* out) {
  float *const red = out, *const green = out + n, *const blue = out + 2 * n;
  for_pixels(
      frame, n,
      [=](int64_t i, __m256 b, __m256 g, __m256 r) {
        _mm256_storeu_ps(red + i, r);
        _mm256_storeu_ps(green + i, g);
        _mm256_storeu_ps(blue + i, b);
      },
      [=](int64_t i, float b, float g, float r) {
        red[i] = r;
        green[i] = g;
        blue[i] = b;
      });
}

void frame_to_grey(const uint8_t* frame, int64_t n, float* out) {
  const auto luma = [](auto b, auto g, auto r) { return r * 0.299f + g * 0.587f + b * 0.114f; };
  for_pixels(
      frame, n, [=](int64_t i, __m256 b, __m256 g, __m256 r) { _mm256_storeu_ps(out + i, luma(b, g, r)); },
      [=](int64_t i, float b, float g, float r) { out[i] = luma(b, g, r); });
}

}  // namespace chiasm::kernels
