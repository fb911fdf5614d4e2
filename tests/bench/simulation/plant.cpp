#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "bench/simulation/plant.h"
#include "devices/tactile/scan_report.h"
#include "tests/bench/simulation/small_plant.h"

namespace tactbench::bench {
namespace {

using devices::Nanoseconds;
using devices::Volts;
using namespace std::chrono_literals;

constexpr Nanoseconds kForever = Nanoseconds::max();

Volts plant_volts_for(double psi) { return Volts(psi / ChamberOptions().span_psi * 10.0); }
double psi_of_reference(Volts volts) { return volts.value() / 10.0 * ChamberOptions().reference_span_psi; }
double psi_of_feedback(Volts volts) { return volts.value() / 10.0 * ChamberOptions().span_psi; }

struct Scan {
  std::array<std::uint16_t, 256> counts{};
  std::array<std::uint8_t, 16> status{};
};

Scan scan(Plant& plant) {
  Scan result;
  plant.scan(result.counts, result.status);
  return result;
}

double mean_volts(const Scan& scan, const ScannerFrontEnd& front = {}) {
  double sum = 0.0;
  for (const auto count : scan.counts) sum += count * front.volts_per_count;
  return sum / 256.0;
}

struct PlantRig {
  // NOLINTNEXTLINE(clang-analyzer-optin*): it loses sight of the copied options
  explicit PlantRig(const PlantOptions& options = PlantOptions()) : plant(options, clock) {}
  void wait(Nanoseconds time) { clock.wait_until(clock.now() + time); }
  void hold(double psi, Nanoseconds time) {
    plant.drive(plant_volts_for(psi), kForever, Volts(0.0));
    wait(time);
  }
  devices::ManualClock clock;
  Plant plant;
};

}  // namespace

TEST_CASE("plant: pressure, feedback and reference follow the command") {
  PlantRig rig;
  CHECK(rig.plant.true_pressure().value() == 0.0);
  rig.hold(30.0, 3s);
  const double truth = rig.plant.true_pressure().value();
  CHECK(truth == Approx(30.0).margin(0.25));
  CHECK(psi_of_reference(rig.plant.reference()) == Approx(truth).margin(0.05));
  CHECK(psi_of_feedback(rig.plant.feedback()) == Approx(30.0).margin(0.11));
  CHECK(psi_of_reference(rig.plant.reference()) != psi_of_reference(rig.plant.reference()));  // noise
}

TEST_CASE("plant: noise of both transducers is as configured") {
  PlantOptions options;
  PlantRig rig(options);
  rig.hold(40.0, 5s);
  const double truth = rig.plant.true_pressure().value();
  double reference = 0.0;
  double feedback = 0.0;
  constexpr int kReadings = 4000;
  for (int i = 0; i < kReadings; ++i) {
    reference += std::pow(psi_of_reference(rig.plant.reference()) - truth, 2);
    feedback += psi_of_feedback(rig.plant.feedback());
  }
  CHECK(std::sqrt(reference / kReadings) == Approx(options.chamber.reference_noise_psi).epsilon(0.05));
  CHECK(feedback / kReadings == Approx(40.0).margin(0.02));
}

TEST_CASE("plant: the watchdog fallback acts at its own time, whatever the query times are") {
  const auto pressure_after = [](Nanoseconds hold, bool ask_often) {
    PlantRig rig;
    rig.plant.drive(plant_volts_for(20.0), hold, plant_volts_for(0.0));
    for (int i = 0; i < 300; ++i) {
      rig.wait(10ms);
      if (ask_often) static_cast<void>(rig.plant.true_pressure());
    }
    return rig.plant.true_pressure().value();
  };
  CHECK(pressure_after(kForever, false) == Approx(20.0).margin(0.25));
  CHECK(pressure_after(1s, false) == Approx(0.0).margin(1e-3));
  // The limit itself counts, not the grid: read while the pressure still falls.
  const double early = pressure_after(2900ms, false);
  const double late = pressure_after(2903ms, false);
  CHECK(early > 0.5);
  CHECK(late > early + 0.05);
  CHECK(pressure_after(2907ms, false) > late + 0.05);  // within one cell of the grid
  CHECK(pressure_after(2903ms, true) == late);
}

TEST_CASE("plant: a command with an expired watchdog time applies the fallback at once") {
  PlantRig rig;
  rig.hold(20.0, 3s);
  rig.plant.drive(plant_volts_for(40.0), rig.clock.now() - 1ms, plant_volts_for(0.0));
  rig.wait(3s);
  CHECK(rig.plant.true_pressure().value() == Approx(0.0).margin(1e-6));
}

TEST_CASE("plant: neither feeding the watchdog nor queries change the plant") {
  const auto run = [](bool feed, bool ask) {
    PlantRig rig;
    rig.clock.wait_until(1234567ns);
    for (const double level : {10.0, 40.0, 24.0, 26.0}) {
      rig.plant.drive(plant_volts_for(level), kForever, Volts(0.0));
      for (int i = 0; i < 9; ++i) {
        rig.wait(287654321ns);
        if (feed) rig.plant.drive(plant_volts_for(level), kForever, Volts(0.0));
        if (ask) {
          static_cast<void>(rig.plant.true_pressure());
          static_cast<void>(rig.plant.feedback());
          static_cast<void>(rig.plant.specimen_state());
        }
      }
    }
    return std::pair{scan(rig.plant).counts, rig.plant.specimen_state()};
  };
  const auto quiet = run(false, false);
  CHECK(run(true, false) == quiet);
  CHECK(run(true, true) == quiet);
}

TEST_CASE("plant: equal seeds give equal scans, another noise seed changes only the noise") {
  const auto run = [](std::uint64_t seed, std::uint64_t sensor) {
    PlantOptions options;
    options.seed = seed;
    options.specimen.sensor_seed = sensor;
    PlantRig rig(options);
    rig.hold(25.0, 3s);
    return scan(rig.plant).counts;
  };
  const auto one = run(1, 1);
  CHECK(run(1, 1) == one);
  const auto other_noise = run(2, 1);
  CHECK(other_noise != one);
  const auto other_sensor = run(1, 2);
  double noise = 0.0;
  double sensor = 0.0;
  for (std::size_t i = 0; i < 256; ++i) {
    noise += std::pow(one[i] - other_noise[i], 2) / 256;
    sensor += std::pow(one[i] - other_sensor[i], 2) / 256;
  }
  const ScannerFrontEnd front;
  CHECK(std::sqrt(noise / 2) * front.volts_per_count == Approx(front.noise_v).epsilon(0.15));
  CHECK(std::sqrt(sensor) > 50 * std::sqrt(noise));
}

TEST_CASE("plant: a relay with too little settling time mixes in the row before") {
  const auto at_settle = [](double settle_s) {
    PlantOptions options;
    options.scanner.noise_v = 0.0;
    options.scanner.relay_settle_s = settle_s;
    PlantRig rig(options);
    rig.hold(25.0, 3s);
    return scan(rig.plant);
  };
  const Scan settled = at_settle(1.0);
  const Scan shipped = at_settle(ScannerFrontEnd().relay_settle_s);
  const Scan hasty = at_settle(0.0006);  // one time constant: 1/e is left
  for (std::size_t r = 0; r < 16; ++r) {
    CHECK(shipped.status[r] == 0);
    CHECK(hasty.status[r] == devices::kStatusNotSettled);
    for (std::size_t c = 0; c < 16; ++c) {
      const double own = settled.counts[r * 16 + c];
      const double before = settled.counts[(r + 15) % 16 * 16 + c];
      REQUIRE(hasty.counts[r * 16 + c] == Approx(own + std::exp(-1.0) * (before - own)).margin(1.5));
      REQUIRE(shipped.counts[r * 16 + c] == Approx(own).margin(0.002 * 65535));
    }
  }
}

TEST_CASE("plant: no healthy taxel is at a converter limit, unloaded or at 60 psi") {
  PlantRig rig;
  for (const double level : {0.0, 60.0, 0.0}) {
    rig.hold(level, 5s);
    for (int k = 0; k < 10; ++k) {
      for (const auto status : scan(rig.plant).status) REQUIRE(status == 0);
    }
  }
}

TEST_CASE("plant: the counts of a noisy taxel are noisy") {
  PlantOptions options;
  options.specimen.defects = {{TaxelDefect::Kind::kNoisy, 9, 9}};
  PlantRig rig(options);
  rig.hold(30.0, 3s);
  double squares = 0.0;
  const double first = scan(rig.plant).counts[9 * 16 + 9];
  for (int k = 0; k < 200; ++k) squares += std::pow(scan(rig.plant).counts[9 * 16 + 9] - first, 2) / 200;
  CHECK(std::sqrt(squares) * options.scanner.volts_per_count > 0.03);
}

TEST_CASE("plant: the state of the specimen can be moved from one plant to another") {
  PlantRig first;
  first.hold(60.0, 3s);
  first.hold(0.0, 3s);
  const std::string state = first.plant.specimen_state();
  PlantRig second;
  second.plant.set_specimen_state(state);
  CHECK(second.plant.specimen_state() == state);
  PlantRig fresh;
  second.hold(20.0, 3s);
  fresh.hold(20.0, 3s);
  CHECK(std::abs(mean_volts(scan(second.plant)) - mean_volts(scan(fresh.plant))) > 0.01);  // conditioned against new
  CHECK_THROWS_AS(second.plant.set_specimen_state("{}"), std::invalid_argument);
}

TEST_CASE("plant: the fixed grid agrees with a fine one over a sweep") {
  // A sweep 0-60-0 in 2 psi steps of 2.4 s; the same film moved at each 10 ms is the truth of the cutting.
  PlantRig rig;
  Specimen fine({});
  Chamber chamber({});
  double worst = 0.0;
  for (int step = 1; step <= 60; ++step) {
    const double level = step <= 30 ? 2.0 * step : 120.0 - 2.0 * step;
    rig.hold(level, 2400ms);
    const double coarse = mean_volts(scan(rig.plant));
    chamber.command(plant_volts_for(level));
    for (int i = 0; i < 240; ++i) {
      chamber.advance(0.01);
      fine.advance(chamber.pressure().value(), 0.01);
    }
    std::vector<double> volts(256);
    fine.output(volts);
    double mean = 0.0;
    for (const double v : volts) mean += v / 256;
    worst = std::max(worst, std::abs(mean - coarse));
  }
  CHECK(worst < 0.002);
}

}  // namespace tactbench::bench

