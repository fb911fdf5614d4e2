// The regulator behind its module joins the table of actuator laws; tests of its further promises.
#include <atomic>
#include <catch2/catch.hpp>
#include <cmath>

#include "devices/pressure/regulator.h"
#include "devices/pressure/simulated_module.h"
#include "tests/devices/actuator_contract.h"
#include "tests/devices/test_chamber.h"
#include "tests/devices/timeouts.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;

namespace {

struct RegulatorBed final : ActuatorBed {
  RegulatorBed(const BedOptions& options, const std::string& profile)
      : known(module_profile(profile)),
        server(new_server(0)),
        module(known, {"127.0.0.1", server->port(), 1, options.reply_timeout}, watchdog(), time, Origin::kSimulated),
        regulator(module, module, regulator_options(), time) {}
  static RegulatorOptions regulator_options() {
    RegulatorOptions options;
    options.command_span.high = options.feedback_span.high = Psi(9.0 * kPsiPerBar);
    return options;
  }

  Regulator& actuator() override { return regulator; }
  ManualClock& clock() override { return time; }
  [[nodiscard]] std::string faults_begin_with() const override { return "TB-CHAMBER"; }
  void make_ready() override { regulator.arm(); }
  std::vector<Act> commands() override {
    return {[&] { regulator.command(Psi(20.0)); }, [&] { regulator.command(Psi(0.0)); }};
  }
  std::vector<Act> forbidden() override {
    std::vector<Act> all;
    for (const double psi : {60.0001, -0.0001, std::nan(""), HUGE_VAL, -HUGE_VAL})
      all.emplace_back([this, psi] { regulator.command(Psi(psi)); });
    return all;
  }
  void load() override { regulator.command(Psi(50.0)); }
  [[nodiscard]] bool make_safe() noexcept override { return regulator.vent(); }
  bool is_in_safe_state() override { return chamber.output() == Volts(0.0); }
  [[nodiscard]] std::uint64_t received() const override { return requests; }
  [[nodiscard]] std::uint64_t driven() const override { return static_cast<std::uint64_t>(chamber.drives); }
  void fall_silent() override { silent = true; }
  void break_wire() override {
    last_port = server->port();
    server.reset();
  }
  // On the same port; the output terminal keeps what it had.
  void mend_wire() override { server = new_server(last_port); }
  [[nodiscard]] int questions() const override { return 1; }
  [[nodiscard]] int questions_to_make_safe() const override { return 4; }  // two attempts of two

  [[nodiscard]] Nanoseconds watchdog() const { return known.fail_safe.watchdog_address >= 0 ? 1000ms : 0ms; }
  std::unique_ptr<SimulatedModule> new_server(int port) {
    SimulatedModuleFaults faults;
    faults.inject = [this] {
      ++requests;
      return silent ? InjectedFault::kSilent : InjectedFault::kNone;
    };
    return std::make_unique<SimulatedModule>(known, port, chamber, time, faults);
  }

  ModuleProfile known;
  ManualClock time;
  std::atomic<std::uint64_t> requests{0};
  std::atomic<bool> silent{false};
  int last_port = 0;
  TestChamber chamber{time};
  std::unique_ptr<SimulatedModule> server;
  AnalogModule module;
  Regulator regulator;
};

const char* const kProfiles[] = {"beckhoff-ek9000", "advantech-adam-6024", "generic"};
const JoinsActuatorLaws<Regulator, RegulatorBed> kBeckhoff("regulator, watchdog and FC 23", kProfiles[0]),
    kAdvantech("regulator, single words", kProfiles[1]), kGeneric("regulator, plain module", kProfiles[2]);

}  // namespace

TEST_CASE("regulator: reads without feeding while it is not armed") {
  for (const char* profile : kProfiles) {
    INFO(profile);
    RegulatorBed bed({}, profile);
    bed.clock().wait_until(10s);
    bed.regulator.keep_alive();
    (void)bed.regulator.feedback();
    CHECK(bed.received() > 0);
    CHECK(bed.chamber.drives == 0);
  }
}

TEST_CASE("regulator: after a restored connection and arming, the first feed writes 0 V") {
  for (const char* profile : kProfiles) {
    INFO(profile);
    RegulatorBed bed({}, profile);
    bed.regulator.arm();
    bed.regulator.command(Psi(50.0));
    REQUIRE(bed.chamber.output() > Volts(3.8));
    bed.break_wire();
    bed.mend_wire();
    bed.clock().wait_until(500ms);
    CHECK(fault_id_of([&] { bed.regulator.keep_alive(); }) != "none");
    CHECK_FALSE(bed.regulator.armed());
    const int drives = bed.chamber.drives;
    bed.regulator.keep_alive();
    (void)bed.regulator.feedback();
    CHECK(bed.chamber.drives == drives);
    bed.regulator.arm();
    bed.regulator.keep_alive();
    CHECK(bed.chamber.output() == Volts(0.0));
  }
}

TEST_CASE("module: arming takes a channel out of safe mode, and the next command takes effect") {
  ManualClock clock;
  TestChamber chamber(clock);
  const ModuleProfile outputs = module_profile("moxa-iologik-e1241");
  const ModuleProfile inputs = module_profile("moxa-iologik-e1240");
  SimulatedUnit out{1, outputs, {}, true};
  SimulatedModule server({out, {2, inputs, {}}}, SimulatedModule::Wire::kTcp, 0, chamber, clock);
  AnalogModule output(outputs, {"127.0.0.1", server.port(), 1, kPatient}, 0s, clock, Origin::kSimulated);
  AnalogModule input(inputs, output, 2, clock, Origin::kSimulated);
  Regulator regulator(output, input, RegulatorBed::regulator_options(), clock);
  CHECK(fault_id_of([&] { output.write(0, 100); }) == "TB-MODULE-READBACK");  // safe mode ignores it
  regulator.arm();
  regulator.command(Psi(30.0));
  CHECK(regulator.feedback().pressure.value() == Approx(30.0).margin(0.05));
}
