#include "bench/guard/trip.h"

#include <fmt/format.h>
#include <unistd.h>

#include <catch2/catch.hpp>

#include "bench/common/error.h"
#include "tests/support/paths.h"
#include "tests/support/process.h"

using namespace tactbench::bench;
using namespace tactbench::tests;

namespace {

std::string refusal(const BenchConfig& config) {
  try {
    refuse_tripped(config);
    return {};
  } catch (const Error& error) {
    CHECK(error.code() == ExitCode::kStopped);
    CHECK_THAT(error.remedy(), Catch::Contains("devices reset"));
    return error.id() + " " + error.what();
  }
}

}  // namespace

TEST_CASE("trip: it is stored, refuses commands, keeps its first cause, and ends only by a logged reset") {
  BenchConfig config;
  config.id = "bench 1/left";
  const TripFile file(config.id);
  CHECK_FALSE(file.read());
  CHECK(refusal(config).empty());
  REQUIRE(file.store({"TB-CHAMBER-TRIP", "67.0 psi", 12, {}}));
  REQUIRE(file.store({"TB-DEADMAN-FIRED", "later", 12, {}}));
  const auto trip = TripFile(config.id).read();
  REQUIRE(trip);
  CHECK(trip->id == "TB-CHAMBER-TRIP");
  CHECK(trip->run == 12);
  CHECK_FALSE(trip->utc.empty());
  CHECK_THAT(refusal(config), Catch::StartsWith("TB-BENCH-TRIPPED") && Catch::Contains("67.0 psi"));
  config.in_process = true;
  CHECK(refusal(config).empty());
  config.in_process = false;
  file.reset(*trip, "A. Person");
  CHECK_FALSE(file.read());
  CHECK_THAT(read_file(file.log_path()), Catch::Contains("A. Person") && Catch::Contains("67.0 psi"));
}

TEST_CASE("trip: a file that cannot be read is a trip") {
  const TripFile file("b");
  write_file(file.path(), GENERATE("", "{", "[1]", "null"));
  REQUIRE(file.read());
  CHECK(file.read()->id == "TB-TRIP-UNREADABLE");
}

TEST_CASE("trip: a file that cannot be made beside the one that it replaces is named, with what was done") {
  const TemporaryFolder folder;
  const std::string path = folder.path("missing/trip");
  CHECK_THROWS_WITH(write_durably(path, "text"),
                    fmt::format("opening {}.{}: No such file or directory", path, getpid()));
}

TEST_CASE("trip: a bench tripped is shown and reset by the command line") {
  const TemporaryFolder folder;
  const TripFile file("simulated-rig");
  REQUIRE(file.store({"TB-FORCE-TRIP", "Fz = 36 N", 3, {}}));
  const auto words = std::vector<std::string>{"devices", "reset", "--bench", "simulated.toml", "--operator", "P"};
  const Finished reset = run_program(program_path(), words, folder.path());
  CHECK(reset.code == 0);
  CHECK_THAT(reset.out, Catch::Contains("Fz = 36 N"));
  CHECK_FALSE(file.read());
  CHECK_THAT(run_program(program_path(), words, folder.path()).out, Catch::Contains("not tripped"));
}
