#include "bench/guard/trip.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <system_error>

#include "bench/common/error.h"
#include "tests/support/paths.h"
#include "tests/support/process.h"
#include "tests/support/variable.h"

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

TEST_CASE("trip: a file that cannot be made beside the one that it replaces is named") {
  const TemporaryFolder folder;
  const std::string path = folder.path("missing/trip");
  CHECK_THROWS_WITH(write_durably(path, "text"), Catch::Contains(fmt::format("{}.{}", path, getpid())));
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
  CHECK(run_program(program_path(), words, folder.path()).code == 0);  // nothing to do
}

TEST_CASE("trip file: contents, state after a reset, and no partial file remains") {
  const TemporaryFolder folder;
  const Variable state("XDG_STATE_HOME", folder.path());
  const TripFile file("b1");
  CHECK(file.path() == folder.path("tactbench/b1.trip"));
  CHECK(file.log_path() == folder.path("tactbench/b1.log"));
  CHECK(file.dead_man_path() == folder.path("tactbench/b1.dead-man.json"));
  REQUIRE(file.store({"TB-X", "said", 12, "ignored"}));
  const auto json = nlohmann::json::parse(read_file(file.path()));
  CHECK((json["id"] == "TB-X" && json["what"] == "said" && json["run"] == 12 && json["utc"] != "ignored"));
  const auto trip = file.read();
  REQUIRE(trip);
  CHECK((trip->id == "TB-X" && trip->what == "said" && trip->run == 12 && trip->utc == json["utc"].get<std::string>()));
  file.reset(*trip, "P");
  CHECK_FALSE(std::filesystem::exists(file.path()));
  REQUIRE(file.store({"TB-Y", "again", 0, {}}));
  file.reset(*file.read(), "Q");
  const std::string log = read_file(file.log_path());
  for (const char* part : {" P", "TB-X", "12", "said", " Q", "TB-Y"}) CHECK(log.find(part) != std::string::npos);
  CHECK(std::count(log.begin(), log.end(), '\n') == 2);
  std::size_t files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder.path("tactbench")))
    files += entry.exists() ? 1 : 0;
  CHECK(files == 1);
  write_file(file.path(), R"({"id":"TB-Z"})");
  CHECK((file.read()->id == "TB-Z" && file.read()->utc == "unknown" && file.read()->run == 0));
  CHECK_THROWS_AS(write_durably(folder.path("no/such/folder"), "x"), std::system_error);
  write_durably(folder.path("text"), "one");
  write_durably(folder.path("text"), "two");
  CHECK(read_file(folder.path("text")) == "two");
}

TEST_CASE("state folder: that of XDG_STATE_HOME, else one in the home folder") {
  const TemporaryFolder folder;
  {
    const Variable given("XDG_STATE_HOME", folder.path("given"));
    CHECK(state_folder("/no/machine") == folder.path("given/tactbench"));
    CHECK(std::filesystem::is_directory(folder.path("given/tactbench")));
  }
  const Variable none("XDG_STATE_HOME", "");
  const Variable home("HOME", folder.path());
  CHECK(state_folder("/no/machine") == folder.path(".local/state/tactbench"));
}
