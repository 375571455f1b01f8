// The kernels of binary shapes and of reconstruction, against OpenCV and against their definitions in plain
// loops over whole images.
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <opencv2/imgproc.hpp>
#include <random>
#include <set>
#include <vector>

#include "benchmarks.h"
#include "fixture.h"
#include "kernels.h"

using namespace chiasm::kernels;

namespace {

// A pixel, a row, a column, less than a vector, and odd sizes.
const Planes kSizes[] = {{1, 1, 1}, {2, 1, 9}, {2, 9, 1}, {2, 3, 5}, {1, 2, 64}, {3, 71, 133}};

int64_t pixels(const Planes& p) { return p.count * p.height * p.width; }

template <class T>
class Shapes : public KernelsTest<T> {
 protected:
  Shapes() : KernelsTest<T>(37) {}

  // Images whose pixels above 0 form discs.
  std::vector<T> discs(const Planes& p, int count, double radius) {
    std::vector<T> x(size_t(pixels(p)), T(-1));
    for (int64_t plane = 0; plane < p.count; ++plane) {
      const auto draw = this->random(3 * count);
      for (int k = 0; k < count; ++k) {
        const double cy = draw[size_t(3 * k)] * double(p.height),
                     cx = draw[size_t(3 * k + 1)] * double(p.width), r = radius * draw[size_t(3 * k + 2)];
        for (int64_t y = 0; y < p.height; ++y)
          for (int64_t c = 0; c < p.width; ++c)
            if (std::hypot(double(y) - cy, double(c) - cx) <= r)
              x[size_t((plane * p.height + y) * p.width + c)] = T(0.5);
      }
    }
    return x;
  }

