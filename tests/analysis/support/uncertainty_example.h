// A small synthetic array, and a run's record whose reference has a certificate.
#pragma once

#include <algorithm>
#include <catch2/catch.hpp>
#include <string>

#include "analysis/statistics/uncertainty/uncertainty.h"
#include "tests/analysis/support/synthetic.h"

namespace uncertainty_example {

using namespace tactbench;
using namespace tactbench::analysis;

// A run's record with a reference that has a certificate.
inline db::RunRecord record_with_reference(const std::string& reference, const std::string& due = "2027-01-31") {
  db::RunRecord run;
  run.origin = "simulated";
  run.started_utc = "2026-05-06T07:08:09Z";
  run.devices = {
      {"analog module", "M", "1", "", "simulated",
       R"({"input_volts":{"raw_low":0,"raw_high":32000,"low":0,"high":10}})"},
      {"pressure reference", "P", "2", "", "simulated",
       R"({"volts_low":0,"volts_high":10,"psi_low":0,"psi_high":100,"independent":true,"certificate":"C-1","due":")" +
           due + "\"" + reference + "}"},
      {"tactile scanner", "T", "3", "", "simulated", R"({"volts_per_count":7.62951094834821e-05})"}};
  return run;
}

inline constexpr const char* kWithCertificate =
    R"(,"drift_psi":0.05,"correction":{"reading_psi":[0,60],"correction_psi":[0,0],)"
    R"("expanded_uncertainty_psi":[0.04,0.16],"coverage_factor":2})";

struct Example {
  Dataset dataset;
  SensorModel fit;
  explicit Example(double noise_v = 0.0015, int columns = 3) {
    const synthetic::Array array({.rows = 1, .columns = columns, .sensor_seed = 4});
    dataset = synthetic::run(array, {.seed = 9, .noise_v = noise_v, .repeats = 3});
    dataset.scans = 2;
    fit = fit_array(dataset);
  }
};

inline const Contribution* row_of(const Budget& budget, UncertaintySource source) {
  const auto found = std::ranges::find(budget.contributions, source, &Contribution::source);
  return found == budget.contributions.end() ? nullptr : &*found;
}

// One that has to be there.
inline const Contribution& known_row(const Budget& budget, UncertaintySource source) {
  const Contribution* const row = row_of(budget, source);
  REQUIRE(row != nullptr);
  return *row;
}

}  // namespace uncertainty_example
