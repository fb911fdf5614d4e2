// What `runs` and `fleet runs|show` share: the list of a store's runs and all that is stored about one.
#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "bench/cli/runs/metadata_options.h"
#include "bench/cli/session.h"

namespace tactbench::bench {

struct RunsListOptions {
  std::string sensor, since, tag, verdict;  // empty: any
  MetadataOptions metadata;
  bool all = false;  // include void runs
};
void add_runs_list_options(CLI::App& verb, RunsListOptions& options);

// Of session.db. `frame_counts`: where the store is a copy without frames, how many each run has.
void list_runs(const RunsListOptions& options, const Session& session,
               const std::map<std::int64_t, std::int64_t>* frame_counts = nullptr);
// `all_events`: also commands to actuators and readings.
void show_run(std::int64_t number, const Session& session, bool all_events = false);

}  // namespace tactbench::bench
