// Figures over nights: what is reported, and what must not be.
#include "bench/nightly/followed.h"

#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <pugixml.hpp>
#include <random>

#include "bench/nightly/followed_page.h"
#include "tests/db/store_example.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::bench;
using namespace tactbench::tests;

namespace {

constexpr const char* kSubject = "nightly/paper";
constexpr std::size_t kTogether = 100;  // figures: one of them is outside by chance with 1e-4

std::int64_t add_night(db::RunStore& store, double value, const std::string& origin = "simulated") {
  db::RunRecord record = example_run();
  record.origin = origin;
  record.seed = static_cast<std::int64_t>(store.runs().size());  // no two nights with one seed
  const std::int64_t run = begin_example(store, record).run;
  store.end_run(run, db::Outcome::kCompleted, "", db::SafeState::kVerified, "2026-01-01T00:00:00Z");
  store.replace_figures(run, kSubject, {{"mean_error_psi", value}});
  return run;
}

// A store whose baseline is eight runs about 0.30 with a spread of about 0.01.
db::RunStore with_baseline(const TemporaryFolder& folder) {
  db::RunStore store = db::RunStore::open(folder.path("runs.db"));
  db::BaselineRecord baseline{0, kSubject, "as delivered", "K. Lee", "2026-01-01T00:00:00Z", {}};
  for (const double off : {0.4, -1.1, 0.9, -0.3, 1.3, -0.8, 0.1, -0.5})
    baseline.runs.push_back(add_night(store, 0.30 + 0.01 * off));
  store.add_baseline(baseline);
  return store;
}

FollowedFigure only_figure(const db::RunStore& store) {
  const Followed followed = follow(store, kSubject, kTogether);
  REQUIRE(followed.figures.size() == 1);
  return followed.figures.front();
}

}  // namespace

TEST_CASE("a night is reported only if it lies outside the spread of the seeds") {
  const TemporaryFolder folder;
  db::RunStore store = with_baseline(folder);
  CHECK_FALSE(only_figure(store).outside);  // accepted runs do not judge themselves
  add_night(store, 0.32);
  const FollowedFigure within = only_figure(store);
  CHECK((within.band && !within.outside && !within.drifts));
  CHECK(within.band->deviation == Approx(0.0085).margin(0.001));
  add_night(store, 0.42);
  CHECK(only_figure(store).outside);
  const std::vector<std::string> lines = outside_lines(follow(store, kSubject, kTogether));
  REQUIRE(lines.size() == 1);
  CHECK_THAT(lines.front(), Catch::Contains("mean_error_psi is 0.42, outside") && Catch::Contains("of 8 runs") &&
                                Catch::Contains("as delivered, accepted by K. Lee"));
}

TEST_CASE("how many figures are judged together widens the band, by default all of the subject's, by hand") {
  // Three accepted values -1, 0, 1: mean 0, deviation 1, and a band of t sqrt(4/3). With two degrees of freedom t has a
  // closed form, (2 p - 1) / sqrt(2 p (1 - p)); one night in 100 outside of one figure: p = 0.995, of two: 0.9975.
  const auto band_of = [](const std::vector<const char*>& names, std::size_t together) {
    const TemporaryFolder folder;
    db::RunStore store = db::RunStore::open(folder.path("runs.db"));
    db::BaselineRecord baseline{0, kSubject, "as delivered", "K. Lee", "2026-01-01T00:00:00Z", {}};
    for (const double value : {-1.0, 0.0, 1.0}) {
      baseline.runs.push_back(add_night(store, value));
      std::map<std::string, double> figures;
      for (const char* name : names) figures[name] = value;
      store.replace_figures(baseline.runs.back(), kSubject, figures);
    }
    store.add_baseline(baseline);
    const Followed followed = together == 0 ? follow(store, kSubject) : follow(store, kSubject, together);
    REQUIRE(followed.figures.size() == names.size());
    REQUIRE(followed.figures.front().band);
    CHECK(followed.figures.front().band->low == Approx(-followed.figures.front().band->high));
    return followed.figures.front().band->high;
  };
  const double alone = 0.99 / std::sqrt(2.0 * 0.995 * 0.005) * std::sqrt(4.0 / 3.0);      // 11.46
  const double of_two = 0.995 / std::sqrt(2.0 * 0.9975 * 0.0025) * std::sqrt(4.0 / 3.0);  // 16.27
  CHECK(band_of({"a_psi"}, 0) == Approx(alone));
  CHECK(band_of({"a_psi", "b_psi"}, 0) == Approx(of_two));
  CHECK(band_of({"a_psi", "b_psi"}, 1) == Approx(alone));
  CHECK(band_of({"a_psi"}, 2) == Approx(of_two));
}

