// The kernels of networks, against their definitions in plain loops of doubles.
#include <cmath>
#include <limits>
#include <vector>

#include "benchmarks.h"
#include "fixture.h"
#include "kernels.h"

using namespace chiasm::kernels;

namespace {

struct Case {
  int64_t batch, height, width, channels, groups, outputs, kernel_y, kernel_x, stride_y, stride_x, top, left,
      dilation_y, dilation_x;

  int64_t depth() const { return channels / groups; }
  int64_t result_height() const {
    return (height + 2 * top - dilation_y * (kernel_y - 1) - 1) / stride_y + 1;
  }
  int64_t result_width() const { return (width + 2 * left - dilation_x * (kernel_x - 1) - 1) / stride_x + 1; }
};

// The sum of output n, with weights (outputs, kernel_y, kernel_x, depth).
template <class T>
double expected(const Case& c, const std::vector<T>& x, const std::vector<T>& weight,
                const std::vector<T>& bias, int64_t b, int64_t y, int64_t xx, int64_t n) {
  double sum = bias[size_t(n)];
  const int64_t group = n / (c.outputs / c.groups);
  for (int64_t ky = 0; ky < c.kernel_y; ++ky)
    for (int64_t kx = 0; kx < c.kernel_x; ++kx)
      for (int64_t k = 0; k < c.depth(); ++k) {
        const int64_t row = y * c.stride_y - c.top + ky * c.dilation_y,
                      column = xx * c.stride_x - c.left + kx * c.dilation_x;
        if (row < 0 || row >= c.height || column < 0 || column >= c.width) continue;
        sum +=
            double(
                x[size_t(((b * c.height + row) * c.width + column) * c.channels + group * c.depth() + k)]) *
            double(weight[size_t(((n * c.kernel_y + ky) * c.kernel_x + kx) * c.depth() + k)]);
      }
  return sum;
}

template <class T>
class NetworkKernels : public KernelsTest<T> {
 protected:
  NetworkKernels() : KernelsTest<T>(29) {}

