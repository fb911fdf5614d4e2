// runs export --format hdf5 of two known frames, read back by h5dump of the HDF Group.
#include <catch2/catch.hpp>
#include <cstdint>
#include <filesystem>
#include <map>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "db/run_store.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

constexpr const char* kDump = "/usr/bin/h5dump";

void store_two_frames(const std::string& path) {
  db::RunStore store = db::RunStore::open(path, db::Durability::kNormal);
  db::RunRecord run;
  run.uuid = db::new_uuid();
  run.origin = "simulated";
  run.state = "prepared";
  run.seed = 7;
  run.bench_toml = "bench";
  run.sequences = {{0, "up", "recipe", "", 2, 1}};
  run.devices = {{"tactile scanner", "T", "SC-1", "", "simulated", R"({"volts_per_count":0.25})"}};
  const std::int64_t number = store.begin_run(run);
  db::BranchRecord branch;
  branch.ordinal = 1;
  branch.attempt = 2;
  branch.from_psi = 0.5;
  branch.to_psi = 60.0;
  db::FrameRecord frame;
  frame.branch = store.begin_branch(number, branch);
  frame.setpoint_psi = 1.5;
  frame.feedback_psi = 1.25;
  frame.reference_psi = 1.125;
  frame.setpoint_counts = 11;
  frame.feedback_counts = 12;
  frame.reference_counts = 13;
  frame.time_ns = 1'500'000'000;
  frame.since_command_ns = 500;
  frame.in_band_ns = 250;
  frame.device_time_us = 7;
  frame.status = 3;
  frame.exchanges = 9;
  frame.flags = "dwell";
  frame.rows = 1;
  frame.columns = frame.scans = 2;
  frame.counts = {1, 2, 3, 4};
  frame.trace = {{0.5F, 1.0F, 2.0F, 3.0F}};
  store.append_frame(number, frame);
  branch.ordinal = branch.attempt = 0;
  branch.repeat = 1;
  branch.from_n = 2.5;
  branch.to_n = 30.0;
  frame.branch = store.begin_branch(number, branch);
  frame.ordinal = 1;
  frame.flags.clear();
  frame.counts = {5, 6, 7, 8};
  frame.trace = {{0.25F, 4.0F, 5.0F, 6.0F}, {0.125F, 7.0F, 8.0F, 9.0F}};
  frame.wrench = db::WrenchRecord{2.5, 2.25, {1, 2, 3, 4, 5, 6.5}, {6, 5, 4, 3, 2, 1}, {10, 20, 30}};
  store.append_frame(number, frame);
  store.void_branch(frame.branch, "torn");
  store.append_event(number, {42, "fault", "TB-X", "it broke"});
  store.append_check(number, {number, 43, "seating", "pass", R"({"a":1})", {}});
  store.end_run(number, db::Outcome::kCompleted, "", db::SafeState::kVerified, "");
  store.replace_verdicts(number, 0,
                         {{number, 0, "unfit_taxels", "array", 1.0, 1.5, "taxels", "simple", "pass", "l", "s"}});
  run.uuid = db::new_uuid();
  const std::int64_t imported = store.begin_run(run);
  store.append_series(imported, {{0, 3, {1.0, 2.5}, {0.5, 0.25}}});
  store.end_run(imported, db::Outcome::kCompleted, "", db::SafeState::kVerified, "");
}

std::string dumped(const TemporaryFolder& folder, const std::vector<std::string>& words) {
  const Finished finished = run_program(kDump, words, folder.path());
  INFO(finished.err);
  REQUIRE(finished.code == 0);
  return finished.out;
}

// What stands behind `head` as data, on one line.
std::string data_behind(const std::string& dump, const std::string& head) {
  const std::size_t place = dump.find(head);
  if (place == std::string::npos) return "not there";
  const std::size_t from = dump.find("DATA {", place) + 6;
  std::istringstream words(dump.substr(from, dump.find("}\n", from) - from));
  std::string line;
  for (std::string word; words >> word;) line += (line.empty() ? "" : " ") + word;
  return line;
}

}  // namespace

