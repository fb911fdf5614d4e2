// One model of each kind, to test the properties that all of them share.
#pragma once

#include <memory>
#include <random>
#include <vector>

#include "analysis/models/gpi.h"
#include "analysis/models/monotone.h"
#include "analysis/models/mpi.h"
#include "analysis/models/poly.h"
#include "analysis/models/preisach.h"

namespace synthetic {

using namespace tactbench::analysis;

// As printed, but Table 2 with its rotation by one place undone (docs/elam-readings.md, Misprints).
inline const GpiParameters kGpiTable2{.a0 = 0.5754,
                                      .a1 = 0.0524,
                                      .a2 = 1.1216,
                                      .a3 = 1.6350,
                                      .b0 = 13.0421,
                                      .b1 = 0.0825,
                                      .b2 = -1.9648,
                                      .b3 = 1.5428,
                                      .alpha = 0.2972,
                                      .rho = 1.7531,
                                      .tau = 4.4935};
inline const GpiParameters kGpiTable3{.a0 = 1.9620,
                                      .a1 = 0.0477,
                                      .a2 = -0.1324,
                                      .a3 = 3.7234,
                                      .b0 = 1.6743,
                                      .b1 = 0.1168,
                                      .b2 = -0.1206,
                                      .b3 = -3.2440,
                                      .alpha = 3.4384,
                                      .rho = 0.8893,
                                      .tau = -0.1617};
inline const MpiParameters kRisingMpi{.a1 = 0.06, .a2 = -6e-4, .a3 = 4e-6, .rho = 2.0, .tau = 0.3};
// As fitted to the descending set.
inline const MpiParameters kWaveringMpi{.a1 = 0.1319, .a2 = -0.00463, .a3 = 3.645e-5, .rho = 35.37, .tau = 1.62};

// Of t = (x - x_low) / 60; y 0..3.49.
inline PolyModel poly_of(const std::array<double, 6>& up, const std::array<double, 6>& down, double x_low = 0.0) {
  PolyParameters p;
  double power = 1.0;
  for (std::size_t k = 0; k < 6; ++k) {
    power *= 60.0;
    p.a[5 - k] = 3.49 * up[k] / power;
    p.b[5 - k] = 3.49 * down[k] / power;
  }
  return {p, x_low, x_low + 60.0, 0.0, 3.49};
}
inline PolyModel rising_poly() { return poly_of({1.6, -1.0, 0.5, -0.2, 0.06, 0.04}, {2.2, -1.9, 0.6, 0.2, -0.1, 0.0}); }
inline PolyModel wavering_poly() { return poly_of({1.6, -1.0, 0.5, -0.2, 0.06, 0.04}, {4.0, -6.5, 3.5, 0, 0, 0}); }

inline PreisachModel random_preisach(unsigned seed = 3, std::size_t n = 30, double low = 0.0) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform;
  std::vector<double> weights;
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j <= i; ++j)
      weights.push_back(i == j ? 0.02 : uniform(random) < 0.7 ? 0.0 : 0.02 * uniform(random));
  return {low, low + 60.0, 0.1, weights};
}

inline std::vector<std::unique_ptr<HysteresisModel>> rising_models() {
  std::vector<std::unique_ptr<HysteresisModel>> models;
  models.push_back(std::make_unique<GpiModel>(kGpiTable2, 0.0, 60.0, 0.0));
  models.push_back(std::make_unique<GpiModel>(kGpiTable3, 0.0, 60.0, 0.0));
  models.push_back(std::make_unique<MpiModel>(kRisingMpi, 0.0, 60.0, 0.0));
  models.push_back(std::make_unique<MpiModel>(kRisingMpi, 5.0, 65.0, 0.4));
  models.push_back(std::make_unique<PolyModel>(rising_poly()));
  models.push_back(std::make_unique<PreisachModel>(random_preisach()));
  models.push_back(std::make_unique<PreisachModel>(random_preisach(4, 7, -20.0)));
  const std::vector<double> x{0, 10, 30, 60}, y{0.0, 1.5, 2.8, 3.49};
  models.push_back(std::make_unique<MonotoneModel>(PatternCurve(x, y, 0.0, 3.49)));
  return models;
}

// Their output falls in places where the input rises.
inline std::vector<std::unique_ptr<HysteresisModel>> wavering_models() {
  std::vector<std::unique_ptr<HysteresisModel>> models;
  models.push_back(std::make_unique<MpiModel>(kWaveringMpi, 0.0, 60.0, 0.0));
  models.push_back(std::make_unique<PolyModel>(wavering_poly()));
  return models;
}

}  // namespace synthetic
