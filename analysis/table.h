// A text table of samples (comma, semicolon or tab) with one header line.
#pragma once

#include <cstddef>
#include <deque>
#include <istream>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace tactbench::analysis {

// Which column is what: by name, or by number from 1. "input" and "output" are needed where they are asked for;
// "sequence" and "taxel" may be absent.
struct ColumnMap {
  std::map<std::string, std::string> columns = {
      {"sequence", "sequence"}, {"input", "input"}, {"output", "output"}, {"taxel", "taxel"}};
};
// "input=COL,output=COL,...". Throws AnalysisError TB-TABLE-MAP on other words.
ColumnMap column_map_from(const std::string& text);

// Samples of one taxel in one sequence, in row order.
struct TableSeries {
  std::string sequence;
  int taxel = 0;
  std::vector<double> input, output;
};

enum class TableNeeds { kInput, kOutput, kBoth };

// Reads a table line by line. Lines that are empty or begin with '#' are passed over.
class TableReader {
 public:
  // Reads the line of names. `file` is for messages. Throws AnalysisError TB-TABLE-EMPTY, TB-TABLE-COLUMN.
  TableReader(std::istream& stream, std::string file, const ColumnMap& map, TableNeeds needs);

  struct Row {
    std::size_t line = 0;
    std::string_view text;  // the whole line; good until the next call
    std::string_view sequence;
    int taxel = 0;
    double input = 0.0, output = 0.0;  // 0 where not asked for
    std::optional<double> step;        // of a column called so, where it is a number
  };
  // False at the end. Throws AnalysisError TB-TABLE-ROW: ragged, not a number, not finite, a quote that is not closed,
  // a NUL, a line beyond kLongestLine; with file, line and column.
  bool next(Row& row);
  [[nodiscard]] const std::string& header() const { return header_; }
  [[nodiscard]] char separator() const { return separator_; }
  [[nodiscard]] bool has_taxel() const { return taxel_ != kAbsent; }

 private:
  static constexpr std::size_t kAbsent = static_cast<std::size_t>(-1);
  static constexpr std::size_t kLongestLine = 1'000'000;  // bytes
  [[nodiscard]] std::size_t column(const ColumnMap& map, const std::string& role, bool needed) const;
  bool next_line();
  bool read_line();
  void split_line();
  [[nodiscard]] double number(std::size_t column) const;
  [[noreturn]] void refuse(const std::string& what) const;
  std::istream* stream_;
  std::string file_, line_, header_;
  std::vector<char> piece_ = std::vector<char>(std::size_t{1} << 16);
  std::size_t number_ = 0;  // of line_, from 1
  char separator_ = ',';
  std::vector<std::string> names_;
  std::vector<std::string_view> fields_;
  std::deque<std::string> unquoted_;  // fields that held a doubled quote
  std::size_t sequence_ = kAbsent, taxel_ = kAbsent, input_ = kAbsent, output_ = kAbsent, step_ = kAbsent;
};

// A file or a pipe, at most 1 GB. Throws AnalysisError TB-TABLE-OPEN.
std::string table_text(const std::string& path);

// A whole table of at most 20 million rows, series in the order of their first rows; `file` is for messages. In a
// series the numbers of a column `step` rise, or begin again at the first (a repeat): rows that stand twice or out of
// order are refused, for a history in another order is another history. Throws AnalysisError as above, and
// TB-TABLE-EMPTY when no row follows the names.
std::vector<TableSeries> read_table(std::istream& stream, const std::string& file, const ColumnMap& map = {});
std::vector<TableSeries> read_table(const std::string& path, const ColumnMap& map = {});

}  // namespace tactbench::analysis
