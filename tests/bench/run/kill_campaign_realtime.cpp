// Twenty kills, and one under full pressure; kill_campaign_long.cpp has the full campaign.
#include <catch2/catch.hpp>
#include <csignal>

#include "tests/bench/run/kill_campaign.h"
#include "tests/support/endless_run.h"

using namespace tactbench;
using namespace tactbench::tests;

TEST_CASE("kill campaign: twenty kills lose nothing, duplicate nothing and change no result") {
  const CampaignFigures figures = KillCampaign({.kills = 20, .races = true}).carry_out();
  WARN(to_text(figures));
  CHECK(figures.kills == 20);
  CHECK(figures.checked > figures.kills);  // how many there are to compare depends on the machine's speed
  check_nothing_lost(figures);
}

TEST_CASE("kill campaign: ten power cuts lose nothing that was visible in the store") {
  const CampaignFigures figures = KillCampaign({.kills = 10, .power_cuts = true}).carry_out();
  WARN(to_text(figures));
  CHECK(figures.kills == 10);
  check_nothing_lost(figures);
}

TEST_CASE("kill: without sync a power cut loses frames that were visible, and the campaign detects it") {
  ServedRig rig(20.0);
  write_file(rig.folder.path("long.toml"),
             "schema = 1\nname = \"long\"\nunit = \"psi\"\nturning_points = [0, 12, 0]\nstep = 4\nrepeats = 20\n"
             "dwell_s = 1\n[dwell]\ntolerance_s = 5\n");
  SyncedStore disk(rig.folder.path("runs.db"), true);
  rig.environment = disk.environment();
  const auto run = rig.start_run("long.toml");
  const auto seen = [&] { return committed_frames(rig.folder.path("runs.db"), 1).size(); };
  CHECK(comes_true([&] { return seen() >= 5; }));
  run->signal(SIGKILL);
  REQUIRE(run->wait() == -SIGKILL);
  std::mt19937 random(1);
  CHECK(disk.cut(0.0, random) > 0);
  CHECK(seen() == 0);
}

TEST_CASE("kill: a resume right after a kill under pressure waits until the dead-man has vented") {
  ServedRig rig(3.0);
  write_file(rig.folder.path("high.toml"),
             "schema = 1\nname = \"high\"\nunit = \"psi\"\nturning_points = [0, 60, 0]\nstep = 30\ndwell_s = 0.5\n"
             "[dwell]\ntolerance_s = 5\n");
  const auto run = rig.start_run("high.toml");
  REQUIRE(comes_true([&] { return rig.psi() >= 58.0; }));
  run->signal(SIGKILL);
  REQUIRE(run->wait() == -SIGKILL);
  const auto resume = rig.start_resume(1);
  const double safe_s = rig.seconds_until_safe();
  WARN(fmt::format("FIGURE safe_after_kill_at_60_psi_and_resume_at_once {:.3f} s at 3 x", safe_s));
  CHECK(safe_s > 0.0);
  CHECK(safe_s < 10.0);
  CHECK(resume->wait() == 0);
  INFO(rig.log());
  CHECK_THAT(read_file(bench::TripFile(rig.bench_id).dead_man_path()),
             Catch::Contains("safe, verified") && Catch::Contains("\"run\": 1"));
  CHECK_FALSE(bench::TripFile(rig.bench_id).read());
}
