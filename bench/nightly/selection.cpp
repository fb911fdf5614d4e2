// What a night takes of its suite.
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "analysis/json_io.h"
#include "bench/common/error.h"
#include "bench/nightly/suite.h"

namespace tactbench::bench {

Suite selected(Suite suite, const Selection& selection) {
  for (const std::string& name : selection.only)
    if (std::ranges::find(suite.scenarios, name, &Scenario::name) == suite.scenarios.end())
      throw Error("TB-NIGHTLY-SCENARIO", fmt::format("there is no scenario '{}'", name), suite.file,
                  "tactbench nightly SUITE --list shows them");
  if (!selection.only.empty())
    std::erase_if(suite.scenarios, [&](const Scenario& scenario) {
      return std::ranges::find(selection.only, scenario.name) == selection.only.end();
    });
  if (selection.seed)
    for (Scenario& scenario : suite.scenarios) scenario.seed = *selection.seed;
  return with_seeds(suite, selection.seeds);
}

std::string to_json(const Selection& selection) {
  nlohmann::ordered_json json = {{"only", selection.only}, {"seed", nullptr}, {"seeds", selection.seeds}};
  if (selection.seed) json["seed"] = *selection.seed;
  return analysis::json_line(json);
}

Selection selection_from_json(const std::string& text) {
  try {
    const auto json = analysis::parse_json(text);
    Selection selection{json.at("only"), std::nullopt, json.at("seeds")};
    if (!json.at("seed").is_null()) selection.seed = json.at("seed").get<std::uint64_t>();
    return selection;
  } catch (const nlohmann::json::exception& error) {
    throw std::invalid_argument(fmt::format("a night's choice of scenarios cannot be read: {}", error.what()));
  }
}

Suite part_of(const Suite& whole, const Shard& shard) {
  Suite part = whole;
  part.scenarios.clear();
  for (std::size_t i = 0; i < whole.scenarios.size(); ++i)
    if (shard.holds(i)) part.scenarios.push_back(whole.scenarios[i]);
  return part;
}

}  // namespace tactbench::bench
