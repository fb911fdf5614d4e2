#include "bench/guard/trip.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <system_error>

#include "bench/common/error.h"
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
  const TemporaryFolder folder;
  const Variable state("XDG_STATE_HOME", folder.path());
  BenchConfig config;
  config.id = "b1";
  const TripFile file(config.id);
  CHECK(file.path() == folder.path("tactbench/b1.trip"));
  CHECK(file.log_path() == folder.path("tactbench/b1.log"));
  CHECK(file.dead_man_path() == folder.path("tactbench/b1.dead-man.json"));
  CHECK_FALSE(file.read());
  CHECK(refusal(config).empty());
  REQUIRE(file.store({"TB-X", "67.0 psi", 12, "ignored"}));
  REQUIRE(file.store({"TB-DEADMAN-FIRED", "later", 12, {}}));
  const auto json = nlohmann::json::parse(read_file(file.path()));
  CHECK((json["id"] == "TB-X" && json["what"] == "67.0 psi" && json["run"] == 12 && json["utc"] != "ignored"));
  const auto trip = TripFile(config.id).read();
  REQUIRE(trip);
  CHECK((trip->id == "TB-X" && trip->what == "67.0 psi" && trip->run == 12));
  CHECK(trip->utc == json["utc"].get<std::string>());
  CHECK_THAT(refusal(config), Catch::StartsWith("TB-BENCH-TRIPPED") && Catch::Contains("67.0 psi"));
  config.in_process = true;
  CHECK(refusal(config).empty());
  file.reset(*trip, "A. Person");
  CHECK_FALSE(std::filesystem::exists(file.path()));
  CHECK_FALSE(file.read());
  REQUIRE(file.store({"TB-Y", "again", 0, {}}));
  file.reset(*file.read(), "Q");
  const std::string log = read_file(file.log_path());
  for (const char* part : {" A. Person", "TB-X", "12", "67.0 psi", " Q", "TB-Y"})
    CHECK(log.find(part) != std::string::npos);
  CHECK(std::count(log.begin(), log.end(), '\n') == 2);
  const std::filesystem::directory_iterator files(folder.path("tactbench"));
  CHECK(std::distance(begin(files), end(files)) == 1);  // no partial one
}

TEST_CASE("trip: a bench whose id cannot be a file name has a file, too") {
  const TripFile file("bench 1/left");
  REQUIRE(file.store({"TB-X", "said", 12, {}}));
  REQUIRE(TripFile("bench 1/left").read());
  file.reset(*file.read(), "P");
}

TEST_CASE("trip: a file that cannot be read is a trip") {
  const TripFile file("b");
  write_file(file.path(), GENERATE("", "{", "[1]", "null"));
  REQUIRE(file.read());
  CHECK(file.read()->id == "TB-TRIP-UNREADABLE");
}

TEST_CASE("trip: what a file lacks is unknown, one that cannot be made is named, one that is there is replaced") {
  const TemporaryFolder folder;
  const TripFile file("lacking");
  write_file(file.path(), R"({"id":"TB-Z"})");
  CHECK((file.read()->id == "TB-Z" && file.read()->utc == "unknown" && file.read()->run == 0));
  std::filesystem::remove(file.path());
  CHECK_THROWS_AS(write_durably(folder.path("no/such/folder"), "x"), std::system_error);
  CHECK_THROWS_WITH(write_durably(folder.path("missing/trip"), "text"),
                    Catch::Contains(fmt::format("{}.{}", folder.path("missing/trip"), getpid())));
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
