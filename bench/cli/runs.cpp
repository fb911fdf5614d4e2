#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>

#include "analysis/json_io.h"
#include "analysis/report/page.h"
#include "bench/cli/session.h"

namespace tactbench::bench {

namespace {

// The worst word among a run's verdicts; "none" when it was not judged.
std::string worst_verdict(const std::vector<db::VerdictRecord>& verdicts) {
  if (verdicts.empty()) return "none";
  return analysis::overall_verdict(verdicts);
}

struct RunsListOptions {
  std::string sensor, since, tag, verdict;  // empty: any
  bool all = false;                         // void runs, too
};

void check_since(const std::string& since) {
  const std::string pattern = "dddd-dd-dd";
  bool fits = since.size() >= pattern.size();
  for (std::size_t i = 0; fits && i < pattern.size(); ++i) {
    fits = pattern[i] == 'd' ? since[i] >= '0' && since[i] <= '9' : since[i] == '-';
  }
  if (fits) return;
  throw Error(ExitCode::kUsage, "TB-USAGE", fmt::format("'{}' is no date", since), "--since",
              "write it as 2026-01-31, or 2026-01-31T12:00:00Z (UTC)");
}

// What was found; where nothing was, the figures.
std::string check_line(const db::CheckRecord& check) {
  const auto detail = analysis::try_ordered_json(check.detail_json);
  std::vector<std::string> parts;
  for (const auto& finding : detail.value("findings", nlohmann::ordered_json::array())) {
    parts.push_back(finding.value("text", ""));
  }
  if (!parts.empty()) return fmt::format("{}", fmt::join(parts, "; "));
  for (const auto& [key, value] : detail.items()) {
    if (value.is_number_float()) {
      parts.push_back(fmt::format("{} {:.4g}", key, value.get<double>()));
    } else if (!value.is_structured() || !value.empty()) {
      parts.push_back(fmt::format("{} {}", key, analysis::json_line(value)));
    }
  }
  return fmt::format("{}", fmt::join(parts, ", "));
}

void list_runs(const RunsListOptions& options, const Session& session) {
  if (!options.since.empty()) check_since(options.since);
  const db::RunStore store = db::RunStore::open_read_only(session.db);
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  if (!session.json) {
    fmt::print("{:>5}  {:<21}{:<12}{:<13}{:>7}  {:<14}{:<11}{}\n", "run", "started (UTC)", "sensor", "outcome",
               "frames", "verdict", "origin", "purpose");
  }
  int left_out = 0;
  for (const db::RunRecord& run : store.runs()) {
    if (!options.sensor.empty() && run.sensor_serial != options.sensor) continue;
    if (run.started_utc < options.since) continue;
    if (!options.tag.empty() && std::ranges::find(run.tags, options.tag) == run.tags.end()) continue;
    const std::string worst = worst_verdict(store.verdicts(run.run));
    if (!options.verdict.empty() && worst != options.verdict) continue;
    if (run.is_void() && !options.all) {
      ++left_out;
      continue;
    }
    const std::int64_t frames = store.frame_count(run.run);
    const std::string verdict = worst == "none" ? "-" : shown_verdict(worst, run.origin);
    if (session.json) {
      nlohmann::ordered_json row = run_json(run);
      row["frames"] = frames;
      row["verdict"] = verdict;
      json.push_back(row);
    } else {
      fmt::print("{:>5}  {:<21}{:<12}{:<13}{:>7}  {:<14}{:<11}{}{}{}\n", run.run, run.started_utc, run.sensor_serial,
                 db::to_string(run.outcome), frames, verdict, run.origin, run.purpose,
                 run.tags.empty() ? "" : fmt::format(" [{}]", fmt::join(run.tags, " ")),
                 run.is_void() ? fmt::format(" VOID: {}", run.void_reason) : "");
    }
  }
  if (session.json) {
    print_json("runs.list", {{"runs", json}, {"void_left_out", left_out}});
  } else if (left_out > 0) {
    fmt::print("{} void {} left out (--all)\n", left_out, left_out == 1 ? "run" : "runs");
  }
}

void show_run(std::int64_t number, const Session& session) {
  const db::RunStore store = db::RunStore::open_read_only(session.db);
  const db::RunRecord run = store.run(number);
  const std::vector<db::VerdictRecord> verdicts = store.verdicts(number);
  const std::vector<db::EventRecord> events = store.events(number);
  const std::vector<db::CheckRecord> checks = store.checks(number);
  if (session.json) {
    nlohmann::ordered_json json = run_json(run);
    json["frames"] = store.frame_count(number);
    json["bench_sha256"] = run.bench_sha256;
    json["sensor_type_sha256"] = run.sensor_sha256;
    json["overrides"] = analysis::try_ordered_json(run.overrides_json);
    json["events"] = nlohmann::ordered_json::array();
    for (const db::EventRecord& event : events) {
      json["events"].push_back({{"time_s", static_cast<double>(event.time_ns) * 1e-9},
                                {"kind", event.kind},
                                {"id", event.id},
                                {"detail", event.detail}});
    }
    json["checks"] = nlohmann::ordered_json::array();
    for (const db::CheckRecord& check : checks) {
      json["checks"].push_back({{"time_s", static_cast<double>(check.time_ns) * 1e-9},
                                {"kind", check.kind},
                                {"verdict", check.verdict},
                                {"detail", analysis::try_ordered_json(check.detail_json)}});
    }
    json["verdicts"] = verdicts_json(verdicts, run.origin);
    print_json("runs.show", json);
    return;
  }
  fmt::print("run {} ({})\n", run.run, run.uuid);
  const auto line = [](const char* name, const std::string& value) {
    fmt::print("  {:<14}{}\n", name, value.empty() ? "not stated" : value);
  };
  if (run.is_void()) line("VOID", fmt::format("{} ({}, {})", run.void_reason, run.void_by, run.void_utc));
  line("origin", run.origin);
  line("outcome", fmt::format("{}: {}", db::to_string(run.outcome), run.reason));
  line("safe state", db::to_string(run.safe_state));
  line("sensor", fmt::format("{}, scanner {}", run.sensor_serial, run.scanner_serial));
  line("operator", run.operator_name);
  line("purpose", run.purpose);
  line("bench", fmt::format("{} (sha256 {})", run.bench_id, run.bench_sha256.substr(0, 12)));
  line("started", run.started_utc);
  line("ended", run.ended_utc);
  line("program", fmt::format("{} ({}{})", run.program_version, run.git_commit, run.git_dirty ? ", modified" : ""));
  line("content", run.content_sha256);
  if (!run.tags.empty()) line("tags", fmt::format("{}", fmt::join(run.tags, " ")));
  std::istringstream notes(run.notes);
  for (std::string note; std::getline(notes, note);) line("note", note);
  for (const db::SequenceRecord& sequence : run.sequences) {
    line("recipe", fmt::format("{}: {} x {} frames (sha256 {})", sequence.name, sequence.repeats,
                               sequence.frames_per_repeat, sequence.recipe_sha256.substr(0, 12)));
  }
  for (const db::DeviceRecord& device : run.devices) {
    line("device", fmt::format("{}: {}, serial {}, {}", device.role, device.model,
                               device.serial.empty() ? "not stated" : device.serial, device.origin));
  }
  line("frames", std::to_string(store.frame_count(number)));
  for (const db::CheckRecord& check : checks) {
    line("check", fmt::format("{:9.3f} s  {} {}: {}", static_cast<double>(check.time_ns) * 1e-9, check.kind,
                              check.verdict, check_line(check)));
  }
  for (const db::EventRecord& event : events) {
    line("event", fmt::format("{:9.3f} s  {} {} {}", static_cast<double>(event.time_ns) * 1e-9, event.kind, event.id,
                              event.detail));
  }
  if (!verdicts.empty()) fmt::print("\n{}", verdict_table(verdicts, run.origin));
}

}  // namespace

void add_runs(CLI::App& app, Session& session) {
  CLI::App* runs = app.add_subcommand("runs", "list, show, compare, export, copy, tag, note or void stored runs");
  runs->require_subcommand(1);
  auto options = std::make_shared<RunsListOptions>();
  CLI::App* list_verb = runs->add_subcommand("list", "one line a run");
  list_verb->add_option("--sensor", options->sensor, "of this sensor alone");
  list_verb->add_option("--since", options->since, "started on this day (UTC, 2026-01-31) or later");
  list_verb->add_option("--tag", options->tag, "with this tag alone");
  list_verb->add_option("--verdict", options->verdict, "whose worst verdict is this; none: not judged")
      ->check(CLI::IsMember({"pass", "fail", "inconclusive", "none"}));
  list_verb->add_flag("--all", options->all, "void runs, too");
  add_common(*list_verb, session);
  list_verb->callback([options, &session] { list_runs(*options, session); });
  auto number = std::make_shared<std::int64_t>(0);
  CLI::App* show_verb = runs->add_subcommand("show", "all that is known of a run");
  show_verb->add_option("run", *number, "run number")->required();
  add_common(*show_verb, session);
  show_verb->callback([number, &session] { show_run(*number, session); });
  add_run_remarks(*runs, session);
  add_run_export(*runs, session);
  add_run_copy(*runs, session);
  add_run_diff(*runs, session);
}

}  // namespace tactbench::bench
