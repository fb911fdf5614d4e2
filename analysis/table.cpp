#include "analysis/table.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <ios>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <sstream>
#include <utility>

#include "analysis/counted.h"
#include "analysis/error.h"
#include "analysis/read_whole_file.h"
#include "analysis/workers.h"

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

// A whole table: distributes its rows to the histories to which they belong.

namespace {

constexpr std::size_t kLargestTable = 1'000'000'000;  // bytes
constexpr std::size_t kMostSamples = 20'000'000;
constexpr std::size_t kCountedRows = 4096;  // rows between two updates of the progress

// Bytes that can still be read; 0: not known, as for a pipe.
std::size_t bytes_left(std::istream& stream) {
  const auto here = stream.tellg();
  stream.seekg(0, std::ios::end);
  const auto end = stream.tellg();
  stream.clear();
  stream.seekg(here);
  return here < 0 || end < here ? 0 : static_cast<std::size_t>(end - here);
}

// Checks the numbers of a column `step`, row by row, for one series.
class StepOrder {
 public:
  // Why `step` cannot follow the previous one; empty if it can. Steps rise; a fall to the first one starts the next
  // repeat.
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

// Order checks of the rows of one series.
struct RowOrder {
  StepOrder step;
  TimeOrder time;
};

// The middle 90 % of some values.
struct Middle {
  double low = 0.0, high = 0.0;
  explicit Middle(std::vector<double> values) {
    constexpr double kOut = 0.05;  // at each end
    std::ranges::sort(values);
    const double last = static_cast<double>(values.size() - 1);
    low = values[static_cast<std::size_t>(std::ceil(kOut * last))];
    high = values[static_cast<std::size_t>(std::floor((1.0 - kOut) * last))];
  }
  [[nodiscard]] double span() const { return high - low; }
};

// Adds up to three samples that are more than kWild spans beyond the middle and beyond their neighbours, while the
// other value (with middle `others`) does not change: otherwise both may be a short press.
void add_wild(const std::vector<double>& values, const std::vector<double>& other, bool input,
              std::vector<ImplausibleSample>& wild) {
  constexpr double kWild = 3.0;
  constexpr std::size_t kLongest = 3;
  const Middle middle(values), others(other);
  const double span = middle.span(), far = kWild * span;
  const auto beyond = [&](std::size_t i) { return values[i] > middle.high + far || values[i] < middle.low - far; };
  const auto rests = [&](std::size_t first, std::size_t end) {
    const std::size_t from = first > kLongest ? first - kLongest - 1 : 0;
    const auto [least, most] =
        std::ranges::minmax(std::span(other).subspan(from, std::min(end + kLongest + 1, other.size()) - from));
    return most - least <= kWild * others.span();
  };
  for (std::size_t first = 0, end = 0; span > 0.0 && first < values.size(); first = end) {
    for (end = first; end < values.size() && beyond(end);) ++end;
    if (end == first) {
      ++end;
      continue;
    }
    if (end - first > kLongest || !rests(first, end)) continue;
    for (std::size_t i = first; i < end; ++i) {
      double off = HUGE_VAL;
      if (first > 0) off = std::abs(values[i] - values[first - 1]);
      if (end < values.size()) off = std::min(off, std::abs(values[i] - values[end]));
      if (off > far) wild.push_back({i, input, values[i], off / span});
    }
  }
}

// Leaves out the rows of wild samples, all columns of them.
void leave_out_wild(const std::string& file, std::size_t outputs, Table& table) {
  for (std::size_t first = 0; first < table.series.size(); first += outputs) {
    std::map<std::size_t, std::string> out;
    for (std::size_t k = first; k < first + outputs; ++k)
      for (const ImplausibleSample& wild : implausible_samples(table.series[k]))
        out.try_emplace(wild.place, fmt::format("{}, {}", file, implausible_text(table.series[k], wild)));
    for (const auto& [row, text] : out)
      if (++table.skipped.count <= SkippedRows::kNamed) table.skipped.first.push_back(text);
    for (auto row = out.rbegin(); row != out.rend(); ++row) {
      const auto erase = [&](auto& values) {
        if (!values.empty()) values.erase(values.begin() + static_cast<std::ptrdiff_t>(row->first));
      };
      for (std::size_t k = first; k < first + outputs; ++k) {
        TableSeries& own = table.series[k];
        erase(own.input);
        erase(own.output);
        erase(own.time_s);
        erase(own.lines);
      }
    }
  }
}

}  // namespace

std::vector<ImplausibleSample> implausible_samples(const TableSeries& series) {
  constexpr std::size_t kFewest = 20;
  std::vector<ImplausibleSample> wild;
  if (series.input.size() < kFewest) return wild;
  add_wild(series.output, series.input, false, wild);
  add_wild(series.input, series.output, true, wild);
  return wild;
}

std::string implausible_text(const TableSeries& series, const ImplausibleSample& wild) {
  const std::string place = series.lines.empty()
                                ? fmt::format("sample {} of sequence \"{}\"", wild.place + 1, series.sequence)
                                : fmt::format("line {}", series.lines[wild.place]);
  return fmt::format("{}: the {} {:.10g} is {:.6g} spans from its neighbours", place, wild.input ? "input" : "output",
                     wild.value, std::round(wild.spans));
}

std::string TimeOrder::see(double& time) {
  // 2^32 ticks, of a second, millisecond or microsecond; 2^16; midnight.
  constexpr std::array kWraps = {4294967296.0, 4294967.296, 4294.967296, 65536.0, 86400.0};
  constexpr double kSteps = 10.0;  // after a wrap the time continues, by at most so many of the longest steps
  const double read = time;
  time += offset_;
  if (last_ && time < *last_) {
    const double back = *last_ - time;
    for (const double wrap : kWraps) {
      if (wrap < back || wrap - back > kSteps * longest_) continue;
      offset_ += wrap;
      time += wrap;
      ++wraps_;
      break;
    }
  }
  if (last_ && time < *last_)
    return fmt::format("the time goes back by {:g}, from {:.10g} to {:.10g}", *last_ - time, *last_ - offset_, read);
  if (last_) longest_ = std::max(longest_, time - *last_);
  last_ = time;
  return {};
}

std::string table_text(const std::string& path) {
  return read_whole_file(path, {.max_bytes = kLargestTable, .or_pipe = true}, "TB-TABLE-OPEN",
                         "check its name and permissions");
}

Table read_table(std::istream& stream, const std::string& file, const TableLayout& layout) {
  Work read(bytes_left(stream));
  TableReader reader(stream, file, layout, TableNeeds::kBoth);
  Table table;
  std::vector<TableSeries>& series = table.series;
  std::vector<RowOrder> orders;
  std::map<std::pair<std::string, int>, std::size_t, std::less<>> places;  // of the first output's series
  const std::size_t outputs = reader.outputs();
  std::size_t last = 0, rows = 0, wraps = 0;
  std::streamoff at = 0;
  TableReader::Row row;
  const auto refuse = [&](const char* id, const std::string& wrong, const char* remedy) {
    const std::string taxel = reader.has_taxel() ? fmt::format(", taxel {}", row.taxel) : "";
    throw AnalysisError(id, fmt::format("{}:{}: {} in sequence \"{}\"{}", file, row.line, wrong, row.sequence, taxel),
                        remedy);
  };
  while (reader.next(row)) {
    if (rows % kCountedRows == 0 && stream.good()) {
      const std::streamoff now = stream.tellg();
      read.add(static_cast<std::size_t>(now - at));
      at = now;
    }
    if (++rows * outputs > kMostSamples)
      throw AnalysisError("TB-TABLE-ROW", fmt::format("{}: more than {} samples", file, kMostSamples),
                          "use only the sequences that are to be fitted, or every second row");
    if (series.empty() || series[last].taxel != row.taxel || series[last].sequence != row.sequence) {
      const auto [known, fresh] = places.try_emplace({row.sequence, row.taxel}, series.size());
      for (std::size_t k = 0; fresh && k < outputs; ++k)
        series.push_back({row.sequence, row.taxel + static_cast<int>(k), {}, {}, {}, {}});
      orders.resize(series.size());
      last = known->second;
    }
    RowOrder& order = orders[last];
    if (const std::string wrong = row.step ? order.step.see(*row.step) : std::string(); !wrong.empty())
      refuse("TB-TABLE-STEP", wrong,
             "rows must be in the order in which they were measured, each once; rename the column if it does not count "
             "the rows of a sequence");
    if (const std::string wrong = row.time ? order.time.see(*row.time) : std::string(); !wrong.empty())
      refuse("TB-TABLE-TIME", wrong,
             "remove repeated rows and put the others in the order in which they were measured; "
             "name recordings that follow each other in a column sequence; --map time=none if the column "
             "holds no times");
    for (std::size_t k = 0; k < outputs; ++k) {
      series[last + k].input.push_back(row.input);
      series[last + k].output.push_back(row.outputs[k]);
      series[last + k].lines.push_back(static_cast<std::uint32_t>(row.line));
      if (row.time) series[last + k].time_s.push_back(*row.time);
    }
  }
  for (const RowOrder& order : orders) wraps += order.time.wraps();
  for (TableSeries& own : series)
    if (!reader.has_seconds() || own.time_s.size() != own.input.size()) own.time_s.clear();
  reader.check_skipped();
  if (series.empty())
    throw AnalysisError("TB-TABLE-EMPTY", fmt::format("{}: no row follows the line of names", file),
                        "write a row for each sample below the names");
  table.input_unit = reader.input_unit();
  table.output_unit = reader.output_unit();
  table.assumed = reader.assumed();
  if (outputs > 1) table.assumed.push_back(fmt::format("{} output columns are taxels 0 to {}", outputs, outputs - 1));
  if (wraps > 0)
    table.assumed.push_back(
        fmt::format("the times wrap {}, as a counter of 2^32 or 2^16 ticks or a clock at midnight does: unwrapped",
                    counted(wraps, "time")));
  table.skipped = reader.skipped();
  if (layout.skip_bad_rows) leave_out_wild(file, outputs, table);
  return table;
}

Table read_table(const std::string& path, const TableLayout& layout) {
  std::istringstream stream(table_text(path));
  return read_table(stream, path, layout);
}

}  // namespace tactbench::analysis
