// Numbers that a rig is driven by lie in a stated range, which the refusal of a number far outside names. The others'
// stand in docs/reference-keys.md alone.
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "tests/bench/config/bench_text.h"

using namespace tactbench;
using tests::Changes;

namespace {

struct Range {
  const char *key, *range;
};

const std::string kSimulated = tests::bench_text("simulated");

void check_ranges(const Changes& before, const std::string& table, const std::vector<Range>& ranges) {
  for (const Range& range : ranges) {
    INFO(table << range.key);
    Changes changes = before;
    changes.push_back({table + range.key, "1e300"});
    CHECK_THAT(tests::refusal_of(kSimulated, changes).remedy, Catch::EndsWith(std::string(" ") + range.range));
  }
}

}  // namespace

TEST_CASE("a bench file's ranges: limits, dead-man, settling") {
  REQUIRE(tests::bench_accepts(kSimulated, {}));
  check_ranges({}, "limits.",
               {{"command_psi", "1 to 100"},
                {"trip_psi", "60 to 110"},
                {"safe_psi", "0.1 to 1"},
                {"disagreement_psi", "0.1 to 50"},
                {"disagreement_s", "0.2 to 60"},
                {"vent_timeout_s", "1 to 120"},
                {"rate_psi_per_s", "0.01 to 200"},
                {"step_psi", "0.01 to 100"},
                {"stale_s", "0.1 to 10"},
                {"contact_n", "0.05 to 5"},
                {"clear_z_mm", "0 to 1000"}});
  CHECK(tests::bench_accepts(kSimulated, {{"limits.force_n", "[1e-9, 5, 100]"}}));
  for (const char* no_limit : {"[5, 5]", "[5, 5, 35, 35]", "[0, 5, 35]", "[5, 0, 35]", "[5, 5, 100.1]"})
    CHECK_FALSE(tests::bench_accepts(kSimulated, {{"limits.force_n", no_limit}}));
  check_ranges({}, "dead_man.",
               {{"timeout_ms", "100 to 5000"}, {"progress_ms", "250 to 30000"}, {"back_off_mm", "0 to 50"}});
  check_ranges({}, "settling.",
               {{"band_psi", "0.01 to 5"},
                {"slope_psi_per_s", "0.01 to 100"},
                {"poll_s", "0.01 to 0.5"},
                {"trace_s", "0.05 to 10"},
                {"landing_s", "0 to 10"},
                {"timeout_s", "1 to 600"}});
  check_ranges({{"bench.simulator", "external"}}, "bench.", {{"rate", "0.1 to 100"}});
}

TEST_CASE("a bench file's ranges: modules, regulator, reference") {
  check_ranges({}, "module.",
               {{"watchdog_ms", "500 to 60000"},
                {"outputs", "1 to 64"},
                {"inputs", "1 to 60"},
                {"port", "0 to 65535"},
                {"unit", "0 to 255"},
                {"response_timeout_ms", "10 to 10000"},
                {"dump_coil", "-1 to 65535"}});
  check_ranges(
      {{"module.transport", "rtu"}}, "module.",
      {{"baud", "110 to 921600"}, {"stop_bits", "1 to 2"}, {"unit", "1 to 247"}, {"max_reply_delay_ms", "1 to 60000"}});
  check_ranges({{"input_module.profile", "beckhoff-ek9000"}}, "input_module.", {{"unit", "0 to 247"}});
  check_ranges({}, "regulator.",
               {{"output_channel", "0 to 63"}, {"feedback_channel", "0 to 63"}, {"feed_interval_ms", "50 to 500"}});
  check_ranges({}, "reference.",
               {{"channel", "0 to 63"},
                {"expanded_uncertainty_psi", "0 to 10"},
                {"drift_psi", "0 to 10"},
                {"resolution_psi", "0 to 10"}});
}

TEST_CASE("a bench file's ranges: stage and force") {
  check_ranges({}, "stage.",
               {{"reply_timeout_ms", "20 to 10000"},
                {"poll_interval_ms", "20 to 1000"},
                {"expanded_uncertainty_mm", "0 to 10"}});
  for (const char* axis : {"stage.x.", "stage.y.", "stage.z."})
    check_ranges({}, axis,
                 {{"device", "1 to 254"},
                  {"device_id", "1 to 99999"},
                  {"low_mm", "0 to 1000"},
                  {"high_mm", "0 to 1000"},
                  {"maximum_speed_mm_per_s", "0.001 to 30"},
                  {"home_timeout_s", "1 to 600"}});
  check_ranges({}, "force.",
               {{"expanded_uncertainty_n", "0 to 10"},
                {"overload_share", "0.05 to 1"},
                {"records_per_reading", "1 to 1000"},
                {"port", "0 to 65535"},
                {"http_port", "0 to 65535"},
                {"reply_timeout_ms", "10 to 10000"}});
}
