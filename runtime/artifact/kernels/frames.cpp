// Interleaved bytes as numbers: of a camera's frame, pixels B, G, R.
#include <cstring>

#include "rows.h"

namespace chiasm::kernels {
namespace {

constexpr int64_t kBlock = 8192;

// Of eight pixels the numbers at `channel` of each: a shuffle puts every third byte where an integer of 32 bits has its lowest.
inline __m256 numbers(__m256i pixels, int channel) {
  const auto at = [channel](int pixel) { return static_cast<int>(0xffffff00u) | (3 * pixel + channel); };
  const __m256i lanes = _mm256_setr_epi32(at(0), at(1), at(2), at(3), at(0), at(1), at(2), at(3));
  return _mm256_cvtepi32_ps(_mm256_shuffle_epi8(pixels, lanes));
}

// Along a row of bytes, which pixel and its right neighbour are summed: weights of the one, three times, and of the other, for each pixel.
struct Pairs {
  std::vector<int64_t> first;  // as bytes
  std::vector<float> weights;  // eight for each
  int64_t inside = 0;          // how many of them have eight bytes in a row
};

Pairs pairs_of(const Taps<float>& taps, int64_t width) {
  Pairs pairs{std::vector<int64_t>(taps.count), std::vector<float>(8 * taps.count), 0};
  for (int64_t i = 0; i < taps.count; ++i) {
    const int64_t first = std::min<int64_t>(taps.index[2 * i], width - 2);
    pairs.first[i] = 3 * first;
    if (3 * first + 8 <= 3 * width) pairs.inside = i + 1;
    for (int64_t k = 0; k < 2; ++k)  // at the ends of a row both taps are of one pixel
      for (int64_t channel = 0; channel < 3; ++channel) pairs.weights[8 * i + 3 * (taps.index[2 * i + k] - first) + channel] += taps.weight[2 * i + k];
  }
  return pairs;
}

// Two pixels as six numbers, and two more of what is beyond them in a row; or zeros, where that may be beyond the frame.
template <bool kEnd>
inline __m256 two_pixels(const uint8_t* p) {
  int64_t bytes = 0;
  std::memcpy(&bytes, p, kEnd ? 6 : 8);
  return _mm256_cvtepi32_ps(_mm256_cvtepu8_epi32(_mm_cvtsi64_si128(bytes)));
}

}  // namespace

void frame_to_grey(const uint8_t* frame, int64_t n, float* out) {
  const auto luma = [](auto b, auto g, auto r) { return r * 0.299f + g * 0.587f + b * 0.114f; };
#pragma omp parallel for
  for (int64_t begin = 0; begin < n; begin += kBlock) {
    const int64_t end = std::min(begin + kBlock, n);
    int64_t i = begin;
    // Both halves are loads of 16 bytes, of which 12 are theirs.
    for (; i + 8 <= end && 3 * i + 28 <= 3 * n; i += 8) {
      const auto* const low = reinterpret_cast<const __m128i*>(frame + 3 * i);
      const auto* const high = reinterpret_cast<const __m128i*>(frame + 3 * i + 12);
      const __m256i pixels = _mm256_set_m128i(_mm_loadu_si128(high), _mm_loadu_si128(low));
      _mm256_storeu_ps(out + i, luma(numbers(pixels, 0), numbers(pixels, 1), numbers(pixels, 2)));
    }
    for (; i < end; ++i) out[i] = luma(static_cast<float>(frame[3 * i]), static_cast<float>(frame[3 * i + 1]), static_cast<float>(frame[3 * i + 2]));
  }
}

void resize_frame(const uint8_t* frame, int64_t height, int64_t width, int64_t new_height, int64_t new_width, float* out) {
  const Taps<float> down = resize_taps<float>(height, new_height, Filter::kBilinear, false, false);
  const Pairs across = pairs_of(resize_taps<float>(width, new_width, Filter::kBilinear, false, false), width);
  const int64_t room = (new_width + 3) / 4 * 16;
  std::vector<float> all_rows(static_cast<size_t>(room * omp_get_max_threads()));
#pragma omp parallel for
  for (int64_t y = 0; y < new_height; ++y) {
    const uint8_t *const upper = frame + 3 * width * down.index[2 * y], *const lower = frame + 3 * width * down.index[2 * y + 1];
    const __m256 above = _mm256_set1_ps(down.weight[2 * y]), below = _mm256_set1_ps(down.weight[2 * y + 1]);
    const __m256i second = _mm256_setr_epi32(3, 4, 5, 6, 7, 7, 7, 7);
    float* const row = all_rows.data() + room * omp_get_thread_num();  // four numbers a pixel, of which three count
    const auto sum = [&](int64_t x, __m256 a, __m256 b) {
      const __m256 both = (a * above + b * below) * _mm256_loadu_ps(across.weights.data() + 8 * x);
      _mm_storeu_ps(row + 4 * x, _mm256_castps256_ps128(both + _mm256_permutevar8x32_ps(both, second)));
    };
    int64_t x = 0;
    for (; x < across.inside; ++x) sum(x, two_pixels<false>(upper + across.first[x]), two_pixels<false>(lower + across.first[x]));
    for (; x < new_width; ++x) sum(x, two_pixels<true>(upper + across.first[x]), two_pixels<true>(lower + across.first[x]));
    float *const blue = out + (2 * new_height + y) * new_width, *const green = out + (new_height + y) * new_width, *const red = out + y * new_width;
    x = 0;
    for (; x + 4 <= new_width; x += 4) {
      __m128 b = _mm_loadu_ps(row + 4 * x), g = _mm_loadu_ps(row + 4 * x + 4), r = _mm_loadu_ps(row + 4 * x + 8), rest = _mm_loadu_ps(row + 4 * x + 12);
      _MM_TRANSPOSE4_PS(b, g, r, rest);
      _mm_storeu_ps(blue + x, b);
      _mm_storeu_ps(green + x, g);
      _mm_storeu_ps(red + x, r);
    }
    for (; x < new_width; ++x) {
      blue[x] = row[4 * x];
      green[x] = row[4 * x + 1];
      red[x] = row[4 * x + 2];
    }
  }
}

}  // namespace chiasm::kernels
