// import: what it prints and stores of a table, row by row; and the doubts that it tells.

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
    more.insert(more.begin(), {"runs", "import", file, "--db", path});
    return verb_here(bench::add_runs, more);
  }
  [[nodiscard]] db::RunStore store() const { return db::RunStore::open_read_only(path); }
  TemporaryFolder folder;
  std::string file = folder.path("own.csv"), path = folder.path("runs.db");
};

}  // namespace

TEST_CASE("import: what is printed, and the run that is stored") {
  const TableToImport table(kRowsOfTwo);
  CHECK(table.import({"--operator", "K. Lee", "--purpose", "as measured"}).code == 0);
  const db::RunStore store = table.store();
  const db::RunRecord run = store.run(1);
  CHECK((run.origin == "imported" && run.operator_name == "K. Lee" && run.purpose == "as measured"));
  CHECK((run.outcome == db::Outcome::kCompleted && run.safe_state == db::SafeState::kUnknown));
  CHECK_FALSE(run.ended_utc.empty());
  REQUIRE(run.sequences.size() == 2);
  CHECK((run.sequences[0].name == "up" && run.sequences[0].repeats == 1 && run.sequences[0].frames_per_repeat == 7));
  CHECK((run.sequences[1].name == "two" && run.sequences[1].repeats == 1 && run.sequences[1].frames_per_repeat == 5));
  REQUIRE(run.devices.size() == 1);
  CHECK((run.devices[0].role == "table" && run.devices[0].model == "own.csv" && run.devices[0].origin == "imported"));
  CHECK(run.devices[0].serial == db::sha256_hex(kRowsOfTwo));
  CHECK(nlohmann::json::parse(run.devices[0].calibration_json) ==
        nlohmann::json{{"input_unit", ""}, {"output_unit", ""}, {"map", ""}});
  const std::vector<db::SeriesRecord> series = store.series(1);
  REQUIRE(series.size() == 2);
  CHECK((series[0].sequence == 0 && series[0].taxel == 0));
  CHECK(series[0].input == std::vector<double>{0, 1, 2, 3, 2, 1, 0});
  CHECK(series[0].output == std::vector<double>{0, 1.5, 2.5, 4, 3.5, 2, 0.1});
  CHECK((series[1].sequence == 1 && series[1].taxel == 3));
  CHECK(series[1].input == std::vector<double>{0, 1, 2, 1, 0});
  CHECK(series[1].output == std::vector<double>{0, 1.4, 2.6, 2.1, 0});
  CHECK(verb_here(bench::add_verify, {"verify", "1", "--db", table.path}).code == 0);
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

TEST_CASE("import: rows that are left out are counted") {
  TableToImport table(kRowsOfTwo + "two,x,0,3\n");
  const Finished refused = table.import();
  CHECK(refused.code == 2);
  CHECK(refused.out.empty());
  CHECK_THAT(refused.err, Catch::Contains("[TB-TABLE-ROW]") && Catch::Contains("own.csv:14"));
  CHECK(table.import({"--skip-bad-rows"}).code == 0);
  CHECK(nlohmann::json::parse(table.store().run(1).devices.at(0).calibration_json).at("rows_left_out") == 1);
  CHECK(nlohmann::json::parse(table.import({"--skip-bad-rows", "--json"}).out).at("left_out") == 1);
}

TEST_CASE("import: a table on which no model can be fitted is refused, and nothing is stored") {
  const TableToImport table("sequence,input,output\na,0,0\n");
  check_refusal(table.import(), 2, "TB-TABLE-SHORT");
  CHECK_THROWS(table.store());
}
