// Pressures as people see them: one conversion, one way to round, sentences rewritten without touching anything else.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstddef>
#include <string>
#include <tuple>
#include <utility>

#include "analysis/counted.h"
#include "analysis/error.h"
#include "analysis/pressure_unit.h"
#include "analysis/read_whole_file.h"
#include "tests/support/process.h"

using namespace tactbench::analysis;

namespace {

constexpr PressureUnit kKpa = PressureUnit::kKilopascal, kBar = PressureUnit::kBar, kPsi = PressureUnit::kPsi;

}  // namespace

TEST_CASE("PressureUnit: accepts kPa, bar and psi in any case, and no other name") {
  CHECK(PressureUnit::from("kPa") == kKpa);
  CHECK(PressureUnit::from("KPA") == kKpa);
  CHECK(PressureUnit::from("bar") == kBar);
  CHECK(PressureUnit::from("Psi") == kPsi);
  for (const char* other : {"", "pa", "mbar", "kPa ", "psig"}) CHECK_FALSE(PressureUnit::from(other).has_value());
}

TEST_CASE("PressureUnit: conversion follows the definition, and rounding is as fine as in psi") {
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
  CHECK(kKpa.other() == kPsi);
  CHECK(kPsi.other() == kKpa);
}

TEST_CASE("PressureUnit: spans and values are printed in one unit, or in both with psi first") {
  CHECK(kKpa.short_span(0, 60) == "0 to 413.7 kPa");
  CHECK(kPsi.short_span(8, 60) == "8 to 60 psi");
  CHECK(both_units(40) == "40 psi (275.8 kPa)");
  CHECK(both_units(-0.04, 1) == "0.0 psi (-0.3 kPa)");
  CHECK(both_units_span(0, 60) == "0 to 60 psi (0 to 413.7 kPa)");
}

TEST_CASE("PressureText: prints its pressures in the requested unit, in the order they were added") {
  PressureText reading("reference "), text("vented (feedback ");
  reading.add(40, 1);
  (text.add(-0.04, 1) += ", ").add(reading) += ")";
  CHECK(text.in(kPsi) == "vented (feedback 0.0 psi, reference 40.0 psi)");
  CHECK(text.in(kKpa) == "vented (feedback -0.3 kPa, reference 275.8 kPa)");
  CHECK(PressureText(std::string("none")).in(kBar) == "none");
}

// Files at their longest.

using tactbench::tests::TemporaryFolder;
using tactbench::tests::write_file;

TEST_CASE("file reading: a file up to the size limit is read whole, one byte more is refused") {
  const TemporaryFolder folder;
  const std::string path = folder.path("f");
  for (const std::size_t bytes : {0U, 10U, 65536U, 65537U, 200001U}) {
    CAPTURE(bytes);
    std::string text(bytes, 'a');
    if (!text.empty()) text.back() = 'z';
    write_file(path, text);
    CHECK(read_whole_file(path, {.max_bytes = std::max(bytes, std::size_t{10}), .or_pipe = false}, "TB-X", "mend it") ==
          text);
    if (bytes < 10) continue;
    try {
      (void)read_whole_file(path, {.max_bytes = bytes - 1, .or_pipe = false}, "TB-X", "mend it");
      FAIL_CHECK("read");
    } catch (const AnalysisError& error) {
      CHECK(error.id() == "TB-X");
      CHECK_THAT(error.what(), Catch::Contains(std::to_string(bytes - 1)));
    }
  }
  for (const char* none : {"none", ""})
    CHECK_THROWS_AS(read_whole_file(folder.path(none), {.max_bytes = 10, .or_pipe = true}, "TB-X", "mend it"),
                    AnalysisError);
}

using tactbench::analysis::counted;

TEST_CASE("counted: the noun is singular for one and plural for any other number") {
  CHECK(counted(0, "frame") == "0 frames");
  CHECK(counted(1, "frame") == "1 frame");
  CHECK(counted(std::size_t{2}, "frame") == "2 frames");
  CHECK(counted(-1, "microstep") == "-1 microsteps");
  CHECK(counted(std::size_t{1}, "branch", "branches") == "1 branch");
  CHECK(counted(0L, "branch", "branches") == "0 branches");
}
