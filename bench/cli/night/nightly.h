// Results of a nightly run, from one machine or merged from several: files, printed output, exit code.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "bench/cli/session.h"
#include "bench/nightly/night.h"
#include "bench/nightly/trend_pages.h"

namespace tactbench::bench {

struct NightFiles {
  std::string junit, metrics, html;  // empty: not written
};
void add_night_files(CLI::App& verb, NightFiles& files);

void write_night_lists(const NightFiles& files, const Suite& suite, const std::vector<ScenarioResult>& results,
                       const Session& session);  // JUnit and metrics
void write_night_page(const NightFiles& files, const Suite& suite, const NightPage& night, const Session& session);

// 1: a scenario is red or was not carried out; 6: a figure has moved.
ExitCode code_of_night(const Suite& suite, const std::vector<ScenarioResult>& results);
nlohmann::ordered_json night_json(const Suite& suite, const std::vector<ScenarioResult>& results);
// Sentences show pressures in `unit`; names of figures show the unit in which they are stored.
void print_night(const Suite& suite, const std::vector<ScenarioResult>& results);

}  // namespace tactbench::bench
