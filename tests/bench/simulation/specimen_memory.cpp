// The specimen's memory as text, and its shapes.
#include <catch2/catch.hpp>
#include <functional>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <utility>

#include "tests/bench/simulation/specimen_runs.h"

namespace tactbench::bench::testing {

TEST_CASE("specimen: the memory goes through text to the last bit") {
  Specimen first({});
  Walker walker(first);
  walker.walk({60, 14, 36});
  Specimen second({});
  second.set_state(first.state());
  CHECK(second.state() == first.state());
  CHECK(Walker(second).frame() == walker.frame());
  for (const double pressure : {37.0, 20.0, 45.5, 3.0}) {
    first.advance(pressure, 0.7);
    second.advance(pressure, 0.7);
  }
  CHECK(Walker(second).frame() == Walker(first).frame());
}

TEST_CASE(
    "specimen: a state of another array, another program or with a value that is none is refused and changes nothing") {
  SpecimenOptions options;
  options.rows = 2;
  options.columns = 3;
  Specimen specimen(options);
  specimen.advance(10.0, 1.0);
  const auto state = nlohmann::json::parse(specimen.state());
  for (const std::string& text : {std::string(), std::string("{}"), state.dump().substr(0, state.dump().size() / 2)})
    CHECK_THROWS_AS(specimen.set_state(text), std::invalid_argument);
  const auto accepts = [&](const std::function<void(nlohmann::json&)>& change) {
    nlohmann::json changed = state;
    change(changed);
    try {
      specimen.set_state(changed.dump());
    } catch (const std::invalid_argument&) {
      CHECK(nlohmann::json::parse(specimen.state()) == state);
      return false;
    }
    return true;
  };
  CHECK(accepts([](auto&) {}));
  CHECK_FALSE(accepts([](auto& json) { json["format"] = "other"; }));
  CHECK_FALSE(accepts([](auto& json) { json["version"] = 2; }));
  CHECK_FALSE(accepts([](auto& json) { json["sensor_seed"] = 2; }));
  CHECK_FALSE(accepts([](auto& json) { json["rows"] = 3; }));
  CHECK_FALSE(accepts([](auto& json) { json["columns"] = 2; }));
  CHECK_FALSE(accepts([](auto& json) { json["virgin"] = nullptr; }));
  CHECK_FALSE(accepts([](auto& json) { json["plays"].erase(5); }));
  CHECK_FALSE(accepts([](auto& json) { json["creep"].push_back(json["creep"][0]); }));
  CHECK_FALSE(accepts([](auto& json) { json["plays"][2].push_back(1.0); }));
  CHECK_FALSE(accepts([](auto& json) { json["creep"][2].erase(0); }));
  CHECK_FALSE(accepts([](auto& json) { json["plays"][2][5] = -1e-12; }));
  CHECK(accepts([](auto& json) { json["plays"][2][5] = 0.0; }));
  CHECK(accepts([](auto& json) { json["travel_psi"] = 77.0; }));
  CHECK(nlohmann::json::parse(specimen.state())["travel_psi"] == 77.0);
}

TEST_CASE("specimen: other shapes of array work") {
  for (const auto& [rows, columns] : {std::pair{1, 1}, {1, 6}, {6, 1}, {3, 5}, {32, 16}}) {
    SpecimenOptions options;
    options.rows = rows;
    options.columns = columns;
    options.effects.row_crosstalk = 0.01;
    options.effects.chamber_nonuniformity = 0.02;
    Specimen specimen(options);
    Walker walker(specimen);
    walker.walk({30});
    const Frame frame = walker.frame();
    CHECK(mean(frame) > 1.0);
    CHECK(mean(frame) < 4.9);
  }
}

}  // namespace tactbench::bench::testing
