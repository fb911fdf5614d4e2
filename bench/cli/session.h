// Shared by the verbs: common options, printing of results and verdicts, exit codes. Results go to standard output,
// messages to standard error.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <iosfwd>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "analysis/judgement/figure.h"
#include "analysis/pressure_unit.h"
#include "analysis/report/document/document.h"
#include "bench/cli/profile_options.h"
#include "bench/cli/verbs.h"
#include "bench/common/error.h"
#include "bench/common/terminal.h"

namespace tactbench::bench {

struct NamedEvaluation;

inline constexpr const char* kDefaultStore = "runs.db";
inline constexpr const char* kShippedBench = "simulated.toml";  // for verbs for which a simulated bench will do

struct Session {
  bool json = false;
  bool quiet = false;              // prints only the result
  bool all = false;                // --all: also the checks that pass, and the data behind the figures
  bool replace = false;            // --replace: bench/common/output_file.h
  bool void_too = false;           // include void runs, in verbs that have the option
  std::string db = kDefaultStore;  // --db, else of TACTBENCH_DB or tactbench.toml
  std::string bench;               // --bench, else of TACTBENCH_BENCH or tactbench.toml, else bench.toml if it is here
  std::string fleet;               // the fleet from which `db` was copied, in words; empty: a bench's own store
  std::string units;               // --units or `units` of the profile: kPa, bar or psi; empty: not given
  std::function<bool(const char* option)> typed = [](const char*) { return false; };  // of add_global_options()
  // For a verb's printed output: psi by default, as in recipes, bench and limits files, CSV and JSON.
  [[nodiscard]] analysis::PressureUnit unit() const;
  // For a report's page: kPa by default, because documents give SI units first.
  [[nodiscard]] analysis::PressureUnit page_unit() const;
  // The bench file; if it was not given on the command line, its name is printed on standard error. Throws Error
  // TB-USAGE if there is none and no shipped one (`otherwise`) may be used.
  [[nodiscard]] std::string bench_file(const char* otherwise = nullptr) const;
  // --bench as typed, else empty: a bench's id or file, for verbs that only query a live run.
  [[nodiscard]] std::string typed_bench() const { return typed("--bench") ? bench : std::string(); }
  // Uses --db only if typed: the results of a demonstration or a nightly run do not belong in the user's own store.
  void use_db_only_if_typed();
  ProfileOptions profile;
  ExitCode code = ExitCode::kPass;
};

// One document on standard output, with schema "tactbench.<verb>" and version 1 in front.
void print_json(const std::string& verb, const nlohmann::ordered_json& body);

// Prints on standard output, at the width of the terminal. Texts typed by people have gone through one_line().
void print_document(const analysis::doc::Document& document, analysis::PressureUnit unit);
void print_table(analysis::doc::Table table, analysis::PressureUnit unit = analysis::PressureUnit::kPsi);

// A verb's exit code by its verdict: also 0 without a verdict, and if conformity is not stated.
ExitCode exit_code_of(std::optional<analysis::Verdict> verdict);
// The verdict in words: "simulated pass" on a simulated run.
std::string shown_verdict(const std::string& word, const std::string& origin);
std::string shown_verdict(analysis::Verdict verdict, const std::string& origin);
nlohmann::ordered_json verdicts_json(const std::vector<analysis::JudgedFigure>& figures, const std::string& origin);

nlohmann::ordered_json evaluation_json(const NamedEvaluation& named);

// Throws Error TB-USAGE for an empty or blank name.
void check_operator(const std::string& name);

// --db, --bench, --units, --json and -q, which every verb takes.
void add_global_options(CLI::App& app, Session& session);
// Group of options that --help leaves out and --help-all shows.
inline constexpr const char* kRareOptions = "Rarely needed";
// --all on a verb that prints verdicts or a plan.
void add_all(CLI::App& verb, Session& session);
// --replace on a verb that writes files (bench/common/output_file.h).
void add_replace(CLI::App& verb, Session& session);
// --void-too on a verb that uses runs as evidence (bench/reporting/evidence.h).
void add_void_too(CLI::App& verb, Session& session);

// Parses and runs; never throws; returns the process's exit code.
int run_command_line(int argc, char** argv);

}  // namespace tactbench::bench
