// Errors of the simulated instruments in numbers, as they were recorded: of all that is drawn at once, and of each part
// alone. A deliberate change of the draws changes them.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <catch2/catch.hpp>
#include <functional>
#include <string>
#include <vector>

#include "bench/simulation/instrument_errors.h"

using namespace tactbench::bench;

namespace {

InstrumentOptions drawn(const std::function<void(InstrumentOptions&)>& state, std::uint64_t seed = 5) {
  InstrumentOptions options;
  options.seed = seed;
  state(options);
  return options;
}

// The reference's error in psi on the way up, at the turn and down, warm and cold, beyond the certificate's levels;
// then the force sensor's at 10 N and the thermometer's.
std::string errors_in_numbers(const InstrumentOptions& options) {
  InstrumentErrors errors(options);
  std::vector<double> values;
  for (const double psi : {0.0, 2.0, 10.0, 25.0, 45.0, 60.0, 70.0, 69.0, 66.5, 30.0, 12.0, -1.0}) {
    errors.follow(psi);
    values.push_back(errors.reference_psi(psi, 23.0));
  }
  errors.follow(30.0);
  for (const double celsius : {15.0, 20.0, 25.5, 40.0}) values.push_back(errors.reference_psi(30.0, celsius));
  values.push_back(errors.force_n(10.0));
  values.push_back(errors.thermometer_c());
  return fmt::format("{:.5f}", fmt::join(values, " "));
}

void check_numbers_of(const std::vector<std::string>& said, const std::string& expected) {
  std::string all = "\n";
  for (const std::string& line : said) all += line + "\n";
  CHECK(all == expected);
}

}  // namespace

TEST_CASE("instrument numbers: each part of the errors alone, and all of them, for two seeds") {
  const auto certificate = [](InstrumentOptions& o) {
    o.reading_psi = {10.0, 30.0, 60.0};
    o.certificate_u_psi = {0.1, 0.3, 0.2};
  };
  const auto chain = [](InstrumentOptions& o) {
    o.reference.drift = 0.4;
    o.reference.input = 0.2;
    o.zero_psi = 0.1;
  };
  const auto hysteresis = [](InstrumentOptions& o) { o.hysteresis_psi = 0.5; };
  const auto temperature = [](InstrumentOptions& o) { o.temperature_psi = 0.5; };
  const auto others = [](InstrumentOptions& o) {
    o.force_n.certificate_u = 0.7;
    o.force_n.drift = 0.35;
    o.force_n.input = 0.2;
    o.thermometer_c.certificate_u = 0.3;
    o.thermometer_c.drift = 0.2;
    o.thermometer_c.input = 0.1;
  };
  const auto all = [&](InstrumentOptions& o) {
    certificate(o);
    chain(o);
    hysteresis(o);
    temperature(o);
    others(o);
  };
  check_numbers_of(
      {"certificate " + errors_in_numbers(drawn(certificate)), "chain " + errors_in_numbers(drawn(chain)),
       "hysteresis " + errors_in_numbers(drawn(hysteresis)), "temperature " + errors_in_numbers(drawn(temperature)),
       "others " + errors_in_numbers(drawn(others)), "all " + errors_in_numbers(drawn(all)),
       "all of seed 6 " + errors_in_numbers(drawn(all, 6)), "no seed " + errors_in_numbers(drawn(all, 0))},
      R"(
certificate -0.03946 -0.04341 -0.06130 -0.24778 -0.30460 -0.23056 -0.23056 -0.23056 -0.23056 -0.32824 -0.07948 -0.03946 -0.32824 -0.32824 -0.32824 -0.32824 0.00000 -0.00000
chain 0.05194 0.05194 0.05194 0.05194 0.05194 0.05194 0.05194 0.05194 0.05194 0.05194 0.05194 0.05194 0.05194 0.05194 0.05194 0.05194 0.00000 -0.00000
hysteresis 0.00000 -0.31488 -0.47232 -0.47232 -0.47232 -0.47232 -0.47232 -0.31488 0.07872 0.47232 0.47232 0.47232 -0.47232 -0.47232 -0.47232 -0.47232 0.00000 -0.00000
temperature 0.00000 0.00000 0.00000 0.00000 0.00000 0.00000 0.00000 0.00000 0.00000 0.00000 0.00000 0.00000 -0.19805 -0.11883 0.09903 0.19805 0.00000 -0.00000
others 0.00000 0.00000 0.00000 0.00000 0.00000 0.00000 0.00000 0.00000 0.00000 0.00000 0.00000 0.00000 0.00000 0.00000 0.00000 0.00000 0.08953 -0.22962
all 0.01248 -0.30635 -0.48169 -0.66816 -0.72499 -0.65094 -0.65094 -0.49350 -0.09990 0.19602 0.44478 0.48480 -0.94668 -0.86746 -0.64960 -0.55057 0.08953 -0.22962
all of seed 6 0.18004 0.12795 0.12661 0.11225 0.48194 0.57661 0.57661 0.60524 0.67681 0.36572 0.27767 0.26593 0.38164 0.30656 0.10009 0.00624 0.34711 -0.16511
no seed 0.00000 0.00000 0.00000 0.00000 0.00000 0.00000 0.00000 0.00000 0.00000 0.00000 0.00000 0.00000 0.00000 0.00000 0.00000 0.00000 0.00000 0.00000
)");
}
