// fleet status: how far the store is behind, by the server, or by the store's own note while the server is away.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <exception>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "analysis/counted.h"
#include "bench/cli/fleet/fleet.h"
#include "bench/common/utc.h"
#include "db/fleet/find.h"
#include "db/fleet/migrations.h"
#include "db/fleet/push.h"

namespace tactbench::bench {

namespace {

namespace fleet = db::fleet;

struct Backlog {
  std::size_t ended = 0, runs = 0, remarks = 0;  // remarks: runs that are there, and of which something newer is said
  std::int64_t frames = 0;
};

Backlog backlog_of(fleet::LocalRuns& store, const std::vector<fleet::Waiting>& waiting) {
  Backlog backlog;
  backlog.ended = store.ended_runs().size();
  for (const fleet::Waiting& one : waiting) {
    ++(one.content ? backlog.runs : backlog.remarks);
    if (one.content) backlog.frames += store.frame_count(one.run.run);
  }
  return backlog;
}

// Without the server: what the note beside the store does not have. A run whose content was pushed counts as a remark,
// and the note cannot tell a resumed one from it.
std::vector<fleet::Waiting> waiting_by_note(fleet::LocalRuns& store, fleet::PushedNote& note) {
  const auto noted = note.fingerprints();
  std::vector<fleet::Waiting> waiting;
  for (const fleet::LocalRun& run : store.ended_runs()) {
    const auto known = noted.find(run.uuid);
    if (known == noted.end())
      waiting.push_back({run, true});
    else if (known->second != run.fingerprint)
      waiting.push_back({run, false});
  }
  return waiting;
}

std::string backlog_text(const Backlog& backlog, const std::string& store) {
  if (backlog.ended == 0) return fmt::format("{}: no run has ended yet\n", store);
  const std::size_t there = backlog.ended - backlog.runs;
  std::string text = fmt::format("{}: {} of {} there", store, there, analysis::counted(backlog.ended, "ended run"));
  if (backlog.runs > 0)
    text += fmt::format("; {} with {} waiting", analysis::counted(backlog.runs, "run"),
                        analysis::counted(backlog.frames, "frame"));
  if (backlog.remarks > 0)
    text += fmt::format("; of {} something newer waits", analysis::counted(backlog.remarks, "run"));
  return text + (backlog.runs + backlog.remarks == 0 ? "; nothing waits\n" : "; tactbench fleet push sends it\n");
}

void status(const std::string& to, Session& session) {
  fleet::LocalRuns store(session.db);
  const std::string where = fleet::where_of(to);
  fleet::PushedNote note(session.db, where);
  Backlog backlog;
  std::optional<Error> away;
  std::map<std::string, std::int64_t> origins;
  try {
    fleet::Link link(to);
    fleet::check_schema(link);
    backlog = backlog_of(store, fleet::Push(link, store, source_name(session.db), {}).waiting());
    origins = fleet::runs_by_origin(link);
    note.keep_try(utc_now(), {});
  } catch (const fleet::FleetError&) {
    away = as_error(std::current_exception());
    if (away->code() == ExitCode::kUsage) throw;
    note.keep_try(utc_now(), away->what());
    backlog = backlog_of(store, waiting_by_note(store, note));
    session.code = away->code();
  }
  const fleet::PushedNote::Last last = note.last();
  if (session.json) {
    nlohmann::ordered_json json = {{"fleet", where},
                                   {"reached", !away},
                                   {"error", away ? away->id() : ""},
                                   {"store", session.db},
                                   {"by", away ? "note" : "server"},
                                   {"ended_runs", backlog.ended},
                                   {"waiting_runs", backlog.runs},
                                   {"waiting_frames", backlog.frames},
                                   {"waiting_remarks", backlog.remarks},
                                   {"last_push_utc", last.pushed_utc}};
    if (!away) json["fleet_runs"] = origins;
    print_json("fleet.status", json);
    return;
  }
  if (away) {
    tty::print("{} [{}]\n  try: {}\n", one_line(away->what(), kLongestText), away->id(),
               one_line(away->remedy(), kLongestText));
    tty::print("{} keeps everything; by the note beside it:\n", session.db);
  } else {
    std::string counts;
    for (const auto& [origin, runs] : origins)
      counts += fmt::format("{}{} {}", counts.empty() ? "" : ", ", runs, origin);
    tty::print("{}: schema {}; runs of all benches: {}\n", where, fleet::kFleetSchema,
               counts.empty() ? "none" : counts);
  }
  tty::print("{}", backlog_text(backlog, session.db));
  if (!last.pushed_utc.empty()) tty::print("last pushed {}\n", last.pushed_utc);
}

}  // namespace

void add_fleet_status(CLI::App& group, Session& session) {
  auto to = std::make_shared<std::string>();
  CLI::App* verb = group.add_subcommand(
      "status", "how far the store is behind the fleet; while the server is away by the note beside the store");
  add_fleet_option(*verb, "--to", *to, session);
  verb->footer("Exit codes: 0 the server was reached, also when something waits, 3 it was not, 5 it takes nothing.");
  add_common(*verb, session);
  verb->callback([to, &session] { status(*to, session); });
}

}  // namespace tactbench::bench
