// Which values a bench file may not combine, and which it may.
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "bench/config/config.h"
#include "tests/bench/config/bench_text.h"

using namespace tactbench;
using namespace tactbench::bench;
using tests::bench_accepts;
using tests::bench_text;
using tests::Changes;
using tests::simulated_bench;

namespace {

Changes with_change(Changes changes, const char* key, const char* value) {
  changes.push_back({key, value});
  return changes;
}

void check_refused_where_accepted(const std::string& text, const std::vector<Changes>& refused,
                                  const std::vector<Changes>& accepted) {
  for (const Changes& changes : refused) {
    INFO(changes.back().key << " = " << changes.back().value);
    CHECK_FALSE(bench_accepts(text, changes));
  }
  for (const Changes& changes : accepted) {
    INFO(changes.back().key << " = " << changes.back().value);
    CHECK(bench_accepts(text, changes));
  }
}

}  // namespace

TEST_CASE("a bench file's tables are refused where they contradict each other") {
  const Changes both{{"module.profile", "moxa-iologik-e1241"}, {"input_module.profile", "moxa-iologik-e1240"}};
  std::vector<Changes> refused = {{{"bench.rate", "2"}},
                                  {{"module.watchdog_ms", "500"}, {"regulator.feed_interval_ms", "301"}},
                                  {{"module.profile", "generic"}, {"module.watchdog_ms", "1000"}},
                                  {{"module.transport", "rtu"}},
                                  {{"module.profile", "waveshare-analog-output-8ch-b"}},
                                  {{"module.profile", "moxa-iologik-e1240"}},
                                  {{"module.profile", "moxa-iologik-e1241"}},
                                  both,
                                  {{"input_module.profile", "moxa-iologik-e1241"}, {"input_module.unit", "2"}}};
  for (const char* key : {"serial_port", "baud", "parity", "stop_bits", "max_reply_delay_ms"})
    refused.push_back({{std::string("module.") + key, "1"}});
  const Changes unit = with_change(both, "input_module.unit", "2");
  check_refused_where_accepted(bench_text("simulated"), refused,
                               {{{"module.watchdog_ms", "500"}, {"regulator.feed_interval_ms", "300"}},
                                {{"module.profile", "generic"}, {"regulator.feed_interval_ms", "500"}},
                                unit});
  CHECK(simulated_bench(unit).input_module->same_line);
  CHECK_FALSE(simulated_bench(with_change(both, "input_module.host", "10.0.0.9")).input_module->same_line);
  check_refused_where_accepted(
      bench_text("hardware"),
      {{{"bench.simulator", "external"}},
       {{"bench.rate", "2"}},
       {{"module.transport", "rtu"}},
       {{"module.transport", "rtu"}, {"module.serial_port", "\"\""}},
       {{"force.kind", "digital"}},
       {{"stage.x.device", "1"}},
       {{"scanner.kind", "frame-source"}},
       {{"force.kind", "daq"}, {"force.calibration_file", "f"}, {"force.tool.rotation_deg", "[1, 2]"}}},
      {{{"force.kind", "digital"}, {"force.usb_serial", "A1"}},
       {{"force.kind", "digital"}, {"force.port", "/dev/ttyUSB1"}},
       {{"stage.usb_serial", "A1"}}});
}

TEST_CASE("a reference without a transducer, with a gauge, and with a correction") {
  const std::string text = bench_text("simulated");
  std::string dependent = text;
  dependent.erase(dependent.find("model = \"m\""));
  dependent += "independent = false\n";
  const BenchConfig config = parse_bench(dependent, "b.toml", {{"regulator.feedback_channel", "1"}});
  CHECK_FALSE(config.reference_independent);
  CHECK(config.reference.channel == 1);
  CHECK(config.reference.serial == "R");
  CHECK(config.reference.span.high.value() == config.regulator.feedback_span.high.value());
  CHECK_FALSE(bench_accepts(dependent, {{"reference.gauge.unit", "2"}}));
  const Changes gauge{{"reference.gauge.unit", "2"}, {"reference.gauge.address", "7"}};
  CHECK_FALSE(simulated_bench(gauge).reference_gauge->own_line);
  CHECK(simulated_bench(gauge).reference_gauge->endpoint.unit == 2);
  CHECK(simulated_bench(with_change(gauge, "reference.gauge.port", "5020")).reference_gauge->own_line);
  CHECK(simulated_bench(with_change(gauge, "reference.gauge.host", "10.0.0.1")).reference_gauge->own_line);
  const auto correction = [](const char* reading, const char* added, const char* uncertainty) {
    return Changes{{"reference.correction.reading_psi", reading},
                   {"reference.correction.correction_psi", added},
                   {"reference.correction.expanded_uncertainty_psi", uncertainty}};
  };
  check_refused_where_accepted(text,
                               {with_change(gauge, "reference.channel", "2"),
                                with_change(gauge, "reference.span_v", "[0, 5]"),
                                with_change(gauge, "reference.span_psi", "[0, 50]"),
                                correction("[30, 30]", "[0.1, 0.2]", "[0.05, 0.05]"),
                                correction("[0, 30, 29]", "[0, 0, 0]", "[1, 1, 1]"),
                                correction("[0, 30]", "[0.1]", "[0.05, 0.05]"),
                                correction("[0, 10, 20]", "[0, 45, 0]", "[1, 1, 1]"),
                                correction("[0, 10]", "[0, -10]", "[1, 1]"),
                                {{"reference.certificate_range_psi", "[40, 0]"}},
                                correction("[0, 30]", "[0.1, 0.2]", "[0.05]"),
                                correction("[]", "[]", "[]"),
                                with_change(correction("[0]", "[0]", "[0]"), "reference.correction_file", "f.toml")},
                               {correction("[0, 30]", "[0.1, 0.2]", "[0.05, 0.05]")});
}
