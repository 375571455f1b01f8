// cuda_replay [--backend NAME]... BUNDLE...: runs each bundle's golden inputs on CUDA device 0, on every
// backend or on those named, and compares the results with the golden outputs, which are eager PyTorch's on
// the CPU.
//
// Prints a line for each artifact and dtype: PASS or FAIL, the op, method, backend, dtype, the largest error
// and the tolerance; or SKIP with the reason. The exit status is 1 if one failed or if nothing was run.
#include <cstdio>
#include <exception>
#include <filesystem>
#include <string>
#include <vector>

#include "chiasm/chiasm.hpp"

int main(int argc, char** argv) {
  using Result = chiasm::SelfTestRow::Result;
  std::vector<std::string> backends, bundles;
  for (int i = 1; i < argc; ++i) {
    if (std::string(argv[i]) == "--backend" && i + 1 < argc)
      backends.emplace_back(argv[++i]);
    else
      bundles.emplace_back(argv[i]);
  }
  if (backends.empty()) backends.emplace_back("auto");
  int passed = 0, failed = 0;
  for (const std::string& folder : bundles) {
    const std::string op = std::filesystem::path(folder).stem().string();
    for (const std::string& backend : backends) {
      try {
        const chiasm::Bundle bundle = chiasm::Bundle::open(folder);
        chiasm::LoadOptions options;
        options.with_backend(backend).with_device(chiasm::Device::cuda());
        for (const chiasm::SelfTestRow& row : bundle.self_test(options)) {
          const char* word = row.result == Result::Passed   ? "PASS"
                             : row.result == Result::Failed ? "FAIL"
                                                            : "SKIP";
          std::printf("%s %s %s %s %s %.3g %.3g %s\n", word, op.c_str(), row.method.c_str(),
                      row.backend.c_str(), row.dtype.c_str(), row.max_error, row.tolerance,
                      row.message.c_str());
          passed += row.result == Result::Passed ? 1 : 0;
          failed += row.result == Result::Failed ? 1 : 0;
        }
      } catch (const std::exception& error) {
        std::printf("FAIL %s - %s - 0 0 %s\n", op.c_str(), backend.c_str(), error.what());
        ++failed;
      }
      std::fflush(stdout);
    }
  }
  std::printf("cuda_replay: %zu bundles, %d passed, %d failed\n", bundles.size(), passed, failed);
  return passed == 0 || failed > 0;
}
