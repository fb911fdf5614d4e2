#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>

#include "bench/cli/session.h"

namespace tactbench::bench {

namespace {

// The worst word among a run's verdicts; "-" when it was not judged.
std::string worst_verdict(const db::RunStore& store, const db::RunRecord& run) {
  const std::vector<db::VerdictRecord> verdicts = store.verdicts(run.run);
  if (verdicts.empty()) return "-";
  switch (exit_code_of(verdicts)) {
    case ExitCode::kPass:
      return shown_verdict("pass", run.origin);
    case ExitCode::kCriterionFailed:
      return shown_verdict("fail", run.origin);
    default:
      return shown_verdict("inconclusive", run.origin);
  }
}

// What was found; where nothing was, the figures.
std::string check_line(const db::CheckRecord& check) {
  const auto detail = nlohmann::ordered_json::parse(check.detail_json, nullptr, false);
  std::vector<std::string> parts;
  for (const auto& finding : detail.value("findings", nlohmann::ordered_json::array())) {
    parts.push_back(finding.value("text", ""));
  }
  if (!parts.empty()) return fmt::format("{}", fmt::join(parts, "; "));
  for (const auto& [key, value] : detail.items()) {
    if (value.is_number_float()) {
      parts.push_back(fmt::format("{} {:.4g}", key, value.get<double>()));
    } else if (!value.is_structured() || !value.empty()) {
      parts.push_back(fmt::format("{} {}", key, value.dump()));
    }
  }
  return fmt::format("{}", fmt::join(parts, ", "));
}

void list_runs(const Session& session) {
  const db::RunStore store = db::RunStore::open_read_only(session.db);
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  if (!session.json) {
    fmt::print("{:>5}  {:<21}{:<12}{:<13}{:>7}  {:<14}{:<11}{}\n", "run", "started (UTC)", "sensor", "outcome",
               "frames", "verdict", "origin", "purpose");
  }
  for (const db::RunRecord& run : store.runs()) {
    const std::int64_t frames = store.frame_count(run.run);
    const std::string verdict = worst_verdict(store, run);
    if (session.json) {
      nlohmann::ordered_json row = run_json(run);
      row["frames"] = frames;
      row["verdict"] = verdict;
      json.push_back(row);
    } else {
      fmt::print("{:>5}  {:<21}{:<12}{:<13}{:>7}  {:<14}{:<11}{}\n", run.run, run.started_utc, run.sensor_serial,
                 db::to_string(run.outcome), frames, verdict, run.origin, run.purpose);
    }
  }
  if (session.json) print_json("runs.list", {{"runs", json}});
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
    json["overrides"] = nlohmann::ordered_json::parse(run.overrides_json, nullptr, false);
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
                                {"detail", nlohmann::ordered_json::parse(check.detail_json, nullptr, false)}});
    }
    json["verdicts"] = verdicts_json(verdicts, run.origin);
    print_json("runs.show", json);
    return;
  }
  fmt::print("run {} ({})\n", run.run, run.uuid);
  const auto line = [](const char* name, const std::string& value) {
    fmt::print("  {:<14}{}\n", name, value.empty() ? "not stated" : value);
  };
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
  CLI::App* runs = app.add_subcommand("runs", "list or show stored runs");
  runs->require_subcommand(1);
  CLI::App* list_verb = runs->add_subcommand("list", "one line a run");
  add_common(*list_verb, session);
  list_verb->callback([&session] { list_runs(session); });
  auto number = std::make_shared<std::int64_t>(0);
  CLI::App* show_verb = runs->add_subcommand("show", "all that is known of a run");
  show_verb->add_option("run", *number, "run number")->required();
  add_common(*show_verb, session);
  show_verb->callback([number, &session] { show_run(*number, session); });
}

}  // namespace tactbench::bench
