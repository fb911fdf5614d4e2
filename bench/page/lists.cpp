#include "bench/page/lists.h"

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "analysis/documents/run_json.h"
#include "bench/reporting/judgement.h"
#include "bench/run/control/locks.h"

namespace tactbench::bench {

namespace {

std::string verdict_of_run(const db::RunStore& store, const db::RunRecord& run) {
  const Standing stands = standing(store, run.run);
  if (!stands.verdict) return "-";
  return (run.origin == "simulated" ? "simulated " : "") + std::string(analysis::to_string(*stands.verdict)) +
         (stands.rests_on_means_alone ? ", of means alone" : "");
}

std::set<std::string> subjects_of(const db::RunStore& store) {
  std::set<std::string> subjects;
  for (const db::FigureRecord& figure : store.figures("")) subjects.insert(figure.subject);
  return subjects;
}

}  // namespace

nlohmann::ordered_json runs_list(const db::RunStore& store) {
  const std::vector<db::RunRecord> runs = store.runs();
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (auto run = runs.rbegin(); run != runs.rend() && list.size() < kListedRuns; ++run) {
    const nlohmann::ordered_json whole = analysis::run_json(store.run(run->run));
    nlohmann::ordered_json row;
    for (const char* key : {"run", "started_utc", "ended_utc", "sensor", "operator", "purpose", "origin", "outcome",
                            "reason", "safe_state", "bench", "recipes", "tags", "void"})
      row[key] = whole.at(key);
    row["frames"] = store.frame_count(run->run);
    row["verdict"] = verdict_of_run(store, *run);
    row["fitted"] = store.latest_fit(run->run).has_value();
    if (run->outcome == db::Outcome::kIncomplete) row["lives"] = is_carried_out(store.path(), run->run).value_or(false);
    list.push_back(std::move(row));
  }
  const std::size_t left_out = runs.size() - list.size();
  return {{"runs", std::move(list)}, {"left_out", left_out}};
}

nlohmann::ordered_json sensors_list(const db::RunStore& store) {
  const std::set<std::string> subjects = subjects_of(store);
  std::map<std::string, nlohmann::ordered_json> runs;
  for (const db::RunRecord& run : store.runs()) {
    nlohmann::ordered_json& own = runs.try_emplace(run.sensor_serial, nlohmann::ordered_json::array()).first->second;
    own.insert(own.begin(), run.run);
  }
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const db::SensorRecord& sensor : store.sensors()) {
    nlohmann::ordered_json row = analysis::sensor_json(sensor);
    const auto own = runs.find(sensor.serial);
    row["runs"] = own == runs.end() ? nlohmann::ordered_json::array() : own->second;
    row["figures"] = std::ranges::any_of(
        subjects, [&](const std::string& subject) { return subject.starts_with("sensor/" + sensor.serial + "/"); });
    list.push_back(std::move(row));
  }
  return {{"sensors", std::move(list)}};
}

nlohmann::ordered_json nights_list(const db::RunStore& store) {
  nlohmann::ordered_json subjects = nlohmann::ordered_json::array();
  for (const std::string& subject : subjects_of(store))
    if (subject.starts_with("nightly/")) subjects.push_back(subject);
  return {{"subjects", std::move(subjects)}};
}

}  // namespace tactbench::bench
