// A run in documents: the same keys and values wherever a run, its figures or its verdicts are written.
#include "analysis/documents/run_json.h"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <set>

#include "analysis/report/overview/overview.h"
#include "tests/analysis/report/report_example.h"
#include "tests/db/store_example.h"

using namespace tactbench;
using namespace tactbench::analysis;

namespace {

using Document = nlohmann::ordered_json;
using Keys = std::set<std::string>;

Keys keys_of(const Document& document) {
  Keys keys;
  for (const auto& [key, value] : document.items()) keys.insert(key);
  return keys;
}

Document report_of(const ReportInput& input) { return Document::parse(render_report(input).json); }

const Keys kRunKeys = {"run",        "uuid",         "origin",      "state",     "outcome",        "reason",
                       "safe_state", "operator",     "purpose",     "sensor",    "scanner",        "sensor_type_sha256",
                       "bench",      "bench_sha256", "overrides",   "seed",      "sensor_seed",    "started_utc",
                       "ended_utc",  "rest_s",       "host",        "time_zone", "git_commit",     "program_version",
                       "git_dirty",  "build_id",     "metadata",    "tags",      "content_sha256", "notes",
                       "void",       "void_by",      "void_reason", "void_utc",  "recipes",        "devices"};
const Keys kDeviceKeys = {"role",        "model",         "serial",     "firmware", "origin",  "certificate",
                          "uncertainty", "calibrated_by", "calibrated", "due",      "overdue", "remarks"};

}  // namespace

TEST_CASE("run JSON: has every key, also for an empty run") {
  CHECK(keys_of(run_json({})) == kRunKeys);
  db::RunRecord run = tests::example_run();
  run.run = 4;
  run.tags = {"a", "b", "film=B/12", "lot=A7"};
  const Document document = run_json(run);
  CHECK(keys_of(document) == kRunKeys);
  const Document told = Document::parse(R"({"run":4,"sensor":"S-1","scanner":"SC-7","bench":"bench-a",
    "operator":"N. Nobody","outcome":"incomplete","safe_state":"unknown","git_dirty":true,"sensor_seed":-8,
    "overrides":[{"key":"a","value":"1"}],"rest_s":null,"tags":["a","b","film=B/12","lot=A7"],
    "metadata":{"film":"B/12","lot":"A7"},"void":false,"void_reason":""})");
  for (const auto& [key, value] : told.items()) {
    INFO(key);
    CHECK(document[key] == value);
  }
  CHECK(document["bench_sha256"] == run.bench_sha256);
  CHECK(document["sensor_type_sha256"] == run.sensor_sha256);
  CHECK(run_json({})["metadata"] == Document::object());
  REQUIRE(document["recipes"].size() == 2);
  CHECK(document["recipes"][1] ==
        Document::parse(R"({"name":"down","sha256":"rb","repeats":1,"frames_per_repeat":4})"));
  REQUIRE(document["devices"].size() == 2);
  CHECK(keys_of(document["devices"][0]) == kDeviceKeys);
  CHECK(document["devices"][1]["serial"] == "SC-7");

  run.rest_s = 12.5;
  run.void_utc = "2024-05-03T00:00:00Z";
  run.void_by = "me";
  run.void_reason = "gauge closed";
  run.overrides_json = "no JSON";
  const Document voided = run_json(run);
  CHECK(voided["rest_s"] == 12.5);
  CHECK(voided["void"] == true);
  CHECK(voided["void_by"] == "me");
  CHECK(voided["void_reason"] == "gauge closed");
  CHECK(voided["overrides"].is_null());
}

TEST_CASE("device JSON: states the calibration as the report does, and leaves FILL-IN fields empty") {
  db::RunRecord run = tests::example_run();
  run.devices[0].calibration_json = R"({"certificate":"C-1","calibrated":"2024-01-31","due":"2024-04-30"})";
  run.devices[1].model = "FILL-IN";
  const std::vector<InstrumentNote> notes = {{"0001", "", "a laboratory", "", "2024-03-31", ""}};
  const Document own = run_json(run)["devices"][0], noted = run_json(run, notes)["devices"][0];
  CHECK(own["certificate"] == "C-1");
  CHECK(own["calibrated"] == "2024-01-31");
  CHECK(own["calibrated_by"] == "");
  CHECK(own["due"] == "2024-04-30");
  CHECK(own["overdue"] == true);  // the run began in May
  CHECK(noted["calibrated_by"] == "a laboratory");
  CHECK(noted["due"] == "2024-03-31");  // the earlier one counts
  CHECK(noted["remarks"].size() == 1);
  CHECK(run_json(run)["devices"][1]["model"] == "");
  run.started_utc = "2024-02-01T00:00:00Z";
  CHECK(run_json(run)["devices"][0]["overdue"] == false);
}

