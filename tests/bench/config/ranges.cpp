// Every number of a bench file lies in a stated range: the refusal of a number far outside names the range.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "tests/bench/config/bench_text.h"

using namespace tactbench;
using tests::Changes;

namespace {

struct Range {
  const char *key, *remedy;
};

const std::string kSimulated = tests::bench_text("simulated");
const std::string kHardware = tests::bench_text("hardware") + "[scanner]\nkind = \"daqmx\"\n";

std::string remedy_of(const std::string& text, const Changes& changes) {
  return tests::refusal_of(text, changes).remedy;
}

void check(const std::string& text, const Changes& before, const std::string& table, const std::vector<Range>& ranges) {
  for (const Range& range : ranges) {
    INFO(table << range.key);
    Changes changes = before;
    changes.push_back({table + range.key, "1e300"});
    CHECK(remedy_of(text, changes) == std::string("use ") + range.remedy);
  }
}

// The same of a key in a list of one table, beside `rest`.
void check_in_list(const std::string& list, const std::string& rest, const std::vector<Range>& ranges) {
  for (const Range& range : ranges) {
    INFO(list << ' ' << range.key);
    const std::string value = fmt::format("[{{{}, {} = -1e300}}]", rest, range.key);
    CHECK(remedy_of(kSimulated, {{list, value}}) == std::string("use ") + range.remedy);
  }
}

}  // namespace

