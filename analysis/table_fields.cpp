#include "analysis/table_fields.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <system_error>

namespace tactbench::analysis {
namespace {

// Where a field that begins with a quote ends: the place of its closing quote; none when the line ends before.
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

std::string separator_word(char separator) {
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
