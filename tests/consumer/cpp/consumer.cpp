// A product that uses an installed chiasm. With a bundle of filters.sobel as its argument it also runs it.
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include <chiasm/chiasm.hpp>

int main(int argc, char** argv) try {
  std::printf("chiasm %s\n", chiasm::library_version().c_str());
  int available = 0;
  for (const chiasm::BackendInfo& backend : chiasm::backends()) {
    std::printf("%s: %s\n", backend.name.c_str(),
                backend.available ? backend.engine_version.c_str() : backend.problem.c_str());
    if (backend.available) ++available;
  }
  if (available == 0) return 1;

  try {
    chiasm::Bundle::open("no.such.chiasm");
    return 1;
  } catch (const chiasm::Error& error) {
    if (error.code() != CHIASM_NOT_FOUND) return 1;
  }
  if (argc < 2) return 0;

  auto sobel = chiasm::Bundle::open(argv[1]).method("forward");
  std::vector<float> image(1 * 3 * 256 * 256, 0.5f);
  auto out = sobel.run({chiasm::Tensor(image.data(), {1, 3, 256, 256})});
  const float* edges = out[0].data<float>();
  std::printf("on %s: %g\n", sobel.backend().c_str(), static_cast<double>(edges[0]));
  return std::fabs(edges[0] - 1e-3f) < 1e-6f ? 0 : 1;  // sqrt(eps) of a flat image
} catch (const std::exception& error) {
  std::printf("%s\n", error.what());
  return 1;
}
