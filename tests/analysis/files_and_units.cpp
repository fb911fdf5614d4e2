// Pressure units digit by digit, how far work has come, and files at their longest: by hand.
#include <catch2/catch.hpp>
#include <limits>

#include "analysis/error.h"
#include "analysis/pressure_unit.h"
#include "analysis/whole_file.h"
#include "analysis/work_count.h"
#include "tests/support/process.h"

using namespace tactbench::analysis;
using tactbench::tests::TemporaryFolder;
using tactbench::tests::write_file;

TEST_CASE("decimals of each unit: a kPa resolves a psi to one digit less, a bar to one more, tenths stay") {
  const PressureUnit kpa = PressureUnit::kKilopascal, bar = PressureUnit::kBar, psi = PressureUnit::kPsi;
  for (const auto& [in_psi, in_kpa, in_bar] :
       {std::tuple{0, 0, 1}, std::tuple{1, 1, 2}, std::tuple{2, 1, 3}, std::tuple{3, 2, 4}}) {
    CHECK(kpa.digits(in_psi) == in_kpa);
    CHECK(bar.digits(in_psi) == in_bar);
    CHECK(psi.digits(in_psi) == in_psi);
  }
  CHECK(kpa.per(6.894757293168361) == Approx(1.0));
  CHECK(bar.per(1.0) == Approx(14.503774));
  CHECK(psi.per(3.0) == 3.0);
  CHECK(kpa.text(-0.004, 2) == "0.0 kPa");
  CHECK(kpa.text(-0.01, 2) == "-0.1 kPa");
  CHECK(bar.text(std::numeric_limits<double>::infinity(), 1) == "not available");
  CHECK(psi.short_text(0.25) == "0.25 psi");
}

TEST_CASE("pressures in sentences keep two significant digits from hundredths on, whole ones are shown to four") {
  const PressureUnit kpa = PressureUnit::kKilopascal, bar = PressureUnit::kBar;
  const auto in_kpa = [&](const char* number) { return kpa.in_text(std::string(number) + " psi"); };
  CHECK(in_kpa("0.1") == "0.7 kPa");
  CHECK(in_kpa("0.10") == "0.69 kPa");
  CHECK(in_kpa("0.010") == "0.069 kPa");
  CHECK(in_kpa("1.00") == "6.9 kPa");
  CHECK(in_kpa("20.00") == "137.9 kPa");
  CHECK(in_kpa("0.000") == "0.00 kPa");
  CHECK(in_kpa("-0.05") == "-0.34 kPa");
  CHECK(in_kpa("+0.05") == "+0.34 kPa");
  CHECK(in_kpa("+3") == "+20.68 kPa");
  CHECK(in_kpa("1") == "6.895 kPa");
  CHECK(bar.in_text("0.05 psi") == "0.0034 bar");
  CHECK(bar.in_text("1.5 to 2.5 psi") == "0.10 to 0.17 bar");
  CHECK(kpa.both_in_text("from 1 to 2 psi and 3 psi") == "from 6.895 to 13.79 kPa (1 to 2 psi) and 20.68 kPa (3 psi)");
}

TEST_CASE("work counts its pieces, work within it counts for nothing of its own") {
  const WorkNow before = work_now();
  {
    Work outer(5);
    CHECK(work_now().works == before.works + 1);
    CHECK((work_now().count == 5 && work_now().done == 0));
    outer.add();
    outer.add(2);
    CHECK(work_now().done == 3);
    {
      Work inner(100);
      inner.add(50);
      CHECK((work_now().count == 5 && work_now().done == 3 && work_now().works == before.works + 1));
    }
    CHECK(work_now().count == 5);
    outer.add();
    CHECK(work_now().done == 4);
  }
  CHECK(work_now().count == 0);
  const Work next(7);
  CHECK((work_now().works == before.works + 2 && work_now().count == 7 && work_now().done == 0));
}

TEST_CASE("a file is read whole up to its most bytes, in blocks, and one byte more is refused") {
  const TemporaryFolder folder;
  const auto read = [&](std::size_t bytes, std::size_t most) {
    std::string text(bytes, 'a');
    if (!text.empty()) text.back() = 'z';
    write_file(folder.path("f"), text);
    try {
      return whole_file(folder.path("f"), {.most_bytes = most, .or_pipe = false}, "TB-X", "mend it") == text
                 ? std::string("whole")
                 : std::string("not whole");
    } catch (const AnalysisError& error) {
      return error.id() + " " + error.what();
    }
  };
  CHECK(read(0, 10) == "whole");
  CHECK(read(10, 10) == "whole");
  CHECK_THAT(read(11, 10), Catch::StartsWith("TB-X") && Catch::EndsWith("is longer than 10 bytes"));
  CHECK(read(65536, 100000) == "whole");
  CHECK(read(65537, 100000) == "whole");
  CHECK(read(200001, 200001) == "whole");
  CHECK_THAT(read(200001, 200000), Catch::EndsWith("is longer than 200000 bytes"));
  CHECK_THROWS_AS(whole_file(folder.path("none"), {.most_bytes = 10, .or_pipe = true}, "TB-X", "mend it"),
                  AnalysisError);
  CHECK_THROWS_AS(whole_file(folder.path(""), {.most_bytes = 10, .or_pipe = true}, "TB-X", "mend it"), AnalysisError);
}
