// The parts of a table line by line: separators, fields, numbers, and what its reader tells.
#include <catch2/catch.hpp>
#include <sstream>

#include "analysis/table.h"

using namespace tactbench::analysis;

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

TEST_CASE("separators: the most frequent outside quotes, commas before others, blanks where there is nothing else") {
  CHECK(separator_of("a,b;c") == ',');
  CHECK(separator_of("a;b;c,d") == ';');
  CHECK(separator_of("a\tb\tc;d") == '\t');
  CHECK(separator_of("\"a;b;c\",d") == ',');
  CHECK(separator_of("  a  b ") == ' ');
  CHECK(separator_of(" a ") == ',');
  CHECK(separator_of("a b;c") == ';');
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

TEST_CASE("clocks by hand: with a date and without, and what is none") {
  CHECK(clock_seconds("10:11:12.5") == 36672.5);
  CHECK(clock_seconds("1970-01-02 00:00:01") == 86401.0);
  CHECK(clock_seconds("2000/03/01T00:00:00") == 951868800.0);
  for (const char* none : {"", "10:11", "10.11.12", "2026-11-02", "2026-13-02 10:00:00", "2026-11-02 10", "10:xx:12",
                           "a:b:c", "2026-11-02x10:00:00", "10:11:-2", "12345678901", "1:2:3:4"})
    CHECK_FALSE(clock_seconds(none));
}

TEST_CASE("formulas by hand: a field that a spreadsheet would carry out is a text, numbers and other texts stay") {
  for (const char* formula :
       {"=1", "@SUM(A1)", "+cmd|' /C calc'!A0", "-1+cmd|' /C calc'!A0", "=", "-x", "-2+3", "+1-2e-3"})
    CHECK(is_formula(formula));
  for (const char* other : {"", "-", "-1", "+1,5", "-1e-3", "- 7", "-inf", "-nan", "a=b", "'=1", "1-2"})
    CHECK_FALSE(is_formula(other));
  CHECK(without_formulas("a,=1,-2", ',') == "a,'=1,-2");
  CHECK(without_formulas(R"(=a,"=b,=c", =d,"x,@e")", ',') == R"('=a,"'=b,=c", '=d,"x,@e")");
  CHECK(without_formulas("1;-2,5;@x", ';') == "1;-2,5;'@x");
}

TEST_CASE("a reader tells what it needs: columns that are not asked for, times, lines as they stand") {
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
