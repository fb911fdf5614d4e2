#include "bench/cli/runs/from_fleet.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>

#include "analysis/json_io.h"
#include "bench/cli/runs/source.h"
#include "bench/fleet/facts.h"
#include "db/fleet/body.h"
#include "db/fleet/schema.h"

namespace tactbench::bench {

namespace fleet = db::fleet;

namespace {

std::string fleet_named(const std::string& given, Session& session) {
  if (!given.empty() && given != "fleet") return given;
  const OperatorProfile& profile = session.profile.values();
  const auto value = profile.find(ProfileKey::kFleet);
  if (value != profile.end()) return value->second.values.front();
  throw Error(
      "TB-USAGE", "no fleet is named", "fleet",
      "name it: --to \"host=db.lab dbname=tactile user=bench_a sslmode=verify-full\"; or set TACTBENCH_FLEET, or "
      "write fleet = \"...\" into tactbench.toml");
}

}  // namespace

void add_from(CLI::App& verb, std::string& from) {
  verb.add_option(
      "--from", from,
      "not from a store, but from the fleet: `fleet` for the one that TACTBENCH_FLEET or tactbench.toml names, "
      "or how to connect, as psql takes it");
}

std::int64_t run_number(const std::string& text) {
  if (names_run(text)) return std::stoll(text);
  throw Error("TB-USAGE", fmt::format("'{}' is not a run number", text), "command line",
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

void FromFleet::take_one(db::RunStore& store, const fleet::FleetRun& run) {
  const std::string path = folder_.path() + "/body.db";
  for (const char* ending : {"-wal", "-shm"}) std::filesystem::remove(path + ending);
  fleet::unpack_run(fleet::body_of(link_, run), path);
  const db::RunStore body = db::RunStore::open_read_only(path);
  const std::vector<db::RunRecord> runs = body.runs();
  if (runs.size() != 1 || runs.front().uuid != run.uuid || runs.front().content_sha256 != run.content_sha256)
    throw fleet::FleetError(fleet::FleetCause::kStore, "TB-FLEET-CHANGED", "its body is another run's",
                            "the bench's own store has what was measured");
  for (const db::SensorRecord& sensor : body.sensors()) {
    const auto known = store.sensor(sensor.serial);
    if (known && (known->type_sha256 != sensor.type_sha256 || known->scanner_serial != sensor.scanner_serial))
      throw fleet::FleetError(
          fleet::FleetCause::kUsage, "TB-FLEET-CONFLICT",
          fmt::format("these runs have sensor '{}' registered with two types or scanners", sensor.serial),
          "name runs of one registration");
  }
  store.number_next_run(run.run);
  (void)store.copy_runs_from(body, {runs.front().run});
}

void FromFleet::take(const std::vector<fleet::FleetRun>& runs, const std::vector<fleet::FleetRun>& also) {
  session_.db = folder_.path() + "/fleet.db";
  db::RunStore store = db::RunStore::open(session_.db, db::Durability::kNormal);
  std::map<std::int64_t, std::pair<const fleet::FleetRun*, bool>> all;  // by number, since those of a store grow
  for (const fleet::FleetRun& run : runs) all[run.run] = {&run, true};
  for (const fleet::FleetRun& run : also) all.try_emplace(run.run, &run, false);
  std::map<std::int64_t, ModelsOfVerdicts> copied;
  for (const auto& [number, asked] : all) {
    const auto& [run, needed] = asked;
    const auto leave = [&, own = run, must = needed](const fleet::FleetError& error) {
      const std::string what =
          fmt::format("fleet {}: run {}, pushed by {}: {}", link_.where(), own->run, own->pushed_by, error.what());
      if (must || error.cause() == fleet::FleetCause::kLink)
        throw fleet::FleetError(error.cause(), error.id(), what, error.remedy());
      tty::print(stderr, "warning: {} [{}]; it is left out\n", one_line(what, kLongestText), error.id());
    };
    const auto changed = [&](const std::string& what) {
      leave(fleet::FleetError(fleet::FleetCause::kStore, "TB-FLEET-CHANGED", what,
                              "the bench's own store has what was measured"));
    };
    try {
      const ModelsOfVerdicts models = models_of_verdicts(analysis::parse_json(run->facts));
      take_one(store, *run);
      copied[number] = models;
    } catch (const fleet::FleetError& error) {
      leave(error);
    } catch (const db::StoreError& error) {
      if (error.id() == "TB-STORE-FULL") throw;
      changed(error.what());
    } catch (const nlohmann::json::exception& error) {
      changed(fmt::format("its facts are none: {}", error.what()));
    }
  }
  for (const auto& [number, models] : copied) link_verdicts(store, number, models);
}

}  // namespace tactbench::bench
