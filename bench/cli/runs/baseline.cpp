#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>

#include "analysis/counted.h"
#include "analysis/json_fields.h"
#include "bench/cli/runs/source.h"
#include "bench/cli/session.h"
#include "bench/common/utc.h"
#include "bench/nightly/followed.h"
#include "bench/reporting/named_runs.h"

namespace tactbench::bench {
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

// Each subject's runs without those that repeat another one. Nothing is accepted when one has too few.
std::size_t counted_runs(const db::RunStore& store, const std::string& subject, const std::vector<std::int64_t>& runs) {
  return runs.size() - store.repeated_runs(subject, runs).size();
}

void refuse_short(const db::RunStore& store, const std::map<std::string, std::vector<std::int64_t>>& chosen) {
  for (const auto& [subject, runs] : chosen) {
    const std::size_t counted = counted_runs(store, subject, runs);
    if (counted >= analysis::kLeastStartUp) continue;
    throw Error(
        "TB-BASELINE-SHORT",
        fmt::format("{} has {} among these runs{}; a chart needs {}, and {} are recommended", subject,
                    analysis::counted(counted, "measurement"), counted < runs.size() ? ", each counted once" : "",
                    analysis::kLeastStartUp, analysis::kRecommendedStartUp),
        store.path(),
        subject.starts_with("nightly/")
            ? fmt::format("carry them out with seeds of their own: tactbench nightly SUITE --db FILE --seeds {}",
                          analysis::kRecommendedStartUp)
            : fmt::format("measure {} more, or accept other subjects alone: --subject SUBJECT",
                          analysis::kLeastStartUp - counted));
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
    few = few || counted < analysis::kRecommendedStartUp;
    tty::print("{:<40} {} runs accepted{}\n", one_line(subject), runs.size(),
               repeated.empty() ? "" : fmt::format(", {} of them counted once each", counted));
    for (const auto& [run, earlier] : repeated)
      tty::print("  run {} repeats run {}: the same content, or the same figures\n", run, earlier);
  }
  if (few)
    tty::print("fewer than {} runs: charts find small shifts later (docs/nights.md)\n", analysis::kRecommendedStartUp);
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
        analysis::kLeastStartUp);
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
  accept->add_option("--subject", options->subject, "only this subject, or those that begin so (trend lists them)");
  accept->add_option("--reason", options->reason, "why these runs serve as reference")->required();
  session.profile.add(*accept, "--by", ProfileKey::kOperator, options->by, "name of the person who accepts them")
      ->required();
  accept->callback([options, &session] { accept_baseline(*options, session); });
  CLI::App* list = trend.add_subcommand("baselines", "list the accepted baselines; a subject's last one counts");
  list->callback([&session] { list_baselines(session); });
}

}  // namespace tactbench::bench
