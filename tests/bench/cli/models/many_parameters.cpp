// model show of a model with more parameters than a page takes.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/bench/cli/models/models_here.h"
#include "tests/bench/cli/play_table.h"

using namespace tactbench;
using namespace tactbench::tests;

TEST_CASE("model show: 24 of a model's many parameters, and how many more there are") {
  const TemporaryFolder folder;
  std::string table = "input,output\n";
  for (const PlaySample& sample : play_samples({0, 10, 0, 10, 5, 10, 0, 8, 2, 6, 3, 10, 0}))
    table += std::to_string(sample.input) + "," + std::to_string(sample.output) + "\n";
  write_file(folder.path("t.csv"), table);
  const Finished fitted = model_verb(folder, {"fit", "t.csv", "--model", "preisach", "-q", "-o", "m.json", "--json"});
  REQUIRE(fitted.code == 0);
  const std::size_t all =
      nlohmann::json::parse(fitted.out).at("models").at(0).at("shown_taxel").at("parameters").size();
  REQUIRE(all > 25);
  const std::string shown = model_verb(folder, {"model", "show", "m.json"}).out,
                    list = shown.substr(shown.find("\n\n") + 2);
  std::size_t lines = 0;
  for (std::size_t at = 0; (at = list.find("\n  ", at)) != std::string::npos; ++at) ++lines;
  CHECK(lines == 25);
  CHECK_THAT(list, Catch::EndsWith("\n  and " + std::to_string(all - 24) + " more (--json)\n"));
}