// How an object under the stage comes to the plant, in numbers of another implementation, and what a scan's status
// says.

using namespace tactbench;
using namespace tactbench::bench;
using namespace tactbench::tests;
using namespace std::chrono_literals;

namespace {

Approx digits(double value) { return Approx(value).epsilon(1e-10); }

// Down to 30.5 mm, a hold, back to 30.25 mm, sideways at 20 s, and off at 30 s.
ScriptedStage::Place scripted(double time_s) {
  const double z_mm = time_s < 2.0    ? 29.9 + 0.3 * time_s
                      : time_s < 3.0  ? 30.5
                      : time_s < 4.0  ? 30.5 - 0.25 * (time_s - 3.0)
                      : time_s < 30.0 ? 30.25
                                      : 29.5;
  return time_s < 20.0 ? ScriptedStage::Place{30.0, 30.0, z_mm} : ScriptedStage::Place{31.0, 29.5, z_mm};
}

void point(PlantOptions& options) { options.contact.object = Footprint::kPoint; }

}  // namespace

TEST_CASE("plant coupling: force of an object and its pressure on each taxel") {
  ScriptedStage stage(scripted);
  SmallPlant bed(point);
  bed.plant.set_stage(&stage);
  CHECK(bed.plant.true_contact_psi().empty());
  for (const auto& [time, force_n] : {std::pair{400ms, 0.419823745976}, std::pair{1000ms, 4.548079856896},
                                      std::pair{2500ms, 12.761986495513}, std::pair{3700ms, 7.183409193033}}) {
    bed.at(time);
    CHECK(bed.plant.true_force().value() == digits(force_n));
  }
  bed.at(3705ms);  // between two cells of the grid
  CHECK(bed.plant.true_force().value() == digits(7.151452023985));
  CHECK(bed.plant.wrench().force_n[2] == digits(-7.151452023985 - 0.0017756322253430473));
  bed.at(25s);
  const std::vector<double> psi = bed.plant.true_contact_psi();
  const std::vector<double> expected = {0.123309293, 54.023194766, 32.31250117,
                                        0.039153792, 20.522767047, 12.052383919};
  REQUIRE(psi.size() == 6);
  for (std::size_t k = 0; k < 6; ++k) CHECK(psi[k] == Approx(expected[k]).epsilon(0.0).margin(2e-9));
  bed.at(31s);
  CHECK(bed.plant.true_force().value() == 0.0);
  CHECK(bed.plant.true_contact_psi().empty());
}

