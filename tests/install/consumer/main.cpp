// Frames of a stored model, one a line of the input: seconds since the one before, then the volts of each taxel.
#include <cstdio>
#include <fstream>
#include <iostream>
#include <iterator>
#include <stdexcept>

#include "analysis/compensate/document.h"

int main(int, char** words) try {
  using namespace tactbench::analysis;
  std::ifstream file(words[1]);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  DocumentFrames model = frames_from_document(text, 0);
  model.frames.start(Start::kAtRest);  // unloaded ...
  model.frames.work(70.0);             // ... and conditioned for 70 s just before
  const std::size_t taxels = model.frames.taxels();
  std::vector<float> volts(taxels), psi(taxels), uncertainty(taxels);
  std::vector<std::uint16_t> status(taxels);
  for (double seconds = 0.0; std::cin >> seconds;) {
    for (float& volt : volts) std::cin >> volt;
    model.frames.frame(volts, seconds, {psi, uncertainty, status});
    for (std::size_t i = 0; i < taxels; ++i) std::printf("%.2f %.2f %d ", psi[i], uncertainty[i], status[i]);
    std::printf("\n");
  }
} catch (const std::invalid_argument& error) {
  std::fprintf(stderr, "%s: %s\n", words[1], error.what());
  return 1;
}