TEST_CASE("a baseline's runs that repeat one another count once") {
  const TemporaryFolder folder;
  db::RunStore store = db::RunStore::open(folder.path("runs.db"));
  db::BaselineRecord baseline{0, kSubject, "as delivered", "K. Lee", "2026-01-01T00:00:00Z", {}};
  for (const double value : {0.30, 0.30, 0.30, 0.31}) baseline.runs.push_back(add_night(store, value));
  store.add_baseline(baseline);
  // Two measurements have no spread yet that a third could be held against.
  CHECK_FALSE(only_figure(store).band);
  CHECK(follow(store, kSubject, kTogether).repeated == 2);
  baseline.runs.push_back(add_night(store, 0.32));
  store.add_baseline(baseline);
  const FollowedFigure figure = only_figure(store);
  REQUIRE(figure.band);
  CHECK(figure.band->values == 3);
  CHECK(figure.band->mean == Approx(0.31));
  CHECK(figure.band->deviation == Approx(0.01));
  add_night(store, 0.33);
  CHECK_FALSE(only_figure(store).outside);
}

TEST_CASE("a slow change that stays inside each night's tolerance is reported within a week") {
  const TemporaryFolder folder;
  db::RunStore store = with_baseline(folder);
  int reported_on = 0;
  for (int night = 1; night <= 7; ++night) {
    add_night(store, 0.30 + 0.003 * night);
    const FollowedFigure figure = only_figure(store);
    CHECK_FALSE(figure.outside);
    if (figure.drifts && reported_on == 0) reported_on = night;
  }
  CHECK(reported_on == 7);
  CHECK_THAT(drift_lines(follow(store, kSubject, kTogether)).at(0),
             Catch::Contains("mean_error_psi drifts: +0.003 per run"));
}

TEST_CASE("nights with different seeds seldom show a drift") {
  const TemporaryFolder folder;
  db::RunStore store = with_baseline(folder);
  std::mt19937 random(3);
  std::normal_distribution<double> normal(0.30, 0.009);
  int alarms = 0;
  for (int night = 1; night <= 120; ++night) {
    add_night(store, normal(random));
    const FollowedFigure figure = only_figure(store);
    alarms += figure.drifts || figure.outside ? 1 : 0;
  }
  CHECK(alarms == 0);
}

TEST_CASE("runs of another origin do not come into a trend, nor do void ones") {
  const TemporaryFolder folder;
  db::RunStore store = with_baseline(folder);
  add_night(store, 9.0, "hardware");
  CHECK(only_figure(store).values == std::vector<double>{9.0});
  const std::int64_t last = add_night(store, 0.31);
  CHECK(only_figure(store).values.size() == 9);
  store.void_run(last, "valve leaked", "K. Lee", "2026-01-01T00:00:00Z");
  CHECK(only_figure(store).values.front() == 9.0);
}

TEST_CASE("a figure of the baseline that the newest run lacks is reported") {
  const TemporaryFolder folder;
  db::RunStore store = with_baseline(folder);
  const std::int64_t run = add_night(store, 0.31);
  store.replace_figures(run, kSubject, {{"other_psi", 1.0}});
  const Followed followed = follow(store, kSubject, kTogether);
  const std::vector<std::string> lines = outside_lines(followed);
  REQUIRE(lines.size() == 1);
  CHECK_THAT(lines.front(), Catch::Contains(fmt::format("mean_error_psi is missing from run {};", run)));
  add_night(store, 0.31);
  CHECK(outside_lines(follow(store, kSubject, kTogether)).empty());
}

TEST_CASE("the sparkline spans the values shown") {
  CHECK(sparkline({0.0, 7.0, 3.5}, 10) == "▁█▅");
  CHECK(sparkline({0.0, 7.0, 3.5, 3.5}, 2) == "▅▅");
  CHECK(sparkline({}, 5).empty());
  CHECK(sparkline({1.0, std::nan("")}, 5) == "▅·");
}

TEST_CASE("the night's page is well-formed for any names, and lists red scenarios first") {
  const TemporaryFolder folder;
  db::RunStore store = with_baseline(folder);
  add_night(store, 0.42);
  Suite suite;
  suite.name = "</title><script>alert(1)</script>";
  for (const char* name : {"calm", "broken", "missing"}) {
    Scenario& scenario = suite.scenarios.emplace_back();
    scenario.name = scenario.label = name;
    scenario.about = "<img onerror=\"x\"/>";
  }
  NightPage night{"2026-01-01T00:00:00Z", "commit <b>", {}, {follow(store, kSubject, kTogether)}};
  for (const char* name : {"calm", "broken"}) night.results.emplace_back().name = name;
  night.results[1].wrong = {"said \"<b>\" & more"};
  const std::string page = night_page(suite, night);
  pugi::xml_document xml;
  REQUIRE(xml.load_string(page.c_str(), pugi::parse_default | pugi::parse_doctype));
  CHECK(page.find("<script") == std::string::npos);
  CHECK(page.find("<img") == std::string::npos);
  CHECK(page.find(">broken<") < page.find(">calm<"));
  CHECK_THAT(page, Catch::Contains("SIMULATED") && Catch::Contains("not run") && Catch::Contains("outside"));
  CHECK(xml.child("html").child("body").find_node(
      [](const pugi::xml_node& node) { return std::string(node.attribute("class").value()) == "out"; }));
}
