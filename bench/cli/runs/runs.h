// --lot, --order and --meta KEY=VALUE on the command line. They become tags of the run, "lot=A7"
// (analysis/documents/run_json.h).
#pragma once

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "analysis/judgement/figure.h"
#include "bench/cli/session.h"
#include "bench/common/error.h"
#include "db/record.h"
#include "sequences/toml/strict_toml.h"

namespace CLI {
class App;
}

namespace tactbench::bench {

struct MetadataOptions {
  std::string lot, order;
  std::vector<std::string> pairs;  // KEY=VALUE
};
// Options to record with a run, or to filter runs (`filter`: --meta KEY without a value only requires the key).
void add_metadata_options(CLI::App& verb, MetadataOptions& options, bool filter = false);

// The options as tags. Throws Error TB-USAGE for a pair without "=", a key named twice, or an invalid tag
// (db::Remarks::set_tags).
std::vector<std::string> metadata_tags(const MetadataOptions& options);
// Whether a run's metadata matches the filter.
bool fits_metadata(const MetadataOptions& asked, const db::RunRecord& run);

// Parser and filter of the option --verdict of `runs list`.

// Parses --verdict, with the words of the list's column: "conditional pass" or conditional-pass; with a leading
// "simulated" only simulated runs; none or "-" for runs without a verdict.
class VerdictFilter {
 public:
  explicit VerdictFilter(const std::string& typed) : any_(typed.empty()) {
    if (any_) return;
    std::string word = typed == "-" ? kNone : typed;
    std::ranges::replace(word, '-', ' ');
    simulated_ = word.starts_with(kSimulated);
    if (simulated_) word.erase(0, kSimulated.size());
    verdict_ = analysis::verdict_from(word);
    const std::vector<std::string> known = words();
    if (std::ranges::find(known, word) != known.end()) return;
    const std::string near = sequences::nearest_word(word, known);
    throw Error("TB-USAGE", fmt::format("there is no verdict '{}'", typed), "--verdict",
                fmt::format("{}one of: {}", near.empty() ? "" : fmt::format("did you mean '{}'? ", near),
                            fmt::join(known, ", ")));
  }

  [[nodiscard]] bool fits(std::optional<analysis::Verdict> verdict, const std::string& origin) const {
    return any_ || (verdict == verdict_ && (!simulated_ || origin == "simulated"));
  }

  static std::vector<std::string> words() {
    std::vector<std::string> all = analysis::verdict_names();
    all.emplace_back(kNone);
    return all;
  }
  // For --help and completion, without blanks, which would split the word.
  static std::string type_name() {
    std::string text = fmt::format("TEXT:{{{}}}", fmt::join(words(), ","));
    std::ranges::replace(text, ' ', '-');
    return text;
  }

 private:
  static constexpr const char* kNone = "none";
  static constexpr std::string_view kSimulated = "simulated ";
  bool any_ = false, simulated_ = false;
  std::optional<analysis::Verdict> verdict_;
};

// The list of a store's runs, and everything stored about one run; shared by `runs` and `fleet runs|show`.
inline constexpr const char* kNotCompleted = "not-completed";  // --outcome: any outcome other than completed

struct RunsListOptions {
  std::string sensor, since, tag, verdict, outcome;  // empty: any
  MetadataOptions metadata;
  bool all = false;  // include void runs
};
void add_runs_list_options(CLI::App& verb, RunsListOptions& options);

// A run as the list shows it.
struct ListedRun {
  db::RunRecord run;  // with its sequences
  std::optional<analysis::Verdict> verdict = {};
  bool means_alone = false;  // the verdict is based on the means of the array alone
  std::int64_t frames = 0;
  std::optional<db::PrunedRecord> pruned = {};
  std::optional<bool> lives = {};  // for a run that has not ended: whether a process carries it out
};

class RunsList {
 public:
  RunsList(const RunsListOptions& options, const Session& session);  // throws Error TB-USAGE
  // Whether the run matches the options; sensor and start are not checked here.
  [[nodiscard]] bool takes(const db::RunRecord& run, std::optional<analysis::Verdict> verdict);
  // `row`: run_json() of the run, to which members are added; only used with --json.
  void add(const ListedRun& listed, nlohmann::ordered_json row);
  void end(bool any_stored);  // prints the remaining lines

 private:
  const RunsListOptions& options_;
  const Session& session_;
  VerdictFilter wanted_;
  std::unique_ptr<nlohmann::ordered_json> rows_;
  analysis::doc::Table table_;
  int left_out_ = 0, listed_ = 0;
};

// `all_events`: also commands to actuators and readings.
void show_run(std::int64_t number, const Session& session, bool all_events = false);

}  // namespace tactbench::bench
