// What the verbs share: the common options, how results and verdicts are printed, and the exit code. Standard output
// is the result, standard error is talk.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "bench/error.h"
#include "sequences/strict_toml.h"

namespace CLI {
class App;
}

namespace tactbench::db {
struct RunRecord;
struct VerdictRecord;
}  // namespace tactbench::db

namespace tactbench::bench {

struct Session {
  bool json = false;
  bool quiet = false;
  std::string db = "runs.db";
  ExitCode code = ExitCode::kPass;
};

// One document on standard output, with schema "tactbench.<verb>" and version 1 in front.
void print_json(const std::string& verb, const nlohmann::ordered_json& body);

// "--set k=v": keys that start with "recipe." go to the recipes (without the prefix), all others to the bench file.
struct SplitOverrides {
  std::vector<sequences::Override> all, bench, recipe;
};
SplitOverrides split_overrides(const std::vector<std::string>& set);

// "fail" outranks "inconclusive" and "conditional fail" (6), those outrank "pass".
ExitCode exit_code_of(const std::vector<db::VerdictRecord>& verdicts);
// The verdict's word as people read it: "simulated pass" on a simulated run.
std::string shown_verdict(const std::string& verdict, const std::string& origin);
std::string verdict_table(const std::vector<db::VerdictRecord>& verdicts, const std::string& origin);
nlohmann::ordered_json verdicts_json(const std::vector<db::VerdictRecord>& verdicts, const std::string& origin);

nlohmann::ordered_json run_json(const db::RunRecord& run);

// One file a verb.
void add_init(CLI::App& app, Session& session);
void add_plan(CLI::App& app, Session& session);
void add_run(CLI::App& app, Session& session);
void add_control(CLI::App& app, Session& session);
void add_fit(CLI::App& app, Session& session);
void add_import(CLI::App& app, Session& session);
void add_predict(CLI::App& app, Session& session);
void add_model(CLI::App& app, Session& session);
void add_report(CLI::App& app, Session& session);
void add_runs(CLI::App& app, Session& session);
void add_db(CLI::App& app, Session& session);
void add_verify(CLI::App& app, Session& session);
void add_sensors(CLI::App& app, Session& session);
void add_demo(CLI::App& app, Session& session);
void add_devices(CLI::App& app, Session& session);
void add_run_remarks(CLI::App& runs, Session& session);
void add_run_export(CLI::App& runs, Session& session);
void add_run_copy(CLI::App& runs, Session& session);
void add_run_diff(CLI::App& runs, Session& session);
void add_calibrate_reference(CLI::App& devices, Session& session);
void add_simulate(CLI::App& app, Session& session);
void add_live(CLI::App& app, Session& session);
void add_nightly(CLI::App& app, Session& session);
void add_baseline(CLI::App& app, Session& session);
void add_trend(CLI::App& app, Session& session);
void add_rig(CLI::App& app, Session& session);
void add_config(CLI::App& app, Session& session);
void add_benchmark(CLI::App& app, Session& session);
void add_dead_man(CLI::App& app, Session& session);

// "h:mm:ss".
std::string clock_text(double seconds);

// Writes `text` to a file whole: a reader never sees half of it. Makes the folder. Throws Error TB-FILE-WRITE.
void write_whole(const std::string& path, const std::string& text);

// --db, --json, -q on a verb.
void add_common(CLI::App& verb, Session& session);

// Parses and runs; never throws; returns the process's exit code.
int run_command_line(int argc, char** argv);

}  // namespace tactbench::bench
