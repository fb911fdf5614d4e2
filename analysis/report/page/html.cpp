#include "analysis/report/page/html.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <stdexcept>

#include "db/remarks.h"

namespace tactbench::analysis::html {
namespace {

constexpr std::string_view kReplacement = "\uFFFD";
constexpr std::string_view kNotAvailable = "not available";

// XML 1.0 production Char without C1 controls and non-characters; direction overrides would let a name change the text
// next to it.
bool printable(std::uint32_t c) {
  if (c < 0x20) return c == '\t' || c == '\n';
  if (c >= 0x7F && c <= 0x9F) return false;
  if ((c >= 0x202A && c <= 0x202E) || (c >= 0x2066 && c <= 0x2069)) return false;
  return (c & 0xFFFEu) != 0xFFFEu && !(c >= 0xFDD0 && c <= 0xFDEF);
}

// Characters that never need escaping: nearly all of a page.
constexpr auto kPlain = [] {
  std::array<bool, 256> plain{};
  for (unsigned char c = ' '; c <= '~'; ++c) plain[c] = c != '&' && c != '<' && c != '>' && c != '"' && c != '\'';
  return plain;
}();
bool is_plain(char c) { return kPlain[static_cast<unsigned char>(c)]; }

std::string escape(std::string_view untrusted, bool in_attribute) {
  std::string out;
  out.reserve(untrusted.size() + untrusted.size() / 8);
  while (true) {
    const auto plain = static_cast<std::size_t>(std::ranges::find_if_not(untrusted, is_plain) - untrusted.begin());
    out += untrusted.substr(0, plain);
    untrusted.remove_prefix(plain);
    if (untrusted.empty()) return out;
    const db::CodePoint c = db::decode_utf8(untrusted);
    const std::string_view bytes = untrusted.substr(0, c.bytes);
    untrusted.remove_prefix(c.bytes);
    if (!c.valid || !printable(c.value)) {
      out += kReplacement;
    } else if (c.value == '&') {
      out += "&amp;";
    } else if (c.value == '<') {
      out += "&lt;";
    } else if (c.value == '>') {
      out += "&gt;";
    } else if (c.value == '"') {
      out += "&quot;";
    } else if (c.value == '\'') {
      out += "&#39;";
    } else if (in_attribute && c.value < 0x20) {
      out += fmt::format("&#{};", c.value);  // XML would turn a raw tab or line end into a space
    } else {
      out += bytes;
    }
  }
}

// "-0.00" is a rounding artefact: zero has no sign here.
std::string visible(std::string digits) {
  if (digits.empty() || digits.front() != '-') return digits;
  digits.erase(0, 1);
  if (digits.find_first_of("123456789") == std::string::npos) return digits;
  return "\u2212" + digits;
}

std::string fixed_string(double number, int digits) {
  if (!std::isfinite(number)) return std::string(kNotAvailable);
  return visible(fmt::format("{:.{}f}", number, digits));
}

}  // namespace

Text::Text(std::string_view untrusted) : Safe{escape(untrusted, false)} {}
Attribute::Attribute(std::string_view untrusted) : Safe{escape(untrusted, true)} {}

CssNumber::CssNumber(double number, int digits) {
  if (!std::isfinite(number)) throw std::invalid_argument("a coordinate of the report is not finite");
  long long scale = 1;
  for (int i = 0; i < digits; ++i) scale *= 10;
  long long units = std::llrint(number * static_cast<double>(scale));  // not by fmt: a report has 10 000 of them
  if (units < 0) value = "-";
  units = std::abs(units);
  value += fmt::format_int(units / scale).str();
  units %= scale;
  if (units == 0) return;
  value += '.';
  for (scale /= 10; units > 0; units %= scale, scale /= 10) value += static_cast<char>('0' + units / scale);
}

PathData& PathData::number(long whole) {
  const fmt::format_int digits(whole);
  value.append(digits.data(), digits.size());
  return *this;
}

PathData& PathData::tenths(long count, bool after_number) {
  if (after_number && count >= 0) value += ' ';
  if (count < 0) value += '-';
  const long size = std::abs(count);
  if (size >= 10 || size == 0) number(size / 10);
  if (size % 10 != 0) {
    value += '.';
    value += static_cast<char>('0' + size % 10);
  }
  return *this;
}

JsonInHtml::JsonInHtml(std::string_view json) {
  if (json.find('<') == json.npos && json.find('>') == json.npos && json.find('&') == json.npos) {
    value = json;
    return;
  }
  value.reserve(json.size() + json.size() / 16);
  for (std::size_t from = 0; from < json.size();) {
    std::size_t at = from;
    while (at < json.size() && json[at] != '<' && json[at] != '>' && json[at] != '&') ++at;
    value.append(json, from, at - from);
    if (at == json.size()) break;
    value += json[at] == '<' ? "\\u003c" : json[at] == '>' ? "\\u003e" : "\\u0026";
    from = at + 1;
  }
}

Text fixed(double number, int digits) { return Text(fixed_string(number, digits)); }

Text significant(double number, int digits) {
  if (!std::isfinite(number)) return Text(kNotAvailable);
  std::string out = visible(fmt::format("{:.{}g}", number, digits));
  // 1e-05 reads as 1×10 to the power of −5 only to programmers.
  const std::size_t e = out.find('e');
  if (e == std::string::npos) return Text(out);
  const int power = std::stoi(out.substr(e + 1));
  return Text(fmt::format("{} × 10^{}", out.substr(0, e), visible(fmt::format("{}", power))));
}

}  // namespace tactbench::analysis::html

namespace tactbench::analysis {

double rounded_to_uncertainty(double value, double expanded) {
  if (!std::isfinite(value) || !std::isfinite(expanded) || expanded < 99.5) return value;
  const double place = std::pow(10.0, std::floor(std::log10(expanded)) - 1.0);
  return place * std::nearbyint(value / place);
}

int gum_decimals(double expanded) {
  if (!std::isfinite(expanded) || expanded <= 0.0) return 3;
  int exponent = static_cast<int>(std::floor(std::log10(expanded)));
  // 0.0996 is 0.10: a number that rounds up to the next power of ten has one digit less.
  if (std::nearbyint(expanded / std::pow(10.0, exponent - 1)) >= 100.0) ++exponent;
  return std::clamp(1 - exponent, 0, 9);
}

std::string fixed_text(double value, int digits) {
  if (!std::isfinite(value)) return "–";
  std::string text = fmt::format("{:.{}f}", value, digits);
  if (text.front() != '-') return text;
  text.erase(0, 1);
  return text.find_first_of("123456789") == std::string::npos ? text : "\u2212" + text;
}

std::string two_digits_text(double expanded) {
  return fixed_text(rounded_to_uncertainty(expanded, expanded), gum_decimals(expanded));
}

}  // namespace tactbench::analysis
