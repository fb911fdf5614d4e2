// Typed pieces of the report's markup: each kind of escaped text has its own type and `markup` accepts no other, so
// that an unescaped string cannot reach the page. The result is HTML that is also well-formed XML 1.0.
#pragma once

#include <fmt/format.h>

#include <concepts>
#include <string>
#include <string_view>
#include <type_traits>

namespace tactbench::analysis::html {

struct Safe {
  std::string value;
};

// Finished markup.
struct Markup : Safe {
  Markup& operator+=(const Safe& other) {
    value += other.value;
    return *this;
  }
  // Literal source text, not escaped (CSS, whose braces `markup` would read as fields).
  template <std::size_t N>
  static Markup literal(const char (&source)[N]) {
    Markup out;
    out.value.assign(source, N - 1);
    return out;
  }
};

// Between tags. Bytes that are not UTF-8, characters that XML forbids and bidirectional overrides become U+FFFD.
struct Text : Safe {
  explicit Text(std::string_view untrusted);
};

// Between the double quotes of an attribute.
struct Attribute : Safe {
  explicit Attribute(std::string_view untrusted);
};

// A coordinate or length with at most `digits` decimals. Throws std::invalid_argument when not finite.
struct CssNumber : Safe {
  explicit CssNumber(double number, int digits = 2);
};

// The d of an SVG path, built from numbers and text of our own source.
class PathData : public Safe {
 public:
  template <std::size_t N>
  PathData& literal(const char (&source)[N]) {
    value.append(source, N - 1);
    return *this;
  }
  PathData& number(long whole);
  // The shortest form of tenths in SVG: "12.5", "-.5", "3"; after another number with a separator if needed.
  PathData& tenths(long count, bool after_number);
};

// A JSON text inside <script type="application/json">: `<`, `>` and `&` as \uXXXX. `json` must be valid JSON in ASCII.
struct JsonInHtml : Safe {
  explicit JsonInHtml(std::string_view json);
};

template <class T>
concept Piece = std::derived_from<T, Safe> || (std::integral<T> && !std::same_as<T, bool> && !std::same_as<T, char>);

template <Piece... Pieces>
Markup markup(fmt::format_string<const Pieces&...> format, const Pieces&... pieces) {
  Markup out;
  out.value = fmt::format(format, pieces...);
  return out;
}

// Numbers for display: C locale, round half to even, U+2212 for a minus, "not available" when not finite.
Text fixed(double number, int digits);
Text significant(double number, int digits);

}  // namespace tactbench::analysis::html

template <class T>
  requires std::derived_from<T, tactbench::analysis::html::Safe>
struct fmt::formatter<T> : fmt::formatter<std::string_view> {
  template <class Context>
  auto format(const tactbench::analysis::html::Safe& piece, Context& context) const {
    return fmt::formatter<std::string_view>::format(piece.value, context);
  }
};

// Formats numbers for people.

namespace tactbench::analysis {

// Number of decimals (0..9) that gives `expanded` two significant digits after rounding; 3 if it is 0 or not finite
// (JCGM 100, 7.2.6).
int gum_decimals(double expanded);
// `value` rounded to the last significant digit of `expanded`: 106 with two significant digits is 110, so the value is
// rounded to tens.
double rounded_to_uncertainty(double value, double expanded);
// Rounds half to even; U+2212 for a minus, no sign for zero, "–" for a non-finite number.
std::string fixed_text(double value, int digits);
std::string two_digits_text(double expanded);

}  // namespace tactbench::analysis
