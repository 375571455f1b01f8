// Distances of pixels to the nearest ones of a shape.
#include <cmath>
#include <limits>

#include "declared/distances.h"
#include "rows.h"

namespace chiasm::kernels {
namespace {

template <class T>
constexpr T kInfinity = std::numeric_limits<T>::infinity();

// The distance of each pixel to the nearest pixel of its column that is not set, for some columns of a plane.
template <class T>
void along_columns(const T* x, int64_t height, int64_t width, int64_t columns, T* out) {
  for (int64_t y = 0; y < height; ++y) {
    const T* const from = x + y * width;
    T* const to = out + y * width;
    const T* const above = y > 0 ? to - width : nullptr;
    for_lanes<T>(columns, [=](auto d, auto, int64_t k) {
      const auto one = hn::Set(d, T(1));
      const auto next = above ? hn::Add(hn::LoadU(d, above + k), one) : hn::Set(d, kInfinity<T>);
      hn::StoreU(hn::IfThenElseZero(hn::Gt(hn::LoadU(d, from + k), hn::Zero(d)), next), d, to + k);
    });
  }
  for (int64_t y = height - 2; y >= 0; --y) {
    T* const to = out + y * width;
    const T* const below = to + width;
    for_lanes<T>(columns, [=](auto d, auto, int64_t k) {
      const auto next = hn::Add(hn::LoadU(d, below + k), hn::Set(d, T(1)));
      hn::StoreU(smaller(hn::LoadU(d, to + k), next), d, to + k);
    });
  }
}

// The pixels to either side that are searched by whole vectors, before a row uses the method whose time does
// not depend on distances.
constexpr int64_t kNear = 24;

// The smallest squares[k + j] + j^2 for each pixel k of a row, which is continued by infinities. Returns
// whether all minima are within kNear.
template <class T>
bool nearby(const T* squares, int64_t width, T* least) {
  const auto search = [=](auto d, int64_t k) {
    auto best = hn::LoadU(d, squares + k);
    for (int64_t j = 1; j <= kNear; ++j) {
      const auto square = hn::Set(d, static_cast<T>(j * j));
      if (hn::AllTrue(d, hn::Le(best, square))) break;
      const auto beside = smaller(hn::LoadU(d, squares + k - j), hn::LoadU(d, squares + k + j));
      best = smaller(best, hn::Add(beside, square));
    }
    hn::StoreU(best, d, least + k);
    return hn::AllTrue(d, hn::Le(best, hn::Set(d, static_cast<T>((kNear + 1) * (kNear + 1)))));
  };
  int64_t k = 0;
  for (; k + kLanes<T> <= width; k += kLanes<T>)
    if (!search(Lanes<T>(), k)) return false;
  for (; k < width; ++k)
    if (!search(Lane<T>(), k)) return false;
  return true;
}

// A parabola (x - at)^2 + height, the lowest one from column `first` to the next parabola's `first`.
struct Parabola {
  int64_t at, height, first;
  int64_t operator()(int64_t x) const { return (x - at) * (x - at) + height; }
};

// The same for any distance, by the lower envelope of parabolas, in integers: A. Meijster, J. Roerdink, W.
// Hesselink, A general algorithm for computing distance transforms in linear time, Mathematical Morphology
// and its Applications to Image and Signal Processing, 2000.
template <class T>
void by_envelope(const T* distances, int64_t width, Parabola* envelope, T* least) {
  int64_t count = 0;
  for (int64_t x = 0; x < width; ++x) {
    if (distances[x] == kInfinity<T>) continue;
    const auto distance = static_cast<int64_t>(distances[x]);
    Parabola added{x, distance * distance, 0};
    while (count > 0 && envelope[count - 1](envelope[count - 1].first) > added(envelope[count - 1].first))
      --count;
    if (count > 0) {
      const Parabola& last = envelope[count - 1];
      added.first = (added(0) - last(0)) / (2 * (x - last.at)) + 1;
      if (added.first >= width) continue;
    }
    envelope[count++] = added;
  }
  if (count == 0) std::fill_n(least, width, kInfinity<T>);
  for (int64_t i = 0; i < count; ++i) {
    const auto at = static_cast<T>(envelope[i].at), height = static_cast<T>(envelope[i].height);
    const auto end = static_cast<int32_t>(i + 1 < count ? envelope[i + 1].first : width);
    for (auto x = static_cast<int32_t>(envelope[i].first); x < end; ++x)
      least[x] = (static_cast<T>(x) - at) * (static_cast<T>(x) - at) + height;
  }
}

// A plane whose edge is replicated by `radius` pixels.
template <class T>
class Replicated {
 public:
  Replicated(T* pixels, int64_t height, int64_t width, int64_t radius)
      : pixels_(pixels), height_(height), width_(width), radius_(radius), stride_(width + 2 * radius) {}

  int64_t stride() const { return stride_; }
  // The pixel, from which its whole window can be reached.
  T* at(int64_t y, int64_t x) const { return pixels_ + (y + radius_) * stride_ + x + radius_; }

  void fill(const T* plane) const {
    for (int64_t y = -radius_; y < height_ + radius_; ++y) {
      const T* const from = plane + std::clamp<int64_t>(y, 0, height_ - 1) * width_;
      T* const to = at(y, 0);
      std::fill_n(to - radius_, radius_, from[0]);
      std::copy_n(from, width_, to);
      std::fill_n(to + width_, radius_, from[width_ - 1]);
    }
  }

