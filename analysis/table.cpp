#include "analysis/table.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <sstream>
#include <utility>

#include "analysis/counted.h"
#include "analysis/error.h"
#include "analysis/whole_file.h"

namespace tactbench::analysis {
namespace {

constexpr const char* kFormat =
    "the first line names the columns, e.g. sequence,step,input,output; --map input=COL,output=COL says which is which";

constexpr std::size_t kLargestTable = 1'000'000'000;  // bytes
constexpr std::size_t kMostRows = 20'000'000;

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

void split(std::string_view line, char separator, std::vector<std::string_view>& fields) {
  fields.clear();
  for (;;) {
    const auto end = line.find(separator);
    fields.push_back(trimmed(line.substr(0, end)));
    if (end == std::string_view::npos) return;
    line.remove_prefix(end + 1);
  }
}

// Where a field that begins with a quote ends: the place of its closing quote; none when the line ends before.
std::size_t closing_quote(std::string_view text, std::size_t open) {
  for (std::size_t at = text.find('"', open + 1); at != std::string_view::npos; at = text.find('"', at + 2))
    if (at + 1 >= text.size() || text[at + 1] != '"') return at;
  return std::string_view::npos;
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
    return step == before ? fmt::format("step {:g} stands twice", step)
                          : fmt::format("step {:g} comes after step {:g}", step, before);
  }

 private:
  double first_ = 0.0;
  std::optional<double> last_;
};

}  // namespace

ColumnMap column_map_from(const std::string& text) {
  ColumnMap map;
  std::vector<std::string_view> pairs;
  if (!text.empty()) split(text, ',', pairs);
  for (const std::string_view pair : pairs) {
    const auto equals = pair.find('=');
    const std::string role(trimmed(pair.substr(0, equals)));
    if (equals == std::string_view::npos || equals + 1 == pair.size() || !map.columns.contains(role))
      throw AnalysisError(Cause::kUsage, "TB-TABLE-MAP",
                          fmt::format("--map: \"{}\" does not say which column is what", pair),
                          "write role=COLUMN with the roles input, output, sequence, taxel; COLUMN is a name or a "
                          "number from 1");
    map.columns[role] = trimmed(pair.substr(equals + 1));
  }
  return map;
}

TableReader::TableReader(std::istream& stream, std::string file, const ColumnMap& map, TableNeeds needs)
    : stream_(&stream), file_(std::move(file)) {
  if (!read_line())
    throw AnalysisError(Cause::kUsage, "TB-TABLE-EMPTY", fmt::format("{}: the table is empty", file_), kFormat);
  if (line_.starts_with("\xEF\xBB\xBF")) line_.erase(0, 3);  // a byte order mark
  header_ = line_;
  if (!header_.empty() && header_.back() == '\r') header_.pop_back();
  for (const char candidate : {',', ';', '\t'})
    if (std::ranges::count(line_, candidate) > std::ranges::count(line_, separator_)) separator_ = candidate;
  split_line();
  names_.assign(fields_.begin(), fields_.end());
  input_ = needs == TableNeeds::kOutput ? kAbsent : column(map, "input", true);
  output_ = needs == TableNeeds::kInput ? kAbsent : column(map, "output", true);
  sequence_ = column(map, "sequence", map.columns.at("sequence") != "sequence");
  taxel_ = column(map, "taxel", map.columns.at("taxel") != "taxel");
  const auto step = std::ranges::find(names_, "step");
  if (step != names_.end()) step_ = static_cast<std::size_t>(step - names_.begin());
}

std::size_t TableReader::column(const ColumnMap& map, const std::string& role, bool needed) const {
  const std::string& wanted = map.columns.at(role);
  const auto found = std::ranges::find(names_, wanted);
  if (found != names_.end()) return static_cast<std::size_t>(found - names_.begin());
  std::size_t number = 0;
  const auto [end, error] = std::from_chars(wanted.data(), wanted.data() + wanted.size(), number);
  if (error == std::errc() && end == wanted.data() + wanted.size() && number >= 1 && number <= names_.size())
    return number - 1;
  if (!needed) return kAbsent;
  throw AnalysisError(Cause::kUsage, "TB-TABLE-COLUMN",
                      fmt::format("{}:{}: no column \"{}\" for the {}; the line names {}", file_, number_, wanted, role,
                                  fmt::join(names_, ", ")),
                      kFormat);
}

// std::getline, but of no more than kLongestLine bytes and a piece.
bool TableReader::next_line() {
  line_.clear();
  while (line_.size() <= kLongestLine) {
    stream_->getline(piece_.data(), static_cast<std::streamsize>(piece_.size()));
    const auto got = static_cast<std::size_t>(stream_->gcount());
    if (!stream_->fail()) {  // to the end of the line, which is counted, or of the file
      line_.append(piece_.data(), stream_->eof() ? got : got - 1);
      return true;
    }
    if (got == 0) return !line_.empty();
    line_.append(piece_.data(), got);
    stream_->clear(stream_->rdstate() & ~std::ios::failbit);
  }
  return true;
}

bool TableReader::read_line() {
  while (next_line()) {
    ++number_;
    if (line_.size() > kLongestLine) refuse(fmt::format("a line of more than {} bytes", kLongestLine));
    if (const auto nul = line_.find('\0'); nul != std::string::npos)
      refuse(fmt::format("byte {} is a NUL: this is no text in UTF-8 (UTF-16 has one at each letter)", nul + 1));
    const std::string_view text = trimmed(line_);
    if (!text.empty() && text.front() != '#') return true;
  }
  if (stream_->bad())
    throw AnalysisError(Cause::kUsage, "TB-TABLE-OPEN", fmt::format("{}: reading failed after line {}", file_, number_),
                        "check the disk and the file");
  return false;
}