  void check(const Case& c, T low, T high) {
    const auto x = this->random(c.batch * c.height * c.width * c.channels, -1, 1),
               weight = this->random(c.outputs * c.kernel_y * c.kernel_x * c.depth(), -1, 1),
               bias = this->random(c.outputs, -1, 1);
    const int64_t height = c.result_height(), width = c.result_width();
    const T unwritten = std::numeric_limits<T>::quiet_NaN();
    std::vector<T> out(size_t(c.batch * height * width * c.outputs), unwritten);
    const int64_t taps = c.kernel_y * c.kernel_x, outputs = c.outputs / c.groups,
                  panels = (outputs + 15) / 16;
    if (c.depth() == 1 && c.groups == c.outputs && c.groups > 1) {
      std::vector<T> windows(weight.size());
      for (int64_t n = 0; n < c.outputs; ++n)
        for (int64_t k = 0; k < taps; ++k) windows[size_t(k * c.outputs + n)] = weight[size_t(n * taps + k)];
      depthwise_convolution(x.data(), c.batch, c.height, c.width, c.channels, windows.data(), c.kernel_y,
                            c.kernel_x, bias.data(), c.stride_y, c.stride_x, c.top, c.left, c.dilation_y,
                            c.dilation_x, height, width, low, high, out.data());
    } else {
      std::vector<T> packed(size_t(c.groups * panels * taps * c.depth() * 16));
      for (int64_t n = 0; n < c.outputs; ++n)
        for (int64_t k = 0; k < taps * c.depth(); ++k) {
          const int64_t panel = n / outputs * panels + n % outputs / 16;
          packed[size_t((panel * taps * c.depth() + k) * 16 + n % outputs % 16)] =
              weight[size_t(n * taps * c.depth() + k)];
        }
      packed_convolution(x.data(), c.batch, c.height, c.width, c.channels, packed.data(), c.groups * panels,
                         c.kernel_y, c.kernel_x, c.depth(), bias.data(), c.outputs, c.stride_y, c.stride_x,
                         c.top, c.left, c.dilation_y, c.dilation_x, height, width, low, high, out.data());
    }
    size_t i = 0;
    const double limit = 4e-7 * double(taps * c.depth() + 1) * (sizeof(T) == 8 ? 1e-8 : 1);
    for (int64_t b = 0; b < c.batch; ++b)
      for (int64_t y = 0; y < height; ++y)
        for (int64_t xx = 0; xx < width; ++xx)
          for (int64_t n = 0; n < c.outputs; ++n, ++i)
            ASSERT_NEAR(
                double(out[i]),
                std::min(std::max(expected(c, x, weight, bias, b, y, xx, n), double(low)), double(high)),
                limit)
                << "image " << b << " row " << y << " column " << xx << " output " << n;
  }
};

using Types = ::testing::Types<float, double>;
TYPED_TEST_SUITE(NetworkKernels, Types);

TYPED_TEST(NetworkKernels, ConvolutionsMatchPlainLoops) {
  constexpr TypeParam most = std::numeric_limits<TypeParam>::infinity();
  for (const Case& c : {
           Case{1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 0, 0, 1, 1},       // a number
           Case{1, 7, 5, 3, 1, 16, 3, 3, 1, 1, 1, 1, 1, 1},      // a whole panel
           Case{2, 9, 11, 5, 1, 33, 3, 5, 2, 1, 1, 2, 1, 1},     // panels and an output, pixels of two images
           Case{1, 14, 13, 40, 1, 150, 1, 1, 1, 1, 0, 0, 1, 1},  // more panels than a thread takes
           Case{1, 12, 10, 6, 2, 10, 3, 3, 1, 2, 2, 0, 2, 3},    // groups, dilated taps
           Case{2, 8, 8, 6, 6, 18, 3, 3, 1, 1, 1, 1, 1, 1},      // groups of one channel, three outputs each
           Case{1, 40, 37, 2, 1, 3, 7, 7, 4, 3, 3, 3, 1, 1},     // a large window
           Case{1, 3, 4, 2, 1, 4, 3, 3, 1, 1, 5, 6, 1, 1},       // windows with padding only
           Case{1, 1, 200, 4, 1, 20, 1, 9, 1, 2, 0, 4, 1, 1},    // a row
       }) {
    this->check(c, -most, most);
    this->check(c, TypeParam(-0.25), TypeParam(0.5));
  }
}

TYPED_TEST(NetworkKernels, WindowsForEachChannelMatchPlainLoops) {
  constexpr TypeParam most = std::numeric_limits<TypeParam>::infinity();
  for (const int64_t channels : {2, 8, 37, 70})
    for (const Case& c : {
             Case{2, 9, 7, channels, channels, channels, 3, 3, 1, 1, 1, 1, 1, 1},
             Case{1, 10, 12, channels, channels, channels, 5, 3, 2, 3, 2, 1, 1, 2},
             Case{1, 2, 3, channels, channels, channels, 3, 3, 1, 1, 6, 5, 2, 1},
         }) {
      this->check(c, -most, most);
      this->check(c, TypeParam(0), TypeParam(1));
    }
}

TYPED_TEST(NetworkKernels, NothingHasNoPixels) {
  const TypeParam one = 1;
  TypeParam out = 0;
  packed_convolution<TypeParam>(&one, 0, 1, 1, 1, std::vector<TypeParam>(16, 1).data(), 1, 1, 1, 1, &one, 1,
                                1, 1, 0, 0, 1, 1, 1, 1, 0, 1, &out);
  depthwise_convolution<TypeParam>(&one, 0, 1, 1, 1, &one, 1, 1, &one, 1, 1, 0, 0, 1, 1, 1, 1, 0, 1, &out);
  EXPECT_EQ(out, 0);
}

TYPED_TEST(NetworkKernels, NaNStays) {
  const TypeParam nan = std::numeric_limits<TypeParam>::quiet_NaN(), zero = 0;
  TypeParam out = 0;
  packed_convolution<TypeParam>(&nan, 1, 1, 1, 1, std::vector<TypeParam>(16, 1).data(), 1, 1, 1, 1, &zero, 1,
                                1, 1, 0, 0, 1, 1, 1, 1, 0, 6, &out);
  EXPECT_TRUE(std::isnan(out));
  out = 0;
  depthwise_convolution<TypeParam>(&nan, 1, 1, 1, 1, &nan, 1, 1, &zero, 1, 1, 0, 0, 1, 1, 1, 1, 0, 6, &out);
  EXPECT_TRUE(std::isnan(out));
}

double sigmoid(double v) { return 1 / (1 + std::exp(-v)); }

// `gates` of the input and of the hidden state, and the state and cell of one unit after a step.
using Step = void (*)(const double* of_input, const double* of_state, double& state, double& cell);

// (S. Hochreiter, J. Schmidhuber, 1997), for sums of both parts.
void lstm_step(const double* of_input, const double* of_state, double& state, double& cell) {
  const auto gate = [&](int i) { return of_input[i] + of_state[i]; };
  cell = sigmoid(gate(1)) * cell + sigmoid(gate(0)) * std::tanh(gate(2));
  state = sigmoid(gate(3)) * std::tanh(cell);
}

// (K. Cho et al., 2014), with the reset gate where PyTorch's documentation has it.
void gru_step(const double* of_input, const double* of_state, double& state, double&) {
  const double reset = sigmoid(of_input[0] + of_state[0]), update = sigmoid(of_input[1] + of_state[1]);
  state = (1 - update) * std::tanh(of_input[2] + reset * of_state[2]) + update * state;
}

// A recurrent layer with random numbers, and its panels of weights.
template <class T>
struct Recurrent {
  int64_t length, batch, units, kinds, all = kinds * units, panels = (all + 15) / 16;
  std::vector<T> packed = std::vector<T>(size_t(panels * units * 16));
  std::vector<T> gates{}, weight{}, bias{}, hidden{}, cell{}, out{};

