// Morphological reconstruction: two scans and a queue, after L. Vincent, Morphological grayscale
// reconstruction in image analysis: applications and efficient algorithms, IEEE TIP 2(2), 1993.
#include <limits>

#include "declared/reconstruction.h"
#include "rows.h"

namespace chiasm::kernels {
namespace {

// The offsets from a pixel to the pixels that it takes values from. The scan forwards uses those in earlier
// rows (`above`) and earlier in its own row (`beside`), the scan backwards those in later rows (`below`) and
// later in its own row (`behind`).
struct Offsets {
  std::vector<int64_t> all, above, beside, below, behind;

  Offsets(const bool* element, int64_t kh, int64_t kw, int64_t stride) {
    for (int64_t i = 0; i < kh * kw; ++i) {
      const int64_t dy = i / kw - kh / 2, dx = i % kw - kw / 2, offset = dy * stride + dx;
      // the caller's bytes: every value except 0 is true
      if (reinterpret_cast<const uint8_t*>(element)[i] == 0 || offset == 0) continue;
      all.push_back(offset);
      (dy < 0 ? above : dy > 0 ? below : dx < 0 ? beside : behind).push_back(offset);
    }
  }
};

// A plane inside a margin, whose value is passed on and never changes.
template <class T>
struct Spreading {
  const Offsets& offsets;
  int64_t height, width, stride, first;  // the offset of the first pixel
  T *values, *limits;
  uint8_t* waiting;
  int32_t* queue;
  int64_t room, head, count;

  void push(int64_t i) {
    if (waiting[i]) return;
    waiting[i] = 1;
    queue[(head + count++) % room] = static_cast<int32_t>(i);
  }

  // Raises a row to the values that it takes from other rows, and then to those from itself.
  void scan(int64_t row, const std::vector<int64_t>& others, const std::vector<int64_t>& own, bool back) {
    T* const to = values + row;
    const T* const most = limits + row;
    for (const int64_t offset : others)
      for_lanes<T>(width, [=](auto d, auto, int64_t k) {
        const auto raised = larger(hn::LoadU(d, to + k + offset), hn::LoadU(d, to + k));
        hn::StoreU(smaller(raised, hn::LoadU(d, most + k)), d, to + k);
      });
    for (int64_t k = 0; k < width; ++k) {
      const int64_t i = back ? width - 1 - k : k;
      for (const int64_t offset : own) to[i] = std::max(to[i], std::min(to[i + offset], most[i]));
    }
  }

  // Queues the pixels of a row that can raise a later pixel; earlier pixels are still to be scanned.
  void queue_row(int64_t row) {
    const auto passes = [this](auto d, int64_t i) {
      auto found = hn::Lt(hn::Zero(d), hn::Zero(d));  // none
      for (const auto* part : {&offsets.above, &offsets.beside})
        for (const int64_t offset : *part) {
          const auto there = hn::LoadU(d, values + i - offset);
          found = hn::Or(found, hn::And(hn::Lt(there, hn::LoadU(d, values + i)),
                                        hn::Lt(there, hn::LoadU(d, limits + i - offset))));
        }
      return any(d, found);
    };
    int64_t k = 0;
    for (; k + kLanes<T> <= width; k += kLanes<T>)
      if (passes(Lanes<T>(), row + k))
        for (int64_t i = row + k; i < row + k + kLanes<T>; ++i)
          if (passes(Lane<T>(), i)) push(i);
    for (; k < width; ++k)
      if (passes(Lane<T>(), row + k)) push(row + k);
  }

  void spread() {
    for (int64_t y = 0; y < height; ++y) scan(first + y * stride, offsets.above, offsets.beside, false);
    for (int64_t y = height - 1; y >= 0; --y) {
      scan(first + y * stride, offsets.below, offsets.behind, true);
      queue_row(first + y * stride);
    }
    while (count > 0) {
      const int64_t i = queue[head];
      head = head + 1 == room ? 0 : head + 1;
      --count;
      waiting[i] = 0;
      const T value = values[i];
      for (const int64_t offset : offsets.all) {
        const int64_t j = i - offset;
        if (!(values[j] < value && values[j] < limits[j])) continue;
        values[j] = std::min(value, limits[j]);
        push(j);
      }
    }
  }
};

}  // namespace

template <class T>
void reconstructed(const T* seed, int64_t planes, int64_t height, int64_t width, const T* mask,
                   const bool* element, int64_t kh, int64_t kw, T border, bool largest, T* out) {
  constexpr T kLowest = -std::numeric_limits<T>::infinity();
  const int64_t stride = width + kw, padded = (height + kh) * stride, size = height * width;
  const Offsets offsets(element, kh, kw, stride);
  const auto threads = static_cast<size_t>(omp_get_max_threads()), room = static_cast<size_t>(padded);
  const std::unique_ptr<T[]> numbers(new T[2 * room * threads]);
  const std::unique_ptr<uint8_t[]> flags(new uint8_t[room * threads]);
  const std::unique_ptr<int32_t[]> queues(new int32_t[static_cast<size_t>(size) * threads]);
  const T sign = largest ? T(1) : T(-1);  // an erosion is a dilation of the negated image
#pragma omp parallel for
  for (int64_t plane = 0; plane < planes; ++plane) {
    const int64_t thread = omp_get_thread_num(), first = kh / 2 * stride + kw / 2;
    T *const values = numbers.get() + 2 * padded * thread, *const limits = values + padded;
    uint8_t* const waiting = flags.get() + padded * thread;
    std::fill_n(values, padded, sign * border);
    std::fill_n(limits, padded, kLowest);
    std::fill_n(waiting, padded, uint8_t{0});
    for (int64_t y = 0; y < height; ++y)
      for (int64_t x = 0; x < width; ++x) {
        const int64_t i = first + y * stride + x, from = (plane * height + y) * width + x;
        limits[i] = sign * mask[from];
        values[i] = std::min(sign * seed[from], limits[i]);
      }
    Spreading<T> spreading{
        offsets, height, width, stride, first, values, limits, waiting, queues.get() + size * thread,
        size,    0,      0};
    spreading.spread();
    for (int64_t y = 0; y < height; ++y)
      for (int64_t x = 0; x < width; ++x)
        out[(plane * height + y) * width + x] = sign * values[first + y * stride + x];
  }
}

CHIASM_INSTANTIATE(reconstructed)

}  // namespace chiasm::kernels
