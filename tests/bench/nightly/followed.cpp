// Figures over nights: what is reported, and what must not be.

#include "bench/nightly/subject_trend.h"

#include <fmt/format.h>
#include <catch2/catch.hpp>
#include <pugixml.hpp>

#include <limits>
#include <random>

#include "bench/nightly/trend_pages.h"
#include "tests/db/store_example.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::bench;
using namespace tactbench::tests;
using analysis::PressureUnit;

namespace {

constexpr const char* kSubject = "nightly/paper";

std::int64_t add_night(db::RunStore& store, double value, const std::string& origin = "simulated",
                       std::int64_t seed = 0) {
  db::RunRecord record = example_run();
  record.origin = origin;
  record.seed = seed != 0 ? seed : 1000 + static_cast<std::int64_t>(store.runs().size());  // each its own
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

TrendFigure only_figure(const db::RunStore& store) {
  const SubjectTrend followed = trend_of_subject(store, kSubject);
  REQUIRE(followed.figures.size() == 1);
  return followed.figures.front();
}

}  // namespace

TEST_CASE("trend: a night is reported only if it lies outside the spread over seeds") {
  const TemporaryFolder folder;
  db::RunStore store = with_baseline(folder);
  CHECK_FALSE(only_figure(store).outside);  // accepted runs do not judge themselves
  add_night(store, 0.32);
  const TrendFigure within = only_figure(store);
  CHECK((within.chart.band && within.chart.ewma && !within.outside && !within.shifted));
  CHECK(within.chart.band->deviation == Approx(0.0085).margin(0.001));
  add_night(store, 0.45);
  CHECK(only_figure(store).outside);
  const std::vector<std::string> lines = outside_band_lines(trend_of_subject(store, kSubject));
  REQUIRE(lines.size() == 1);
  for (const char* part : {"mean_error_psi", "0.45", "8 runs", "as delivered", "K. Lee"})
    CHECK(lines.front().find(part) != std::string::npos);
}

TEST_CASE("trend: shifts are judged by the false discovery rate of all values together, constants do not count") {
  // Baselines of mean 0 and deviation 1 (eight values, sum of squares 7). After six runs at 3 the EWMA is 3 (1 - 0.8^6)
  // = 2.2136, its variance 0.1035 + 0.0681: Student's t is 5.34, p in one run 0.0011, in sixty 0.014.
  const auto shifted = [&](int further, double step, int nights) {
    const TemporaryFolder folder;
    db::RunStore store = db::RunStore::open(folder.path("runs.db"));
    db::BaselineRecord baseline{0, kSubject, "as delivered", "K. Lee", "2026-01-01T00:00:00Z", {}};
    const std::vector<double> values = {-1.0, 1.0, -1.0 - 1e-6, 1.0 + 1e-6, -std::sqrt(1.5), std::sqrt(1.5), 0.0, 1e-6};
    const auto figures = [&](double first, double others) {
      std::map<std::string, double> all = {{"a_psi", first}, {"frames", 3310.0}};
      for (int i = 0; i < further; ++i) all[fmt::format("b{}_psi", i)] = others;
      return all;
    };
    for (const double value : values) {
      baseline.runs.push_back(add_night(store, value));
      store.replace_figures(baseline.runs.back(), kSubject, figures(value, value));
    }
    store.add_baseline(baseline);
    for (int night = 0; night < nights; ++night)
      store.replace_figures(add_night(store, 0.0), kSubject, figures(step, 1e-3 * night));
    return trend_of_subject(store, kSubject).figures.front().shifted;
  };
  CHECK_FALSE(shifted(0, 0.5, 6));
  CHECK(shifted(0, 3.0, 6));
  CHECK_FALSE(shifted(9, 3.0, 6));  // one of ten would need 0.005
  CHECK(shifted(9, 8.0, 6));
}

TEST_CASE("trend: simulated nights with repeated seeds are compared by content, not by the EWMA chart") {
  const TemporaryFolder folder;
  db::RunStore store = with_baseline(folder);
  for (int night = 0; night < 20; ++night) add_night(store, 0.33, "simulated", 77);
  const SubjectTrend fixed = trend_of_subject(store, kSubject);
  CHECK(fixed.same_seeds == fixed.run - 1);
  CHECK_FALSE(fixed.figures.front().chart.ewma);
  CHECK(fixed.figures.front().chart.band);
  const std::int64_t drawn = add_night(store, 0.33);
  const SubjectTrend charted = trend_of_subject(store, kSubject);
  CHECK((charted.run == drawn && charted.same_seeds == 0));
  REQUIRE(charted.figures.front().chart.ewma);
  CHECK(charted.figures.front().chart.ewma->later == 2);  // the first with seed 77, and this one
}

TEST_CASE("trend: runs on instruments have no seeds, and only runs after the baseline enter the EWMA chart") {
  const TemporaryFolder folder;
  db::RunStore store = db::RunStore::open(folder.path("runs.db"));
  db::BaselineRecord baseline{0, kSubject, "as delivered", "K. Lee", "2026-01-01T00:00:00Z", {}};
  add_night(store, 9.0, "hardware", 1);
  for (int i = 0; i < 8; ++i) baseline.runs.push_back(add_night(store, 0.30 + 0.01 * i, "hardware"));
  store.add_baseline(baseline);
  for (int i = 0; i < 3; ++i) add_night(store, 0.33, "hardware", 1);
  const SubjectTrend followed = trend_of_subject(store, kSubject);
  CHECK(followed.same_seeds == 0);
  REQUIRE(followed.figures.front().chart.ewma);
  CHECK(followed.figures.front().chart.ewma->later == 3);
}

TEST_CASE("trend: runs of a baseline that repeat one another count once") {
  const TemporaryFolder folder;
  db::RunStore store = db::RunStore::open(folder.path("runs.db"));
  db::BaselineRecord baseline{0, kSubject, "as delivered", "K. Lee", "2026-01-01T00:00:00Z", {}};
  for (const double value : {0.30, 0.30, 0.30, 0.31}) baseline.runs.push_back(add_night(store, value));
  store.add_baseline(baseline);
  // Two measurements have no spread yet that a third could be held against.
  CHECK_FALSE(only_figure(store).chart.band);
  const std::string judges_nothing = short_baseline(trend_of_subject(store, kSubject));
  CHECK_FALSE(judges_nothing.empty());
  CHECK(trend_of_subject(store, kSubject).repeated == 2);
  baseline.runs.push_back(add_night(store, 0.32));
  store.add_baseline(baseline);
  const TrendFigure figure = only_figure(store);
  REQUIRE(figure.chart.band);
  CHECK(figure.chart.band->values == 3);
  CHECK(figure.chart.band->mean == Approx(0.31));
  CHECK(figure.chart.band->deviation == Approx(0.01));
  add_night(store, 0.33);
  CHECK_FALSE(only_figure(store).outside);
  CHECK_FALSE(only_figure(store).chart.ewma);  // accepted by an earlier version: too few for a chart
  const std::string judges_little = short_baseline(trend_of_subject(store, kSubject));
  CHECK_FALSE((judges_little.empty() || judges_little == judges_nothing));
}

TEST_CASE("trend: a slow change within the wide band is reported within two weeks") {
  const TemporaryFolder folder;
  db::RunStore store = with_baseline(folder);
  int reported_on = 0;
  for (int night = 1; night <= 14; ++night) {
    add_night(store, 0.30 + 0.003 * night);
    const TrendFigure figure = only_figure(store);
    CHECK_FALSE(figure.outside);
    if (figure.shifted && reported_on == 0) reported_on = night;
  }
  CHECK((reported_on > 3 && reported_on <= 14));
  CHECK_THAT(shift_lines(trend_of_subject(store, kSubject)).at(0),
             Catch::Contains("mean_error_psi") && Catch::Contains("8 runs") && Catch::Contains("+0.003"));
}

TEST_CASE("trend: 120 nights with different seeds and no change give no alarm") {
  const TemporaryFolder folder;
  db::RunStore store = with_baseline(folder);
  std::mt19937 random(3);
  std::normal_distribution<double> normal(0.30, 0.009);
  int alarms = 0;
  for (int night = 1; night <= 120; ++night) {
    add_night(store, normal(random));
    const TrendFigure figure = only_figure(store);
    alarms += figure.shifted || figure.outside ? 1 : 0;
  }
  CHECK(alarms == 0);
}

TEST_CASE("trend: void runs and runs of another origin are left out") {
  const TemporaryFolder folder;
  db::RunStore store = with_baseline(folder);
  add_night(store, 9.0, "hardware");
  CHECK(only_figure(store).values == std::vector<double>{9.0});
  const std::int64_t last = add_night(store, 0.31);
  CHECK(only_figure(store).values.size() == 9);
  store.void_run(last, "valve leaked", "K. Lee", "2026-01-01T00:00:00Z");
  CHECK(only_figure(store).values.front() == 9.0);
}

TEST_CASE("trend: a value in the baseline that the newest run lacks is reported") {
  const TemporaryFolder folder;
  db::RunStore store = with_baseline(folder);
  const std::int64_t run = add_night(store, 0.31);
  store.replace_figures(run, kSubject, {{"other_psi", 1.0}});
  const SubjectTrend followed = trend_of_subject(store, kSubject);
  const std::vector<std::string> lines = outside_band_lines(followed);
  REQUIRE(lines.size() == 1);
  CHECK_THAT(lines.front(), Catch::Contains("mean_error_psi") && Catch::Contains(fmt::format("run {}", run)));
  add_night(store, 0.31);
  CHECK(outside_band_lines(trend_of_subject(store, kSubject)).empty());
}

TEST_CASE("sparkline: its scale spans three bands, or starts at 0") {
  CHECK(sparkline({0.0, 0.99, 1.01, 8.0, -0.1, 8.1}, {0.0, 8.0}, 9) == "▁▁▂█↓↑");
  CHECK(sparkline({1.0, std::nan(""), std::numeric_limits<double>::infinity()}, {0.0, 1.0}, 2) == "··");
  CHECK(sparkline({}, {}, 5).empty());
  TrendFigure figure;
  figure.values = {100.0, 100.01};
  CHECK(scale_of(figure).low == 0.0);
  CHECK(scale_of(figure).high == 100.01);
  figure.values = {-2.0, -1.0};
  CHECK(scale_of(figure).low == -2.0);
  CHECK(scale_of(figure).high == 0.0);
  figure.chart.band = analysis::ControlBand{1.5, 0.25, 1.0, 2.0, 8};
  CHECK(scale_of(figure).low == 0.0);
  CHECK(scale_of(figure).high == 3.0);
  figure.values = {0.0};
  figure.chart.band.reset();
  CHECK(scale_of(figure).high > scale_of(figure).low);
}

TEST_CASE("statistic names: name and unit of a key as printed") {
  for (const auto& [key, name, unit] : {std::tuple("mean_error_psi", "mean error", "psi"),
                                        {"hysteresis_max_percent_fs", "hysteresis max", "% FS"},
                                        {"elam_alpha_a1_per_psi", "elam alpha a1", "1/psi"},
                                        {"hold_drift_kpa_per_min", "hold drift", "kPa/min"},
                                        {"press_stiffness_n_per_mm", "press stiffness", "N/mm"},
                                        {"unfit_taxels", "unfit taxels", ""},
                                        {"psi", "psi", ""}}) {
    CHECK(display_text(key).name == name);
    CHECK(display_text(key).unit == unit);
  }
}

TEST_CASE("trend: a sensor that differs from four others with the same recipes is an outlier") {
  std::vector<SubjectTrend> sensors(6);
  const double noise[] = {1.1, 1.2, 1.3, 1.15, 31.9, 500.0};
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    sensors[i].subject = fmt::format("sensor/S-{}/{}", i, i < 5 ? "loops" : "other");
    sensors[i].figures.resize(1);
    sensors[i].figures[0].name = "noisiest_taxel_mv";
    sensors[i].figures[0].values = {noise[i]};
  }
  mark_outliers(sensors);
  for (std::size_t i = 0; i < sensors.size(); ++i) CHECK(sensors[i].figures[0].outlier == (i == 4));
}

