// Tables as people have them, from the command line: assumptions, omissions and doubts are reported; files stay tables.
#include <algorithm>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/bench/cli/check_refusal.h"
#include "tests/bench/cli/play_table.h"

using namespace tactbench::tests;
using nlohmann::json;

namespace {

const std::vector<double> kManyTurns = {0, 10, 0, 10, 5, 10, 3, 10, 1, 10, 0, 8, 0, 6, 0, 4, 0};

std::string play_rows(const std::vector<double>& turns, const std::string& separator = ",", bool comma = false) {
  std::string text;
  for (const PlaySample& sample : play_samples(turns)) {
    std::string row = std::to_string(sample.input) + "|" + std::to_string(sample.output);
    if (comma) std::ranges::replace(row, '.', ',');
    text += row.replace(row.find('|'), 1, separator) + "\n";
  }
  return text;
}

}  // namespace

TEST_CASE("a table with decimal commas and a line of units gives the plain table's fit, and keeps its format") {
  const TemporaryFolder folder;
  write_file(folder.path("plain.csv"), "input,output\n" + play_rows(kManyTurns));
  write_file(folder.path("comma.csv"), "\"force, N\";\"signal, V\"\n[N];[V]\n" + play_rows(kManyTurns, ";", true));
  const std::string map = "input=\"force, N\",output=\"signal, V\"";
  const Finished plain = call(folder, {"fit", "plain.csv", "--model", "preisach", "--json"});
  const Finished comma =
      call(folder, {"fit", "comma.csv", "--map", map, "--model", "preisach", "--json", "-o", "m.json"});
  INFO(comma.err);
  REQUIRE((plain.code == 0 && comma.code == 0));
  const json a = json::parse(plain.out), b = json::parse(comma.out);
  CHECK(a["models"][0]["shown_taxel"]["j"] == b["models"][0]["shown_taxel"]["j"]);
  CHECK((b["input_unit"] == "N" && b["output_unit"] == "V"));
  CHECK((a["assumed"].empty() && b["assumed"].size() == 3));
  CHECK((a["warnings"].empty() && plain.err.empty()));
  const Finished predicted = call(folder, {"predict", "m.json", "comma.csv", "--map", map});
  CHECK_THAT(predicted.out, Catch::StartsWith("\"force, N\";\"signal, V\";predicted\n[N];[V];V\n0,000000;0,000000;"));
  write_file(folder.path("p.csv"), predicted.out);
  CHECK(call(folder, {"compensate", "m.json", "p.csv", "--map", "output=predicted"}).code == 0);
}

TEST_CASE("bad rows end a fit with their line, or --skip-bad-rows goes on without them") {
  const TemporaryFolder folder;
  std::string text = "input,output\n" + play_rows(kManyTurns);
  const std::size_t third = text.find('\n', text.find('\n') + 1) + 1;
  text.insert(third, "0.3,\n");
  write_file(folder.path("t.csv"), text);
  const Finished refused = call(folder, {"fit", "t.csv"});
  CHECK(refused.code == 2);
  CHECK_THAT(refused.err, Catch::Contains("[TB-TABLE-ROW]") && Catch::Contains("t.csv:3"));
  const Finished fitted = call(folder, {"fit", "t.csv", "--skip-bad-rows"});
  CHECK(fitted.code == 0);
  CHECK_THAT(fitted.err, Catch::Contains("t.csv:3"));
  write_file(folder.path("none.csv"), "input,output\n1,2\n,\n,\n");
  check_refusal(call(folder, {"fit", "none.csv", "--skip-bad-rows"}), 2, "TB-TABLE-SKIPPED");
}

TEST_CASE("turns can be stated, in units of the input") {
  const TemporaryFolder folder;
  write_file(folder.path("t.csv"), "input,output\n" + play_rows(kManyTurns));
  const auto turn = [&](const std::vector<std::string>& more) {
    return json::parse(call(folder, joined_words({"fit", "t.csv", "--model", "monotone", "--json"}, more)).out)
        .at("turn")
        .get<double>();
  };
  CHECK(turn({}) == Approx(0.01).epsilon(0.1));
  CHECK(turn({"--turn", "4.5"}) == Approx(4.5));
  check_refusal(call(folder, {"fit", "t.csv", "--turn", "10"}), 2, "TB-TABLE-TURN");
}
