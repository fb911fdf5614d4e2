// Numbers of options at the ends of what is taken, and just beyond, of the verbs of models and of the fleet.
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "db/run_store.h"
#include "tests/bench/cli/models/models_here.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

struct EdgesOfOption {
  std::string name;
  std::vector<std::string> taken, refused;
};

// `words` fail for another reason than their form: a file that is not there, a server that is away.
void check_edges(AddVerb add, const std::vector<std::string>& words, const std::vector<EdgesOfOption>& options) {
  const auto is_of_form = [&](const std::string& name, const std::string& value) {
    const Finished finished = verb_here(add, joined_words(words, {name, value}));
    CHECK(finished.code != 0);
    return !finished.err.starts_with("parse: ");
  };
  for (const EdgesOfOption& option : options) {
    for (const std::string& value : option.taken) {
      INFO(option.name << " " << value);
      CHECK(is_of_form(option.name, value));
    }
    for (const std::string& value : option.refused) {
      INFO(option.name << " " << value);
      CHECK_FALSE(is_of_form(option.name, value));
    }
  }
}

}  // namespace

TEST_CASE("options of fit, live, compensate: the least and the most that is taken") {
  const TemporaryFolder folder;
  const std::string none = folder.path("none.csv");
  check_edges(bench::add_fit, {"fit", none, "--model", "elam"},
              {{"--splits", {"1", "8"}, {"0", "9"}},
               {"--starts", {"1", "4096"}, {"0", "4097"}},
               {"--rate", {"1"}, {"0", "-1"}},
               {"--creep", {"1"}, {"0", "-1"}},
               {"--mode", {"paper", "free-run"}, {"free", ""}},
               {"--identify", {"exact", "ga"}, {"genetic"}}});
  check_edges(bench::add_live, {"live", "--bench", "simulated.toml", "--model", folder.path("none.json")},
              {{"--frames", {"0", "1"}, {"-1"}},
               {"--interval", {"0", "60"}, {"-0.1", "60.1"}},
               {"--scans", {"1", "64"}, {"0", "65"}}});
  check_edges(bench::add_predict, {"compensate", folder.path("none.json"), none},
              {{"--conditioned", {"0", "1e9"}, {"-1", "1.1e9"}}, {"--taxel", {"0", "1", "mean"}, {"-1", "means"}}});
}

TEST_CASE("options of the fleet: the least and the most that is taken") {
  const TemporaryFolder folder;
  db::RunStore::open(folder.path("runs.db"), db::Durability::kNormal);
  check_edges(bench::add_fleet,
              {"fleet", "push", "--db", folder.path("runs.db"), "--to", "host=" + folder.path() + " dbname=x"},
              {{"--patience", {"1", "3600"}, {"0", "3601"}}});
  for (const char* verb : {"runs", "trend"})
    check_edges(bench::add_fleet, {"fleet", verb, "--from", "host=" + folder.path() + " dbname=x"},
                {{"--origin", {"hardware", "simulated", "imported"}, {"real", ""}}});
}
