// The study of compensated pressures: its sums by hand, its histories by what they promise, and one small study.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>

#include "tests/benchmarks/study/compensation.h"
#include "tests/benchmarks/study/histories.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::bench;

TEST_CASE("errors of a study: quantiles, coverage and width are those of the samples") {
  StudiedErrors errors;
  for (int i = 1; i <= 100; ++i) {
    analysis::Compensated now;
    now.uncertainty_psi = i <= 60 ? 0.5 * i : 0.1;  // 2 u: as large as the error, or 0.2 psi
    now.flat = i % 10 == 0;
    errors.add(i, now);
  }
  CHECK(errors.error().mean() == Approx(50.5));
  CHECK(errors.quantile(0.95) == Approx(95.0).margin(0.03));
  CHECK(errors.covered() == Approx(0.6));
  CHECK(errors.width() == Approx((60 * 61 / 2 + 40 * 0.2) / 100));
  CHECK(errors.quantile(errors.covered()) == Approx(60.0).margin(0.03));
  CHECK(errors.flat() == Approx(0.1));
}

TEST_CASE("a route names what is fitted, runs for lag and creep, and settings of the first run") {
  const Route route = route_of("mine=a+b.toml:rate:creep-levels,recipe.repeats=2,recipe.dwell_s=1");
  CHECK(route.name == "mine");
  REQUIRE(route.runs.size() == 3);
  CHECK(route.runs[0].recipes == std::vector<std::string>{"a", "b.toml"});
  CHECK(route.runs[0].set == std::vector<std::string>{"recipe.repeats=2", "recipe.dwell_s=1"});
  CHECK(route.runs[2].recipes == std::vector<std::string>{"creep-levels"});
  CHECK(route.runs[2].set.empty());
  CHECK_THROWS_AS(route_of("production"), std::invalid_argument);
}

TEST_CASE("histories keep to the pressures that their names promise, and begin at rest unless they say otherwise") {
  const std::vector<std::size_t> taxels = {0, 100};
  const PlantOptions plant = simulated_request({{}, {}}, {SpecimenKind::kHarsh, 7}, 1).bench.simulation->plant;
  for (const HistoryKind& kind : history_kinds()) {
    INFO(kind.name);
    const Recording made = record(kind, plant, 5, taxels);
    REQUIRE(made.psi.size() > 100);
    REQUIRE(made.seconds.size() == made.psi.size());
    REQUIRE(made.volts.size() == taxels.size() * made.psi.size());
    const double highest = *std::ranges::max_element(made.psi);
    CHECK(highest < kind.conditioned_psi + 0.5);
    CHECK((made.psi.front() < 0.1) != kind.unknown_start);
    CHECK(std::ranges::all_of(made.seconds, [](double s) { return s >= 0.0 && s < 61.0; }));
    if (std::string(kind.name).ends_with("0 to 20 psi")) CHECK(highest == Approx(20.0).margin(0.5));
    const Recording again = record(kind, plant, 5, taxels), other = record(kind, plant, 6, taxels);
    CHECK(again.volts == made.volts);
    CHECK(other.volts != made.volts);
  }
}

TEST_CASE("a small study has errors of every kind, the way that calibrate goes first, and nothing twice") {
  const tests::TemporaryFolder folder;
  CompensationOptions options;
  options.seed = "1";
  options.specimens = {"paper"};
  options.models = {"dynamic", "monotone"};
  options.routes = {"the same=production"};
  options.sensors = 1;
  options.every = 64;
  const CompensationStudy study = study_compensation(options, folder.path());
  REQUIRE(study.errors.size() == 2);
  const RouteErrors &dynamic = study.errors[0], &curve = study.errors[1];
  CHECK((dynamic.route == "default" && dynamic.model == "dynamic" && curve.model == "monotone"));
  CHECK((dynamic.minutes > 5.0 && dynamic.minutes < 30.0));
  for (std::size_t k = 0; k < dynamic.kinds.size(); ++k) {
    INFO(history_kinds()[k].name);
    CHECK(dynamic.kinds[k].error().samples > 200);
    CHECK(dynamic.kinds[k].error().samples == curve.kinds[k].error().samples);
    CHECK(dynamic.kinds[k].quantile(0.95) <= dynamic.kinds[k].error().max + 0.02);
    CHECK((dynamic.kinds[k].unknown() > 0.0) == history_kinds()[k].unknown_start);
    CHECK(dynamic.worst() >= (history_kinds()[k].known_here() ? dynamic.kinds[k].error().mean() : 0.0));
  }
  CHECK(dynamic.mean() < 0.5 * curve.mean());  // history is most of the error
  const auto kept = nlohmann::json::parse(json_of(study));
  CHECK(kept["seed"] == study.seed);
  CHECK(kept["errors"][0]["kinds"]["grasps"]["mean"].get<double>() < 3.0);
}
