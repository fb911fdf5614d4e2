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
  CHECK(refusal(hardware_text, {{"bench.simulator", "external"}}) != "accepted");
  CHECK(refusal(hardware_text, {{"bench.rate", "2"}}) != "accepted");
  CHECK(refused({{"bench.rate", "2"}}) != "accepted");
  CHECK(refused({{"module.watchdog_ms", "500"}, {"regulator.feed_interval_ms", "301"}}) != "accepted");
  CHECK(refused({{"module.watchdog_ms", "500"}, {"regulator.feed_interval_ms", "300"}}) == "accepted");
  CHECK(refused({{"module.profile", "generic"}, {"regulator.feed_interval_ms", "500"}}) == "accepted");
  CHECK(refused({{"module.profile", "generic"}, {"module.watchdog_ms", "1000"}}) != "accepted");
  CHECK(refused({{"module.transport", "rtu"}}) != "accepted");
  CHECK(refused({{"module.profile", "waveshare-analog-output-8ch-b"}}) != "accepted");
  CHECK(refused({{"module.profile", "moxa-iologik-e1240"}}) != "accepted");
  CHECK(refused({{"module.profile", "moxa-iologik-e1241"}}) != "accepted");
  const Changes both{{"module.profile", "moxa-iologik-e1241"}, {"input_module.profile", "moxa-iologik-e1240"}};
  CHECK(refused(both) != "accepted");
  Changes other = both;
  other.push_back({"input_module.unit", "2"});
  CHECK(refused(other) == "accepted");
  CHECK(parse_bench(simulated_text, "b.toml", other).input_module->same_line);
  other.back() = {"input_module.host", "10.0.0.9"};
  CHECK_FALSE(parse_bench(simulated_text, "b.toml", other).input_module->same_line);
  CHECK(refused({{"input_module.profile", "moxa-iologik-e1241"}, {"input_module.unit", "2"}}) != "accepted");
  for (const char* key : {"serial_port", "baud", "parity", "stop_bits", "max_reply_delay_ms"})
    CHECK(refused({{std::string("module.") + key, "1"}}) != "accepted");
  CHECK(refusal(hardware_text, {{"module.transport", "rtu"}}) != "accepted");
  CHECK(refusal(hardware_text, {{"module.transport", "rtu"}, {"module.serial_port", "\"\""}}) != "accepted");
  CHECK(refusal(hardware_text, {{"force.kind", "digital"}}) != "accepted");
  CHECK(refusal(hardware_text, {{"force.kind", "digital"}, {"force.usb_serial", "A1"}}) == "accepted");
  CHECK(refusal(hardware_text, {{"force.kind", "digital"}, {"force.port", "/dev/ttyUSB1"}}) == "accepted");
  CHECK(refusal(hardware_text, {{"stage.x.device", "1"}}) != "accepted");
  CHECK(refusal(hardware_text, {{"stage.usb_serial", "A1"}}) == "accepted");
  CHECK(refusal(hardware_text, {{"scanner.kind", "frame-source"}}) != "accepted");
  CHECK(refusal(hardware_text,
                {{"force.kind", "daq"}, {"force.calibration_file", "f"}, {"force.tool.rotation_deg", "[1, 2]"}}) !=
        "accepted");
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
  CHECK(config.reference.span.high.value() == config.regulator.feedback_span.high.value());
  CHECK(refusal(dependent, {{"reference.gauge.unit", "2"}}) != "accepted");
  const Changes gauge{{"reference.gauge.unit", "2"}, {"reference.gauge.address", "7"}};
  const auto with = [](Changes changes, const char* key, const char* value) {
    changes.push_back({key, value});
    return changes;
  };
  for (const auto& [key, value] :
       {std::pair{"reference.channel", "2"}, {"reference.span_v", "[0, 5]"}, {"reference.span_psi", "[0, 50]"}})
    CHECK(refused(with(gauge, key, value)) != "accepted");
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
  CHECK(refused(correction("[30, 30]", "[0.1, 0.2]", "[0.05, 0.05]")) != "accepted");
  CHECK(refused(correction("[0, 30, 29]", "[0, 0, 0]", "[1, 1, 1]")) != "accepted");
  CHECK(refused(correction("[0, 30]", "[0.1]", "[0.05, 0.05]")) != "accepted");
  CHECK(refused(correction("[0, 30]", "[0.1, 0.2]", "[0.05]")) != "accepted");
  CHECK(refused(correction("[]", "[]", "[]")) != "accepted");
  CHECK(refused(with(correction("[0]", "[0]", "[0]"), "reference.correction_file", "f.toml")) != "accepted");
}
