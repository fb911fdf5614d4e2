#include "analysis/table.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

#include "analysis/counted.h"
#include "analysis/error.h"
#include "db/utf8.h"

namespace tactbench::analysis {
namespace {

constexpr const char* kFormat =
    "the first line names the columns, e.g. sequence,step,input,output; --map input=COL,output=COL names the columns";

// At commas outside double quotes.
std::vector<std::string_view> pairs_of(std::string_view text) {
  std::vector<std::string_view> pairs;
  bool quoted = false;
  std::size_t start = 0;
  for (std::size_t at = 0; at <= text.size() && !text.empty(); ++at) {
    if (at < text.size() && text[at] == '"') quoted = !quoted;
    if (at < text.size() && (text[at] != ',' || quoted)) continue;
    pairs.push_back(trimmed(text.substr(start, at - start)));
    start = at + 1;
  }
  return pairs;
}

bool is_number(std::string_view text) {
  double value = 0.0;
  const std::string wrong = NumberText().read(text, 1, value);
  return wrong.empty() || wrong == NumberText::kNotFinite;
}

std::size_t words_of(std::string_view line) {
  Fields fields;
  return fields.split(line, ' ').empty() ? fields.all.size() : 0;
}

// Of a word of a line of units: without brackets; empty where it is no text in UTF-8.
std::string unit_of(std::string_view word) {
  if (word.size() > 1 && ((word.front() == '[' && word.back() == ']') || (word.front() == '(' && word.back() == ')')))
    word = trimmed(word.substr(1, word.size() - 2));
  for (std::string_view rest = word; !rest.empty();) {
    const db::CodePoint first = db::decode_utf8(rest);
    if (!first.valid || first.value < 0x20) return {};
    rest.remove_prefix(first.bytes);
  }
  return std::string(word);
}

}  // namespace

ColumnMap column_map_from(const std::string& text) {
  ColumnMap map;
  for (const std::string_view pair : pairs_of(text)) {
    const auto equals = pair.find('=');
    const std::string role(trimmed(pair.substr(0, equals)));
    std::string_view name = equals == std::string_view::npos ? std::string_view() : trimmed(pair.substr(equals + 1));
    if (name.size() > 1 && name.front() == '"' && name.back() == '"') name = name.substr(1, name.size() - 2);
    if (name.empty() || !map.columns.contains(role))
      throw AnalysisError(
          "TB-TABLE-MAP", fmt::format("--map: \"{}\" does not name role and column", pair),
          "write role=COLUMN with the roles input, output, sequence, taxel; COLUMN is a number from 1 or "
          "a name, in double quotes where it holds a comma");
    map.columns[role] = name;
  }
  return map;
}

TableReader::TableReader(std::istream& stream, std::string file, const ColumnMap& map, TableNeeds needs,
                         bool skip_bad_rows)
    : stream_(&stream), file_(std::move(file)), skip_bad_rows_(skip_bad_rows) {
  if (!read_line()) throw AnalysisError("TB-TABLE-EMPTY", fmt::format("{}: the table is empty", file_), kFormat);
  header_ = line_.starts_with("\xEF\xBB\xBF") ? line_.substr(3) : line_;  // without a byte order mark
  if (header_.ends_with('\r')) header_.pop_back();
  const std::size_t number = number_;
  ahead_ = read_line();
  separator_ = separator_of(header_);
  if (separator_ == ' ' && ahead_ && words_of(line_) != words_of(header_))
    separator_ = ',';  // one name of several words
  read_names(number, map, needs);
  read_units();
}

void TableReader::read_names(std::size_t line, const ColumnMap& map, TableNeeds needs) {
  if (const std::string wrong = fields_.split(header_, separator_); !wrong.empty()) refuse(line, wrong);
  names_.assign(fields_.all.begin(), fields_.all.end());
  if (std::ranges::all_of(names_, is_number))
    throw AnalysisError(
        "TB-TABLE-COLUMN",
        fmt::format("{}:{}: numbers in place of the names of the columns: {}", file_, line, fmt::join(names_, ", ")),
        kFormat);
  const auto column_of = [&](const char* role, bool needed) {
    return column(line, map.columns.at(role), role, needed);
  };
  input_ = needs == TableNeeds::kOutput ? kAbsent : column_of("input", true);
  output_ = needs == TableNeeds::kInput ? kAbsent : column_of("output", true);
  sequence_ = column_of("sequence", map.columns.at("sequence") != "sequence");
  taxel_ = column_of("taxel", map.columns.at("taxel") != "taxel");
  const auto at = [&](const char* name) {
    const auto found = std::ranges::find(names_, name);
    return found == names_.end() ? kAbsent : static_cast<std::size_t>(found - names_.begin());
  };
  step_ = at("step");
  time_ = at("time_s");
}

// The line after the names is one of units when it has as many fields, no number, and short words in those needed.
void TableReader::read_units() {
  constexpr std::size_t kLongestUnit = 24;  // bytes
  if (!ahead_ || !fields_.split(line_, separator_).empty() || fields_.all.size() != names_.size()) return;
  if (std::ranges::any_of(fields_.all, is_number)) return;
  const std::array<std::size_t, 2> roles = {input_, output_};
  for (const std::size_t role : roles) {
    if (role == kAbsent) continue;
    const std::string_view word = fields_.all[role];
    if (word.empty() || word.size() > kLongestUnit || word == "NA" || word == "N/A" || word == "na" || word == "n/a")
      return;
  }
  for (std::size_t i = 0; i < roles.size(); ++i)
    if (roles[i] != kAbsent) units_[i] = unit_of(fields_.all[roles[i]]);
  units_line_ = line_;
  if (units_line_.ends_with('\r')) units_line_.pop_back();
  units_number_ = number_;
  ahead_ = false;
}

std::size_t TableReader::column(std::size_t line, const std::string& wanted, const char* role, bool needed) const {
  const auto found = std::ranges::find(names_, wanted);
  if (found != names_.end()) return static_cast<std::size_t>(found - names_.begin());
  std::size_t number = 0;
  const auto [end, error] = std::from_chars(wanted.data(), wanted.data() + wanted.size(), number);
  if (error == std::errc() && end == wanted.data() + wanted.size() && number >= 1 && number <= names_.size())
    return number - 1;
  if (!needed) return kAbsent;
  throw AnalysisError("TB-TABLE-COLUMN",
                      fmt::format("{}:{}: no column \"{}\" for the {}; the line names {}", file_, line, wanted, role,
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
    if (line_.size() > kLongestLine) refuse(number_, fmt::format("a line of more than {} bytes", kLongestLine));
    if (const auto nul = line_.find('\0'); nul != std::string::npos)
      refuse(number_,
             fmt::format("byte {} is a NUL: this is no text in UTF-8 (UTF-16 has one at each letter)", nul + 1));
    const std::string_view text = trimmed(line_);
    if (!text.empty() && text.front() != '#') return true;
  }
  if (stream_->bad())
    throw AnalysisError("TB-TABLE-OPEN", fmt::format("{}: reading failed after line {}", file_, number_),
                        "check the disk and the file");
  return false;
}

void TableReader::refuse(std::size_t line, const std::string& what) const {
  throw AnalysisError("TB-TABLE-ROW", fmt::format("{}:{}: {}", file_, line, what),
                      "correct or remove the line; fit and import leave such rows out with --skip-bad-rows");
}

void TableReader::split_line() {
  if (const std::string wrong = fields_.split(line_, separator_); !wrong.empty()) refuse(number_, wrong);
}

double TableReader::number(std::size_t column) {
  double value = 0.0;
  if (const std::string wrong = numbers_.read(fields_.all[column], number_, value); !wrong.empty())
    refuse(number_, fmt::format("\"{}\" in column {} {}", fields_.all[column], names_[column], wrong));
  return value;
}

void TableReader::read_row(Row& row) {
  split_line();
  if (fields_.all.size() != names_.size())
    refuse(number_, fmt::format("{} where the first line names {}{}", counted(fields_.all.size(), "field"),
                                counted(names_.size(), "column"),
                                separator_ == ',' && fields_.all.size() == 2 * names_.size()
                                    ? " (decimal commas need semicolons or tabs between the columns)"
                                    : ""));
  row.line = number_;
  row.text = line_;
  if (row.text.ends_with('\r')) row.text.remove_suffix(1);
  row.sequence = sequence_ == kAbsent ? std::string_view("1") : fields_.all[sequence_];
  row.taxel = 0;
  if (taxel_ != kAbsent) {
    const double taxel = number(taxel_);
    if (taxel < 0.0 || taxel > 1e6 || taxel != std::floor(taxel))
      refuse(number_, fmt::format("taxel {} is not a whole number from 0 to 1000000", fields_.all[taxel_]));
    row.taxel = static_cast<int>(taxel);
  }
  if (input_ != kAbsent) row.input = number(input_);
  if (output_ != kAbsent) row.output = number(output_);
  const auto if_number = [&](std::size_t column) -> std::optional<double> {
    double value = 0.0;
    if (column == kAbsent || !NumberText(numbers_).read(fields_.all[column], number_, value).empty())
      return std::nullopt;
    return value;
  };
  row.step = if_number(step_);
  row.time_s = if_number(time_);
}

bool TableReader::next(Row& row) {
  for (;;) {
    if (!ahead_ && !read_line()) return false;
    ahead_ = false;
    try {
      read_row(row);
      ++rows_;
      return true;
    } catch (const AnalysisError& error) {
      if (!skip_bad_rows_) throw;
      skip(error.what());
    }
  }
}

void TableReader::skip(const std::string& reason) {
  if (++skipped_.count <= SkippedRows::kNamed) skipped_.first.push_back(reason);
  if (skipped_.count > rows_ + kMostSkippedAhead) check_skipped();
}

void TableReader::check_skipped() const {
  if (skipped_.count <= rows_) return;
  throw AnalysisError("TB-TABLE-SKIPPED",
                      fmt::format("{}: {} of {} cannot be read, which is more than half; the first is {}", file_,
                                  skipped_.count, counted(skipped_.count + rows_, "row"), skipped_.first.front()),
                      "check separators, decimal commas and the assignment of columns (--map)");
}

std::vector<std::string> TableReader::assumed() const {
  std::vector<std::string> lines;
  if (separator_ != ',') lines.push_back(fmt::format("columns are separated by {}", separator_word(separator_)));
  if (numbers_.comma())
    lines.push_back(
        fmt::format("numbers have decimal commas (line {}: {})", numbers_.comma_line(), numbers_.comma_text()));
  if (units_number_ == 0) return lines;
  std::string units;
  for (std::size_t i = 0; i < 2; ++i)
    if (!units_[i].empty())
      units += fmt::format("{}{} in {}", units.empty() ? "" : ", ", i == 0 ? "input" : "output", units_[i]);
  lines.push_back(fmt::format("line {} holds units, not samples{}{}", units_number_, units.empty() ? "" : ": ", units));
  return lines;
}

}  // namespace tactbench::analysis
