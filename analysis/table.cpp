#include "analysis/table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ios>
#include <limits>
#include <utility>

#include "analysis/counted.h"
#include "analysis/error.h"

namespace tactbench::analysis {

// Reads a line of at most kMaxLineBytes + 1 bytes, without its line end.
bool TableReader::next_line() {
  line_.clear();
  std::streambuf& bytes = *stream_->rdbuf();
  constexpr auto kEnd = std::streambuf::traits_type::eof();
  try {
    for (auto byte = bytes.sbumpc(); byte != kEnd; byte = bytes.sbumpc()) {
      const char c = std::streambuf::traits_type::to_char_type(byte);
      const bool second = skip_line_feed_ && c == '\n';
      skip_line_feed_ = c == '\r';  // the next row of a pipe may arrive much later
      if (second) continue;
      if (c == '\n' || c == '\r') return true;
      line_ += c;
      if (line_.size() > kMaxLineBytes) return true;
    }
  } catch (const std::ios_base::failure&) {
    throw AnalysisError("TB-TABLE-OPEN", fmt::format("{}: reading failed after line {}", file_, counted_),
                        "check the disk and the file");
  }
  return !line_.empty();
}

// The next line of the stream that may contain data.
bool TableReader::new_line() {
  while (next_line()) {
    ++counted_;
    if (names_.empty() && line_.starts_with("\xEF\xBB\xBF")) line_.erase(0, 3);  // also behind a head
    if (counted_ <= layout_.skip_lines) continue;
    if (line_.size() > kMaxLineBytes) refuse(counted_, fmt::format("a line of more than {} bytes", kMaxLineBytes));
    if (const auto nul = line_.find('\0'); nul != std::string::npos)
      refuse(counted_,
             fmt::format("byte {} is a NUL: the file is not UTF-8 text (UTF-16 has a NUL with each letter)", nul + 1));
    const std::string_view text = trimmed(line_);
    if (text.empty() || text.front() == '#' || text.front() == '%') continue;
    if (text.front() == ';' && !names_.empty() && separator_ != ';') continue;
    return true;
  }
  return false;
}

bool TableReader::read_line() {
  if (ahead_.empty()) {
    const bool read = new_line();
    number_ = counted_;
    return read;
  }
  number_ = ahead_.front().number;
  line_ = std::move(ahead_.front().text);
  ahead_.pop_front();
  return true;
}

void TableReader::refuse(std::size_t line, const std::string& what) const {
  throw AnalysisError("TB-TABLE-ROW", fmt::format("{}:{}: {}", file_, line, what),
                      needs_ == TableNeeds::kBoth
                          ? "correct or remove the line, or leave such rows out: --skip-bad-rows"
                          : "correct or remove the line");
}

double TableReader::number(std::size_t column) {
  double value = 0.0;
  if (const std::string wrong = numbers_.read(fields_.all[column], number_, value); !wrong.empty())
    refuse(number_, fmt::format("\"{}\" in column {} {}", fields_.all[column], names_[column], wrong));
  return value;
}

std::optional<double> TableReader::if_number(std::size_t column) const {
  double value = 0.0;
  if (column == kAbsent || column >= fields_.all.size() ||
      !NumberText(numbers_).read(fields_.all[column], number_, value).empty())
    return std::nullopt;
  return value;
}

bool TableReader::needed(std::size_t column) const {
  return column == input_ || column == sequence_ || column == taxel_ ||
         std::ranges::find(outputs_, column) != outputs_.end();
}

// There must be as many fields as columns. One field at the end is optional if it is never a number: if a number were
// missing, others could be in its place.
void TableReader::check_width() {
  const std::size_t fields = fields_.all.size(), columns = names_.size();
  bool fits = fields == columns;
  if (fields == columns + 1) fits = !is_number(fields_.all.back());
  const bool may_lack = !needed(columns - 1);
  if (fields + 1 == columns && may_lack && !number_at_end_) {
    fits = true;
    if (short_line_ == 0) short_line_ = number_;
  }
  if (fields == columns && may_lack && !number_at_end_ && is_number(fields_.all.back())) {
    fits = short_line_ == 0;
    number_at_end_ = fits;
  }
  if (fits) return;
  refuse(number_, short_line_ != 0 && fields == columns
                      ? fmt::format("{} where line {} has {}", counted(fields, "field"), short_line_, columns - 1)
                      : fmt::format("{} where {}{}", counted(fields, "field"),
                                    header_.empty() ? fmt::format("line {} has {}", first_row_, columns)
                                                    : fmt::format("the line of names has {}", columns),
                                    separator_ == ',' && fields == 2 * columns
                                        ? " (decimal commas need semicolons or tabs between the columns)"
                                        : ""));
}

void TableReader::read_row(Row& row) {
  if (const std::string wrong = fields_.split(line_, separator_); !wrong.empty()) refuse(number_, wrong);
  row.line = number_;
  row.text = line_;
  row.outputs.clear();
  row.bad.clear();
  try {
    read_outputs(row);
  } catch (const AnalysisError& error) {
    if (needs_ != TableNeeds::kOutput || fields_.all.size() > names_.size()) throw;
    row.text.append(names_.size() - fields_.all.size(), separator_);
    row.bad = error.what();
    row.outputs.clear();
    row.step = row.time = row.frame = std::nullopt;
  }
}

void TableReader::read_outputs(Row& row) {
  check_width();
  row.sequence = sequence_ == kAbsent ? "1" : fields_.all[sequence_];
  row.taxel = 0;
  if (taxel_ != kAbsent) {
    const double taxel = number(taxel_);
    if (taxel < 0.0 || taxel > 1e6 || taxel != std::floor(taxel))
      refuse(number_, fmt::format("taxel {} is not a whole number from 0 to 1000000", fields_.all[taxel_]));
    row.taxel = static_cast<int>(taxel);
  }
  if (input_ != kAbsent) row.input = number(input_);
  for (const std::size_t column : outputs_) {
    try {
      row.outputs.push_back(number(column));
    } catch (const AnalysisError& error) {
      if (needs_ != TableNeeds::kOutput) throw;
      row.outputs.push_back(std::numeric_limits<double>::quiet_NaN());
      if (row.bad.empty()) row.bad = error.what();
    }
  }
  row.step = if_number(step_);
  row.time = if_number(time_);
  if (!row.time && time_ < fields_.all.size()) row.time = clock_seconds(fields_.all[time_]);
  row.frame = if_number(frame_);
}

bool TableReader::next(Row& row) {
  if (next_)
    row = *std::exchange(next_, std::nullopt);
  else if (!next_row(row))
    return false;
  std::size_t scans = 1;
  for (Row scan; row.frame && next_row(scan);) {
    if (scan.frame != row.frame || scan.sequence != row.sequence) {
      next_ = std::move(scan);
      break;
    }
    ++scans;
    for (std::size_t k = 0; k < row.outputs.size(); ++k)
      row.outputs[k] += (scan.outputs[k] - row.outputs[k]) / static_cast<double>(scans);
  }
  scans_ = std::max(scans_, scans);
  return true;
}

// The next row that can be read and is not void.
bool TableReader::next_row(Row& row) {
  while (read_line()) {
    try {
      read_row(row);
      ++rows_;
      if (if_number(void_).value_or(0.0) == 0.0) return true;
      ++voids_;
    } catch (const AnalysisError& error) {
      if (!layout_.skip_bad_rows) throw;
      skip(error.what());
    }
  }
  return false;
}

void TableReader::skip(const std::string& reason) {
  if (++skipped_.count <= SkippedRows::kNamed) skipped_.first.push_back(reason);
  if (skipped_.count > rows_ + kMaxSkippedAhead) check_skipped();
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
  if (passed_ > 0 || header_.empty())
    lines.push_back(header_.empty()
                        ? fmt::format("the columns have no names; samples begin in line {}", first_row_)
                        : fmt::format("line {} names the columns; the lines above it are skipped", head_number_));
  if (separator_ != ',') lines.push_back(fmt::format("columns are separated by {}", separator_name(separator_)));
  if (numbers_.comma())
    lines.push_back(
        fmt::format("numbers have decimal commas (line {}: {})", numbers_.comma_line(), numbers_.comma_text()));
  if (scans_ > 1) lines.push_back(fmt::format("the {} scans of a frame are averaged", scans_));
  if (voids_ > 0) lines.push_back(counted(voids_, "void row") + " left out");
  if (units_number_ == 0) return lines;
  std::string units;
  for (std::size_t i = 0; i < 2; ++i)
    if (!units_[i].empty())
      units += fmt::format("{}{} in {}", units.empty() ? "" : ", ", i == 0 ? "input" : "output", units_[i]);
  lines.push_back(fmt::format("line {} holds units, not samples{}{}", units_number_, units.empty() ? "" : ": ", units));
  return lines;
}

}  // namespace tactbench::analysis
