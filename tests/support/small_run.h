// A short run on the simulated rig, for tests of the bench: shipped bench file, tiny recipe, overrides.
#pragma once

#include <string>
#include <vector>

#include "bench/common/utc.h"
#include "bench/run/characterize.h"

namespace tactbench::tests {

// Of the text behind schema and name.
inline sequences::Recipe recipe_of(const std::string& text) {
  return sequences::parse_recipe(
      sequences::TomlDocument::from_text("schema = 1\nname = \"small\"\n" + text, "small.toml"));
}

// 0 - 8 - 2 - 8 - 0 psi in steps of 2, two repeats, one conditioning cycle: 15 frames per repeat.
inline sequences::Recipe small_recipe(const std::string& more = {}) {
  return recipe_of("unit = \"psi\"\nturning_points = [0, 8, 2, 8, 0]\nstep = 2\nrepeats = 2\n" + more +
                   "[conditioning]\ncycles = 1\npeak = 20\n");
}

// Presses a ring with 5 and 30 N in one place, after a cycle of 10 N; of the text behind the name.
inline std::string press_text(int repeats) {
  return "kind = \"press\"\ndwell_s = 0.5\nrepeats = " + std::to_string(repeats) +
         "\n[press]\nobject = \"ring\"\npositions_mm = [[30, 30]]\nforces_n = [5, 30]\nservo_mm_per_s = 0.05\n"
         "[conditioning]\ncycles = 1\npeak_n = 10\n";
}

inline bench::RunRequest small_request(const std::vector<sequences::Override>& bench_overrides = {},
                                       bench::SeedOptions seeds = {},
                                       const std::string& bench_file = "simulated.toml") {
  bench::RunRequest request;
  request.bench = bench::read_bench(bench::find_config(bench_file), bench_overrides, seeds);
  request.recipes = {small_recipe()};
  request.overrides = bench_overrides;
  const bench::SensorType type = bench::read_sensor_type(bench::find_config("sensor.toml"));
  request.sensor = {"S-1", type.name, type.text, db::sha256_hex(type.text), "SIM-SCANNER-1", "", bench::utc_now()};
  request.sensor_type = type;
  request.operator_name = "test";
  request.check_seating = false;  // its exchanges and scans would move what the tests count; whole_run_wire.cpp has it
  return request;
}

// From `at_s` of the run's time on.
inline bench::PlannedFault planned_fault(bench::FaultKind kind, double at_s, double lasts_s, double value) {
  bench::PlannedFault fault;
  fault.kind = kind;
  fault.at_s = at_s;
  fault.lasts_s = lasts_s;
  fault.value = value;
  return fault;
}

inline bench::RunResult run_small(const bench::RunRequest& request, db::RunStore& store) {
  if (!store.sensor(request.sensor.serial)) store.add_sensor(request.sensor);
  bench::Progress progress(bench::Progress::Mode::kQuiet);
  return bench::characterize(request, store, progress);
}

}  // namespace tactbench::tests