TEST_CASE("a bench file's ranges: limits, dead-man, settling") {
  REQUIRE(remedy_of(kSimulated, {}) == "accepted");
  REQUIRE(remedy_of(kHardware, {}) == "accepted");
  check(kSimulated, {}, "limits.",
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
  CHECK(remedy_of(kSimulated, {{"limits.force_n", "[1e-9, 5, 100]"}}) == "accepted");
  for (const char* no_limit : {"[5, 5]", "[5, 5, 35, 35]", "[0, 5, 35]", "[5, 0, 35]", "[5, 5, 100.1]"})
    CHECK(remedy_of(kSimulated, {{"limits.force_n", no_limit}}) == "write [fx, fy, fz] in N");
  check(kSimulated, {}, "dead_man.",
        {{"timeout_ms", "100 to 5000"}, {"progress_ms", "250 to 30000"}, {"back_off_mm", "0 to 50"}});
  check(kSimulated, {}, "settling.",
        {{"band_psi", "0.01 to 5"},
         {"slope_psi_per_s", "0.01 to 100"},
         {"poll_s", "0.01 to 0.5"},
         {"trace_s", "0 for none, or 0.05 to 10"},
         {"landing_s", "0 to 10"},
         {"timeout_s", "1 to 600"}});
  check(kSimulated, {{"bench.simulator", "external"}}, "bench.", {{"rate", "0.1 to 100"}});
}

TEST_CASE("a bench file's ranges: modules, regulator, reference, environment") {
  check(kSimulated, {}, "module.",
        {{"watchdog_ms", "500 to 60000"},
         {"outputs", "a whole number from 1 to 64"},
         {"inputs", "a whole number from 1 to 60"},
         {"port", "a whole number from 0 to 65535"},
         {"unit", "a whole number from 0 to 255"},
         {"response_timeout_ms", "10 to 10000"},
         {"dump_coil", "a whole number from -1 to 65535"}});
  check(kSimulated, {{"module.transport", "rtu"}}, "module.",
        {{"baud", "a whole number from 110 to 921600"},
         {"stop_bits", "a whole number from 1 to 2"},
         {"unit", "a whole number from 1 to 247"},
         {"max_reply_delay_ms", "1 to 60000"}});
  check(kSimulated, {{"input_module.profile", "beckhoff-ek9000"}}, "input_module.",
        {{"unit", "a whole number from 0 to 247"}});
  check(kSimulated, {}, "regulator.",
        {{"output_channel", "a whole number from 0 to 63"},
         {"feedback_channel", "a whole number from 0 to 63"},
         {"feed_interval_ms", "50 to 500"}});
  check(kSimulated, {}, "reference.",
        {{"channel", "a whole number from 0 to 63"},
         {"expanded_uncertainty_psi", "0 to 10"},
         {"drift_psi", "0 to 10"},
         {"resolution_psi", "0 to 10"}});
  const Changes corrected{{"reference.correction.reading_psi", "[0]"},
                          {"reference.correction.correction_psi", "[0]"},
                          {"reference.correction.expanded_uncertainty_psi", "[0]"}};
  REQUIRE(remedy_of(kSimulated, corrected) == "accepted");
  check(kSimulated, corrected, "reference.correction.", {{"coverage_factor", "1 to 4"}});
  check(kSimulated, {{"reference.gauge.unit", "2"}, {"reference.gauge.address", "0"}}, "reference.gauge.",
        {{"unit", "a whole number from 1 to 247"},
         {"function", "a whole number from 3 to 4"},
         {"address", "a whole number from 0 to 65535"},
         {"spare", "a whole number from 0 to 8"}});
  check_in_list("environment.sensor", "quantity = 'supply_bar', unit = 2",
                {{"address", "a whole number from 0 to 65535"}});
}

TEST_CASE("a bench file's ranges: scanner") {
  check(kSimulated, {}, "scanner.",
        {{"rows", "a whole number from 1 to 64"},
         {"columns", "a whole number from 16 to 16"},
         {"frame_timeout_ms", "10 to 10000"},
         {"scans_per_frame", "a whole number from 1 to 8"},
         {"vendor_id", "a whole number from 0 to 65535"},
         {"product_id", "a whole number from 0 to 65535"}});
  check(kHardware, {}, "scanner.",
        {{"columns", "a whole number from 1 to 64"},
         {"range_v", "0.1 to 10"},
         {"sample_rate_hz", "1 to 1e+06"},
         {"convert_rate_hz", "0 for none, or 1 to 1.25e+06"},
         {"samples_per_row", "a whole number from 1 to 10000"},
         {"settle_ms", "0 to 1000"}});
}

TEST_CASE("a bench file's ranges: stage and force") {
  check(kSimulated, {}, "stage.",
        {{"reply_timeout_ms", "20 to 10000"},
         {"poll_interval_ms", "20 to 1000"},
         {"expanded_uncertainty_mm", "0 to 10"}});
  for (const char* axis : {"stage.x.", "stage.y.", "stage.z."})
    check(kSimulated, {}, axis,
          {{"device", "a whole number from 1 to 254"},
           {"device_id", "a whole number from 1 to 99999"},
           {"low_mm", "0 to 1000"},
           {"high_mm", "0 to 1000"},
           {"maximum_speed_mm_per_s", "0.001 to 30"},
           {"home_timeout_s", "1 to 600"}});
  check(kSimulated, {}, "force.",
        {{"expanded_uncertainty_n", "0 to 10"},
         {"overload_share", "0.05 to 1"},
         {"records_per_reading", "a whole number from 1 to 1000"},
         {"port", "a whole number from 0 to 65535"},
         {"http_port", "a whole number from 0 to 65535"},
         {"reply_timeout_ms", "10 to 10000"}});
  check(kSimulated, {{"force.kind", "digital"}}, "force.",
        {{"baud", "a whole number from 9600 to 3000000"},
         {"unit", "a whole number from 1 to 247"},
         {"samples_per_second", "1 to 20000"}});
  check(kHardware, {{"force.kind", "daq"}, {"force.calibration_file", "f.cal"}}, "force.",
        {{"range_v", "0.1 to 10"}, {"sample_rate_hz", "1 to 1e+06"}});
}

TEST_CASE("a bench file's ranges: the simulated plant") {
  check(kSimulated, {}, "simulation.",
        {{"seed", "a whole number from 0 to 9007199254740992"},
         {"sensor_seed", "a whole number from 0 to 9007199254740992"},
         {"mount_seed", "a whole number from 0 to 9007199254740992"},
         {"temperature_c", "-20 to 80"},
         {"age_months", "0 to 1200"},
         {"turned_in_chamber_deg", "-360 to 360"},
         {"edge_outside_lines", "a whole number from 0 to 1024"},
         {"supply_bar", "0 to 20"},
         {"frame_source_port", "a whole number from 0 to 65535"}});
  check(kSimulated, {}, "simulation.chamber.",
        {{"reference_span_psi", "1 to 1000"},
         {"time_constant_s", "0.01 to 10"},
         {"damping", "0.2 to 5"},
         {"slew_psi_per_s", "1 to 1000"},
         {"resolution_v", "0 to 0.1"},
         {"hysteresis_share", "0 to 0.05"},
         {"leak_psi_per_s", "0 to 50"},
         {"dump_psi_per_s", "1 to 10000"},
         {"reference_noise_psi", "0 to 1"},
         {"feedback_noise_psi", "0 to 1"}});
  check(kSimulated, {}, "simulation.front_end.",
        {{"noise_v", "0 to 1"}, {"relay_settle_s", "0 to 1"}, {"relay_time_constant_s", "0 to 1"}});
  check(kSimulated, {}, "simulation.wire_faults.",
        {{"module_silent_after_requests", "a whole number from -1 to 1000000000"},
         {"module_dead_after_requests", "a whole number from -1 to 1000000000"},
         {"scanner_silent_after_scans", "a whole number from -1 to 1000000000"},
         {"scanner_corrupt_scan", "a whole number from -1 to 1000000000"},
         {"scanner_drop_report_scan", "a whole number from -1 to 1000000000"},
         {"scanner_unplug_after_scans", "a whole number from -1 to 1000000000"}});
  check_in_list("simulation.faults", "kind = 'leak'",
                {{"at_s", "0 to 1e+08"},
                 {"at_psi", "0 to 1000"},
                 {"at_n", "0 to 1000"},
                 {"lasts_s", "0 to inf"},
                 {"value", "-1000 to 1000"},
                 {"times", "a whole number from 0 to 1000000000"}});
}

TEST_CASE("a bench file's ranges: the simulated sensor and what presses on it") {
  check(kSimulated, {{"simulation.contact.outer_diameter_mm", "8"}}, "simulation.contact.",
        {{"inner_diameter_mm", "0 to 7.9"}});
  check(kSimulated, {}, "simulation.contact.",
        {{"outer_diameter_mm", "0.1 to 200"},
         {"point_diameter_mm", "0 to 200"},
         {"surface_z_mm", "0 to 1000"},
         {"stiffness_n_per_mm", "0.1 to 1000"},
         {"stiffening_n_per_mm2", "0 to 10000"},
         {"friction_share", "0 to 0.5"},
         {"relaxation_share", "0 to 0.5"},
         {"relaxation_s", "0.01 to 1000"},
         {"backlash_mm", "0 to 1"},
         {"fabric_spread_mm", "0.05 to 20"},
         {"pitch_mm", "0.1 to 100"},
         {"centre_x_mm", "-1000 to 1000"},
         {"centre_y_mm", "-1000 to 1000"},
         {"misplaced_x_mm", "-100 to 100"},
         {"misplaced_y_mm", "-100 to 100"},
         {"misplaced_deg", "-180 to 180"},
         {"force_noise_n", "0 to 1"},
         {"torque_noise_nmm", "0 to 10"}});
  check(kSimulated, {}, "simulation.effects.",
        {{"row_crosstalk", "0 to 0.5"},
         {"column_crosstalk", "0 to 0.5"},
         {"temperature_coefficient", "-0.05 to 0.05"},
         {"lift_off_psi", "0 to 5"},
         {"chamber_nonuniformity", "-0.5 to 0.5"},
         {"chamber_tilt", "-0.5 to 0.5"},
         {"chamber_tilt_deg", "-360 to 360"},
         {"zero_drift_v_per_month", "-0.5 to 0.5"},
         {"gain_drift_per_month", "0 to 0.5"},
         {"gain_drift_per_thousand_cycles", "-0.5 to 0.5"},
         {"remount_variation", "0 to 0.5"}});
  check_in_list("simulation.defect", "kind = 'dead', column = 1", {{"row", "a whole number from 0 to 15"}});
  check_in_list("simulation.defect", "kind = 'dead', row = 1", {{"column", "a whole number from 0 to 15"}});
  check_in_list("simulation.defect", "kind = 'swapped', row = 1, column = 1, other_column = 1",
                {{"other_row", "a whole number from 0 to 15"}});
  check_in_list("simulation.defect", "kind = 'swapped', row = 1, column = 1, other_row = 1",
                {{"other_column", "a whole number from 0 to 15"}});
}
