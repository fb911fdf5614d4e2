// fleet: the group of verbs, what they share, and fleet migrate.
#include "bench/cli/fleet/fleet.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <string_view>

#include "bench/common/build_info.h"
#include "db/fleet/schema.h"

namespace tactbench::bench {

namespace {

void migrate_fleet(const std::string& to, const Session& session) {
  db::fleet::Link link(to);
  const int before = db::fleet::make_fleet(link, build_info().version);
  if (session.json) {
    print_json("fleet.migrate",
               {{"fleet", link.where()}, {"schema_before", before}, {"schema_now", db::fleet::kFleetSchema}});
  } else if (before != 0) {
    tty::print("{}: has schema {} already\n", link.where(), before);
  } else {
    tty::print(
        "{}: made a fleet with schema {}; benches log in as members of role tactbench_bench, readers of "
        "tactbench_analyst\n",
        link.where(), db::fleet::kFleetSchema);
  }
}

}  // namespace

void add_fleet_option(CLI::App& verb, const char* name, std::string& value, Session& session) {
  session.profile
      .add(verb, name, ProfileKey::kFleet, value,
           std::string_view(name) == "--to"
               ? "how to connect to the fleet's PostgreSQL, as psql takes it: \"host=db.lab dbname=tactile "
                 "user=bench_a sslmode=verify-full\", \"service=NAME\"; keep the password in ~/.pgpass"
               : "how to connect to the fleet, as --to of fleet push")
      ->required();
}

void add_fleet(CLI::App& app, Session& session) {
  CLI::App* group = app.add_subcommand("fleet", "runs of several benches in one PostgreSQL: push, read");
  group->require_subcommand(1);
  auto to = std::make_shared<std::string>();
  CLI::App* migrate = group->add_subcommand("migrate", "make the fleet's tables, views and roles in a database");
  add_fleet_option(*migrate, "--to", *to, session);
  migrate->callback([to, &session] { migrate_fleet(*to, session); });
  add_fleet_push(*group, session);
  add_fleet_status(*group, session);
  add_fleet_readers(*group, session);
}

}  // namespace tactbench::bench
