// Carries out one scenario of a suite through the real drivers and holds what came out against what had to.
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "bench/nightly/suite.h"

namespace tactbench::bench {

struct ScenarioRun {
  std::int64_t run = 0;
  std::string outcome, error, safe, content_sha256;  // error: identifier, empty where none
};

struct ScenarioResult {
  std::string name, about;           // name: the scenario's label
  std::vector<std::string> wrong;    // what did not come out as it had to, a line each; empty: green
  std::vector<std::string> remarks;  // what is to be known though nothing is wrong: drifts
  std::string compared;              // with the last night with the same seed; empty: not asked
  std::vector<ScenarioRun> runs;
  std::map<std::string, double> figures;           // of what was judged; unit in the name
  std::map<std::string, std::string> verdicts;     // criterion, "mismatch 40 psi up", "overall" -> word
  std::map<std::string, std::vector<int>> taxels;  // status -> taxels that are not fitted
  double seconds = 0.0;                            // real time
};

// `store`: the file the runs go to, made. Never throws for what the rig does; Error and FileError for a scenario that
// asks for what does not exist.
ScenarioResult carry_out(const Scenario& scenario, const std::string& store);

// Whether `store` is a file that carry_out() left, whole or not: all in it is a scenario's, and nobody tagged or noted
// anything, as keep_night() does.
bool is_scenario_store(const std::string& store);

// Lines about where `result` differs from what `scenario` says must come out.
std::vector<std::string> differences(const Scenario& scenario, const ScenarioResult& result);

// As JSON text in one line, and back: a scenario runs in a process of its own. Throws std::invalid_argument.
std::string to_json(const ScenarioResult& result);
ScenarioResult result_from_json(const std::string& text);

}  // namespace tactbench::bench
