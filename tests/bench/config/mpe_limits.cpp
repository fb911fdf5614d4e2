// [[mpe]] of a limits file.
#include <catch2/catch.hpp>

#include "bench/config/config.h"

using namespace tactbench;
using namespace tactbench::bench;

TEST_CASE("a maximum permissible error is of one level or of a span, for a share of the taxels") {
  const std::string whole =
      "schema = 1\nname = \"l\"\nmean_compensation_error_psi = 1\nworst_taxel_error_psi = 3\n"
      "distance_of_mean_percent_fs = 1.5\nunfit_taxels = 0\n";
  const auto limits_with = [&](const std::string& more) { return parse_limits(whole + more, "l.toml").mpe; };
  const auto level = limits_with("[[mpe]]\npressure_psi = 20\nmpe_psi = 2\n");
  REQUIRE(level.size() == 1);
  CHECK(level[0].low_psi == 20.0);
  CHECK(level[0].high_psi == 20.0);
  CHECK(level[0].mpe_psi == 2.0);
  CHECK(level[0].share == 0.95);
  const auto span = limits_with("[[mpe]]\nspan_psi = [4, 60]\nmpe_psi = 3\ntaxels_percent = 90\n");
  CHECK(span.at(0).low_psi == 4.0);
  CHECK(span.at(0).high_psi == 60.0);
  CHECK(span.at(0).share == Approx(0.9));
  for (const char* wrong :
       {"[[mpe]]\nmpe_psi = 2\n", "[[mpe]]\npressure_psi = 20\n",
        "[[mpe]]\npressure_psi = 20\nspan_psi = [4, 60]\nmpe_psi = 2\n", "[[mpe]]\npressure_psi = 20\nmpe_psi = 0\n",
        "[[mpe]]\npressure_psi = 20\nmpe_psi = 2\ntaxels_percent = 0\n",
        "[[mpe]]\npressure_psi = 20\nmpe_psi = 2\nlevel = 3\n"}) {
    INFO(wrong);
    CHECK_THROWS_AS(limits_with(wrong), sequences::FileError);
  }
}
