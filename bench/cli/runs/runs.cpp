#include "bench/cli/runs/runs.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <ranges>
#include <sstream>
#include <string_view>

#include "analysis/counted.h"
#include "analysis/documents/run_json.h"
#include "analysis/error.h"
#include "analysis/json_fields.h"
#include "analysis/json_io.h"
#include "analysis/report/document/document.h"
#include "analysis/report/report_facts.h"
#include "bench/cli/judgement_output.h"
#include "bench/cli/session.h"
#include "bench/common/error.h"
#include "bench/common/utc.h"
#include "bench/config/config_calibration.h"
#include "bench/monitor/run_view.h"
#include "bench/reporting/judgement.h"
#include "bench/run/control/locks.h"
#include "bench/run/run_record.h"

namespace tactbench::bench {

namespace {

// "7d": seven days ago.
std::string since_utc(const std::string& since) {
  int days = 0;
  const char *const begin = since.data(), *const end = begin + since.size();
  const auto read = std::from_chars(begin, end, days);
  if (read.ec == std::errc() && days >= 0 && days <= 36500 && std::string_view(read.ptr, end) == "d")
    return utc_days_ago(days);
  if (analysis::is_date(since.substr(0, 10)) && (since.size() == 10 || since[10] == 'T')) return since;
  throw Error("TB-USAGE", fmt::format("'{}' is neither a date nor a number of days", since), "--since",
              "write it as 7d, 2026-01-31, or 2026-01-31T12:00:00Z (UTC)");
}

// "2026-01-31 12:00".
std::string minute_of(const std::string& utc) {
  std::string text = utc.substr(0, 16);
  std::ranges::replace(text, 'T', ' ');
  return one_line(text);
}

// As JSON has it.
std::string verdict_cell(std::optional<analysis::Verdict> verdict, const std::string& origin) {
  return verdict ? shown_verdict(*verdict, origin) : "-";
}

// The recipes' names; of a table with many sequences the first ones.
std::string recipe_cell(const db::RunRecord& run) {
  constexpr std::size_t kShown = 3;
  std::vector<std::string> names;
  for (const db::SequenceRecord& sequence : run.sequences | std::views::take(kShown)) names.push_back(sequence.name);
  const std::size_t more = run.sequences.size() - names.size();
  return fmt::format("{}{}", fmt::join(names, ", "), more == 0 ? "" : fmt::format(" and {} more", more));
}

std::string lot_of(const db::RunRecord& run) {
  const std::map<std::string, std::string> metadata = analysis::metadata_of(run);
  const auto lot = metadata.find("lot");
  return lot == metadata.end() ? std::string() : lot->second;
}

std::vector<std::string> tags_but_lot(const db::RunRecord& run) {
  std::vector<std::string> tags = run.tags;
  std::erase(tags, "lot=" + lot_of(run));
  return tags;
}

// The finding; without one, the figures.
std::string check_line(const db::CheckRecord& check) {
  const auto detail = analysis::try_ordered_json(check.detail_json);
  std::vector<std::string> parts;
  for (const auto& finding : detail.value("findings", nlohmann::ordered_json::array())) {
    parts.push_back(finding.value("text", ""));
  }
  if (!parts.empty()) return fmt::format("{}", fmt::join(parts, "; "));
  for (const auto& [key, value] : detail.items()) {
    if (value.is_number_float()) {
      parts.push_back(fmt::format("{} {:.4g}", key, value.get<double>()));
    } else if (!value.is_structured() || !value.empty()) {
      parts.push_back(fmt::format("{} {}", key, analysis::json_line(value)));
    }
  }
  return fmt::format("{}", fmt::join(parts, ", "));
}

}  // namespace

RunsList::RunsList(const RunsListOptions& options, const Session& session)
    : options_(options),
      session_(session),
      wanted_(options.verdict),
      rows_(std::make_unique<nlohmann::ordered_json>(nlohmann::ordered_json::array())) {
  table_.columns = {{"run", true}, {"started (UTC)"}, {"sensor"},
                    {"lot"},       {"origin"},        {"outcome"},
                    {"verdict"},   {"frames", true},  {.title = "recipes; purpose [tags]", .cut = true}};
}

bool RunsList::takes(const db::RunRecord& run, std::optional<analysis::Verdict> verdict) {
  if (!options_.outcome.empty() && options_.outcome != db::to_string(run.outcome) &&
      !(options_.outcome == kNotCompleted && run.outcome != db::Outcome::kCompleted))
    return false;
  if (!options_.tag.empty() && std::ranges::find(run.tags, options_.tag) == run.tags.end()) return false;
  if (!fits_metadata(options_.metadata, run) || !wanted_.fits(verdict, run.origin)) return false;
  const bool left_out = run.is_void() && !options_.all;
  if (left_out) ++left_out_;
  return !left_out;
}

void RunsList::add(const ListedRun& listed, nlohmann::ordered_json row) {
  const db::RunRecord& run = listed.run;
  ++listed_;
  const std::string verdict = verdict_cell(listed.verdict, run.origin);
  if (session_.json) {
    row["frames"] = listed.frames;
    if (listed.pruned) row["frames_pruned"] = listed.pruned->frames;
    row["verdict"] = verdict;
    row["rests_on_means_alone"] = listed.means_alone;
    if (listed.lives) row["lives"] = *listed.lives;
    rows_->push_back(std::move(row));
    return;
  }
  const std::vector<std::string> tags = tags_but_lot(run);
  const std::string remarks =
      fmt::format("{}{}{}{}{}{}", run.is_void() ? fmt::format("VOID: {}; ", run.void_reason) : "",
                  !listed.lives   ? ""
                  : *listed.lives ? "under way; "
                                  : "no process carries it out; ",
                  listed.pruned ? fmt::format("{} removed; ", analysis::counted(listed.pruned->frames, "frame")) : "",
                  recipe_cell(run), run.purpose.empty() ? "" : "; " + run.purpose,
                  tags.empty() ? "" : fmt::format(" [{}]", fmt::join(tags, " ")));
  const std::string word =
      listed.verdict ? to_string(*listed.verdict) + std::string(listed.means_alone ? ", means" : "") : "-";
  table_.rows.push_back({{std::to_string(run.run), minute_of(run.started_utc), one_line(run.sensor_serial),
                          one_line(lot_of(run)), run.origin, db::to_string(run.outcome), word,
                          std::to_string(listed.frames), one_line(remarks, kMaxTextLength)}});
}

void RunsList::end(bool any_stored) {
  if (session_.json) return print_json("runs.list", {{"runs", *rows_}, {"void_left_out", left_out_}});
  // Columns with the same value in all rows are stated once, above; lots are kept so that they can be searched.
  constexpr std::ptrdiff_t kLot = 3, kOrigin = 4, kOutcome = 5;
  std::vector<std::string> of_all;
  for (const std::ptrdiff_t column : {kOutcome, kOrigin, kLot}) {
    const auto cell = [column](const analysis::doc::Row& row) {
      return text_of(row.cells[static_cast<std::size_t>(column)], analysis::PressureUnit::kPsi);
    };
    const std::string same = listed_ > 0 ? cell(table_.rows.front()) : std::string();
    if (std::ranges::any_of(table_.rows, [&](const auto& row) { return cell(row) != same; })) continue;
    if (column == kLot && !same.empty()) continue;
    table_.columns.erase(table_.columns.begin() + column);
    for (analysis::doc::Row& row : table_.rows) row.cells.erase(row.cells.begin() + column);
    if (column != kLot && same != "hardware") of_all.push_back(same);
  }
  if (!of_all.empty()) table_.caption = fmt::format("all {}", fmt::join(of_all, ", "));
  if (listed_ > 0) print_table(std::move(table_));
  if (left_out_ > 0) {
    tty::print("{} void {} left out (--all)\n", left_out_, left_out_ == 1 ? "run" : "runs");
  } else if (listed_ == 0) {
    tty::print("{}\n",
               any_stored ? "no stored run matches all options" : "no runs are stored: tactbench run stores one");
  }
}

namespace {

// Prints one judgement per pair of models and limits.
void print_judgements(const std::vector<analysis::JudgedFigure>& verdicts, const std::string& origin,
                      const Session& session) {
  std::vector<analysis::Judgement> judgements;
  for (const analysis::JudgedFigure& verdict : verdicts) {
    const auto same = std::ranges::find_if(judgements, [&](const analysis::Judgement& judgement) {
      const analysis::JudgedFigure& front = judgement.figures.front();
      return front.model_run == verdict.model_run && front.limits_sha256 == verdict.limits_sha256;
    });
    (same == judgements.end() ? judgements.emplace_back() : *same).figures.push_back(verdict);
  }
  for (analysis::Judgement& judgement : judgements) {
    conclude(judgement);
    if (judgements.size() > 1)
      tty::print("models of {}, limits sha256 {}\n",
                 judgement.figures.front().model_run == 0 ? "no stored run"
                                                          : fmt::format("run {}", judgement.figures.front().model_run),
                 judgement.figures.front().limits_sha256.substr(0, 12));
    analysis::doc::Document out = judgement_document(judgement, origin, session.unit(), session.all);
    if (session.quiet) out.blocks.resize(1);
    print_document(out, session.unit());
  }
}

// Which simulated sensor it was; empty for another origin, or where the bench's text can no longer be read.
std::string specimen_text(const db::RunRecord& run) {
  if (run.origin != "simulated") return {};
  const std::optional<BenchConfig> bench = stored_bench(run);
  if (!bench || !bench->simulation) return {};
  return keyword_of(bench->simulation->plant.specimen.kind);
}

}  // namespace

void show_run(std::int64_t number, const Session& session, bool all_events) {
  const db::RunStore store = db::RunStore::open_read_only(session.db);
  const db::RunRecord run = store.run(number);
  const auto [verdicts, verdict, means_alone] = standing(store, number);
  const std::string word = verdict_cell(verdict, run.origin);
  const std::vector<db::EventRecord> events = store.events(number);
  const std::vector<db::CheckRecord> checks = store.checks(number);
  const std::optional<db::PrunedRecord> pruned = store.pruned(number);
  const std::vector<db::FitRecord> fits = store.fits(number);
  if (session.json) {
    nlohmann::ordered_json json = analysis::run_json(run);
    json["frames"] = store.frame_count(number);
    if (pruned)
      json["pruned"] = {{"frames", pruned->frames}, {"rule", pruned->rule}, {"pruned_utc", pruned->pruned_utc}};
    if (const std::string specimen = specimen_text(run); !specimen.empty()) json["specimen"] = specimen;
    json["events"] = nlohmann::ordered_json::array();
    for (const db::EventRecord& event : events) {
      json["events"].push_back(
          {{"time_s", static_cast<double>(event.time_ns) * 1e-9}, JSON_FIELDS(event, kind, id, detail)});
    }
    json["checks"] = nlohmann::ordered_json::array();
    for (const db::CheckRecord& check : checks) {
      json["checks"].push_back({{"time_s", static_cast<double>(check.time_ns) * 1e-9},
                                JSON_FIELDS(check, kind, verdict),
                                {"detail", analysis::ordered_json_or_null(check.detail_json)}});
    }
    json["models"] = nlohmann::ordered_json::array();
    for (const db::FitRecord& fit : fits)
      json["models"].push_back({{"model", fmt::format("{}:{}", number, fit.fit)},
                                {"fit", fit.fit},
                                {"kind", fit.model},
                                {"fitted_taxels", fit.fitted},
                                {"created", fit.created_utc},
                                {"program", fit.program_version}});
    json["verdict"] = word;
    json["rests_on_means_alone"] = means_alone;
    json["verdicts"] = verdicts_json(verdicts, run.origin);
    print_json("runs.show", json);
    return;
  }
  print_judgements(verdicts, run.origin, session);
  if (session.quiet && !verdicts.empty()) return;
  namespace doc = analysis::doc;
  std::vector<std::pair<std::string, doc::Phrase>> lines;
  const auto line = [&](const char* name, const std::string& value) {
    lines.emplace_back(name, value.empty() ? "not stated" : one_line(value, kMaxTextLength));
  };
  const bool all = session.all || all_events;
  const auto at = [](std::int64_t time_ns) {
    return fmt::format("{:9.3f} s of process time", static_cast<double>(time_ns) * 1e-9);
  };
  if (run.is_void()) line("VOID", fmt::format("{} ({}, {})", run.void_reason, run.void_by, run.void_utc));
  line("run", fmt::format("{}, {}, {} ({})", run.run, run.origin, db::to_string(run.outcome), run.reason));
  line("safe state", db::to_string(run.safe_state));
  line("sensor", fmt::format("{}, scanner {}", analysis::or_not_stated(run.sensor_serial),
                             analysis::or_not_stated(analysis::scanner_serial_of(run))));
  if (const std::string specimen = specimen_text(run); !specimen.empty()) line("specimen", specimen);
  line("started",
       fmt::format("{}, ended {} (wall time, UTC)", run.started_utc, analysis::or_not_stated(run.ended_utc)));
  line("by", analysis::or_not_stated(run.operator_name) + (run.purpose.empty() ? "" : "; " + run.purpose));
  line("bench", run.bench_id);
  if (!run.tags.empty()) line("tags", fmt::format("{}", fmt::join(run.tags, " ")));
  std::istringstream notes(run.notes);
  for (std::string note; std::getline(notes, note);) line("note", note);
  std::vector<std::string> recipes;
  for (const db::SequenceRecord& sequence : run.sequences)
    recipes.push_back(fmt::format("{} ({} x {})", sequence.name, sequence.repeats, sequence.frames_per_repeat));
  line("recipes", fmt::format("{}", fmt::join(recipes, ", ")));
  line("frames", pruned ? fmt::format("none: {} were removed on {} by the rule: {}", pruned->frames, pruned->pruned_utc,
                                      pruned->rule)
                        : std::to_string(store.frame_count(number)));
  for (const db::FitRecord& fit : fits)
    line("model", fmt::format("{}:{}: {}, {}, {}", number, fit.fit, fit.model, analysis::counted(fit.fitted, "taxel"),
                              fit.created_utc));
  for (const db::DeviceRecord& device : run.devices) {
    // Devices with a certificate; the bench file states none for a scanner or a module.
    const bool calibrated = device.calibration_json.find("\"certificate\"") != std::string::npos;
    if (!all && !calibrated) continue;
    line("device", fmt::format("{}: {}, serial {}, {}{}", device.role, device.model,
                               device.serial.empty() ? "not stated" : device.serial, device.origin,
                               calibrated ? "; " + calibration_text(analysis::calibration_of(device), run.started_utc,
                                                                    session.unit())
                                          : ""));
  }
  for (const db::CheckRecord& check : checks)
    if (all || check.verdict != "pass")
      line("check", fmt::format("{}  {} {}: {}", at(check.time_ns), check.kind, check.verdict, check_line(check)));
  for (const db::EventRecord& event : events) {
    if (event.kind == "time") line("time", event.detail);
    if (all_events || shows_progress(event))
      line("event", fmt::format("{}  {} {} {}", at(event.time_ns), event.kind, event.id, event.detail));
  }
  if (all) {
    line("uuid", run.uuid);
    line("program", fmt::format("{} ({}{})", run.program_version, run.git_commit, run.git_dirty ? ", modified" : ""));
    line("content", run.content_sha256);
    line("bench file", "sha256 " + run.bench_sha256);
    for (const db::SequenceRecord& sequence : run.sequences)
      line("recipe file", fmt::format("{}: sha256 {}", sequence.name, sequence.recipe_sha256));
  }
  doc::Document out;
  out.add(doc::pairs({}, std::move(lines)));
  print_document(out, session.unit());
}

void add_runs_list_options(CLI::App& verb, RunsListOptions& options) {
  verb.add_option("--sensor", options.sensor, "only this sensor");
  verb.add_option("--since", options.since,
                  "started on this day (UTC, 2026-01-31), or so many days ago (7d), or later");
  verb.add_option("--outcome", options.outcome, "only runs with this outcome")
      ->check(CLI::IsMember({kNotCompleted, "completed", "stopped", "aborted", "failed", "interrupted", "incomplete"}));
  verb.add_option("--tag", options.tag, "only with this tag");
  add_metadata_options(verb, options.metadata, true);
  verb.add_option("--verdict", options.verdict, "only with this verdict, on the run or on its models; none: not judged")
      ->type_name(VerdictFilter::type_name());
  verb.add_flag("--all", options.all, "include void runs");
}

namespace {

// of session.db
void list_runs(const RunsListOptions& options, const Session& session) {
  const std::string since = options.since.empty() ? "" : since_utc(options.since);
  const db::RunStore store = db::RunStore::open_read_only(session.db);
  RunsList list(options, session);
  for (const db::RunRecord& run : store.runs({.sensor_serial = options.sensor, .since_utc = since})) {
    const Standing stands = standing(store, run.run);
    if (!list.takes(run, stands.verdict)) continue;
    // Frames are numbered from 1.
    ListedRun listed{store.run(run.run), stands.verdict, stands.rests_on_means_alone, store.last_position(run.run),
                     store.pruned(run.run)};
    if (run.outcome == db::Outcome::kIncomplete) listed.lives = is_carried_out(store.path(), run.run);
    list.add(listed, session.json ? analysis::run_json(listed.run) : nlohmann::ordered_json());
  }
  list.end(!store.runs().empty());
}

}  // namespace

void add_runs(CLI::App& app, Session& session) {
  CLI::App* runs = app.add_subcommand("runs", "list, show, void, export, import, copy stored runs");
  runs->require_subcommand(1);
  auto options = std::make_shared<RunsListOptions>();
  CLI::App* list_verb = runs->add_subcommand("list", "one line per run");
  add_runs_list_options(*list_verb, *options);
  list_verb->callback([options, &session] { list_runs(*options, session); });
  auto number = std::make_shared<std::int64_t>(0);
  CLI::App* show_verb = runs->add_subcommand("show", "everything stored about a run");
  auto all_events = std::make_shared<bool>(false);
  show_verb->add_option("run", *number, "run number")->required();
  show_verb->add_flag("--events", *all_events, "all events, also commands to actuators and readings");
  add_all(*show_verb, session);
  show_verb->callback([number, all_events, &session] { show_run(*number, session, *all_events); });
  add_subverbs(*runs, session);
}

namespace {

constexpr std::size_t kLongestTag = 64;

[[noreturn]] void refuse_metadata(const std::string& what, const char* option, const std::string& remedy) {
  throw Error("TB-USAGE", what, option, remedy);
}

std::string metadata_tag(const std::string& key, const std::string& value, const char* option) {
  std::string tag = key + "=" + value;
  const auto plain = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
           std::string_view("._:/+-").find(c) != std::string_view::npos;
  };
  if (key.empty() || value.empty() || tag.size() > kLongestTag || !std::ranges::all_of(key, plain) ||
      !std::ranges::all_of(value, plain))
    refuse_metadata(fmt::format("'{}' cannot be recorded as metadata", tag), option,
                    "key and value are words of letters, digits and . _ : / + -, together at most 63 of them; write "
                    "sentences into --purpose or a note");
  return tag;
}

}  // namespace

