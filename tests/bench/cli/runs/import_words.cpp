// import: what it prints and stores of a table, row by row; and the doubts that it tells.
#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/bench/cli/verb_here.h"
#include "tests/db/store_example.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

// Two sequences, of seven and of five rows, on two taxels.
const std::string kRowsOfTwo =
    "sequence,input,output,taxel\n"
    "up,0,0,0\nup,1,1.5,0\nup,2,2.5,0\nup,3,4,0\nup,2,3.5,0\nup,1,2,0\nup,0,0.1,0\n"
    "two,0,0,3\ntwo,1,1.4,3\ntwo,2,2.6,3\ntwo,1,2.1,3\ntwo,0,0,3\n";

struct TableToImport {
  explicit TableToImport(const std::string& text) { write_file(file, text); }
  Finished import(std::vector<std::string> more = {}) const {
    more.insert(more.begin(), {"import", file, "--db", path});
    return verb_here(bench::add_import, more);
  }
  [[nodiscard]] db::RunStore store() const { return db::RunStore::open_read_only(path); }
  TemporaryFolder folder;
  std::string file = folder.path("own.csv"), path = folder.path("runs.db");
};

}  // namespace

TEST_CASE("import: what is printed, and the run that is stored") {
  const TableToImport table(kRowsOfTwo);
  const Finished done = table.import({"--operator", "K. Lee", "--purpose", "as measured"});
  CHECK(done.code == 0);
  CHECK(done.out == "run 1: 12 rows in 2 sequences imported from " + table.file + "\n");
  CHECK_THAT(done.err, Catch::StartsWith("warning: " + table.file + ": ") && !Catch::Contains("left out"));
  const db::RunStore store = table.store();
  const db::RunRecord run = store.run(1);
  CHECK(run.origin == "imported");
  CHECK(run.operator_name == "K. Lee");
  CHECK(run.purpose == "as measured");
  CHECK(run.outcome == db::Outcome::kCompleted);
  CHECK(run.reason == "imported");
  CHECK(run.safe_state == db::SafeState::kUnknown);
  CHECK_FALSE(run.ended_utc.empty());
  REQUIRE(run.sequences.size() == 2);
  CHECK(run.sequences[0].sequence == 0);
  CHECK(run.sequences[0].name == "up");
  CHECK(run.sequences[0].repeats == 1);
  CHECK(run.sequences[0].frames_per_repeat == 7);
  CHECK(run.sequences[1].sequence == 1);
  CHECK(run.sequences[1].name == "two");
  CHECK(run.sequences[1].repeats == 1);
  CHECK(run.sequences[1].frames_per_repeat == 5);
  REQUIRE(run.devices.size() == 1);
  CHECK(run.devices[0].role == "table");
  CHECK(run.devices[0].model == "own.csv");
  CHECK(run.devices[0].serial == db::sha256_hex(kRowsOfTwo));
  CHECK(run.devices[0].firmware.empty());
  CHECK(run.devices[0].origin == "imported");
  CHECK(nlohmann::json::parse(run.devices[0].calibration_json) ==
        nlohmann::json{{"input_unit", ""}, {"output_unit", ""}, {"map", ""}});
  const std::vector<db::SeriesRecord> series = store.series(1);
  REQUIRE(series.size() == 2);
  CHECK(series[0].sequence == 0);
  CHECK(series[0].taxel == 0);
  CHECK(series[0].input == std::vector<double>{0, 1, 2, 3, 2, 1, 0});
  CHECK(series[0].output == std::vector<double>{0, 1.5, 2.5, 4, 3.5, 2, 0.1});
  CHECK(series[1].sequence == 1);
  CHECK(series[1].taxel == 3);
  CHECK(series[1].input == std::vector<double>{0, 1, 2, 1, 0});
  CHECK(series[1].output == std::vector<double>{0, 1.4, 2.6, 2.1, 0});
}

