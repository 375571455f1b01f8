/** The effects of backends on a process, each in a separate process:
 *
 *      process_test BUNDLE native            the native backend alone maps neither libtorch nor onnxruntime
 *      process_test BUNDLE torch onnx        engines loaded one after the other, and OpenCV, in one process
 *
 *  The bundle is filters.sobel; every backend must give OpenCV's result, also after the others were loaded.
 */
#include <cstdio>
#include <fstream>
#include <opencv2/imgproc.hpp>

#include "chiasm/opencv.hpp"

namespace {

bool maps(const std::string& library) {
  std::ifstream file("/proc/self/maps");
  std::string line;
  while (std::getline(file, line)) {
    if (line.find(library) != std::string::npos) return true;
  }
  return false;
}

double difference(const chiasm::Method& method, const cv::Mat& image) {
  cv::Mat gx, gy, expected;
  cv::Sobel(image, gx, CV_32F, 1, 0, 3, 1.0 / 8, 0, cv::BORDER_REPLICATE);
  cv::Sobel(image, gy, CV_32F, 0, 1, 3, 1.0 / 8, 0, cv::BORDER_REPLICATE);
  cv::sqrt(gx.mul(gx) + gy.mul(gy) + 1e-6, expected);
  const auto outputs = method.run({chiasm::Tensor(image.ptr<const float>(), {1, 1, image.rows, image.cols})});
  const chiasm::Tensor flat(outputs[0].data<float>(), {image.rows, image.cols});
  return cv::norm(chiasm::to_mat(flat), expected, cv::NORM_INF);
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc < 3) return 2;
  cv::Mat image(240, 320, CV_32F);
  cv::randu(image, 0, 1);
  const chiasm::Bundle bundle = chiasm::Bundle::open(argv[1]);
  std::vector<chiasm::Method> methods;
  int failures = 0;
  for (int i = 2; i < argc; ++i) {
    methods.push_back(bundle.method("forward", chiasm::LoadOptions().with_backend(argv[i])));
    for (const chiasm::Method& method : methods) {
      const double error = difference(method, image);
      std::printf("%s after loading %s: largest difference to OpenCV %g\n", method.backend().c_str(), argv[i],
                  error);
      if (!(error < 2e-5)) ++failures;
    }
  }
  const bool native_alone = argc == 3 && std::string(argv[2]) == "native";
  for (const char* library : {"libtorch", "libc10", "libonnxruntime"}) {
    const bool mapped = maps(library);
    std::printf("%s is %smapped\n", library, mapped ? "" : "not ");
    if (native_alone && mapped) ++failures;
  }
  return failures == 0 ? 0 : 1;
} catch (const std::exception& error) {
  std::printf("%s\n", error.what());
  return 1;
}
