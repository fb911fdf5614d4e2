// A table of samples as people have them: comma, semicolon or tab separated text with one line of column names.
#pragma once

#include <cstddef>
#include <istream>
#include <map>
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
  };
  // False at the end. Throws AnalysisError TB-TABLE-ROW: ragged, not a number, not finite; with file, line and column.
  bool next(Row& row);
  [[nodiscard]] const std::string& header() const { return header_; }
  [[nodiscard]] char separator() const { return separator_; }
  [[nodiscard]] bool has_taxel() const { return taxel_ != kAbsent; }

 private:
  static constexpr std::size_t kAbsent = static_cast<std::size_t>(-1);
  [[nodiscard]] std::size_t column(const ColumnMap& map, const std::string& role, bool needed) const;
  bool read_line();
  [[nodiscard]] double number(std::size_t column) const;
  [[noreturn]] void refuse(const std::string& what) const;
  std::istream* stream_;
  std::string file_, line_, header_;
  std::size_t number_ = 0;  // of line_, from 1
  char separator_ = ',';
  std::vector<std::string> names_;
  std::vector<std::string_view> fields_;
  std::size_t sequence_ = kAbsent, taxel_ = kAbsent, input_ = kAbsent, output_ = kAbsent;
};

// The whole file, series in the order of their first rows. Throws AnalysisError as above, TB-TABLE-OPEN, and
// TB-TABLE-EMPTY when no row follows the names.
std::vector<TableSeries> read_table(const std::string& path, const ColumnMap& map = {});

}  // namespace tactbench::analysis
