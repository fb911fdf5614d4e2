// Pressures as people see them: one conversion, one way to round, sentences rewritten without touching anything else.
#include "analysis/pressure_unit.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <tuple>
#include <utility>

using namespace tactbench::analysis;

namespace {

constexpr PressureUnit kKpa = PressureUnit::kKilopascal, kBar = PressureUnit::kBar, kPsi = PressureUnit::kPsi;

}  // namespace

TEST_CASE("units by their names, in any case, and nothing else") {
  CHECK(PressureUnit::from("kPa") == kKpa);
  CHECK(PressureUnit::from("KPA") == kKpa);
  CHECK(PressureUnit::from("bar") == kBar);
  CHECK(PressureUnit::from("Psi") == kPsi);
  for (const char* other : {"", "pa", "mbar", "kPa ", "psig"}) CHECK_FALSE(PressureUnit::from(other).has_value());
}

TEST_CASE("pressures convert by definition and round as finely as they did in psi") {
  CHECK(kKpa.of(60.0) == Approx(413.68543759).epsilon(1e-9));  // NIST SP 811: 6.894757 kPa
  CHECK(kBar.of(60.0) == Approx(4.1368543759).epsilon(1e-9));
  CHECK(kPsi.of(60.0) == 60.0);
  CHECK(kKpa.per(1.0) == Approx(0.1450377));
  CHECK(kKpa.fixed(0.9034, 3) == "6.23");
  CHECK(kBar.fixed(0.9034, 3) == "0.0623");
  CHECK(kPsi.fixed(0.9034, 3) == "0.903");
  CHECK(kKpa.text(40.0, 1) == "275.8 kPa");
  CHECK(kKpa.fixed(-0.0001, 2) == "0.0");
  CHECK(kKpa.text(std::nan(""), 2) == "not available");
  CHECK(kKpa.short_text(40.0) == "275.8 kPa");
  CHECK(kBar.short_text(40.0) == "2.758 bar");
  CHECK(kPsi.short_text(40.0) == "40 psi");
  // A kPa resolves a psi to one digit less, a bar to one more; tenths stay.
  for (const auto& [in_psi, in_kpa, in_bar] :
       {std::tuple{0, 0, 1}, std::tuple{1, 1, 2}, std::tuple{2, 1, 3}, std::tuple{3, 2, 4}}) {
    CHECK((kKpa.digits(in_psi) == in_kpa && kBar.digits(in_psi) == in_bar && kPsi.digits(in_psi) == in_psi));
  }
  CHECK(kKpa.beside() == kPsi);
  CHECK(kPsi.beside() == kKpa);
}

TEST_CASE("spans, and pressures in both units, psi first") {
  CHECK(kKpa.short_span(0, 60) == "0 to 413.7 kPa");
  CHECK(kPsi.short_span(8, 60) == "8 to 60 psi");
  CHECK(both_units(40) == "40 psi (275.8 kPa)");
  CHECK(both_units(-0.04, 1) == "0.0 psi (-0.3 kPa)");
  CHECK(both_units_span(0, 60) == "0 to 60 psi (0 to 413.7 kPa)");
}

TEST_CASE("a text with pressures is written in the unit asked for, in the order that they were added") {
  PressureText reading("reference "), text("vented (feedback ");
  reading.add(40, 1);
  (text.add(-0.04, 1) += ", ").add(reading) += ")";
  CHECK(text.in(kPsi) == "vented (feedback 0.0 psi, reference 40.0 psi)");
  CHECK(text.in(kKpa) == "vented (feedback -0.3 kPa, reference 275.8 kPa)");
  CHECK(PressureText(std::string("none")).in(kBar) == "none");
}
