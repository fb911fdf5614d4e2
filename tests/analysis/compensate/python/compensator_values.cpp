// Writes a model of each kind of compensator into a folder, and prints frames and what the C++ side makes of them, for
// compensator_test.py.
#include <array>
#include <cstdio>
#include <fstream>
#include <utility>

#include "analysis/identify/sensor_model.h"
#include "analysis/identify/stored/model_document.h"
#include "tests/analysis/compensate/kinds.h"

using namespace synthetic;

int main(int, char** words) {
  for (const Kind& kind : kinds()) {
    if (kind.name != "elam" && kind.name != "linearised in time") continue;
    const SensorModel model = sensor_of(kind);
    const std::string name = kind.in_time ? "in_time" : "elam";
    std::ofstream(words[1] + ("/" + name + ".json")) << to_text(model);
    FrameCompensator frames = frames_of(model);
    frames.start(Start::kAtRest);
    frames.work(30.0);
    const Walk walk = walk_of(kind, reversals(kind, 200, 2.0, 3), 1.0 / 2000.0, 1);
    for (std::size_t i = 0; i < walk.output.size(); ++i) {
      const double output = walk.output[i], first = i % 41 == 17 ? output + 3.0 * kind.full() : output;  // spikes
      const std::array<float, kThree> volts{static_cast<float>(first), 0.0F, static_cast<float>(0.9 * output)};
      std::array<float, kThree> pressure{}, uncertainty{};
      std::array<std::uint16_t, kThree> status{};
      frames.frame(volts, walk.seconds, {pressure, uncertainty, status});
      std::printf("%s", name.c_str());
      for (const auto* const list : {&std::as_const(volts), &std::as_const(pressure), &std::as_const(uncertainty)})
        for (const float value : *list) std::printf(" %.17g", static_cast<double>(value));
      for (const unsigned bits : status) std::printf(" %u", bits);
      std::printf("\n");
    }
  }
}
