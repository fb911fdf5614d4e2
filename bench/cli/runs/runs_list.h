// The list of a store's runs, and everything stored about one run; shared by `runs` and `fleet runs|show`.
#pragma once

#include <cstdint>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "bench/cli/runs/metadata_options.h"
#include "bench/cli/runs/wanted_verdict.h"
#include "bench/cli/session.h"

namespace tactbench::bench {

inline constexpr const char* kNotCompleted = "not-completed";  // of --outcome: any other

struct RunsListOptions {
  std::string sensor, since, tag, verdict, outcome;  // empty: any
  MetadataOptions metadata;
  bool all = false;  // include void runs
};
void add_runs_list_options(CLI::App& verb, RunsListOptions& options);

// A run as the list shows it.
struct ListedRun {
  db::RunRecord run;  // with its sequences
  std::optional<analysis::Verdict> verdict = {};
  bool means_alone = false;  // the verdict rests on them
  std::int64_t frames = 0;
  std::optional<db::PrunedRecord> pruned = {};
  std::optional<bool> lives = {};  // of one that has not ended: whether a process carries it out
};

class RunsList {
 public:
  RunsList(const RunsListOptions& options, const Session& session);  // throws Error TB-USAGE
  // Whether the run matches the options; sensor and start are not checked here.
  [[nodiscard]] bool takes(const db::RunRecord& run, std::optional<analysis::Verdict> verdict);
  // `row`: run_json() of the run, to which members are added; only used with --json.
  void add(const ListedRun& listed, nlohmann::ordered_json row);
  void end(bool any_stored);  // prints what is left to say

 private:
  const RunsListOptions& options_;
  const Session& session_;
  WantedVerdict wanted_;
  std::unique_ptr<nlohmann::ordered_json> rows_;
  analysis::doc::Table table_;
  int left_out_ = 0, listed_ = 0;
};

void list_runs(const RunsListOptions& options, const Session& session);  // of session.db
// `all_events`: also commands to actuators and readings.
void show_run(std::int64_t number, const Session& session, bool all_events = false);

}  // namespace tactbench::bench
