// `devices check` and `devices watch` on the simulated rig, and the rows that a run keeps of its devices, as they were
// recorded: each reading, note and number.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <catch2/catch.hpp>

#include "bench/instruments/check.h"
#include "bench/instruments/watch.h"
#include "bench/rig/rig.h"
#include "bench/simulation/plant.h"
#include "devices/fault.h"
#include "tests/bench/cli/verb_here.h"
#include "tests/bench/run/recorded_run.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

using Changes = std::vector<sequences::Override>;

std::vector<std::string> page_of_check(const Changes& changes, const std::function<void(bench::Rig&)>& before = {},
                                       bool independent = true) {
  bench::BenchConfig config = small_request(changes).bench;
  config.reference_independent = independent;
  bench::Rig rig(config);
  if (before) before(rig);
  std::vector<std::string> lines;
  for (const bench::DeviceCheck& device : bench::check_devices(rig, "2026-06-01")) {
    std::string line =
        fmt::format("{} {}: {} | {}", to_string(device.state), device.role, device.found, device.reading);
    if (!device.notes.empty()) line += fmt::format(" | {}", fmt::join(device.notes, " | "));
    if (!device.remedy.empty()) line += " | to do: " + device.remedy;
    // Ports and paths differ.
    static const std::regex kWhere("[^ ]*/tactbench-[^/ ]+/[a-z]+|127.0.0.1:[0-9]+|/dev/pts/[0-9]+|after [0-9]+ ms");
    lines.push_back(std::regex_replace(line, kWhere, "..."));
  }
  return lines;
}

std::vector<std::string> page_of_watch(const Changes& changes, bool terminal, analysis::PressureUnit unit) {
  bench::WatchOptions options;
  options.interval_s = 0.01;
  options.count = 2;
  options.terminal = terminal;
  options.unit = unit;
  std::istringstream printed(printed_by([&] { bench::watch_devices(small_request(changes).bench, options); }));
  std::vector<std::string> lines;
  for (std::string line; std::getline(printed, line);) {
    if (const std::size_t end = line.find_last_not_of(' '); end != std::string::npos) line.erase(end + 1);
    if (line.starts_with("\x1b")) line = "ESC" + line.substr(1);
    lines.push_back("[" + line + "]");
  }
  return lines;
}

const std::string kSurroundings =
    "[{quantity = 'temperature_c', unit = 9, address = 7, type = 'i16', raw_span = [-1000, 1000], span_c = [-100, "
    "100], "
    "model = 'T 1', serial = '77'}, {quantity = 'supply_bar', unit = 9, address = 20, type = 'f32', model = 'P 2'}]";

}  // namespace

TEST_CASE("page of devices: all well, with the surroundings, line by line") {
  check_lines(page_of_check({{"environment.sensor", kSurroundings}, {"simulation.temperature_c", "25.5"}}), R"(
ok analog module: Beckhoff EK9000 + EL4xxx/EL3xxx (simulated) | outputs 0 counts | tactbench: every run ends vented, with proof of it; trip above 66 psi | Beckhoff EK9000 + EL4xxx/EL3xxx: coupler watchdog: outputs to 0 V when no write comes in time (set and read back at the start) | Beckhoff EK9000 + EL4xxx/EL3xxx: EL4xxx terminal watchdog: 0 V by default, 0x80n0:05, :13, :14 (neither set nor read by tactbench) | watchdog time 1000 ms, fed every 450 ms
ok regulator: Pneumax 171E2N.T.D.0009, serial SIM-REG-1 (simulated) | feedback 0.03 psi
ok pressure reference: simulated transducer, 100 psi, serial SIM-REF-1 (simulated) | -0.01 psi | certificate SIM-CERT-1 (invented for the simulation), no due date stated, U 0.05 psi (k = 2)
ok temperature_c sensor: T 1, serial 77 | 25.50
ok supply_bar sensor: P 2, serial not stated | 8.00
ok tactile scanner: tactbench HID scanner, serial SIM-SCANNER-1, firmware sim-1 (simulated) | 16 x 16 taxels, mean 0.020 V, highest 0.027 V
ok stage: x: id 60, firmware 5.23; y: id 60, firmware 5.23; z: id 5082, firmware 5.23 (simulated) | x 0 microsteps, 15.0 V; y 0 microsteps, 15.0 V; z 0 microsteps, 15.0 V | certificate SIM-CERT-3 (invented for the simulation), no due date stated, U 0.01 mm (k = 2)
ok force sensor: ATI Nano17, serial SIM-FT-1, firmware sim-1 (simulated), calibration SIM-FT-1 | F 0.001 0.001 0.000 N, T -0.00 0.01 -0.00 N mm | range +-25 25 35 N, +-250 250 250 N mm | certificate SIM-CERT-2 (invented for the simulation), no due date stated, U 0.05 N (k = 2)
)");
}

