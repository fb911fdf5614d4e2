// trend: what it prints, tells as JSON and ends with, of figures whose baselines are worked out by hand.
#include <catch2/catch.hpp>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/bench/cli/verb_here.h"
#include "tests/db/store_example.h"

using namespace tactbench;
using namespace tactbench::tests;
using Told = nlohmann::ordered_json;

namespace {

using Figures = std::map<std::string, double>;

struct StoreOfTrends {
  std::int64_t add(const std::string& subject, const Figures& figures, const std::string& origin = "simulated",
                   std::int64_t seed = 0) {
    db::RunRecord run = example_run();
    run.origin = origin;
    run.seed = seed != 0 ? seed : ++seed_;
    const std::int64_t number = begin_example(store, run).run;
    store.end_run(number, db::Outcome::kCompleted, "", db::SafeState::kVerified, kUtc);
    store.replace_figures(number, subject, figures);
    return number;
  }
  // Eight runs of 9 and 11 by turns: mean 10, deviation sqrt(8/7) = 1.069; and a count that is always 100.
  void add_baseline(const std::string& subject, const std::string& figure, const std::string& origin = "simulated") {
    db::BaselineRecord baseline{0, subject, "as delivered", "K. Lee", kUtc, {}};
    for (int i = 0; i < 8; ++i)
      baseline.runs.push_back(add(subject, {{figure, i % 2 == 0 ? 9.0 : 11.0}, {"frames", 100.0}}, origin));
    store.add_baseline(baseline);
  }
  Finished trend(std::vector<std::string> more = {}) const {
    more.insert(more.begin(), {"trend", "--db", path});
    return verb_here(bench::add_trend, more);
  }
  TemporaryFolder folder;
  std::string path = folder.path("runs.db");
  db::RunStore store = db::RunStore::open(path, db::Durability::kNormal);

 private:
  std::int64_t seed_ = 0;
};

}  // namespace

TEST_CASE("trend: a figure line by line, from within its band to shifted, outside and missing") {
  StoreOfTrends store;
  store.add_baseline("rig/a", "mean_error_psi");
  const auto shown = [&](const std::vector<std::string>& more = {}) { return store.trend(more).out; };
  const std::string head = "SIMULATED DATA\nrig/a: baseline of 8 runs (as delivered)\n";
  const std::string error = "  mean_error_psi               ", frames = "  frames                       ";
  CHECK(shown() == head + frames + "▅▅▅▅▅▅▅▅                               100  100 to 100\n" + error +
                       "▁█▁█▁█▁█                                11  -2.7164 to 22.716\n");
  store.add("rig/a", {{"mean_error_psi", 10.0}, {"frames", 100.0}});
  CHECK(shown() == head + frames + "▅▅▅▅▅▅▅▅▅                              100  100 to 100\n" + error +
                       "▁█▁█▁█▁█▅                               10  -2.7164 to 22.716  average 10, p 1\n");
  CHECK(store.trend({"--check"}).code == 0);
  store.add("rig/a", {{"mean_error_psi", 12.0}, {"frames", 100.0}});
  CHECK(shown({"--units", "kPa", "--figure", "mean_error_psi"}) ==
        head +
            "  mean_error_kpa               ▁▆▁▆▁▆▁▆▃█                          82.737  -18.729 to 156.62  average "
            "71.705, p 0.9\n");
  // The average of 10, 12 and six times 13: 13 - 2.6 * 0.8^6.
  for (int i = 0; i < 6; ++i) store.add("rig/a", {{"mean_error_psi", 13.0}, {"frames", 100.0}});
  CHECK(shown({"--figure", "mean_error_psi"}) ==
        head + error +
            "▁▅▁▅▁▅▁▅▃▇██████                        13  -2.7164 to 22.716  average 12.318, p 0.02  shifted, +0 a "
            "run\n");
  CHECK(store.trend().code == 0);
  CHECK(store.trend({"--check"}).code == 6);
  CHECK(store.trend({"--check", "--figure", "frames"}).code == 0);
  store.add("rig/a", {{"mean_error_psi", 90.0}, {"frames", 101.0}});
  CHECK(shown() == head + frames + "▁▁▁▁▁▁▁▁▁▁▁▁▁▁▁▁█                      101  100 to 100  OUTSIDE\n" + error +
                       "▁▁▁▁▁▁▁▁▁▁▁▁▁▁▁▁█                       90  -2.7164 to 22.716  average 12.318, p 0.02  "
                       "OUTSIDE\n");
  CHECK(store.trend().code == 0);
  CHECK(store.trend({"--check"}).code == 1);
  store.add("rig/a", {{"frames", 100.0}});
  CHECK_THAT(shown(), Catch::EndsWith(" 90  -2.7164 to 22.716  average 12.318, p 0.02  MISSING\n"));
  CHECK(store.trend({"--check"}).code == 1);
  store.add("rig/a", {{"mean_error_psi", 13.0}, {"frames", 100.0}}, "simulated", 9);
  CHECK_THAT(shown(), Catch::StartsWith("SIMULATED DATA\nrig/a: baseline of 8 runs (as delivered); run 19 has the "
                                        "seeds of run 9: no moving average\n") &&
                          Catch::EndsWith(" 13  -2.7164 to 22.716\n"));
  const Told told = Told::parse(store.trend({"--json"}).out).at("subjects").at(0);
  CHECK(told.at("same_seeds_as_run") == 9);
  CHECK_FALSE(told.at("figures").at(1).contains("ewma"));
  CHECK(told.at("figures").at(1).at("slope_per_run").get<double>() == Approx(0.2916667));
}

