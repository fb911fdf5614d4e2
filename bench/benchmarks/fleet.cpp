#include "bench/benchmarks/fleet.h"

#include <fmt/format.h>
#include <sys/wait.h>

#include <algorithm>
#include <limits>

#include "bench/benchmarks/synthetic_array.h"
#include "bench/common/child_process.h"
#include "bench/common/error.h"
#include "db/fleet/migrations.h"
#include "db/fleet/push.h"

namespace tactbench::bench {

namespace {

namespace fleet = db::fleet;

constexpr const char* kTable = "tactbench_benchmark";

void psql(const std::string& conninfo, const std::string& command) {
  ChildStart start;
  start.words = {"/bin/sh", "-c",
                 "exec psql -X -q -v ON_ERROR_STOP=1 -d \"$TACTBENCH_CONNINFO\" -c \"$TACTBENCH_COMMAND\""};
  start.environment = environment_with({"TACTBENCH_CONNINFO=" + conninfo, "TACTBENCH_COMMAND=" + command});
  start.ends_with_us = true;
  const int status = ChildProgram(std::move(start)).wait();
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return;
  throw Error(ExitCode::kUsage, "TB-USAGE", "psql could not do its part of the benchmark", "benchmark fleet",
              "install postgresql-client, and log in as the owner of the database");
}

}  // namespace

std::vector<Figure> benchmark_fleet(int rounds, const std::string& conninfo, const std::string& folder,
                                    const FleetSizes& sizes) {
  fleet::Link link(conninfo);
  fleet::check_schema(link);
  if (link.query("SELECT count(*) FROM fleet.runs").front().front() != "0")
    throw Error(ExitCode::kUsage, "TB-USAGE",
                "this fleet holds runs, and those of a benchmark could never be taken away", "benchmark fleet",
                "name a database of its own: createdb benchmark; tactbench fleet migrate --to ...");
  const analysis::Dataset dataset = synthetic_dataset(sizes.side, sizes.side, 1);
  // As fleet.frames, without partitions.
  link.execute(fmt::format("DROP TABLE IF EXISTS public.{0}; CREATE TABLE public.{0} (LIKE fleet.frames INCLUDING ALL)",
                           kTable));
  constexpr double kNone = std::numeric_limits<double>::infinity();
  FleetTimes best{.push_s = kNone, .copy_s = kNone, .again_s = kNone, .runs = sizes.runs};
  for (int round = 0; round < rounds; ++round) {
    const std::string path = fmt::format("{}/{}.db", folder, round);
    {
      db::RunStore store = db::RunStore::open(path, db::Durability::kNormal);
      for (int i = 0; i < sizes.runs; ++i) (void)store_run(store, dataset);
    }
    best.frames = 0.0;
    fleet::LocalRuns store(path);
    best.push_s = std::min(best.push_s, best_seconds(1, [&] {
                             fleet::Push push(link, store, path, folder);
                             for (const fleet::Waiting& one : push.waiting())
                               best.frames += static_cast<double>(push.push(one).frames);
                           }));
    const std::string file = fmt::format("{}/{}.copy", folder, round);
    psql(conninfo,
         fmt::format("\\copy (SELECT f.* FROM fleet.frames f WHERE run IN (SELECT run FROM fleet.revisions WHERE "
                     "source = '{}') ORDER BY run, position) TO '{}' (FORMAT binary)",
                     path, file));
    link.execute(fmt::format("TRUNCATE public.{}", kTable));
    best.copy_s = std::min(best.copy_s, best_seconds(1, [&] {
                             psql(conninfo, fmt::format("\\copy public.{} FROM '{}' (FORMAT binary)", kTable, file));
                           }));
    best.again_s =
        std::min(best.again_s, best_seconds(5, [&] { keep(fleet::Push(link, store, path, folder).waiting().size()); }));
  }
  link.execute(fmt::format("DROP TABLE public.{}", kTable));
  return figures_of(best);
}

std::vector<Figure> figures_of(const FleetTimes& times) {
  FigureList figures("fleet");
  figures.add_at_least("push", times.frames / times.push_s, 5000, "frames/s");
  figures.add("psql_copy", times.frames / times.copy_s, "frames/s");
  figures.add_at_least("push_over_copy", times.copy_s / times.push_s, 0.5);
  figures.add("push_a_run", 1e3 * times.push_s / times.runs, "ms");
  figures.add_at_most("push_again_a_run", 1e3 * times.again_s / times.runs, 1.0, "ms");
  return figures.take();
}

}  // namespace tactbench::bench
