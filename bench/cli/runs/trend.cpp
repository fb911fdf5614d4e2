#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>

#include "analysis/counted.h"
#include "bench/cli/session.h"
#include "bench/common/output_file.h"
#include "bench/nightly/followed_page.h"

namespace tactbench::bench {
namespace {

struct TrendOptions {
  std::string sensor, subject, figure, html;
  bool check = false;
};

constexpr std::size_t kTrendWidth = 30;

std::vector<std::string> chosen_subjects(const TrendOptions& options, const db::RunStore& store) {
  std::set<std::string> subjects;
  for (const db::FigureRecord& figure : store.figures("")) subjects.insert(figure.subject);
  std::vector<std::string> chosen;
  for (const std::string& subject : subjects) {
    if (!options.sensor.empty() && !subject.starts_with(fmt::format("sensor/{}/", options.sensor))) continue;
    if (!options.subject.empty() && !subject.starts_with(options.subject)) continue;
    chosen.push_back(subject);
  }
  if (!chosen.empty()) return chosen;
  throw Error(ExitCode::kUsage, "TB-TREND-NONE", "there are no such figures", store.path(),
              subjects.empty() ? std::string("fit, nightly --db and rig check store figures")
                               : fmt::format("there are: {}", fmt::join(subjects, ", ")));
}

nlohmann::ordered_json followed_json(const Followed& followed) {
  nlohmann::ordered_json json = {{"subject", followed.subject}, {"figures", nlohmann::ordered_json::array()}};
  for (const FollowedFigure& figure : followed.figures) {
    nlohmann::ordered_json own = {{"name", figure.name},       {"runs", figure.runs},       {"values", figure.values},
                                  {"missing", figure.missing}, {"outside", figure.outside}, {"drifts", figure.drifts}};
    if (figure.band)
      own["baseline"] = {{"runs", figure.band->values},
                         {"mean", figure.band->mean},
                         {"deviation", figure.band->deviation},
                         {"low", figure.band->low},
                         {"high", figure.band->high}};
    if (figure.trend)
      own["trend"] = {{"probability", figure.trend->probability},
                      {"slope_per_run", figure.trend->slope},
                      {"moved", figure.trend->moved}};
    json["figures"].push_back(own);
  }
  return json;
}

void show_followed(const Followed& followed) {
  tty::print("{}{}\n", one_line(followed.subject),
             followed.baseline
                 ? fmt::format(": baseline of {}{} ({})", analysis::counted(followed.baseline->runs.size(), "run"),
                               followed.repeated == 0 ? ""
                                                      : fmt::format(", of which {} repeat another run and do not count",
                                                                    followed.repeated),
                               one_line(followed.baseline->reason))
                 : std::string(": no baseline"));
  for (const FollowedFigure& figure : followed.figures) {
    const std::string line = sparkline(figure.values, kTrendWidth);
    const std::size_t shown = std::min(kTrendWidth, figure.values.size());
    tty::print("  {:<28} {}{} {:>11.5g}{}{}\n", one_line(figure.name), line, std::string(kTrendWidth - shown, ' '),
               figure.values.back(),
               figure.band ? fmt::format("  {:.5g} to {:.5g}", figure.band->low, figure.band->high) : std::string(),
               figure.missing   ? "  MISSING"
               : figure.outside ? "  OUTSIDE"
               : figure.drifts  ? fmt::format("  drifts, {:+.2g} a run", figure.trend->slope)
                                : std::string());
  }
}

void trend(const TrendOptions& options, Session& session) {
  const db::RunStore store = db::RunStore::open_read_only(session.db);
  std::vector<Followed> subjects;
  std::string origin;
  std::size_t figures = 0;
  for (const std::string& subject : chosen_subjects(options, store)) {
    Followed& followed = subjects.emplace_back(follow(store, subject));
    if (!options.figure.empty())
      std::erase_if(followed.figures, [&](const FollowedFigure& figure) { return figure.name != options.figure; });
    figures += followed.figures.size();
    if (origin != "simulated") origin = followed.origin;
  }
  if (figures == 0)
    throw Error(ExitCode::kUsage, "TB-TREND-NONE", fmt::format("there is no figure '{}'", options.figure), "--figure",
                "omit it to list all");
  const auto any = [&](bool FollowedFigure::*what) {
    return std::ranges::any_of(subjects, [&](const Followed& f) { return std::ranges::any_of(f.figures, what); });
  };
  if (options.check)
    session.code = any(&FollowedFigure::outside)  ? ExitCode::kCriterionFailed
                   : any(&FollowedFigure::drifts) ? ExitCode::kInconclusive
                                                  : ExitCode::kPass;
  if (!options.html.empty())
    write_output(options.html, trend_page("Figures over time", origin, subjects), session.replace);
  if (session.json) {
    auto json = nlohmann::ordered_json::array();
    for (const Followed& followed : subjects) json.push_back(followed_json(followed));
    print_json("trend", {{"store", session.db}, {"origin", origin}, {"subjects", json}});
    return;
  }
  if (origin == "simulated") tty::print("SIMULATED DATA\n");
  for (const Followed& followed : subjects) show_followed(followed);
  if (!options.html.empty()) tty::print("{}\n", options.html);
}

}  // namespace

void add_trend(CLI::App& app, Session& session) {
  auto options = std::make_shared<TrendOptions>();
  CLI::App* verb = app.add_subcommand(
      "trend", "figures of a sensor, a rig or a scenario run by run, with the spread of its accepted baseline");
  verb->add_option("--sensor", options->sensor, "serial; its figures come from `fit`");
  verb->add_option("--subject", options->subject, "subject or its beginning: nightly/paper, rig/bench-1");
  verb->add_option("--figure", options->figure, "this figure alone");
  verb->add_option("--html", options->html, "write a page with a plot for each figure");
  add_replace(*verb, session);
  verb->add_flag("--check", options->check,
                 "exit 1 when the newest value of a figure is outside its band, 6 when one drifts");
  add_common(*verb, session);
  verb->callback([options, &session] { trend(*options, session); });
}

}  // namespace tactbench::bench
