#include "analysis/table.h"

#include <catch2/catch.hpp>
#include <sstream>

#include "analysis/error.h"
#include "tests/support/process.h"

using namespace tactbench::analysis;
using tactbench::tests::TemporaryFolder;
using tactbench::tests::write_file;

namespace {

std::vector<TableSeries> read(const std::string& text, const std::string& map = {}) {
  const TemporaryFolder folder;
  write_file(folder.path("t.csv"), text);
  return read_table(folder.path("t.csv"), column_map_from(map));
}

// Identifier and message of the refusal.
std::string refusal(const std::string& text, const std::string& map = {}) {
  try {
    read(text, map);
  } catch (const AnalysisError& error) {
    CHECK_FALSE(error.remedy().empty());
    return error.id() + " " + error.what();
  }
  return "accepted";
}

}  // namespace

TEST_CASE("a table is read by the names of its columns, in row order") {
  const auto series = read("sequence,step,input,output,taxel\nb,1,0,0.5,3\nb,2,1.25,1e-3,3\na,1,2,3,3\nb,3,-1,7,3\n");
  REQUIRE(series.size() == 2);
  CHECK((series[0].sequence == "b" && series[0].taxel == 3 && series[0].input == std::vector{0.0, 1.25, -1.0}));
  CHECK(series[0].output == std::vector{0.5, 1e-3, 7.0});
  CHECK((series[1].sequence == "a" && series[1].output == std::vector{3.0}));
}

TEST_CASE("without sequence and taxel all rows are one history") {
  const auto series = read("input,output\n1,2\n3,4\n");
  REQUIRE(series.size() == 1);
  CHECK((series[0].sequence == "1" && series[0].taxel == 0 && series[0].input.size() == 2));
}

TEST_CASE("columns are mapped by name or number") {
  const std::string text = "sample,drive_V,displacement_um\n0,1.5,-100\n1,1.6,-99\n";
  CHECK(read(text, "input=drive_V,output=displacement_um")[0].output == std::vector{-100.0, -99.0});
  CHECK(read(text, "input=2,output=3")[0].input == std::vector{1.5, 1.6});
  CHECK_THAT(refusal(text), Catch::Contains("TB-TABLE-COLUMN") && Catch::Contains("sample, drive_V"));
  CHECK_THAT(refusal(text, "input=4,output=3"), Catch::Contains("no column \"4\" for the input"));
  CHECK_THAT(refusal(text, "in=2"), Catch::Contains("TB-TABLE-MAP"));
  CHECK_THAT(refusal(text, "input="), Catch::Contains("TB-TABLE-MAP"));
}

TEST_CASE("separators, line ends, comments, quotes and a byte order mark are taken as they come") {
  for (const std::string text : {"input;output\n1;2\n", "input\toutput\n1\t2\n", "input,output\r\n1,2\r\n",
                                 "# made by hand\n\ninput , output\n\n 1 , +2 \n# end\n",
                                 "\xEF\xBB\xBFinput,output\n1,2", "\"input\",\"output\"\n\"1\",\"2\"\n"}) {
    INFO(text);
    const auto series = read(text);
    CHECK((series[0].input == std::vector{1.0} && series[0].output == std::vector{2.0}));
  }
}

TEST_CASE("a bad row is refused with its line, column and content") {
  const std::string head = "input,output\n1,2\n";
  CHECK_THAT(refusal(head + "3\n"), Catch::Contains("t.csv:3: 1 fields where the first line names 2"));
  CHECK_THAT(refusal(head + "3,4,5\n"), Catch::Contains("TB-TABLE-ROW"));
  CHECK_THAT(refusal(head + "\n3,x\n"), Catch::Contains(":4: \"x\" in column output is not a number"));
  CHECK_THAT(refusal(head + "nan,4\n"), Catch::Contains("nan in column input is not finite"));
  CHECK_THAT(refusal(head + "3,inf\n"), Catch::Contains("not finite"));
  CHECK_THAT(refusal(head + "3,4 V\n"), Catch::Contains("\"4 V\""));
  CHECK_THAT(refusal(head + "3,\n"), Catch::Contains("\"\" in column output"));
  CHECK_THAT(refusal("input,output,taxel\n1,2,1.5\n"), Catch::Contains("taxel 1.5"));
}

TEST_CASE("an empty table and a missing one are refused") {
  CHECK_THAT(refusal(""), Catch::Contains("TB-TABLE-EMPTY"));
  CHECK_THAT(refusal("# only a comment\n"), Catch::Contains("TB-TABLE-EMPTY"));
  CHECK_THAT(refusal("input,output\n"), Catch::Contains("TB-TABLE-EMPTY"));
  CHECK_THROWS_AS(read_table("/nowhere/t.csv"), AnalysisError);
}
