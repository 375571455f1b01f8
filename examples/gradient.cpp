// Gradient descent by a bundle's `vjp`: what was this image before it was blurred?
//
//     gradient BUNDLE STEPS OUT.raw        BUNDLE: chiasm export filters.box_blur -o bundles
#include <chiasm/chiasm.hpp>
#include <cstdlib>
#include <fstream>
#include <iostream>

int main(int count, char** arguments) try {
  if (count != 4) {
    std::cerr << "usage: gradient BUNDLE STEPS OUT.raw\n";
    return 2;
  }
  const int steps = std::atoi(arguments[2]);
  const auto bundle = chiasm::Bundle::open(arguments[1]);
  const auto blur = bundle.method("forward"), vjp = bundle.method("vjp");
  constexpr int64_t kSize = 32;
  const chiasm::Shape shape = {1, 1, kSize, kSize};
  std::vector<float> truth(kSize * kSize), blurred(truth), again(truth), gradient(truth);
  for (int64_t y = 8; y < 24; ++y)
    for (int64_t x = 12; x < 20; ++x) truth[y * kSize + x] = 1;  // a bar
  blur.run_into({{truth.data(), shape}}, {{blurred.data(), shape}});

  std::vector<float> guess = blurred;
  for (int step = 0; step < steps; ++step) {
    blur.run_into({{guess.data(), shape}}, {{again.data(), shape}});
    for (size_t i = 0; i < again.size(); ++i) again[i] -= blurred[i];
    // the gradient of half the sum of squared differences
    vjp.run_into({{guess.data(), shape}, {again.data(), shape}}, {{gradient.data(), shape}});
    for (size_t i = 0; i < guess.size(); ++i) guess[i] -= 0.5f * gradient[i];
  }
  blur.run_into({{guess.data(), shape}}, {{again.data(), shape}});
  double error = 0;
  for (size_t i = 0; i < again.size(); ++i) error += (again[i] - blurred[i]) * (again[i] - blurred[i]);
  std::ofstream(arguments[3], std::ios::binary)
      .write(reinterpret_cast<const char*>(guess.data()),
             static_cast<std::streamsize>(guess.size() * sizeof(float)));
  std::cout << vjp.backend() << ": squared difference " << error << " after " << steps << " steps\n";
} catch (const std::exception& error) {
  std::cerr << "gradient: " << error.what() << '\n';
  return 1;
}
