#include "bench/page/lists.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>

#include "analysis/documents/run_json.h"
#include "analysis/report/report_facts.h"
#include "bench/run/control/locks.h"

namespace tactbench::bench {

using nlohmann::ordered_json;

namespace {

std::string decided_text(const analysis::JudgedFigure& figure) {
  if (figure.run == figure.model_run)
    return "judged only on the run from which the models were made: a held-out run is needed";
  constexpr auto kPsi = analysis::PressureUnit::kPsi;
  using Kind = analysis::Scope::Kind;
  return fmt::format("{}{}{}{}: {}, limit {}, on run {}",
                     passes(figure.verdict) ? "closest to its limit: " : "decided by: ", display_text(figure.criterion),
                     figure.scope.kind == Kind::kArray ? "" : " at " + display_text(figure.scope, kPsi),
                     figure.scope.kind == Kind::kSpan ? " of the taxels" : "",
                     figure_text(figure.criterion, figure.value, kPsi),
                     figure_text(figure.criterion, figure.limit, kPsi), figure.run);
}

}  // namespace

ordered_json verdict_json(const Standing& stands) {
  const analysis::JudgedFigure* deciding = stands.deciding();
  if (deciding == nullptr) return {};
  return {{"word", to_string(*stands.verdict)},
          {"of_means", stands.rests_on_means_alone},
          {"models_of", stands.models_run()},
          {"decided", decided_text(*deciding)}};
}

Standing calibration_of(const db::RunStore& store, std::int64_t run) {
  Standing own = standing(store, run);
  const std::int64_t models = own.models_run();
  return models == 0 || models == run ? own : standing(store, models);
}

ordered_json runs_list(const db::RunStore& store) {
  const std::vector<db::RunRecord> runs = store.runs();
  ordered_json list = ordered_json::array();
  for (auto run = runs.rbegin(); run != runs.rend() && list.size() < kListedRuns; ++run) {
    const ordered_json whole = analysis::run_json(store.run(run->run));
    ordered_json row;
    for (const char* key : {"run", "started_utc", "ended_utc", "sensor", "operator", "purpose", "origin", "outcome",
                            "reason", "safe_state", "bench", "recipes", "tags", "void"})
      row[key] = whole.at(key);
    const Standing stands = standing(store, run->run);
    row["frames"] = store.frame_count(run->run);
    row["verdict"] = verdict_json(stands);
    row["report"] = reporting_run(store, stands, run->run);
    if (run->outcome == db::Outcome::kIncomplete) row["lives"] = is_carried_out(store.path(), run->run).value_or(false);
    list.push_back(std::move(row));
  }
  const std::size_t left_out = runs.size() - list.size();
  return {{"runs", std::move(list)}, {"left_out", left_out}};
}

ordered_json sensors_list(const db::RunStore& store, const analysis::Laboratory& laboratory, const std::string& today) {
  const std::vector<std::string> subjects = store.subjects();
  const std::vector<db::RunRecord> runs = store.runs();
  ordered_json list = ordered_json::array();
  for (const db::SensorRecord& sensor : store.sensors()) {
    ordered_json row = analysis::sensor_json(sensor);
    row["runs"] = ordered_json::array();
    row["verdict"] = nullptr;
    for (auto run = runs.rbegin(); run != runs.rend(); ++run) {
      if (run->sensor_serial != sensor.serial) continue;
      row["runs"].push_back(run->run);
      if (!row["verdict"].is_null()) continue;
      row["verdict"] = verdict_json(calibration_of(store, run->run));
      if (row["verdict"].is_null()) continue;
      const std::string due = valid_until(laboratory, run->started_utc);
      row["origin"] = run->origin;
      row["calibrated"] = analysis::date_of(run->started_utc);
      row["due"] = due;
      row["overdue"] = !due.empty() && due < today;
    }
    row["figures"] = std::ranges::any_of(
        subjects, [&](const std::string& subject) { return subject.starts_with("sensor/" + sensor.serial + "/"); });
    list.push_back(std::move(row));
  }
  return {{"sensors", std::move(list)}};
}

std::size_t stored_nights(const db::RunStore& store) {
  const auto nightly = [](const std::string& subject) { return subject.starts_with("nightly/"); };
  return static_cast<std::size_t>(std::ranges::count_if(store.subjects(), nightly));
}

}  // namespace tactbench::bench
