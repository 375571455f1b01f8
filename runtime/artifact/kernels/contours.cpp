// The borders of sets of pixels as polygons.
#include <algorithm>

#include "declared/contours.h"
#include "rows.h"

namespace chiasm::kernels {
namespace {

// The step from one side of a border pixel to the next: another side of the same pixel, a side of the pixel
// ahead, or of the pixel diagonally ahead.
enum class Step { Turn, Straight, Diagonal };

// The sides of a pixel, in the order in which a border goes around an isolated pixel: top, left, bottom,
// right. Each side faces the direction in which the border leaves the previous side.
constexpr int64_t kDown[4] = {-1, 0, 1, 0}, kRight[4] = {0, -1, 0, 1};

struct Side {
  int64_t y, x;
  int side;

  bool operator==(const Side& other) const { return y == other.y && x == other.x && side == other.side; }
};

// A border: its first side in the order of rows, the two steps before it, and the area inside, which is
// negative for a hole.
struct Outline {
  Side first;
  Step before, second_before;
  int64_t area;

  int64_t size() const { return area < 0 ? -area : area; }
};

class Mask {
 public:
  Mask(const uint8_t* mask, int64_t height, int64_t width, uint8_t* seen)
      : mask_(mask), height_(height), width_(width), seen_(seen) {}

  // Calls add(border) for each, in the order of their first sides. Every border has a side at the top of a
  // pixel.
  template <class Add>
  void for_borders(const Add& add) const {
    std::fill_n(seen_, height_ * width_, uint8_t{0});
    for (int64_t y = 0; y < height_; ++y)
      for (int64_t x = 0; x < width_; ++x)
        if (const int64_t i = y * width_ + x;
            mask_[i] != 0 && (y == 0 || mask_[i - width_] == 0) && seen_[i] == 0)
          add(border({y, x, 0}));
  }

  // Calls add(pixel) for the corners of a border.
  template <class Add>
  void for_corners(const Outline& border, const Add& add) const {
    Step before = border.before, second_before = border.second_before;
    Side side = border.first;
    bool is_alone = true;
    do {
      const int64_t pixel = side.y * width_ + side.x;
      const Step step = go(side);
      const bool goes_on =
          (step == Step::Straight && before == Step::Straight) ||
          (step == Step::Diagonal && before == Step::Turn && second_before == Step::Diagonal);
      is_alone = is_alone && step == Step::Turn;
      if (step != Step::Turn && !goes_on) add(pixel);
      second_before = before;
      before = step;
    } while (!(side == border.first));
    if (is_alone) add(side.y * width_ + side.x);
  }

 private:
  bool has(int64_t y, int64_t x) const {
    return y >= 0 && y < height_ && x >= 0 && x < width_ && mask_[y * width_ + x] != 0;
  }

  Step go(Side& side) const {
    const int on = (side.side + 1) % 4;
    const int64_t y = side.y + kDown[on], x = side.x + kRight[on];
    if (has(y + kDown[side.side], x + kRight[side.side])) {
      side = {y + kDown[side.side], x + kRight[side.side], (side.side + 3) % 4};
      return Step::Diagonal;
    }
    if (has(y, x)) {
      side = {y, x, side.side};
      return Step::Straight;
    }
    side.side = on;
    return Step::Turn;
  }

  // Only sides at the top are marked as seen: no others are looked up.
  Outline border(const Side& first) const {
    Outline made{first, Step::Turn, Step::Turn, 0};
    Side side = first;
    do {
      if (side.side == 0) seen_[side.y * width_ + side.x] = 1;
      // Green's theorem: the area is the sum of x along the vertical sides
      if (side.side == 3) made.area += side.x + 1;
      if (side.side == 1) made.area -= side.x;
      made.second_before = made.before;
      made.before = go(side);
    } while (!(side == first));
    return made;
  }

  const uint8_t* mask_;
  int64_t height_, width_;
  uint8_t* seen_;
};

}  // namespace

void find_contours(const uint8_t* mask, Planes planes, int64_t polygons, int64_t numbers, int64_t* out) {
  const int64_t size = planes.height * planes.width, most = numbers - 2, slots = std::min(polygons, size),
                threads = omp_get_max_threads();
  // The memory is allocated here, but its pages are not touched before they are used.
  const std::unique_ptr<uint8_t[]> all_seen(new uint8_t[static_cast<size_t>(size * threads)]);
  const std::unique_ptr<Outline[]> all_borders(new Outline[static_cast<size_t>((slots + 1) * threads)]);
#pragma omp parallel
  {
    const int64_t thread = omp_get_thread_num();
    Outline* const borders = all_borders.get() + (slots + 1) * thread;
#pragma omp for
    for (int64_t plane = 0; plane < planes.count; ++plane) {
      const Mask set(mask + plane * size, planes.height, planes.width, all_seen.get() + size * thread);
      int64_t count = 0;
      set.for_borders([&](const Outline& border) {
        // The largest first; ties in the order in which they were found
        Outline* const place =
            std::upper_bound(borders, borders + count, border,
                             [](const Outline& a, const Outline& b) { return a.size() > b.size(); });
        if (place == borders + slots) return;
        std::move_backward(place, borders + count, borders + count + 1);
        *place = border;
        count = std::min(count + 1, slots);
      });
      for (int64_t i = 0; i < polygons; ++i) {
        int64_t* const to = out + (plane * polygons + i) * numbers;
        std::fill_n(to, 2, int64_t{0});
        std::fill_n(to + 2, most, int64_t{-1});
        if (i >= count) continue;
        int64_t corners = 0;
        set.for_corners(borders[i], [&](int64_t) { ++corners; });
        to[0] = std::min(corners, most);
        to[1] = borders[i].area < 0;
        // A border with more than `most` corners is thinned: point k is its corner k * span / most.
        const int64_t span = std::max(corners, most);
        int64_t corner = 0;
        set.for_corners(borders[i], [&](int64_t pixel) {
          const int64_t k = (corner * most + span - 1) / span;
          if (k * span / most == corner) to[2 + k] = pixel;
          ++corner;
        });
      }
    }
  }
}

}  // namespace chiasm::kernels
