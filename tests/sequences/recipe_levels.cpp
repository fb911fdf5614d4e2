// Turning points on their grid, drawn ones against an independent generator, and conditioning.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>

#include "tests/sequences/recipe_text.h"
#include "tests/sequences/refusal.h"

using namespace tactbench::sequences;

namespace {

std::vector<double> points_of(const std::string& body) {
  std::vector<double> points;
  for (const auto& point : recipe_of(body).turning_points) points.push_back(point.value());
  return points;
}

std::string drawn(const std::string& step, int seed, int reversals, const std::string& low, const std::string& high) {
  return fmt::format("step = {}\n[random]\nseed = {}\nreversals = {}\nlow = {}\nhigh = {}\n", step, seed, reversals,
                     low, high);
}

std::string key_refused(const std::string& body, const std::string& fact = {}) {
  return tactbench::sequences::key_refused([&] { (void)recipe_of(body); }, fact);
}

}  // namespace

TEST_CASE("random reversals are those of the 64-bit Mersenne Twister, drawn modulo the remaining range") {
  // From a second implementation of the generator (its 10000th number of seed 5489 is 9981545532273789042, as the
  // standard asks): after 0, high, 0 alternately low' + 1 + g % (high - low') and low + g % (last - low), where low' is
  // the larger of the last point and low.
  CHECK(points_of(drawn("2", 1, 5, "0", "60")) == std::vector<double>{0, 60, 0, 18, 12, 50, 42, 44, 0});
  CHECK(points_of(drawn("1", 1, 9, "3", "9")) == std::vector<double>{0, 9, 0, 6, 3, 4, 3, 4, 3, 6, 3, 6, 0});
  CHECK(points_of(drawn("0.5", 7, 9, "1.5", "3")) ==
        std::vector<double>{0, 3, 0, 2, 1.5, 2, 1.5, 2.5, 1.5, 2, 1.5, 2, 0});
  CHECK(points_of(drawn("1", 0, 1, "0", "2")).size() == 5);
}