TEST_CASE("trend: all that JSON has of a figure") {
  StoreOfTrends store;
  store.add_baseline("rig/a", "mean_error_psi");
  const auto told = [&] { return Told::parse(store.trend({"--json"}).out); };
  const auto error = [&] { return told().at("subjects").at(0).at("figures").at(1); };
  CHECK_FALSE(error().contains("ewma"));
  CHECK_FALSE(error().contains("slope_per_run"));
  store.add("rig/a", {{"mean_error_psi", 12.0}, {"frames", 100.0}});
  const Told all = told();
  CHECK(all.at("schema") == "tactbench.trend");
  CHECK(all.at("store") == store.path);
  CHECK(all.at("origin") == "simulated");
  CHECK(all.at("subjects").at(0).at("subject") == "rig/a");
  CHECK_FALSE(all.at("subjects").at(0).contains("same_seeds_as_run"));
  Told figure = error();
  const Told band = figure.at("baseline"), ewma = figure.at("ewma");
  figure.erase("baseline");
  figure.erase("ewma");
  CHECK(figure == Told::parse(R"({"name": "mean_error_psi", "runs": [1, 2, 3, 4, 5, 6, 7, 8, 9],
      "values": [9.0, 11.0, 9.0, 11.0, 9.0, 11.0, 9.0, 11.0, 12.0],
      "missing": false, "outside": false, "shifted": false})"));
  CHECK(band.at("runs") == 8);
  CHECK(band.at("mean") == 10.0);
  CHECK(band.at("deviation").get<double>() == Approx(1.0690450));
  CHECK(band.at("low").get<double>() == Approx(-2.7164444));
  CHECK(band.at("high").get<double>() == Approx(22.7164444));
  CHECK(band.at("constant") == false);
  CHECK(band.at("logarithmic") == false);
  CHECK(ewma.at("runs") == 1);
  CHECK(ewma.at("value").get<double>() == Approx(10.4));
  CHECK(ewma.at("deviations").get<double>() == Approx(0.4 / 1.0690450));
  CHECK(ewma.at("probability").get<double>() > 0.5);
  const Told frames = all.at("subjects").at(0).at("figures").at(0);
  CHECK(frames.at("name") == "frames");
  CHECK(frames.at("baseline").at("constant") == true);
}

TEST_CASE("trend: a line of thirty blocks, a rising figure and its slope") {
  StoreOfTrends store;
  store.add_baseline("rig/a", "mean_error_psi", "hardware");
  for (int i = 0; i < 14; ++i) store.add("rig/a", {{"mean_error_psi", 10.0 + 0.5 * i}, {"frames", 100.0}}, "hardware");
  const std::string rising = store.trend({"--figure", "mean_error_psi"}).out;
  CHECK_THAT(rising, Catch::StartsWith("rig/a: baseline of 8 runs (as delivered)\n") &&
                         Catch::EndsWith("  shifted, +0.5 a run\n"));
  for (int i = 0; i < 10; ++i) store.add("rig/a", {{"mean_error_psi", 12.0}, {"frames", 100.0}}, "hardware");
  std::string line = "  frames                       ";
  for (int i = 0; i < 30; ++i) line += "▅";
  CHECK(store.trend({"--figure", "frames"}).out ==
        "rig/a: baseline of 8 runs (as delivered)\n" + line + "         100  100 to 100\n");
}

