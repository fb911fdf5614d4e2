#include "analysis/table.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <utility>

#include "analysis/error.h"

namespace tactbench::analysis {
namespace {

constexpr const char* kFormat =
    "the first line names the columns, e.g. sequence,step,input,output; --map input=COL,output=COL says which is which";

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\r\"");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r\"") - first + 1);
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

}  // namespace

ColumnMap column_map_from(const std::string& text) {
  ColumnMap map;
  std::vector<std::string_view> pairs;
  if (!text.empty()) split(text, ',', pairs);
  for (const std::string_view pair : pairs) {
    const auto equals = pair.find('=');
    const std::string role(trimmed(pair.substr(0, equals)));
    if (equals == std::string_view::npos || equals + 1 == pair.size() || !map.columns.contains(role))
      throw AnalysisError("TB-TABLE-MAP", fmt::format("--map: \"{}\" does not say which column is what", pair),
                          "write role=COLUMN with the roles input, output, sequence, taxel; COLUMN is a name or a "
                          "number from 1");
    map.columns[role] = trimmed(pair.substr(equals + 1));
  }
  return map;
}

TableReader::TableReader(std::istream& stream, std::string file, const ColumnMap& map, TableNeeds needs)
    : stream_(&stream), file_(std::move(file)) {
  if (!read_line()) throw AnalysisError("TB-TABLE-EMPTY", fmt::format("{}: the table is empty", file_), kFormat);
  if (line_.starts_with("\xEF\xBB\xBF")) line_.erase(0, 3);  // a byte order mark
  header_ = line_;
  if (!header_.empty() && header_.back() == '\r') header_.pop_back();
  for (const char candidate : {',', ';', '\t'})
    if (std::ranges::count(line_, candidate) > std::ranges::count(line_, separator_)) separator_ = candidate;
  split(line_, separator_, fields_);
  names_.assign(fields_.begin(), fields_.end());
  input_ = needs == TableNeeds::kOutput ? kAbsent : column(map, "input", true);
  output_ = needs == TableNeeds::kInput ? kAbsent : column(map, "output", true);
  sequence_ = column(map, "sequence", map.columns.at("sequence") != "sequence");
  taxel_ = column(map, "taxel", map.columns.at("taxel") != "taxel");
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
  throw AnalysisError("TB-TABLE-COLUMN",
                      fmt::format("{}:{}: no column \"{}\" for the {}; the line names {}", file_, number_, wanted, role,
                                  fmt::join(names_, ", ")),
                      kFormat);
}

bool TableReader::read_line() {
  while (std::getline(*stream_, line_)) {
    ++number_;
    const std::string_view text = trimmed(line_);
    if (!text.empty() && text.front() != '#') return true;
  }
  if (stream_->bad())
    throw AnalysisError("TB-TABLE-OPEN", fmt::format("{}: reading failed after line {}", file_, number_),
                        "check the disk and the file");
  return false;
}

void TableReader::refuse(const std::string& what) const {
  throw AnalysisError("TB-TABLE-ROW", fmt::format("{}:{}: {}", file_, number_, what), "mend or remove the line");
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
  split(line_, separator_, fields_);
  if (fields_.size() != names_.size())
    refuse(fmt::format("{} fields where the first line names {} columns", fields_.size(), names_.size()));
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
  return true;
}

std::vector<TableSeries> read_table(const std::string& path, const ColumnMap& map) {
  std::ifstream file(path);
  if (!file)
    throw AnalysisError("TB-TABLE-OPEN", fmt::format("{}: the file cannot be read", path), "check its name and rights");
  TableReader reader(file, path, map, TableNeeds::kBoth);
  std::vector<TableSeries> series;
  std::map<std::pair<std::string, int>, std::size_t, std::less<>> places;
  TableSeries* last = nullptr;
  for (TableReader::Row row; reader.next(row);) {
    if (last == nullptr || last->taxel != row.taxel || last->sequence != row.sequence) {
      const auto [place, fresh] = places.try_emplace({std::string(row.sequence), row.taxel}, series.size());
      if (fresh) series.push_back({std::string(row.sequence), row.taxel, {}, {}});
      last = &series[place->second];
    }
    last->input.push_back(row.input);
    last->output.push_back(row.output);
  }
  if (series.empty())
    throw AnalysisError("TB-TABLE-EMPTY", fmt::format("{}: no row follows the line of names", path), kFormat);
  return series;
}

}  // namespace tactbench::analysis
