// Runs of the fleet as a store: what the fleet's tables hold is handed out by a script, and is what the bench stored.
#include "db/fleet/copy_back.h"

#include <catch2/catch.hpp>
#include <filesystem>

#include "tests/db/fleet/fleet_example.h"

namespace tactbench::tests::postgres {

using Catch::Contains;
using db::fleet::CopyBack;
using db::fleet::Frames;

namespace {

// What taking the run back with frames is told.
Told told_of(const std::vector<Answer>& answers) {
  Server server(answers);
  db::fleet::Link link(server.conninfo(), kSoon);
  const TemporaryFolder folder;
  return told([&] { CopyBack(link, folder.path("back.db")).add_runs({kRun}, Frames::kWith); });
}

}  // namespace

TEST_CASE("fleet copy back: a run of the fleet is a store with all that was measured and said of it") {
  if (!db::fleet::built_with_libpq()) return;
  const Fleet fleet;
  Server server(fleet.all(fleet.fit.sha256, db::fleet::sha256_of(fleet.remarks), {fleet.sensor}));
  const std::string path = fleet.folder.path("back.db");
  {
    db::fleet::Link link(server.conninfo(), kSoon);
    CopyBack back(link, path);
    back.add_runs({kRun}, Frames::kWith);
    CHECK(back.path() == path);
    CHECK(back.content_hash(kRun) == fleet.store.run(1).content_sha256);
    CHECK(back.bytes() == std::filesystem::file_size(path));
  }
  const RunStore store = RunStore::open_read_only(path);
  CHECK(store.check_content(kRun).holds());
  CHECK(store.check_seals(kRun).empty());
  const db::RunRecord run = store.run(kRun), own = fleet.store.run(1);
  CHECK((run.uuid == own.uuid && run.tags == own.tags && run.notes == own.notes && run.host == own.host));
  CHECK((run.void_reason == own.void_reason && run.void_by == own.void_by && run.void_utc == own.void_utc));
  CHECK((run.started_utc == own.started_utc && run.ended_utc == own.ended_utc && run.rest_s == own.rest_s));
  REQUIRE(store.sensor("S-1"));
  CHECK((store.sensor("S-1")->type_toml == "rows = 3\n" && store.sensor("S-1")->note == "first"));
  const std::vector<db::FitRecord> fits = store.fits(kRun);
  REQUIRE(fits.size() == 1);
  CHECK((fits[0].fit == kFit && fits[0].model == "elam" && fits[0].summary_json == R"({"s":2})"));
  REQUIRE(store.fit_taxels(kFit).size() == 1);
  CHECK(store.fit_taxels(kFit)[0].parameters == std::vector<double>{0.1, 1.0 / 3.0});
  const std::vector<db::VerdictRecord> verdicts = store.verdicts(kRun);
  REQUIRE(verdicts.size() == 2);
  CHECK((verdicts[0].criterion == "by no fit" && verdicts[0].fit == 0));
  CHECK((verdicts[1].criterion == "by its fit" && verdicts[1].fit == kFit && verdicts[1].verdict == "pass"));
  CHECK(store.figures_of(kRun, "rig") == std::map<std::string, double>{{"x_psi", 0.5}, {"y_psi", 2.5}});
  CHECK(store.figures_of(kRun, "a") == std::map<std::string, double>{{"z", 1.0}});
  REQUIRE(store.reports(kRun).size() == 2);
  CHECK((store.reports(kRun)[0].number == "1-a" && store.reports(kRun)[1].reason == "serial corrected"));
  const std::vector<db::BaselineRecord> baselines = store.baselines();
  REQUIRE(baselines.size() == 2);  // those of which a run is here, numbered in the order of their acceptance
  CHECK((baselines[0].baseline == 1 && baselines[0].subject == "rig" && baselines[0].reason == "as made"));
  CHECK((baselines[1].baseline == 2 && baselines[1].subject == "sensor" && baselines[1].reason == "new film"));
  CHECK((baselines[1].accepted_by == "M. Ito" && baselines[1].accepted_utc == "2026-03-03"));
  CHECK(baselines[1].runs == std::vector<std::int64_t>{kRun});
  CHECK(server.statements().at(0) == "BEGIN ISOLATION LEVEL REPEATABLE READ READ ONLY");
}

TEST_CASE("fleet copy back: rows are asked for by their runs, frames by their months, remarks by their revisions") {
  if (!db::fleet::built_with_libpq()) return;
  const Fleet fleet;
  Server server(fleet.all(fleet.fit.sha256, db::fleet::sha256_of(fleet.remarks), {fleet.sensor}));
  {
    db::fleet::Link link(server.conninfo(), kSoon);
    CopyBack(link, fleet.folder.path("back.db")).add_runs({kRun}, Frames::kWith);
  }
  const std::vector<std::string> asked = server.statements();
  REQUIRE(asked.size() == 18);
  const auto check_ends = [&](std::size_t at, const std::string& end) {
    CHECK_THAT(asked[at], Catch::StartsWith("COPY (SELECT "));
    CHECK_THAT(asked[at], Catch::EndsWith(end + ") TO STDOUT (FORMAT binary)"));
  };
  const std::string own = " = ANY('{41}'::bigint[])", revision = " = ANY('{9}'::bigint[])";
  for (const std::size_t at : {1U, 2U})
    check_ends(at,
               "FROM fleet.sensors t WHERE (serial, type_sha256, scanner_serial) IN (SELECT sensor_serial, "
               "sensor_type_sha256, sensor_scanner FROM fleet.runs WHERE run" +
                   own + ") ORDER BY 1");
  check_ends(
      3, "WHERE run" + own + " ORDER BY run, revision DESC) v ON v.run = t.run WHERE t.run" + own + " ORDER BY t.run");
  std::size_t at = 4;
  for (const Table& table : db::fleet::content_tables())
    check_ends(at++, std::string("FROM fleet.") + table.name + " t WHERE t.run" + own + " ORDER BY 1, 2");
  REQUIRE(at == 10);
  CHECK_THAT(asked[10], Catch::StartsWith("COPY (SELECT t.\"run\", t.\"month\", t.\"position\", "));
  check_ends(10, "FROM fleet.frames t WHERE t.month = ANY('{202405}'::bigint[]) AND t.run" + own +
                     " ORDER BY t.month, t.run, t.position");
  check_ends(11, "t.\"run\", t.\"sha256\" FROM fleet.fits t WHERE run" + own + " ORDER BY fit");
  check_ends(12, "FROM fleet.fit_taxels t JOIN fleet.fits f ON f.fit = t.fit WHERE f.run" + own + " ORDER BY 1, 2");
  check_ends(13, "FROM fleet.revisions WHERE run" + own + " ORDER BY run, revision DESC");
  check_ends(14, "FROM fleet.verdicts t WHERE t.revision" + revision + " ORDER BY 1, 2, 3");
  check_ends(15, "FROM fleet.figures t WHERE t.revision" + revision + " ORDER BY 1, 2, 3");
  check_ends(16, "FROM fleet.reports t WHERE t.revision" + revision + " ORDER BY 1, 2, 3");
  CHECK(asked[17] == "ROLLBACK");

  // Several runs of several months.
  std::vector<Answer> answers = {started()};
  for (const Answer& answer : fleet.content(true)) answers.push_back(answer);
  answers[answers.size() - 2] = rows(1, {{"202406"}, {"202405"}, {"202406"}});
  Server second(answers);
  {
    db::fleet::Link link(second.conninfo(), kSoon);
    CopyBack(link, fleet.folder.path("two.db")).add_content({kRun, 42}, Frames::kWith);
  }
  CHECK_THAT(second.statements().back(),
             Contains("t.month = ANY('{202405,202406}'::bigint[]) AND t.run = ANY('{41,42}'::bigint[])"));
}

TEST_CASE("fleet copy back: content alone comes with or without frames, and a list takes one of two registrations") {
  if (!db::fleet::built_with_libpq()) return;
  const Fleet fleet;
  for (const bool with_frames : {true, false}) {
    CAPTURE(with_frames);
    std::vector<Answer> answers = {started()};
    for (const Answer& answer : fleet.content(with_frames)) answers.push_back(answer);
    Row other = fleet.sensor;
    other[3] = text_value("another type");
    answers[1] = handed_out(db::fleet::sensors_table().columns, {fleet.sensor, other});
    Server server(answers);
    const std::string path = fleet.folder.path(with_frames ? "with.db" : "without.db");
    {
      db::fleet::Link link(server.conninfo(), kSoon);
      CopyBack(link, path).add_content({kRun}, with_frames ? Frames::kWith : Frames::kWithout);
    }
    const RunStore store = RunStore::open_read_only(path);
    CHECK(store.frame_count(kRun) == (with_frames ? 3 : 0));
    CHECK((store.events(kRun).size() == 2 && store.branches(kRun).size() == 2 && store.series(kRun).size() == 1));
    CHECK(store.sensor("S-1")->type_sha256 == fleet.sensor[3].bytes);
    CHECK((store.fits(kRun).empty() && store.verdicts(kRun).empty()));
  }
}

TEST_CASE("fleet copy back: fits and remarks that somebody changed, and a serial with two types, are told") {
  if (!db::fleet::built_with_libpq()) return;
  const Fleet fleet;
  const std::string fit = fleet.fit.sha256, said = db::fleet::sha256_of(fleet.remarks);
  const Told changed_fit = told_of(fleet.all(said, said, {fleet.sensor}));
  CHECK((changed_fit.id == "TB-FLEET-CHANGED" && changed_fit.cause == db::fleet::FleetCause::kStore));
  CHECK_THAT(changed_fit.message, Contains("run 41: fit 71 is not what was pushed"));
  const Told changed_remarks = told_of(fleet.all(fit, fit, {fleet.sensor}));
  CHECK(changed_remarks.id == "TB-FLEET-CHANGED");
  CHECK_THAT(changed_remarks.message, Contains("run 41: what was said of it is not what was pushed"));
  for (const std::size_t at : {3U, 4U}) {
    Row other = fleet.sensor;
    other[at] = text_value("another");
    const Told two = told_of(fleet.all(fit, said, {fleet.sensor, other}));
    CHECK((two.id == "TB-FLEET-CONFLICT" && two.cause == db::fleet::FleetCause::kUsage));
    CHECK_THAT(two.message, Contains("sensor 'S-1' registered with two types or scanners"));
  }
}

}  // namespace tactbench::tests::postgres
