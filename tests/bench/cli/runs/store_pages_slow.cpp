// What sensors, db check, baseline and trend print of a store that is known row by row.
#include <catch2/catch.hpp>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "db/run_store.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::tests;
using nlohmann::json;

namespace {

void check_told(const Finished& finished, const std::vector<std::string>& lines) {
  INFO(finished.out << finished.err);
  for (const std::string& line : lines) {
    INFO(line);
    CHECK(("\n" + finished.out).find("\n" + line + "\n") != std::string::npos);
  }
}

// A run a value, with that figure.
void store_figures(const std::string& path, const std::vector<double>& values) {
  db::RunStore store = db::RunStore::open(path, db::Durability::kNormal);
  store.add_sensor({"S-1", "array", "text of the type\n", "", "SC-1", "first", "2026-01-01T00:00:00Z"});
  store.add_sensor({"S-2", "array", "", "", "", "", "2026-01-01T00:00:00Z"});
  for (std::size_t i = 0; i < values.size(); ++i) {
    db::RunRecord run;
    run.uuid = db::new_uuid();
    run.origin = "hardware";
    run.state = "prepared";
    run.sensor_serial = "S-1";
    run.seed = static_cast<std::int64_t>(i);
    run.sequences = {{0, "levels", "", "", 1, 1}};
    const std::int64_t number = store.begin_run(run);
    db::FrameRecord frame;
    frame.branch = store.begin_branch(number, {});
    frame.rows = frame.columns = frame.scans = 1;
    frame.counts = {static_cast<std::uint16_t>(i)};
    store.append_frame(number, frame);
    store.end_run(number, db::Outcome::kCompleted, "", db::SafeState::kVerified, "");
    store.replace_figures(number, "rig/b-1", {{"error_psi", values[i]}});
  }
}

}  // namespace

TEST_CASE("sensors and db check print a known store") {
  const TemporaryFolder folder;
  store_figures(folder.path("runs.db"), {0.25, 0.5});
  check_told(call(folder, {"sensors", "list"}),
             {"serial          type                            scanner           note",
              "S-1             array                           SC-1              first",
              "S-2             array                           any               "});
  CHECK(call(folder, {"sensors", "show", "S-1"}).out ==
        "sensor S-1\n  type     array\n  scanner  SC-1\n  note     first\n  added    2026-01-01T00:00:00Z\n"
        "  runs     [1,2]\n\ntext of the type\n");
  CHECK(call(folder, {"sensors", "show", "S-2"}).out ==
        "sensor S-2\n  type     array\n  scanner  any\n  note     not stated\n  added    2026-01-01T00:00:00Z\n"
        "  runs     []\n\n");
  CHECK(json::parse(call(folder, {"sensors", "show", "S-1", "--json"}).out)["runs"] == json({1, 2}));
  CHECK(call(folder, {"sensors", "show", "S-3"}).code == 2);
  check_told(call(folder, {"db", "check"}),
             {"runs.db: structure sound; 2 runs as they were stored, 0 not, 0 not ended (no hash yet)"});
  const json checked = json::parse(call(folder, {"db", "check", "--json"}).out);
  CHECK(checked["holds"] == true);
  CHECK(checked["runs"][1]["ended"] == true);
  CHECK(checked["runs"][1]["frames"] == 1);
  {
    db::RunStore store = db::RunStore::open(folder.path("runs.db"), db::Durability::kNormal);
    db::RunRecord open;
    open.uuid = db::new_uuid();
    open.origin = "hardware";
    open.state = "prepared";
    (void)store.begin_run(open);
  }
  check_told(call(folder, {"db", "check"}),
             {"runs.db: structure sound; 2 runs as they were stored, 0 not, 1 not ended (no hash yet)"});
  check_told(call(folder, {"verify", "1"}), {"run 1 (hardware), 1 frame", "verified"});
}

