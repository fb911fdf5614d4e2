// The full kill campaign, by command: ctest -L long -R kill. TACTBENCH_KILLS sets another number than 200, and
// TACTBENCH_KILL_SEED another seed.
#include <catch2/catch.hpp>
#include <cstdlib>

#include "tests/bench/run/kill_campaign.h"

using namespace tactbench::tests;

namespace {

int number_of(const char* variable, int standard) {
  const char* text = std::getenv(variable);
  return text != nullptr ? std::atoi(text) : standard;
}

void hold(CampaignKind kind) {
  kind.kills = number_of("TACTBENCH_KILLS", 200);
  kind.seed = static_cast<std::uint32_t>(number_of("TACTBENCH_KILL_SEED", 2));
  const CampaignFigures figures = KillCampaign(kind).carry_out();
  WARN(to_text(figures));
  CHECK(figures.kills == kind.kills);
  check_nothing_lost(figures);
}

}  // namespace

TEST_CASE("kill campaign: two hundred kills lose nothing, duplicate nothing and change no result") {
  hold({.races = true});
}

TEST_CASE("kill campaign: two hundred power cuts lose nothing, duplicate nothing and change no result") {
  hold({.power_cuts = true});
}