TEST_CASE("nightly page: is well-formed for any names, and lists failed scenarios first") {
  const TemporaryFolder folder;
  db::RunStore store = with_baseline(folder);
  add_night(store, 0.45);
  Suite suite;
  suite.name = "</title><script>alert(1)</script>";
  for (const char* name : {"calm", "broken", "missing"}) {
    Scenario& scenario = suite.scenarios.emplace_back();
    scenario.name = scenario.label = name;
    scenario.about = "<img onerror=\"x\"/>";
  }
  NightPage night{"2026-01-01T00:00:00Z", "commit <b>", {}, {trend_of_subject(store, kSubject)}};
  for (const char* name : {"calm", "broken"}) night.results.emplace_back().name = name;
  night.results[1].wrong = {"said \"<b>\" & more"};
  const std::string page = night_page(suite, night);
  pugi::xml_document xml;
  REQUIRE(xml.load_string(page.c_str(), pugi::parse_default | pugi::parse_doctype));
  CHECK(page.find("<script") == std::string::npos);
  CHECK(page.find("<img") == std::string::npos);
  CHECK(page.find(">broken<") < page.find(">calm<"));
  CHECK(page.find(">calm<") < page.find(">missing<"));
  CHECK(xml.child("html").child("body").find_node(
      [](const pugi::xml_node& node) { return std::string(node.attribute("class").value()) == "out"; }));
}

