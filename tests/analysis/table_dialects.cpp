// Tables as people have them: decimal commas, lines of units, names with commas, blanks between columns, blank cells.
#include <catch2/catch.hpp>
#include <sstream>

#include "analysis/error.h"
#include "analysis/table.h"

using namespace tactbench::analysis;

namespace {

Table table_of(const std::string& text, const std::string& map = {}, bool skip_bad_rows = false) {
  std::istringstream stream(text);
  return read_table(stream, "t.csv", column_map_from(map), skip_bad_rows);
}

// Identifier and message of the refusal.
std::string table_refusal(const std::string& text, const std::string& map = {}, bool skip_bad_rows = false) {
  try {
    (void)table_of(text, map, skip_bad_rows);
  } catch (const AnalysisError& error) {
    CHECK_FALSE(error.remedy().empty());
    return error.id() + " " + error.what();
  }
  return "accepted";
}

using TextLines = std::vector<std::string>;

}  // namespace

TEST_CASE("decimal commas are read where semicolons, tabs or quotes separate the columns, and are reported") {
  for (const std::string text : {"input;output\n0;-1\n1,5;+2,5e1\n", "input\toutput\n0\t-1\n1,5\t25\n",
                                 "input,output\n0,-1\n\"1,5\",\"25,0\"\n", "input output\n0 -1\n1,5   25\n"}) {
    INFO(text);
    const Table table = table_of(text);
    CHECK(table.series[0].input == std::vector{0.0, 1.5});
    CHECK(table.series[0].output == std::vector{-1.0, 25.0});
    REQUIRE_FALSE(table.assumed.empty());
    CHECK_THAT(table.assumed.back(), Catch::Contains("3"));
  }
  CHECK(table_of("input,output\n1.5,2\n").assumed.empty());
  CHECK(table_of("input;output\n1;2\n").assumed == TextLines{"columns are separated by semicolons"});
}

TEST_CASE("decimal commas and points in one table, and thousands separators, are refused with the line") {
  CHECK_THAT(table_refusal("input;output\n1,5;2\n1.500;3\n"), Catch::Contains("t.csv:3"));
  CHECK_THAT(table_refusal("input;output\n1.5;2\n1;2,5\n"), Catch::Contains(":3"));
  CHECK_THAT(table_refusal("input;output\n1;2\n1.234,5;2\n"), Catch::Contains("without thousands separators"));
  CHECK_THAT(table_refusal("input;output\n1;2\n1,234,567;2\n"), Catch::Contains("without thousands separators"));
  CHECK_THAT(table_refusal("input,output\n1,5,2,5\n"), Catch::Contains(":2"));
}

TEST_CASE("a line of units after the names is skipped, and its units are kept") {
  const Table table = table_of("time,force,signal\ns,[N],(V)\n0,1,2\n1,3,4\n", "input=force,output=signal");
  CHECK(table.series[0].input == std::vector{1.0, 3.0});
  CHECK((table.input_unit == "N" && table.output_unit == "V"));
  CHECK(table.assumed.size() == 1);
  CHECK(table_of("input,output\n1,2\n").input_unit.empty());
  const Table latin = table_of("input,output\nN,\xB5m\n1,2\n");  // no UTF-8
  CHECK((latin.output_unit.empty() && latin.assumed.size() == 1));
  // No units: words in one column alone, nothing, nan, or words further down.
  CHECK_THAT(table_refusal("input,output\n1,V\n"), Catch::Contains(":2"));
  CHECK_THAT(table_refusal("input,output\n,\n"), Catch::Contains(":2"));
  CHECK_THAT(table_refusal("input,output\nnan,nan\n"), Catch::Contains(":2"));
  CHECK_THAT(table_refusal("input,output\nNA,NA\n"), Catch::Contains(":2"));
  CHECK_THAT(table_refusal("input,output\n1,2\nN,V\n"), Catch::Contains(":3"));
}

