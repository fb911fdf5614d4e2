// Twenty kills, and one under full pressure; kill_campaign_long.cpp has the full campaign.
#include <catch2/catch.hpp>
#include <csignal>

#include "tests/bench/kill_campaign.h"

using namespace tactbench;
using namespace tactbench::tests;

TEST_CASE("kill campaign: twenty kills lose nothing, double nothing and change no result") {
  const CampaignFigures figures = KillCampaign(20, 1, 20.0).carry_out();
  WARN(to_text(figures));
  CHECK(figures.faults.empty());
  CHECK(figures.kills == 20);
  CHECK(figures.checked > 100);
  CHECK(figures.lost == 0);
  CHECK(figures.changed == 0);
  CHECK(figures.doubled == 0);
  CHECK(figures.trips == 0);
  CHECK(figures.deviation_v < figures.bound_v);
  CHECK(figures.bound_v < 0.75 * figures.no_way_v);  // a path that was not repeated would show
}

TEST_CASE("kill: a resume right after a kill under pressure waits until the dead-man has vented") {
  ServedRig rig(3.0);
  write_file(rig.folder.path("high.toml"),
             "schema = 1\nname = \"high\"\nunit = \"psi\"\nturning_points = [0, 60, 0]\nstep = 30\ndwell_s = 0.5\n"
             "[dwell]\ntolerance_s = 5\n");
  const auto run = rig.start_run("high.toml");
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (rig.psi() < 58.0 && std::chrono::steady_clock::now() < end) usleep(2000);
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
