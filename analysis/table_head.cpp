// The lines above the rows of a table: finds the line of names, the line of units, and the role of each column.
#include "analysis/table_head.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <cmath>
#include <system_error>
#include <utility>

#include "analysis/error.h"
#include "analysis/table.h"
#include "db/remarks.h"

namespace tactbench::analysis {
namespace {

constexpr const char* kFormat =
    "name the columns in the first line, e.g. sequence,step,input,output, or assign them: --map input=COL,output=COL "
    "(for one column per taxel: output=2-17), by number if no line names them (--no-header)";

// Splits at each `mark` outside double quotes.
std::vector<std::string_view> parts_of(std::string_view text, char mark = '+') {
  std::vector<std::string_view> parts;
  bool quoted = false;
  std::size_t start = 0;
  for (std::size_t at = 0; at <= text.size() && !text.empty(); ++at) {
    if (at < text.size() && text[at] == '"') quoted = !quoted;
    if (at < text.size() && (text[at] != mark || quoted)) continue;
    parts.push_back(trimmed(text.substr(start, at - start)));
    start = at + 1;
  }
  return parts;
}

// The unit in a word of a line of units, without brackets; empty if it is not UTF-8 text.
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

// "3" or "3-5", counted from 1 -> places from 0; empty for other words.
std::vector<std::size_t> places_of(std::string_view text) {
  std::size_t first = 0;
  const char* const end = text.data() + text.size();
  auto [at, error] = std::from_chars(text.data(), end, first);
  std::size_t last = first;
  if (error == std::errc() && at != end && *at == '-') {
    const auto second = std::from_chars(at + 1, end, last);
    at = second.ptr;
    error = second.ec;
  }
  constexpr std::size_t kMostColumns = 100'000;
  std::vector<std::size_t> places;
  if (error != std::errc() || at != end || first == 0 || last > kMostColumns) return places;
  for (std::size_t i = first; i <= last; ++i) places.push_back(i - 1);
  return places;
}

bool matches(std::string_view name, std::string_view pattern) {
  const auto star = pattern.find('*');
  return star != std::string_view::npos && name.size() + 1 >= pattern.size() &&
         name.starts_with(pattern.substr(0, star)) && name.ends_with(pattern.substr(star + 1));
}

// The unit of a column of times, as in "Time (s)" or "time_ms": empty if it has none; none if it is not a column of
// times.
std::optional<std::string> time_unit(std::string_view name) {
  std::string word;
  for (const char c : name)
    if (std::string_view(" _()[]").find(c) == std::string_view::npos)
      word += static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
  for (const std::string_view begin : {"datetime", "timestamp", "time", "elapsed", "ticks", "millis", "micros"}) {
    if (!word.starts_with(begin)) continue;
    word.erase(0, begin.size());
    constexpr std::array<std::string_view, 10> kUnits = {"",   "s",         "sec", "seconds", "ms",
                                                         "us", "\xC2\xB5s", "ns",  "ticks",   "msec"};
    if (std::ranges::find(kUnits, word) == kUnits.end()) return std::nullopt;
    return word.starts_with("sec") ? "s" : word;
  }
  return std::nullopt;
}

std::string listed(const std::vector<std::string>& names) {
  constexpr std::size_t kNamed = 20;
  const std::size_t shown = std::min(names.size(), kNamed);
  return fmt::format("{}{}", fmt::join(names.begin(), names.begin() + static_cast<std::ptrdiff_t>(shown), ", "),
                     names.size() > shown ? fmt::format(" and {} more", names.size() - shown) : "");
}

}  // namespace

TableLayout table_layout(const std::string& map) {
  TableLayout layout;
  std::vector<std::string> stated;
  const auto refuse = [](const std::string& what) {
    throw AnalysisError("TB-TABLE-MAP", "--map: " + what,
                        "write role=COLUMN with the roles input, output, sequence, taxel, time, each once; COLUMN is a "
                        "number from 1 or a name, in double quotes if it contains a comma; several outputs, one per "
                        "taxel, are output=3-18, output=s* or output=s0+s1");
  };
  for (const std::string_view pair : parts_of(map, ',')) {
    const auto equals = pair.find('=');
    const std::string role(trimmed(pair.substr(0, equals)));
    std::string_view name = equals == std::string_view::npos ? std::string_view() : trimmed(pair.substr(equals + 1));
    if (name.size() > 1 && name.front() == '"' && name.back() == '"') name = name.substr(1, name.size() - 2);
    if (name.empty() || !layout.columns.contains(role))
      refuse(fmt::format("\"{}\" does not name role and column", pair));
    if (std::ranges::find(stated, role) != stated.end()) refuse(fmt::format("{} is named twice", role));
    stated.push_back(role);
    layout.columns[role] = name;
  }
  return layout;
}

TableReader::TableReader(std::istream& stream, std::string file, TableLayout layout, TableNeeds needs)
    : stream_(&stream), file_(std::move(file)), layout_(std::move(layout)), needs_(needs) {
  std::vector<std::string> wanted;
  std::vector<std::size_t> numbered;
  for (const auto& [role, name] : layout_.columns) {
    if (role == (needs == TableNeeds::kInput ? "output" : needs == TableNeeds::kOutput ? "input" : "")) continue;
    if (role != "input" && role != "output" && !stated(role.c_str())) continue;
    bool named = false;
    for (const std::string_view part : parts_of(name)) {
      const std::vector<std::size_t> places = places_of(part);
      named = named || places.empty();
      if (role == "input" || role == "output") numbered.insert(numbered.end(), places.begin(), places.end());
    }
    if (named && name != "none") wanted.push_back(name);
  }
  if (!look()) throw AnalysisError("TB-TABLE-EMPTY", fmt::format("{}: the table is empty", file_), kFormat);
  if (wanted.empty())
    find_first_row(numbered);
  else
    find_names(wanted);
  set_columns(needs);
  read_units();
}

bool TableReader::stated(const char* role) const { return layout_.columns.at(role) != TableLayout().columns.at(role); }

// Reads one more line into ahead_; false if it cannot be a line of names or samples.
bool TableReader::look() {
  constexpr std::string_view kEnd = "***End_of_Header***";
  if (!new_line()) return false;
  if (counted_ == 1 && line_.starts_with("LabVIEW Measurement")) labview_ = true;
  if (labview_ && ahead_.empty() && (counted_ == 1 || line_.starts_with("Channels"))) {
    while (!line_.starts_with(kEnd)) {
      ++passed_;
      if (!new_line()) return false;
    }
    ++passed_;
    return look();
  }
  std::string_view text = line_;
  if (text.starts_with('"') && text.ends_with('"')) text = text.substr(1, text.size() - 2);
  if (ahead_.empty() && separator_ == 0 && (text.starts_with("sep=") || text.starts_with("SEP=")) &&
      text.size() <= std::string_view("sep=;").size()) {
    separator_ = text.size() > 4 ? text[4] : '\t';
    ++passed_;
    return look();
  }
  ahead_.push_back({counted_, line_});
  return true;
}

// Empty if the line cannot be split.
std::vector<std::string> TableReader::split(const std::string& line, char separator) const {
  Fields fields;
  return fields.split(line, separator).empty() ? std::vector<std::string>(fields.all.begin(), fields.all.end())
                                               : std::vector<std::string>();
}

// The separator that gives numbers in `columns` (empty: in all columns). Blanks are tried before commas, which may be
// decimal commas.
std::optional<char> TableReader::separator_of_row(const std::string& line,
                                                  const std::vector<std::size_t>& columns) const {
  for (const char separator : {separator_, '\t', ';', ' ', ','}) {
    if (separator == 0 || (separator_ != 0 && separator != separator_)) continue;
    if (separator != ',' && trimmed(line).find(separator) == std::string_view::npos) continue;
    const std::vector<std::string> all = split(line, separator);
    const auto is_at = [&](std::size_t column) { return column < all.size() && is_number(all[column]); };
    const auto comma_at_end = [](const std::string& field) { return field.starts_with(',') || field.ends_with(','); };
    if (separator == ' ' && std::ranges::any_of(all, comma_at_end)) continue;
    if (!all.empty() && (columns.empty() ? std::ranges::all_of(all, is_number) : std::ranges::all_of(columns, is_at)))
      return separator;
  }
  return std::nullopt;
}

void TableReader::refuse_names(const std::string& what, const std::string& remedy) const {
  throw AnalysisError("TB-TABLE-COLUMN", fmt::format("{}:{}: {}", file_, head_number_, what), remedy);
}

// The first line that contains all names, before the first line of numbers only.
void TableReader::find_names(const std::vector<std::string>& wanted) {
  if (layout_.no_header) {
    head_number_ = 1;
    refuse_names(fmt::format("--no-header is given, but column \"{}\" is requested by name", wanted.front()), kFormat);
  }
  do {
    const std::string& line = ahead_.back().text;
    const char likely = separator_ != 0 ? separator_ : separator_of(line);
    // A name of several words is one name if it was requested like that.
    for (const char separator : {likely == ' ' ? ',' : likely, likely}) {
      const std::vector<std::string> names = split(line, separator);
      const auto is_here = [&](const std::string& name) { return std::ranges::find(names, name) != names.end(); };
      const auto holds = [&](const std::string& name) {
        if (is_here(name) || (name == "input" && !stated("input") && is_here("reference_psi")) ||
            (name == "output" && !stated("output") && is_here("volts_r0_c0")))
          return true;
        return std::ranges::all_of(parts_of(name), [&](std::string_view part) {
          return !places_of(part).empty() ||
                 std::ranges::any_of(names, [&](const std::string& own) { return own == part || matches(own, part); });
        });
      };
      if (!std::ranges::all_of(wanted, holds)) continue;
      separator_ = separator;
      return name_by(ahead_.size() - 1);
    }
    if (separator_of_row(line, {})) break;
  } while (ahead_.size() < kMostLooked && look());
  // No line has them: the error shows the line above the first numbers.
  const std::size_t shown = ahead_.size() > 1 && separator_of_row(ahead_.back().text, {}) ? ahead_.size() - 2 : 0;
  const std::string& line = ahead_[shown].text;
  head_number_ = ahead_[shown].number;
  if (separator_ == 0) separator_ = separator_of(line);
  if (const std::string wrong = fields_.split(line, separator_); !wrong.empty()) refuse(head_number_, wrong);
  if (separator_of_row(line, {}))
    refuse_names(fmt::format("numbers in place of the names of the columns: {}", listed(split(line, separator_))),
                 kFormat);
  const std::vector<std::string> names = split(line, separator_);
  const std::string here = names.size() < 2 ? ""
                                            : fmt::format("; here it may be --map input=1,output=2{}",
                                                          names.size() > 2 ? fmt::format("-{}", names.size()) : "");
  refuse_names(fmt::format("no line names the {} \"{}\"; this one names {}", wanted.size() > 1 ? "columns" : "column",
                           fmt::join(wanted, "\", \""), listed(names)),
               kFormat + here);
}

// The first line with numbers in `columns`; the names are the line above it with as many fields.
void TableReader::find_first_row(const std::vector<std::size_t>& columns) {
  std::optional<char> separator;
  do {
    separator = separator_of_row(ahead_.back().text, columns);
  } while (!separator && ahead_.size() < kMostLooked && look());
  const bool found = separator.has_value();
  std::size_t row = found ? ahead_.size() - 1 : std::min<std::size_t>(1, ahead_.size() - (layout_.no_header ? 1 : 0));
  if (separator_ == 0) separator_ = separator.value_or(separator_of(ahead_.front().text));
  const std::size_t width = split(ahead_[found ? row : 0].text, separator_).size();
  const auto looks_same = [&](const std::vector<std::string>& fields) {
    return fields.size() == width || fields.size() == width + 1;
  };
  const auto any_number = [&](const std::vector<std::string>& fields) {
    return std::ranges::any_of(columns, [&](std::size_t c) { return c < fields.size() && is_number(fields[c]); });
  };
  const auto fields_at = [&](std::size_t line) { return split(ahead_[line].text, separator_); };
  // A line with a number in one column and none in another is an unreadable row, not a line of names.
  while (row > 0 && looks_same(fields_at(row - 1)) && any_number(fields_at(row - 1))) --row;
  if (layout_.no_header) return number_from(0, width);
  if (row == 0 || !looks_same(fields_at(row - 1))) return number_from(row, width);
  std::size_t names = row - 1;
  if (names > 0 && is_units(fields_at(names), columns) && fields_at(names).size() == fields_at(names - 1).size() &&
      !any_number(fields_at(names - 1)))
    --names;
  name_by(names);
}

void TableReader::name_by(std::size_t line) {
  header_ = ahead_[line].text;
  head_number_ = ahead_[line].number;
  names_ = split(header_, separator_);
  passed_ += line;
  ahead_.erase(ahead_.begin(), ahead_.begin() + static_cast<std::ptrdiff_t>(line) + 1);
}

void TableReader::number_from(std::size_t row, std::size_t columns) {
  head_number_ = first_row_ = ahead_[row].number;
  for (std::size_t i = 1; i <= columns; ++i) names_.push_back(std::to_string(i));
  const std::vector<std::string> first = split(ahead_[row].text, separator_);
  const auto counts_from = [&](std::size_t begin) {
    for (std::size_t i = 0; i < first.size(); ++i)
      if (first[i] != std::to_string(begin + i)) return false;
    return true;
  };
  if (!layout_.no_header && (counts_from(0) || counts_from(1)))
    refuse_names(fmt::format("{} may be names of columns, or samples", listed(first)),
                 fmt::format("choose: --skip-lines {} skips that line, --no-header reads it as samples", first_row_));
  passed_ += row;
  ahead_.erase(ahead_.begin(), ahead_.begin() + static_cast<std::ptrdiff_t>(row));
}

// Index of the first column of that name.
std::size_t TableReader::place_of(std::string_view name) const {
  const auto found = std::ranges::find(names_, name);
  return found == names_.end() ? kAbsent : static_cast<std::size_t>(found - names_.begin());
}

// The columns of `runs export`, if no others are requested.
void TableReader::take_export() {
  const auto are_here = [&](const auto&... name) { return ((place_of(name) != kAbsent) && ...); };
  const bool frames = are_here("frame", "scan", "void", "reference_psi");
  const bool series = are_here("sequence", "name", "taxel", "position");
  if (frames) {
    frame_ = place_of("frame");
    void_ = place_of("void");
    if (!are_here("input") && !stated("input")) layout_.columns["input"] = "reference_psi";
    if (!are_here("output") && !stated("output")) layout_.columns["output"] = "volts_*";
    if (layout_.columns["input"].ends_with("_psi")) units_[0] = "psi";
    if (layout_.columns["output"].starts_with("volts_")) units_[1] = "V";
  }
  if ((frames || series) && !stated("sequence")) layout_.columns["sequence"] = frames ? "recipe" : "name";
}

void TableReader::set_columns(TableNeeds needs) {
  take_export();
  if (needs != TableNeeds::kOutput) input_ = column("input");
  if (needs != TableNeeds::kInput) outputs_ = columns("output");
  sequence_ = column("sequence");
  taxel_ = column("taxel");
  time_ = column("time");
  step_ = place_of("step");
  if (time_ == kAbsent && !stated("time")) {
    const auto found = std::ranges::find_if(names_, [](const auto& name) { return time_unit(name).has_value(); });
    if (found != names_.end()) time_ = place_of(*found);
  }
  in_seconds_ = stated("time") || (time_ != kAbsent && time_unit(names_[time_]) == "s");
  std::vector<std::size_t> used = outputs_;
  if (input_ != kAbsent) used.push_back(input_);
  if (!stated("time") && std::ranges::find(used, time_) != used.end()) time_ = kAbsent;
  for (const std::size_t more : {sequence_, taxel_})
    if (more != kAbsent) used.push_back(more);
  std::ranges::sort(used);
  if (const auto twice = std::ranges::adjacent_find(used); twice != used.end())
    refuse_names(fmt::format("column {} (\"{}\") is given two roles", *twice + 1, names_[*twice]), kFormat);
  if (taxel_ != kAbsent && outputs_.size() > 1)
    refuse_names("both a column of taxels and several outputs, one per taxel", "name one output, or none as taxel");
}

std::size_t TableReader::column(const char* role) const {
  const std::vector<std::size_t> found = columns(role);
  if (found.size() > 1) refuse_names(fmt::format("the {} is one column, not {}", role, found.size()), kFormat);
  return found.empty() ? kAbsent : found.front();
}

// Columns of a role, by name first, then by number. Empty for an optional role that is not assigned, or assigned to
// none.
std::vector<std::size_t> TableReader::columns(const char* role) const {
  const std::string& wanted = layout_.columns.at(role);
  std::vector<std::size_t> found;
  const auto add_named = [&](const auto& is) {
    const std::size_t before = found.size();
    for (std::size_t i = 0; i < names_.size(); ++i)
      if (is(names_[i])) found.push_back(i);
    return found.size() - before;
  };
  const auto add = [&](std::string_view name) {
    const std::size_t named = header_.empty() ? 0 : add_named([&](const std::string& own) { return own == name; });
    if (named > 1) refuse_names(fmt::format("{} columns are named \"{}\"", named, name), "select one by its number");
    return named == 1;
  };
  if (add(wanted)) return found;
  for (const std::string_view part : parts_of(wanted)) {
    if (add(part)) continue;
    std::vector<std::size_t> places = places_of(part);
    if (places.empty() || places.back() >= names_.size()) {
      places.clear();
      if (add_named([&](const std::string& own) { return matches(own, part); }) > 0) continue;
      if (std::string_view(role) != "input" && std::string_view(role) != "output" &&
          (!stated(role) || wanted == "none"))
        return {};
      refuse_names(fmt::format("no column \"{}\" for the {}; the line {} {}", part, role,
                               header_.empty() ? "has" : "names", listed(names_)),
                   kFormat);
    }
    found.insert(found.end(), places.begin(), places.end());
  }
  return found;
}

// True for short words, and no number, in the requested columns.
bool TableReader::is_units(const std::vector<std::string>& words, const std::vector<std::size_t>& columns) const {
  constexpr std::size_t kLongestUnit = 24;  // bytes
  if (std::ranges::any_of(words, is_number)) return false;
  return std::ranges::all_of(columns, [&](std::size_t column) {
    const std::string word = column < words.size() ? words[column] : std::string();
    return !word.empty() && word.size() <= kLongestUnit && word != "NA" && word != "N/A" && word != "na" &&
           word != "n/a";
  });
}

void TableReader::read_units() {
  if (header_.empty() || (ahead_.empty() && !look())) return;
  const std::vector<std::string> words = split(ahead_.front().text, separator_);
  std::vector<std::size_t> columns = outputs_;
  if (input_ != kAbsent) columns.push_back(input_);
  if (words.size() != names_.size() || !is_units(words, columns)) return;
  if (input_ != kAbsent) units_[0] = unit_of(words[input_]);
  if (!outputs_.empty()) units_[1] = unit_of(words[outputs_.front()]);
  units_line_ = ahead_.front().text;
  units_number_ = ahead_.front().number;
  ahead_.pop_front();
}

namespace {

// Position of the closing quote of a field that begins with a quote; none if the line ends before it.
std::size_t closing_quote(std::string_view text, std::size_t open) {
  for (std::size_t at = text.find('"', open + 1); at != std::string_view::npos; at = text.find('"', at + 2))
    if (at + 1 >= text.size() || text[at + 1] != '"') return at;
  return std::string_view::npos;
}

}  // namespace

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

char separator_of(std::string_view header) {
  constexpr std::string_view kCandidates = ",;\t ";
  std::size_t counts[kCandidates.size()] = {};
  bool quoted = false;
  for (const char c : trimmed(header)) {
    if (c == '"') quoted = !quoted;
    const std::size_t which = quoted ? std::string_view::npos : kCandidates.find(c);
    if (which != std::string_view::npos) ++counts[which];
  }
  const auto* const most = std::max_element(counts, counts + 3);
  if (*most > 0) return kCandidates[static_cast<std::size_t>(most - counts)];
  return counts[3] > 0 ? ' ' : ',';
}

std::string separator_name(char separator) {
  if (separator == '\t' || separator == ' ') return separator == ' ' ? "blanks" : "tabs";
  return separator == ';' ? "semicolons" : fmt::format("\"{}\"", separator);
}

std::string Fields::split(std::string_view line, char separator) {
  all.clear();
  unquoted.clear();
  const char* blanks = separator == '\t' ? " " : " \t";
  if (separator == ' ') line = trimmed(line);
  for (std::size_t start = 0;;) {
    const std::size_t open = std::min(line.find_first_not_of(blanks, start), line.size());
    const bool quoted = line.substr(open, 1) == "\"";
    const std::size_t close = quoted ? closing_quote(line, open) : open;
    if (close == std::string_view::npos) return fmt::format("the quote at byte {} is not closed on the line", open + 1);
    const std::size_t from = quoted || separator == ' ' ? close : start;
    const std::size_t end =
        std::min(separator == ' ' ? line.find_first_of(" \t", from) : line.find(separator, from), line.size());
    if (quoted) {
      if (!trimmed(line.substr(close + 1, end - close - 1)).empty())
        return fmt::format("the closing quote at byte {} is followed by more than a separator", close + 1);
      std::string_view inside = line.substr(open + 1, close - open - 1);
      if (inside.find('"') != std::string_view::npos) {
        std::string& own = unquoted.emplace_back(inside);
        for (std::size_t at = 0; (at = own.find("\"\"", at)) != std::string::npos; ++at) own.erase(at, 1);
        inside = own;
      }
      all.push_back(trimmed(inside));
    } else {
      all.push_back(trimmed(line.substr(from, end - from)));
      if (all.back().find('"') != std::string_view::npos)
        return fmt::format("a quote is in the middle of field {}", all.size());
    }
    if (end == line.size()) return {};
    start = end + 1;
  }
}

bool is_formula(std::string_view field) {
  if (field.empty() || std::string_view("=@+-").find(field.front()) == std::string_view::npos) return false;
  if (field.front() == '=' || field.front() == '@') return true;
  field = trimmed(field.substr(1));
  for (std::size_t sign = 1; (sign = field.find_first_of("+-", sign)) != std::string_view::npos; ++sign)
    if (field[sign - 1] != 'e' && field[sign - 1] != 'E') return true;  // "-2+3"
  return field.find_first_not_of("0123456789.,+-eE") != std::string_view::npos && field != "inf" && field != "nan";
}

std::string without_formulas(std::string_view line, char separator) {
  std::string out;
  bool quoted = false, begins = true;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (begins && is_formula(line.substr(i, line.find(quoted ? '"' : separator, i) - i))) out += '\'';
    begins = begins && (c == ' ' || c == '"');
    if (c == '"') quoted = !quoted;
    if (c == separator && !quoted) begins = true;
    out += c;
  }
  return out;
}