TEST_CASE("a run as HDF5 holds every field of its frames, branches and remarks, with units") {
  const TemporaryFolder folder;
  store_two_frames(folder.path("runs.db"));
  const Finished made = call(folder, {"runs", "export", "1", "--format", "hdf5", "-o", "run.h5"});
  if (made.code != 0 || !std::filesystem::exists(kDump)) {
    CHECK((made.code == 0 || made.err.find("built without") != std::string::npos));
    WARN("skipped: no libhdf5 in this build, or no h5dump");
    return;
  }
  CHECK_THAT(made.out, Catch::Contains(std::to_string(std::filesystem::file_size(folder.path("run.h5"))) + " bytes"));
  const std::map<std::string, std::string> expected = {
      {"/frames/branch", "0, 1"},
      {"/frames/step", "0, 1"},
      {"/frames/setpoint_psi", "1.5, 1.5"},
      {"/frames/feedback_psi", "1.25, 1.25"},
      {"/frames/reference_psi", "1.125, 1.125"},
      {"/frames/setpoint_counts", "11, 11"},
      {"/frames/feedback_counts", "12, 12"},
      {"/frames/reference_counts", "13, 13"},
      {"/frames/time_ns", "1500000000, 1500000000"},
      {"/frames/since_command_ns", "500, 500"},
      {"/frames/in_band_ns", "250, 250"},
      {"/frames/device_time_us", "7, 7"},
      {"/frames/status", "3, 3"},
      {"/frames/exchanges", "9, 9"},
      {"/frames/flags", "\"dwell\", \"\""},
      {"/frames/counts", "1, 2, 3, 4, 5, 6, 7, 8"},
      {"/frames/target_n", "nan, 2.5"},
      {"/frames/force_start_n", "nan, 2.25"},
      {"/frames/wrench", "nan, nan, nan, nan, nan, nan, 1, 2, 3, 4, 5, 6.5"},
      {"/frames/wrench_raw", "nan, nan, nan, nan, nan, nan, 6, 5, 4, 3, 2, 1"},
      {"/frames/place_mm", "nan, nan, nan, 10, 20, 30"},
      {"/trace/frame", "0, 1, 1"},
      {"/trace/before_frame_s", "0.5, 0.25, 0.125"},
      {"/trace/setpoint_psi", "1, 4, 7"},
      {"/trace/feedback_psi", "2, 5, 8"},
      {"/trace/reference_psi", "3, 6, 9"},
      {"/branches/sequence", "0, 0"},
      {"/branches/repeat", "0, 1"},
      {"/branches/ordinal", "1, 0"},
      {"/branches/attempt", "2, 0"},
      {"/branches/void", "0, 1"},
      {"/branches/void_reason", "\"\", \"torn\""},
      {"/branches/from_psi", "0.5, 0.5"},
      {"/branches/to_psi", "60, 60"},
      {"/branches/from_n", "nan, 2.5"},
      {"/branches/to_n", "nan, 30"},
      {"/checks/time_ns", "43"},
      {"/checks/kind", "\"seating\""},
      {"/checks/verdict", "\"pass\""},
      {"/checks/detail_json", "\"{\"a\":1}\""},
      {"/verdicts/criterion", "\"unfit_taxels\""},
      {"/verdicts/scope", "\"array\""},
      {"/verdicts/value", "1"},
      {"/verdicts/limit", "1.5"},
      {"/verdicts/unit", "\"taxels\""},
      {"/verdicts/rule", "\"simple\""},
      {"/verdicts/verdict", "\"pass\""},
      {"/verdicts/limits_sha256", "\"s\""},
      {"/configuration/bench_toml", "\"bench\""},
      {"/configuration/sensor_toml", "\"\""},
      {"/configuration/overrides_json", "\"\""},
      {"/configuration/notes", "\"\""},
      {"/recipes/0/toml", "\"recipe\""},
      {"/devices/0/calibration_json", "\"{\"volts_per_count\":0.25}\""},
  };
  std::vector<std::string> words = {"-y", "-w", "0"};
  for (const auto& [name, values] : expected) words.insert(words.end(), {"-d", name});
  for (const char* name : {"/events/time_ns", "/events/kind", "/events/id", "/events/detail"})
    words.insert(words.end(), {"-d", name});
  words.emplace_back("run.h5");
  const std::string dump = dumped(folder, words);
  for (const auto& [name, values] : expected) {
    INFO(name);
    CHECK(data_behind(dump, "DATASET \"" + name + "\" {") == values);
  }
  for (const auto& [name, value] :
       {std::pair{"time_ns", "42"}, {"kind", "\"fault\""}, {"id", "\"TB-X\""}, {"detail", "\"it broke\""}})
    CHECK_THAT(data_behind(dump, std::string("DATASET \"/events/") + name + "\" {"), Catch::Contains(value));
  CHECK_THAT(dump, Catch::Contains("SIMPLE { ( 2, 2, 1, 2 )") && Catch::Contains("SIMPLE { ( 2, 6 )") &&
                       Catch::Contains("SIMPLE { ( 2, 3 )"));
  for (const auto& [name, unit] : {std::pair{"/frames/setpoint_psi", "psi"},
                                   {"/frames/time_ns", "ns"},
                                   {"/frames/place_mm", "mm"},
                                   {"/frames/counts", "count"},
                                   {"/trace/before_frame_s", "s"},
                                   {"/branches/from_n", "N"}}) {
    const std::size_t place = dump.find(std::string("DATASET \"") + name + "\" {");
    REQUIRE(place != std::string::npos);
    CHECK(data_behind(dump.substr(place), "ATTRIBUTE \"units\"") == std::string("\"") + unit + "\"");
  }
  const std::string attributes = dumped(folder, {"-y",
                                                 "-w",
                                                 "0",
                                                 "-a",
                                                 "/schema",
                                                 "-a",
                                                 "/version",
                                                 "-a",
                                                 "/seed",
                                                 "-a",
                                                 "/void",
                                                 "-a",
                                                 "/rest_s",
                                                 "-a",
                                                 "/tags",
                                                 "-a",
                                                 "/recipes/0/repeats",
                                                 "-a",
                                                 "/devices/0/role",
                                                 "-a",
                                                 "/frames/counts/volts_per_count",
                                                 "-a",
                                                 "/frames/axes",
                                                 "run.h5"});
  for (const auto& [name, value] : {std::pair{"schema", "\"tactbench.run\""},
                                    {"version", "2"},
                                    {"seed", "7"},
                                    {"void", "0"},
                                    {"rest_s", "nan"},
                                    {"tags", "\"\""},
                                    {"repeats", "2"},
                                    {"role", "\"tactile scanner\""},
                                    {"volts_per_count", "0.25"},
                                    {"axes", "\"frame\", \"scan\", \"row\", \"column\""}}) {
    INFO(name);
    CHECK(data_behind(attributes, std::string("ATTRIBUTE \"") + name + "\"") == value);
  }
  REQUIRE(call(folder, {"runs", "export", "2", "--format", "hdf5", "-o", "series.h5"}).code == 0);
  const std::string series = dumped(folder, {"-y", "-w", "0", "-d", "/series/0/input", "-d", "/series/0/output", "-a",
                                             "/series/0/taxel", "-a", "/series/0/sequence", "series.h5"});
  CHECK(data_behind(series, "DATASET \"/series/0/input\"") == "1, 2.5");
  CHECK(data_behind(series, "DATASET \"/series/0/output\"") == "0.5, 0.25");
  CHECK(data_behind(series, "ATTRIBUTE \"taxel\"") == "3");
  CHECK(data_behind(series, "ATTRIBUTE \"sequence\"") == "0");
}