TEST_CASE("import: units of the command line before those of the table, and which columns were meant") {
  const TableToImport table("sequence,force,volts\n,N,V\na,0,0\na,1,1\na,2,2\na,1,1.5\na,0,0.1\n");
  REQUIRE(table.import({"--map", "input=force,output=3,sequence=sequence"}).code == 0);
  REQUIRE(table.import({"--map", "input=force,output=volts,sequence=1", "--input-unit", "kN", "--output-unit", "mV"})
              .code == 0);
  const auto calibration = [&](std::int64_t run) {
    return nlohmann::json::parse(table.store().run(run).devices.at(0).calibration_json);
  };
  CHECK(calibration(1) ==
        nlohmann::json{{"input_unit", "N"}, {"output_unit", "V"}, {"map", "input=force,output=3,sequence=sequence"}});
  CHECK(calibration(2) ==
        nlohmann::json{{"input_unit", "kN"}, {"output_unit", "mV"}, {"map", "input=force,output=volts,sequence=1"}});
  const auto told =
      nlohmann::ordered_json::parse(table.import({"--json", "--map", "input=force,output=volts,sequence=1"}).out);
  CHECK(told == nlohmann::ordered_json{{"schema", "tactbench.import"},
                                       {"version", 1},
                                       {"run", 3},
                                       {"rows", 5},
                                       {"left_out", 0},
                                       {"sequences", 1},
                                       {"sha256", db::sha256_hex(read_file(table.file))}});
}

TEST_CASE("import: rows that are left out are named, the first ones alone where there are many") {
  TableToImport table(kRowsOfTwo + "two,x,0,3\n");
  const Finished refused = table.import();
  CHECK(refused.code == 2);
  CHECK(refused.out.empty());
  CHECK_THAT(refused.err, Catch::Contains("own.csv:14: \"x\" in column input is not a number [TB-TABLE-ROW]"));
  const Finished one = table.import({"--skip-bad-rows"});
  CHECK(one.code == 0);
  const std::string named = "left out: " + table.file + ":14: \"x\" in column input is not a number\n";
  CHECK_THAT(one.err, Catch::StartsWith(named + "warning: " + table.file +
                                        ": 1 row left out by --skip-bad-rows\nwarning: " + table.file + ": "));
  CHECK(table.store().run(1).reason == "imported without 1 row that cannot be read");
  CHECK(nlohmann::json::parse(table.store().run(1).devices.at(0).calibration_json).at("rows_left_out") == 1);
  CHECK(nlohmann::json::parse(table.import({"--skip-bad-rows", "--json"}).out).at("left_out") == 1);
  std::string many = kRowsOfTwo;
  const auto check_many = [&](int count, const std::string& more) {
    for (int i = 0; i < 12; ++i) many += "two,0,0,3\n";
    write_file(
        table.file, many + [&] {
          std::string bad;
          for (int i = 0; i < count; ++i) bad += "two,x,0,3\n";
          return bad;
        }());
    const Finished left_out = table.import({"--skip-bad-rows"});
    CAPTURE(count);
    CHECK_THAT(left_out.err, Catch::Contains(fmt::format("\nwarning: {}: {} rows left out by --skip-bad-rows{}\n",
                                                         table.file, count, more)));
    return std::size_t(std::ranges::count(left_out.err, '\n'));
  };
  CHECK(check_many(20, "") > 20);
  CHECK(check_many(21, "; the first 20 are named") > 20);
  CHECK(table.store().run(4).reason == "imported without 21 rows that cannot be read");
}

TEST_CASE("import: what was assumed of separators is told, before doubts about the data") {
  const TableToImport table("input;output\n0;0\n1;1\n2;2\n1;1,5\n0;0,1\n");
  const Finished done = table.import();
  CHECK(done.code == 0);
  CHECK_THAT(done.err, Catch::StartsWith(table.file + ": columns are separated by semicolons\n"));
  CHECK(done.out == "run 1: 5 rows in 1 sequence imported from " + table.file + "\n");
}

TEST_CASE("import: a table on which no model can be fitted is refused, and nothing is stored") {
  const TableToImport table("sequence,input,output\na,0,0\n");
  const Finished refused = table.import();
  CHECK(refused.code == 2);
  CHECK(refused.err == "error: " + table.file +
                           ": sequence a of taxel 0 has 1 sample [TB-TABLE-SHORT]\n  try: a history of at least 4 "
                           "samples is needed to see a loop\n");
  CHECK_THROWS(table.store());
}
