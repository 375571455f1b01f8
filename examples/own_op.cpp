// An op of your own, exported by own_op.py, without Python.
//
//     own_op BUNDLE OUT.raw
#include <chiasm/chiasm.hpp>
#include <fstream>
#include <iostream>

int main(int count, char** arguments) try {
  if (count != 3) {
    std::cerr << "usage: own_op BUNDLE OUT.raw\n";
    return 2;
  }
  const auto op = chiasm::Bundle::open(arguments[1]).method("forward");
  for (const auto& input : op.info().inputs)
    std::cout << input.name << ": " << input.dims.size() << " dimensions\n";

  std::vector<float> ramp(2 * 3 * 4 * 5);
  for (size_t i = 0; i < ramp.size(); ++i) ramp[i] = static_cast<float>(-1 + 2.0 * i / (ramp.size() - 1));
  const float threshold[] = {0.25f, 0.5f};
  const auto outputs = op.run({{ramp.data(), {2, 3, 4, 5}}, {threshold, {2}}});

  const auto& result = outputs[0];  // one output for each of the op; the memory is theirs
  std::ofstream(arguments[2], std::ios::binary)
      .write(reinterpret_cast<const char*>(result.data<const float>()),
             static_cast<std::streamsize>(ramp.size() * sizeof(float)));
  std::cout << "on " << op.backend() << '\n';
} catch (const std::exception& error) {
  std::cerr << "own_op: " << error.what() << '\n';
  return 1;
}
