// Which quantities of a report are traceable, and which instruments page 1 warns about.
#include "analysis/report/data/traceability.h"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

using namespace tactbench;
using namespace tactbench::analysis;

namespace {

db::DeviceRecord instrument(const char* role, const char* model, const char* serial, const char* calibration) {
  return {role, model, serial, "", "hardware", calibration};
}

ReportInput run_of_may() {
  ReportInput input;
  input.run.started_utc = "2024-05-06T07:08:09Z";
  input.evaluation.levels.resize(1);
  return input;
}

}  // namespace

TEST_CASE("traceability: pressure needs a separate reference with a certificate that is not overdue") {
  ReportInput input = run_of_may();
  const auto traceable = [&](const char* calibration) {
    input.run.devices = {instrument("regulator", "VPPM", "R-1", "{}"),
                         instrument("pressure reference", "PT", "P-1", calibration)};
    const std::vector<Traceability> all = traceability_of(input, {});
    REQUIRE(all.size() == 1);
    return all[0].traceable;
  };
  CHECK(traceable(R"({"certificate":"C-1","due":"2024-05-06"})"));
  CHECK_FALSE(traceable(R"({"certificate":"C-1","due":"2024-05-05"})"));
  CHECK(instrument_warnings(input).size() == 1);  // overdue
  CHECK_FALSE(traceable("{}"));
  CHECK(traceable(R"({"certificate":"C-1"})"));
  CHECK(instrument_warnings(input).empty());
  // Neither is it by the regulator entered twice, or alone.
  input.run.devices[0] = instrument("regulator", "PT", "P-1", "{}");
  CHECK_FALSE(traceability_of(input, {})[0].traceable);
  input.run.devices.pop_back();
  CHECK_FALSE(traceability_of(input, {})[0].traceable);
}

TEST_CASE("traceability: a press run states force and place, and pressure if it was evaluated") {
  ReportInput input = run_of_may();
  const auto quantities = [&] {
    std::string words;
    for (const auto& one : nlohmann::json::parse(traceability_json(input)))
      words += one["quantity"].get<std::string>() + (one["traceable"] == true ? "+ " : "- ");
    return words;
  };
  input.history.presses = true;
  CHECK(quantities() == "pressure- force- position- ");
  input.evaluation.levels.clear();
  input.run.devices = {instrument("stage x", "", "", R"({"certificate":"S-1"})"),
                       instrument("force sensor", "ATI", "FT-1", R"({"certificate":""})")};
  CHECK(quantities() == "force- position+ ");
  input.laboratory.instruments = {{"FT-1", "F-7", "ATI", "2024-01-31", "2025-01-31", ""}};
  CHECK(quantities() == "force+ position+ ");
}
