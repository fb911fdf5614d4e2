// runs show and runs diff of runs that are known row by row: verdicts by models and limits, remarks, settings,
// metadata.

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include <cmath>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "bench/cli/runs/runs.h"
#include "bench/run/control/locks.h"
#include "db/record.h"
#include "db/sqlite.h"
#include "tests/bench/cli/verb_here.h"
#include "tests/bench/config/bench_text.h"
#include "tests/support/paths.h"
#include "tests/support/refusal.h"
#include "tests/support/text.h"

using namespace tactbench;
using namespace tactbench::tests;
using bench::MetadataOptions;

namespace {

struct StoreOfPages : OpenStoreHere {
  Finished runs(std::vector<std::string> words) const {
    words.insert(words.begin(), "runs");
    return say(bench::add_runs, words);
  }
  std::int64_t add(const std::function<void(db::RunRecord&)>& change = [](db::RunRecord&) {}) {
    db::RunRecord run = example_run();
    change(run);
    return store_example(store, run);
  }
  [[nodiscard]] nlohmann::json shown(std::int64_t run) const {
    return nlohmann::json::parse(runs({"show", std::to_string(run), "--json"}).out);
  }
};

}  // namespace

TEST_CASE("runs show: lists verdicts by several models and limits, and the overall verdict") {
  StoreOfPages store;
  store.add();
  store.add();
  db::FitRecord fit;
  fit.run = 1;
  fit.model = "elam";
  const std::int64_t own = store.store.add_fit(fit);
  const auto row = [](const char* verdict, const std::string& limits) {
    return db::VerdictRecord{0, 0, "unfit_taxels", "array", 1.0, 1.5, "taxels", "simple", verdict, "limits", limits};
  };
  const std::string first(64, '1'), second(64, '2');
  store.store.replace_verdicts(2, own, {row("pass", first)});
  store.store.replace_verdicts(2, 0, {row("fail", second)});
  const nlohmann::json printed = store.shown(2);
  CHECK(printed.at("verdict") == "simulated fail");
  CHECK(printed.at("verdicts").size() == 2);
  CHECK(printed.at("frames") == 3);
  CHECK_FALSE(printed.contains("pruned"));
  CHECK_FALSE(printed.contains("specimen"));
}

TEST_CASE("runs show: shows the rule and number of pruned frames, also for a run without bench and operator") {
  StoreOfPages store;
  store.add([](db::RunRecord& run) {
    run.bench_id = "";
    run.operator_name = "";
    run.git_dirty = false;
    run.devices.clear();
  });
  store.store.add_note(1, "the door was open");
  store.store.add_note(1, "and the light on");
  store.store.set_tags(1, {"nightly"}, {});
  (void)store.store.prune_frames(1, "old nights", kUtc);
  store.store.void_run(1, "gauge closed", "K. Lee", kUtc);
  const nlohmann::json printed = store.shown(1);
  CHECK(printed.at("pruned") == nlohmann::json{{"frames", 3}, {"rule", "old nights"}, {"pruned_utc", kUtc}});
  const auto listed = nlohmann::json::parse(store.runs({"list", "--all", "--json"}).out).at("runs");
  CHECK(listed.at(0).at("frames_pruned") == 3);
}

TEST_CASE("runs list: counts void runs, and marks whether a run that has not ended has a live process") {
  StoreOfPages store;
  for (int i = 0; i < 3; ++i) store.add();
  (void)begin_example(store.store);
  store.store.void_run(1, "door", "K. Lee", kUtc);
  store.store.void_run(2, "door", "K. Lee", kUtc);
  const bench::RunLock lock(store.path);
  CHECK(nlohmann::json::parse(store.runs({"list", "--json"}).out).at("runs").at(1).at("lives") == false);
  lock.lock_for_resume(4);
  CHECK(nlohmann::json::parse(store.runs({"list", "--all", "--json"}).out).at("runs").size() == 4);
  const auto printed = nlohmann::json::parse(store.runs({"list", "--json"}).out);
  CHECK(printed.at("void_left_out") == 2);
  REQUIRE(printed.at("runs").size() == 2);
  CHECK(printed.at("runs").at(0).at("frames") == 3);
  CHECK_FALSE(printed.at("runs").at(0).contains("lives"));
  CHECK(printed.at("runs").at(1).at("lives") == true);
  CHECK(printed.at("runs").at(1).at("frames") == 0);
}

