// The study of compensated pressures: its sums by hand, its histories by what they promise, and one small study.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "analysis/identify/compensators.h"
#include "analysis/identify/dynamic/dynamic_alone.h"
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

namespace {

// Of a taxel's streams along one history: as it is, with drawn spikes of one to three samples, and without those
// samples.
struct Spiked {
  double samples = 0.0, flagged = 0.0, moves = 0.0, late = 0.0;  // as it is
  double spikes = 0.0, unflagged = 0.0, others = 0.0, apart = 0.0;
};

void add_spikes(const analysis::SensorModel& model, const analysis::ModelTaxel& taxel, const HistoryKind& kind,
                const Recording& made, std::size_t k, std::size_t of, Draw& draw, Spiked& sum) {
  const double more = std::sqrt(static_cast<double>(model.scans)), full = taxel.gain * taxel.fit.full_scale;
  const double low = taxel.zero + taxel.gain * taxel.loop_low, band = 5.5 * more * taxel.noise;
  const auto clean = compensator_of(model, taxel, more), spiked = compensator_of(model, taxel, more);
  const auto without = compensator_of(model, taxel, more);
  const auto moved = compensator_of(model, taxel, more);  // as `without`, by the dead band
  for (analysis::Compensator* const stream : {clean.get(), spiked.get(), without.get(), moved.get()})
    kind.unknown_start ? stream->start(analysis::Start::kUnknown) : stream->work(made.worked_s);
  double before = 0.0, output = low, passed = 0.0;
  for (std::size_t i = 0, left = 0, next = 20; i < made.psi.size(); ++i) {
    const double last = std::exchange(output, made.volts[i * of + k]), seconds = made.seconds[i];
    const analysis::Compensated now = clean->step(output, seconds);
    const bool moves = i > 0 && std::abs(output - last) > 0.05 * full;
    sum.samples += 1.0;
    sum.flagged += now.held || now.out_of_range ? 1.0 : 0.0;
    sum.moves += moves ? 1.0 : 0.0;
    const bool at_end = now.pressure_psi <= 0.0 || now.pressure_psi >= 60.0;  // no reading lies beyond
    sum.late += moves && !at_end && std::abs(now.pressure_psi - before) < 0.2 ? 1.0 : 0.0;
    before = now.pressure_psi;
    passed += seconds;
    if (i == next) {
      left = 1 + static_cast<std::size_t>(draw.between(0.0, 2.999));
      next += 10 + static_cast<std::size_t>(draw.between(0.0, 60.0));
    }
    if (left > 0) {
      --left;
      const double by = draw.between(0.2, 3.0) * full;
      sum.spikes += 1.0;
      sum.unflagged +=
          spiked->step(draw.between(0.0, 1.0) < 0.5 ? low - by : low + full + by, seconds).out_of_range ? 0.0 : 1.0;
      continue;
    }
    const double psi = without->step(output, passed).pressure_psi;
    const double hidden = std::abs(moved->step(output + band, std::exchange(passed, 0.0)).pressure_psi - psi);
    sum.others += 1.0;
    sum.apart += std::abs(spiked->step(output, seconds).pressure_psi - psi) > std::max(0.05, hidden) ? 1.0 : 0.0;
  }
}

}  // namespace

TEST_CASE("streams of every model along every kind of history: clean samples are not flagged, spikes stay alone") {
  const tests::TemporaryFolder folder;
  const std::vector<std::size_t> taxels = {3, 119};
  for (const SpecimenKind specimen : {SpecimenKind::kPaper, SpecimenKind::kHarsh, SpecimenKind::kFoam}) {
    const SimulatedSensor sensor{specimen, 5};
    db::RunStore store = db::RunStore::open(folder.path(word_of(specimen)), db::Durability::kNormal);
    const KnownRun run = simulate_run({{"production"}, {}}, sensor, 3, store);
    // Of one pace, slow enough for models that know none: what the film creeps further is no drift to them.
    tests::write_file(
        folder.path("slow.toml"),
        "schema = 1\nname = \"slow\"\nunit = \"psi\"\nturning_points = [0, 60, 0, 40, 0, 60, 20, 60, 0]\n"
        "step = 4\ndwell_s = 1\nrepeats = 3\n[conditioning]\ncycles = 4\nleast = 2\nchange_percent = 0.5\n"
        "peak = 60\n");
    const KnownRun slow = simulate_run({{folder.path("slow.toml")}, {}}, sensor, 3, store);
    analysis::Histories histories = analysis::histories_of(slow.data);
    std::erase_if(histories.taxels, [&](const auto& taxel) {
      return std::ranges::find(taxels, static_cast<std::size_t>(taxel.taxel)) == taxels.end();
    });
    std::vector<analysis::SensorModel> models = {analysis::fit_dynamic_alone(run.data)};
    for (const char* const name : {"elam", "gpi", "mpi", "poly", "preisach", "monotone"})
      models.push_back(analysis::fit_models(name, histories, {}, {}));
    std::vector<Spiked> sums(models.size());
    Draw draw(17);
    for (const HistoryKind& kind : history_kinds()) {
      const PlantOptions plant = simulated_request({{}, kind.set}, sensor, 1).bench.simulation->plant;
      const Recording made = record(kind, plant, 77, taxels);
      for (std::size_t m = 0; m < models.size(); ++m) {
        const double flagged = sums[m].flagged, samples = sums[m].samples;
        for (std::size_t k = 0; k < taxels.size(); ++k)
          add_spikes(models[m], models[m].taxel(static_cast<int>(taxels[k])), kind, made, k, taxels.size(), draw,
                     sums[m]);
        INFO(word_of(specimen) << ", " << models[m].model << ", " << kind.name);
        CHECK(sums[m].flagged - flagged <= 0.001 * (sums[m].samples - samples));
      }
    }
    for (std::size_t m = 0; m < models.size(); ++m) {
      const Spiked& all = sums[m];
      INFO(word_of(specimen) << ", " << models[m].model << ": " << all.late << " of " << all.moves << " late, "
                             << all.unflagged << " of " << all.spikes << " not flagged, " << all.apart << " of "
                             << all.others << " apart");
      CHECK(all.moves > 1000.0);
      CHECK(all.late == 0.0);
      CHECK(all.spikes > 1000.0);
      CHECK(all.unflagged == 0.0);
      // Creep goes on at the last reading while a sample is held, which may not be the pressure.
      CHECK(all.apart <= (models[m].dynamics ? 0.04 : 0.01) * all.others);
    }
  }
}