TEST_CASE("plant coupling: a stage at rest in the air is not queried, a removed one no longer presses") {
  ScriptedStage stage([](double) { return ScriptedStage::Place{30.0, 30.0, 29.0}; });
  SmallPlant bed(point);
  bed.plant.set_stage(&stage);
  bed.at(1s);
  (void)bed.plant.true_pressure();
  CHECK(stage.asked == 100);  // it was not placed before: each cell
  stage.rests = true;
  bed.at(2s);
  (void)bed.plant.true_pressure();
  CHECK(stage.asked == 100);
  stage.rests = false;
  stage.where = [](double) { return ScriptedStage::Place{30.0, 30.0, 30.4}; };
  bed.at(3s);
  CHECK(bed.plant.true_force().value() > 1.0);
  CHECK(stage.asked == 200);
  stage.rests = true;  // in contact it is still queried
  bed.at(4s);
  (void)bed.plant.true_pressure();
  CHECK(stage.asked == 300);
  bed.plant.forget_stage();
  bed.at(5s);
  (void)bed.plant.true_pressure();
  CHECK(stage.asked == 300);
  bed.plant.set_stage(nullptr);
  CHECK(bed.plant.true_force().value() == 0.0);
}

TEST_CASE("plant coupling: scan status marks rows that have not settled, and counts at the converter limits") {
  SmallPlant slow([](PlantOptions& options) { options.scanner.relay_settle_s = 0.002; });
  slow.drive(2.0);
  slow.at(13ms);
  slow.drive(3.0);
  slow.at(420ms);
  (void)slow.scan();
  CHECK(slow.status == std::vector<std::uint8_t>{devices::kStatusNotSettled, devices::kStatusNotSettled});
  // exp(-settle / 0.6 ms) is a hundredth at 2.763 ms.
  for (const auto& [settle_s, told] : {std::pair{0.002764, false}, std::pair{0.002762, true}}) {
    SmallPlant edge([settle = settle_s](PlantOptions& options) { options.scanner.relay_settle_s = settle; });
    (void)edge.scan();
    CHECK((edge.status[0] == devices::kStatusNotSettled) == told);
  }
  SmallPlant instant([](PlantOptions& options) { options.scanner.relay_time_constant_s = 0.0; });
  (void)instant.scan();
  CHECK(instant.status == std::vector<std::uint8_t>{0, 0});
  SmallPlant ends([](PlantOptions& options) {
    options.scanner.noise_v = 0.0;
    options.scanner.relay_time_constant_s = 0.0;
    options.specimen.defects = {{TaxelDefect::Kind::kDead, 0, 2, 0, 0}, {TaxelDefect::Kind::kSaturated, 1, 0, 0, 0}};
  });
  const std::vector<int> counts = ends.scan();
  CHECK((counts[2] == 0 && counts[3] == 65535));
  CHECK(ends.status == std::vector<std::uint8_t>{devices::kStatusAtLimit, devices::kStatusAtLimit});
  std::vector<std::uint16_t> wrong(5);
  CHECK_THROWS_AS(ends.plant.scan(wrong, ends.status), std::invalid_argument);
  wrong.resize(6);
  ends.status.resize(3);
  CHECK_THROWS_AS(ends.plant.scan(wrong, ends.status), std::invalid_argument);
}

