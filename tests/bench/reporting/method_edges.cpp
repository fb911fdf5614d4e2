// The method in words at its edges: many turning points, one ramp, several frames a level, presses and conditioning.
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "bench/reporting/method_words.h"

using namespace tactbench;

namespace {

std::string method_of(const std::string& recipe, const std::string& overrides = "[]") {
  db::RunRecord run;
  run.overrides_json = overrides;
  run.sequences = {{0, "a", "schema = 1\nname = \"a\"\n" + recipe, "", 1, 1}};
  return bench::method_words(run).at(0);
}

// So many turns between 0 and 10 psi.
std::string turns(int count) {
  std::string list;
  for (int i = 0; i < count; ++i) list += (i == 0 ? "" : ", ") + std::string(i % 2 == 0 ? "0" : "10");
  return "unit = \"psi\"\nturning_points = [" + list + "]\nstep = 5\n";
}

}  // namespace

TEST_CASE("method edges: twenty turning points are named, of more their number") {
  const std::string twenty = method_of(turns(20)), more = method_of(turns(21));
  CHECK_THAT(twenty, Catch::StartsWith("1 repeat of 19 sweeps; a level every 5 psi, from 0 to 10 to 0 to 10 to ") &&
                         Catch::Contains(" to 0 to 10 psi; "));
  CHECK_THAT(more, Catch::StartsWith("1 repeat of 20 sweeps; a level every 5 psi, 21 turning points; "));
  CHECK_THAT(method_of(turns(2)), Catch::StartsWith("1 repeat of 1 sweep; a level every 5 psi, from 0 to 10 psi; "));
}

TEST_CASE("method edges: one dwell and one ramp are no turns, frames a level with their distance") {
  CHECK_THAT(method_of(turns(3) + "dwell_s = [2]\n"),
             Catch::Contains("waiting time (dwell) 2 s from pressure or force in band to the frame; no conditioning"));
  CHECK_THAT(method_of(turns(3) + "settle = \"none\"\nramp_psi_per_s = [2]\n"),
             Catch::Contains("; on a ramp of 2 psi/s, frames as it passes the levels; "));
  CHECK_THAT(method_of(turns(3) + "dwell_s = 4\nframes_per_level = 3\nframe_interval_s = 2.5\n"),
             Catch::Contains("to the frame; 3 frames a level, 2.5 s apart; no conditioning before it"));
  CHECK_THAT(method_of(turns(3) + "dwell_s = 4\nframes_per_level = 2\n"),
             Catch::Contains("; 2 frames a level, 1 s apart;"));
  CHECK_THAT(method_of(turns(3) + "dwell_s = 4\nframes_per_level = 1\n"), !Catch::Contains("frames a level"));
}

TEST_CASE("method edges: conditioning by cycles alone, or until two are alike, in psi and in newtons") {
  CHECK_THAT(method_of(turns(3) + "[conditioning]\ncycles = 1\npeak = 20\n"),
             Catch::EndsWith("; before it 1 cycle to 20 psi without frames"));
  CHECK_THAT(method_of(turns(3) + "[conditioning]\ncycles = 0\npeak = 20\n"),
             Catch::EndsWith("; no conditioning before it"));
  const std::string press =
      "kind = \"press\"\ndwell_s = 0.5\nrepeats = 2\n[press]\nobject = \"ring\"\npositions_mm = [[30, 30]]\nforces_n = "
      "[5, 30]\n";
  CHECK(method_of(press + "[conditioning]\ncycles = 2\npeak_n = 10\n") ==
        "2 repeats; ring at 1 place, forces of 5, 30 N; waiting time (dwell) 0.5 s from pressure or force in band to "
        "the frame; before it 2 cycles to 10 N without frames");
}

TEST_CASE("method edges: what was set goes in, keys of the bench do not, and unread overrides are none") {
  CHECK_THAT(method_of(turns(3), R"([{"key":"recipe.dwell_s","value":"7"},{"key":"reference.due","value":"x"}])"),
             Catch::Contains("(dwell) 7 s from"));
  CHECK_THAT(method_of(turns(3) + "dwell_s = 3\n", "no JSON"), Catch::Contains("(dwell) 3 s from"));
}
