// Which values a bench file may not combine, and which it may.
#include <catch2/catch.hpp>
#include <string>

#include "bench/config/config.h"
#include "tests/bench/config/bench_text.h"

using namespace tactbench;
using namespace tactbench::bench;
using tests::bench_text;
using tests::Changes;
using tests::simulated_bench;

namespace {

std::string refusal(const std::string& text, const Changes& changes) { return tests::refusal_of(text, changes).what; }

}  // namespace

TEST_CASE("a bench file's tables are refused where they contradict each other") {
  const std::string simulated_text = bench_text("simulated"), hardware_text = bench_text("hardware");
  const auto refused = [&](const Changes& changes) { return refusal(simulated_text, changes); };
  CHECK_THAT(refusal(hardware_text, {{"bench.simulator", "external"}}), Catch::Contains("has no simulator"));
  CHECK_THAT(refusal(hardware_text, {{"bench.rate", "2"}}), Catch::Contains("unknown key"));
  CHECK_THAT(refused({{"bench.rate", "2"}}), Catch::Contains("unknown key"));
  CHECK_THAT(refused({{"module.watchdog_ms", "500"}, {"regulator.feed_interval_ms", "301"}}),
             Catch::Contains("every 301 ms is too slow for a watchdog of 500 ms"));
  CHECK(refused({{"module.watchdog_ms", "500"}, {"regulator.feed_interval_ms", "300"}}) == "accepted");
  CHECK(refused({{"module.profile", "generic"}, {"regulator.feed_interval_ms", "500"}}) == "accepted");
  CHECK_THAT(refused({{"module.profile", "generic"}, {"module.watchdog_ms", "1000"}}),
             Catch::Contains("no watchdog that can be set"));
  CHECK_THAT(refused({{"module.transport", "rtu"}}), Catch::Contains("does not support Modbus RTU"));
  CHECK_THAT(refused({{"module.profile", "waveshare-analog-output-8ch-b"}}),
             Catch::Contains("does not support Modbus TCP"));
  CHECK_THAT(refused({{"module.profile", "moxa-iologik-e1240"}}), Catch::Contains("has no outputs"));
  CHECK_THAT(refused({{"module.profile", "moxa-iologik-e1241"}}), Catch::Contains("has no inputs to read"));
  const Changes both{{"module.profile", "moxa-iologik-e1241"}, {"input_module.profile", "moxa-iologik-e1240"}};
  CHECK_THAT(refused(both), Catch::Contains("'unit' is missing"));
  Changes other = both;
  other.push_back({"input_module.unit", "2"});
  CHECK(refused(other) == "accepted");
  CHECK(parse_bench(simulated_text, "b.toml", other).input_module->same_line);
  other.back() = {"input_module.host", "10.0.0.9"};
  CHECK_FALSE(parse_bench(simulated_text, "b.toml", other).input_module->same_line);
  CHECK_THAT(refused({{"input_module.profile", "moxa-iologik-e1241"}, {"input_module.unit", "2"}}),
             Catch::Contains("has no inputs"));
  for (const char* key : {"serial_port", "baud", "parity", "stop_bits", "max_reply_delay_ms"})
    CHECK_THAT(refused({{std::string("module.") + key, "1"}}), Catch::Contains("belongs to a serial line"));
  CHECK_THAT(refusal(hardware_text, {{"module.transport", "rtu"}}), Catch::Contains("'serial_port' is missing"));
  CHECK_THAT(refusal(hardware_text, {{"module.transport", "rtu"}, {"module.serial_port", "\"\""}}),
             Catch::Contains("no serial port is named"));
  CHECK_THAT(refusal(hardware_text, {{"force.kind", "digital"}}), Catch::Contains("no serial port is named"));
  CHECK(refusal(hardware_text, {{"force.kind", "digital"}, {"force.usb_serial", "A1"}}) == "accepted");
  CHECK(refusal(hardware_text, {{"force.kind", "digital"}, {"force.port", "/dev/ttyUSB1"}}) == "accepted");
  CHECK_THAT(refusal(hardware_text, {{"stage.x.device", "1"}}), Catch::Contains("'port' is missing"));
  CHECK(refusal(hardware_text, {{"stage.usb_serial", "A1"}}) == "accepted");
  CHECK_THAT(refusal(hardware_text, {{"scanner.kind", "frame-source"}}),
             Catch::Contains("is not the address of a frame source"));
  CHECK_THAT(refusal(hardware_text,
                     {{"force.kind", "daq"}, {"force.calibration_file", "f"}, {"force.tool.rotation_deg", "[1, 2]"}}),
             Catch::Contains("must hold three numbers"));
}

