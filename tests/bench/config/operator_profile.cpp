// tactbench.toml and the environment: what they give, which precedes, and what is refused.
#include "bench/config/operator_profile.h"

#include <catch2/catch.hpp>

#include "sequences/toml/strict_toml.h"
#include "tests/support/process.h"
#include "tests/support/variable.h"

using namespace tactbench;
using bench::OperatorProfile;
using bench::ProfileKey;
using tests::Variable;

namespace {

OperatorProfile profile_of(const std::string& text) {
  const tests::TemporaryFolder folder;
  tests::write_file(folder.path("tactbench.toml"), text);
  return bench::read_operator_profile(folder.path("tactbench.toml"));
}

void check_refused(const std::string& text, const std::string& id, const std::string& where) {
  try {
    static_cast<void>(profile_of(text));
    FAIL("was taken: " << text);
  } catch (const sequences::FileError& error) {
    CAPTURE(error.what(), error.remedy(), error.where());
    CHECK(error.id() == id);
    CHECK(error.where().find(where) != std::string::npos);
  }
}

}  // namespace

TEST_CASE("operator profile: each value has its line, recipe holds one name or several") {
  const OperatorProfile profile =
      profile_of("bench = \"rig.toml\"\n\noperator = \"A. Person\"\nrecipe = \"descending, ascending\"\n");
  REQUIRE(profile.size() == 3);
  CHECK(profile.at(ProfileKey::kBench).values == std::vector<std::string>{"rig.toml"});
  CHECK(profile.at(ProfileKey::kBench).origin.ends_with("tactbench.toml:1"));
  CHECK(profile.at(ProfileKey::kOperator).values == std::vector<std::string>{"A. Person"});
  CHECK(profile.at(ProfileKey::kOperator).origin.ends_with("tactbench.toml:3"));
  CHECK(profile.at(ProfileKey::kRecipe).values == std::vector<std::string>{"descending", "ascending"});
  CHECK(profile_of("recipe = \"ring\"\n").at(ProfileKey::kRecipe).values == std::vector<std::string>{"ring"});
}

TEST_CASE("operator profile: the environment outranks the file for each key, a blank variable is ignored") {
  const Variable bench("TACTBENCH_BENCH", "other.toml"), db("TACTBENCH_DB", " ");
  const OperatorProfile profile = profile_of("bench = \"rig.toml\"\ndb = \"mine.db\"\nlimits = \"l.toml\"\n");
  CHECK(profile.at(ProfileKey::kBench).values == std::vector<std::string>{"other.toml"});
  CHECK(profile.at(ProfileKey::kBench).origin == "TACTBENCH_BENCH");
  CHECK(profile.at(ProfileKey::kDb).values == std::vector<std::string>{"mine.db"});
  CHECK(profile.at(ProfileKey::kDb).origin.ends_with("tactbench.toml:2"));
  CHECK(profile.at(ProfileKey::kLimits).values == std::vector<std::string>{"l.toml"});
}

TEST_CASE("operator profile: an unknown key is reported with its line, a blank or invalid value is rejected") {
  check_refused("bench = \"a\"\noperater = \"me\"\n", "TB-FILE-KEY", "tactbench.toml:2");
  check_refused("[run]\nbench = \"a\"\n", "TB-FILE-KEY", "tactbench.toml:1");
  check_refused("operator = \" \"\n", "TB-FILE-VALUE", "tactbench.toml:1");
  check_refused("db = 7\n", "TB-FILE-VALUE", "tactbench.toml:1");
  check_refused("recipe = [\"ring\"]\n", "TB-FILE-VALUE", "tactbench.toml:1");
  check_refused("recipe = \"ring, \"\n", "TB-FILE-VALUE", "tactbench.toml:1");
  check_refused("bench = \n", "TB-FILE-SYNTAX", "tactbench.toml:1");
}
