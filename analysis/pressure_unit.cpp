#include "analysis/pressure_unit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <regex>

namespace tactbench::analysis {

namespace {

constexpr double kKilopascalsPerPsi = 6.894757293168361;  // NIST SP 811, appendix B
constexpr PressureUnit kUnits[] = {PressureUnit::kKilopascal, PressureUnit::kBar, PressureUnit::kPsi};

// "-0.00" is a rounding artefact.
std::string without_signed_zero(std::string digits) {
  if (digits.starts_with('-') && digits.find_first_of("123456789") == std::string::npos) digits.erase(0, 1);
  return digits;
}

// Numbers as sentences have them, joined in a span: "40", "-0.6", "0 to 60", "8-60".
const std::regex& stated_pressures() {
  static const std::regex pattern(
      R"((^|[^A-Za-z0-9_.+-])([+-]?\d+(?:\.\d+)?(?:(?:-| to )[+-]?\d+(?:\.\d+)?)*) psi(?![A-Za-z0-9_]))");
  return pattern;
}
const std::regex& stated_number() {
  static const std::regex pattern(R"((^|-| to )([+-]?\d+(?:\.\d+)?))");
  return pattern;
}

// Decimals as the text has them; a whole number may be an exact one and is shown to four digits. What is stated to
// hundredths or finer keeps two significant digits: 0.05 psi is 0.34 kPa, not 0.3.
std::string converted(const std::string& number, PressureUnit unit) {
  const std::size_t point = number.find('.');
  const double psi = std::strtod(number.c_str(), nullptr);
  const char* const plus = number.starts_with('+') ? "+" : "";
  if (point == std::string::npos) return fmt::format("{}{:.4g}", plus, unit.of(psi));
  const auto decimals = static_cast<int>(number.size() - point - 1);
  const double shown = std::abs(unit.of(psi));
  const int needed = decimals < 2 || psi == 0.0 ? 0 : 1 - static_cast<int>(std::floor(std::log10(shown)));
  if (needed > unit.digits(decimals)) return fmt::format("{}{:.{}f}", plus, unit.of(psi), needed);
  return plus + unit.fixed(psi, decimals);
}

template <class Write>
std::string replaced(const std::string& text, const std::regex& pattern, Write write) {
  std::string out;
  auto from = text.cbegin();
  for (auto found = std::sregex_iterator(text.begin(), text.end(), pattern); found != std::sregex_iterator(); ++found) {
    out.append(from, (*found)[0].first);
    out += write(*found);
    from = (*found)[0].second;
  }
  return out.append(from, text.cend());
}

}  // namespace

std::optional<PressureUnit> PressureUnit::from(std::string_view word) {
  const auto same = [](char a, char b) {
    return std::tolower(static_cast<unsigned char>(a)) == std::tolower(static_cast<unsigned char>(b));
  };
  for (const PressureUnit unit : kUnits)
    if (std::ranges::equal(word, std::string_view(unit.symbol()), same)) return unit;
  return {};
}

const char* PressureUnit::symbol() const {
  switch (kind_) {
    case kKilopascal:
      return "kPa";
    case kBar:
      return "bar";
    case kPsi:
      break;
  }
  return "psi";
}

double PressureUnit::of(double psi) const {
  switch (kind_) {
    case kKilopascal:
      return psi * kKilopascalsPerPsi;
    case kBar:
      return psi * kKilopascalsPerPsi / 100.0;
    case kPsi:
      break;
  }
  return psi;
}

double PressureUnit::per(double per_psi) const { return per_psi / of(1.0); }

int PressureUnit::digits(int in_psi) const {
  const int finer = in_psi - static_cast<int>(std::lround(std::log10(of(1.0))));
  return std::max(finer, std::min(in_psi, 1));  // tenths stay: 0.1 psi is 0.7 kPa, not 1
}

PressureUnit PressureUnit::beside() const { return kind_ == kPsi ? kKilopascal : kPsi; }

std::string PressureUnit::fixed(double psi, int in_psi) const {
  if (!std::isfinite(psi)) return "not available";
  return without_signed_zero(fmt::format("{:.{}f}", of(psi), digits(in_psi)));
}

std::string PressureUnit::text(double psi, int in_psi) const {
  return std::isfinite(psi) ? fmt::format("{} {}", fixed(psi, in_psi), symbol()) : fixed(psi, in_psi);
}

std::string PressureUnit::short_text(double psi) const {
  return kind_ == kPsi ? fmt::format("{:g} psi", psi) : fmt::format("{:.4g} {}", of(psi), symbol());
}

std::string PressureUnit::short_span(double low_psi, double high_psi) const {
  return kind_ == kPsi ? fmt::format("{:g} to {:g} psi", low_psi, high_psi)
                       : fmt::format("{:.4g} to {:.4g} {}", of(low_psi), of(high_psi), symbol());
}

std::string PressureUnit::rewritten(const std::string& text, bool both) const {
  if (text.find(" psi") == std::string::npos) return text;
  return replaced(text, stated_pressures(), [&](const std::smatch& span) {
    const std::string numbers = span[2].str();
    const auto in = [&](PressureUnit unit) {
      if (unit.kind_ == kPsi) return numbers + " psi";
      return replaced(numbers, stated_number(),
                      [&](const std::smatch& one) { return one[1].str() + converted(one[2].str(), unit); }) +
             " " + unit.symbol();
    };
    return span[1].str() + (both ? fmt::format("{} ({})", in(*this), in(beside())) : in(*this));
  });
}

std::string PressureUnit::in_text(const std::string& text) const {
  return kind_ == kPsi ? text : rewritten(text, false);
}

std::string PressureUnit::both_in_text(const std::string& text) const { return rewritten(text, true); }

}  // namespace tactbench::analysis
