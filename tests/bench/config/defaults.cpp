// Defaults of a bench file, and what each kind of instrument and each unit in a key is read as.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <map>
#include <string>
#include <utility>

#include "bench/config/config.h"
#include "tests/bench/config/bench_text.h"

using namespace tactbench;
using namespace tactbench::bench;
using namespace std::chrono_literals;
using tests::bench_text;
using tests::Changes;
using tests::hardware_bench;
using tests::simulated_bench;

TEST_CASE("a bench file's defaults: limits, dead-man, settling, module, regulator, reference") {
  const BenchConfig config = simulated_bench();
  std::map<std::string, std::string> taken;
  for (const sequences::Setting& setting : config.settings)
    if (setting.origin == "default") taken[setting.key] = setting.value;
  const std::pair<const char*, const char*> safety[] = {
      {"limits.command_psi", "60"},     {"limits.trip_psi", "66"},      {"limits.safe_psi", "1"},
      {"limits.disagreement_psi", "5"}, {"limits.disagreement_s", "1"}, {"limits.vent_timeout_s", "20"},
      {"limits.rate_psi_per_s", "20"},  {"limits.step_psi", "2.5"},     {"limits.stale_s", "1"},
      {"limits.contact_n", "0.5"},      {"limits.clear_z_mm", "25"},    {"dead_man.enabled", "true"},
      {"dead_man.back_off_mm", "5"},    {"dead_man.blind", "\"end\""},  {"module.dump_coil", "-1"},
      {"settling.band_psi", "0.25"},    {"settling.timeout_s", "20"},   {"reference.independent", "true"}};
  for (const auto& [key, value] : safety) {
    INFO(key);
    CHECK(taken[key] == value);
  }
  CHECK(config.limits.force_n == std::array<double, 3>{5.0, 5.0, 35.0});
  CHECK(config.dead_man.timeout_s == 0.4);
  CHECK(config.dead_man.progress_s == 1.5);
  CHECK(config.watchdog_s == 1.0);
  CHECK(config.regulator.feed_interval == 450ms);
  CHECK(config.reference.span.high.value() == 100.0);
}

TEST_CASE("a bench file's defaults: the simulated plant") {
  const BenchConfig config = simulated_bench();
  CHECK(config.simulation->plant.chamber.span_psi == Approx(130.534).epsilon(1e-5));
  const BenchConfig faulty =
      simulated_bench({{"simulation.faults", "[{kind = 'leak'}, {kind = 'row_stuck', at_psi = 0}]"}});
  const auto& faults = faulty.simulation->plant.faults;
  REQUIRE(faults.size() == 2);
  CHECK(faults[0].kind == FaultKind::kLeak);
  CHECK_FALSE((faults[0].at_s || faults[0].at_psi || faults[0].at_n || faults[0].value));
  CHECK(faults[0].times == 0);
  CHECK(faults[0].lasts_s > 1e300);
  CHECK(faults[1].kind == FaultKind::kRowStuck);
  CHECK(faults[1].at_psi == 0.0);
}

TEST_CASE("a bench file's words for the simulated sensor: turns, edges, objects, defects") {
  const auto specimen = [](const Changes& changes) { return simulated_bench(changes).simulation->plant.specimen; };
  CHECK(specimen({{"simulation.mount_turn", "turned-90"}}).mount_turn == MountTurn::kBy90);
  CHECK(specimen({{"simulation.edge_outside", "first-column"}}).edge_outside == MountEdge::kFirstColumn);
  const Changes narrow{{"scanner.rows", "8"}, {"simulation.mount_turn", "turned-90"}};
  CHECK_FALSE(tests::bench_accepts(bench_text("simulated"), narrow));
  CHECK(specimen({{"scanner.rows", "8"}}).rows == 8);
  CHECK(simulated_bench({{"simulation.contact.object", "flat"}}).simulation->plant.contact.object == Footprint::kFlat);
  const char* const kinds[] = {"dead", "stuck", "saturated", "noisy"};
  for (int i = 0; i < 4; ++i) {
    const auto defects =
        specimen({{"simulation.defect", fmt::format("[{{kind = '{}', row = 3, column = 15}}]", kinds[i])}}).defects;
    REQUIRE(defects.size() == 1);
    CHECK(static_cast<int>(defects[0].kind) == i);
    CHECK(defects[0].row == 3);
    CHECK(defects[0].column == 15);
  }
  const auto swapped =
      specimen({{"simulation.defect", "[{kind = 'swapped', row = 0, column = 1, other_row = 2, other_column = 3}]"}});
  CHECK(swapped.defects[0].kind == TaxelDefect::Kind::kSwapped);
  CHECK(swapped.defects[0].other_row == 2);
  CHECK(swapped.defects[0].other_column == 3);
}