  void pack() {
    for (int64_t n = 0; n < all; ++n)
      for (int64_t k = 0; k < units; ++k)
        packed[size_t((n / 16 * units + k) * 16 + n % 16)] = weight[size_t(n * units + k)];
  }

  void expect(Step step, bool reverse, bool has_cells) const {
    const double limit = sizeof(T) == 8 ? 1e-12 : 1e-5;
    for (int64_t b = 0; b < batch; ++b) {
      std::vector<double> state(hidden.begin() + b * units, hidden.begin() + (b + 1) * units),
          memory(cell.begin() + b * units, cell.begin() + (b + 1) * units);
      for (int64_t i = 0; i < length; ++i) {
        const int64_t t = reverse ? length - 1 - i : i;
        const std::vector<double> before = state;
        for (int64_t k = 0; k < units; ++k) {
          double of_input[4], of_state[4];
          for (int64_t kind = 0; kind < kinds; ++kind) {
            const int64_t n = kind * units + k;
            of_input[kind] = gates[size_t((t * batch + b) * all + n)];
            of_state[kind] = bias.empty() ? 0 : bias[size_t(n)];
            for (int64_t m = 0; m < units; ++m)
              of_state[kind] += before[size_t(m)] * double(weight[size_t(n * units + m)]);
          }
          step(of_input, of_state, state[size_t(k)], memory[size_t(k)]);
          const int64_t at = (t * batch + b) * units + k;
          ASSERT_NEAR(double(out[size_t(at)]), state[size_t(k)], limit);
          if (has_cells) {
            ASSERT_NEAR(double(out[size_t(length * batch * units + at)]), memory[size_t(k)], limit);
          }
        }
      }
    }
  }
};

TYPED_TEST(NetworkKernels, RecurrentLayersMatchPlainLoops) {
  using T = TypeParam;
  for (const bool reverse : {false, true})
    for (const int64_t length : {0, 1, 5})
      for (const int64_t batch : {1, 3, 4, 9})
        for (const int64_t units : {1, 4, 7, 16, 37}) {
          const auto layer = [&](int64_t kinds, bool has_bias) {
            Recurrent<T> made{length, batch, units, kinds};
            made.gates = this->random(length * batch * made.all, -20, 20);
            made.weight = this->random(made.all * units, -1, 1);
            made.bias = this->random(has_bias ? made.all : 0, -1, 1);
            made.hidden = this->random(batch * units, -1, 1);
            made.cell = this->random(batch * units, -3, 3);
            made.out.assign(size_t(2 * length * batch * units), std::numeric_limits<T>::quiet_NaN());
            made.pack();
            return made;
          };
          Recurrent<T> a = layer(4, false);
          lstm(a.gates.data(), length, batch, a.all, a.packed.data(), a.panels, units, a.hidden.data(),
               a.cell.data(), reverse, a.out.data());
          a.expect(lstm_step, reverse, true);
          Recurrent<T> b = layer(3, true);
          gru(b.gates.data(), length, batch, b.all, b.packed.data(), b.panels, units, b.bias.data(),
              b.hidden.data(), reverse, b.out.data());
          b.expect(gru_step, reverse, false);
        }
}

TYPED_TEST(NetworkKernels, RecurrentLayersOfInfinitiesAndNaN) {
  using T = TypeParam;
  constexpr T nan = std::numeric_limits<T>::quiet_NaN(), most = std::numeric_limits<T>::infinity();
  const std::vector<T> weight(16), hidden{0}, cell{T(0.5)};
  const auto run = [&](std::vector<T> gates) {
    std::vector<T> out(2);
    lstm(gates.data(), 1, 1, 4, weight.data(), 1, 1, hidden.data(), cell.data(), false, out.data());
    return out;
  };
  EXPECT_EQ(run({most, -most, most, most})[1], 1);     // open, forgotten, 1
  EXPECT_EQ(run({-most, most, 0, -most})[1], T(0.5));  // kept
  EXPECT_EQ(run({-most, most, 0, -most})[0], 0);
  EXPECT_TRUE(std::isnan(run({nan, 0, 1, 0})[1]));
  EXPECT_TRUE(std::isnan(run({0, 0, nan, 0})[0]));
  EXPECT_TRUE(std::isnan(run({0, 0, 0, nan})[0]));
  const std::vector<T> bias(3);
  const auto run_gru = [&](std::vector<T> gates) {
    T result = 0;
    gru(gates.data(), 1, 1, 3, weight.data(), 1, 1, bias.data(), cell.data(), false, &result);
    return result;
  };
  EXPECT_EQ(run_gru({0, most, 1}), T(0.5));  // kept
  EXPECT_EQ(run_gru({0, -most, most}), 1);   // replaced
  for (int i = 0; i < 3; ++i) {
    std::vector<T> gates(3);
    gates[size_t(i)] = nan;
    EXPECT_TRUE(std::isnan(run_gru(gates)));
  }
}

// A layer from `channels` to `channels` channels on images of side x side, with windows of 3 x 3 or single
// pixels.
struct Layer {
  int64_t side, channels, kernel;
  std::vector<float> x = kernel_benchmarks::random(side * side * channels), out = x,
                     weight = kernel_benchmarks::random(kernel * kernel * channels * channels),
                     bias = kernel_benchmarks::random(channels);

