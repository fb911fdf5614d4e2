// The study's tables: Markdown for docs/compensation-error.md, and JSON.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <span>

#include "tests/benchmarks/study/compensation.h"
#include "tests/benchmarks/study/histories.h"

namespace tactbench::bench {

namespace {

std::string title_of(const RouteErrors& errors) { return fmt::format("{}: {}", errors.route, errors.model); }

std::string psi(double value) { return fmt::format("{:.2f}", value); }

std::string overview(std::span<const RouteErrors> all) {
  std::string text = "| mean error, psi |", line = "|---|";
  const auto row = [&](const std::string& name, auto figure) {
    text += fmt::format("| {} |", name);
    for (const RouteErrors& errors : all) text += fmt::format(" {} |", figure(errors));
    text += "\n";
  };
  for (const RouteErrors& errors : all) {
    text += fmt::format(" {} |", title_of(errors));
    line += "---|";
  }
  text += "\n" + line + "\n";
  row("route, minutes · taxels with a model",
      [](const RouteErrors& errors) { return fmt::format("{:.0f} · {}", errors.minutes, errors.taxels); });
  for (std::size_t k = 0; k < history_kinds().size(); ++k)
    row(history_kinds()[k].name, [k](const RouteErrors& errors) { return psi(errors.kinds[k].error().mean()); });
  row("**worst with a known start, in one mount**", [](const RouteErrors& errors) { return psi(errors.worst()); });
  row("**mean over the kinds**", [](const RouteErrors& errors) { return psi(errors.mean()); });
  return text;
}

std::string details(const RouteErrors& errors) {
  std::string text = fmt::format(
      "\n#### {}, {}\n\n"
      "| psi | mean | 95 % | largest | within 2 u, % | mean 2 u | covers as many | unknown · flat · out of range, % "
      "|\n|---|---|---|---|---|---|---|---|\n",
      errors.specimen, title_of(errors));
  for (std::size_t k = 0; k < errors.kinds.size(); ++k) {
    const StudiedErrors& kind = errors.kinds[k];
    if (kind.error().samples == 0) continue;
    text += fmt::format("| {} | {:.2f} | {:.2f} | {:.1f} | {:.1f} | {:.2f} | {:.2f} | {:.1f} · {:.1f} · {:.1f} |\n",
                        history_kinds()[k].name, kind.error().mean(), kind.quantile(0.95), kind.error().max,
                        100.0 * kind.covered(), kind.width(), kind.quantile(kind.covered()), 100.0 * kind.unknown(),
                        100.0 * kind.flat(), 100.0 * kind.out_of_range());
  }
  return text;
}

}  // namespace

std::string markdown_of(const CompensationStudy& study) {
  const std::vector<HistoryKind>& kinds = history_kinds();
  std::string text = study.commit.empty()
                         ? fmt::format("Seed {}, as given.\n", study.seed)
                         : fmt::format("Seed {}, of the last commit to code, {}.\n", study.seed, study.commit);
  for (const auto& [specimen, seeds] : study.sensors)
    text += fmt::format("Sensors, {}: {}.\n", specimen, fmt::join(seeds, ", "));
  std::vector<std::string> draws;
  for (std::size_t k = 0; k < kinds.size(); ++k) draws.push_back(fmt::format("{} {}", kinds[k].name, study.draws[k]));
  text += fmt::format("Draws: {}.\n", fmt::join(draws, "; "));
  for (auto first = study.errors.begin(); first != study.errors.end();) {
    const auto last = std::find_if(first, study.errors.end(),
                                   [&](const RouteErrors& errors) { return errors.specimen != first->specimen; });
    text += fmt::format("\n### {}\n\n{}", first->specimen, overview({first, last}));
    for (; first != last; ++first) text += details(*first);
  }
  return text;
}

std::string json_of(const CompensationStudy& study) {
  nlohmann::ordered_json json = {{"seed", study.seed}, {"commit", study.commit}};
  for (const auto& [specimen, seeds] : study.sensors) json["sensors"][specimen] = seeds;
  for (std::size_t k = 0; k < study.draws.size(); ++k) json["draws"][history_kinds()[k].name] = study.draws[k];
  for (const RouteErrors& errors : study.errors) {
    nlohmann::ordered_json own = {{"specimen", errors.specimen}, {"route", errors.route},     {"model", errors.model},
                                  {"taxels", errors.taxels},     {"minutes", errors.minutes}, {"worst", errors.worst()},
                                  {"mean", errors.mean()}};
    for (std::size_t k = 0; k < errors.kinds.size(); ++k) {
      const StudiedErrors& kind = errors.kinds[k];
      if (kind.error().samples == 0) continue;
      own["kinds"][history_kinds()[k].name] = {{"known_here", history_kinds()[k].known_here()},
                                               {"samples", kind.error().samples},
                                               {"mean", kind.error().mean()},
                                               {"q95", kind.quantile(0.95)},
                                               {"largest", kind.error().max},
                                               {"within_2u", kind.covered()},
                                               {"mean_2u", kind.width()},
                                               {"covers_as_many", kind.quantile(kind.covered())},
                                               {"unknown", kind.unknown()},
                                               {"flat", kind.flat()},
                                               {"out_of_range", kind.out_of_range()}};
    }
    json["errors"].push_back(std::move(own));
  }
  return json.dump(2) + "\n";
}

}  // namespace tactbench::bench