std::string NumberText::read(std::string_view text, std::size_t line, double& value) {
  if (text.empty()) return "is blank";
  if (text.starts_with('+')) text.remove_prefix(1);
  const std::string_view whole = text;
  const std::size_t comma = text.find(','), point = text.find('.');
  if (comma != std::string_view::npos) {
    copy_ = text;
    copy_[comma] = '.';
    text = copy_;
  }
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) {
    const bool grouped = whole.find_first_not_of("0123456789.,-") == std::string_view::npos;
    return grouped && comma != std::string_view::npos ? "is not a number (write it without thousands separators)"
                                                      : "is not a number";
  }
  if (!std::isfinite(value)) return kNotFinite;
  if (comma != std::string_view::npos) {
    if (point_line_ != 0) return fmt::format("has a decimal comma where line {} has a decimal point", point_line_);
    if (comma_line_ == 0) {
      comma_line_ = line;
      comma_text_ = whole;
    }
  } else if (point != std::string_view::npos) {
    if (comma_line_ != 0) return fmt::format("has a decimal point where line {} has a decimal comma", comma_line_);
    if (point_line_ == 0) point_line_ = line;
  }
  return {};
}

bool is_number(std::string_view text) {
  double value = 0.0;
  const std::string wrong = NumberText().read(text, 1, value);
  return wrong.empty() || wrong == NumberText::kNotFinite;
}