TEST_CASE("page of devices: a correction, an overdue stage, a chamber under pressure, line by line") {
  check_lines(page_of_check({{"reference.correction.reading_psi", "[0, 60]"},
                             {"reference.correction.correction_psi", "[0.5, 3.0]"},
                             {"reference.correction.expanded_uncertainty_psi", "[0.02, 0.05]"},
                             {"stage.due", "\"2026-05-31\""},
                             {"scanner.kind", "frame-source"},
                             {"force.kind", "digital"},
                             {"simulation.defect", "[{kind = 'saturated', row = 2, column = 5}]"}},
                            [](bench::Rig& rig) {
                              rig.plant()->inject(bench::FaultKind::kFeedbackOffset, 2.5, 0);
                              rig.plant()->inject(bench::FaultKind::kReferenceOffset, -3.0, 0);
                            }),
              R"(
ok analog module: Beckhoff EK9000 + EL4xxx/EL3xxx (simulated) | outputs 0 counts | tactbench: every run ends vented, with proof of it; trip above 66 psi | Beckhoff EK9000 + EL4xxx/EL3xxx: coupler watchdog: outputs to 0 V when no write comes in time (set and read back at the start) | Beckhoff EK9000 + EL4xxx/EL3xxx: EL4xxx terminal watchdog: 0 V by default, 0x80n0:05, :13, :14 (neither set nor read by tactbench) | watchdog time 1000 ms, fed every 450 ms
wrong regulator: Pneumax 171E2N.T.D.0009, serial SIM-REG-1 (simulated) | feedback 2.53 psi | not at zero: 2.53 psi by the monitor output (limit 1) | to do: vent the chamber; check span_v and span_bar, the monitor's wiring and the regulator's zero
wrong pressure reference: simulated transducer, 100 psi, serial SIM-REF-1 (simulated) | -2.51 psi | certificate SIM-CERT-1 (invented for the simulation), no due date stated, U at most 0.05 psi (k = 2), of its correction | correction +0.500 psi, U 0.020 psi (k = 2) at this reading | not at zero: -2.51 psi | to do: vent the chamber; check the transducer's span and zero
ok tactile scanner: tactbench simulated frame source, serial SIM-SCANNER-1, firmware sim-1 (simulated) | 16 x 16 taxels, mean 0.039 V, highest 4.994 V
warning stage: x: id 60, firmware 5.23; y: id 60, firmware 5.23; z: id 5082, firmware 5.23 (simulated) | x 0 microsteps, 15.0 V; y 0 microsteps, 15.0 V; z 0 microsteps, 15.0 V | certificate SIM-CERT-3 (invented for the simulation), OVERDUE since 2026-05-31, U 0.01 mm (k = 2) | to do: have it calibrated: results measured with it until then are inconclusive
ok force sensor: ATI Nano17, serial SIMFT2 (simulated), calibration SIMFT2 | F 0.005 0.007 0.005 N, T -0.02 -0.01 0.00 N mm | range +-25 25 35 N, +-250 250 250 N mm | certificate SIM-CERT-2 (invented for the simulation), no due date stated, U 0.05 N (k = 2)
)");
}

