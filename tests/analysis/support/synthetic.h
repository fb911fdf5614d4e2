// Synthetic sensors for the tests of analysis/: the reconstructed paper taxel, arrays of similar taxels, their runs.
#pragma once

#include <algorithm>
#include <cmath>
#include <fstream>
#include <random>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "analysis/dataset.h"
#include "analysis/loop.h"
#include "analysis/models/elam.h"
#include "tests/support/paths.h"

namespace synthetic {

using namespace tactbench::analysis;

inline const ElamParameters kPrinted{0.7957, 0.9991, -0.0072, 0.6031, 0.3382};  // Tables 2, 3

// Evenly spread numbers from a seed.
struct Random {
  std::mt19937 engine;
  std::uniform_real_distribution<double> unit;
  explicit Random(unsigned seed) : engine(seed) {}
  double operator()(double low, double high) { return low + (high - low) * unit(engine); }
};

struct Loop {
  std::vector<double> x, up, down;
};

inline Loop paper_loop() {
  std::ifstream file(tactbench::tests::source_path("tests/analysis/data/paper_taxel.csv"));
  std::string line;
  Loop loop;
  std::getline(file, line);
  while (std::getline(file, line)) {
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream row(line);
    double x = 0, up = 0, down = 0;
    row >> x >> up >> down;
    loop.x.push_back(x);
    loop.up.push_back(up);
    loop.down.push_back(down);
  }
  if (loop.x.size() != 31) throw std::runtime_error("paper_taxel.csv is not there");
  return loop;
}

inline ElamModel model_of(const Loop& loop, const ElamParameters& parameters, bool exact_outer = false) {
  return {PatternCurve(loop.x, loop.up, loop.up.front(), loop.up.back()),
          PatternCurve(loop.x, loop.down, loop.down.front(), loop.down.back()),
          parameters,
          {exact_outer}};
}

// Table 1.
inline const std::vector<double> kDescendingTurns{0, 60, 0, 50, 0, 40, 0, 30, 0, 20, 0, 10, 0};
inline const std::vector<double> kAscendingTurns{0,  60, 10, 60, 0,  60, 20, 60, 0,  60, 30,
                                                 60, 0,  60, 40, 60, 0,  60, 50, 60, 0};

inline std::vector<double> levels_of(const std::vector<double>& turns, double step = 2.0) {
  std::vector<double> levels{turns.front()};
  for (std::size_t i = 1; i < turns.size(); ++i) {
    const int count = static_cast<int>(std::lround(std::abs(turns[i] - turns[i - 1]) / step));
    for (int k = 1; k <= count; ++k) levels.push_back(turns[i - 1] + (turns[i] - turns[i - 1]) * k / count);
  }
  return levels;
}

// The direct model driven by pressures, free running: a turn starts from the model's own ordinate.
class Plant {
 public:
  explicit Plant(const ElamModel& model) : model_(&model), curve_(model, true, model.x0(), model.y0()) {}
  double operator()(double x) {
    if (x != x_ && (x > x_) != curve_.ascending()) {
      const bool up = x > x_;
      curve_ = ElamCurve(*model_, up, x_, y_ + 0.0);
    }
    x_ = x;
    y_ = curve_.output(x);
    return y_;
  }
  void rest() { y_ = model_->y0(); }

 private:
  const ElamModel* model_;
  ElamCurve curve_;
  double x_ = 0.0, y_ = 0.0;
};

struct ArrayOptions {
  int rows = 16, columns = 16;
  unsigned sensor_seed = 1;
  double top_fall_low = 0.01, top_fall_high = 0.02;  // share of full scale lost from 60 down to 50 psi
  double play_share = 0.015;                         // of full scale: play operators no ELAM can follow
  double inner_spread = 1.0;                         // of the taxels' split points
};

// Taxels like the paper's with spread gain, shape, top and splits.
struct Array {
  ArrayOptions options;
  std::vector<ElamModel> taxels;
  std::vector<double> play_v;