TEST_CASE("runs list: in a file or a pipe one complete line per run, with lot, recipes and the full purpose") {
  StoreOfPages store;
  const std::string purpose = "of the first film " + std::string(300, 'x') + " and its end";
  store.add([&](db::RunRecord& run) { run.purpose = purpose; });
  store.add();
  store.store.set_tags(1, {"lot=A7", "night"}, {});
  const std::string out = store.runs({"list"}).out;
  const std::size_t at = out.find("A7");
  REQUIRE(at != std::string::npos);
  const std::size_t begin = out.rfind('\n', at) + 1;
  const std::string line = out.substr(begin, out.find('\n', at) - begin);
  const std::string recipe = example_run().sequences.front().name;
  CHECK(line.find(recipe) < line.find(purpose));
  CHECK_THAT(line, Catch::Contains(purpose) && Catch::EndsWith("[night]"));
}

TEST_CASE("runs diff: names members by path and settings by key, and ignores host and time") {
  StoreOfPages store;
  store.add();
  store.add([](db::RunRecord& run) {
    run.overrides_json = R"([{"key":"a","value":"2"},{"key":"b","value":"3"},{"value":"4"},7])";
    run.host = "host-b";
    run.time_zone = "UTC";
    run.started_utc = "2025-01-01T00:00:00Z";
    run.rest_s = 5.0;
    run.devices[1].model = "T-2";
    run.sequences[0].repeats = 3;
  });
  const auto diff = [&](const std::string& second) {
    return nlohmann::json::parse(store.runs({"diff", "1", second, "--json"}).out);
  };
  std::vector<std::string> named;
  const nlohmann::json differences = diff("2").at("differences");
  for (const nlohmann::json& one : differences) named.push_back(one.at("what"));
  CHECK(named == std::vector<std::string>{"overrides.a", "overrides.b", "content_sha256", "recipes[0].repeats",
                                          "devices[1].model"});
  CHECK(store.runs({"diff", "1", "2"}).code == 1);
  store.add();
  CHECK(diff("3").at("differences").empty());
  store.store.set_tags(1, {"lot=A7", "night"}, {});
  store.store.set_tags(3, {"lot=A8", "film=B"}, {});
  const nlohmann::json printed = diff("3");
  CHECK(printed.at("differences") ==
        nlohmann::json::parse(R"([{"what": "tags", "first": "[\"night\"]", "second": "[]"}])"));
  CHECK(printed.at("metadata").size() == 2);
  CHECK(printed.at("frames_equal") == 3);
  CHECK(printed.at("first_frame") == 0);
}

TEST_CASE("runs diff: compares verdicts, and a run with fewer frames") {
  StoreOfPages store;
  store.add();
  store.add();
  const auto row = [](double value) {
    db::VerdictRecord one{0, 0, "mismatch", "level", value, 0.05, "FS", "simple", "pass", "limits", "sha"};
    one.low_psi = one.high_psi = 40.0;
    one.direction = "up";
    return one;
  };
  const auto differences = [&](const std::string& second) {
    return nlohmann::json::parse(store.runs({"diff", "1", second, "--json"}).out).at("differences");
  };
  store.store.replace_verdicts(1, 0, {row(0.03)});
  REQUIRE(differences("2").size() == 1);
  CHECK(differences("2").at(0).at("second") == "nothing");
  store.store.replace_verdicts(2, 0, {row(0.04)});
  REQUIRE(differences("2").size() == 1);
  CHECK(differences("2").at(0).at("second") != "nothing");
  const Begun fewer = begin_example(store.store);
  store.store.append_frame(fewer.run, example_frame(fewer.branch, 0));
  store.store.end_run(fewer.run, db::Outcome::kFailed, "x", db::SafeState::kVerified, kUtc);
  const auto less = nlohmann::json::parse(store.runs({"diff", "1", std::to_string(fewer.run), "--json"}).out);
  CHECK(less.at("frames_equal") == 1);
  CHECK(less.at("first_frame") == 0);
}