TEST_CASE("report JSON: holds the same facts on its runs as the run JSON, except tags and notes") {
  ReportInput input = example::example_input();
  input.further = {tests::example_run()};
  input.run.tags = {"night"};
  const Document identification = report_of(input)["identification"];
  const auto same = [&](const Document& reported, const db::RunRecord& run) {
    Keys keys = kRunKeys;
    keys.erase("tags");
    keys.erase("notes");
    const Document own = run_json(run, input.laboratory.instruments);
    for (const std::string& key : keys) {
      INFO(key);
      REQUIRE(reported.contains(key));
      if (key != "devices") CHECK(reported[key] == own[key]);
    }
    REQUIRE(reported["devices"].size() == run.devices.size());
    for (std::size_t i = 0; i < run.devices.size(); ++i) {
      Document device = reported["devices"][i];
      device.erase("calibration");
      CHECK(device == own["devices"][i]);
    }
    Keys more = keys_of(reported);
    for (const std::string& key : keys) more.erase(key);
    return more;
  };
  CHECK(same(identification["run"], input.run).empty());
  CHECK(same(identification["held_out"][0], input.held_out[0].run) == Keys{"title"});
  CHECK(same(identification["further"][0], input.further[0]).empty());
  CHECK(identification["further"][0]["devices"][1]["calibration"]["volts_per_count"] == 0.1);
  CHECK(identification["sensor"] == sensor_json(*input.sensor));
  CHECK(keys_of(identification["sensor"]) == Keys{"serial", "type", "type_sha256", "scanner", "note", "added_utc"});

  const std::string number = render_report(input).number;
  input.run.rest_s = 60.0;
  input.run.tags.clear();
  input.run.notes = "the door was open";
  CHECK(render_report(input).number == number);
}

TEST_CASE("evaluation JSON: has the same keys in every document, and shares of full scale end in _fs") {
  const ReportInput input = example::example_input();
  const Document own = evaluation_json(input.evaluation);
  CHECK(own["raw_distance_fs"] == input.evaluation.raw_distance);
  CHECK(own["comp_distance_of_mean_fs"] == input.evaluation.comp_distance_of_mean);
  CHECK(own["worst_taxel_distance_observable_fs"] == input.evaluation.worst_taxel_distance_observable);
  std::vector<double> made_worse;
  for (const LevelFigures& level : input.evaluation.levels)
    if (level.made_worse) made_worse.push_back(level.pressure_psi);
  CHECK(own["levels_made_worse_psi"] == Document(made_worse));
  const Document results = report_of(input)["results"];
  Document reported = results["evaluation"];
  REQUIRE(reported["levels"].size() == input.evaluation.levels.size());
  REQUIRE(reported["largest_error"]["error_psi"] == own["max_error_psi"]);
  for (const char* more : {"levels", "largest_error"}) reported.erase(more);  // of reports alone: where it is
  CHECK(keys_of(reported) == keys_of(own));
  CHECK(reported["mean_error_psi"] == own["mean_error_psi"]);
  CHECK(keys_of(results["held_out"][0]["evaluation"]) == keys_of(results["evaluation"]));
  // A distance or a spread without a unit is a share.
  for (const auto& [key, value] : results["evaluation"]["levels"][3].items()) {
    INFO(key);
    const bool share = key.find("distance") != std::string::npos || key.find("_std_") != std::string::npos;
    if (!key.ends_with("_made_worse")) CHECK(key.ends_with("_fs") == share);
  }
}

TEST_CASE("verdict JSON: has the same keys in every document") {
  ReportInput input = example::example_input();
  input.judgement.stored_worse = {input.judgement.figures[1]};
  const Document own = figure_json(input.judgement.figures[0]);
  CHECK(keys_of(own) ==
        Keys{"criterion", "scope", "value", "expanded", "limit", "unit", "rule", "verdict", "limits_sha256"});
  const Document results = report_of(input)["results"];
  for (const Document& list : {results["verdicts"], results["judgement"]["stored_worse"]}) {
    Keys keys = keys_of(list.at(0));
    CHECK(keys.erase("on") == 1);
    CHECK(keys == keys_of(own));
  }
  const Document batch = Document::parse(render_batch({input}).json);
  CHECK(batch["version"] == 2);
  CHECK(keys_of(batch["content"][0]["verdicts"][0]) == keys_of(own));
  CHECK(batch["content"][0]["sensor"] == input.run.sensor_serial);
  CHECK(batch["content"][0]["scanner"] == "SC-0042");
  const Document comparison = Document::parse(render_comparison(input, input).json);
  CHECK(comparison["version"] == 2);
  CHECK(keys_of(comparison["first"]) == keys_of(batch["content"][0]));
}
