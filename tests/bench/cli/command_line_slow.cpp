// The words of the command line that scripts of people call: verbs, their options, defaults and ranges. What is added
// needs no line here; what is gone or renamed breaks a script.
#include <algorithm>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <utility>
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

// The names of a verb's options, as its --help lists them.
std::string options_of_verb(const TemporaryFolder& folder, const std::string& verb) {
  std::istringstream lines(well(call(folder, parts_of(verb + " --help"))).out);
  std::string options;
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with("  -")) continue;
    std::string names = line.substr(2, line.find(' ', 2) - 2);
    std::ranges::replace(names, ',', ' ');
    options += names + " ";
  }
  return options;
}

}  // namespace

TEST_CASE("each verb takes the options that scripts give it") {
  const TemporaryFolder folder;
  const std::vector<std::pair<std::string, std::string>> expected = {
      {"", "--version"},
      {"demo", "--seed --sensor-seed -o --output --replace --timing#"},
      {"init", "--operator --rig --replace --force --json"},
      {"calibrate",
       "--bench --operator --recipe --held-out-recipe --minutes --limits --lab --model --type --run --held-out --lot "
       "--order "
       "--meta --set --seed "
       "--sensor-seed --on-event --yes --no-seating#"},
      {"recipes list", "--json"},
      {"recipes show", "--json"},
      {"recipes check", "--bench --json"},
      {"recipes new", "--from -o --output --replace --json"},
      {"model list", "--db --json -q --quiet"},
      {"reports list", "--db --json -q --quiet"},
      {"reports verify", "--db --json -q --quiet"},
      {"plan", "--bench --set --limits --steps --parameters --db --json"},
      {"run",
       "--bench --sensor --operator --purpose --lot --order --meta --set --seed --sensor-seed --specimen-state "
       "--on-event --yes "
       "--no-seating#"},
      {"pause", "--db --json -q --quiet --bench"},
      {"resume", "--db --json -q --quiet --bench --on-event --yes --units"},
      {"stop", "--db --json -q --quiet --bench"},
      {"abort", "--db --json -q --quiet --bench"},
      {"panic", "--db --json -q --quiet --bench"},
      {"status", "--db --json --bench"},
      {"watch", "--db --bench"},
      {"fit",
       "--model --fit --score --mode --identify --rate --creep --linearise --memory --exact-outer --splits --starts "
       "--mean-taxel --mount "
       "--interface -o --output --replace --check --map --input-unit --noise --output-unit --held-out --limits --lab "
       "--void-too#"},
      {"import", "--map --input-unit --noise --output-unit --operator --purpose#"},
      {"predict", "-o --output --replace --map --taxel --units --void-too#"},
      {"compensate", "-o --output --replace --map --taxel --conditioned --void-too#"},
      {"model show", "--units --void-too#"},
      {"model diff", "--units --void-too#"},
      {"model export", "-o --output --replace --void-too#"},
      {"model adjust", "--zero --gain -o --output --replace --map --input-unit --noise --output-unit --void-too#"},
      {"report",
       "--held-out --previous --studies --model --format --limits --lab --approve-by --reason --without-verdict "
       "--issued-at "
       "--paper --pdf-with --compare --batch --replace -o --output --void-too#"},
      {"runs list", "--sensor --since --tag --lot --order --meta --verdict --all#"},
      {"runs show", "--events#"},
      {"runs tag", "--remove#"},
      {"runs note", "--db --json -q --quiet"},
      {"runs void", "--reason --by#"},
      {"runs export", "--format -o --output --replace#"},
      {"runs copy", "--to#"},
      {"runs diff", "--db --json -q --quiet"},
      {"verify", "--db --json -q --quiet"},
      {"db check", "--db --json -q --quiet"},
      {"db snapshot", "--db --json -q --quiet"},
      {"db migrate", "--db --json -q --quiet"},
      {"sensors add", "--type --scanner --note#"},
      {"sensors list", "--db --json -q --quiet"},
      {"sensors show", "--db --json -q --quiet"},
      {"devices scan", "--modbus --json"},
      {"devices check", "--bench --set --json"},
      {"devices watch", "--bench --set --interval --count"},
      {"devices reset", "--bench --set --operator --json"},
      {"devices calibrate-reference",
       "--bench --gauge --uncertainty --resolution --levels --set -o --output --replace --json"},
      {"live", "--bench --model --set --frames --interval --scans --csv --replace --void-too#"},
      {"simulate", "--bench --set --rate --write-bench --replace --for --json"},
      {"nightly",
       "--jobs --junit --metrics --html --replace --stores --list --only --seed --seeds --limit --stop-on-red#"},
      {"baseline accept", "--reason --by#"},
      {"baseline list", "--db --json -q --quiet"},
      {"trend", "--sensor --subject --figure --html --replace --check --units#"},
      {"rig check", "--bench --standard --operator --recipe --press --yes --set --seed --sensor-seed --units#"},
      {"config show", "--bench --set --origin --json"},
      {"selfcheck", "-o --output --replace --json -q --quiet"},
  };
  for (auto [verb, options] : expected) {
    if (const std::size_t common = options.find('#'); common != std::string::npos)
      options.replace(common, 1, " --db --json -q --quiet");
    const std::string known = " " + options_of_verb(folder, verb);
    for (const std::string& option : parts_of(options + " -h --help")) {
      INFO(verb << ' ' << option);
      CHECK(known.find(" " + option + " ") != std::string::npos);
    }
  }
}

