// runs tag, note, void: remarks on a run after its end. None of them is part of the content that `verify` checks.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>

#include "analysis/documents/run_json.h"
#include "bench/cli/session.h"
#include "bench/common/utc.h"
#include "bench/reporting/signed_reports.h"
#include "db/run_store.h"

namespace tactbench::bench {

namespace {

struct RunRemark {
  std::int64_t run = 0;
  std::vector<std::string> tags;
  bool remove = false;
  std::string text, by;
};

// A verb that changes an existing store does not make a new one.
db::RunStore store_for_remark(const Session& session, std::int64_t run) {
  (void)db::RunStore::open_read_only(session.db).run(run);
  return db::RunStore::open(session.db);
}

void report_remark(const std::string& verb, const db::RunRecord& run, const std::string& text, const Session& session) {
  if (session.json) {
    print_json(verb, analysis::run_json(run));
  } else {
    tty::print("run {}: {}\n", run.run, text);
  }
}

void tag_run(const RunRemark& remark, const Session& session) {
  db::RunStore store = store_for_remark(session, remark.run);
  const std::vector<std::string> none;
  store.set_tags(remark.run, remark.remove ? none : remark.tags, remark.remove ? remark.tags : none);
  const db::RunRecord run = store.run(remark.run);
  report_remark("runs.tag", run, run.tags.empty() ? "no tags" : fmt::format("tags {}", fmt::join(run.tags, " ")),
                session);
}

void note_run(const RunRemark& remark, const Session& session) {
  db::check_nonblank_text("the note", remark.text, db::kMaxTextLength);  // without the time that is put before it
  db::RunStore store = store_for_remark(session, remark.run);
  store.add_note(remark.run, fmt::format("{} {}", utc_now(), remark.text));
  report_remark("runs.note", store.run(remark.run), "noted", session);
}

void void_run(const RunRemark& remark, const Session& session) {
  db::RunStore store = store_for_remark(session, remark.run);
  store.void_run(remark.run, remark.text, remark.by, utc_now());
  const std::vector<db::ReportRecord> affected = reports_based_on(store, remark.run);
  if (session.json) {
    nlohmann::ordered_json json = analysis::run_json(store.run(remark.run));
    for (const db::ReportRecord& report : affected) json["signed_reports"].push_back(report.number);
    return print_json("runs.void", json);
  }
  tty::print("run {}: void, by {}: {}; it is kept\n", remark.run, remark.by, remark.text);
  for (const db::ReportRecord& report : affected)
    tty::print(
        "warning: the report {}, signed by {} on {}, is based on this run: withdraw it, and write a new report of run "
        "{}\n",
        report.number, one_line(report.approved_by), report.approved_utc, report.run);
}

}  // namespace

void add_run_remarks(CLI::App& runs, Session& session) {
  auto remark = std::make_shared<RunRemark>();
  CLI::App* tag = runs.add_subcommand("tag", "add tags to a run, or remove them");
  tag->add_option("run", remark->run, "run number")->required();
  tag->add_option("tags", remark->tags, "words of letters, digits and . _ : / + -")->required()->take_all();
  tag->add_flag("--remove", remark->remove, "remove them");
  tag->callback([remark, &session] { tag_run(*remark, session); });
  CLI::App* note = runs.add_subcommand("note", "add a line to a run's notes, with the time");
  note->add_option("run", remark->run, "run number")->required();
  note->add_option("text", remark->text, "text of the note")->required();
  note->callback([remark, &session] { note_run(*remark, session); });
  CLI::App* nullify =
      runs.add_subcommand("void", "declare a run void permanently: it no longer counts; nothing is deleted");
  nullify->add_option("run", remark->run, "run number")->required();
  nullify->add_option("--reason", remark->text, "why")->required();
  session.profile.add(*nullify, "--by", ProfileKey::kOperator, remark->by, "name of the person who declares it")
      ->required();
  nullify->callback([remark, &session] { void_run(*remark, session); });
}

}  // namespace tactbench::bench