void add_metadata_options(CLI::App& verb, MetadataOptions& options, bool filter) {
  verb.add_option("--lot", options.lot, filter ? "only of this lot" : "lot that the sensor comes from; recorded");
  verb.add_option("--order", options.order,
                  filter ? "only of this order" : "order that the run is for; recorded, and printed on the report");
  verb.add_option("--meta", options.pairs,
                  filter ? "only with this metadata: KEY=VALUE, or KEY with any value"
                         : "further metadata as KEY=VALUE; recorded, and printed on the report")
      ->take_all();
}

std::vector<std::string> metadata_tags(const MetadataOptions& options) {
  std::vector<std::string> tags, keys;
  const auto add = [&](const std::string& key, const std::string& value, const char* option) {
    if (std::ranges::find(keys, key) != keys.end())
      refuse_metadata(fmt::format("'{}' is named twice", key), option,
                      "name each key once; --lot and --order are the keys lot and order");
    keys.push_back(key);
    tags.push_back(metadata_tag(key, value, option));
  };
  if (!options.lot.empty()) add("lot", options.lot, "--lot");
  if (!options.order.empty()) add("order", options.order, "--order");
  for (const std::string& text : options.pairs) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos)
      refuse_metadata(fmt::format("'{}' is not KEY=VALUE", text), "--meta", "e.g. --meta film=B12");
    add(text.substr(0, equals), text.substr(equals + 1), "--meta");
  }
  return tags;
}

bool fits_metadata(const MetadataOptions& asked, const db::RunRecord& run) {
  const std::map<std::string, std::string> metadata = analysis::metadata_of(run);
  const auto has = [&](const std::string& key, const std::string& value) {
    const auto found = metadata.find(key);
    return found != metadata.end() && found->second == value;
  };
  if (!asked.lot.empty() && !has("lot", asked.lot)) return false;
  if (!asked.order.empty() && !has("order", asked.order)) return false;
  return std::ranges::all_of(asked.pairs, [&](const std::string& text) {
    const std::size_t equals = text.find('=');
    return equals == std::string::npos ? metadata.contains(text) : has(text.substr(0, equals), text.substr(equals + 1));
  });
}

}  // namespace tactbench::bench
