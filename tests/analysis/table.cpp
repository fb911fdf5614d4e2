// Whole tables as people have them: what is read of them, and where and by which error the rest is refused.
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <sstream>
#include <utility>

#include "analysis/error.h"
#include "analysis/table.h"
#include "tests/analysis/support/alike.h"

using namespace tactbench::analysis;

namespace {

Table table_of(const std::string& text, const std::string& map = {}, bool skip_bad_rows = false) {
  std::istringstream stream(text);
  TableLayout layout = table_layout(map);
  layout.skip_bad_rows = skip_bad_rows;
  return read_table(stream, "t", layout);
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

TEST_CASE("read_table: finds columns by name and keeps the row order, unnamed sequences are one history") {
  const auto series = read("sequence,step,input,output,taxel\nb,1,0,0.5,3\nb,2,1.25,1e-3,3\na,1,2,3,3\nb,3,-1,7,3\n");
  REQUIRE(series.size() == 2);
  CHECK((series[0].sequence == "b" && series[0].taxel == 3 && series[0].input == std::vector{0.0, 1.25, -1.0}));
  CHECK(series[0].output == std::vector{0.5, 1e-3, 7.0});
  CHECK((series[1].sequence == "a" && series[1].output == std::vector{3.0}));
  const auto alone = read("input,output\n1,2\n3,4\n");
  REQUIRE(alone.size() == 1);
  CHECK((alone[0].sequence == "1" && alone[0].taxel == 0 && alone[0].input.size() == 2));
}

TEST_CASE("column map: a name is matched before a number, and names with a comma are quoted") {
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
  for (const char* odd : {"input", "in=2", "input=", "\"input=1,2\"", "input=time, s,output=2", "input=\"\",output=2",
                          "input=1,output=2,output=1", "input=1,input=1", "input=1,input=2,output=3",
                          "input=1,output=2,sequence=3,sequence=4"})
    CHECK(refusal(quoted, odd) == "TB-TABLE-MAP --map");
  // No column has two roles, and no name two columns.
  CHECK(refusal("a,b\n1,2\n", "input=1,output=a") == "TB-TABLE-COLUMN t:1");
  CHECK(refusal("a,b,b\n1,2,3\n", "input=a,output=b") == "TB-TABLE-COLUMN t:1");
  CHECK(read("a,b,b\n1,2,3\n", "input=a,output=3")[0].output == std::vector{3.0});
}

TEST_CASE("read_table: without a header columns go by number, and no sample is read as a column name") {
  const auto inputs = [](const std::string& text, const std::string& map = "input=1,output=2", bool no_header = false) {
    std::istringstream stream(text);
    TableLayout layout = table_layout(map);
    layout.no_header = no_header;
    return read_table(stream, "t", layout).series.at(0).input;
  };
  for (const char* text :
       {"0.5,1\n2,3\n", "0.5;1\n2;3\n", "0,5;1\n2;3\n", "0.5 1.0\n2 3\n", "0,5 1,0\n2 3\n", "0.5\t1\n2\t3\n",
        "0.5 , 1\n2 , 3\n", "# no names\n0.5,1\n2,3\n", "0,5000;1,0000\r\n2,0000;3,0000"}) {
    INFO(text);
    CHECK(inputs(text) == std::vector{0.5, 2.0});
    CHECK(inputs(text, "input=1,output=2", true) == std::vector{0.5, 2.0});
  }
  CHECK(table_of("0.5,1\n2,3\n", "input=1,output=2").assumed.size() == 1);
  // Numbers that count may be names, as pandas writes them.
  CHECK(refusal("0,1\n1,2\n", "input=1,output=2") == "TB-TABLE-COLUMN t:1");
  CHECK(inputs("0,1\n1,2\n", "input=1,output=2", true) == std::vector{0.0, 1.0});
  CHECK(refusal("0.5,1\n2,3\n") == "TB-TABLE-COLUMN t:1");  // by name
  CHECK(refusal("0,b\n1,2\n", "input=1,output=2") == "TB-TABLE-ROW t:1");
  CHECK(refusal("a,b\n0,OL\n1,OL\n2,3\n", "input=1,output=2") == "TB-TABLE-ROW t:2");
  std::istringstream named("a,b\n1,2\n");
  TableLayout layout = table_layout("input=1,output=2");
  layout.no_header = true;
  CHECK_THROWS_AS(read_table(named, "t", layout), AnalysisError);
}

TEST_CASE("read_table: preamble lines of data loggers above the header are skipped") {
  const std::string mark = "\xEF\xBB\xBF", rows = "0,1,2\n5,3,4\n", tabs = "0\t1\t2\n5\t3\t4\n";
  const std::string labview = "LabVIEW Measurement\t\nSeparator\tTab\n***End_of_Header***\t\n\t\n";
  const std::string segment = "Channels\t2\t\t\nSamples\t9\t9\t\nX0\t0.0\t0.0\t\n***End_of_Header***\t\t\t\n";
  for (const std::string& text : TextLines{
           "\xEF\xBB\xBF# by hand\nT,F,O\n" + rows, "\xEF\xBB\xBF\nT,F,O\n" + rows,
           "; scope 0.2\n; 20 Hz\nT,F,O\n" + rows, "% made, by, matlab\nT,F,O\n" + rows, "sep=,\nT,F,O\n" + rows,
           "\"sep=;\"\nT;F;O\n0;1;2\n5;3;4\n", std::string("sep=;\r\nT;F;O\r\n0,0;1,0;2,0\r\n5,0;3,0;4,0\r\n"),
           "Model,X1\nRate,20\n\nT,F,O\n" + rows, "Serial, 7, of 9\nT,F,O\ns,N,V\n" + rows,
           labview + "T\tF\tO\tComment\n" + tabs, labview + segment + "T\tF\tO\tComment\n0\t1\t2\tbegun\n5\t3\t4\n",
           std::string("T,F,O\r0,1,2\r5,3,4\r"), std::string("T,F,O\r\r\n0,1,2\r\r\n5,3,4"),
           "T,F,O\n0,1,2\n; a pause\n% more\n5,3,4\n", ";F;O\n0;1;2\n5;3;4\n", "sep=\t\nT\tF\tO\n" + tabs,
           "T,F,O,\n0,1,2,\n5,3,4,\n\n\n# end\n", "\"T\",\"F\",\"O\"\r\n\"0\",\"1\",\"2\"\r\n\"5\",\"3\",\"4\"\r\n",
           // A mark before each kind of line, and behind a head that was put before a file.
           "# head\n" + mark + "T,F,O\n" + rows, mark + "# a\n" + mark + "T,F,O\n" + rows, mark + "; a\nT,F,O\n" + rows,
           mark + "sep=,\nT,F,O\n" + rows, mark + "\"T\",\"F\",\"O\"\n" + rows,
           // Of a computer that writes decimal commas.
           labview + "Channels\t2\t\t\nX0\t0,0E+0\t0,0E+0\t\n***End_of_Header***\t\t\t\nT\tF\tO\tComment\n"
                     "0,0\t1,0\t2,0\t\n5,0\t3,0\t4,0\t\n"}) {
    INFO(text);
    for (const char* map : {"input=2,output=3", "input=F,output=O"}) {
      const auto series = read(text, map);
      CHECK((series[0].input == std::vector{1.0, 3.0} && series[0].output == std::vector{2.0, 4.0}));
    }
  }
  CHECK(refusal("Model,X1\nRate,20\nT,F,O\n" + rows, "input=F,output=x") == "TB-TABLE-COLUMN t:3");
  std::istringstream skipped("1,2,3\nno, table, yet\nT,F,O\n" + rows);
  TableLayout layout = table_layout("input=2,output=3");
  layout.skip_lines = 2;
  CHECK(read_table(skipped, "t", layout).series[0].input == std::vector{1.0, 3.0});
}

TEST_CASE("read_table: a trailing field without numbers may be missing or extra, any other may not") {
  const std::string head = "input,output,note\n";
  CHECK(read(head + "1,2,begun\n3,4\n5,6,\n")[0].input == std::vector{1.0, 3.0, 5.0});
  CHECK(read("0.5 2 begun\n3 4\n5 6 on\n", "input=1,output=2")[0].input == std::vector{0.5, 3.0, 5.0});
  CHECK(read("input,output\n1,2,\n3,4,\n")[0].output == std::vector{2.0, 4.0});
  CHECK(refusal(head + "1,2,3\n4,5\n") == "TB-TABLE-ROW t:3");  // one that is missing in the middle looks the same
  CHECK(refusal(head + "4,5\n1,2,3\n") == "TB-TABLE-ROW t:3");
  CHECK(refusal("note,input,output\nx,1,2\nx,1\n") == "TB-TABLE-ROW t:3");
  CHECK(refusal("input,output\n1,2,x,y\n") == "TB-TABLE-ROW t:2");
}

TEST_CASE("read_table: accepts one column per taxel by range, pattern or list, and exported frames of a run") {
  const std::string text = "time,force,s0,s1,s2\n0,1,10,20,30\n1,2,11,21,31\n";
  for (const char* outputs : {"3-5", "s*", "s0+s1+s2", "3+s1+5", "s0+4-5"}) {
    INFO(outputs);
    const Table table = table_of(text, std::string("input=force,output=") + outputs);
    REQUIRE(table.series.size() == 3);
    for (int k = 0; k < 3; ++k) {
      const TableSeries& own = table.series[static_cast<std::size_t>(k)];
      CHECK((own.taxel == k && own.input == std::vector{1.0, 2.0}));
      CHECK(own.output == std::vector{10.0 * (k + 1), 10.0 * (k + 1) + 1.0});
    }
    CHECK_FALSE(table.assumed.empty());
  }
  CHECK(read("0.5 10 20\n1 11 21\n", "input=1,output=2-3").size() == 2);
  const std::string logged =
      "t;F;S0;S1;T\ns;N;V;V;\xC2\xB0"  // degrees
      "C\n0,0;1,0;10,0;20,0;23,1\n1,0;2,0;11,0;21,0;23,1\n";
  for (const char* map : {"input=2,output=3-4", "input=F,output=S*"})
    CHECK(read(logged, map).at(1).output == std::vector{20.0, 21.0});
  CHECK(read("a-b,3-5\n1,2\n", "input=a-b,output=3-5")[0].output == std::vector{2.0});  // names come first
  for (const char* none : {"input=force,output=3-6", "input=force,output=5-3", "input=force,output=x*",
                           "input=force,output=2-5", "input=force,output=s0+s0", "input=3-4,output=s2"})
    CHECK(refusal(text, none) == "TB-TABLE-COLUMN t:1");
  CHECK(refusal("taxel,input,a,b\n0,1,2,3\n", "output=3-4") == "TB-TABLE-COLUMN t:1");
  // Scans of a frame are one sample, void rows none, and recipes are sequences.
  const std::string frames =
      "# tactbench: frames of run 1\nframe,sequence,recipe,void,step,setpoint_psi,reference_psi,time_s,scan,"
      "counts_r0_c0,counts_r0_c1,volts_r0_c0,volts_r0_c1\n"
      "1,0,up,1,0,0,7,1,0,9,9,9,9\n2,0,up,0,0,0,0.5,2,0,1,2,1.0,2.0\n2,0,up,0,0,0,0.5,2,1,3,4,3.0,4.0\n"
      "3,0,up,0,1,2,2.5,3,0,5,6,5.0,6.0\n3,0,up,0,1,2,2.5,3,1,5,6,5.0,6.0\n";
  const Table table = table_of(frames);
  REQUIRE(table.series.size() == 2);
  CHECK((table.series[0].sequence == "up" && table.series[0].input == std::vector{0.5, 2.5}));
  CHECK((table.series[0].output == std::vector{2.0, 5.0} && table.series[1].output == std::vector{3.0, 6.0}));
  CHECK((table.input_unit == "psi" && table.output_unit == "V"));
  CHECK(read(frames, "input=setpoint_psi,output=counts_*")[1].output == std::vector{3.0, 6.0});
  CHECK(read(frames, "output=volts_r0_c1").at(0).output == std::vector{3.0, 6.0});
  CHECK(read("sequence,name,taxel,position,input,output\n0,\"a, b\",3,0,1,2\n")[0].sequence == "a, b");
}

TEST_CASE("read_table: times that go back are refused, unless a counter wraps") {
  const auto times = [](const std::string& name, const std::vector<std::string>& cells, const std::string& map = {}) {
    std::string text = name + ",input,output\n";
    for (const std::string& cell : cells) text += cell + ",0,0\n";
    return std::pair(refusal(text, map), text);
  };
  for (const char* name : {"time_s", "time", "Time (s)", "Timestamp", "TIME_MS", "time [us]", "millis", "ticks"}) {
    INFO(name);
    CHECK(times(name, {"1", "2", "2", "3"}).first == "accepted");
    CHECK(times(name, {"1", "2", "1.5"}).first == "TB-TABLE-TIME t:4");
  }
  for (const char* other : {"timer", "temperature", "t", "time_constant"})
    CHECK(times(other, {"1", "2", "1.5"}).first == "accepted");
  CHECK(times("time_s", {"1", "2", "1.5"}, "time=none").first == "accepted");
  CHECK(times("at", {"1", "2", "1.5"}, "time=at").first == "TB-TABLE-TIME t:4");
  CHECK(times("time_s", {"noon", "dawn"}).first == "accepted");  // not a column of times: not checked
  CHECK(times("time", {"10:11:12.5", "10:11:13", "10:11:12.9"}).first == "TB-TABLE-TIME t:4");
  CHECK(times("Date Time", {"2026-10-31 23:59:59", "2026-11-01 00:00:00", "2026-10-31 23:59:59"}).first ==
        "TB-TABLE-TIME t:4");
  CHECK(times("timestamp", {"2026-12-31T23:59:59", "2027-01-01T00:00:00"}).first == "accepted");
  const std::vector<std::vector<std::string>> wraps = {{"4294967000", "4294967200", "104"},
                                                       {"4294967.0", "4294967.2", "0.104"},
                                                       {"4294.90", "4294.95", "0.03", "0.08"},
                                                       {"2147483500", "2147483600", "-2147483596"},
                                                       {"65520", "65530", "4"},
                                                       {"23:59:58", "23:59:59", "00:00:00"}};
  for (const std::vector<std::string>& cells : wraps) {
    const auto [accepted, text] = times("time", cells);
    CHECK(accepted == "accepted");
    CHECK(table_of(text).assumed.size() == 1);
  }
  CHECK(times("time", {"4294967000", "4294967200", "50000"}).first == "TB-TABLE-TIME t:4");  // later than a wrap
  CHECK(times("time", {"4294967200", "104"}).first == "TB-TABLE-TIME t:3");  // no step tells how far it may go on
  CHECK(read("sequence,time_s,input,output\na,5,0,0\nb,1,0,0\na,6,1,1\nb,2,1,1\n").size() == 2);
  // Times that are the input are inputs.
  CHECK(refusal("time,output\n0,0\n1,1\n0,0\n", "input=time") == "accepted");
}

TEST_CASE("read_table: common separators, line ends, comments, quotes and a byte order mark are accepted") {
  for (const std::string text : {"input;output\n1;2\n", "input\toutput\n1\t2\n", "input\t\"output\"\n1\t2\n",
                                 "input,output\r\n1,2\r\n", "# made by hand\n\ninput , output\n\n 1 , +2 \n# end\n",
                                 "\xEF\xBB\xBFinput,output\n1,2", "# head\n\xEF\xBB\xBFinput,output\n1,2",
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
  TableReader reader(one, "t", table_layout("output=output voltage"), TableNeeds::kOutput);
  TableReader::Row row;
  REQUIRE(reader.next(row));
  CHECK(row.outputs.front() == 3.0);
}

TEST_CASE("read_table: a bad row is refused with its line") {
  const std::string head = "input,output\n1,2\n", nul(1, '\0');
  for (const std::string& row : {std::string("3\n"), std::string("3,4,5\n"), std::string("nan,4\n"),
                                 std::string("3,inf\n"), std::string("3,4 V\n"), std::string("3,\n"), nul + "3,4\n"})
    CHECK(refusal(head + row) == "TB-TABLE-ROW t:3");
  CHECK(refusal(head + "\n3,x\n") == "TB-TABLE-ROW t:4");
  CHECK(refusal("i" + nul + "nput,output\n1,2\n") == "TB-TABLE-ROW t:1");
  CHECK(refusal("\xFF\xFE#" + nul + "\n" + nul) == "TB-TABLE-ROW t:1");  // UTF-16
  CHECK(std::string(AnalysisError("TB-X", "before" + nul + "after", "mend it").what()) == "before\\x00after");
  for (const char* empty : {"", "# only a comment\n", "input,output\n"}) CHECK(refusal(empty) == "TB-TABLE-EMPTY t");
  // An endless line is refused before all of it is read.
  CHECK(refusal("input,output\n1," + std::string(1'200'000, '2') + "\n") == "TB-TABLE-ROW t:2");
  CHECK(read("input,output,note\n1,2," + std::string(200'000, 'x') + "\n3,4,\n")[0].input.size() == 2);
}

TEST_CASE("read_table: taxel numbers are integers from 0 to 1000000") {
  const auto taxel = [](const std::string& cell) { return refusal("input,output,taxel\n1,2," + cell + "\n"); };
  CHECK(taxel("0") == "accepted");
  CHECK(taxel("1000000") == "accepted");
  for (const char* none : {"1000001", "-1", "0.5"}) CHECK(taxel(none) == "TB-TABLE-ROW t:2");
}

TEST_CASE("read_table: quotes follow RFC 4180, and an unclosed quote is refused with its line") {
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

TEST_CASE("read_table: step numbers rise or restart where they began, per sequence and taxel") {
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
  CHECK(read("step,input,output\nup,0,0\nup,1,1\n")[0].input.size() == 2);  // not a number: not checked
}

TEST_CASE("read_table: decimal commas are read if another separator or quotes allow it, and are reported") {
  for (const std::string text : {"input;output\n0;-1\n1,5;+2,5e1\n", "input\toutput\n0\t-1\n1,5\t25\n",
                                 "input,output\n0,-1\n\"1,5\",\"25,0\"\n", "input output\n0 -1\n1,5   25\n"}) {
    INFO(text);
    const Table table = table_of(text);
    CHECK(table.series[0].input == std::vector{0.0, 1.5});
    CHECK(table.series[0].output == std::vector{-1.0, 25.0});
    REQUIRE_FALSE(table.assumed.empty());
    CHECK_THAT(table.assumed.back(), Catch::Contains("3") && Catch::Contains("1,5"));
  }
  // Commas together with points, and thousands separators.
  for (const char* mixed : {"1,5;2\n1.500;3\n", "1.5;2\n1;2,5\n", "1;2\n1.234,5;2\n", "1;2\n1,234,567;2\n"})
    CHECK(refusal(std::string("input;output\n") + mixed) == "TB-TABLE-ROW t:3");
  CHECK(refusal("input,output\n1,5,2,5\n") == "TB-TABLE-ROW t:2");
}

TEST_CASE("unit line: has text of up to 24 bytes in each mapped column, as many fields as the header and no number") {
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

TEST_CASE("bad rows: are skipped on request, the first 20 are named with their lines, more than half are refused") {
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
  // Other errors than a bad row are still refused.
  CHECK(refusal("step,input,output\n1,1,2\n1,3,4\n", {}, true) == "TB-TABLE-STEP t:3");
  CHECK(refusal("input,output\n1,2\n1" + std::string(1, '\0') + ",2\n", {}, true) == "TB-TABLE-ROW t:3");
}

TEST_CASE("read_table: a path that is not a readable file is refused") {
  const auto id = [](const std::string& path) { return id_of_refusal([&] { return read_table(path); }); };
  for (const char* none : {"/nowhere/t.csv", "/dev/zero", "/dev"}) CHECK(id(none) == "TB-TABLE-OPEN");
  // A file of the kernel's that says it has no length is not read: as root, /proc/kmsg would be waited for.
  for (const char* kernels : {"/proc/self/mem", "/proc/kmsg", "/proc/self/status"})
    CHECK(id(kernels) == "TB-TABLE-EMPTY");
}

// Samples that no sensor can have between its neighbours, and good data that look like them.

namespace {

constexpr std::size_t kSamples = 200;

// Two sweeps of 0 to 40 and back, outputs of 0 to 2.
TableSeries sweeps() {
  TableSeries series;
  for (std::size_t i = 0; i < kSamples; ++i) {
    const double share = std::abs(std::fmod(static_cast<double>(i) / 50.0, 2.0) - 1.0);
    series.input.push_back(40.0 * share);
    series.output.push_back(2.0 * share);
  }
  return series;
}

// Rests at 0 except for presses of `length` samples from 100 on.
TableSeries presses(std::size_t length, double input, double output) {
  TableSeries series;
  for (std::size_t i = 0; i < kSamples; ++i) {
    const bool pressed = i >= 100 && i < 100 + length;
    series.input.push_back((pressed ? input : 0.0) + 0.01 * static_cast<double>(i % 3));
    series.output.push_back((pressed ? output : 0.0) + 0.001 * static_cast<double>(i % 5));
  }
  return series;
}

std::vector<std::size_t> places(const TableSeries& series) {
  std::vector<std::size_t> found;
  for (const ImplausibleSample& wild : implausible_samples(series)) found.push_back(wild.place);
  return found;
}

}  // namespace

TEST_CASE("wild samples: up to three in a row beyond three spans are found, in outputs or inputs, at any place") {
  using Values = std::vector<double> TableSeries::*;
  for (const Values values : {&TableSeries::output, &TableSeries::input}) {
    for (const double value : {83886.07, -83886.07, 1e308, 300.0, -250.0})
      for (const std::size_t first : {std::size_t{0}, std::size_t{77}, kSamples - 3})
        for (std::size_t length = 1; length <= 3; ++length) {
          TableSeries series = sweeps();
          std::vector<std::size_t> put;
          for (std::size_t i = first; i < first + length; ++i) {
            (series.*values)[i] = value;
            put.push_back(i);
          }
          INFO(value << " at " << first << ", " << length);
          if (first == kSamples - 3 && length < 3) continue;
          CHECK(places(series) == put);
        }
  }
  TableSeries seldom = sweeps();  // one row in twenty-five
  for (std::size_t i = 10; i < kSamples; i += 25) seldom.output[i] = 65535.0;
  CHECK(places(seldom).size() == 8);
}

TEST_CASE("wild samples: steps, short presses, zero jumps, noise and converter limits are not reported") {
  using Change = std::function<void(TableSeries&)>;
  const std::vector<std::pair<const char*, Change>> good = {
      {"as it is", [](TableSeries&) {}},
      {"the output's zero jumps and stays",
       [](TableSeries& s) {
         for (std::size_t i = 120; i < kSamples; ++i) s.output[i] += 20.0;
       }},
      {"one output at the end of the converter, 2.5 times the span", [](TableSeries& s) { s.output[60] = 5.0; }},
      {"a square wave",
       [](TableSeries& s) {
         for (std::size_t i = 0; i < kSamples; ++i) s.output[i] = 0.05 * (s.input[i] = i / 20 % 2 == 0 ? 0.0 : 40.0);
       }},
      {"constant", [](TableSeries& s) { std::ranges::fill(s.output, 1.0); }},
      {"a short recording, which tells no span", [](TableSeries& s) {
         s.input.resize(19);
         s.output.resize(19);
         s.output[9] = 1e6;
       }}};
  for (const auto& [what, change] : good) {
    TableSeries series = sweeps();
    change(series);
    INFO(what);
    CHECK(places(series).empty());
  }
  for (const std::size_t length : {1U, 2U, 3U, 10U}) CHECK(places(presses(length, 40.0, 2.0)).empty());
  CHECK(places(presses(2, 0.0, 2.0)).size() == 2);  // the input rests
  CHECK(places(presses(10, 0.0, 2.0)).empty());     // goes on for longer than a fault of one row
}

// The parts of a table line by line: separators, fields, numbers, and what its reader tells.

namespace {

std::string split_by(char separator, const std::string& line) {
  Fields fields;
  std::string out = fields.split(line, separator);
  for (const std::string_view field : fields.all) out += "[" + std::string(field) + "]";
  return out;
}

std::string number_read(const std::string& text) {
  double value = 0.0;
  const std::string wrong = NumberText().read(text, 1, value);
  return wrong.empty() ? std::to_string(value) : wrong;
}

}  // namespace

TEST_CASE("separator: the most frequent outside quotes, comma before others, blanks only if there is no other") {
  CHECK(separator_of("a,b;c") == ',');
  CHECK(separator_of("a;b;c,d") == ';');
  CHECK(separator_of("a\tb\tc;d") == '\t');
  CHECK(separator_of("\"a;b;c\",d") == ',');
  CHECK(separator_of("  a  b ") == ' ');
  CHECK(separator_of(" a ") == ',');
  CHECK(separator_of("a b;c") == ';');
}

TEST_CASE("table fields: doubled quotes, quoted separators, blanks and empty fields are split correctly") {
  CHECK(split_by(',', "a, b ,,") == "[a][b][][]");
  CHECK(split_by(',', "") == "[]");
  CHECK(split_by(',', R"("a,b",c)") == "[a,b][c]");
  CHECK(split_by(',', R"("a""b",""""""  ,"")") == R"([a"b][""][])");
  CHECK(split_by(',', R"( "a" ,b)") == "[a][b]");
  CHECK(split_by(' ', "  a   b\tc  ") == "[a][b][c]");
  CHECK(split_by(' ', R"(1 "a b" 2)") == "[1][a b][2]");
  CHECK(split_by('\t', "a\t b\t\tc") == "[a][b][][c]");
  CHECK_THAT(split_by(',', R"(a,"b)"), Catch::Contains("byte 3"));
  CHECK_THAT(split_by(',', R"("a" x,b)"), Catch::Contains("byte 3"));
  CHECK_THAT(split_by(',', R"(a,b"c)"), Catch::Contains("field 2"));
  CHECK(trimmed(" \t a b \r") == "a b");
  CHECK(trimmed(" \t\r").empty());
}

TEST_CASE("number text: signs, exponents and decimal commas are read, other text is refused") {
  CHECK(number_read("1.5") == "1.500000");
  CHECK(number_read("+1.5") == "1.500000");
  CHECK(number_read("-1,5") == "-1.500000");
  CHECK(number_read("1e2") == "100.000000");
  double value = 0.0;
  for (const char* none : {"", "1.2.3", "1,2,3", "1,2x", "--1", "+"}) {
    const std::string wrong = NumberText().read(none, 1, value);
    CHECK((!wrong.empty() && wrong != NumberText::kNotFinite));
  }
  CHECK(number_read("inf") == NumberText::kNotFinite);
  NumberText text;
  CHECK(text.read("7", 3, value).empty());  // neither point nor comma
  CHECK_FALSE(text.comma());
  CHECK(text.read("1,5", 4, value).empty());
  CHECK(text.read("2,5", 5, value).empty());
  CHECK((text.comma() && text.comma_line() == 4 && text.comma_text() == "1,5"));
  CHECK_THAT(text.read("1.5", 6, value), Catch::Contains(" 4"));
}

TEST_CASE("clock text: times with and without a date are converted to seconds, other text is refused") {
  CHECK(clock_seconds("10:11:12.5") == 36672.5);
  CHECK(clock_seconds("1970-01-02 00:00:01") == 86401.0);
  CHECK(clock_seconds("2000/03/01T00:00:00") == 951868800.0);
  for (const char* none : {"", "10:11", "10.11.12", "2026-11-02", "2026-13-02 10:00:00", "2026-11-02 10", "10:xx:12",
                           "a:b:c", "2026-11-02x10:00:00", "10:11:-2", "12345678901", "1:2:3:4"})
    CHECK_FALSE(clock_seconds(none));
}

TEST_CASE("formula cells: fields that a spreadsheet would execute are marked as text, all others are unchanged") {
  for (const char* formula :
       {"=1", "@SUM(A1)", "+cmd|' /C calc'!A0", "-1+cmd|' /C calc'!A0", "=", "-x", "-2+3", "+1-2e-3"})
    CHECK(is_formula(formula));
  for (const char* other : {"", "-", "-1", "+1,5", "-1e-3", "- 7", "-inf", "-nan", "a=b", "'=1", "1-2"})
    CHECK_FALSE(is_formula(other));
  CHECK(without_formulas("a,=1,-2", ',') == "a,'=1,-2");
  CHECK(without_formulas(R"(=a,"=b,=c", =d,"x,@e")", ',') == R"('=a,"'=b,=c", '=d,"x,@e")");
  CHECK(without_formulas("1;-2,5;@x", ';') == "1;-2,5;'@x");
}

TEST_CASE("TableReader: reports the requested columns, times, steps and the original text of each line") {
  std::istringstream stream("time_s;output;step\r\n0,5;1;x\r\n;2;3\r\n");
  TableReader reader(stream, "t", {}, TableNeeds::kOutput);
  CHECK(reader.header() == "time_s;output;step");
  CHECK((reader.has_seconds() && !reader.has_taxel() && reader.separator() == ';'));
  TableReader::Row row;
  REQUIRE(reader.next(row));
  CHECK((row.line == 2 && row.text == "0,5;1;x" && row.sequence == "1" && row.taxel == 0));
  CHECK((row.input == 0.0 && row.outputs.front() == 1.0));
  CHECK((row.time == 0.5 && !row.step));
  REQUIRE(reader.next(row));
  CHECK((row.outputs.front() == 2.0 && !row.time && row.step == 3.0));
  CHECK_FALSE(reader.next(row));
  CHECK(reader.assumed().size() == 1);
}