TEST_CASE("runs show: lists checks with details, and events with time") {
  StoreOfPages store;
  const std::int64_t run = begin_example(store.store).run;
  const char* const detail = R"({"findings": [{"text": "first"}, {"text": "second"}], "n": 1})";
  store.store.append_check(run, {run, 1'250'000'000, "tare", "pass", detail, {}});
  store.store.append_check(run, {run, 3'000'000'000, "tare", "pass", R"({"findings":[]})", {}});
  store.store.append_event(run, {1'250'000'000, "fault", "TB-X", "one"});
  store.store.append_event(run, {2'500'000'000, "command", "", "two"});
  store.store.end_run(run, db::Outcome::kCompleted, "done", db::SafeState::kVerified, kUtc);
  const nlohmann::json printed = store.shown(run);
  REQUIRE(printed.at("checks").size() == 2);
  CHECK(printed.at("checks").at(0) ==
        nlohmann::json{
            {"time_s", 1.25}, {"kind", "tare"}, {"verdict", "pass"}, {"detail", nlohmann::json::parse(detail)}});
  CHECK(printed.at("events") ==
        nlohmann::json::parse(R"([{"time_s": 1.25, "kind": "fault", "id": "TB-X", "detail": "one"},
                                  {"time_s": 2.5, "kind": "command", "id": "", "detail": "two"}])"));
}

TEST_CASE("runs show: shows the specimen of simulated runs only") {
  StoreOfPages store;
  const auto simulated = [](db::RunRecord& run) {
    run.bench_toml = bench_text("simulated") + "[simulation]\nspecimen = \"harsh\"\n";
    run.overrides_json = "[]";
  };
  CHECK(store.shown(store.add(simulated)).at("specimen") == "harsh");
  CHECK(store.runs({"show", "1"}).code == 0);
  CHECK_FALSE(store
                  .shown(store.add([&](db::RunRecord& run) {
                    simulated(run);
                    run.origin = "hardware";
                  }))
                  .contains("specimen"));
  CHECK_FALSE(store
                  .shown(store.add([&](db::RunRecord& run) {
                    simulated(run);
                    run.bench_toml = bench_text("hardware");
                  }))
                  .contains("specimen"));
  CHECK(store.runs({}).code == 2);  // a verb is needed
}

// Metadata of the command line as tags, at the length that a tag may have, and as a filter.

namespace {

using Tags = std::vector<std::string>;

std::string metadata_refusal(const MetadataOptions& options) {
  const auto error = tests::refusal_by([&] { (void)bench::metadata_tags(options); });
  return error ? error->id() + " at " + error->where() : "";
}

MetadataOptions with_pairs(const Tags& pairs) {
  MetadataOptions options;
  options.pairs = pairs;
  return options;
}

}  // namespace

TEST_CASE("metadata tags: lot and order come first, then the pairs in the given order") {
  MetadataOptions options = with_pairs({"film=B12", "a.b_c:/+-Z9=x=y"});
  CHECK_FALSE(metadata_refusal(options).empty());  // no sign of equality in a value
  options.pairs = {"film=B12", "a.b_c:/+-Z9=0aZ._:/+-"};
  options.lot = "A7";
  options.order = "55/26";
  CHECK(bench::metadata_tags(options) == Tags{"lot=A7", "order=55/26", "film=B12", "a.b_c:/+-Z9=0aZ._:/+-"});
  CHECK(bench::metadata_tags({}).empty());
  CHECK(bench::metadata_tags(with_pairs({"k=" + std::string(62, 'x')})).size() == 1);  // 64 characters
}

TEST_CASE("metadata tags: rejects invalid values, and names the option") {
  for (const std::string& pair : Tags{"=x", "a=", "a b=x", "a=x y", "a=\xC3\xA4", "a@=x", "a[=x", "a`=x", "a{=x", "a=;",
                                      "a=,", "k=" + std::string(63, 'x'), "film"})
    CHECK(metadata_refusal(with_pairs({pair})) == "TB-USAGE at --meta");
  MetadataOptions lot, order;
  lot.lot = "a b";
  CHECK(metadata_refusal(lot) == "TB-USAGE at --lot");
  order.order = "#";
  CHECK(metadata_refusal(order) == "TB-USAGE at --order");
  CHECK(metadata_refusal(with_pairs({"a=1", "b=1", "a=2"})) == "TB-USAGE at --meta");
  MetadataOptions both = with_pairs({"lot=1"});
  both.lot = "1";
  CHECK(metadata_refusal(both) == "TB-USAGE at --meta");
  both = with_pairs({"order=1"});
  both.order = "1";
  CHECK(metadata_refusal(both) == "TB-USAGE at --meta");
}

TEST_CASE("metadata filter: all given pairs must match, a key alone matches any value") {
  db::RunRecord run;
  run.tags = {"film=B12", "lot=A7", "night", "order=55/26"};
  const auto fits = [&](const std::string& lot, const std::string& order, const Tags& pairs) {
    MetadataOptions asked = with_pairs(pairs);
    asked.lot = lot;
    asked.order = order;
    return bench::fits_metadata(asked, run);
  };
  CHECK(fits("", "", {}));
  CHECK(fits("A7", "55/26", {"film=B12", "film", "lot=A7"}));
  CHECK_FALSE(fits("A8", "", {}));
  CHECK_FALSE(fits("", "55", {}));
  CHECK_FALSE(fits("A7", "55", {}));
  CHECK_FALSE(fits("A8", "55/26", {}));
  CHECK_FALSE(fits("A7", "55/26", {"film=B13"}));
  CHECK_FALSE(fits("", "", {"film", "station"}));
  CHECK_FALSE(fits("", "", {"night"}));  // a tag, no metadata
  CHECK_FALSE(fits("", "", {"station=left"}));
}

// sensors add, list and show, of a sensor with all its words and of one without.

using Told = nlohmann::ordered_json;

namespace {

struct StoreOfSensors : StoreHere {
  StoreOfSensors() {
    db::RunStore store = open();
    store.add_sensor({"S-0", "a-very-long-name-of-a-type-of-32c", "rows = 2\n", "h0", "", "", kUtc});
    store_example(store);  // S-1
    db::RunRecord other = example_run();
    other.sensor_serial = "S-0";
    store_example(store, other);
    store_example(store);
  }
  Finished sensors(std::vector<std::string> words) const {
    words.insert(words.begin(), "sensors");
    return say(bench::add_sensors, words);
  }
};

}  // namespace

TEST_CASE("sensors list and show: the JSON documents have their members") {
  const StoreOfSensors store;
  const Told printed = Told::parse(store.sensors({"list", "--json"}).out);
  CHECK(printed.at("schema") == "tactbench.sensors.list");
  REQUIRE(printed.at("sensors").size() == 2);
  CHECK(printed.at("sensors").at(0).at("serial") == "S-0");
  CHECK(printed.at("sensors").at(1).at("scanner") == "SC-7");
  const Told one = Told::parse(store.sensors({"show", "S-1", "--json"}).out);
  CHECK(one.at("schema") == "tactbench.sensors.show");
  CHECK(one.at("serial") == "S-1");
  CHECK(one.at("runs") == Told::array({1, 3}));
  CHECK(one.at("type_toml") == "rows = 3\n");
}

TEST_CASE("sensors show: rejects a sensor that is not registered") {
  check_refusal(StoreOfSensors().sensors({"show", "S-2"}), 2, "TB-SENSOR-UNKNOWN");
}

TEST_CASE("sensors add: stores the sensor with its type file and the time") {
  const StoreOfSensors store;
  const std::string type = source_path("bench/config/sensor.toml");
  CHECK(store.sensors({"add", "S-9", "--type", type, "--scanner", "SC-9", "--note", "from lot A7"}).code == 0);
  const db::RunStore open = db::RunStore::open_read_only(store.path);
  const auto sensor = open.sensor("S-9");
  REQUIRE(sensor);
  CHECK(sensor->type_toml == read_file(type));
  CHECK(sensor->type_sha256 == db::sha256_hex(read_file(type)));
  CHECK(sensor->scanner_serial == "SC-9");
  CHECK(sensor->note == "from lot A7");
  CHECK(sensor->added_utc > "2026");
  const Told printed = Told::parse(store.sensors({"add", "S-8", "--type", type, "--json"}).out);
  check_members(printed, R"({"schema": "tactbench.sensors.add", "serial": "S-8", "scanner": ""})");
  CHECK(store.sensors({"add", "S-7", "--type", store.folder.path("none.toml")}).code == 2);
}

// verify and verify of runs without models: as stored, changed, pruned, not ended.

namespace {

struct StoreToVerify : OpenStoreHere {
  StoreToVerify() { (void)store_example(store); }
  Finished verify() const { return say(bench::add_verify, {"verify", "1"}); }
  [[nodiscard]] nlohmann::json verify_result() const {
    return printed<nlohmann::json>(bench::add_verify, {"verify", "1"});
  }
  void change(const char* sql) const { db::sqlite::Connection(path, db::sqlite::Access::kReadWrite).execute(sql); }
  [[nodiscard]] std::string hash() const { return store.run(1).content_sha256; }
};

}  // namespace

TEST_CASE("verify: an unchanged stored run passes") {
  const StoreToVerify store;
  CHECK(store.verify().code == 0);
  const nlohmann::json printed = store.verify_result();
  check_members(printed, R"({"run": 1, "origin": "simulated", "holds": true})");
  CHECK(printed.at("pruned").is_null());
  CHECK(printed.at("first_difference") == "");
  CHECK(printed.at("content") ==
        nlohmann::json{
            {"holds", true}, {"frames", 3}, {"stored_sha256", store.hash()}, {"computed_sha256", store.hash()}});
  CHECK(printed.at("beside").empty());
  CHECK(printed.at("analysis").empty());
  CHECK_THAT(verb_here(bench::add_verify, {"verify", "x", "--db", store.path}).err, Catch::Contains("[TB-USAGE]"));
}

TEST_CASE("verify: exit code 5 for changed content or a changed approval") {
  StoreToVerify store;
  store.store.add_report({1, "1-a", "h", "K. Lee", kUtc, "", ""});
  store.change("UPDATE reports SET approved_by = 'B'");
  CHECK(store.verify().code == 5);
  CHECK(store.verify_result().at("beside").size() == 1);
  store.change("UPDATE frames SET status = 9 WHERE frame = (SELECT min(frame) FROM frames)");
  CHECK(store.verify().code == 5);
  const nlohmann::json printed = store.verify_result();
  CHECK(printed.at("holds") == false);
  CHECK(printed.at("content").at("holds") == false);
  CHECK(printed.at("content").at("computed_sha256") != store.hash());
}

TEST_CASE("verify: exit code 6 for a run with pruned frames, a run that has not ended is rejected") {
  StoreToVerify store;
  store.store.set_tags(1, {"nightly"}, {});
  (void)store.store.prune_frames(1, "old nights", kUtc);
  CHECK(store.verify().code == 6);
  const nlohmann::json printed = store.verify_result();
  CHECK(printed.at("pruned") == nlohmann::json{{"frames", 3}, {"rule", "old nights"}, {"pruned_utc", kUtc}});
  store.change("UPDATE runs SET seed = 8");
  CHECK(store.verify().code == 5);
  (void)begin_example(store.store);
  check_refusal(verb_here(bench::add_verify, {"verify", "2", "--db", store.path}), 6, "TB-VERIFY-NOT-ENDED");
}

// runs diff: trees compared with words, settings without a key, tags and checks, and the first count that differs.

namespace {

struct PairOfRuns : OpenStoreHere {
  std::int64_t add(const std::function<void(db::RunRecord&)>& change,
                   const std::function<void(db::FrameRecord&)>& change_frame = {}, const char* verdict = "pass") {
    db::RunRecord run = example_run();
    change(run);
    const Begun begun = begin_example(store, run);
    if (change_frame) {
      db::FrameRecord frame = example_frame(begun.branch, 0);
      change_frame(frame);
      store.append_frame(begun.run, frame);
    }
    store.append_check(begun.run, {begun.run, 4, "seating", verdict, "{}", {}});
    store.end_run(begun.run, db::Outcome::kCompleted, "", db::SafeState::kVerified, kUtc);
    return begun.run;
  }
  std::int64_t add_settings(const char* overrides) {
    return add([&](db::RunRecord& run) { run.overrides_json = overrides; });
  }
  std::int64_t add_frame(const std::function<void(db::FrameRecord&)>& change) {
    return add([](db::RunRecord&) {}, change);
  }
  Finished diff(std::int64_t first, std::int64_t second, const std::vector<std::string>& more = {}) const {
    return verb_here(bench::add_runs,
                     joined({"runs", "diff", std::to_string(first), std::to_string(second), "--db", path}, more));
  }
  [[nodiscard]] nlohmann::json printed(std::int64_t first, std::int64_t second) const {
    return nlohmann::json::parse(diff(first, second, {"--json"}).out);
  }
  // As "what: first | second", without the hashes.
  [[nodiscard]] std::string differences(std::int64_t first, std::int64_t second) const {
    std::string text;
    const nlohmann::json found = printed(first, second).at("differences");
    for (const nlohmann::json& one : found)
      if (one.at("what") != "content_sha256")
        text += one.at("what").get<std::string>() + ": " + one.at("first").get<std::string>() + " | " +
                one.at("second").get<std::string>() + "\n";
    return text;
  }
};

}  // namespace

TEST_CASE("runs diff: compares settings of different types: object, list, text and none") {
  PairOfRuns runs;
  const std::int64_t none = runs.add_settings("[]");
  const std::int64_t tree = runs.add_settings(R"([{"key":"a","value":{"x":1}}])");
  const std::int64_t word = runs.add_settings(R"([{"key":"a","value":"s"}])");
  const std::int64_t list = runs.add_settings(R"([{"key":"a","value":[1]}])");
  const std::int64_t other = runs.add_settings(R"([{"key":5,"value":"s"},{"key":"b"}])");
  CHECK(runs.differences(none, tree) == "overrides.a.x: nothing | 1\n");
  CHECK(runs.differences(tree, none) == "overrides.a.x: 1 | nothing\n");
  CHECK(runs.differences(tree, word) == "overrides.a: {\"x\":1} | s\n");
  CHECK(runs.differences(word, tree) == "overrides.a: s | {\"x\":1}\n");
  CHECK(runs.differences(list, word) == "overrides.a: [1] | s\n");
  CHECK(runs.differences(word, list) == "overrides.a: s | [1]\n");
  CHECK(runs.differences(none, other).empty());
}

TEST_CASE("runs diff: a tag or a check counts as a difference if content and frames are equal") {
  PairOfRuns runs;
  const auto same = [](db::RunRecord&) {};
  const std::int64_t first = runs.add(same), second = runs.add(same), third = runs.add(same, {}, "warning");
  CHECK(runs.diff(first, second).code == 0);
  runs.store.set_tags(second, {"night"}, {});
  CHECK(runs.diff(first, second).code == 1);
  CHECK(runs.differences(first, second) == "tags: [] | [\"night\"]\n");
  CHECK(runs.differences(first, third) == "checks[0]: seating pass | seating warning\n");
  const std::int64_t open = begin_example(runs.store).run, more = begin_example(runs.store).run;
  CHECK(runs.diff(open, more).code == 1);  // without a hash
}

TEST_CASE("runs diff: compares each value of a frame") {
  PairOfRuns runs;
  const std::int64_t first = runs.add_frame([](db::FrameRecord&) {});
  CHECK(runs.diff(first, runs.add_frame([](db::FrameRecord&) {})).code == 0);
  const std::vector<std::function<void(db::FrameRecord&)>> changes = {
      [](db::FrameRecord& f) { f.ordinal = 2; },
      [](db::FrameRecord& f) { f.setpoint_psi = 1.5; },
      [](db::FrameRecord& f) { f.reference_psi = 0.25; },
      [](db::FrameRecord& f) { f.feedback_psi = 1.5; },
      [](db::FrameRecord& f) { f.feedback_psi = NAN; },
      [](db::FrameRecord& f) { f.time_ns = 5; },
      [](db::FrameRecord& f) { f.flags = "x"; },
      [](db::FrameRecord& f) { f.counts[0] = 3; },
      [](db::FrameRecord& f) { f.counts[7] = 3; },
      [](db::FrameRecord& f) {
        f.scans = 1;
        f.counts.resize(6);
      }};
  for (std::size_t i = 0; i < changes.size(); ++i) {
    INFO(i);
    const nlohmann::json printed = runs.printed(first, runs.add_frame(changes[i]));
    check_members(printed, R"({"same_content": false, "frames_equal": 0, "first_frame": 1})");
  }
  const std::int64_t gap = runs.add_frame([](db::FrameRecord& f) { f.feedback_psi = NAN; });
  const std::int64_t gap_too = runs.add_frame([](db::FrameRecord& f) { f.feedback_psi = NAN; });
  CHECK(runs.diff(gap, gap_too).code == 0);
}