TEST_CASE("page of devices: no transducer, and instruments that are silent or damaged, line by line") {
  check_lines(page_of_check(
                  {{"scanner.frame_timeout_ms", "200"}},
                  [](bench::Rig& rig) {
                    rig.plant()->inject(bench::FaultKind::kScannerSilent, std::nullopt, 0);
                    rig.plant()->inject(bench::FaultKind::kModuleException, std::nullopt, 2);
                    rig.plant()->inject(bench::FaultKind::kStageSilent, std::nullopt, 0);
                  },
                  false),
              R"(
wrong analog module: Beckhoff EK9000 + EL4xxx/EL3xxx (simulated) |  | TB-MODBUS-EXCEPTION: reading 2 registers at 0x0000 (FC 4) of analog module at ... unit 1: refused with exception 4 (Slave device or server failure) | to do: Check that the profile in the bench file fits the module, that no other master holds it, and that its watchdog has not tripped.
wrong regulator: Pneumax 171E2N.T.D.0009, serial SIM-REG-1 (simulated) |  | TB-MODBUS-EXCEPTION: reading 2 registers at 0x0000 (FC 4) of analog module at ... unit 1: refused with exception 4 (Slave device or server failure) | to do: Check that the profile in the bench file fits the module, that no other master holds it, and that its watchdog has not tripped.
ok pressure reference: simulated transducer, 100 psi, serial SIM-REF-1 (simulated) | -0.01 psi | the regulator's feedback: pressure not independently traceable | certificate SIM-CERT-1 (invented for the simulation), no due date stated, U 0.05 psi (k = 2)
absent tactile scanner:  |  | TB-SCANNER-TIMEOUT: asking the identity of packet socket ...: no answer within 200 ms | to do: Check the scanner's power and cable, then start again.
absent stage:  (simulated) |  | axis x does not answer | axis y does not answer | axis z does not answer | certificate SIM-CERT-3 (invented for the simulation), no due date stated, U 0.01 mm (k = 2) | to do: check the daisy chain's cables and power, and [stage.x], [stage.y], [stage.z] device
ok force sensor: ATI Nano17, serial SIM-FT-1, firmware sim-1 (simulated), calibration SIM-FT-1 | F 0.001 0.001 0.000 N, T -0.00 0.01 -0.00 N mm | range +-25 25 35 N, +-250 250 250 N mm | certificate SIM-CERT-2 (invented for the simulation), no due date stated, U 0.05 N (k = 2)
)");
}

TEST_CASE("page of the watch: two looks without a terminal, line by line") {
  check_lines(page_of_watch({{"environment.sensor", kSurroundings}}, false, analysis::PressureUnit::kPsi), R"(
[time       0.00 s]
[feedback      0.028 psi]
[reference    -0.009 psi]
[temperature_c 23.00]
[supply_bar 8.00]
[stage      x 0.0000 mm, y 0.0000 mm, z 0.0000 mm]
[force         0.001    0.001    0.000 N]
[array      mean 0.020 V, highest 0.027 V, status 0x00]
[]
[time       0.01 s]
[feedback     -0.012 psi]
[reference    -0.018 psi]
[temperature_c 23.00]
[supply_bar 8.00]
[stage      x 0.0000 mm, y 0.0000 mm, z 0.0000 mm]
[force         0.000   -0.000    0.001 N]
[array      mean 0.020 V, highest 0.026 V, status 0x00]
[]
)");
}

TEST_CASE("page of the watch: on a terminal with the array's picture, line by line") {
  check_lines(
      page_of_watch({{"simulation.defect",
                      "[{kind = 'saturated', row = 2, column = 5}, {kind = 'stuck', row = 9, column = 1}, {kind = "
                      "'dead', row = 0, column = 0}, {kind = 'stuck', row = 9, column = 2}, {kind = 'stuck', row = "
                      "11, column = 3}, {kind = 'stuck', row = 12, column = 4}]"}},
                    true, analysis::PressureUnit::kKilopascal),
      R"(
[ESC[H[2Jsimulated-rig (simulated), every 0.01 s, Ctrl-C ends]
[time       0.00 s]
[feedback       0.19 kPa]
[reference     -0.06 kPa]
[stage      x 0.0000 mm, y 0.0000 mm, z 0.0000 mm]
[force         0.001    0.001    0.000 N]
[array      mean 0.067 V, highest 4.994 V, status 0x00]
[                                  ]
[                                  ]
[            ██]
[                                  ]
[                                  ]
[                                  ]
[                                  ]
[                                  ]
[                                  ]
[    ░░░░]
[                                  ]
[        ▒▒]
[          ▒▒]
[                                  ]
[                                  ]
[                                  ]
[]
[ESC[H[2Jsimulated-rig (simulated), every 0.01 s, Ctrl-C ends]
[time       0.01 s]
[feedback      -0.08 kPa]
[reference     -0.13 kPa]
[stage      x 0.0000 mm, y 0.0000 mm, z 0.0000 mm]
[force         0.000   -0.000    0.001 N]
[array      mean 0.067 V, highest 4.995 V, status 0x00]
[                                  ]
[                                  ]
[            ██]
[                                  ]
[                                  ]
[                                  ]
[                                  ]
[                                  ]
[                                  ]
[    ░░░░]
[                                  ]
[        ▒▒]
[          ▒▒]
[                                  ]
[                                  ]
[                                  ]
[]
)");
}