TEST_CASE("plant coupling: a stuck row beyond the array means its last row") {
  SmallPlant bed;
  bed.drive(2.0);
  bed.at(3s);
  bed.plant.inject(FaultKind::kRowStuck, 77.0);
  const std::vector<int> last = bed.scan();
  bed.drive(4.0);
  bed.at(60s);
  const std::vector<int> later = bed.scan();
  CHECK(std::equal(last.begin() + 3, last.end(), later.begin() + 3));
  CHECK(last[0] != later[0]);
}

// Each question and each change brings the plant up to its time first: whoever has looked before changes nothing.

namespace {

// From 10 psi on.
std::function<void(PlantOptions&)> with_fault(FaultKind kind) {
  return [kind](PlantOptions& options) {
    PlannedFault fault;
    fault.kind = kind;
    fault.at_psi = 10.0;
    options.faults = {fault};
  };
}

}  // namespace

TEST_CASE("plant queries: a fault that waits for a load starts even if nobody queried the pressure") {
  SmallPlant module(with_fault(FaultKind::kModuleException)), supply(with_fault(FaultKind::kSupplyLost));
  SmallPlant monitor(with_fault(FaultKind::kRegulatorUnpowered)), reference(with_fault(FaultKind::kReferenceOffset));
  for (SmallPlant* bed : {&module, &supply, &monitor, &reference}) {
    bed->drive(2.0);
    bed->at(3s);
  }
  CHECK(module.plant.injected(Instrument::kModule) == devices::InjectedFault::kRefused);
  CHECK(supply.plant.supply_bar() == 0.0);
  CHECK(monitor.plant.feedback().value() == 0.0);
  CHECK(reference.plant.reference_pressure().value() > 30.0);  // 26 psi, and 10
  SmallPlant below(with_fault(FaultKind::kModuleException));
  below.drive(0.5);
  below.at(3s);
  CHECK(below.plant.injected(Instrument::kModule) == devices::InjectedFault::kNone);
}

