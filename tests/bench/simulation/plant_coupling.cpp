// How an object under the stage comes to the plant, in numbers of another implementation, and what a scan's status
// says.
#include <array>
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <stdexcept>

#include "devices/tactile/scan_report.h"
#include "tests/bench/simulation/small_plant.h"

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

TEST_CASE("plant coupling: an object's force and its pressure on each taxel") {
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
  stage.rests = true;  // in contact it is looked at all the same
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

TEST_CASE("plant coupling: a scan's status marks rows without time to settle and counts at the converter's ends") {
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

TEST_CASE("plant coupling: a stuck row beyond the array is its last one") {
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
