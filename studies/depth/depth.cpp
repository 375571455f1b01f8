// Depth of a scene by gradient descent, from bundles, without Python or torch: the loop of
// studies/depth/descent.py.
//
//     study_depth BUNDLES native|onnx SCENE
//
// SCENE is a folder with the views as pictures and scene.json: cameras, motions, limits of the inverse depth,
// scales, iterations, learning rate. The inverse depth is written to the same folder as
// inverse_depth.BACKEND.tiff (32-bit floats). A line of JSON on stdout has the loss of the last step, the
// time of the whole optimisation and of a step at the finest scale, and whether libtorch was in the process.
#include <fstream>
#include <iostream>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <chiasm/chiasm.hpp>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "../../bench/harness.hpp"
#include "../loaded.hpp"

using bench::Clock;
using nlohmann::json;

namespace {

// Flattens nested lists of numbers, row by row.
void flatten(const json& value, std::vector<float>& into) {
  if (value.is_array())
    for (const json& part : value) flatten(part, into);
  else
    into.push_back(value.get<float>());
}

// A tensor that owns its values.
struct Values {
  std::vector<float> data;
  chiasm::Shape shape;

  Values(std::vector<float> values, chiasm::Shape sizes) : data(std::move(values)), shape(sizes) {
    if (int64_t(data.size()) != shape.count())
      throw std::runtime_error("scene.json: expected " + std::to_string(shape.count()) + " numbers, got " +
                               std::to_string(data.size()));
  }
  static Values read(const json& value, chiasm::Shape sizes) {
    std::vector<float> values;
    flatten(value, values);
    return {std::move(values), sizes};
  }
  chiasm::Tensor view() const { return {data.data(), shape}; }
};

// The entries from `first` up to, but without, `last` of a tensor's first dimension.
chiasm::Tensor entries(const chiasm::Tensor& tensor, int64_t first, int64_t last) {
  chiasm::Shape shape = tensor.shape();
  const int64_t each = shape.count() / shape[0];
  shape[0] = last - first;
  return {tensor.data<const float>() + first * each, shape};
}

// Pictures of one size as (B, 3, H, W), red first, from 0 to 1.
Values read_views(const std::string& folder, const json& files) {
  std::vector<float> values;
  cv::Size size;
  for (const json& file : files) {
    const std::string path = folder + "/" + file.get<std::string>();
    const cv::Mat picture = cv::imread(path, cv::IMREAD_COLOR);
    if (picture.empty()) throw std::runtime_error("cannot read " + path);
    if (&file == &files.front()) size = picture.size();
    if (picture.size() != size) throw std::runtime_error(path + " has another size than the first view");
    for (int channel = 2; channel >= 0; --channel)
      for (int y = 0; y < size.height; ++y)
        for (int x = 0; x < size.width; ++x)
          values.push_back(float(picture.at<cv::Vec3b>(y, x)[channel]) / 255);
  }
  return {std::move(values), {int64_t(files.size()), 3, size.height, size.width}};
}

class Descent {
 public:
  Descent(const std::string& bundles, const std::string& backend)
      : step_(load(bundles, backend, "step")),
        reduce_(load(bundles, backend, "reduce")),
        enlarge_(load(bundles, backend, "enlarge")) {}

  // Writes the inverse depth at the finest scale to a file, and returns a report.
  json run(const std::string& folder, const std::string& result) {
    const json scene = json::parse(std::ifstream(folder + "/scene.json"));
    const Values images = read_views(folder, scene.at("views"));
    const int64_t count = images.shape[0];
    const Values cameras = Values::read(scene.at("cameras"), {count, 3, 3}),
                 motions = Values::read(scene.at("motions"), {count, 4, 4});
    const Values limits = Values::read(scene.at("limits"), {2});
    const int scales = scene.at("scales"), iterations = scene.at("iterations");
    const double rate = scene.at("rate");

    const auto start = Clock::now();
    std::vector<chiasm::Outputs> reduced;  // images and cameras from the second finest scale on
    const auto scale = [&](int i) {
      if (i == 0) return std::pair(images.view(), cameras.view());
      return std::pair(reduced[size_t(i) - 1][0], reduced[size_t(i) - 1][1]);
    };
    for (int i = 1; i < scales; ++i) {
      const auto [finer, their_cameras] = scale(i - 1);
      reduced.push_back(reduce_.run({finer, their_cameras}));
    }
    // The start has the size of the coarsest scale, not of one pixel: resampling a constant gives rounding
    // errors, which differ between engines.
    chiasm::Shape coarsest = scale(scales - 1).first.shape();
    coarsest[0] = coarsest[1] = 1;
    const std::vector<float> middle(size_t(coarsest.count()), (limits.data[0] + limits.data[1]) / 2);
    std::optional<chiasm::Outputs> state;  // owns the memory of the two tensors
    chiasm::Tensor inverse_depth(middle.data(), coarsest);
    double loss = 0, step_ms = 0;
    for (int i = scales - 1; i >= 0; --i) {
      const auto [views, their_cameras] = scale(i);
      const chiasm::Tensor reference = entries(views, 0, 1);
      state = enlarge_.run({inverse_depth, reference});
      inverse_depth = (*state)[0];
      const std::vector<float> still(size_t(inverse_depth.count()));
      chiasm::Tensor velocity(still.data(), inverse_depth.shape());
      const auto began = Clock::now();
      for (int k = 0; k < iterations; ++k) {
        const float now = float(rate * (1 - double(k) / iterations));
        state = step_.run({inverse_depth,
                           velocity,
                           reference,
                           entries(views, 1, count),
                           entries(their_cameras, 0, 1),
                           entries(their_cameras, 1, count),
                           entries(motions.view(), 1, count),
                           limits.view(),
                           {&now, chiasm::Shape()}});
        inverse_depth = (*state)[0];
        velocity = (*state)[1];
      }
      loss = double(*(*state)[2].data<const float>());
      step_ms = bench::microseconds_since(began) / 1000 / iterations;
    }
    const double seconds = bench::microseconds_since(start) / 1e6;
    write(inverse_depth, result);
    return {{"loss", loss}, {"seconds", seconds}, {"step_ms", step_ms}, {"libtorch", loaded("libtorch")}};
  }

 private:
  static chiasm::Method load(const std::string& bundles, const std::string& backend,
                             const std::string& name) {
    // ONNX Runtime with standard operators: native code is the other backend.
    const auto options = chiasm::LoadOptions().with_backend(backend).with_fused(false);
    return chiasm::Bundle::open(bundles + "/depth." + name + ".chiasm").method("forward", options);
  }

  static void write(const chiasm::Tensor& inverse_depth, const std::string& path) {
    const cv::Mat view(int(inverse_depth.shape()[2]), int(inverse_depth.shape()[3]), CV_32F,
                       inverse_depth.data());
    if (!cv::imwrite(path, view)) throw std::runtime_error("cannot write " + path);
  }

  chiasm::Method step_, reduce_, enlarge_;
};

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 4) {
    std::cerr << "usage: study_depth BUNDLES native|onnx SCENE\n";
    return 2;
  }
  chiasm::set_num_threads(1);
  const std::string backend = argv[2], folder = argv[3];
  std::cout << Descent(argv[1], backend).run(folder, folder + "/inverse_depth." + backend + ".tiff")
            << std::endl;
  return 0;
} catch (const std::exception& error) {
  std::cerr << error.what() << '\n';
  return 1;
}