void TableReader::refuse(const std::string& what) const {
  throw AnalysisError(Cause::kUsage, "TB-TABLE-ROW", fmt::format("{}:{}: {}", file_, number_, what),
                      "mend or remove the line");
}

// A field in quotes may hold the separator, and a quote as two (RFC 4180); it ends on its line.
void TableReader::split_line() {
  fields_.clear();
  unquoted_.clear();
  const std::string_view line = line_;
  const char* blanks = separator_ == '\t' ? " " : " \t";
  for (std::size_t start = 0;;) {
    const std::size_t open = std::min(line.find_first_not_of(blanks, start), line.size());
    const bool quoted = line.substr(open, 1) == "\"";
    const std::size_t close = quoted ? closing_quote(line, open) : start;
    if (close == std::string_view::npos)
      refuse(fmt::format("the quote at byte {} is not closed on the line", open + 1));
    const std::size_t end = std::min(line.find(separator_, close), line.size());
    if (quoted) {
      if (!trimmed(line.substr(close + 1, end - close - 1)).empty())
        refuse(fmt::format("after the closing quote at byte {} stands more than a separator", close + 1));
      std::string_view inside = line.substr(open + 1, close - open - 1);
      if (inside.find('"') != std::string_view::npos) {
        std::string& own = unquoted_.emplace_back(inside);
        for (std::size_t at = 0; (at = own.find("\"\"", at)) != std::string::npos; ++at) own.erase(at, 1);
        inside = own;
      }
      fields_.push_back(trimmed(inside));
    } else {
      fields_.push_back(trimmed(line.substr(start, end - start)));
      if (fields_.back().find('"') != std::string_view::npos)
        refuse(fmt::format("a quote stands in the middle of field {}", fields_.size()));
    }
    if (end == line.size()) return;
    start = end + 1;
  }
}

double TableReader::number(std::size_t column) const {
  std::string_view text = fields_[column];
  if (text.starts_with('+')) text.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size())
    refuse(fmt::format("\"{}\" in column {} is not a number", fields_[column], names_[column]));
  if (!std::isfinite(value)) refuse(fmt::format("{} in column {} is not finite", fields_[column], names_[column]));
  return value;
}

bool TableReader::next(Row& row) {
  if (!read_line()) return false;
  split_line();
  if (fields_.size() != names_.size())
    refuse(fmt::format("{} where the first line names {}", counted(fields_.size(), "field"),
                       counted(names_.size(), "column")));
  row.line = number_;
  row.text = line_;
  if (row.text.ends_with('\r')) row.text.remove_suffix(1);
  row.sequence = sequence_ == kAbsent ? std::string_view("1") : fields_[sequence_];
  row.taxel = 0;
  if (taxel_ != kAbsent) {
    const double taxel = number(taxel_);
    if (taxel < 0.0 || taxel > 1e6 || taxel != std::floor(taxel))
      refuse(fmt::format("taxel {} is not a whole number from 0 to 1000000", fields_[taxel_]));
    row.taxel = static_cast<int>(taxel);
  }
  if (input_ != kAbsent) row.input = number(input_);
  if (output_ != kAbsent) row.output = number(output_);
  row.step.reset();
  if (step_ != kAbsent) {
    const std::string_view text = fields_[step_];
    double step = 0.0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), step);
    if (error == std::errc() && end == text.data() + text.size() && std::isfinite(step)) row.step = step;
  }
  return true;
}

std::string table_text(const std::string& path) {
  return whole_file(path, {.most_bytes = kLargestTable, .or_pipe = true}, "TB-TABLE-OPEN", "check its name and rights");
}

std::vector<TableSeries> read_table(std::istream& stream, const std::string& file, const ColumnMap& map) {
  TableReader reader(stream, file, map, TableNeeds::kBoth);
  std::vector<TableSeries> series;
  std::vector<StepOrder> orders;
  std::map<std::pair<std::string, int>, std::size_t, std::less<>> places;
  std::size_t last = 0, rows = 0;
  for (TableReader::Row row; reader.next(row);) {
    if (++rows > kMostRows)
      throw AnalysisError(Cause::kUsage, "TB-TABLE-ROW", fmt::format("{}: more than {} rows", file, kMostRows),
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
      throw AnalysisError(Cause::kUsage, "TB-TABLE-STEP",
                          fmt::format("{}:{}: {} in sequence \"{}\"{}", file, row.line, wrong, row.sequence,
                                      reader.has_taxel() ? fmt::format(", taxel {}", row.taxel) : ""),
                          "rows stand in the order in which they were measured, each once; give the column another "
                          "name if it does not count the rows of a sequence");
    series[last].input.push_back(row.input);
    series[last].output.push_back(row.output);
  }
  if (series.empty())
    throw AnalysisError(Cause::kUsage, "TB-TABLE-EMPTY", fmt::format("{}: no row follows the line of names", file),
                        kFormat);
  return series;
}

std::vector<TableSeries> read_table(const std::string& path, const ColumnMap& map) {
  std::istringstream stream(table_text(path));
  return read_table(stream, path, map);
}

}  // namespace tactbench::analysis
