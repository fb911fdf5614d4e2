// Which specimen it is, and of the harsh one and the foam their seeds, truth and memory.
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "bench/config/config.h"
#include "bench/simulation/plant.h"
#include "tests/bench/config/bench_text.h"
#include "tests/bench/simulation/harsh_sensor.h"

namespace tactbench::bench::testing {
namespace {

using namespace std::chrono_literals;

// Counts of scans at some levels, one after the other.
std::vector<std::uint16_t> scanned(const PlantOptions& options) {
  devices::TurnedClock clock;
  Plant plant(options, clock);
  std::vector<std::uint16_t> all, counts(256);
  std::vector<std::uint8_t> status(16);
  for (const double psi : {8.0, 60.0, 12.0, 0.0, 33.0}) {
    plant.drive(devices::Volts(psi / options.chamber.span_psi * 10.0), devices::Nanoseconds::max(),
                devices::Volts(0.0));
    clock.wait_until(clock.now() + 20s);
    plant.scan(counts, status);
    all.insert(all.end(), counts.begin(), counts.end());
  }
  return all;
}

}  // namespace

TEST_CASE("harsh specimen: same seeds, same scans, and either seed changes them") {
  const std::vector<std::uint16_t> one = scanned(harsh_plant(11, 1));
  CHECK(scanned(harsh_plant(11, 1)) == one);
  CHECK(scanned(harsh_plant(11, 2)) != one);
  CHECK(scanned(harsh_plant(12, 1)) != one);
}

TEST_CASE(
    "foam: same seeds, same scans, and the sensor's seed changes what is scanned, the run's seed only its noise") {
  const auto of = [](std::uint64_t sensor, std::uint64_t run) {
    PlantOptions options = harsh_plant(sensor, run);
    options.specimen.kind = SpecimenKind::kFoam;
    return options;
  };
  const std::vector<std::uint16_t> one = scanned(of(11, 1)), noisy = scanned(of(11, 2));
  CHECK(scanned(of(11, 1)) == one);
  CHECK(noisy != one);
  CHECK(scanned(of(12, 1)) != one);
  const double ten_deviations = 10.0 * of(11, 1).scanner.noise_v / of(11, 1).scanner.volts_per_count;
  for (std::size_t i = 0; i < one.size(); ++i) REQUIRE(std::abs(noisy[i] - one[i]) < ten_deviations);
}

TEST_CASE("harsh specimen: the plant reports the true output without noise, and the query changes nothing") {
  const PlantOptions options = harsh_plant(21, 3);
  devices::TurnedClock clock, other_clock;
  Plant plant(options, clock), asked(options, other_clock);
  for (int k = 1; k <= 20; ++k) {
    other_clock.wait_until(std::chrono::seconds(k));
    const std::vector<double> truth = asked.true_output();
    CHECK(asked.true_output() == truth);
    CHECK(truth.size() == 256);
  }
  clock.wait_until(20s);
  CHECK(plant.true_output() == asked.true_output());
  CHECK(plant.specimen_state() == asked.specimen_state());
  // The mean of many scans at one moment is the truth but for the film's slow noise, 0.3 % of the output at most.
  plant.drive(devices::Volts(30.0 / options.chamber.span_psi * 10.0), devices::Nanoseconds::max(), devices::Volts(0.0));
  clock.wait_until(60s);
  const std::vector<double> truth = plant.true_output();
  std::vector<double> sum(256);
  std::vector<std::uint16_t> counts(256);
  std::vector<std::uint8_t> status(16);
  for (int k = 0; k < 400; ++k) {
    plant.scan(counts, status);
    for (std::size_t i = 0; i < 256; ++i) sum[i] += counts[i] * options.scanner.volts_per_count / 400.0;
  }
  for (std::size_t i = 0; i < 256; ++i) REQUIRE(sum[i] == Approx(truth[i]).epsilon(0.006).margin(0.0005));
}

TEST_CASE("specimen: its memory is restored from text, only in a specimen of that kind and sensor") {
  const bool foam = GENERATE(false, true);
  const auto sensor = foam ? foam_sensor : harsh_sensor;
  Specimen one(sensor(31, 1)), other(sensor(31, 1));
  for (const double psi : {20.0, 60.0, 35.0}) one.advance(psi, 7.0);
  other.set_state(one.state());
  CHECK(other.state() == one.state());
  for (Specimen* specimen : {&one, &other}) {
    for (const double psi : {0.0, 44.0, 10.0}) specimen->advance(psi, 40.0);
  }
  std::vector<double> a(256), b(256), ahead(256);
  one.output(a);
  other.output(b);
  CHECK(a == b);
  one.output_after(30.0, 2.0, ahead);
  one.output(b);
  CHECK(a == b);
  other.advance(30.0, 2.0);
  other.output(b);
  CHECK(ahead == b);
  Specimen paper(paper_sensor(31)), third(foam ? harsh_sensor(31) : foam_sensor(31)), wrong(sensor(32, 1));
  for (Specimen* specimen : {&paper, &third, &wrong}) {
    CHECK_THROWS_AS(specimen->set_state(one.state()), std::invalid_argument);
    CHECK_THROWS_AS(one.set_state(specimen->state()), std::invalid_argument);
  }
  if (foam) {
    auto json = nlohmann::json::parse(one.state());
    json["foam"]["taxels"][7]["strain"] = 1.5;
    CHECK_THROWS_WITH(one.set_state(json.dump()), Catch::Contains("strain"));
    json = nlohmann::json::parse(one.state());
    json["foam"]["taxels"].erase(0);
    CHECK_THROWS_WITH(one.set_state(json.dump()), Catch::Contains("foam"));
    return;
  }
  for (const char* key : {"load_psi", "sliding", "drag_psi", "zero_walk_v", "gain_walk"}) {
    auto json = nlohmann::json::parse(one.state());
    json["harsh"][key].erase(0);
    CHECK_THROWS_WITH(one.set_state(json.dump()), Catch::Contains(key));
  }
}

TEST_CASE("specimen: chosen by its word, an unknown one is an error that names the nearest") {
  const auto kind_of = [](const std::vector<sequences::Override>& overrides) {
    return read_bench(find_config("simulated.toml"), overrides).simulation->plant.specimen.kind;
  };
  CHECK(kind_of({}) == SpecimenKind::kPaper);
  CHECK(kind_of({{"simulation.specimen", "harsh"}}) == SpecimenKind::kHarsh);
  CHECK(kind_of({{"simulation.specimen", "paper"}}) == SpecimenKind::kPaper);
  CHECK(kind_of({{"simulation.specimen", "foam"}}) == SpecimenKind::kFoam);
  const tests::Refusal harch = tests::refusal_of(tests::bench_text("simulated"), {{"simulation.specimen", "harch"}});
  CHECK_THAT(harch.remedy, Catch::Contains("harsh") && !Catch::Contains("paper"));
}

}  // namespace tactbench::bench::testing
