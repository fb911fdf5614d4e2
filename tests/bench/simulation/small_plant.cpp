#include "tests/bench/simulation/small_plant.h"

#include <nlohmann/json.hpp>
#include <numeric>

namespace tactbench::tests {

void SmallPlant::check_film(const std::vector<double>& expected) {
  const auto state = nlohmann::json::parse(plant.specimen_state());
  std::vector<double> found;
  for (const char* key : {"pressure_psi", "lag_psi", "virgin", "travel_psi"}) found.push_back(state[key].get<double>());
  for (const char* key : {"plays", "creep"}) {
    for (const auto& each : state[key].get<std::vector<std::vector<double>>>())
      found.push_back(std::accumulate(each.begin(), each.end(), 0.0));
  }
  REQUIRE(found.size() == expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    INFO("number " << i);
    CHECK(found[i] == Approx(expected[i]).epsilon(1e-9).margin(1e-12));
  }
}

}  // namespace tactbench::tests