TEST_CASE("random reversals keep to their grid and their bounds") {
  CHECK(key_refused(drawn("1", 1, 3, "0.5", "9")) == "random.low");
  CHECK(key_refused(drawn("1", 1, 3, "0", "9.5")) == "random.high");
  CHECK(key_refused(drawn("1", 1, 3, "-1", "9")) == "random.high");
  CHECK(key_refused(drawn("1", 1, 3, "4", "5")) == "random.high");
  CHECK(key_refused(drawn("1", 1, 3, "4", "6")) == "accepted");
  CHECK(key_refused(drawn("1", 1, 2, "0", "9")) == "random.reversals");
  CHECK(key_refused(drawn("1", 1, 0, "0", "9"), "from 1 to 10000") == "random.reversals");
  CHECK(key_refused(drawn("1", 1, 10'001, "0", "9"), "from 1 to 10000") == "random.reversals");
  CHECK(key_refused(drawn("1", 1, 9'999, "0", "9")) == "accepted");
  CHECK(key_refused(drawn("1", -1, 1, "0", "9")) == "random.seed");
  CHECK(key_refused(drawn("1", 2'000'000'000, 1, "0", "9")) == "accepted");
  CHECK(key_refused(drawn("1", 2'000'000'001, 1, "0", "9")) == "random.seed");
  // A million steps from 0 to high are too many only as a whole sequence.
  CHECK(key_refused(drawn("1", 1, 1, "0", "1000000")) == "step");
  CHECK(key_refused(drawn("1", 1, 1, "0", "1000001")) == "random.high");
}

TEST_CASE("a point within a millionth of a step of the grid is on it") {
  CHECK(key_refused(drawn("1", 1, 1, "1e-6", "9")) == "accepted");
  CHECK(key_refused(drawn("1", 1, 1, fmt::format("{}", std::nextafter(1e-6, 1.0)), "9")) == "random.low");
  CHECK(points_of("turning_points = [0, 4.0000018]\nstep = 2\n").back() == 4.0000018);
  CHECK(key_refused("turning_points = [0, 4.0000022]\nstep = 2\n", "0 to 4") == "turning_points");
}

TEST_CASE("turning points are named by their number, a single one needs several frames") {
  const std::string frames = "frames_per_level = 2\n";
  CHECK(key_refused("turning_points = []\nstep = 2\n") == "turning_points");
  CHECK(key_refused("turning_points = []\nstep = 2\n" + frames) == "turning_points");
  CHECK(key_refused("turning_points = [4]\nstep = 2\n") == "turning_points");
  CHECK(key_refused("turning_points = [4]\nstep = 2\n" + frames) == "accepted");
  CHECK(key_refused("turning_points = [4, 6]\nstep = 2\n") == "accepted");
  CHECK(key_refused("turning_points = [4, 4]\nstep = 0.25\n") == "turning_points");
  CHECK(key_refused("turning_points = [0, 0.25]\nstep = 0.25\n") == "accepted");
  CHECK(key_refused("turning_points = [4, 2, -2]\nstep = 2\n", " 3 ") == "turning_points");
  CHECK(key_refused("turning_points = [-2]\nstep = 2\n" + frames, " 1 ") == "turning_points");
  CHECK(key_refused("turning_points = [4, 2, 5]\nstep = 2\n", "2 to 5 ") == "turning_points");
}

TEST_CASE("frames taken in passing have no dwell, and one frame a level") {
  const std::string passing = "turning_points = [0, 2]\nstep = 2\nsettle = \"none\"\nramp_psi_per_s = 1\n";
  CHECK(key_refused(passing + "dwell_s = 0\nframes_per_level = 1\n") == "accepted");
  CHECK(key_refused(passing + "dwell_s = 1e-9\n", "0 to 0") == "dwell_s");
  CHECK(key_refused(passing + "dwell_s = -1\n", "0 to 0") == "dwell_s");
  CHECK(key_refused(passing + "frames_per_level = 2\n") == "frames_per_level");
  CHECK(key_refused("turning_points = [0, 2]\nstep = 2\ndwell_s = [1, 86401]\n", "0 to 86400") == "dwell_s");
  CHECK(key_refused("turning_points = [0, 2]\nstep = 2\nramp_psi_per_s = [1, 0]\nsettle = \"none\"\n") ==
        "ramp_psi_per_s");
  CHECK(key_refused("turning_points = [0, 2]\nstep = 2\nsettle = \"nome\"\n") == "settle");
}

TEST_CASE("a cycle of conditioning has a peak, and its least number of cycles no more than all") {
  const std::string head = "turning_points = [0, 2]\nstep = 2\n[conditioning]\n";
  CHECK(key_refused(head + "cycles = 1\npeak = 0\n") == "conditioning.peak");
  CHECK(key_refused(head + "cycles = 1\npeak = -1\n") == "conditioning.peak");
  CHECK(key_refused(head + "cycles = 1\npeak = 0.001\n") == "accepted");
  CHECK(key_refused(head + "cycles = 0\npeak = 0\n") == "accepted");
  CHECK(key_refused(head + "cycles = 0\npeak = -1\n") == "conditioning.peak");
  CHECK(key_refused(head + "cycles = 2\nleast = 3\npeak = 1\n") == "conditioning.least");
  const auto least = [&](const std::string& rest) { return recipe_of(head + rest).conditioning.least; };
  CHECK(least("cycles = 2\nleast = 2\npeak = 1\n") == 2);
  CHECK(least("cycles = 2\npeak = 1\n") == 1);
  CHECK(least("cycles = 0\nleast = 3\npeak = 1\n") == 0);  // as with --set recipe.conditioning.cycles=0
  CHECK(least("cycles = 1\nleast = 0\npeak = 1\n") == 0);
}

TEST_CASE("units by definition: 1 bar is 100 kPa, 1 psi 6.894757 kPa") {
  const auto second = [](const std::string& unit, const std::string& conditioning) {
    return parse_recipe(TomlDocument::from_text(
        "schema = 1\nname = \"t\"\nunit = \"" + unit + "\"\nturning_points = [0, 50]\nstep = 10\n" + conditioning,
        "u.toml"));
  };
  const std::string cycles = "[conditioning]\ncycles = 1\npeak = 20\n";
  CHECK(second("psi", cycles).turning_points[1].value() == 50.0);
  CHECK(second("psi", cycles).conditioning.peak.value() == 20.0);
  CHECK(second("kPa", cycles).turning_points[1].value() == Approx(50.0 / 6.894757293168).epsilon(1e-12));
  CHECK(second("kPa", cycles).step.value() == Approx(10.0 / 6.894757293168).epsilon(1e-12));
  CHECK(second("bar", cycles).conditioning.peak.value() == Approx(2000.0 / 6.894757293168).epsilon(1e-12));
}