TEST_CASE("milliseconds, bar and counts of a bench file become what the devices take") {
  const BenchConfig config = simulated_bench({{"dead_man.timeout_ms", "200"},
                                              {"dead_man.progress_ms", "750"},
                                              {"module.response_timeout_ms", "250"},
                                              {"module.watchdog_ms", "2000"},
                                              {"regulator.feed_interval_ms", "300"},
                                              {"regulator.span_bar", "[0, 2]"},
                                              {"scanner.frame_timeout_ms", "120"},
                                              {"stage.reply_timeout_ms", "50"},
                                              {"stage.poll_interval_ms", "60"},
                                              {"stage.y.home_timeout_s", "2.5"},
                                              {"force.reply_timeout_ms", "70"}});
  CHECK(config.dead_man.timeout_s == 0.2);
  CHECK(config.dead_man.progress_s == 0.75);
  CHECK(config.module.endpoint.response_timeout == 250ms);
  CHECK(config.watchdog_s == 2.0);
  CHECK(config.regulator.feed_interval == 300ms);
  CHECK(config.regulator.command_span.high.value() == Approx(29.00755));  // 1 bar is 14.503774 psi
  CHECK(config.regulator.feedback_span.high.value() == Approx(29.00755));
  CHECK(config.scanner.frame_timeout == 120ms);
  CHECK(config.stage->options.reply_timeout == 50ms);
  CHECK(config.stage->options.poll_interval == 60ms);
  CHECK(config.stage->options.axes[1].home_timeout == 2500ms);
  CHECK(config.force->net.reply_timeout == 70ms);
  const BenchConfig line = simulated_bench({{"module.profile", "generic"},
                                            {"module.transport", "rtu"},
                                            {"module.max_reply_delay_ms", "40"},
                                            {"module.parity", "E"},
                                            {"module.stop_bits", "2"}});
  CHECK(line.module.endpoint.max_reply_delay == 40ms);
  CHECK(line.module.endpoint.parity == 'E');
  CHECK(line.module.endpoint.stop_bits == 2);
  CHECK(line.watchdog_s == 0.0);
  const BenchConfig card = hardware_bench({{"scanner.kind", "daqmx"}, {"scanner.settle_ms", "7"}});
  CHECK(card.daqmx_scanner.settle == 7ms);
  CHECK(card.daqmx_scanner.timeout == 500ms);
}

TEST_CASE("kinds of instruments and terminals are taken by their words") {
  CHECK(simulated_bench({{"scanner.kind", "frame-source"}}).scanner_kind == ScannerKind::kFrameSource);
  CHECK(simulated_bench().scanner_kind == ScannerKind::kHid);
  const auto terminal = [](const char* word) {
    return hardware_bench({{"scanner.kind", "daqmx"}, {"scanner.terminal", word}}).daqmx_scanner.terminal;
  };
  CHECK(terminal("rse") == devices::DaqmxTerminal::kRse);
  CHECK(terminal("nrse") == devices::DaqmxTerminal::kNrse);
  CHECK(terminal("differential") == devices::DaqmxTerminal::kDifferential);
  CHECK(simulated_bench({{"force.kind", "net"}}).force->kind == ForceKind::kNet);
  CHECK(simulated_bench({{"force.kind", "digital"}}).force->kind == ForceKind::kDigital);
  CHECK(simulated_bench({{"force.kind", "digital"}, {"force.parity", "O"}}).force->address.parity == 'O');
  const BenchConfig daq = hardware_bench({{"force.kind", "daq"},
                                          {"force.calibration_file", "f.cal"},
                                          {"force.range_v", "5"},
                                          {"force.tool.displacement_mm", "[1, 2, 3]"}});
  CHECK(daq.force->kind == ForceKind::kDaq);
  CHECK(daq.force->daq.tool.displacement_mm == std::array<double, 3>{1, 2, 3});
  CHECK(daq.force->daq.tool.rotation_deg == std::array<double, 3>{0, 0, 0});
  CHECK(daq.force->daq.converter_limit.value() == 5.0);
  const auto type = [](const char* word) {
    return simulated_bench(
               {{"reference.gauge.unit", "2"}, {"reference.gauge.address", "0"}, {"reference.gauge.type", word}})
        .reference_gauge->quantity.format.type;
  };
  CHECK(type("i16") == devices::RegisterType::kI16);
  CHECK(type("f32") == devices::RegisterType::kF32);
  const BenchConfig external = simulated_bench({{"bench.simulator", "external"}, {"bench.rate", "10"}});
  CHECK_FALSE(external.in_process);
  CHECK_FALSE(external.simulation);
  CHECK(external.rate == 10.0);
  CHECK(simulated_bench({{"bench.simulator", "in-process"}}).in_process);
}
