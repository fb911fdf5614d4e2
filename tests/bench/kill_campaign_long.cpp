// The full kill campaign, by command: ctest -L long -R kill. TACTBENCH_KILLS sets another number than 200, and
// TACTBENCH_KILL_SEED another seed.
#include <catch2/catch.hpp>
#include <cstdlib>

#include "tests/bench/kill_campaign.h"

using namespace tactbench::tests;

namespace {

int number_of(const char* variable, int standard) {
  const char* text = std::getenv(variable);
  return text != nullptr ? std::atoi(text) : standard;
}

}  // namespace

TEST_CASE("kill campaign: two hundred kills lose nothing, double nothing and change no result") {
  const int kills = number_of("TACTBENCH_KILLS", 200);
  const auto seed = static_cast<std::uint32_t>(number_of("TACTBENCH_KILL_SEED", 2));
  const CampaignFigures figures = KillCampaign(kills, seed, 20.0).carry_out();
  WARN(to_text(figures));
  CHECK(figures.faults.empty());
  CHECK(figures.kills == kills);
  CHECK(figures.lost == 0);
  CHECK(figures.changed == 0);
  CHECK(figures.doubled == 0);
  CHECK(figures.trips == 0);
  CHECK(figures.deviation_v < figures.bound_v);
  CHECK(figures.bound_v < 0.75 * figures.no_way_v);
}