TEST_CASE("plant queries: clearing ends a fault that has started meanwhile, and keeps one that has not") {
  for (const bool begun : {true, false}) {
    SmallPlant bed(with_fault(FaultKind::kSupplyLost));
    bed.drive(begun ? 2.0 : 0.5);
    bed.at(3s);
    bed.plant.clear(FaultKind::kSupplyLost);
    bed.drive(2.0);
    bed.at(8s);
    CHECK(bed.plant.supply_bar() == (begun ? 8.0 : 0.0));
  }
}

TEST_CASE("plant queries: a query before a change does not affect the result") {
  // Events at 257 ms, between two cells of the grid.
  ScriptedStage stage([](double) { return ScriptedStage::Place{30.0, 30.0, 30.3}; });
  const std::vector<std::pair<std::string, std::function<void(SmallPlant&)>>> changes = {
      {"a stage is set", [&](SmallPlant& bed) { bed.plant.set_stage(&stage); }},
      {"a fault begins", [](SmallPlant& bed) { bed.plant.inject(FaultKind::kLeak, 4.0); }},
      {"a command", [](SmallPlant& bed) { bed.drive(1.0); }},
      {"a command with a limit",
       [](SmallPlant& bed) { bed.plant.drive(devices::Volts(3.0), 391ms, devices::Volts(0.5)); }},
      {"the dump valve opens, and closes",
       [](SmallPlant& bed) {
         bed.plant.dump(true);
         bed.at(304ms);
         bed.plant.dump(false);
       }},
      {"another memory of the film",
       [](SmallPlant& bed) { bed.plant.set_specimen_state(SmallPlant().plant.specimen_state()); }},
  };
  for (const auto& [what, change] : changes) {
    INFO(what);
    SmallPlant looked, unseen;
    for (SmallPlant* bed : {&looked, &unseen}) {
      bed->drive(3.0);
      bed->at(257ms);
      if (bed == &looked) {
        (void)bed->plant.true_pressure();
        (void)bed->plant.true_force();
        (void)bed->plant.true_output();
        (void)bed->plant.specimen_state();
      }
      change(*bed);
      bed->at(777ms);
    }
    CHECK(looked.plant.true_pressure().value() == unseen.plant.true_pressure().value());
    CHECK(looked.plant.true_force().value() == unseen.plant.true_force().value());
    CHECK(looked.plant.true_output() == unseen.plant.true_output());
    CHECK(looked.plant.specimen_state() == unseen.plant.specimen_state());
  }
}

TEST_CASE("plant queries: each returns the present value, not the last queried one") {
  const auto bed_at = [](devices::Nanoseconds time) {
    auto bed = std::make_unique<SmallPlant>();
    bed->drive(3.0);
    bed->at(time);
    return bed;
  };
  CHECK(bed_at(1s)->plant.true_pressure().value() > 20.0);
  CHECK(bed_at(1s)->plant.reference_pressure().value() > 20.0);
  CHECK(bed_at(1s)->plant.reference().value() > 2.0);
  CHECK(bed_at(1s)->plant.feedback().value() > 1.5);
  CHECK(bed_at(1s)->plant.true_output()[0] > bed_at(10ms)->plant.true_output()[0] + 0.1);
  CHECK(bed_at(1s)->scan()[0] > bed_at(10ms)->scan()[0] + 1000);
  CHECK(bed_at(1s)->plant.specimen_state() != bed_at(10ms)->plant.specimen_state());
  // A memory that was set is read at once.
  auto bed = bed_at(1s);
  const std::string fresh = SmallPlant().plant.specimen_state();
  bed->plant.set_specimen_state(fresh);
  CHECK(bed->plant.specimen_state() == fresh);
  const std::vector<double> before = bed->plant.true_output();
  bed->at(1100ms);
  CHECK(bed->plant.true_output() != before);
}
