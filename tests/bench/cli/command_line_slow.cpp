// What the command line refuses before a verb begins.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "tests/bench/cli/check_refusal.h"

using namespace tactbench::tests;

namespace {

std::vector<std::string> parts_of(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> parts;
  for (std::string part; stream >> part;) parts.push_back(part);
  return parts;
}

}  // namespace

TEST_CASE("numbers beyond their range are refused") {
  const TemporaryFolder folder;
  // Those of fit and live: option_edges.cpp.
  for (const char* line : {"live --bench simulated.toml --interval 1e9", "live --bench simulated.toml --frames -1",
                           "devices calibrate-reference --bench simulated.toml --gauge g --uncertainty 1e9",
                           "simulate --rate 1e9", "simulate --for -1", "nightly nightly --jobs 1000000",
                           "nightly nightly --seeds 1000000", "nightly nightly --limit 0"}) {
    INFO(line);
    check_refusal(call(folder, parts_of(line)), 2, "TB-USAGE");
  }
}

TEST_CASE("words that no verb takes are refused, with the state of the rig where a verb may have touched it") {
  const TemporaryFolder folder;
  for (const std::vector<std::string>& words :
       std::vector<std::vector<std::string>>{{"rn"},
                                             {"zzzzzzzz"},
                                             {"runs"},
                                             {"runs", "lst"},
                                             {"runs", "--all"},
                                             {"runs", "list", "--sensr=x", "-5"},
                                             {"runs", "list", "-z"},
                                             {"runs", "list", "-5"},
                                             {"runs", "list", "x"},
                                             {"runs", "show", "x"},
                                             {"-5"}}) {
    const Finished finished = call(folder, words);
    CAPTURE(words);
    check_refusal(finished, 2, "TB-USAGE", "command line");
    CHECK(finished.out.empty());
  }
  CHECK(call(folder, {}).code == 0);  // greets
  CHECK(nlohmann::json::parse(well(call(folder, {"rn", "--json"}), 2).out).at("id") == "TB-USAGE");
  for (const char* const judging : {"--limits", "--held-out", "--lab"})
    CHECK_THAT(call(folder, {"fit", "1", judging, "2"}).err, Catch::Contains("tactbench judge "));
  CHECK_THAT(call(folder, {"fit", "1", "--model", "elam,poly"}).err, Catch::Contains("tactbench compare 1"));
  // The state of the rig is told where a verb may have touched it.
  for (const char* verb :
       {"run", "calibrate", "resume", "devices", "live", "pause", "stop", "panic", "simulate", "dead-man", "demo"})
    CHECK_THAT(call(folder, {verb, "--zzzzzz"}).err, Catch::Contains("\n  state: "));
  for (const char* verb : {"plan", "fit", "runs", "status", "nightly", "init", "selfcheck"})
    CHECK_THAT(call(folder, {verb, "--zzzzzz"}).err, !Catch::Contains("\n  state: "));
}
