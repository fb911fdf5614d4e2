#include "analysis/table.h"

#include <catch2/catch.hpp>
#include <sstream>

#include "analysis/error.h"
#include "tests/support/process.h"

using namespace tactbench::analysis;
using tactbench::tests::TemporaryFolder;
using tactbench::tests::write_file;

namespace {

Table whole(const std::string& text, const std::string& map = {}, bool skip_bad_rows = false) {
  const TemporaryFolder folder;
  write_file(folder.path("t.csv"), text);
  return read_table(folder.path("t.csv"), column_map_from(map), skip_bad_rows);
}

std::vector<TableSeries> read(const std::string& text, const std::string& map = {}) { return whole(text, map).series; }

// Identifier and message of the refusal.
std::string refusal(const std::string& text, const std::string& map = {}, bool skip_bad_rows = false) {
  try {
    (void)whole(text, map, skip_bad_rows);
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
  CHECK_THAT(refusal(text, "input=4,output=3"), Catch::Contains("\"4\""));
  CHECK_THAT(refusal(text, "in=2"), Catch::Contains("TB-TABLE-MAP"));
  CHECK_THAT(refusal(text, "input="), Catch::Contains("TB-TABLE-MAP"));
}

TEST_CASE("all usual separators, line ends, comments, quotes and a byte order mark are accepted") {
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
  CHECK_THAT(refusal(head + "3\n"), Catch::Contains("t.csv:3"));
  CHECK_THAT(refusal(head + "3,4,5\n"), Catch::Contains("TB-TABLE-ROW"));
  CHECK_THAT(refusal(head + "\n3,x\n"), Catch::Contains(":4"));
  CHECK_THAT(refusal(head + "nan,4\n"), Catch::Contains("\"nan\""));
  CHECK_THAT(refusal(head + "3,inf\n"), Catch::Contains("not finite"));
  CHECK_THAT(refusal(head + "3,4 V\n"), Catch::Contains("\"4 V\""));
  CHECK_THAT(refusal(head + "3,\n"), Catch::Contains(":3"));
  CHECK_THAT(refusal("input,output,taxel\n1,2,1.5\n"), Catch::Contains("taxel 1.5"));
}

TEST_CASE("an empty table and a missing one are refused") {
  CHECK_THAT(refusal(""), Catch::Contains("TB-TABLE-EMPTY"));
  CHECK_THAT(refusal("# only a comment\n"), Catch::Contains("TB-TABLE-EMPTY"));
  CHECK_THAT(refusal("input,output\n"), Catch::Contains("TB-TABLE-EMPTY"));
  CHECK_THROWS_AS(read_table("/nowhere/t.csv"), AnalysisError);
}

TEST_CASE("quotes follow RFC 4180, and an unclosed one is refused with its line") {
  const std::string head = "sequence,input,output\n";
  const auto names = [&](const std::string& cell) { return read(head + cell + ",1,2\n")[0].sequence; };
  CHECK(names("\"a,b\"") == "a,b");
  CHECK(names(" \"a\" ") == "a");
  CHECK(names("\"say \"\"up\"\"\"") == "say \"up\"");
  CHECK(names("\"\"").empty());
  CHECK_THAT(refusal(head + "a,1,2\n\"a,5,1\n"), Catch::Contains("t.csv:3"));
  CHECK_THAT(refusal(head + "\"a,5,1"), Catch::Contains("TB-TABLE-ROW") && Catch::Contains(":2: the quote"));
  CHECK_FALSE(std::string(refusal(head + "\"a\"b,5,1\n")).empty());
  CHECK_THAT(refusal(head + "a\",5,1\n"), Catch::Contains("middle of field 1"));
  CHECK_THAT(refusal("\"input,output\n1,2\n"), Catch::Contains(":1"));
  CHECK(read("input\t\"output\"\n1\t2\n")[0].output == std::vector{2.0});
}

TEST_CASE("duplicate and out-of-order steps are refused with their line, a repeat is accepted") {
  const std::string head = "sequence,step,input,output\n";
  CHECK_THAT(refusal(head + "a,1,0,0\na,2,1,1\na,2,2,2\n"),
             Catch::Contains("TB-TABLE-STEP") && Catch::Contains("t.csv:4: step 2 occurs twice in sequence \"a\""));
  CHECK_THAT(refusal(head + "a,1,0,0\na,3,1,1\na,2,2,2\n"), Catch::Contains(":4"));
  CHECK(read(head + "a,1,0,0\na,2,1,1\na,1,0,0\na,2,1,1\n")[0].input.size() == 4);  // two repeats
  CHECK(read(head + "a,5,0,0\nb,1,1,1\na,6,1,1\nb,2,0,0\n").size() == 2);           // each counts for itself
  CHECK(read("input,output,taxel,step\n0,0,1,1\n0,0,2,1\n1,1,1,2\n1,1,2,2\n").size() == 2);
  CHECK(read("step,input,output\nup,0,0\nup,1,1\n")[0].input.size() == 2);  // no number: not looked at
}

TEST_CASE("a NUL character is reported and does not truncate the message") {
  const std::string nul(1, '\0');
  CHECK_THAT(refusal("input,output\n1" + nul + "2,2\n"), Catch::Contains("t.csv:2"));
  CHECK_THAT(refusal("i" + nul + "nput,output\n1,2\n"), Catch::Contains("t.csv:1"));
  const AnalysisError error("TB-TABLE-ROW", "before" + nul + "after", "mend it");
  CHECK(std::string(error.what()) == "before\\x00after");
}

TEST_CASE("an endless line is refused before all of it is read") {
  CHECK_THAT(refusal("input,output\n1," + std::string(1'200'000, '2') + "\n"),
             Catch::Contains("more than 1000000 bytes"));
  CHECK(read("input,output,note\n1,2," + std::string(200'000, 'x') + "\n3,4,\n")[0].input.size() == 2);
}

TEST_CASE("a table that is not a file is refused") {
  const auto id = [](const std::string& path) -> std::string {
    try {
      (void)read_table(path);
    } catch (const AnalysisError& error) {
      return error.id() + " " + error.what();
    }
    return "accepted";
  };
  CHECK_THAT(id("/dev/zero"), Catch::StartsWith("TB-TABLE-OPEN"));
  CHECK_THAT(id("/dev"), Catch::Contains("TB-TABLE-OPEN"));
  // A file of the kernel's that says it has no length is not read: as root, /proc/kmsg would be waited for.
  for (const char* kernels : {"/proc/self/mem", "/proc/kmsg", "/proc/self/status"})
    CHECK_THAT(id(kernels), Catch::Contains("TB-TABLE-EMPTY"));
}
