// What of lag and creep a sensor's model undoes.
#include <array>
#include <catch2/catch.hpp>
#include <string>

#include "analysis/identify/dynamic/dynamic_alone.h"

using namespace tactbench::analysis;

TEST_CASE("what of lag and creep a dynamic model undoes", "[dynamic]") {
  const auto with = [](std::array<double, 3> creep, double lag) {
    SensorDynamics dynamics;
    dynamics.shared.creep_share = creep;
    dynamics.shared.lag_share = lag;
    return std::string(undoes_creep(dynamics) ? "c" : "-") + (undoes_lag(dynamics) ? "l" : "-") +
           (in_time(dynamics) ? "t" : "-") + (creep_of_fitted_run(dynamics) ? "o" : "-");
  };
  CHECK(with({0, 0, 0}, 0) == "----");
  CHECK(with({0, 0, 0}, 0.1) == "-lt-");
  CHECK(with({0, 0, 0.1}, 0) == "c-t-");
  CHECK(with({0.1, 0.1, 0.1}, 0) == "c-to");
  CHECK(with({0.1, 0.1, 0.2}, 0.1) == "clt-");
}
