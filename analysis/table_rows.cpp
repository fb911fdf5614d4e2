// A whole table: its rows dealt to the histories that they belong to.
#include <fmt/format.h>

#include <map>
#include <sstream>
#include <utility>

#include "analysis/counted.h"
#include "analysis/error.h"
#include "analysis/table.h"
#include "analysis/whole_file.h"
#include "analysis/work_count.h"

namespace tactbench::analysis {
namespace {

constexpr std::size_t kLargestTable = 1'000'000'000;  // bytes
constexpr std::size_t kMostRows = 20'000'000;
constexpr std::size_t kCountedRows = 4096;  // between two looks at how far the file is read

// Bytes that can still be read; 0: not known, as of a pipe.
std::size_t bytes_left(std::istream& stream) {
  const auto here = stream.tellg();
  stream.seekg(0, std::ios::end);
  const auto end = stream.tellg();
  stream.clear();
  stream.seekg(here);
  return here < 0 || end < here ? 0 : static_cast<std::size_t>(end - here);
}

// Numbers of a column `step` as the rows of one series bring them.
class StepOrder {
 public:
  // Why `step` cannot follow; empty when it can. They rise; a fall to where they began is the next repeat.
  std::string see(double step) {
    const double before = last_.value_or(step - 1.0);
    if (!last_) first_ = step;
    last_ = step;
    if (step > before || (step < before && step == first_)) return {};
    return step == before ? fmt::format("step {:g} occurs twice", step)
                          : fmt::format("step {:g} comes after step {:g}", step, before);
  }

 private:
  double first_ = 0.0;
  std::optional<double> last_;
};

}  // namespace

std::string table_text(const std::string& path) {
  return whole_file(path, {.most_bytes = kLargestTable, .or_pipe = true}, "TB-TABLE-OPEN", "check its name and rights");
}

Table read_table(std::istream& stream, const std::string& file, const ColumnMap& map, bool skip_bad_rows) {
  Work read(bytes_left(stream));
  TableReader reader(stream, file, map, TableNeeds::kBoth, skip_bad_rows);
  Table table;
  std::vector<TableSeries>& series = table.series;
  std::vector<StepOrder> orders;
  std::map<std::pair<std::string, int>, std::size_t, std::less<>> places;
  std::size_t last = 0, rows = 0;
  std::streamoff at = 0;
  for (TableReader::Row row; reader.next(row);) {
    if (rows % kCountedRows == 0 && stream.good()) {
      const std::streamoff now = stream.tellg();
      read.add(static_cast<std::size_t>(now - at));
      at = now;
    }
    if (++rows > kMostRows)
      throw AnalysisError("TB-TABLE-ROW", fmt::format("{}: more than {} rows", file, kMostRows),
                          "take the sequences that are to be fitted, or every other row");
    if (series.empty() || series[last].taxel != row.taxel || series[last].sequence != row.sequence) {
      const auto [place, fresh] = places.try_emplace({std::string(row.sequence), row.taxel}, series.size());
      if (fresh) {
        series.push_back({std::string(row.sequence), row.taxel, {}, {}});
        orders.emplace_back();
      }
      last = place->second;
    }
    if (const std::string wrong = row.step ? orders[last].see(*row.step) : std::string(); !wrong.empty())
      throw AnalysisError("TB-TABLE-STEP",
                          fmt::format("{}:{}: {} in sequence \"{}\"{}", file, row.line, wrong, row.sequence,
                                      reader.has_taxel() ? fmt::format(", taxel {}", row.taxel) : ""),
                          "rows must be in the order in which they were measured, each once; give the column another "
                          "name if it does not count the rows of a sequence");
    series[last].input.push_back(row.input);
    series[last].output.push_back(row.output);
  }
  reader.check_skipped();
  if (series.empty())
    throw AnalysisError("TB-TABLE-EMPTY", fmt::format("{}: no row follows the line of names", file),
                        "write a row for each sample below the names");
  table.input_unit = reader.input_unit();
  table.output_unit = reader.output_unit();
  table.assumed = reader.assumed();
  table.skipped = reader.skipped();
  return table;
}

Table read_table(const std::string& path, const ColumnMap& map, bool skip_bad_rows) {
  std::istringstream stream(table_text(path));
  return read_table(stream, path, map, skip_bad_rows);
}

}  // namespace tactbench::analysis