TEST_CASE("a reference without a transducer, with a gauge, and with a correction") {
  const std::string text = bench_text("simulated");
  const auto refused = [&](const Changes& changes) { return refusal(text, changes); };
  std::string dependent = text;
  dependent.erase(dependent.find("model = \"m\""));
  dependent += "independent = false\n";
  const BenchConfig config = parse_bench(dependent, "b.toml", {{"regulator.feedback_channel", "1"}});
  CHECK_FALSE(config.reference_independent);
  CHECK(config.reference.channel == 1);
  CHECK(config.reference.serial == "R");
  CHECK(config.reference.model == "Pneumax 171E2N.T.D.0009 (feedback)");
  CHECK(config.reference.span.high.value() == config.regulator.feedback_span.high.value());
  CHECK_THAT(refusal(dependent, {{"reference.gauge.unit", "2"}}),
             Catch::Contains("a gauge is an independent reference"));
  const Changes gauge{{"reference.gauge.unit", "2"}, {"reference.gauge.address", "7"}};
  const auto with = [](Changes changes, const char* key, const char* value) {
    changes.push_back({key, value});
    return changes;
  };
  for (const auto& [key, value] :
       {std::pair{"reference.channel", "2"}, {"reference.span_v", "[0, 5]"}, {"reference.span_psi", "[0, 50]"}})
    CHECK_THAT(refused(with(gauge, key, value)), Catch::Contains("a gauge reads pressure directly"));
  CHECK_FALSE(simulated_bench(gauge).reference_gauge->own_line);
  CHECK(simulated_bench(gauge).reference_gauge->endpoint.unit == 2);
  CHECK(simulated_bench(with(gauge, "reference.gauge.port", "5020")).reference_gauge->own_line);
  CHECK(simulated_bench(with(gauge, "reference.gauge.host", "10.0.0.1")).reference_gauge->own_line);
  const auto correction = [](const char* reading, const char* added, const char* uncertainty) {
    return Changes{{"reference.correction.reading_psi", reading},
                   {"reference.correction.correction_psi", added},
                   {"reference.correction.expanded_uncertainty_psi", uncertainty}};
  };
  CHECK(refused(correction("[0, 30]", "[0.1, 0.2]", "[0.05, 0.05]")) == "accepted");
  CHECK_THAT(refused(correction("[30, 30]", "[0.1, 0.2]", "[0.05, 0.05]")), Catch::Contains("do not rise"));
  CHECK_THAT(refused(correction("[0, 30, 29]", "[0, 0, 0]", "[1, 1, 1]")), Catch::Contains("do not rise"));
  CHECK_THAT(refused(correction("[0, 30]", "[0.1]", "[0.05, 0.05]")), Catch::Contains("differ in length"));
  CHECK_THAT(refused(correction("[0, 30]", "[0.1, 0.2]", "[0.05]")), Catch::Contains("differ in length"));
  CHECK_THAT(refused(correction("[]", "[]", "[]")), Catch::Contains("or are empty"));
  CHECK_THAT(refused(with(correction("[0]", "[0]", "[0]"), "reference.correction_file", "f.toml")),
             Catch::Contains("given twice"));
}
