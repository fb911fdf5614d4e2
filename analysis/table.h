// A text table of samples: columns separated by commas, semicolons, tabs or blanks, with or without a line of names.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <istream>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "analysis/table_head.h"

namespace tactbench::analysis {

// Layout of a table, as far as the user states it. A column is given by name or by number from 1; "output" may be
// several columns, one per taxel: 3-18, volts_*, or s0+s1. "input" and "output" are required if requested; "sequence",
// "taxel" and "time" may be absent.
struct TableLayout {
  std::map<std::string, std::string> columns = {
      {"sequence", "sequence"}, {"input", "input"}, {"output", "output"}, {"taxel", "taxel"}, {"time", "time_s"}};
  bool no_header = false;      // no line of names; columns are numbers
  std::size_t skip_lines = 0;  // lines skipped at the beginning, whatever they contain
  bool skip_bad_rows = false;  // an invalid row, or one with an implausible sample, is left out
};
// "input=COL,output=COL,...", a COL with a comma in double quotes, each role once. Throws AnalysisError TB-TABLE-MAP.
TableLayout table_layout(const std::string& map);

// Samples of one taxel in one sequence, in row order.
struct TableSeries {
  std::string sequence;
  int taxel = 0;
  std::vector<double> input, output;
  std::vector<double> time_s{};        // empty: not known for all samples
  std::vector<std::uint32_t> lines{};  // line numbers in the table; empty: none
};

// Samples with an input or output that is implausible between its neighbours, which agree. At most one per row of the
// table.
struct ImplausibleSample {
  std::size_t place = 0;  // index in the series
  bool input = false;
  double value = 0.0,
         spans = 0.0;  // spans: distance to its neighbours, in units of the span of the middle 90 % of the values
};
std::vector<ImplausibleSample> implausible_samples(const TableSeries& series);
// "line 214: the output 83886.1 lies 2.9e+04 spans from its neighbours".
std::string implausible_text(const TableSeries& series, const ImplausibleSample& wild);

enum class TableNeeds { kInput, kOutput, kBoth };

// Rows that were left out, and the reasons for the first ones: "line 7: ...".
struct SkippedRows {
  static constexpr std::size_t kNamed = 20;
  std::size_t count = 0;
  std::vector<std::string> first;
};

// Reads a table line by line, in these steps:
// 1. Lines end in LF, CR or both. A byte order mark, the first `skip_lines` lines, empty lines and lines that begin
// with '#' or '%' (below the names also with ';', unless semicolons separate) are skipped.
// 2. A line sep=X gives the separator, and LabVIEW's headers are skipped.
// 3. The line of names is the first one with all columns that were requested by name; if all were requested by number,
// the line above the first with numbers in these columns. Lines before it are skipped.
// 4. A line of units may follow: a line without numbers that has short words in the requested columns.
// 5. Rows. All numbers have decimal points, or all have decimal commas. One field at the end is optional if it never
// contains a number: a comment, or an empty field after a last separator. Tables from `runs export` need no map:
// reference_psi, volts_* and recipe are recognised.
class TableReader {
 public:
  // Executes steps 1 to 4. `file` is for messages. Throws AnalysisError TB-TABLE-EMPTY, TB-TABLE-COLUMN.
  TableReader(std::istream& stream, std::string file, TableLayout layout, TableNeeds needs);

  struct Row {
    std::size_t line = 0;
    std::string text;  // the whole line
    std::string sequence;
    int taxel = 0;
    double input = 0.0;           // 0 if not requested
    std::vector<double> outputs;  // one per column
    // If only outputs are requested: why some outputs are NaN, or all of them because the row is too short or has no
    // taxel; then `text` is padded and `outputs` is empty.
    std::string bad;
    std::optional<double> step;   // of a column named step, if it is a number
    std::optional<double> time;   // of the time column, in seconds; clock times are converted
    std::optional<double> frame;  // of a table from `runs export`
  };
  // Reads the next row; false at the end. From an exported table one frame: the row of its first scan with the mean
  // outputs of all scans; void rows are left out. If only outputs are requested, a row with unreadable outputs is
  // returned with Row::bad. Throws AnalysisError TB-TABLE-ROW: ragged, blank, not a number, not finite, a quote that is
  // not closed, a NUL, a line beyond kMaxLineBytes; with file, line and column. TB-TABLE-SKIPPED: more rows were left
  // out than read.
  bool next(Row& row);
  [[nodiscard]] const std::string& header() const { return header_; }          // the header line unchanged; empty: none
  [[nodiscard]] const std::string& units_line() const { return units_line_; }  // likewise
  // Unit from the line of units, without brackets; empty: not stated.
  [[nodiscard]] const std::string& input_unit() const { return units_[0]; }
  [[nodiscard]] const std::string& output_unit() const { return units_[1]; }
  [[nodiscard]] char separator() const { return separator_; }
  [[nodiscard]] bool decimal_comma() const { return numbers_.comma(); }  // whether a decimal comma was read so far
  [[nodiscard]] bool has_taxel() const { return taxel_ != kAbsent; }
  [[nodiscard]] bool has_seconds() const { return time_ != kAbsent && in_seconds_; }
  [[nodiscard]] std::size_t outputs() const { return outputs_.size(); }  // columns
  [[nodiscard]] const SkippedRows& skipped() const { return skipped_; }
  void check_skipped() const;  // throws TB-TABLE-SKIPPED
  // Assumptions made so far, one line each: separators, decimal commas, names, units.
  [[nodiscard]] std::vector<std::string> assumed() const;

