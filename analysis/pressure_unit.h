// The unit in which people see pressures: kPa, bar or psi. Data, files and computations stay in psi; every pressure
// that is printed passes here, so that no table mixes units. All pressures are gauge pressures.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace tactbench::analysis {

class PressureUnit {
 public:
  enum Kind { kKilopascal, kBar, kPsi };
  constexpr PressureUnit(Kind kind = kKilopascal) : kind_(kind) {}  // NOLINT(google-explicit-constructor): a plain name
  // "kPa", "bar", "psi", in any case.
  static std::optional<PressureUnit> from(std::string_view word);

  [[nodiscard]] const char* symbol() const;  // "kPa"
  [[nodiscard]] double of(double psi) const;
  [[nodiscard]] double per(double per_psi) const;  // a figure per psi as one per this unit
  // The decimals that resolve about as much as `in_psi` decimals of psi.
  [[nodiscard]] int digits(int in_psi) const;
  // The unit that stands behind in brackets: psi; of psi itself kPa.
  [[nodiscard]] PressureUnit beside() const;

  // Without a sign for zero; "not available" when not finite. `digits`: those of psi.
  [[nodiscard]] std::string fixed(double psi, int digits) const;  // "68.9"
  [[nodiscard]] std::string text(double psi, int digits) const;   // "68.9 kPa"
  // As short as it is exact to four digits: "40 psi", "275.8 kPa", "2.758 bar".
  [[nodiscard]] std::string short_text(double psi) const;
  [[nodiscard]] std::string short_span(double low_psi, double high_psi) const;  // "0 to 413.7 kPa"
  // A sentence of the program, which states pressures in psi ("40 psi up", "allowed is 0 to 60 psi", "2.5 psi/s"), in
  // this unit: "275.8 kPa up". For texts that were stored, or come from where nothing is known of the reader.
  [[nodiscard]] std::string in_text(const std::string& text) const;
  // The same with the other unit behind: "275.8 kPa (40 psi) up".
  [[nodiscard]] std::string both_in_text(const std::string& text) const;

  friend constexpr bool operator==(PressureUnit, PressureUnit) = default;

 private:
  [[nodiscard]] std::string rewritten(const std::string& text, bool both) const;
  Kind kind_;
};

// What the report and the glossary say once.
inline constexpr const char* kGaugeInWords =
    "All pressures are gauge pressures: the excess over the pressure of the surrounding air.";

}  // namespace tactbench::analysis
