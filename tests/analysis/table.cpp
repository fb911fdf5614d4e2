// Whole tables as people have them: what is read of them, and where and by which error the rest is refused.
#include "analysis/table.h"

#include <catch2/catch.hpp>
#include <sstream>

#include "analysis/error.h"

using namespace tactbench::analysis;

namespace {

Table table_of(const std::string& text, const std::string& map = {}, bool skip_bad_rows = false) {
  std::istringstream stream(text);
  return read_table(stream, "t", column_map_from(map), skip_bad_rows);
}

std::vector<TableSeries> read(const std::string& text, const std::string& map = {}) {
  return table_of(text, map).series;
}

// Error and place of the refusal: "TB-TABLE-ROW t:3".
std::string refusal(const std::string& text, const std::string& map = {}, bool skip_bad_rows = false) {
  try {
    (void)table_of(text, map, skip_bad_rows);
  } catch (const AnalysisError& error) {
    CHECK_FALSE(error.remedy().empty());
    const std::string what = error.what();
    return error.id() + " " + what.substr(0, what.find(": "));
  }
  return "accepted";
}

using TextLines = std::vector<std::string>;

}  // namespace

TEST_CASE("a table is read by the names of its columns, in row order, all rows are one history where none is named") {
  const auto series = read("sequence,step,input,output,taxel\nb,1,0,0.5,3\nb,2,1.25,1e-3,3\na,1,2,3,3\nb,3,-1,7,3\n");
  REQUIRE(series.size() == 2);
  CHECK((series[0].sequence == "b" && series[0].taxel == 3 && series[0].input == std::vector{0.0, 1.25, -1.0}));
  CHECK(series[0].output == std::vector{0.5, 1e-3, 7.0});
  CHECK((series[1].sequence == "a" && series[1].output == std::vector{3.0}));
  const auto alone = read("input,output\n1,2\n3,4\n");
  REQUIRE(alone.size() == 1);
  CHECK((alone[0].sequence == "1" && alone[0].taxel == 0 && alone[0].input.size() == 2));
}

TEST_CASE("columns are mapped by name or number, a name before a number, names with a comma in quotes") {
  const std::string text = "2,b,c\n5,6,7\n", quoted = "\"time, s\",\"force, N\"\n1,2\n";
  const auto first = [&](const std::string& map) { return read(text, map)[0].input[0]; };
  CHECK(first("input=c,output=b") == 7.0);
  CHECK(first("input=1,output=b") == 5.0);
  CHECK(first("input=3,output=b") == 7.0);
  CHECK(first("input=2,output=b") == 5.0);  // the column that is called so
  CHECK(first(" input = 1 , output = b ") == 5.0);
  CHECK(read(quoted, "input=\"time, s\",output=\"force, N\"")[0].output == std::vector{2.0});
  CHECK(read("\"time, s\";\"force, N\"\n1;2\n", "output=\"force, N\", input=1")[0].input == std::vector{1.0});
  for (const char* none : {"", "input=0,output=b", "input=4,output=b", "input=1x,output=b",
                           "input=1,output=b,sequence=x", "input=1,output=b,taxel=9"})
    CHECK(refusal(text, none) == "TB-TABLE-COLUMN t:1");
  for (const char* odd : {"input", "in=2", "input=", "\"input=1,2\"", "input=time, s,output=2", "input=\"\",output=2"})
    CHECK(refusal(quoted, odd) == "TB-TABLE-MAP --map");
  // A sample would be lost where numbers stand in place of the names.
  CHECK(refusal("0,1\n1,2\n", "input=1,output=2") == "TB-TABLE-COLUMN t:1");
  CHECK(refusal("0,b\n1,2\n", "input=1,output=2") == "accepted");
}

TEST_CASE("all usual separators, line ends, comments, quotes and a byte order mark are accepted") {
  for (const std::string text :
       {"input;output\n1;2\n", "input\toutput\n1\t2\n", "input\t\"output\"\n1\t2\n", "input,output\r\n1,2\r\n",
        "# made by hand\n\ninput , output\n\n 1 , +2 \n# end\n", "\xEF\xBB\xBFinput,output\n1,2",
        "\"input\",\"output\"\n\"1\",\"2\"\n", "  input   output\n 1  2\n\n"}) {
    INFO(text);
    const auto series = read(text);
    CHECK((series[0].input == std::vector{1.0} && series[0].output == std::vector{2.0}));
  }
  CHECK(table_of("input,output\n1.5,2\n").assumed.empty());
  CHECK(table_of("input;output\n1;2\n").assumed.size() == 1);
  CHECK(read("sequence input output\n\"a b\" 1 2\n")[0].sequence == "a b");
  // A name of several words stays one name.
  std::istringstream one("output voltage\n3\n");
  TableReader reader(one, "t", column_map_from("output=output voltage"), TableNeeds::kOutput);
  TableReader::Row row;
  REQUIRE(reader.next(row));
  CHECK(row.output == 3.0);
}