TEST_CASE("numbers of the command line have these ranges and defaults") {
  const TemporaryFolder folder;
  // Those of fit and live: option_edges.cpp.
  for (const char* line :
       {"devices watch --bench simulated.toml --interval 1e9", "devices watch --bench simulated.toml --count -1",
        "devices calibrate-reference --bench simulated.toml --gauge g --uncertainty 1e9", "simulate --rate 1e9",
        "simulate --for -1", "nightly nightly --jobs 1000000", "nightly nightly --seeds 1000000",
        "nightly nightly --limit 0"}) {
    INFO(line);
    check_refusal(call(folder, parts_of(line)), 2, "TB-USAGE");
  }
  const std::vector<std::pair<std::string, std::string>> defaults = {
      {"demo", "--seed=1"},
      {"plan", "--bench=simulated.toml"},
      {"fit", "--splits=1"},
      {"fit", "--starts=16"},
      {"devices watch", "--interval=0.5"},
      {"devices watch", "--count=0"},
      {"devices calibrate-reference", "--resolution=0.1"},
      {"devices calibrate-reference", "--levels=[0,10,20,30,40,50,60]"},
      {"live", "--interval=0.01"},
      {"live", "--scans=1"},
      {"simulate", "--rate=1"},
      {"nightly", "--jobs=2"},
      {"nightly", "--seeds=1"},
      {"nightly", "--limit=300"},
      {"rig check", "--recipe=[production]"},
      {"runs export", "--format=csv"},
      {"runs list", "--db=runs.db"}};
  for (const auto& [verb, option] : defaults) {
    INFO(verb << ' ' << option);
    const std::string help = call(folder, parts_of(verb + " --help")).out, name = option.substr(0, option.find('='));
    const std::size_t entry = help.find("  " + name + " ");
    REQUIRE(entry != std::string::npos);
    const std::string line = help.substr(entry, help.find('\n', entry) - entry) + " ";
    CHECK_THAT(line, Catch::Contains(option.substr(name.size()) + " "));
  }
}

TEST_CASE("words that no verb takes are refused, with the state of the rig where a verb may have touched it") {
  const TemporaryFolder folder;
  for (const std::vector<std::string>& words :
       std::vector<std::vector<std::string>>{{"rn"},
                                             {"zzzzzzzz"},
                                             {},
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
  CHECK(nlohmann::json::parse(well(call(folder, {"rn", "--json"}), 2).out).at("id") == "TB-USAGE");
  // The state of the rig is told where a verb may have touched it.
  for (const char* verb : {"run", "calibrate", "resume", "rig", "devices", "live", "pause", "stop", "abort", "panic",
                           "simulate", "dead-man", "demo"})
    CHECK_THAT(call(folder, {verb, "--zzzzzz"}).err, Catch::Contains("\n  state: "));
  for (const char* verb : {"plan", "fit", "runs", "status", "watch", "nightly", "init", "selfcheck"})
    CHECK_THAT(call(folder, {verb, "--zzzzzz"}).err, !Catch::Contains("\n  state: "));
}
