// fleet status: how far the store is behind.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>

#include "analysis/counted.h"
#include "bench/cli/fleet/fleet.h"
#include "bench/fleet/facts.h"
#include "db/fleet/schema.h"

namespace tactbench::bench {

namespace {

namespace fleet = db::fleet;

std::string backlog_text(std::size_t ended, std::size_t runs, std::size_t remarks, std::int64_t frames) {
  if (ended == 0) return "no run has ended yet\n";
  std::string text = fmt::format("{} of {} there", ended - runs, analysis::counted(ended, "ended run"));
  if (runs > 0)
    text += fmt::format("; {} with {} waiting", analysis::counted(runs, "run"), analysis::counted(frames, "frame"));
  if (remarks > 0) text += fmt::format("; of {} something newer waits", analysis::counted(remarks, "run"));
  return text + (runs + remarks == 0 ? "; nothing waits\n" : "; tactbench fleet push sends it\n");
}

void status(const std::string& to, Session& session) {
  const db::RunStore store = db::RunStore::open_read_only(session.db);
  const std::vector<LocalRun> ended = ended_runs(store);
  fleet::Link link(to);
  fleet::check_schema(link);
  std::size_t runs = 0, remarks = 0;  // remarks: of runs that are there, and of which something newer is said
  std::int64_t frames = 0;
  for (const LocalRun& one : waiting_runs(link, ended, source_name(session.db))) {
    ++(one.content ? runs : remarks);
    if (one.content) frames += store.frame_count(one.run.run);
  }
  const std::map<std::string, std::int64_t> origins = fleet::runs_by_origin(link);
  if (session.json)
    return print_json("fleet.status", {{"fleet", link.where()},
                                       {"store", session.db},
                                       {"ended_runs", ended.size()},
                                       {"waiting_runs", runs},
                                       {"waiting_frames", frames},
                                       {"waiting_remarks", remarks},
                                       {"fleet_runs", origins}});
  std::string counts;
  for (const auto& [origin, number] : origins)
    counts += fmt::format("{}{} {}", counts.empty() ? "" : ", ", number, origin);
  tty::print("{}: schema {}; runs of all benches: {}\n{}: {}", link.where(), fleet::kFleetSchema,
             counts.empty() ? "none" : counts, session.db, backlog_text(ended.size(), runs, remarks, frames));
}

}  // namespace

void add_fleet_status(CLI::App& group, Session& session) {
  auto to = std::make_shared<std::string>();
  CLI::App* verb = group.add_subcommand("status", "how far the store is behind the fleet");
  add_fleet_option(*verb, "--to", *to, session);
  verb->footer("Exit codes: 0 the server was reached, also when something waits, 3 it was not, 5 it takes nothing.");
  verb->callback([to, &session] { status(*to, session); });
}

}  // namespace tactbench::bench
