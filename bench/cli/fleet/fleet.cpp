// fleet: the group of verbs, and what they share.
#include "bench/cli/fleet/fleet.h"

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <array>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string_view>

#include "bench/common/build_info.h"
#include "db/fleet/migrations.h"

namespace tactbench::bench {

namespace {

namespace fs = std::filesystem;

void migrate_fleet(const std::string& to, const Session& session) {
  db::fleet::Link link(to);
  const int before = db::fleet::migrate(link, build_info().version);
  if (session.json) {
    print_json("fleet.migrate",
               {{"fleet", link.where()}, {"schema_before", before}, {"schema_now", db::fleet::kFleetSchema}});
  } else if (before == db::fleet::kFleetSchema) {
    tty::print("{}: has schema {} already\n", link.where(), before);
  } else {
    tty::print("{}: {}; benches log in as members of role tactbench_bench, readers of tactbench_analyst\n",
               link.where(),
               before == 0 ? fmt::format("made a fleet with schema {}", db::fleet::kFleetSchema)
                           : fmt::format("schema {} migrated to {}", before, db::fleet::kFleetSchema));
  }
}

}  // namespace

void add_fleet_option(CLI::App& verb, const char* name, std::string& value, Session& session) {
  session.profile
      .add(verb, name, ProfileKey::kFleet, value,
           std::string_view(name) == "--to" ? "how to connect to the fleet's PostgreSQL, as psql takes it: "
                                              "\"host=db.lab dbname=tactile user=bench_a\", "
                                              "\"service=NAME\"; keep the password in ~/.pgpass"
                                            : "how to connect to the fleet, as --to of fleet push")
      ->required();
}

void add_origin(CLI::App& verb, std::string& origin) {
  verb.add_option("--origin", origin, "runs of this origin; origins never mix")
      ->check(CLI::IsMember({"hardware", "simulated", "imported"}))
      ->capture_default_str();
}

std::string source_name(const std::string& store) {
  std::array<char, 256> host{};
  if (gethostname(host.data(), host.size() - 1) != 0) host[0] = '?';
  std::error_code missing;
  const fs::path file = fs::weakly_canonical(store, missing);
  return fmt::format("{}:{}", host.data(), missing ? fs::absolute(store).string() : file.string());
}

void add_fleet(CLI::App& app, Session& session) {
  CLI::App* group = app.add_subcommand(
      "fleet", "runs of several benches in one PostgreSQL: push, read, fit; nights in parts under Slurm");
  group->require_subcommand(1);
  auto to = std::make_shared<std::string>();
  CLI::App* migrate = group->add_subcommand(
      "migrate", "make the fleet's tables and roles in a database, or bring them to this program's schema");
  add_fleet_option(*migrate, "--to", *to, session);
  migrate->add_flag("--json", session.json, "one JSON document on standard output");
  migrate->callback([to, &session] { migrate_fleet(*to, session); });
  add_fleet_push(*group, session);
  add_fleet_status(*group, session);
  add_fleet_readers(*group, session);
  add_fleet_fit(*group, session);
  add_fleet_slurm(*group, session);
}

}  // namespace tactbench::bench
