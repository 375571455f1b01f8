// Connected sets of pixels.
#include <bit>
#include <cstring>

#include "declared/connected_components.h"
#include "rows.h"

namespace chiasm::kernels {
namespace {

// The pixels first..end-1 of a row. Runs are numbered row by row.
struct Run {
  int32_t first, end;
};

// The root of a tree of runs, with path halving: every other run on the way is attached to its grandparent.
int32_t root(int32_t* parent, int32_t i) {
  while (parent[i] != i) i = parent[i] = parent[parent[i]];
  return i;
}

// Attaches the higher of two roots to the lower.
void join(int32_t* parent, int32_t a, int32_t b) {
  a = root(parent, a);
  b = root(parent, b);
  parent[std::max(a, b)] = std::min(a, b);
}

// Bit x % 64 of word x / 64 says whether pixel x of a row is above 0; bits after the last pixel are 0.
template <class P>
void mark(const P* row, int64_t width, uint64_t* words) {
  static_assert(kLanes<P> <= 64 && std::endian::native == std::endian::little);
  std::fill_n(words, width / 64 + 1, uint64_t{0});
  const auto put = [=](auto d, int64_t x) {
    uint64_t bits = 0;
    hn::StoreMaskBits(d, hn::Gt(hn::LoadU(d, row + x), hn::Zero(d)), reinterpret_cast<uint8_t*>(&bits));
    words[x / 64] |= bits << x % 64;
  };
  int64_t x = 0;
  for (; x + kLanes<P> <= width; x += kLanes<P>) put(Lanes<P>(), x);
  for (; x < width; ++x) put(Lane<P>(), x);
}

// Calls add(first, end) for the runs of a row.
template <class Add>
void for_runs(const uint64_t* words, int64_t width, const Add& add) {
  uint64_t before = 0;  // the last pixel of the previous word
  int32_t first = -1;
  for (int64_t w = 0; w <= width / 64; ++w) {
    uint64_t changes = words[w] ^ (words[w] << 1 | before);
    before = words[w] >> 63;
    for (; changes != 0; changes &= changes - 1) {
      const auto x = static_cast<int32_t>(w * 64 + std::countr_zero(changes));
      if (first < 0) {
        first = x;
      } else {
        add(first, x);
        first = -1;
      }
    }
  }
}

}  // namespace

// By runs and union-find in two passes: L. He, Y. Chao, K. Suzuki, A run-based two-scan labeling algorithm,
// IEEE TIP 17(5), 2008.
template <class P>
void connected_components(const P* x, Planes planes, bool consecutive, int64_t* out) {
  const int64_t height = planes.height, width = planes.width, size = height * width;
  const auto most = static_cast<size_t>(height * ((width + 1) / 2)),
             words = static_cast<size_t>(width / 64 + 1),
             threads = static_cast<size_t>(omp_get_max_threads());
  // The memory is allocated here, but its pages are not touched before they are used.
  const std::unique_ptr<Run[]> all_runs(new Run[most * threads]);
  const std::unique_ptr<int32_t[]> parents(new int32_t[most * threads]),
      all_ends(new int32_t[static_cast<size_t>(height) * threads]);
  const std::unique_ptr<uint64_t[]> marks(new uint64_t[words * threads]);
#pragma omp parallel
  {
    const auto thread = static_cast<size_t>(omp_get_thread_num());
    Run* const runs = all_runs.get() + most * thread;
    int32_t *const parent = parents.get() + most * thread,
                   *const ends = all_ends.get() + static_cast<size_t>(height) * thread;  // of each row's runs
    uint64_t* const set = marks.get() + words * thread;
#pragma omp for
    for (int64_t plane = 0; plane < planes.count; ++plane) {
      int32_t count = 0, above = 0;
      for (int64_t y = 0; y < height; ++y) {
        mark(x + plane * size + y * width, width, set);
        const int32_t row = count;
        for_runs(set, width, [&](int32_t first, int32_t end) {
          parent[count] = count;
          // runs of the previous row that end left of this run touch no later run either
          while (above < row && runs[above].end < first) ++above;
          for (int32_t i = above; i < row && runs[i].first <= end; ++i)
            if (parent[count] == count)
              parent[count] = root(parent, i);
            else
              join(parent, count, i);
          runs[count++] = {first, end};
        });
        above = row;
        ends[y] = count;
      }
      // A parent comes before its children, so it has already been replaced by its component's number.
      int32_t i = 0, numbers = 0;
      for (int64_t y = 0; y < height; ++y) {
        int64_t* const to = out + plane * size + y * width;
        int64_t done = 0;
        for (; i < ends[y]; ++i) {
          const int64_t first = runs[i].first, end = runs[i].end;
          if (parent[i] != i)
            parent[i] = parent[parent[i]];
          else
            parent[i] = consecutive ? numbers++ : static_cast<int32_t>(y * width + first);
          std::fill(to + done, to + first, 0);
          std::fill(to + first, to + end, int64_t{parent[i]} + 1);
          done = end;
        }
        std::fill(to + done, to + width, 0);
      }
    }
  }
}

template <class T>
void canny_hysteresis(const T* x, Planes planes, T low, T high, bool* out) {
  const Lanes<T> d;
  const int64_t height = planes.height, width = planes.width, size = height * width;
  // Every pixel is queued at most once. The memory is allocated here, but its pages are not touched before
  // they are used.
  const std::unique_ptr<int32_t[]> scratch(new int32_t[static_cast<size_t>(size * omp_get_max_threads())]);
  std::memset(out, 0, static_cast<size_t>(planes.count * size));
#pragma omp parallel
  {
    int32_t* const stack = scratch.get() + size * omp_get_thread_num();
#pragma omp for
    for (int64_t plane = 0; plane < planes.count; ++plane) {
      const T* const values = x + plane * size;
      bool* const found = out + plane * size;
      const auto follow = [&](int64_t start) {
        if (!(values[start] > high) || found[start]) return;
        found[start] = true;
        int64_t count = 0;
        stack[count++] = static_cast<int32_t>(start);
        while (count > 0) {
          const int64_t i = stack[--count], r = i / width, c = i - r * width;
          for (int64_t v = std::max<int64_t>(r - 1, 0); v <= std::min(r + 1, height - 1); ++v)
            for (int64_t u = std::max<int64_t>(c - 1, 0); u <= std::min(c + 1, width - 1); ++u) {
              const int64_t j = v * width + u;
              if (!(values[j] > low) || found[j]) continue;
              found[j] = true;
              stack[count++] = static_cast<int32_t>(j);
            }
        }
      };
      int64_t i = 0;
      for (; i + kLanes<T> <= size; i += kLanes<T>)
        if (any(d, hn::Gt(hn::LoadU(d, values + i), hn::Set(d, high))))
          for (int64_t k = 0; k < kLanes<T>; ++k) follow(i + k);
      for (; i < size; ++i) follow(i);
    }
  }
}

void label_statistics(const int64_t* labels, int64_t n, int64_t height, int64_t width, int64_t slots,
                      int64_t* out) {
  std::fill_n(out, n * slots * 7, 0);
#pragma omp parallel for
  for (int64_t plane = 0; plane < n; ++plane)
    for (int64_t y = 0; y < height; ++y) {
      const int64_t* const row = labels + (plane * height + y) * width;
      for (int64_t first = 0, end = 0; first < width; first = end) {  // runs of one label
        const int64_t label = row[first];
        for (end = first + 1; end < width && row[end] == label;) ++end;
        if (label < 0 || label >= slots) continue;
        const int64_t pixels = end - first;
        // left, top, width, height, pixels, sums of x and y
        int64_t* const s = out + (plane * slots + label) * 7;
        const int64_t left = s[4] == 0 ? first : std::min(s[0], first),
                      top = s[4] == 0 ? y : s[1],  // rows come from top to bottom
            right = std::max(s[0] + s[2], end);
        s[0] = left;
        s[1] = top;
        s[2] = right - left;
        s[3] = y + 1 - top;
        s[4] += pixels;
        s[5] += pixels * (first + end - 1) / 2;
        s[6] += pixels * y;
      }
    }
}

CHIASM_INSTANTIATE(connected_components)
CHIASM_INSTANTIATE(canny_hysteresis)

}  // namespace chiasm::kernels
