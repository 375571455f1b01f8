// A photograph through a pipeline: colour to grey, blur, Sobel, back to bytes.
//
//     edges BUNDLE PHOTO OUT.png        BUNDLE: chiasm export pipelines.edges -o bundles
#include <chiasm/opencv.hpp>
#include <iostream>
#include <opencv2/imgcodecs.hpp>

int main(int count, char** arguments) try {
  if (count != 4) {
    std::cerr << "usage: edges BUNDLE PHOTO OUT.png\n";
    return 2;
  }
  const auto edges = chiasm::Bundle::open(arguments[1]).method("forward");
  const cv::Mat photo = cv::imread(arguments[2]);
  if (photo.empty()) throw std::runtime_error(std::string("cannot read ") + arguments[2]);
  const auto outputs = edges.run({chiasm::view(photo)});  // reads the photograph where it is
  if (!cv::imwrite(arguments[3], chiasm::to_mat(outputs[0])))
    throw std::runtime_error(std::string("cannot write ") + arguments[3]);
  std::cout << "edges on " << edges.backend() << ": " << photo.size() << " -> " << arguments[3] << '\n';
} catch (const std::exception& error) {
  std::cerr << "edges: " << error.what() << '\n';
  return 1;
}
