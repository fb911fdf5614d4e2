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

// What starting says with 0, 1, 2 ... descriptors left, until it says nothing.
std::vector<std::string> said_with_few(const std::function<void()>& start) {
  std::vector<std::string> said;
  start();  // what stays open from the first time on is no leak
  const auto before = FewDescriptors::open();
  for (int left = 0; left < 20; ++left) {
    std::optional<Fault> fault;
    {
      const FewDescriptors few(left);
      fault = fault_of(start);
    }
    CHECK(FewDescriptors::open() == before);
    if (!fault) return said;
    CHECK(fault->id() == "TB-SIM-LISTEN");
    said.push_back(fault->what());
  }
  FAIL("twenty descriptors are not enough");
  return said;
}

}  // namespace

TEST_CASE("simulated ends: with too few descriptors each says so and leaves none open", "[few-descriptors]") {
  using Catch::Contains;
  NoLoad load;
  TurnedClock clock;
  TestArray array;
  const auto digital = said_with_few([&] { SimulatedDigitalFt(invented_digital(), load, false); });
  REQUIRE(digital.size() == 3);  // both ends of a line, and what ends the thread
  CHECK(digital[2] == "no descriptor is left");
  const auto net = said_with_few([&] { SimulatedNetFt({0, 0, NetFtPage(), {}}, load); });
  REQUIRE(net.size() == 3);  // the page's listener, the records' socket, and what ends the thread
  CHECK(net[2] == "no descriptor is left for its thread");
  const TemporaryFolder folder;
  const std::string path = folder.path("scanner.sock");
  const auto scanner = said_with_few([&] { SimulatedScanner(path, {0, 2, 2, 1.0F, "S", "1"}, array, clock); });
  REQUIRE(scanner.size() >= 2);
  for (const std::string& words : {scanner[0], scanner[1]})
    CHECK(words == "listening on " + path + ": Too many open files");
  CHECK_FALSE(std::filesystem::exists(path));
  const auto source = said_with_few([&] {
    SimulatedFrameSource({.description = {1, 2, 2, 1.0, "", "", ""}}, array, clock);
  });
  REQUIRE(source.size() == 2);
  CHECK_THAT(source[0], Contains("Too many open files"));
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
    REQUIRE(fault);
    CHECK(fault->what() == "listening on " + path + (left < 2 ? ": Too many open files" : ": Address already in use"));
    CHECK(std::filesystem::exists(path));
  }
}
