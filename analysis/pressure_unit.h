// The unit in which pressures are displayed: kPa, bar or psi. Data, files and computations are in psi; every printed
// pressure is converted here, so that no table mixes units. All pressures are gauge pressures.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace tactbench::analysis {

class PressureUnit {
 public:
  enum Kind { kKilopascal, kBar, kPsi };
  constexpr PressureUnit(Kind kind = kKilopascal) : kind_(kind) {}  // NOLINT(google-explicit-constructor): a plain name
  // "kPa", "bar", "psi", in any case.
  static std::optional<PressureUnit> from(std::string_view word);

  [[nodiscard]] const char* symbol() const;  // "kPa"
  [[nodiscard]] double of(double psi) const;
  [[nodiscard]] double per(double per_psi) const;  // converts a figure per psi to one per this unit
  // Number of decimals with about the same resolution as `in_psi` decimals of psi.
  [[nodiscard]] int digits(int in_psi) const;
  // The second unit, displayed in brackets: psi; for psi itself kPa.
  [[nodiscard]] PressureUnit other() const;

  // Without a sign for zero; "not available" when not finite. `digits`: those of psi.
  [[nodiscard]] std::string fixed(double psi, int digits) const;  // "68.9"
  [[nodiscard]] std::string text(double psi, int digits) const;   // "68.9 kPa"
  // The shortest text that is exact to four digits: "40 psi", "275.8 kPa", "2.758 bar".
  [[nodiscard]] std::string short_text(double psi) const;
  [[nodiscard]] std::string short_span(double low_psi, double high_psi) const;  // "0 to 413.7 kPa"
  friend constexpr bool operator==(PressureUnit, PressureUnit) = default;

 private:
  Kind kind_;
};

// "40 psi (275.8 kPa)": for stored texts, such as an event, and for texts without a known display unit, such as an
// error of the guard. `decimals`: for readings.
std::string both_units(double psi);
std::string both_units(double psi, int decimals);
std::string both_units_span(double low_psi, double high_psi);  // "0 to 60 psi (0 to 413.7 kPa)"

// A text with pressures whose unit is chosen later, when it is displayed.
class PressureText {
 public:
  PressureText() = default;
  PressureText(std::string text) : text_(std::move(text)) {}  // NOLINT(google-explicit-constructor): without pressures
  PressureText& operator+=(std::string_view text);
  PressureText& add(double psi, int decimals);  // decimals: of psi
  PressureText& add(const PressureText& more);
  [[nodiscard]] std::string in(PressureUnit unit) const;

 private:
  struct Pressure {
    std::size_t at;  // in text_
    double psi;
    int decimals;
  };
  std::string text_;
  std::vector<Pressure> pressures_;
};

}  // namespace tactbench::analysis