 private:
  static constexpr std::size_t kAbsent = static_cast<std::size_t>(-1);
  static constexpr std::size_t kMaxLineBytes = 1'000'000;  // bytes
  static constexpr std::size_t kMaxSkippedAhead = 10'000;  // rows left out before the first valid rows
  static constexpr std::size_t kMostLooked = 1000;         // lines searched for the line of names
  struct Line {
    std::size_t number = 0;
    std::string text;
  };
  // Implemented in table_head.cpp: finds the line of names.
  void find_names(const std::vector<std::string>& wanted);
  void find_first_row(const std::vector<std::size_t>& columns);
  void name_by(std::size_t line);
  void number_from(std::size_t row, std::size_t columns);
  bool look();
  [[nodiscard]] std::vector<std::string> split(const std::string& line, char separator) const;
  [[nodiscard]] std::optional<char> separator_of_row(const std::string& line,
                                                     const std::vector<std::size_t>& columns) const;
  void set_columns(TableNeeds needs);
  void take_export();
  [[nodiscard]] std::size_t place_of(std::string_view name) const;
  [[nodiscard]] std::vector<std::size_t> columns(const char* role) const;
  [[nodiscard]] std::size_t column(const char* role) const;
  [[nodiscard]] bool stated(const char* role) const;
  void read_units();
  [[nodiscard]] bool is_units(const std::vector<std::string>& words, const std::vector<std::size_t>& columns) const;
  [[noreturn]] void refuse_names(const std::string& what, const std::string& remedy) const;

  bool next_line();
  bool new_line();
  bool read_line();
  bool next_row(Row& row);
  [[nodiscard]] bool needed(std::size_t column) const;
  void check_width();
  void read_row(Row& row);
  void read_outputs(Row& row);
  void skip(const std::string& reason);
  [[nodiscard]] double number(std::size_t column);
  [[nodiscard]] std::optional<double> if_number(std::size_t column) const;
  [[noreturn]] void refuse(std::size_t line, const std::string& what) const;
  std::istream* stream_;
  std::string file_, line_, header_, units_line_;
  TableLayout layout_;
  std::size_t counted_ = 0;                      // lines of the stream so far
  std::size_t number_ = 0, units_number_ = 0;    // of line_ and units_line_, from 1
  std::size_t head_number_ = 0, first_row_ = 0;  // of the line of names, or of the first row without one
  std::size_t passed_ = 0;                       // lines skipped before these, without comments
  std::size_t rows_ = 0, voids_ = 0;             // rows read so far, and the void ones among them
  std::size_t scans_ = 1;                        // greatest number of scans of a frame
  TableNeeds needs_;
  std::optional<Row> next_;  // first row of the next frame
  std::deque<Line> ahead_;   // lines read from the stream but not yet returned
  char separator_ = 0;       // 0: not known yet
  bool skip_line_feed_ = false, labview_ = false, in_seconds_ = false;
  std::size_t short_line_ = 0;      // the first line without its last field
  bool number_at_end_ = false;      // the last field held a number
  std::vector<std::string> names_;  // numbers if there are no names
  std::array<std::string, 2> units_;
  Fields fields_;
  NumberText numbers_;
  SkippedRows skipped_;
  std::vector<std::size_t> outputs_;
  std::size_t sequence_ = kAbsent, taxel_ = kAbsent, input_ = kAbsent, step_ = kAbsent, time_ = kAbsent,
              frame_ = kAbsent, void_ = kAbsent;
};

// Checks the times of one history, row by row.
class TimeOrder {
 public:
  // Why `time` cannot follow the previous one; empty if it can: then `time` is continued across the wrap of a 32 or 16
  // bit counter, or of a day.
  std::string see(double& time);
  [[nodiscard]] std::size_t wraps() const { return wraps_; }

 private:
  std::optional<double> last_;
  double longest_ = 0.0, offset_ = 0.0;
  std::size_t wraps_ = 0;
};

// A file or a pipe, at most 1 GB. Throws AnalysisError TB-TABLE-OPEN.
std::string table_text(const std::string& path);

struct Table {
  std::vector<TableSeries> series;      // in the order of their first rows
  std::string input_unit, output_unit;  // from its line of units; empty: not stated
  std::vector<std::string> assumed;
  SkippedRows skipped;
};
// A whole table of at most 20 million samples; `file` is for messages. In a series the numbers of a column `step` rise,
// or start again at the first one (a repeat), and times do not decrease: repeated rows or rows out of order are
// refused, because in another order they are another history. Throws AnalysisError as above, TB-TABLE-STEP,
// TB-TABLE-TIME, and TB-TABLE-EMPTY when no row follows the names.
Table read_table(std::istream& stream, const std::string& file, const TableLayout& layout = {});
Table read_table(const std::string& path, const TableLayout& layout = {});

}  // namespace tactbench::analysis
