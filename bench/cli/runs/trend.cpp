#include "bench/cli/runs/trend.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>

#include "analysis/counted.h"
#include "analysis/json_fields.h"
#include "analysis/report/document/document.h"
#include "bench/cli/runs/source.h"
#include "bench/cli/session.h"
#include "bench/common/output_file.h"
#include "bench/common/terminal.h"
#include "bench/common/utc.h"
#include "bench/nightly/subject_trend.h"
#include "bench/nightly/trend_pages.h"
#include "bench/reporting/evidence.h"

namespace tactbench::bench {
namespace {

constexpr std::size_t kTrendWidth = 20;

std::vector<std::string> chosen_subjects(const TrendOptions& options, const db::RunStore& store) {
  const std::vector<std::string> subjects = store.subjects();
  std::vector<std::string> chosen;
  for (const std::string& subject : subjects) {
    if (!options.sensor.empty() && !subject.starts_with(fmt::format("sensor/{}/", options.sensor))) continue;
    if (!options.subject.empty() && !subject.starts_with(options.subject)) continue;
    chosen.push_back(subject);
  }
  if (!chosen.empty()) return chosen;
  throw Error("TB-TREND-NONE", "there are no such figures", store.path(),
              subjects.empty() ? std::string("fit, nightly --db and devices test store figures")
                               : fmt::format("there are: {}", fmt::join(subjects, ", ")));
}

nlohmann::ordered_json followed_json(const SubjectTrend& followed) {
  nlohmann::ordered_json json = {{"subject", followed.subject}};
  if (followed.same_seeds != 0) json["same_seeds_as_run"] = followed.same_seeds;
  json["figures"] = nlohmann::ordered_json::array();
  for (const TrendFigure& figure : followed.figures) {
    const analysis::ControlChart& chart = figure.chart;
    nlohmann::ordered_json own = {JSON_FIELDS(figure, name, runs, values, missing, outside, shifted, outlier)};
    if (chart.band)
      own["baseline"] = {{"runs", chart.band->values},         {"mean", chart.band->mean},
                         {"deviation", chart.band->deviation}, {"low", chart.band->low},
                         {"high", chart.band->high},           JSON_FIELDS(chart, constant, logarithmic)};
    if (chart.ewma)
      own["ewma"] = {{"runs", chart.ewma->later},
                     {"value", chart.level},
                     {"deviations", chart.ewma->ewma},
                     {"probability", chart.probability}};
    if (chart.slope) own["slope_per_run"] = *chart.slope;
    json["figures"].push_back(own);
  }
  return json;
}

std::string baseline_text(const SubjectTrend& followed) {
  if (!followed.baseline) return "no baseline";
  std::string text = fmt::format("baseline of {}", analysis::counted(followed.baseline->runs.size(), "run"));
  if (followed.repeated > 0)
    text += fmt::format(", of which {} repeat another run and do not count", followed.repeated);
  text += fmt::format(" ({})", one_line(followed.baseline->reason));
  if (const std::string too_short = short_baseline(followed); !too_short.empty()) text += "; " + too_short;
  if (followed.same_seeds != 0)
    text += fmt::format("; run {} has the seeds of run {}: no moving average", followed.run, followed.same_seeds);
  return text;
}

std::string judged_text(const TrendFigure& figure) {
  if (figure.missing) return "MISSING";
  if (figure.outside) return "OUTSIDE";
  if (figure.shifted)
    return fmt::format("shifted: average {:.4g}{}", figure.chart.level,
                       figure.chart.slope ? fmt::format(", {:+.2g} a run", *figure.chart.slope) : std::string());
  if (figure.outlier) return "OUTLIER among sensors";
  return figure.compared ? "within" : "";
}

void show_followed(const SubjectTrend& followed) {
  const auto has_band = [](const TrendFigure& figure) { return figure.chart.band.has_value(); };
  const bool banded = std::ranges::any_of(followed.figures, has_band);
  analysis::doc::Table table{.id = {}, .columns = {{"figure"}, {"former", true}, {"newest", true}, {"runs", true}}};
  if (banded) table.columns.push_back({"band", true});
  table.columns.emplace_back();
  for (const TrendFigure& figure : followed.figures) {
    const auto& band = figure.chart.band;
    std::vector<analysis::doc::Phrase>& cells = table.rows.emplace_back().cells;
    cells = {display_text(one_line(figure.name)).text(),
             figure.values.size() > 1 ? fmt::format("{:.4g}", figure.former()) : "–",
             fmt::format("{:.4g}", figure.values.back()), sparkline(figure.values, scale_of(figure), kTrendWidth)};
    if (banded) cells.emplace_back(band ? fmt::format("{:.4g} to {:.4g}", band->low, band->high) : "–");
    cells.emplace_back(judged_text(figure));
  }
  analysis::doc::Document document;
  document.add(std::move(table));
  tty::print("{}: {}\n{}", one_line(followed.subject), baseline_text(followed),
             to_text(document, analysis::PressureUnit::kPsi, line_columns()));
}

}  // namespace

void trend(const TrendOptions& options, Session& session) {
  const db::RunStore store = db::RunStore::open_read_only(session.db);
  std::vector<SubjectTrend> subjects;
  std::string origin;
  std::size_t figures = 0;
  for (const std::string& subject : chosen_subjects(options, store))
    if (SubjectTrend followed = follow(store, subject); followed.run != 0) subjects.push_back(std::move(followed));
  if (subjects.empty())
    throw Error("TB-TREND-NONE", "all runs with such figures are void", store.path(),
                "tactbench runs list --all shows why");
  std::vector<SubjectTrend*> family;
  for (SubjectTrend& followed : subjects) family.push_back(&followed);
  judge_shifts(family);
  mark_outliers(subjects);
  for (SubjectTrend& followed : subjects) {
    if (!options.figure.empty())
      std::erase_if(followed.figures, [&](const TrendFigure& figure) {
        return figure.name != options.figure && display_text(figure.name).name != options.figure;
      });
    figures += followed.figures.size();
    if (origin != "simulated") origin = followed.origin;
  }
  if (figures == 0)
    throw Error("TB-TREND-NONE", fmt::format("there is no figure '{}'", options.figure), "--figure",
                "omit it to list all");
  const auto any = [&](bool TrendFigure::*what) {
    return std::ranges::any_of(subjects, [&](const SubjectTrend& f) { return std::ranges::any_of(f.figures, what); });
  };
  const bool compared = any(&TrendFigure::compared);
  if (options.check) {
    session.code = any(&TrendFigure::outside)                ? ExitCode::kCriterionFailed
                   : any(&TrendFigure::shifted) || !compared ? ExitCode::kInconclusive
                                                             : ExitCode::kPass;
    if (!compared)
      tty::print(stderr,
                 "warning: nothing was compared: no figure has a value after a baseline with enough runs; accept a "
                 "baseline with tactbench trend accept\n");
  }
  if (!options.html.empty())
    write_output(options.html, trend_page("Figures over time", origin, subjects), session.replace);
  if (session.json) {
    auto json = nlohmann::ordered_json::array();
    for (const SubjectTrend& followed : subjects) json.push_back(followed_json(followed));
    print_json("trend",
               {{"store", session.fleet.empty() ? session.db : session.fleet}, {"origin", origin}, {"subjects", json}});
    return;
  }
  if (origin == "simulated") tty::print("SIMULATED DATA\n");
  if (!compared) tty::print("no baseline to compare with: bars begin at 0\n");
  for (const SubjectTrend& followed : subjects) show_followed(in_unit(followed, session.unit()));
  if (!options.html.empty()) tty::print("{}\n", options.html);
}

void add_trend_options(CLI::App& verb, TrendOptions& options, Session& session) {
  verb.add_option("--sensor", options.sensor, "serial number; the figures come from `fit`");
  verb.add_option("--subject", options.subject, "subject or its beginning: nightly/paper, rig/bench-1");
  verb.add_option("--figure", options.figure, "only this figure: \"mean error\" or mean_error_psi");
  verb.add_option("--html", options.html, "write a page with a plot for each figure");
  add_replace(verb, session);
  verb.add_flag(
      "--check", options.check,
      "exit code 1 if the newest value of a figure is outside its band, 6 if one has shifted or none was compared");
}

void add_trend(CLI::App& app, Session& session) {
  auto options = std::make_shared<TrendOptions>();
  CLI::App* verb = app.add_subcommand("trend",
                                      "values run by run against their baseline; accept baselines\n"
                                      "Of a sensor, a rig or a scenario, with the band and the moving average of the "
                                      "accepted baseline.");
  add_trend_options(*verb, *options, session);
  verb->callback([options, verb, &session] {
    if (verb->get_subcommands().empty()) trend(*options, session);
  });
  add_subverbs(*verb, session);
}

namespace {

struct BaselineOptions {
  std::vector<std::string> runs;  // numbers and ranges
  std::string subject, reason, by;
};

// The runs named, grouped by the subjects for which they have figures.
std::map<std::string, std::vector<std::int64_t>> chosen_runs(const BaselineOptions& options, const db::RunStore& store,
                                                             const Session& session) {
  analysis::Runs named(store);
  std::vector<RunRange> ranges;
  for (const std::string& word : options.runs) {
    const std::vector<RunRange> own = run_ranges(word);
    if (own.empty())
      throw Error("TB-USAGE", fmt::format("'{}' is not a run", word), "RUNS", "a number, or a range such as 12-55");
    // A single run must exist and not be void, else throws; a range skips void and missing runs.
    for (const RunRange& range : own)
      if (range.first == range.last) (void)named_runs(named, {range.first}, {"RUNS", 0, false}, session.void_too);
    ranges.insert(ranges.end(), own.begin(), own.end());
  }
  std::map<std::string, std::vector<std::int64_t>> chosen;
  for (const db::FigureRecord& figure : store.figures("")) {
    const auto inside = [&](const RunRange& range) { return range.holds(figure.run); };
    std::vector<std::int64_t>& runs = chosen[figure.subject];
    if (std::ranges::any_of(ranges, inside) && (runs.empty() || runs.back() != figure.run)) runs.push_back(figure.run);
  }
  std::erase_if(chosen, [&](const auto& subject) {
    return subject.second.empty() || !subject.first.starts_with(options.subject);
  });
  return chosen;
}

// The runs of each subject without repetitions. Nothing is accepted if a subject has too few.
std::size_t counted_runs(const db::Models& store, const std::string& subject, const std::vector<std::int64_t>& runs) {
  return runs.size() - store.repeated_runs(subject, runs).size();
}

void refuse_short(const db::RunStore& store, const std::map<std::string, std::vector<std::int64_t>>& chosen) {
  for (const auto& [subject, runs] : chosen) {
    const std::size_t counted = counted_runs(store, subject, runs);
    if (counted >= analysis::kMinStartUpRuns) continue;
    throw Error(
        "TB-BASELINE-SHORT",
        fmt::format("{} has {} among these runs{}; a chart needs {}, and {} are recommended", subject,
                    analysis::counted(counted, "measurement"), counted < runs.size() ? ", each counted once" : "",
                    analysis::kMinStartUpRuns, analysis::kRecommendedStartUpRuns),
        store.path(),
        subject.starts_with("nightly/")
            ? fmt::format("carry them out with different seeds: tactbench nightly SUITE --db FILE --seeds {}",
                          analysis::kRecommendedStartUpRuns)
            : fmt::format("measure {} more, or accept only other subjects: --subject SUBJECT",
                          analysis::kMinStartUpRuns - counted));
  }
}

void accept_baseline(const BaselineOptions& options, const Session& session) {
  db::RunStore store = db::RunStore::open(session.db);
  const auto chosen = chosen_runs(options, store, session);
  if (chosen.empty())
    throw Error("TB-BASELINE-NO-FIGURES", "none of these runs has stored figures", session.db,
                "nightly --db and fit store figures; tactbench trend lists them");
  refuse_short(store, chosen);
  auto json = nlohmann::ordered_json::array();
  bool few = false;
  for (const auto& [subject, runs] : chosen) {
    const std::int64_t number = store.add_baseline({0, subject, options.reason, options.by, utc_now(), runs});
    const auto repeated = store.repeated_runs(subject, runs);
    const std::size_t counted = runs.size() - repeated.size();
    json.push_back({{"baseline", number}, {"subject", subject}, {"runs", runs}, {"counted", counted}});
    if (session.json) continue;
    few = few || counted < analysis::kRecommendedStartUpRuns;
    tty::print("{:<40} {} runs accepted{}\n", one_line(subject), runs.size(),
               repeated.empty() ? "" : fmt::format(", {} of them counted once each", counted));
    for (const auto& [run, earlier] : repeated)
      tty::print("  run {} repeats run {}: the same content, or the same figures\n", run, earlier);
  }
  if (few)
    tty::print("fewer than {} runs: charts find small shifts later (docs/nights.md)\n",
               analysis::kRecommendedStartUpRuns);
  if (session.json) print_json("trend.accept", {{"store", session.db}, {"baselines", json}});
}

void list_baselines(const Session& session) {
  const db::RunStore store = db::RunStore::open_read_only(session.db);
  auto json = nlohmann::ordered_json::array();
  analysis::doc::Table table{.columns = {{"no.", true}, {"subject"}, {"runs", true}, {"accepted"}, {"by"}, {"reason"}}};
  for (const db::BaselineRecord& baseline : store.baselines()) {
    json.push_back({JSON_FIELDS(baseline, baseline, subject, reason, accepted_by, accepted_utc, runs)});
    table.rows.push_back(
        {{std::to_string(baseline.baseline), one_line(baseline.subject), std::to_string(baseline.runs.size()),
          one_line(baseline.accepted_utc.substr(0, 10)), one_line(baseline.accepted_by), one_line(baseline.reason)}});
  }
  if (session.json) return print_json("trend.baselines", {{"store", session.db}, {"baselines", json}});
  if (json.empty())
    tty::print(
        "no baseline is accepted: tactbench trend accept RUNS --reason TEXT --by NAME accepts runs whose figures "
        "tactbench trend lists, at least {}\n",
        analysis::kMinStartUpRuns);
  else
    print_table(std::move(table));
}

}  // namespace

void add_baseline(CLI::App& trend, Session& session) {
  auto options = std::make_shared<BaselineOptions>();
  CLI::App* accept =
      trend.add_subcommand("accept",
                           "accept runs as the baseline of later ones\n"
                           "Later figures of each subject are compared with the spread of these runs, at "
                           "least 8, better 20. Replaces the previous baseline.");
  accept
      ->add_option("runs", options->runs,
                   "numbers and ranges, e.g. 1-88 90; runs without figures are skipped, runs that repeat another "
                   "(equal seeds and content, or equal figures) count once")
      ->required();
  accept->add_option("--subject", options->subject,
                     "only this subject, or subjects with this beginning (trend lists them)");
  accept->add_option("--reason", options->reason, "why these runs serve as reference")->required();
  session.profile.add(*accept, "--by", ProfileKey::kOperator, options->by, "name of the person who accepts them")
      ->required();
  accept->callback([options, &session] { accept_baseline(*options, session); });
  CLI::App* list =
      trend.add_subcommand("baselines", "list the accepted baselines; the last one of a subject is in use");
  list->callback([&session] { list_baselines(session); });
}

}  // namespace tactbench::bench
