#include "bench/cli/runs/from_fleet.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>

#include "bench/cli/runs/source.h"
#include "db/fleet/find.h"
#include "db/fleet/migrations.h"

namespace tactbench::bench {

namespace fleet = db::fleet;

void add_from(CLI::App& verb, std::string& from) {
  verb.add_option(
      "--from", from,
      "not from a store, but from the fleet: `fleet` for the one that TACTBENCH_FLEET or tactbench.toml names, "
      "or how to connect, as psql takes it");
}

std::string fleet_named(const std::string& given, Session& session) {
  if (!given.empty() && given != "fleet") return given;
  const OperatorProfile& profile = session.profile.values();
  const auto value = profile.find(ProfileKey::kFleet);
  if (value != profile.end()) return value->second.values.front();
  throw Error(
      ExitCode::kUsage, "TB-USAGE", "no fleet is named", "fleet",
      "name it: --to \"host=db.lab dbname=tactile user=bench_a\"; or set TACTBENCH_FLEET, or write fleet = \"...\" "
      "into tactbench.toml");
}

std::int64_t run_number(const std::string& text) {
  if (names_run(text)) return std::stoll(text);
  throw Error(ExitCode::kUsage, "TB-USAGE", fmt::format("'{}' is not a run number", text), "command line",
              "tactbench runs list shows the numbers; a UUID is taken with --from alone");
}

FromFleet::FromFleet(Session& session, const std::string& given)
    : session_(session), link_(fleet_named(given, session)), folder_("tactbench-fleet"), db_before_(session.db) {
  fleet::check_schema(link_);
  session_.fleet = link_.where();
}

FromFleet::~FromFleet() {
  session_.db = db_before_;
  session_.fleet.clear();
}

std::int64_t FromFleet::run_named(const std::string& name) { return fleet::run_named(link_, name); }

std::vector<std::int64_t> FromFleet::with_what_they_rest_on(const std::vector<std::int64_t>& runs) {
  return fleet::with_what_they_rest_on(link_, runs);
}

void FromFleet::take(const std::vector<std::int64_t>& runs, fleet::Frames frames) {
  if (stores_ > 0) std::filesystem::remove(session_.db);
  session_.db = fmt::format("{}/fleet-{}.db", folder_.path(), ++stores_);
  fleet::CopyBack(link_, session_.db).add_runs(runs, frames);
}

}  // namespace tactbench::bench
