// A text table of samples (commas, semicolons, tabs or blanks between the columns) with one header line.
#pragma once

#include <array>
#include <cstddef>
#include <istream>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "analysis/table_fields.h"

namespace tactbench::analysis {

// Which column is what: by name, or by number from 1. "input" and "output" are needed where they are asked for;
// "sequence" and "taxel" may be absent.
struct ColumnMap {
  std::map<std::string, std::string> columns = {
      {"sequence", "sequence"}, {"input", "input"}, {"output", "output"}, {"taxel", "taxel"}};
};
// "input=COL,output=COL,...", a COL with a comma in double quotes. Throws AnalysisError TB-TABLE-MAP on other words.
ColumnMap column_map_from(const std::string& text);

// Samples of one taxel in one sequence, in row order.
struct TableSeries {
  std::string sequence;
  int taxel = 0;
  std::vector<double> input, output;
};

enum class TableNeeds { kInput, kOutput, kBoth };

// Rows that were left out, and why the first of them were: "line 7: ...".
struct SkippedRows {
  static constexpr std::size_t kNamed = 20;
  std::size_t count = 0;
  std::vector<std::string> first;
};

// Reads a table line by line. Lines that are empty or begin with '#' are passed over; so is a line of units after the
// names: one that holds no number, but words in the columns needed. All numbers have decimal points, or all have
// decimal commas.
class TableReader {
 public:
  // Reads the line of names and the one after it. `file` is for messages. skip_bad_rows: a row that next() would refuse
  // is left out. Throws AnalysisError TB-TABLE-EMPTY, TB-TABLE-COLUMN.
  TableReader(std::istream& stream, std::string file, const ColumnMap& map, TableNeeds needs,
              bool skip_bad_rows = false);

  struct Row {
    std::size_t line = 0;
    std::string_view text;  // the whole line; good until the next call
    std::string_view sequence;
    int taxel = 0;
    double input = 0.0, output = 0.0;  // 0 where not asked for
    std::optional<double> step;        // of a column called so, where it is a number
    std::optional<double> time_s;      // likewise
  };
  // False at the end. Throws AnalysisError TB-TABLE-ROW: ragged, blank, not a number, not finite, a quote that is not
  // closed, a NUL, a line beyond kLongestLine; with file, line and column. TB-TABLE-SKIPPED: more rows are left out
  // than read.
  bool next(Row& row);
  [[nodiscard]] const std::string& header() const { return header_; }
  [[nodiscard]] const std::string& units_line() const { return units_line_; }  // as it stands; empty: none
  // Of the line of units, without brackets; empty: not told.
  [[nodiscard]] const std::string& input_unit() const { return units_[0]; }
  [[nodiscard]] const std::string& output_unit() const { return units_[1]; }
  [[nodiscard]] char separator() const { return separator_; }
  [[nodiscard]] bool decimal_comma() const { return numbers_.comma(); }  // as far as it was read
  [[nodiscard]] bool has_taxel() const { return taxel_ != kAbsent; }
  [[nodiscard]] bool has_time() const { return time_ != kAbsent; }  // a column time_s
  [[nodiscard]] const SkippedRows& skipped() const { return skipped_; }
  void check_skipped() const;  // throws TB-TABLE-SKIPPED
  // What was taken for granted in what was read so far, a line each: separators, decimal commas, units.
  [[nodiscard]] std::vector<std::string> assumed() const;

 private:
  static constexpr std::size_t kAbsent = static_cast<std::size_t>(-1);
  static constexpr std::size_t kLongestLine = 1'000'000;    // bytes
  static constexpr std::size_t kMostSkippedAhead = 10'000;  // rows left out before the first that are read
  void read_names(std::size_t line, const ColumnMap& map, TableNeeds needs);
  void read_units();
  [[nodiscard]] std::size_t column(std::size_t line, const std::string& wanted, const char* role, bool needed) const;
  bool next_line();
  bool read_line();
  void split_line();
  void read_row(Row& row);
  void skip(const std::string& reason);
  [[nodiscard]] double number(std::size_t column);
  [[noreturn]] void refuse(std::size_t line, const std::string& what) const;
  std::istream* stream_;
  std::string file_, line_, header_, units_line_;
  std::vector<char> piece_ = std::vector<char>(std::size_t{1} << 16);
  std::size_t number_ = 0, units_number_ = 0;  // of line_ and units_line_, from 1
  std::size_t rows_ = 0;                       // read so far
  char separator_ = ',';
  bool skip_bad_rows_, ahead_ = false;  // ahead_: line_ is the next row
  std::vector<std::string> names_;
  std::array<std::string, 2> units_;
  Fields fields_;
  NumberText numbers_;
  SkippedRows skipped_;
  std::size_t sequence_ = kAbsent, taxel_ = kAbsent, input_ = kAbsent, output_ = kAbsent, step_ = kAbsent,
              time_ = kAbsent;
};

// A file or a pipe, at most 1 GB. Throws AnalysisError TB-TABLE-OPEN.
std::string table_text(const std::string& path);

struct Table {
  std::vector<TableSeries> series;      // in the order of their first rows
  std::string input_unit, output_unit;  // of its line of units; empty: not told
  std::vector<std::string> assumed;
  SkippedRows skipped;
};
// A whole table of at most 20 million rows; `file` is for messages. In a series the numbers of a column `step` rise, or
// begin again at the first (a repeat): rows that stand twice or out of order are refused, for a history in another
// order is another history. Throws AnalysisError as above, and TB-TABLE-EMPTY when no row follows the names.
Table read_table(std::istream& stream, const std::string& file, const ColumnMap& map = {}, bool skip_bad_rows = false);
Table read_table(const std::string& path, const ColumnMap& map = {}, bool skip_bad_rows = false);

}  // namespace tactbench::analysis