// Trends of figures in kPa and bar: which names are of pressures, what is multiplied, what stays.

namespace {

constexpr double kKpaOfPsi = 6.894757293168361;

SubjectTrend one_figure(const std::string& name) {
  SubjectTrend followed;
  followed.subject = "rig/psi";
  TrendFigure figure;
  figure.name = name;
  figure.values = {1.0, 2.0};
  figure.chart.band = analysis::ControlBand{1.5, 0.25, 1.0, 2.0, 8};
  figure.chart.level = 1.75;
  figure.chart.slope = 0.125;
  followed.figures = {figure};
  return followed;
}

}  // namespace

TEST_CASE("trend units: values, band, average, slope and name of a pressure are converted") {
  const TrendFigure kpa = in_unit(one_figure("mean_error_psi"), PressureUnit::kKilopascal).figures[0];
  CHECK(kpa.name == "mean_error_kpa");
  CHECK(kpa.values[1] == Approx(2.0 * kKpaOfPsi));
  CHECK(kpa.chart.band->mean == Approx(1.5 * kKpaOfPsi));
  CHECK(kpa.chart.band->low == Approx(kKpaOfPsi));
  CHECK(kpa.chart.band->high == Approx(2.0 * kKpaOfPsi));
  CHECK(kpa.chart.band->deviation == Approx(0.25 * kKpaOfPsi));
  CHECK(kpa.chart.level == Approx(1.75 * kKpaOfPsi));
  CHECK(*kpa.chart.slope == Approx(0.125 * kKpaOfPsi));
  CHECK(in_unit(one_figure("mean_error_psi"), PressureUnit::kKilopascal).subject == "rig/psi");
  SubjectTrend logarithmic = one_figure("max_error_psi");
  logarithmic.figures[0].chart.logarithmic = true;
  CHECK(in_unit(logarithmic, PressureUnit::kKilopascal).figures[0].chart.band->deviation == 0.25);
}

TEST_CASE("trend units: pressure rates and reciprocals of pressure are converted, other names are not") {
  const TrendFigure rate = in_unit(one_figure("hold_drift_psi_per_min"), PressureUnit::kBar).figures[0];
  CHECK(rate.name == "hold_drift_bar_per_min");
  CHECK(rate.values[0] == Approx(0.01 * kKpaOfPsi));
  const TrendFigure share = in_unit(one_figure("elam_alpha_a1_per_psi"), PressureUnit::kKilopascal).figures[0];
  CHECK(share.name == "elam_alpha_a1_per_kpa");
  CHECK(share.values[1] == Approx(2.0 / kKpaOfPsi));
  for (const char* other : {"dead_taxels", "psilon", "epsi_v", "full_scale_v"}) {
    const TrendFigure same = in_unit(one_figure(other), PressureUnit::kKilopascal).figures[0];
    CHECK((same.name == other && same.values[1] == 2.0 && same.chart.level == 1.75));
  }
  const TrendFigure psi = in_unit(one_figure("mean_error_psi"), PressureUnit::kPsi).figures[0];
  CHECK((psi.name == "mean_error_psi" && psi.values[1] == 2.0));
}
