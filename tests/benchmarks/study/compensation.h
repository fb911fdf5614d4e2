// Distance of compensated pressures from the true ones, by what was measured for the calibration (the route), model,
// and kind of history. The route that `calibrate` uses is the first. Sensors and histories are drawn from one seed, by
// default the hash of the last commit that changed code, so that nothing can have been chosen on them.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "analysis/compensate/compensator.h"
#include "analysis/statistics/scoring/score.h"
#include "tests/benchmarks/study/simulated_run.h"

namespace tactbench::bench {

struct CompensationOptions {
  std::string seed;                    // hexadecimal; empty: of the commit
  std::vector<std::string> specimens;  // words; empty: all
  std::vector<std::string> models = {"dynamic", "elam", "gpi", "preisach", "monotone"};
  std::vector<std::string> routes;     // further ones; empty: two that are kept here
  std::vector<unsigned> sensor_seeds;  // in place of those drawn
  int sensors = 2, every = 16;         // of each specimen; which taxels
};

// Errors of many samples, psi: ErrorSum with quantiles, and with the stated uncertainty u.
class StudiedErrors {
 public:
  void add(double error, const analysis::Compensated& now);
  [[nodiscard]] const analysis::ErrorSum& error() const { return error_; }
  [[nodiscard]] double quantile(double share) const;                                     // of the errors' sizes
  [[nodiscard]] double covered() const { return covered_ / error_.samples; }             // share within 2 u
  [[nodiscard]] double width() const { return stated_ > 0.0 ? width_ / stated_ : 0.0; }  // mean 2 u
  [[nodiscard]] double unknown() const { return unknown_ / error_.samples; }
  [[nodiscard]] double flat() const { return flat_ / error_.samples; }
  [[nodiscard]] double out_of_range() const { return out_of_range_ / error_.samples; }

 private:
  analysis::ErrorSum error_;
  double covered_ = 0.0, width_ = 0.0, stated_ = 0.0, unknown_ = 0.0, flat_ = 0.0, out_of_range_ = 0.0;
  std::vector<std::uint32_t> histogram_;
};

struct Route {
  std::string name;
  std::vector<SimulatedRun> runs;  // fitted; then, where they are, those for lag and for creep, or one for both
};
// "NAME=RECIPE+RECIPE[:RATE[:CREEP]][,KEY=VALUE...]": the settings are those of the fitted run. Throws
// std::invalid_argument.
Route route_of(const std::string& text);

struct RouteErrors {  // of one model
  std::string specimen, route, model;
  int taxels = 0;                      // of all sensors, with such a model
  double minutes = 0.0;                // of process time that the route takes
  std::vector<StudiedErrors> kinds;    // in the order of history_kinds()
  [[nodiscard]] double worst() const;  // largest mean error of the kinds with a known start in one mount
  [[nodiscard]] double mean() const;   // of the kinds' mean errors
};

struct CompensationStudy {
  std::string seed, commit;  // hexadecimal; commit: empty where the seed was given
  struct Sensors {
    std::string specimen;
    std::vector<unsigned> seeds;
  };
  std::vector<Sensors> sensors;
  std::vector<std::uint64_t> draws;  // by kind
  std::vector<RouteErrors> errors;   // by specimen, route and model
};

// Runs are made in `folder`. Says on stderr how far it is. Throws std::invalid_argument for seeds and routes that are
// none, and what carrying out a run throws.
CompensationStudy study_compensation(const CompensationOptions& options, const std::string& folder);

std::string markdown_of(const CompensationStudy& study);
std::string json_of(const CompensationStudy& study);

}  // namespace tactbench::bench