  void packed() {
    packed_convolution(x.data(), 1, side, side, channels, weight.data(), channels / 16, kernel, kernel,
                       channels, bias.data(), channels, 1, 1, kernel / 2, kernel / 2, 1, 1, side, side, 0.0f,
                       6.0f, out.data());
  }
  void depthwise() {
    depthwise_convolution(x.data(), 1, side, side, channels, weight.data(), kernel, kernel, bias.data(), 1, 1,
                          kernel / 2, kernel / 2, 1, 1, side, side, 0.0f, 6.0f, out.data());
  }
};

// 32 steps of 256 units, one sample.
KERNEL_CALL_BENCHMARK(lstm, [] {
  return [gates = kernel_benchmarks::random(32 * 1024), weight = kernel_benchmarks::random(256 * 1024),
          state = std::vector<float>(256), out = std::vector<float>(2 * 32 * 256)]() mutable {
    lstm(gates.data(), 32, 1, 1024, weight.data(), 64, 256, state.data(), state.data(), false, out.data());
  };
});
KERNEL_CALL_BENCHMARK(gru, [] {
  return [gates = kernel_benchmarks::random(32 * 768), weight = kernel_benchmarks::random(256 * 768),
          bias = kernel_benchmarks::random(768), state = std::vector<float>(256),
          out = std::vector<float>(32 * 256)]() mutable {
    gru(gates.data(), 32, 1, 768, weight.data(), 48, 256, bias.data(), state.data(), false, out.data());
  };
});
KERNEL_CALL_BENCHMARK(packed_convolution_3x3, [] {
  return [layer = Layer{28, 128, 3}]() mutable { layer.packed(); };
});
KERNEL_CALL_BENCHMARK(packed_convolution_1x1, [] {
  return [layer = Layer{56, 128, 1}]() mutable { layer.packed(); };
});
KERNEL_CALL_BENCHMARK(depthwise_convolution_3x3, [] {
  return [layer = Layer{56, 144, 3}]() mutable { layer.depthwise(); };
});

}  // namespace
