#include "tests/benchmarks/study/simulated_run.h"

#include <fmt/format.h>

#include <stdexcept>

#include "bench/common/overrides.h"
#include "bench/common/utc.h"
#include "bench/rig/rig.h"
#include "bench/run/characterize.h"
#include "bench/run/recipe_check.h"
#include "bench/simulation/plant.h"

namespace tactbench::bench {

namespace {

std::size_t frames_of(const analysis::Dataset& data) {
  std::size_t frames = 0;
  for (const analysis::SequenceData& sequence : data.sequences)
    for (const analysis::Repeat& repeat : sequence.repeats) frames += repeat.steps.size();
  return frames;
}

}  // namespace

RunRequest simulated_request(const SimulatedRun& run, const SimulatedSensor& sensor, unsigned noise_seed) {
  std::vector<std::string> set = run.set;
  if (sensor.kind != SpecimenKind::kPaper) set.push_back("simulation.specimen=" + keyword_of(sensor.kind));
  const SplitOverrides overrides = split_overrides(set);
  RunRequest request;
  request.bench = read_bench(find_config("simulated.toml"), overrides.bench, {noise_seed, sensor.seed});
  request.recipes = read_recipes(run.recipes, overrides.recipe);
  request.overrides = overrides.all;
  SensorType& type = request.sensor_type = read_sensor_type(find_config("sensor.toml"));
  type.rows = request.bench.scanner.rows;
  type.columns = request.bench.scanner.columns;
  request.sensor = {fmt::format("SIM-{:04}", sensor.seed), type.name, type.text, db::sha256_hex(type.text),
                    SimulationConfig().scanner_serial,     "",        utc_now()};
  request.operator_name = "benchmark";
  request.check_seating = false;
  return request;
}

RunRequest descending_request(int repeats, unsigned noise_seed) {
  return simulated_request(
      {{"descending"},
       {fmt::format("recipe.repeats={}", repeats), "recipe.conditioning.cycles=0", "recipe.conditioning.least=0"}},
      {}, noise_seed);
}

RunResult carry_out(const RunRequest& request, db::RunStore& store) {
  if (!store.sensor(request.sensor.serial)) store.add_sensor(request.sensor);
  Progress quiet(Progress::Mode::kQuiet);
  RunResult result = characterize(request, store, quiet);
  if (result.error) throw *result.error;
  return result;
}

KnownRun simulate_run(const SimulatedRun& run, const SimulatedSensor& sensor, unsigned noise_seed,
                      db::RunStore& store) {
  RunRequest request = simulated_request(run, sensor, noise_seed);
  // The truth of a frame is read when its step is over: nothing moves between the frame and the next step.
  KnownRun known;
  Rig* rig = nullptr;
  bool measured = false;
  const auto keep = [&] {
    if (measured && rig != nullptr) known.chamber_psi.push_back(rig->plant()->true_pressure().value());
    measured = false;
  };
  request.on_rig = [&](Rig& now, RigMoment moment) {
    rig = &now;
    if (moment == RigMoment::kTearingDown) keep();
  };
  request.on_step = [&](const sequences::Step& step) {
    keep();
    measured = step.kind == sequences::StepKind::kMeasure;
  };
  const RunResult result = carry_out(request, store);
  const std::int64_t number = result.run;
  known.process_s = result.process_seconds;
  known.data = analysis::load_dataset(store, number);
  if (frames_of(known.data) != known.chamber_psi.size())
    throw std::runtime_error(fmt::format("run {}: {} frames, and the pressure of {} is known", number,
                                         frames_of(known.data), known.chamber_psi.size()));
  return known;
}

}  // namespace tactbench::bench
