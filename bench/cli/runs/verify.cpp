#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>

#include "analysis/counted.h"
#include "analysis/json_fields.h"
#include "bench/cli/runs/source.h"
#include "bench/cli/session.h"
#include "bench/reporting/verification.h"
#include "db/run_store.h"

namespace tactbench::bench {

namespace {

nlohmann::ordered_json result_json(const VerifiedResult& result) {
  return {JSON_FIELDS(result, what, fit, fit_run, rows, recomputed, compared, difference)};
}

nlohmann::ordered_json pruned_json(const std::optional<db::PrunedRecord>& pruned) {
  if (!pruned) return nullptr;
  return {{"frames", pruned->frames}, {"rule", pruned->rule}, {"pruned_utc", pruned->pruned_utc}};
}

void print_result(const VerifiedResult& result) {
  const std::string name = result.what == "verdicts" ? analysis::counted(result.rows, "verdict")
                                                     : fmt::format("fit {} ({})", result.fit, result.what);
  const std::string state = !result.difference.empty() ? fmt::format("DIFFER: {}", result.difference)
                            : result.recomputed        ? "equal"
                                                       : "";
  tty::print("  {:<14}{}{}{}\n", name + " ", state, state.empty() ? "" : "; ", result.compared);
}

void verify(std::int64_t number, Session& session) {
  const db::RunStore store = db::RunStore::open_read_only(session.db);
  const db::RunRecord run = store.run(number);
  if (run.outcome == db::Outcome::kIncomplete) {
    throw Error("TB-VERIFY-NOT-ENDED",
                fmt::format("run {} has not ended, so it has no hash to compare with yet", number), session.db);
  }
  const RunVerification verified = verify_run(store, number);
  const auto& [content, changed_records, results, first] = verified;
  if (!content.holds() || !changed_records.empty()) {
    session.code = ExitCode::kStore;
  } else if (!first.empty()) {
    session.code = ExitCode::kCriterionFailed;
  } else if (content.pruned) {
    session.code = ExitCode::kInconclusive;
  }
  if (session.json) {
    auto list = nlohmann::ordered_json::array();
    for (const VerifiedResult& result : results) list.push_back(result_json(result));
    print_json("verify",
               {{"run", number},
                {"origin", run.origin},
                {"holds", first.empty()},
                {"pruned", pruned_json(content.pruned)},
                {"first_difference", first},
                {"content", {{"holds", content.holds()}, JSON_FIELDS(content, frames, stored_sha256, computed_sha256)}},
                {"beside", changed_records},
                {"analysis", list}});
    return;
  }
  tty::print("run {} ({}), {}\n", number, run.origin, analysis::counted(content.frames, "frame"));
  if (content.pruned && content.holds()) {
    tty::print("  {:<14}removed on {}, by the rule: {}. They were not checked, and nothing was recomputed from them\n",
               "frames", content.pruned->pruned_utc, one_line(content.pruned->rule));
    tty::print("  {:<14}as it was stored: row, sequences, devices, branches, events, checks; sha256 {}\n", "all else",
               content.computed_sha256);
  } else if (content.holds()) {
    tty::print("  {:<14}as it was stored, sha256 {}\n", "content", content.computed_sha256);
  } else {
    tty::print("  {:<14}DIFFERS: {}\n  {:<14}stored sha256 {}, recomputed {}; the analysis was not checked\n",
               "content", content.difference, "", content.stored_sha256, content.computed_sha256);
  }
  for (const std::string& line : changed_records) tty::print("  {:<14}{}\n", "CHANGED", line);
  for (const VerifiedResult& result : results) print_result(result);
  if (content.holds() && results.empty()) tty::print("  {:<14}no stored fit, no verdict\n", "analysis");
  const char* well = content.pruned ? "the remaining data are verified; the frames are not there" : "verified";
  tty::print("{}\n", first.empty() ? well : fmt::format("NOT verified; first difference: {}", first));
}

void verify_store(Session& session) {
  const std::string& path = session.db;
  const db::RunStore store = db::RunStore::open_read_only(path);
  const std::vector<std::string> structure = store.check_structure();
  auto list = nlohmann::ordered_json::array();
  int sound = 0, differ = 0, open = 0, pruned = 0;
  if (!session.json) {
    for (const std::string& line : structure) tty::print("  file    {}\n", line);
  }
  for (const db::RunRecord& run : store.runs()) {
    const db::ContentCheck content = store.check_content(run.run);
    const std::vector<std::string> changed_records = store.check_seals(run.run);
    const bool ended = run.outcome != db::Outcome::kIncomplete, holds = content.holds() && changed_records.empty();
    ++(!holds ? differ : ended ? sound : open);
    pruned += content.pruned ? 1 : 0;
    list.push_back({{"run", run.run},
                    {"ended", ended},
                    {"holds", holds},
                    {"pruned", content.pruned.has_value()},
                    JSON_FIELDS(content, frames, difference),
                    {"beside", changed_records}});
    if (session.json) continue;
    if (!content.holds()) tty::print("  run {:<4}{}\n", run.run, content.difference);
    for (const std::string& line : changed_records) tty::print("  run {:<4}{}\n", run.run, line);
  }
  const bool well = structure.empty() && differ == 0;
  if (!well) session.code = ExitCode::kStore;
  if (session.json) {
    print_json("verify.store", {{"store", path}, {"holds", well}, {"structure", structure}, {"runs", list}});
    return;
  }
  tty::print("{}: structure {}; {}, {} not, {} not ended (no hash yet)\n", path,
             structure.empty() ? "sound" : "DAMAGED",
             analysis::counted(sound, "run as it was stored", "runs as they were stored"), differ, open);
  if (pruned > 0)
    tty::print("of {} the frames were removed by a rule (db prune): they were not checked\n",
               analysis::counted(pruned, "run"));
  if (!well)
    tty::print("keep a copy of the file and use the last snapshot; tactbench verify RUN shows more about a run\n");
}

}  // namespace

void add_verify(CLI::App& app, Session& session) {
  auto run = std::make_shared<std::string>();
  auto from = std::make_shared<std::string>();
  CLI::App* verb = app.add_subcommand("verify",
                                      "check that a run, or the whole store, is unchanged since it was stored\n"
                                      "Of a run the content hash and the analysis are recomputed from the raw frames, "
                                      "and the first difference is named; "
                                      "of the store the file's structure, every run's content hash, and the hashes of "
                                      "its fits, verdicts, approvals and "
                                      "voids.");
  verb->add_option("run", *run, "run number; with --from also a UUID; none: the whole store");
  add_from_option(*verb, *from);
  verb->footer(
      "Exit codes: 0 all as stored, 1 a recomputed fit or verdict differs, 5 content, fits, verdicts, approvals or "
      "voids were changed, 6 not ended, or the frames were removed by a rule (db prune).");
  verb->callback([run, from, &session] {
    if (run->empty() && !from->empty())
      throw Error("TB-USAGE", "with --from one run is verified, but none is named", "--from", "name it by its UUID");
    if (run->empty()) return verify_store(session);
    if (from->empty()) return verify(run_number(*run), session);
    FleetImport fleet(session, *from);
    const db::fleet::FleetRun named = find_run_by_name(fleet.link(), *run);
    fleet.take({named}, with_dependencies(fleet.link(), named));
    verify(named.run, session);
  });
}

}  // namespace tactbench::bench