  void set(int64_t y, int64_t x, T value) const {
    const int64_t top = y == 0 ? -radius_ : y, bottom = y == height_ - 1 ? y + radius_ : y,
                  left = x == 0 ? -radius_ : x, right = x == width_ - 1 ? x + radius_ : x;
    for (int64_t v = top; v <= bottom; ++v) std::fill_n(at(v, left), right - left + 1, value);
  }

 private:
  T* const pixels_;
  const int64_t height_, width_, radius_, stride_;
};

}  // namespace

template <class T>
void distance_transform_edt(const T* x, Planes planes, T* out) {
  constexpr int64_t kStrip = 128;
  const int64_t height = planes.height, width = planes.width, size = height * width,
                strips = (width + kStrip - 1) / kStrip, length = padded_length<T>(width, 2 * kNear);
  const auto threads = omp_get_max_threads();
  const auto rows = new_lines<T>(2 * length * threads);
  const std::unique_ptr<Parabola[]> envelopes(new Parabola[static_cast<size_t>(width * threads)]);
#pragma omp parallel
  {
    T *const squares = rows.get() + 2 * length * omp_get_thread_num() + kNear, *const least =
                                                                                   squares + length;
    Parabola* const envelope = envelopes.get() + width * omp_get_thread_num();
    std::fill_n(squares - kNear, length, kInfinity<T>);
#pragma omp for
    for (int64_t i = 0; i < planes.count * strips; ++i) {
      const int64_t left = i % strips * kStrip, start = i / strips * size + left;
      along_columns(x + start, height, width, std::min(kStrip, width - left), out + start);
    }
#pragma omp for
    for (int64_t i = 0; i < planes.count * height; ++i) {
      T* const row = out + i * width;
      for_lanes<T>(width, [=](auto d, auto, int64_t k) {
        const auto distance = hn::LoadU(d, row + k);
        hn::StoreU(hn::Mul(distance, distance), d, squares + k);
      });
      if (!nearby(squares, width, least)) by_envelope(row, width, envelope, least);
      for_lanes<T>(
          width, [=](auto d, auto, int64_t k) { hn::StoreU(hn::Sqrt(hn::LoadU(d, least + k)), d, row + k); });
    }
  }
}

template <class T>
void grown_distances(const T* shape, int64_t planes, int64_t height, int64_t width, const T* taps,
                     int64_t taps_size, T scale, int64_t limit, T* out) {
  const int64_t size = height * width, radius = taps_size / 2;
  const int64_t padded_size = (height + 2 * radius) * (width + 2 * radius);
  const auto threads = static_cast<size_t>(omp_get_max_threads());
  const std::unique_ptr<T[]> pixels(new T[static_cast<size_t>(padded_size) * threads]);
  // For each thread: the last step in which each pixel was visited, and the pixels found in the last two
  // steps.
  const std::unique_ptr<int32_t[]> scratch(new int32_t[static_cast<size_t>(3 * size) * threads]);
#pragma omp parallel for
  for (int64_t plane = 0; plane < planes; ++plane) {
    const auto thread = omp_get_thread_num();
    const Replicated<T> grown(pixels.get() + padded_size * thread, height, width, radius);
    int32_t *const seen = scratch.get() + 3 * size * thread, *front = seen + size, *found = front + size;
    T* const distances = out + plane * size;
    const T* const given = shape + plane * size;
    // If no value is outside of 0 to 1, a pixel that belongs to the shape never needs a second visit.
    const bool ordinary = std::all_of(given, given + size, [](T v) { return v >= 0 && v <= 1; });
    std::fill_n(seen, size, -1);
    std::fill_n(distances, size, T(0));
    grown.fill(given);

    int64_t count = 0;
    // Visits a pixel in step k.
    const auto look = [&](int64_t y, int64_t x, int64_t k) {
      const int64_t i = y * width + x;
      const T* const middle = grown.at(y, x);
      if ((ordinary && *middle == 1) || seen[i] == k) return;
      seen[i] = static_cast<int32_t>(k);
      T near = 0;
      for (int64_t v = 0; v < taps_size; ++v)
        for (int64_t u = 0; u < taps_size; ++u)
          near += middle[(v - radius) * grown.stride() + u - radius] * taps[v * taps_size + u];
      if (!(near > 0 && near < 1)) return;
      const T beyond = -scale * std::log(near);
      if (!(beyond > 0)) return;
      distances[i] = distances[i] + static_cast<T>(k * radius) + beyond;
      found[count++] = static_cast<int32_t>(i);
    };
    for (int64_t k = 0; k < limit; ++k) {
      const int64_t reached = count;
      count = 0;
      for (int64_t i = 0; k == 0 && i < size; ++i) look(i / width, i % width, k);
      for (int64_t i = 0; i < reached; ++i) {  // the neighbours of the pixels found in the previous step
        const int64_t y = front[i] / width, x = front[i] % width;
        for (int64_t v = std::max<int64_t>(y - radius, 0); v <= std::min(y + radius, height - 1); ++v)
          for (int64_t u = std::max<int64_t>(x - radius, 0); u <= std::min(x + radius, width - 1); ++u)
            look(v, u, k);
      }
      if (count == 0) break;
      for (int64_t i = 0; i < count; ++i) grown.set(found[i] / width, found[i] % width, T(1));
      std::swap(front, found);
    }
  }
}

CHIASM_INSTANTIATE(distance_transform_edt)
CHIASM_INSTANTIATE(grown_distances)

}  // namespace chiasm::kernels