std::optional<double> clock_seconds(std::string_view text) {
  const auto digits = [&](std::size_t count) {
    int value = -1;
    const char* const end = text.data() + std::min(count, text.size());
    const auto [at, error] = std::from_chars(text.data(), end, value);
    text.remove_prefix(static_cast<std::size_t>(at - text.data()));
    return error == std::errc() && at == end ? value : -1;
  };
  const auto passes = [&](std::string_view marks) {
    const bool is = !text.empty() && marks.find(text.front()) != std::string_view::npos;
    if (is) text.remove_prefix(1);
    return is;
  };
  double days = 0.0;
  if (text.size() > 10 && text[4] == text[7] && (text[4] == '-' || text[4] == '/')) {
    const int year = digits(4);
    const bool first = passes("-/");
    const int month = digits(2);
    const bool second = passes("-/");
    const int day = digits(2);
    const std::chrono::year_month_day date{std::chrono::year(year), std::chrono::month(static_cast<unsigned>(month)),
                                           std::chrono::day(static_cast<unsigned>(day))};
    if (year < 0 || !first || !second || !date.ok() || !passes(" T")) return std::nullopt;
    days = static_cast<double>(std::chrono::sys_days(date).time_since_epoch().count());
  }
  const int hours = digits(2);
  const int minutes = passes(":") ? digits(2) : -1;
  double seconds = -1.0;
  if (hours < 0 || minutes < 0 || !passes(":") || !NumberText().read(text, 1, seconds).empty() || seconds < 0.0)
    return std::nullopt;
  return 86400.0 * days + 3600.0 * hours + 60.0 * minutes + seconds;
}

}  // namespace tactbench::analysis
