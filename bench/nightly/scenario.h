// Carries out one scenario of a suite through the real drivers and compares the result with the expectations.
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "bench/nightly/suite.h"

namespace tactbench::bench {

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