  explicit Array(const ArrayOptions& o) : options(o) {
    std::mt19937 random(o.sensor_seed);
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> uniform;
    const Loop base = paper_loop();
    const ElamModel paper = model_of(base, kPrinted);
    for (int i = 0; i < o.rows * o.columns; ++i) {
      const double gain = std::clamp(1.0 + 0.13 * normal(random), 0.6, 1.4);
      const double shape = std::clamp(1.0 + 0.06 * normal(random), 0.85, 1.15);
      const double fall = o.top_fall_low + (o.top_fall_high - o.top_fall_low) * uniform(random);
      Loop loop = base;
      const double yu = 3.49 * gain;
      for (std::size_t k = 0; k < loop.x.size(); ++k) {
        const double x = loop.x[k], warped = 60.0 * std::pow(x / 60.0, shape);
        loop.up[k] = gain * paper.ascending(warped);
        // The paper's curve is saturated at the top; these go on falling, the more the further from it.
        const double top = 1.0 - fall * std::pow((60.0 - std::max(x, 40.0)) / 10.0, 1.3);
        loop.down[k] = gain * paper.descending(warped) * top;
        loop.down[k] = std::max(loop.down[k], loop.up[k] * (k + 1 < loop.x.size() ? 1.001 : 1.0));
      }
      loop.down.back() = loop.up.back();
      const double s = o.inner_spread, u = 0.60 + 0.06 * s * normal(random), v = 0.17 + 0.03 * s * normal(random);
      const ElamParameters p{0.78 + 0.05 * s * normal(random),
                             std::clamp(0.975 + 0.01 * s * normal(random), 0.9, 0.999), (v - u) / 60.0, u,
                             0.338 + 0.04 * s * normal(random)};
      taxels.push_back(model_of(loop, p, true));
      play_v.push_back(o.play_share * yu);
    }
  }
};

struct RunOptions {
  unsigned seed = 1;
  double noise_v = 0.0015;  // of one scan
  int scans = 2;
  int repeats = 5;
  double regulator_psi = 0.15;  // lags by this up and down
  double reference_noise_psi = 0.03;
  double gain = 1.0;  // drift of all outputs
  std::vector<std::vector<double>> turns{kDescendingTurns, kAscendingTurns};
};

inline Dataset run(const Array& array, const RunOptions& o) {
  std::mt19937 random(o.seed);
  std::normal_distribution<double> normal;
  Dataset dataset;
  dataset.run = o.seed;
  dataset.origin = "simulated";
  dataset.sensor_serial = "S1";
  dataset.scanner_serial = "C1";
  dataset.rows = array.options.rows;
  dataset.columns = array.options.columns;
  const std::size_t width = array.taxels.size();
  dataset.noise_v.assign(width, o.noise_v / std::sqrt(o.scans));
  dataset.at_limit.assign(width, false);
  std::vector<Plant> plants(array.taxels.begin(), array.taxels.end());
  double play = 0.0, last = 0.0;
  const char* names[] = {"descending", "ascending"};
  for (std::size_t s = 0; s < o.turns.size(); ++s) {
    SequenceData sequence{names[s % 2], {}};
    const std::vector<double> levels = levels_of(o.turns[s]);
    for (int r = 0; r < o.repeats; ++r) {
      Repeat repeat;
      for (const double level : levels) {
        const double lag = level > last ? -o.regulator_psi : o.regulator_psi;
        double pressure = std::clamp(level + lag + o.reference_noise_psi * normal(random), 0.0, 60.0);
        if (level == 0.0 || level == 60.0) pressure = level;
        last = level;
        play = std::clamp(play, pressure - 6.0, pressure);  // lags behind by up to 6 psi going up
        const double bulge = (pressure - play) / 6.0 * std::sin(3.14159265 * pressure / 60.0);
        repeat.steps.push_back({level, pressure});
        for (std::size_t i = 0; i < width; ++i) {
          const double clean = plants[i](pressure) - array.play_v[i] * bulge;
          repeat.volts.push_back(o.gain * clean + dataset.noise_v[i] * normal(random));
        }
      }
      sequence.repeats.push_back(std::move(repeat));
    }
    dataset.sequences.push_back(std::move(sequence));
  }
  return dataset;
}

}  // namespace synthetic
