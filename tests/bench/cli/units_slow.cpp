// --units as a person meets it: every verb that prints pressures, the profile's key, typed pressures, and what stays
// psi.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <regex>
#include <string>
#include <vector>

#include "tests/bench/cli/small_bench.h"

using namespace tactbench::tests;
using nlohmann::json;

namespace {

// A number with psi behind it, or psi as the unit of a column.
bool shows_psi(const std::string& text) { return std::regex_search(text, std::regex(R"(\d psi\b|, psi\b)")); }

}  // namespace

TEST_CASE("plan, recipes and errors in kPa and bar, and JSON as it is") {
  const TemporaryFolder folder;
  const std::vector<std::string> plan = {"plan", "production", "--steps", "--all"};
  const std::string kpa = call(folder, joined_words(plan, {"--units", "kpa"})).out;
  CHECK_THAT(kpa, Catch::Contains(" 413.7 kPa") && Catch::Contains("455.1 kPa"));
  CHECK_FALSE(shows_psi(kpa));
  CHECK(call(folder, joined_words(plan, {"--json"})).out ==
        call(folder, joined_words(plan, {"--json", "--units", "bar"})).out);
  CHECK(call(folder, {"plan", "production", "--set", "recipe.conditioning.peak=5bar", "--units", "bar"}).code == 2);
  const Finished wrong = call(folder, joined_words(plan, {"--units", "mbar"}));
  CHECK(wrong.code == 2);
  CHECK_THAT(wrong.err, Catch::Contains("--units"));
}

TEST_CASE("units of the profile, a run, its verdicts and its report") {
  const TemporaryFolder folder;
  REQUIRE(call(folder, {"init", "--operator", "tester"}).code == 0);
  write_file(folder.path("tactbench.toml"), read_file(folder.path("tactbench.toml")) + "units = \"kPa\"\n");
  write_file(folder.path("small.toml"), small_loop_text(20, 2));
  REQUIRE(call(folder, {"sensors", "add", "S-1"}).code == 0);
  for (const char* seed : {"1", "2"}) {
    const Finished run =
        call(folder, {"run", "small.toml", "--sensor", "S-1", "-q", "--seed", seed, "--set", "settling.band_psi=2kPa"});
    REQUIRE(run.code == 0);
    CHECK_THAT(run.out, Catch::Contains("vented") && Catch::Contains("kPa"));
    CHECK_FALSE(shows_psi(run.out));
  }
  const Finished fit = call(folder, {"fit", "1", "-q"}, {"judge", "1", "2", "--all"});
  CHECK_THAT(fit.out, Catch::Contains("8.27 kPa") && Catch::Contains("275.8 kPa"));
  CHECK_FALSE(shows_psi(fit.out));
  CHECK_THAT(call(folder, {"runs", "show", "1"}).out, Catch::Contains("0.345 kPa"));

  // The page: kPa with psi behind, or the other way round, of one number; the data do not change.
  const auto report = [&](const char* unit, const char* file) {
    return json::parse(call(folder, {"report", "1", "-o", file, "--json", "--units", unit}).out).at("number");
  };
  const json number = report("kPa", "kpa.html");
  CHECK(report("psi", "psi.html") == number);
  CHECK(report("bar", "bar.html") == number);
  const std::string kpa = read_file(folder.path("kpa.html")), psi = read_file(folder.path("psi.html"));
  const auto data = [](const std::string& page) { return page.substr(page.find("id=\"report-data\">")); };
  CHECK(data(kpa) == data(psi));
  write_file(folder.path("tactbench.toml"), "units = \"atm\"\n");
  CHECK(call(folder, {"plan", "production"}).code == 2);
}

TEST_CASE("devices test and resume print kPa, and numbers that are those in psi") {
  const TemporaryFolder folder;
  REQUIRE(call(folder, {"init", "--operator", "tester"}).code == 0);
  REQUIRE(call(folder, {"sensors", "add", "S-1"}).code == 0);
  write_file(folder.path("small.toml"), small_loop_text(20, 2));
  const auto check = [&](const char* unit) {
    return call(folder, {"devices", "test", "--standard", "S-1", "--recipe", "small.toml", "-q", "--units", unit}).out;
  };
  // One number behind a figure's name.
  const auto figure = [](const std::string& text, const std::string& name) {
    const std::size_t at = text.find("\n" + name + " ");
    REQUIRE(at != std::string::npos);
    return std::stod(text.substr(at + name.size() + 2));
  };
  const std::string kpa = check("kPa"), psi = check("psi");
  CHECK(kpa.find("psi") == std::string::npos);
  for (const std::string name : {"overshoot_", "reference_minus_feedback_", "mean_error_", "worst_taxel_error_"}) {
    INFO(name);
    CHECK(figure(kpa, name + "kpa") == Approx(6.894757 * figure(psi, name + "psi")).epsilon(0.002));
  }
  CHECK(figure(kpa, "elam_alpha_a1_per_kpa") == Approx(figure(psi, "elam_alpha_a1_per_psi") / 6.894757).epsilon(0.002));

  // Runs 1 to 4 are those of the two checks.
  const std::string unplugged = R"(simulation.faults=[{kind="scanner_unplugged",at_s=45}])";
  REQUIRE(call(folder, {"run", "small.toml", "--sensor", "S-1", "-q", "--no-seating", "--set", unplugged}).code == 3);
  const Finished resumed = call(folder, {"resume", "5", "-q", "--units", "kPa"});
  CHECK(resumed.code == 3);
  CHECK_THAT(resumed.err, Catch::Contains(" kPa"));
}
