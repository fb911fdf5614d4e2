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

TEST_CASE("sentences in psi are rewritten, with what is no pressure as it is") {
  const std::pair<const char*, const char*> sentences[] = {
      {"40 psi up", "275.8 kPa up"},
      {"8-60 psi 95 %", "55.16-413.7 kPa 95 %"},
      {"0 to 60 psi", "0 to 413.7 kPa"},
      {"0.0 psi, -0.1 psi", "0.0 kPa, -0.7 kPa"},
      {"by 0.31 psi within 3 s", "by 2.1 kPa within 3 s"},
      {"2.50 psi/s", "17.2 kPa/s"},
      {"+0.031 psi, U 0.050 psi (k = 2)", "+0.21 kPa, U 0.34 kPa (k = 2)"},
      {"0.10 psi and 0.010 psi", "0.69 kPa and 0.069 kPa"},
      {"0.000 psi, -0.05 psi, +3 psi", "0.00 kPa, -0.34 kPa, +20.68 kPa"},
      {"'trip_psi' is 66, psi alone, A4 psi, 4 psig", "'trip_psi' is 66, psi alone, A4 psi, 4 psig"},
      {"array", "array"}};
  for (const auto& [psi, kpa] : sentences) {
    CHECK(kKpa.in_text(psi) == kpa);
    CHECK(kPsi.in_text(psi) == psi);
  }
  CHECK(kBar.in_text("above 66 psi") == "above 4.551 bar");
  CHECK(kBar.in_text("1.5 to 2.5 psi, 0.05 psi") == "0.10 to 0.17 bar, 0.0034 bar");
  CHECK(kKpa.both_in_text("40 psi up") == "275.8 kPa (40 psi) up");
  CHECK(kPsi.both_in_text("0 to 60 psi") == "0 to 60 psi (0 to 413.7 kPa)");
  CHECK(kKpa.both_in_text("no pressure") == "no pressure");
}