TEST_CASE("a bad row is refused with its line") {
  const std::string head = "input,output\n1,2\n", nul(1, '\0');
  for (const std::string& row : {std::string("3\n"), std::string("3,4,5\n"), std::string("nan,4\n"),
                                 std::string("3,inf\n"), std::string("3,4 V\n"), std::string("3,\n"), nul + "3,4\n"})
    CHECK(refusal(head + row) == "TB-TABLE-ROW t:3");
  CHECK(refusal(head + "\n3,x\n") == "TB-TABLE-ROW t:4");
  CHECK(refusal("i" + nul + "nput,output\n1,2\n") == "TB-TABLE-ROW t:1");
  CHECK(std::string(AnalysisError("TB-X", "before" + nul + "after", "mend it").what()) == "before\\x00after");
  for (const char* empty : {"", "# only a comment\n", "input,output\n"}) CHECK(refusal(empty) == "TB-TABLE-EMPTY t");
  // An endless line is refused before all of it is read.
  CHECK(refusal("input,output\n1," + std::string(1'200'000, '2') + "\n") == "TB-TABLE-ROW t:2");
  CHECK(read("input,output,note\n1,2," + std::string(200'000, 'x') + "\n3,4,\n")[0].input.size() == 2);
}

TEST_CASE("taxels of a table are whole numbers from 0 to a million") {
  const auto taxel = [](const std::string& cell) { return refusal("input,output,taxel\n1,2," + cell + "\n"); };
  CHECK(taxel("0") == "accepted");
  CHECK(taxel("1000000") == "accepted");
  for (const char* none : {"1000001", "-1", "0.5"}) CHECK(taxel(none) == "TB-TABLE-ROW t:2");
}

TEST_CASE("quotes follow RFC 4180, and an unclosed one is refused with its line") {
  const std::string head = "sequence,input,output\n";
  const auto names = [&](const std::string& cell) { return read(head + cell + ",1,2\n")[0].sequence; };
  CHECK(names("\"a,b\"") == "a,b");
  CHECK(names(" \"a\" ") == "a");
  CHECK(names("\"say \"\"up\"\"\"") == "say \"up\"");
  CHECK(names("\"\"").empty());
  for (const char* odd : {"\"a,5,1", "\"a\"b,5,1\n", "a\",5,1\n"}) CHECK(refusal(head + odd) == "TB-TABLE-ROW t:2");
  CHECK(refusal(head + "a,1,2\n\"a,5,1\n") == "TB-TABLE-ROW t:3");
  CHECK(refusal("\"input,output\n1,2\n") == "TB-TABLE-ROW t:1");
}

TEST_CASE("steps rise, or fall to where they began, in each sequence and taxel for itself") {
  const auto steps = [](const std::string& numbers) {
    std::string text = "step,input,output\n";
    for (const char step : numbers) text += std::string(1, step) + ",0,0\n";
    return refusal(text);
  };
  for (const char* rising : {"123123", "3693", "1", "12312412"}) CHECK(steps(rising) == "accepted");
  CHECK(steps("1232") == "TB-TABLE-STEP t:5");
  CHECK(steps("11") == "TB-TABLE-STEP t:3");
  CHECK(steps("1211") == "TB-TABLE-STEP t:5");
  CHECK(steps("2312") == "TB-TABLE-STEP t:4");
  CHECK(read("sequence,step,input,output\na,5,0,0\nb,1,1,1\na,6,1,1\nb,2,0,0\n").size() == 2);
  CHECK(read("input,output,taxel,step\n0,0,1,1\n0,0,2,1\n1,1,1,2\n1,1,2,2\n").size() == 2);
  CHECK(refusal("step,input,output,taxel\n1,0,0,4\n1,0,0,4\n") == "TB-TABLE-STEP t:3");
  CHECK(read("step,input,output\nup,0,0\nup,1,1\n")[0].input.size() == 2);  // no number: not looked at
}

TEST_CASE("decimal commas are read where semicolons, tabs or quotes separate the columns, and are reported") {
  for (const std::string text : {"input;output\n0;-1\n1,5;+2,5e1\n", "input\toutput\n0\t-1\n1,5\t25\n",
                                 "input,output\n0,-1\n\"1,5\",\"25,0\"\n", "input output\n0 -1\n1,5   25\n"}) {
    INFO(text);
    const Table table = table_of(text);
    CHECK(table.series[0].input == std::vector{0.0, 1.5});
    CHECK(table.series[0].output == std::vector{-1.0, 25.0});
    REQUIRE_FALSE(table.assumed.empty());
    CHECK_THAT(table.assumed.back(), Catch::Contains("3") && Catch::Contains("1,5"));
  }
  // Commas beside points, and thousands separators.
  for (const char* mixed : {"1,5;2\n1.500;3\n", "1.5;2\n1;2,5\n", "1;2\n1.234,5;2\n", "1;2\n1,234,567;2\n"})
    CHECK(refusal(std::string("input;output\n") + mixed) == "TB-TABLE-ROW t:3");
  CHECK(refusal("input,output\n1,5,2,5\n") == "TB-TABLE-ROW t:2");
}

TEST_CASE(
    "a line of units: words of up to 24 bytes in the columns needed, as many fields as names, no number anywhere") {
  const Table table = table_of("time,force,signal\ns,[N],(V)\n0,1,2\n1,3,4\n", "input=force,output=signal");
  CHECK(table.series[0].input == std::vector{1.0, 3.0});
  CHECK((table.input_unit == "N" && table.output_unit == "V" && table.assumed.size() == 1));
  CHECK(table_of("input,output\n1,2\n").input_unit.empty());
  const auto second_line = [](const std::string& line) {
    const std::string text = "input,output,note\n" + line + "\n1,2,\n";
    return refusal(text) == "accepted" ? table_of(text).output_unit : std::string("refused");
  };
  CHECK(second_line("psi,V,x") == "V");
  CHECK(second_line("psi,V,") == "V");
  CHECK(second_line("psi," + std::string(24, 'u') + ",x") == std::string(24, 'u'));
  for (const std::string& none :
       {"psi," + std::string(25, 'u') + ",x", std::string("psi,V,1"), std::string("psi,V"), std::string("psi,,x"),
        std::string("psi,NA,x"), std::string("psi,N/A,x"), std::string("psi,na,x"), std::string("psi,n/a,x")})
    CHECK(second_line(none) == "refused");
  CHECK(second_line("psi,[mV],x") == "mV");
  CHECK(second_line("psi,( mV ),x") == "mV");
  CHECK(second_line("psi,[mV),x") == "[mV)");
  CHECK(second_line("psi,[],x").empty());
  CHECK(second_line("psi,[,x") == "[");
  for (const char* no_text : {"psi,\"\x01\",x", "psi,\xB5m,x"}) CHECK(second_line(no_text).empty());
  CHECK(table_of("input,output\nmm,\xC2\xB5m\n1,2\n").output_unit == "\xC2\xB5m");
  for (const char* row : {"1,V\n", ",\n", "nan,nan\n"})
    CHECK(refusal(std::string("input,output\n") + row) == "TB-TABLE-ROW t:2");
  CHECK(refusal("input,output\n1,2\nN,V\n") == "TB-TABLE-ROW t:3");
}

TEST_CASE("bad rows are left out when asked for, the first twenty named with their lines, and no more than half") {
  const std::string text = "input,output\n1,2\n3,\n4,x\n5,6\n7\n8,nan\n9,\"1\n10,11\n12,13\n14,15\n";
  CHECK(refusal(text) == "TB-TABLE-ROW t:3");
  const Table table = table_of(text, {}, true);
  CHECK(table.series[0].input == std::vector{1.0, 5.0, 10.0, 12.0, 14.0});
  CHECK(table.skipped.count == 5);
  TextLines places;
  for (const std::string& reason : table.skipped.first) places.push_back(reason.substr(0, 4));
  CHECK(places == TextLines{"t:3:", "t:4:", "t:6:", "t:7:", "t:8:"});
  CHECK(table_of("input,output\n1,2\n", {}, true).skipped.count == 0);
  std::string many = "input,output\n";
  for (int i = 0; i < 21; ++i) many += "x,1\n1,2\n";
  CHECK((table_of(many, {}, true).skipped.count == 21 && table_of(many, {}, true).skipped.first.size() == 20));
  const auto rows = [](int bad, int good) {
    std::string own = "input,output\n";
    for (int i = 0; i < bad; ++i) own += "x,1\n";
    for (int i = 0; i < good; ++i) own += "1,2\n";
    return refusal(own, {}, true);
  };
  CHECK(rows(3, 3) == "accepted");
  CHECK(rows(4, 3) == "TB-TABLE-SKIPPED t");
  CHECK(rows(10000, 10000) == "accepted");
  CHECK(rows(10001, 10001) == "TB-TABLE-SKIPPED t");  // a file of bad rows alone is not read to its end
  // What is no bad row is refused all the same.
  CHECK(refusal("step,input,output\n1,1,2\n1,3,4\n", {}, true) == "TB-TABLE-STEP t:3");
  CHECK(refusal("input,output\n1,2\n1" + std::string(1, '\0') + ",2\n", {}, true) == "TB-TABLE-ROW t:3");
}

TEST_CASE("a table that is not a file is refused") {
  const auto id = [](const std::string& path) -> std::string {
    try {
      (void)read_table(path);
    } catch (const AnalysisError& error) {
      return error.id();
    }
    return "accepted";
  };
  for (const char* none : {"/nowhere/t.csv", "/dev/zero", "/dev"}) CHECK(id(none) == "TB-TABLE-OPEN");
  // A file of the kernel's that says it has no length is not read: as root, /proc/kmsg would be waited for.
  for (const char* kernels : {"/proc/self/mem", "/proc/kmsg", "/proc/self/status"})
    CHECK(id(kernels) == "TB-TABLE-EMPTY");
}