TEST_CASE("trend: subjects that are chosen, and what is refused") {
  StoreOfTrends store;
  const auto refused = [&](const std::vector<std::string>& more, const std::string& said) {
    const Finished finished = store.trend(more);
    CHECK(finished.code == 2);
    CHECK(finished.out.empty());
    CHECK(finished.err == "error: " + said + "\n");
  };
  const std::string none = "there are no such figures [TB-TREND-NONE]\n  at: " + store.path + "\n  try: ";
  refused({}, none + "fit, nightly --db and rig check store figures");
  store.add("sensor/S-1/elam", {{"mean_error_psi", 13.0}}, "hardware");
  store.add("sensor/S-1/elam", {{"mean_error_psi", 13.5}}, "hardware");
  store.add("sensor/S-10/elam", {{"mean_error_psi", 2.5}}, "hardware");
  const std::string first =
                        "sensor/S-1/elam: no baseline\n"
                        "  mean_error_psi               ▁█                                    13.5\n",
                    second =
                        "sensor/S-10/elam: no baseline\n"
                        "  mean_error_psi               ▅                                      2.5\n";
  CHECK(store.trend().out == first + second);
  CHECK(store.trend({"--sensor", "S-1"}).out == first);
  CHECK(store.trend({"--subject", "sensor/S-10"}).out == second);
  CHECK(store.trend({"--subject", "sensor/", "--sensor", "S-10"}).out == second);
  CHECK(store.trend({"--check"}).code == 0);
  refused({"--sensor", "S-2"}, none + "there are: sensor/S-1/elam, sensor/S-10/elam");
  refused({"--subject", "ensor"}, none + "there are: sensor/S-1/elam, sensor/S-10/elam");
  refused({"--figure", "x"}, "there is no figure 'x' [TB-TREND-NONE]\n  at: --figure\n  try: omit it to list all");
  store.store.void_run(3, "by hand", "K. Lee", kUtc);
  refused({"--sensor", "S-10"}, "all runs with such figures are void [TB-TREND-NONE]\n  at: " + store.path +
                                    "\n  try: tactbench runs list --all shows why");
  CHECK(store.trend().out == first);
  store.add("rig/a", {{"mean_error_psi", 1.0}});
  CHECK_THAT(store.trend().out, Catch::StartsWith("SIMULATED DATA\nrig/a: no baseline\n") && Catch::EndsWith(first));
  CHECK(Told::parse(store.trend({"--json"}).out).at("origin") == "simulated");
  CHECK(Told::parse(store.trend({"--json", "--sensor", "S-1"}).out).at("origin") == "hardware");
}

TEST_CASE("trend: baselines that are too short, or repeat a run") {
  StoreOfTrends store;
  db::BaselineRecord baseline{0, "rig/a", "as made", "K. Lee", kUtc, {}};
  for (const std::int64_t seed : {11, 12, 12})
    baseline.runs.push_back(store.add("rig/a", {{"mean_error_psi", 10.0}}, "simulated", seed));
  store.store.add_baseline(baseline);
  CHECK_THAT(store.trend().out,
             Catch::StartsWith("SIMULATED DATA\nrig/a: baseline of 3 runs, of which 1 repeat another run and do not "
                               "count (as made); fewer than three measurements: it does not judge; run 3 has the "
                               "seeds of run 2: no moving average\n"));
}

TEST_CASE("trend: a page, and its name as the last line") {
  StoreOfTrends store;
  store.add_baseline("rig/a", "mean_error_psi");
  const std::string page = store.folder.path("trend.html");
  CHECK_THAT(store.trend({"--html", page}).out, Catch::EndsWith("22.716\n" + page + "\n"));
  CHECK_THAT(read_file(page), Catch::Contains("Figures over time") && Catch::Contains("rig/a"));
  CHECK_THAT(store.trend({"--html", page, "--json"}).out, !Catch::Contains(page + "\n"));
}