TEST_CASE("baseline and trend print runs, ranges, repetitions and a row of blocks") {
  const TemporaryFolder folder;
  store_figures(folder.path("runs.db"), {0.25, 0.5, 0.75, 0.5, 0.25, 0.375, 0.625, 0.4375, 0.5625, 0.40625, 0.59375});
  check_told(call(folder, {"trend"}), {"rig/b-1: no baseline"});
  CHECK_THAT(call(folder, {"trend"}).out, Catch::Contains("\n  error_psi" + std::string(20, ' ') + "▁▅█▅▁▃▇▄▆▃▆ ") &&
                                              Catch::Contains("     0.59375\n") && !Catch::Contains("SIMULATED"));
  const std::string subject = "rig/b-1" + std::string(33, ' ');
  const std::vector<std::string> who = {"--by", "me", "--reason", "as made"};
  const auto accept = [&](std::vector<std::string> words) {
    words.insert(words.begin(), {"baseline", "accept"});
    words.insert(words.end(), who.begin(), who.end());
    return call(folder, words);
  };
  const Finished refused = accept({"1-9"});
  CHECK(refused.code == 2);
  CHECK_THAT(refused.err, Catch::Contains("[TB-BASELINE-SHORT]") &&
                              Catch::Contains("rig/b-1 has 7 measurements among these runs, each counted once; a chart "
                                              "needs 8, and 20 are recommended") &&
                              Catch::Contains("measure 1 more"));
  CHECK_THAT(call(folder, {"baseline", "list"}).out,
             Catch::StartsWith("no baseline is accepted: tactbench baseline accept RUNS --reason TEXT --by NAME"));
  CHECK(json::parse(call(folder, {"baseline", "list", "--json"}).out)["baselines"].empty());
  const std::string few = "fewer than 20 runs: charts find small shifts later (docs/nights.md)\n";
  CHECK(accept({"1-10"}).out == subject +
                                    " 10 runs accepted, 8 of them counted once each\n"
                                    "  run 4 repeats run 2: the same content, or the same figures\n"
                                    "  run 5 repeats run 1: the same content, or the same figures\n" +
                                    few);
  CHECK(accept({"1-3", "6-10"}).out == subject + " 8 runs accepted\n" + few);
  for (const char* wrong : {"0", "x", "1-", "1-x", "-1"}) CHECK(accept({wrong}).code == 2);
  CHECK(accept({"99"}).code != 0);
  const Finished list = call(folder, {"baseline", "list"});
  CHECK_THAT(list.out, Catch::StartsWith("   1  rig/b-1" + std::string(31, ' ') + "10 runs  2") &&
                           Catch::Contains("\n   2  rig/b-1" + std::string(32, ' ') + "8 runs  2") &&
                           Catch::Contains("Z  me: as made\n"));
  check_told(call(folder, {"trend"}), {"rig/b-1: baseline of 8 runs (as made)"});
  // 0.59375 psi = 4.0938 kPa; the data keep psi.
  CHECK_THAT(call(folder, {"trend", "--units", "kPa"}).out,
             Catch::Contains("\n  error_kpa ") && Catch::Contains("      4.0938  ") && !Catch::Contains("error_psi"));
  CHECK(call(folder, {"trend", "--units", "kPa", "--json"}).out == call(folder, {"trend", "--json"}).out);
  const json told = json::parse(call(folder, {"trend", "--json"}).out);
  const json& figure = told["subjects"][0]["figures"][0];
  CHECK(figure["values"].size() == 11);
  CHECK(figure["baseline"]["runs"] == 8);
  CHECK(figure["baseline"]["mean"] == Approx(0.48828125));
  CHECK(figure["baseline"]["logarithmic"] == false);
  CHECK(figure["ewma"]["runs"] == 1);
  CHECK(figure["ewma"]["deviations"] ==
        Approx(0.2 * (0.59375 - 0.48828125) / figure["baseline"]["deviation"].get<double>()));
  CHECK(figure["outside"] == false);
  CHECK(figure["shifted"] == false);
  CHECK(call(folder, {"trend", "--check"}).code == 0);
}
