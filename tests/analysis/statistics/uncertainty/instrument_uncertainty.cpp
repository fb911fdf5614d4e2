// Budgets of the force sensor and the thermometer, row by row, and what a certificate covers: by hand.
#include "analysis/statistics/uncertainty/instrument_uncertainty.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <stdexcept>

using namespace tactbench;
using namespace tactbench::analysis;

namespace {

db::RunRecord run_with(const std::string& role, const std::string& json,
                       const std::string& utc = "2026-05-06T07:08:09Z") {
  db::RunRecord run;
  run.started_utc = utc;
  run.devices = {{"pressure reference", "PT", "1", "", "hardware", R"({"expanded_uncertainty_n":99})"},
                 {role, "F-1", "77", "", "hardware", json}};
  return run;
}

const InstrumentRow& row_named(const InstrumentUncertainty& budget, const std::string& name) {
  for (const InstrumentRow& row : budget.rows)
    if (row.name == name) return row;
  throw std::runtime_error("no row " + name);
}

constexpr const char* kForceSensorText =
    R"({"expanded_uncertainty_n":0.3,"drift_n":0.12,"input_limit_n":0.06,"certificate_covers":"transducer",)"
    R"("calibrated":"2026-01-31","due":"2027-01-31"})";

}  // namespace

TEST_CASE("force sensor by hand: certificate over 2, drift and input over sqrt 3, and their root sum of squares") {
  const InstrumentUncertainty budget =
      instrument_uncertainty(run_with("force sensor", kForceSensorText), "force sensor");
  CHECK(budget.unit == "N");
  CHECK(budget.covers == CertificateCovers::kTransducer);
  REQUIRE(budget.rows.size() == 3);
  const InstrumentRow &certificate = budget.rows[0], &drift = budget.rows[1], &input = budget.rows[2];
  CHECK((certificate.name == "certificate" && certificate.distribution == "normal"));
  CHECK((certificate.width == 0.3 && certificate.divisor == 2.0));
  CHECK(certificate.u() == Approx(0.15));
  CHECK((drift.name == "drift" && drift.distribution == "rectangular"));
  CHECK(drift.u() == Approx(0.12 / std::sqrt(3.0)));
  CHECK(input.distribution == "rectangular");
  CHECK(input.u() == Approx(0.06 / std::sqrt(3.0)));
  for (const InstrumentRow& row : budget.rows) CHECK(row.assessed());
  CHECK(budget.complete());
  // 0.0225 + 0.0048 + 0.0012
  CHECK(budget.u() == Approx(std::sqrt(0.0285)));
  CHECK(budget.expanded() == Approx(2.0 * std::sqrt(0.0285)));
}

TEST_CASE("force sensor by hand: beyond the due date its drift grows, a laboratory's earlier date counts") {
  // 365 days from calibration to due date; 730 days after the calibration it is twice the limit.
  const db::RunRecord late = run_with("force sensor", kForceSensorText, "2028-01-31T00:00:00Z");
  CHECK(row_named(instrument_uncertainty(late, "force"), "drift").width == Approx(0.24));
  const std::vector<InstrumentNote> notes{{"77", "", "", "", "2026-03-02", ""}};  // 30 days, of 95 that have passed
  CHECK(row_named(instrument_uncertainty(run_with("force sensor", kForceSensorText), "force", notes), "drift").width ==
        Approx(0.12 * 95.0 / 30.0));
}

TEST_CASE("instruments: what is not stated is named with its table and key, and is in no sum") {
  const InstrumentUncertainty bare = instrument_uncertainty(run_with("force sensor", "{}"), "force sensor");
  REQUIRE(bare.rows.size() == 3);
  for (const InstrumentRow& row : bare.rows) CHECK_FALSE(row.part.missing.empty());
  CHECK_FALSE(bare.complete());
  CHECK(bare.u() == 0.0);
  const auto of_force = [](const std::string& json) {
    return instrument_uncertainty(run_with("force sensor", json), "force sensor");
  };
  const InstrumentUncertainty chain =
      of_force(R"({"expanded_uncertainty_n":0.3,"drift_n":0.12,"certificate_covers":"chain"})");
  CHECK_FALSE(chain.rows[2].part.from.empty());
  CHECK_FALSE(chain.rows[2].assessed());
  CHECK(chain.complete());
  CHECK(chain.u() == Approx(std::sqrt(0.0225 + 0.0048)));
  CHECK_FALSE(
      of_force(R"({"expanded_uncertainty_n":0.3,"certificate_covers":"transducer"})").rows[2].part.missing.empty());
  const InstrumentUncertainty unsaid = of_force(R"({"expanded_uncertainty_n":0.3})");
  CHECK_FALSE(unsaid.rows[2].part.missing.empty());
  CHECK(unsaid.u() == Approx(0.15));
  // Numbers that are none, and limits that are no limits.
  for (const char* odd : {R"({"expanded_uncertainty_n":"0.3"})", R"({"expanded_uncertainty_n":-0.3})",
                          R"({"expanded_uncertainty_n":0})", "[]", "", "{"})
    CHECK(of_force(odd).u() == 0.0);
}

TEST_CASE("thermometer by hand: kelvins, its own table, and only the device that was asked for") {
  const db::RunRecord run = run_with("temperature_c ambient",
                                     R"({"expanded_uncertainty_c":0.2,"drift_c":0.06,"certificate_covers":"chain"})");
  const InstrumentUncertainty budget = instrument_uncertainty(run, "temperature_c");
  CHECK(budget.unit == "K");
  CHECK(budget.covers == CertificateCovers::kChain);
  CHECK(budget.u() == Approx(std::sqrt(0.01 + 0.0012)));
  CHECK(instrument_uncertainty(run, "force sensor").unit.empty());
  CHECK(instrument_uncertainty(run, "force sensor").rows.empty());
  CHECK_FALSE(instrument_uncertainty(run, "force sensor").complete());
  CHECK_FALSE(instrument_uncertainty(run_with("temperature_c", "{}"), "temperature_c").rows[1].part.missing.empty());
  CHECK(instrument_uncertainty({}, "temperature_c").unit.empty());
}

TEST_CASE("what a certificate covers, by its word, and what that makes of a part of the chain") {
  const auto covers = [](const std::string& json) { return covers_of({"force", "", "", "", "", json}); };
  CHECK(covers(R"({"certificate_covers":"chain"})") == CertificateCovers::kChain);
  CHECK(covers(R"({"certificate_covers":"transducer"})") == CertificateCovers::kTransducer);
  for (const char* other : {R"({"certificate_covers":"both"})", R"({"certificate_covers":7})", "{}", "[]", ""})
    CHECK(covers(other) == CertificateCovers::kNotStated);
  for (const CertificateCovers each :
       {CertificateCovers::kNotStated, CertificateCovers::kChain, CertificateCovers::kTransducer}) {
    const ChainPart stated = chain_part(each, 0.1, true, "k"), unknown = chain_part(each, 0.0, false, "k");
    CHECK((stated.missing.empty() && stated.from.empty()));
    CHECK_FALSE(unknown.missing.empty());
    const ChainPart open = chain_part(each, 0.0, true, "k");
    CHECK(open.missing.empty() == (each == CertificateCovers::kChain));
    CHECK(open.from.empty() == (each != CertificateCovers::kChain));
  }
}
