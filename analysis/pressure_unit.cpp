#include "analysis/pressure_unit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>

namespace tactbench::analysis {

namespace {

constexpr double kKilopascalsPerPsi = 6.894757293168361;  // NIST SP 811, appendix B
constexpr PressureUnit kUnits[] = {PressureUnit::kKilopascal, PressureUnit::kBar, PressureUnit::kPsi};

// "-0.00" is a rounding artefact.
std::string without_signed_zero(std::string digits) {
  if (digits.starts_with('-') && digits.find_first_of("123456789") == std::string::npos) digits.erase(0, 1);
  return digits;
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

PressureUnit PressureUnit::other() const { return kind_ == kPsi ? kKilopascal : kPsi; }

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

namespace {

std::string with_kilopascals(const std::string& in_psi, const std::string& in_kilopascals) {
  return fmt::format("{} ({})", in_psi, in_kilopascals);
}

constexpr PressureUnit kPsi = PressureUnit::kPsi, kKilopascal = PressureUnit::kKilopascal;

}  // namespace

std::string both_units(double psi) { return with_kilopascals(kPsi.short_text(psi), kKilopascal.short_text(psi)); }

std::string both_units(double psi, int decimals) {
  if (!std::isfinite(psi)) return fmt::format("{} psi", psi);  // unchanged, as the instrument reported it
  return with_kilopascals(kPsi.text(psi, decimals), kKilopascal.text(psi, decimals));
}

std::string both_units_span(double low_psi, double high_psi) {
  return with_kilopascals(kPsi.short_span(low_psi, high_psi), kKilopascal.short_span(low_psi, high_psi));
}

PressureText& PressureText::operator+=(std::string_view text) {
  text_ += text;
  return *this;
}

PressureText& PressureText::add(const PressureText& more) {
  for (Pressure pressure : more.pressures_) {
    pressure.at += text_.size();
    pressures_.push_back(pressure);
  }
  text_ += more.text_;
  return *this;
}

PressureText& PressureText::add(double psi, int decimals) {
  pressures_.push_back({text_.size(), psi, decimals});
  return *this;
}

std::string PressureText::in(PressureUnit unit) const {
  std::string out;
  std::size_t from = 0;
  for (const Pressure& pressure : pressures_) {
    out += text_.substr(from, pressure.at - from) + unit.text(pressure.psi, pressure.decimals);
    from = pressure.at;
  }
  return out + text_.substr(from);
}

}  // namespace tactbench::analysis