TEST_CASE("names with a comma are mapped in quotes") {
  const std::string text = "\"time, s\",\"force, N\"\n1,2\n";
  CHECK(table_of(text, "input=\"time, s\",output=\"force, N\"").series[0].output == std::vector{2.0});
  CHECK(table_of("\"time, s\";\"force, N\"\n1;2\n", "output=\"force, N\", input=1").series[0].input ==
        std::vector{1.0});
  CHECK_THAT(table_refusal(text, "input=time, s,output=2"), Catch::Contains("TB-TABLE-MAP"));
  CHECK_THAT(table_refusal(text, "input=\"\",output=2"), Catch::Contains("TB-TABLE-MAP"));
}

TEST_CASE("blanks separate columns where nothing else does, and a name of several words stays one name") {
  const Table table = table_of("  input   output\n 1  2\n\n 3\t4 \n");
  CHECK((table.series[0].input == std::vector{1.0, 3.0} && table.series[0].output == std::vector{2.0, 4.0}));
  CHECK(table.assumed.size() == 1);
  CHECK(table_of("sequence input output\n\"a b\" 1 2\n").series[0].sequence == "a b");
  std::istringstream one("output voltage\n3\n");
  TableReader reader(one, "t.csv", column_map_from("output=output voltage"), TableNeeds::kOutput);
  TableReader::Row row;
  REQUIRE(reader.next(row));
  CHECK(row.output == 3.0);
}

TEST_CASE("numbers in place of column names are refused, since a sample would be lost") {
  CHECK_THAT(table_refusal("0,1\n1,2\n", "input=1,output=2"),
             Catch::Contains("TB-TABLE-COLUMN") && Catch::Contains("t.csv:1: numbers in place of the names"));
  CHECK(table_refusal("0,b\n1,2\n", "input=1,output=2") == "accepted");
}

TEST_CASE("bad rows are left out when asked for, each with line and reason, and no more than half") {
  const std::string text = "input,output\n1,2\n3,\n4,x\n5,6\n7\n8,nan\n9,\"1\n10,11\n12,13\n14,15\n";
  CHECK_THAT(table_refusal(text), Catch::Contains("t.csv:3"));
  const Table table = table_of(text, {}, true);
  CHECK(table.series[0].input == std::vector{1.0, 5.0, 10.0, 12.0, 14.0});
  CHECK(table.skipped.count == 5);
  CHECK(table.skipped.first == TextLines{"t.csv:3: \"\" in column output is blank",
                                         "t.csv:4: \"x\" in column output is not a number",
                                         "t.csv:6: 1 field where the first line names 2 columns",
                                         "t.csv:7: \"nan\" in column output is not finite",
                                         "t.csv:8: the quote at byte 3 is not closed on the line"});
  CHECK(table_of("input,output\n1,2\n", {}, true).skipped.count == 0);
  CHECK_THAT(table_refusal("input,output\n1,2\n3,\n4,\n", {}, true),
             Catch::Contains("TB-TABLE-SKIPPED") && Catch::Contains("2 of 3 rows cannot be read") &&
                 Catch::Contains("t.csv:3"));
  // What is no bad row is refused all the same.
  CHECK_THAT(table_refusal("step,input,output\n1,1,2\n1,3,4\n", {}, true), Catch::Contains("TB-TABLE-STEP"));
  CHECK_THAT(table_refusal("input,output\n1,2\n1" + std::string(1, '\0') + ",2\n", {}, true), Catch::Contains("NUL"));
}

TEST_CASE("the first twenty omitted rows are named, and a file of bad rows alone is not read to its end") {
  std::string text = "input,output\n";
  for (int i = 0; i < 100; ++i) text += i % 3 == 0 ? "1,\n" : "1,2\n";
  const Table table = table_of(text, {}, true);
  CHECK((table.skipped.count == 34 && table.skipped.first.size() == SkippedRows::kNamed));
  for (int i = 0; i < 20'000; ++i) text += "-,-\n";
  CHECK_THAT(table_refusal(text, {}, true),
             Catch::Contains("TB-TABLE-SKIPPED") && Catch::Contains("10067 of 10133 rows"));
}
