// Simulated ends in a process that has few descriptors left: each that is missing is a fault, none stays open.
#include <catch2/catch.hpp>
#include <functional>

#include "devices/force/simulated_digital_ft.h"
#include "devices/force/simulated_net_ft.h"
#include "devices/tactile/simulated_frame_source.h"
#include "devices/tactile/simulated_scanner.h"
#include "tests/devices/few_descriptors.h"
#include "tests/devices/force/invented_digital.h"
#include "tests/devices/test_chamber.h"

using namespace tactbench::devices;
using tactbench::tests::FewDescriptors;

namespace {

class NoLoad final : public ForcePort {
 public:
  Wrench wrench() override { return {}; }
};

// With how many descriptors left it does not start, and is refused for it: 0, 1, 2 ...
int refused_with_few(const std::function<void()>& start) {
  start();  // what stays open from the first time on is no leak
  const auto before = FewDescriptors::open();
  for (int left = 0; left < 20; ++left) {
    std::optional<Fault> fault;
    {
      const FewDescriptors few(left);
      fault = fault_of(start);
    }
    CHECK(FewDescriptors::open() == before);
    if (!fault) return left;
    CHECK(fault->id() == "TB-SIM-LISTEN");
  }
  FAIL("twenty descriptors are not enough");
  return -1;
}

}  // namespace

TEST_CASE("simulated ends: with too few descriptors each says so and leaves none open", "[few-descriptors]") {
  NoLoad load;
  TurnedClock clock;
  TestArray array;
  // Both ends of a line; the page's listener and the records' socket; and what ends the thread.
  CHECK(refused_with_few([&] { SimulatedDigitalFt(invented_digital(), load, false); }) == 3);
  CHECK(refused_with_few([&] { SimulatedNetFt({0, 0, NetFtPage(), {}}, load); }) == 3);
  const TemporaryFolder folder;
  const std::string path = folder.path("scanner.sock");
  CHECK(refused_with_few([&] { SimulatedScanner(path, {0, 2, 2, 1.0F, "S", "1"}, array, clock); }) >= 2);
  CHECK_FALSE(std::filesystem::exists(path));
  CHECK(refused_with_few([&] {
          SimulatedFrameSource({.description = {1, 2, 2, 1.0, "", "", ""}}, array, clock);
        }) == 2);
}

TEST_CASE("simulated scanner: with too few descriptors a living one keeps its path", "[few-descriptors]") {
  TurnedClock clock;
  TestArray array;
  const TemporaryFolder folder;
  const std::string path = folder.path("scanner.sock");
  const SimulatedScanner living(path, {0, 2, 2, 1.0F, "S", "1"}, array, clock);
  for (int left = 0; left < 6; ++left) {
    std::optional<Fault> fault;
    {
      const FewDescriptors few(left);
      fault = fault_of([&] { SimulatedScanner(path, {0, 2, 2, 1.0F, "S", "1"}, array, clock); });
    }
    CHECK((fault && fault->id() == "TB-SIM-LISTEN"));
    CHECK(std::filesystem::exists(path));
  }
}
