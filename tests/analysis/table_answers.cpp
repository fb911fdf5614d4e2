// Tables at each of their bounds: taxels, units, separators, quotes, steps, rows that are left out.
#include <catch2/catch.hpp>
#include <sstream>

#include "analysis/error.h"
#include "analysis/table.h"

using namespace tactbench::analysis;

namespace {

Table table_in(const std::string& text, const std::string& map = {}, bool skip_bad_rows = false) {
  std::istringstream stream(text);
  return read_table(stream, "t", column_map_from(map), skip_bad_rows);
}

std::string refused_table(const std::string& text, const std::string& map = {}, bool skip_bad_rows = false) {
  try {
    (void)table_in(text, map, skip_bad_rows);
  } catch (const AnalysisError& error) {
    return error.id() + " " + error.what();
  }
  return "accepted";
}

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

TEST_CASE("taxels of a table are whole numbers from 0 to a million") {
  const auto taxel = [](const std::string& cell) { return refused_table("input,output,taxel\n1,2," + cell + "\n"); };
  CHECK(taxel("0") == "accepted");
  CHECK(taxel("1000000") == "accepted");
  for (const char* none : {"1000001", "-1", "0.5"}) CHECK_THAT(taxel(none), Catch::StartsWith("TB-TABLE-ROW t:2"));
  CHECK(table_in("input,output,taxel\n1,2,7\n").series[0].taxel == 7);
}

TEST_CASE("columns by number: from 1 to as many as there are, a name before a number") {
  const std::string text = "2,b,c\n5,6,7\n";
  const auto first = [&](const std::string& map) { return table_in(text, map).series[0].input[0]; };
  CHECK(first("input=1,output=b") == 5.0);
  CHECK(first("input=3,output=b") == 7.0);
  CHECK(first("input=2,output=b") == 5.0);  // the column that is called so
  CHECK_THAT(refused_table(text, "input=0,output=b"), Catch::Contains("\"0\""));
  CHECK_THAT(refused_table(text, "input=4,output=b"), Catch::Contains("\"4\""));
  CHECK_THAT(refused_table(text, "input=1x,output=b"), Catch::Contains("\"1x\""));
  CHECK_THAT(refused_table(text, "input=1,output=b,sequence=x"), Catch::Contains("\"x\""));
  CHECK_THAT(refused_table(text, "input=1,output=b,taxel=9"), Catch::Contains("\"9\""));
  CHECK_THAT(refused_table(text, "input"), Catch::Contains("--map"));
  CHECK_THAT(refused_table(text, "\"input=1,2\""), Catch::Contains("TB-TABLE-MAP"));
  CHECK(first(" input = 1 , output = b ") == 5.0);
}

TEST_CASE(
    "a line of units: words of up to 24 bytes in the columns needed, as many fields as names, no number anywhere") {
  const auto second_line = [](const std::string& line) {
    const std::string text = "input,output,note\n" + line + "\n1,2,\n";
    return refused_table(text) == "accepted" ? table_in(text).output_unit : std::string("refused");
  };
  CHECK(second_line("psi,V,x") == "V");
  CHECK(second_line("psi," + std::string(24, 'u') + ",x") == std::string(24, 'u'));
  CHECK(second_line("psi," + std::string(25, 'u') + ",x") == "refused");
  CHECK(second_line("psi,V,") == "V");
  CHECK(second_line("psi,V,1") == "refused");
  CHECK(second_line("psi,V") == "refused");
  CHECK(second_line("psi,,x") == "refused");
  for (const char* none : {"NA", "N/A", "na", "n/a"})
    CHECK(second_line(std::string("psi,") + none + ",x") == "refused");
  CHECK(second_line("psi,[mV],x") == "mV");
  CHECK(second_line("psi,( mV ),x") == "mV");
  CHECK(second_line("psi,[mV),x") == "[mV)");
  CHECK(second_line("psi,[],x").empty());
  CHECK(second_line("psi,\"\x01\",x").empty());  // no text
  CHECK(second_line("psi,[,x") == "[");
  CHECK(table_in("input,output\nmm,\xC2\xB5m\n1,2\n").output_unit == "\xC2\xB5m");
}

TEST_CASE("separators: the most frequent outside quotes, commas before others, blanks where there is nothing else") {
  CHECK(separator_of("a,b;c") == ',');
  CHECK(separator_of("a;b;c,d") == ';');
  CHECK(separator_of("a\tb\tc;d") == '\t');
  CHECK(separator_of("\"a;b;c\",d") == ',');
  CHECK(separator_of("  a  b ") == ' ');
  CHECK(separator_of(" a ") == ',');
  CHECK(separator_of("a b;c") == ';');
  CHECK(std::string(separator_word(',')) == "commas");
  CHECK(std::string(separator_word(';')) == "semicolons");
  CHECK(std::string(separator_word('\t')) == "tabs");
  CHECK(std::string(separator_word(' ')) == "blanks");
}

TEST_CASE("fields by hand: quotes doubled and closed, blanks around and between, empty ones") {
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

TEST_CASE("numbers by hand: signs, exponents, decimal commas, and what is none") {
  CHECK(number_read("1.5") == "1.500000");
  CHECK(number_read("+1.5") == "1.500000");
  CHECK(number_read("-1,5") == "-1.500000");
  CHECK(number_read("1e2") == "100.000000");
  CHECK(number_read("") == "is blank");
  CHECK(number_read("1.2.3") == "is not a number");
  CHECK_THAT(number_read("1,2,3"), Catch::StartsWith("is not a number"));
  CHECK(number_read("1,2x") == "is not a number");
  CHECK(number_read("--1") == "is not a number");
  CHECK(number_read("+") == "is not a number");
  CHECK(number_read("inf") == NumberText::kNotFinite);
  double value = 0.0;
  NumberText text;
  CHECK(text.read("7", 3, value).empty());  // neither point nor comma
  CHECK_FALSE(text.comma());
  CHECK(text.read("1,5", 4, value).empty());
  CHECK(text.read("2,5", 5, value).empty());
  CHECK((text.comma() && text.comma_line() == 4 && text.comma_text() == "1,5"));
  CHECK_THAT(text.read("1.5", 6, value), Catch::Contains("line 4"));
}

TEST_CASE("steps by hand: they rise, or fall to where they began") {
  const auto steps = [](const std::string& numbers) {
    std::string text = "step,input,output\n";
    for (const char step : numbers) text += std::string(1, step) + ",0,0\n";
    return refused_table(text);
  };
  CHECK(steps("123123") == "accepted");
  CHECK(steps("3693") == "accepted");
  CHECK(steps("1") == "accepted");
  CHECK_THAT(steps("1232"), Catch::Contains("step 2"));
  CHECK_THAT(steps("12312412"), Catch::Contains("accepted"));
  CHECK_THAT(steps("11"), Catch::Contains("step 1"));
  CHECK_THAT(steps("1211"), Catch::Contains("step 1"));
  CHECK_THAT(steps("2312"), Catch::Contains("step 1"));
  CHECK_THAT(refused_table("step,input,output,taxel\n1,0,0,4\n1,0,0,4\n"), Catch::Contains("taxel 4"));
}

TEST_CASE("rows left out: half of them may be, one more may not, and ten thousand before any is read") {
  const auto rows = [](int bad, int good) {
    std::string text = "input,output\n";
    for (int i = 0; i < bad; ++i) text += "x,1\n";
    for (int i = 0; i < good; ++i) text += "1,2\n";
    return refused_table(text, {}, true);
  };
  CHECK(rows(3, 3) == "accepted");
  CHECK_THAT(rows(4, 3), Catch::Contains("4 of 7"));
  CHECK(rows(10000, 10000) == "accepted");
  CHECK_THAT(rows(10001, 10001), Catch::Contains("10001"));
  std::string text = "input,output\n";
  for (int i = 0; i < 21; ++i) text += "x,1\n1,2\n";
  CHECK((table_in(text, {}, true).skipped.count == 21 && table_in(text, {}, true).skipped.first.size() == 20));
}

TEST_CASE("a reader tells what it needs: columns that are not asked for, times, lines as they stand") {
  std::istringstream stream("time_s;output;step\r\n0,5;1;x\r\n;2;3\r\n");
  TableReader reader(stream, "t", {}, TableNeeds::kOutput);
  CHECK(reader.header() == "time_s;output;step");
  CHECK((reader.has_time() && !reader.has_taxel() && reader.separator() == ';'));
  TableReader::Row row;
  REQUIRE(reader.next(row));
  CHECK((row.line == 2 && row.text == "0,5;1;x" && row.sequence == "1" && row.taxel == 0));
  CHECK((row.input == 0.0 && row.output == 1.0));
  CHECK((row.time_s == 0.5 && !row.step));
  REQUIRE(reader.next(row));
  CHECK((row.output == 2.0 && !row.time_s && row.step == 3.0));
  CHECK_FALSE(reader.next(row));
  CHECK(reader.assumed() == std::vector<std::string>{"columns are separated by semicolons"});
}