  // Few, many and most pixels at random; discs; all and none.
  std::vector<std::vector<T>> masks(const Planes& p) {
    std::vector<std::vector<T>> made{
        this->random(pixels(p), -0.2, 0.8),      this->random(pixels(p), -0.5, 0.5),
        this->random(pixels(p), -0.8, 0.2),      discs(p, 6, 40),
        std::vector<T>(size_t(pixels(p)), T(1)), std::vector<T>(size_t(pixels(p)), T(0))};
    made.push_back(made[4]);
    made.back()[size_t(pixels(p) / 2)] = 0;  // one pixel is not set
    return made;
  }
};

using Types = ::testing::Types<float, double>;
TYPED_TEST_SUITE(Shapes, Types);

TYPED_TEST(Shapes, EuclideanDistancesAreTheLeastOfAllPixels) {
  using T = TypeParam;
  for (const Planes& p : kSizes)
    for (const auto& x : this->masks(p)) {
      std::vector<T> out(x.size());
      distance_transform_edt(x.data(), p, out.data());
      for (int64_t i = 0; i<pixels(p); i += pixels(p)> 1000 ? 37 : 1) {
        const int64_t plane = i / (p.height * p.width), y = i / p.width % p.height, c = i % p.width;
        double least = std::numeric_limits<double>::infinity();
        for (int64_t v = 0; v < p.height; ++v)
          for (int64_t u = 0; u < p.width; ++u)
            if (!(x[size_t((plane * p.height + v) * p.width + u)] > 0))
              least = std::min(least, double((v - y) * (v - y) + (u - c) * (u - c)));
        ASSERT_EQ(out[size_t(i)], static_cast<T>(std::sqrt(static_cast<T>(least))))
            << p.height << "x" << p.width << ", " << y << ", " << c;
      }
    }
}

TYPED_TEST(Shapes, EuclideanDistancesMatchOpenCv) {
  using T = TypeParam;
  const Planes p{1, 300, 417};
  for (const auto& x : {this->discs(p, 12, 90), this->random(pixels(p), -0.01, 0.99)}) {
    std::vector<T> out(x.size());
    distance_transform_edt(x.data(), p, out.data());
    cv::Mat expected;
    const cv::Mat set = cv::Mat(300, 417, cv::DataType<T>::type, const_cast<T*>(x.data())) > 0;
    cv::distanceTransform(set, expected, cv::DIST_L2, cv::DIST_MASK_PRECISE);
    for (int64_t i = 0; i < pixels(p); ++i)
      ASSERT_NEAR(out[size_t(i)], expected.at<float>(int(i / 417), int(i % 417)), 1e-4);
  }
}

// Discs of all sizes on a frame.
std::vector<float> many_discs() {
  std::vector<float> x(3 * 1080 * 1920);
  for (int64_t i = 0; i < int64_t(x.size()); ++i) {
    const int64_t y = i / 1920 % 1080, c = i % 1920, across = c % 240 - 120, down = y % 216 - 108;
    x[size_t(i)] = across * across + down * down < 100 * 100 - 40 * (c / 240) * (y / 216) ? 1.0f : 0.0f;
  }
  return x;
}

KERNEL_CALL_BENCHMARK(distance_transform_edt, [] {
  return [x = many_discs(), out = std::vector<float>(3 * 1080 * 1920)]() mutable {
    distance_transform_edt(x.data(), {3, 1080, 1920}, out.data());
  };
});

KERNEL_CALL_BENCHMARK(distance_transform_edt_far, [] {
  std::vector<float> x(3 * 1080 * 1920, 1.0f);
  x[1920 * 500 + 900] = x[1920 * 1600 + 90] = x[1920 * 2200 + 900] = 0;
  return [x, out = std::vector<float>(3 * 1080 * 1920)]() mutable {
    distance_transform_edt(x.data(), {3, 1080, 1920}, out.data());
  };
});

TYPED_TEST(Shapes, GrownDistancesMatchStepsOverTheWholeImage) {
  using T = TypeParam;
  const T scale = T(0.35);
  for (const Planes& p : kSizes)
    for (const int64_t k : {3, 5})
      for (const int64_t limit : {int64_t{0}, int64_t{2}, p.height + p.width})
        for (int kind = 0; kind < 3; ++kind) {
          const int64_t radius = k / 2;
          auto shape = this->random(pixels(p), -0.5, 1);
          for (T& v : shape) v = kind == 0 ? T(v > T(0.95)) : kind == 1 ? (v > T(0.8) ? v : T(0)) : v;
          std::vector<T> taps;
          for (int64_t i = 0; i < k * k; ++i)
            taps.push_back(T(std::exp(-std::hypot(double(i / k - radius), double(i % k - radius)) / scale)));
          std::vector<T> out(shape.size()), expected(shape.size()), now = shape;
          grown_distances(shape.data(), p.count, p.height, p.width, taps.data(), k, scale, limit, out.data());
          for (int64_t step = 0; step < limit; ++step) {
            auto after = now;
            for (int64_t i = 0; i < pixels(p); ++i) {
              const int64_t y = i / p.width % p.height, x = i % p.width, plane = i / p.width / p.height;
              T near = 0;
              for (int64_t j = 0; j < k * k; ++j) {
                const int64_t v = std::clamp<int64_t>(y + j / k - radius, 0, p.height - 1),
                              u = std::clamp<int64_t>(x + j % k - radius, 0, p.width - 1);
                near += now[size_t((plane * p.height + v) * p.width + u)] * taps[size_t(j)];
              }
              const T beyond = near > 0 && near < 1 ? -scale * std::log(near) : T(0);
              if (!(beyond > 0)) continue;
              expected[size_t(i)] = expected[size_t(i)] + T(step * radius) + beyond;
              after[size_t(i)] = 1;
            }
            now = after;
          }
          ASSERT_EQ(out, expected) << p.height << "x" << p.width << ", " << k << " taps, kind " << kind;
        }
}

KERNEL_CALL_BENCHMARK(grown_distances, [] {
  std::vector<float> taps;
  for (int i = 0; i < 9; ++i)
    taps.push_back(std::exp(-std::hypot(float(i / 3 - 1), float(i % 3 - 1)) / 0.35f));
  return [x = many_discs(), taps, out = std::vector<float>(3 * 1080 * 1920)]() mutable {
    grown_distances(x.data(), 3, 1080, 1920, taps.data(), 3, 0.35f, 3000, out.data());
  };
});

// Whether the papers' rules remove a pixel, from its neighbours in the order around it.
bool goes(const std::array<int, 8>& ring, bool zhang, bool first) {
  if (zhang) {  // clockwise from the north
    int count = 0, rises = 0;
    for (size_t n = 0; n < 8; ++n) {
      count += ring[n];
      rises += ring[n] == 0 && ring[(n + 1) % 8] == 1;
    }
    const int a = first ? ring[0] * ring[2] * ring[4] : ring[0] * ring[2] * ring[6],
              b = first ? ring[2] * ring[4] * ring[6] : ring[0] * ring[4] * ring[6];
    return count >= 2 && count <= 6 && rises == 1 && a == 0 && b == 0;
  }
  // p1..p8 are the neighbours, clockwise from the north-west; c, n1, n2 and m are the paper's C, N1, N2 and
  // the condition of a half step.
  const int p1 = ring[7], p2 = ring[0], p3 = ring[1], p4 = ring[2], p5 = ring[3], p6 = ring[4], p7 = ring[5],
            p8 = ring[6];
  const int c = (1 - p2) * (p3 | p4) + (1 - p4) * (p5 | p6) + (1 - p6) * (p7 | p8) + (1 - p8) * (p1 | p2);
  const int n1 = (p1 | p2) + (p3 | p4) + (p5 | p6) + (p7 | p8),
            n2 = (p2 | p3) + (p4 | p5) + (p6 | p7) + (p8 | p1);
  const int m = first ? (p2 | p3 | (1 - p5)) & p4 : (p6 | p7 | (1 - p1)) & p8;
  return c == 1 && std::min(n1, n2) >= 2 && std::min(n1, n2) <= 3 && m == 0;
}

TYPED_TEST(Shapes, ThinnedMatchesRoundsOverTheWholeImage) {
  using T = TypeParam;
  constexpr int kDown[] = {-1, -1, 0, 1, 1, 1, 0, -1}, kRight[] = {0, 1, 1, 1, 0, -1, -1, -1};
  for (const Planes& p : kSizes)
    for (const auto& x : this->masks(p))
      for (const bool zhang : {true, false})
        for (const int64_t limit : {0, 2, 1000}) {
          std::vector<T> out(x.size()), now(x.size());
          thin(x.data(), p, limit, zhang, out.data());
          for (size_t i = 0; i < x.size(); ++i) now[i] = T(x[i] > 0);
          bool moved = true;
          for (int64_t k = 0; k < limit && moved; ++k) {
            moved = false;
            for (const bool first : {true, false}) {
              auto after = now;
              for (int64_t i = 0; i < pixels(p); ++i) {
                const int64_t y = i / p.width % p.height, c = i % p.width, plane = i / p.width / p.height;
                std::array<int, 8> ring{};
                for (size_t n = 0; n < 8; ++n) {
                  const int64_t v = y + kDown[n], u = c + kRight[n];
                  ring[n] = v >= 0 && u >= 0 && v < p.height && u < p.width &&
                            now[size_t((plane * p.height + v) * p.width + u)] > 0;
                }
                if (now[size_t(i)] > 0 && goes(ring, zhang, first)) {
                  after[size_t(i)] = 0;
                  moved = true;
                }
              }
              now = after;
            }
          }
          ASSERT_EQ(out, now) << p.height << "x" << p.width << ", limit " << limit << ", zhang " << zhang;
        }
}

KERNEL_CALL_BENCHMARK(thin, [] {
  return [x = many_discs(), out = std::vector<float>(3 * 1080 * 1920)]() mutable {
    thin(x.data(), {3, 1080, 1920}, 10000, true, out.data());
  };
});

TYPED_TEST(Shapes, ReconstructedMatchesDilationsByOpenCv) {
  using T = TypeParam;
  for (const Planes& p : kSizes)
    for (const auto& [kh, kw] : {std::array<int, 2>{3, 3}, {1, 3}, {5, 2}, {4, 3}})
      for (const bool largest : {true, false})
        for (const double border : {0.0, 0.3, largest ? -1e4 : 1e4}) {
          const auto mask = this->random(pixels(p)), seed = this->random(pixels(p), -0.2, 1.2);
          const std::unique_ptr<bool[]> element(new bool[size_t(kh * kw)]);
          cv::Mat window(kh, kw, CV_8U);
          for (int i = 0; i < kh * kw; ++i) {
            element[size_t(i)] = i == kh / 2 * kw + kw / 2 || i % 4 != 1;
            window.at<uchar>(i / kw, i % kw) = element[size_t(i)];
          }
          std::vector<T> out(mask.size());
          reconstructed(seed.data(), p.count, p.height, p.width, mask.data(), element.get(), kh, kw,
                        T(border), largest, out.data());
          for (int64_t i = 0; i < p.count; ++i) {
            const auto image = [&](const std::vector<T>& values) {
              return cv::Mat(int(p.height), int(p.width), cv::DataType<T>::type,
                             const_cast<T*>(values.data() + i * p.height * p.width));
            };
            const auto bounded = [&](const cv::Mat& x) {
              return largest ? cv::Mat(cv::min(x, image(mask))) : cv::Mat(cv::max(x, image(mask)));
            };
            cv::Mat now = bounded(image(seed));
            for (bool moved = true; moved;) {
              cv::Mat after;
              if (largest)
                cv::dilate(now, after, window, {kw / 2, kh / 2}, 1, cv::BORDER_CONSTANT,
                           cv::Scalar(T(border)));
              else
                cv::erode(now, after, window, {kw / 2, kh / 2}, 1, cv::BORDER_CONSTANT,
                          cv::Scalar(T(border)));
              after = bounded(after);
              moved = cv::norm(now, after, cv::NORM_INF) != 0;
              now = after;
            }
            ASSERT_EQ(cv::norm(now, image(out), cv::NORM_INF), 0)
                << p.height << "x" << p.width << ", window " << kh << "x" << kw << ", border " << border;
          }
        }
}

KERNEL_CALL_BENCHMARK(reconstructed, [] {
  std::vector<float> mask = kernel_benchmarks::random(3 * 1080 * 1920), seed = mask;
  for (float& v : seed) v -= 0.2f;
  const std::shared_ptr<bool[]> element(new bool[9]);
  std::fill_n(element.get(), 9, true);
  return [mask, seed, element, out = std::vector<float>(3 * 1080 * 1920)]() mutable {
    reconstructed(seed.data(), 3, 1080, 1920, mask.data(), element.get(), 3, 3, -1e4f, true, out.data());
  };
});

TYPED_TEST(Shapes, ConnectedComponentsMatchOpenCv) {
  using T = TypeParam;
  for (const Planes& p : kSizes)
    for (const auto& x : this->masks(p)) {
      std::vector<int64_t> numbers(x.size()), of_bytes(x.size());
      connected_components(x.data(), p, false, numbers.data());
      std::vector<uint8_t> bytes(x.size());
      std::transform(x.begin(), x.end(), bytes.begin(), [](T v) { return v > 0 ? 200 : 0; });
      connected_components(bytes.data(), p, false, of_bytes.data());
      ASSERT_EQ(of_bytes, numbers);
      for (int64_t i = 0; i < p.count; ++i) {
        const int64_t start = i * p.height * p.width;
        const cv::Mat plane(int(p.height), int(p.width), cv::DataType<T>::type,
                            const_cast<T*>(x.data() + start));
        cv::Mat labels;
        cv::connectedComponents(plane > 0, labels, 8);
        std::map<int, int64_t> first{{0, -1}};  // OpenCV's label -> its first pixel
        for (int k = 0; k < int(labels.total()); ++k) {
          const int label = labels.at<int>(k / labels.cols, k % labels.cols);
          ASSERT_EQ(numbers[size_t(start + k)], first.try_emplace(label, k).first->second + 1);
        }
      }
    }
}

TYPED_TEST(Shapes, StatisticsOfLabelsMatchOpenCv) {
  using T = TypeParam;
  for (const Planes& p : kSizes)
    for (const auto& x : this->masks(p)) {
      const int64_t size = p.height * p.width;
      std::vector<int64_t> labels(x.size());
      connected_components(x.data(), p, true, labels.data());
      const int64_t slots = 1 + *std::max_element(labels.begin(), labels.end());
      std::vector<int64_t> made(static_cast<size_t>(p.count * slots * 7));
      label_statistics(labels.data(), p.count, p.height, p.width, slots, made.data());
      for (int64_t i = 0; i < p.count; ++i) {
        const cv::Mat plane(int(p.height), int(p.width), cv::DataType<T>::type,
                            const_cast<T*>(x.data() + i * size));
        cv::Mat theirs, boxes, centroids;
        const int count = cv::connectedComponentsWithStats(plane > 0, theirs, boxes, centroids, 8);
        int64_t most = 0;  // labels come in the order of their first pixels
        for (int64_t k = 0; k < size; ++k) {
          const int64_t label = labels[size_t(i * size + k)];
          ASSERT_LE(label, most + 1);
          most = std::max(most, label);
          const int other = theirs.at<int>(int(k / p.width), int(k % p.width));
          ASSERT_EQ(label == 0, other == 0);
          const int64_t* const s = made.data() + (i * slots + label) * 7;
          for (int c = 0; c < 5; ++c) ASSERT_EQ(s[c], boxes.at<int>(other, c)) << c;
          for (int c = 0; c < 2; ++c)
            ASSERT_NEAR(double(s[5 + c]) / double(s[4]), centroids.at<double>(other, c), 1e-9);
        }
        ASSERT_EQ(most, count - 1);
      }
    }
}

KERNEL_CALL_BENCHMARK(label_statistics, [] {
  const auto x = many_discs();
  std::vector<int64_t> labels(x.size());
  connected_components(x.data(), {3, 1080, 1920}, true, labels.data());
  return [labels, out = std::vector<int64_t>(3 * 256 * 7)]() mutable {
    label_statistics(labels.data(), 3, 1080, 1920, 256, out.data());
  };
});

KERNEL_CALL_BENCHMARK(connected_components, [] {
  return [x = many_discs(), out = std::vector<int64_t>(3 * 1080 * 1920)]() mutable {
    connected_components(x.data(), {3, 1080, 1920}, false, out.data());
  };
});

KERNEL_CALL_BENCHMARK(connected_components_noise, [] {
  return [x = kernel_benchmarks::random(3 * 1080 * 1920, -0.6f, 0.4f),
          out = std::vector<int64_t>(3 * 1080 * 1920)]() mutable {
    connected_components(x.data(), {3, 1080, 1920}, false, out.data());
  };
});

// The points of a polygon, from the smallest one on.
std::vector<int64_t> from_the_least(std::vector<int64_t> points) {
  if (!points.empty()) {
    std::vector<int64_t> least = points;
    for (size_t i = 0; i < points.size(); ++i) {
      std::rotate(points.begin(), points.begin() + 1, points.end());
      least = std::min(least, points);
    }
    points = least;
  }
  return points;
}

TEST(Contours, AreOpenCvs) {
  std::mt19937 random(0);
  for (const Planes& p : {Planes{1, 1, 1}, Planes{2, 1, 9}, Planes{2, 9, 1}, Planes{2, 3, 5},
                          Planes{1, 2, 64}, Planes{3, 19, 37}})
    for (const double share : {0.0, 0.2, 0.5, 0.8, 1.0}) {
      const int64_t size = p.height * p.width, numbers = 2 * size + 2;
      std::vector<uint8_t> mask(size_t(p.count * size));
      for (uint8_t& m : mask) m = std::bernoulli_distribution(share)(random) ? 7 : 0;
      std::vector<int64_t> found(size_t(p.count * size * numbers));
      find_contours(mask.data(), p, size, numbers, found.data());
      for (int64_t i = 0; i < p.count; ++i) {
        std::vector<std::vector<cv::Point>> paths;
        std::vector<cv::Vec4i> hierarchy;
        cv::findContours(cv::Mat(int(p.height), int(p.width), CV_8U, mask.data() + i * size), paths,
                         hierarchy, cv::RETR_CCOMP, cv::CHAIN_APPROX_SIMPLE);
        std::multiset<std::pair<bool, std::vector<int64_t>>> expected, actual;
        for (size_t k = 0; k < paths.size(); ++k) {
          std::vector<int64_t> points;
          for (const cv::Point& q : paths[k]) points.push_back(q.y * p.width + q.x);
          expected.emplace(hierarchy[k][3] >= 0, from_the_least(points));
        }
        for (int64_t k = 0; k < size; ++k) {
          const int64_t* const slot = found.data() + (i * size + k) * numbers;
          for (int64_t j = 2 + slot[0]; j < numbers; ++j) ASSERT_EQ(slot[j], -1);
          if (slot[0] > 0) actual.emplace(slot[1] != 0, from_the_least({slot + 2, slot + 2 + slot[0]}));
        }
        ASSERT_EQ(actual, expected);
      }
    }
}

TEST(Contours, TheLargestComeFirstAndLosePointsEvenly) {
  // Two squares, the larger with a hole.
  const int64_t width = 16;
  std::vector<uint8_t> mask(12 * 16, 0);
  for (int64_t y = 1; y < 4; ++y)
    for (int64_t x = 1; x < 4; ++x) mask[size_t(y * width + x)] = 1;
  for (int64_t y = 4; y < 11; ++y)
    for (int64_t x = 6; x < 14; ++x) mask[size_t(y * width + x)] = y != 7 || x < 8 || x > 10;
  std::vector<int64_t> out(4 * 4);
  find_contours(mask.data(), {1, 12, width}, 4, 4, out.data());
  // The polygon around the hole, in (x, y): (8, 8), which is the first below, then (7, 7), (8, 6), (10, 6),
  // (11, 7), (10, 8).
  EXPECT_EQ(out, (std::vector<int64_t>{2, 0, 4 * width + 6, 10 * width + 13,  //
                                       2, 0, width + 1, 3 * width + 3,        //
                                       2, 1, 8 * width + 8, 6 * width + 10,   //
                                       0, 0, -1, -1}));
}

KERNEL_CALL_BENCHMARK(find_contours, [] {
  const std::vector<float> discs = many_discs();
  return [mask = std::vector<uint8_t>(discs.begin(), discs.end()),
          out = std::vector<int64_t>(3 * 64 * 258)]() mutable {
    find_contours(mask.data(), {3, 1080, 1920}, 64, 258, out.data());
  };
});

TYPED_TEST(Shapes, WhatIsNoNumberIsNotSet) {
  using T = TypeParam;
  const T nan = std::numeric_limits<T>::quiet_NaN(), inf = std::numeric_limits<T>::infinity();
  const std::vector<T> x{1, nan, inf, -inf, 1};
  std::vector<T> out(5);
  distance_transform_edt(x.data(), {1, 1, 5}, out.data());
  EXPECT_EQ(out, (std::vector<T>{1, 0, 1, 0, 1}));
  thin(x.data(), {1, 1, 5}, 100, false, out.data());
  EXPECT_EQ(out, (std::vector<T>{1, 0, 1, 0, 1}));
  std::vector<int64_t> numbers(5);
  connected_components(x.data(), {1, 1, 5}, false, numbers.data());
  EXPECT_EQ(numbers, (std::vector<int64_t>{1, 0, 3, 0, 5}));
}

}  // namespace
