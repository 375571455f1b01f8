// Mirror images, and transposed ones.
#include <cstring>

#include "declared/flips.h"
#include "rows.h"

namespace chiasm::kernels {
namespace {

// The pixels of `bytes` each, from the last to the first.
void reverse(const uint8_t* x, int64_t pixels, int64_t bytes, uint8_t* out) {
  // One shuffle reverses as many whole pixels as fit into 16 bytes. They are the last of the loaded bytes and
  // become the first of the stored ones; later stores overwrite the rest.
  const hn::FixedTag<uint8_t, 16> d;
  const int64_t each = 16 / bytes, length = each * bytes;
  int64_t k = 0;
  if (each > 0) {
    alignas(16) uint8_t order[16] = {};
    for (int64_t i = 0; i < length; ++i)
      order[i] = static_cast<uint8_t>(16 - length + (each - 1 - i / bytes) * bytes + i % bytes);
    const auto indices = hn::Load(d, order);
    const auto turn = [=](const uint8_t* from, uint8_t* to) {
      hn::StoreU(hn::TableLookupBytes(hn::LoadU(d, from), indices), d, to);
    };
    const uint8_t* from = x + pixels * bytes - 16;
    uint8_t* to = out;
    for (; from - 3 * length >= x; from -= 4 * length, to += 4 * length, k += 4 * each)
      for (int64_t i = 0; i < 4; ++i) turn(from - i * length, to + i * length);
    for (; from >= x; from -= length, to += length, k += each) turn(from, to);
  }
  for (; k < pixels; ++k)
    std::memcpy(out + k * bytes, x + (pixels - 1 - k) * bytes, static_cast<size_t>(bytes));
}

// Results of this many bytes leave the caches before they are read. Past the caches, writing does not read
// first: a third of the traffic. docs/decisions/02-kernels.md says why no other kernel does so.
constexpr int64_t kStreamed = 16 << 20;

// The same for pixels of one integer U, written past the caches.
template <class U>
void reverse_streaming(const uint8_t* x, int64_t pixels, uint8_t* out) {
  const Lanes<U> d;
  constexpr int64_t kSize = sizeof(U), kVector = kLanes<U> * kSize;
  const auto copy = [=](int64_t k) { std::memcpy(out + k * kSize, x + (pixels - 1 - k) * kSize, kSize); };
  const auto beyond = static_cast<int64_t>(reinterpret_cast<uintptr_t>(out) % kVector);
  const int64_t before = std::min(pixels, beyond == 0 ? 0 : (kVector - beyond) / kSize);
  int64_t k = 0;
  for (; k < before; ++k) copy(k);
  for (; k + kLanes<U> <= pixels; k += kLanes<U>) {
    const auto from = reinterpret_cast<const U*>(x + (pixels - k) * kSize) - kLanes<U>;
    hn::Stream(hn::Reverse(d, hn::LoadU(d, from)), d, reinterpret_cast<U*>(out + k * kSize));
  }
  for (; k < pixels; ++k) copy(k);
  hwy::FlushStream();
}

// Pixels of `bytes` each, a constant or not, of a square of the image.
template <class Bytes>
HWY_INLINE void transpose_square(const uint8_t* x, int64_t height, int64_t width, int64_t from_row,
                                 int64_t to_row, Bytes bytes, uint8_t* out) {
  for (int64_t column = 0; column < width; ++column)
    for (int64_t y = 0; y < height; ++y)
      std::memcpy(out + column * to_row + y * bytes, x + y * from_row + column * bytes,
                  static_cast<size_t>(bytes));
}

}  // namespace

template <class P>
void flip(const P* x, int64_t n, int64_t height, int64_t width, int64_t step, bool along, bool down, P* out) {
  const int64_t bytes = step * static_cast<int64_t>(sizeof(P)),
                length = width * static_cast<int64_t>(sizeof(P));
  const auto* const from = reinterpret_cast<const uint8_t*>(x);
  auto* const to = reinterpret_cast<uint8_t*>(out);
  const bool streams =
      n * height * length >= kStreamed && reinterpret_cast<uintptr_t>(out) % static_cast<size_t>(bytes) == 0;
  const auto turn = [=](const uint8_t* row, uint8_t* target) {
    if (streams && bytes == 4)
      reverse_streaming<uint32_t>(row, width / step, target);
    else if (streams && bytes == 8)
      reverse_streaming<uint64_t>(row, width / step, target);
    else
      reverse(row, width / step, bytes, target);
  };
#pragma omp parallel for
  for (int64_t i = 0; i < n * height; ++i) {
    const int64_t row = down ? i / height * height + height - 1 - i % height : i;
    if (along)
      turn(from + row * length, to + i * length);
    else
      std::memcpy(to + i * length, from + row * length, static_cast<size_t>(length));
  }
}

template <class P>
void transpose_pixels(const P* x, int64_t n, int64_t height, int64_t length, int64_t step, P* out) {
  constexpr int64_t kSide = 32;  // pixels of a square, whose rows stay in the L1 cache on both sides
  constexpr auto size = static_cast<int64_t>(sizeof(P));
  const int64_t width = length / step, bytes = step * size;
  const int64_t down = (height + kSide - 1) / kSide, along = (width + kSide - 1) / kSide;
#pragma omp parallel for
  for (int64_t task = 0; task < n * along; ++task) {
    const int64_t image = task / along, left = task % along * kSide, columns = std::min(kSide, width - left);
    const auto* const from = reinterpret_cast<const uint8_t*>(x + image * height * length + left * step);
    auto* const to = reinterpret_cast<uint8_t*>(out + (image * width + left) * height * step);
    for (int64_t block = 0; block < down; ++block) {
      const int64_t top = block * kSide, rows = std::min(kSide, height - top);
      const auto move = [=](auto pixel) {
        transpose_square(from + top * length * size, rows, columns, length * size, height * bytes, pixel,
                         to + top * bytes);
      };
      if (step == 1)
        move(std::integral_constant<int64_t, size>());
      else if (step == 3)
        move(std::integral_constant<int64_t, 3 * size>());
      else if (step == 4)
        move(std::integral_constant<int64_t, 4 * size>());
      else
        move(bytes);
    }
  }
}

CHIASM_INSTANTIATE(flip)
CHIASM_INSTANTIATE(transpose_pixels)

}  // namespace chiasm::kernels
