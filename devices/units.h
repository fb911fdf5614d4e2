// Physical quantities as types that cannot be mixed. Values read from or sent to an instrument have their unit in the
// type; analysis and db use double with the unit in the name. Used by all code that drives an instrument.
#pragma once

#include <compare>

namespace tactbench::devices {

template <class Tag>
class Quantity {
 public:
  constexpr Quantity() = default;
  constexpr explicit Quantity(double value) : value_(value) {}
  [[nodiscard]] constexpr double value() const { return value_; }
  constexpr auto operator<=>(const Quantity&) const = default;
  constexpr Quantity operator+(Quantity other) const { return Quantity(value_ + other.value_); }
  constexpr Quantity operator-(Quantity other) const { return Quantity(value_ - other.value_); }
  constexpr Quantity operator-() const { return Quantity(-value_); }
  constexpr Quantity operator*(double factor) const { return Quantity(value_ * factor); }
  constexpr double operator/(Quantity other) const { return value_ / other.value_; }

 private:
  double value_ = 0.0;
};

using Psi = Quantity<struct PsiTag>;
using Volts = Quantity<struct VoltsTag>;
using Newtons = Quantity<struct NewtonsTag>;
using Millimetres = Quantity<struct MillimetresTag>;
using MillimetresPerSecond = Quantity<struct MillimetresPerSecondTag>;
using Celsius = Quantity<struct CelsiusTag>;

// NIST SP 811, appendix B: 1 psi = 6.894757 kPa; 1 bar = 100 kPa exactly.
inline constexpr double kKilopascalsPerPsi = 6.894757293168361;
inline constexpr double kPsiPerBar = 100.0 / kKilopascalsPerPsi;

constexpr double kilopascals(Psi pressure) { return pressure.value() * kKilopascalsPerPsi; }

}  // namespace tactbench::devices
