// The nightly suite: scenarios on the simulated rig, each with its expected result. Read from a TOML file; unknown keys
// are errors. sequences/nightly.toml is the shipped suite and explains the keys.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bench/common/shard.h"
#include "sequences/toml/strict_toml.h"

namespace tactbench::bench {

struct Scenario {
  std::string name, about;  // name: letters, digits and hyphens; unique in its suite
  std::string label;        // the name, followed by the seed if there are several
  std::string bench = "simulated.toml";
  std::vector<std::string> recipes;  // names of shipped recipes, or files
  std::vector<std::string> set;      // as the option --set of the verb run
  // Held-out runs, each with overrides in addition to `set`; all are judged, and the worst one counts.
  std::vector<std::vector<std::string>> held_out;
  bool void_held_out = false;  // the first of them is declared void before anything is judged
  bool own_run = false;        // judges the figures of the fitted run itself: this is not a verdict on the sensor
  bool fits = true;            // the runs are fitted and judged
  bool dynamic = false;        // by dynamic models, as calibrate does; else by ELAM
  std::string limits = "nightly-limits.toml";  // for the verdicts
  std::uint64_t seed = 1, sensor_seed = 1;

  // Expectations.
  std::string outcome = "completed";  // outcome of the last run
  std::string error;                  // identifier of the error; empty: none
  std::string safe = "verified";
  std::map<std::string, std::vector<int>> taxels;  // status -> exactly these taxels, row-major from 0; absent: none
  std::map<std::string, std::string>
      verdicts;  // criterion -> worst word; "mismatch" applies to each of its scopes; "overall"
  std::map<std::string, std::pair<double, double>> figures;  // name -> [low, high]
};

struct Suite {
  std::string name, file;
  std::string text;                 // of the file
  std::vector<Scenario> scenarios;  // at least one
};

// Throws FileError, with file, line and key.
Suite read_suite(const std::string& path);
Suite parse_suite(const std::string& text, const std::string& file);
std::vector<sequences::KeyFacts> suite_keys();

// Each scenario `seeds` times, with its own seed and the following ones; labels "NAME-seed-S".
Suite with_seeds(const Suite& suite, int seeds);

// Which scenarios of a suite a night carries out, and with which seeds.
struct Selection {
  std::vector<std::string> only;      // only these scenarios; empty: all
  std::optional<std::uint64_t> seed;  // instead of the scenarios' own
  int seeds = 1;
};
// In the suite's order. Throws Error TB-NIGHTLY-SCENARIO if a named scenario does not exist.
Suite selected(Suite suite, const Selection& selection);
// As JSON text in one line, and back. Throws std::invalid_argument.
std::string to_json(const Selection& selection);
Selection selection_from_json(const std::string& text);
// The part of a night's scenarios that one of several machines carries out, in the order of the whole.
Suite part_of(const Suite& whole, const Shard& shard);

// Carries out one scenario of a suite through the real drivers and compares the result with the expectations.
struct ScenarioRun {
  std::int64_t run = 0;
  std::string outcome, error, safe, content_sha256;  // error: identifier, empty if there is none
};

struct ScenarioResult {
  std::string name, about;           // name: the scenario's label
  std::vector<std::string> wrong;    // one line per unmet expectation; empty: green
  std::vector<std::string> remarks;  // remarks that are not failures: changes and shifts
  std::string compared;              // comparison with the last night with the same seed; empty: none
  std::vector<ScenarioRun> runs;
  std::map<std::string, double> figures;           // of the judged run; unit in the name
  std::map<std::string, std::string> verdicts;     // criterion, "mismatch 40 psi up", "overall" -> word
  std::map<std::string, std::vector<int>> taxels;  // status -> taxels that are not fitted
  double seconds = 0.0;                            // real time
};

// `store`: the file to make for the runs. Faults of the rig do not throw; throws Error and FileError for a scenario
// that names something that does not exist.
ScenarioResult carry_out(const Scenario& scenario, const std::string& store);

// Whether carry_out() made `store`, complete or not: it holds only a scenario's runs, without tags and notes by people
// or by store_night().
bool is_scenario_store(const std::string& store);

// One line per difference between `result` and the expectations of `scenario`.
std::vector<std::string> differences(const Scenario& scenario, const ScenarioResult& result);

// To JSON text in one line, and back: a scenario runs in a separate process. Throws std::invalid_argument.
std::string to_json(const ScenarioResult& result);
ScenarioResult result_from_json(const std::string& text);

}  // namespace tactbench::bench
