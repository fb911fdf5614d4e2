// Splits one line of a text table into fields, and converts a field to a number.
#pragma once

#include <cstddef>
#include <deque>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace tactbench::analysis {

std::string_view trimmed(std::string_view text);  // without blanks, tabs and carriage returns at its ends

// The separator of a header: the most frequent of comma, semicolon and tab outside quotes; a blank if there are none of
// these between its words; else a comma.
char separator_of(std::string_view header);
std::string separator_name(char separator);  // "semicolons"

// A line's fields, views of it or of `unquoted` (fields that held a doubled quote). A field in quotes may hold the
// separator, and a quote as two (RFC 4180); it ends on its line. A run of blanks is one separator.
struct Fields {
  std::vector<std::string_view> all;
  std::deque<std::string> unquoted;
  // Splits the line; returns what is wrong with it, empty: nothing.
  std::string split(std::string_view line, char separator);
};

// Whether a spreadsheet would execute this field as a formula: it begins with = or @, or with a sign and is not a
// number.
bool is_formula(std::string_view field);
// The line with an apostrophe before each formula, which makes it a text.
std::string without_formulas(std::string_view line, char separator);

// Reads numbers with a decimal point or, throughout the table, a decimal comma.
class NumberText {
 public:
  static constexpr const char* kNotFinite = "is not finite";
  // What is wrong: "is not a number"; empty: `value` is set. `line`: of the file, for messages.
  std::string read(std::string_view text, std::size_t line, double& value);
  [[nodiscard]] bool comma() const { return !comma_text_.empty(); }
  [[nodiscard]] std::size_t comma_line() const { return comma_line_; }         // the first with a decimal comma
  [[nodiscard]] const std::string& comma_text() const { return comma_text_; }  // the number in that line

 private:
  std::size_t comma_line_ = 0, point_line_ = 0;
  std::string comma_text_, copy_;
};

bool is_number(std::string_view text);  // finite or not
// "10:11:12.5", or with "2026-11-02" and a blank or T before it -> seconds since midnight, or since 1970; else nothing.
std::optional<double> clock_seconds(std::string_view text);

}  // namespace tactbench::analysis
