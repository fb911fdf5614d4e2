// trend: JSON and exit code for figures with hand-computed baselines.
#include <catch2/catch.hpp>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/bench/cli/verb_here.h"
#include "tests/support/text.h"

using namespace tactbench;
using namespace tactbench::tests;
using Told = nlohmann::ordered_json;

namespace {

using Figures = std::map<std::string, double>;

struct StoreOfTrends : OpenStoreHere {
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
    more.insert(more.begin(), "trend");
    return say(bench::add_trend, more);
  }

 private:
  std::int64_t seed_ = 0;
};

}  // namespace

TEST_CASE("trend: reports a statistic as within its band, shifted, outside or missing") {
  StoreOfTrends store;
  store.add_baseline("rig/a", "mean_error_psi");
  const auto figure = [&] { return Told::parse(store.trend({"--json"}).out).at("subjects").at(0).at("figures").at(1); };
  store.add("rig/a", {{"mean_error_psi", 10.0}, {"frames", 100.0}});
  CHECK(store.trend({"--check"}).code == 0);
  store.add("rig/a", {{"mean_error_psi", 12.0}, {"frames", 100.0}});
  // The average of 10, 12 and six times 13: 13 - 2.6 * 0.8^6.
  for (int i = 0; i < 6; ++i) store.add("rig/a", {{"mean_error_psi", 13.0}, {"frames", 100.0}});
  CHECK(figure().at("ewma").at("value").get<double>() == Approx(12.318).margin(1e-3));
  CHECK(figure().at("shifted") == true);
  CHECK(store.trend().code == 0);
  CHECK(store.trend({"--check"}).code == 6);
  CHECK(store.trend({"--check", "--figure", "frames"}).code == 0);
  store.add("rig/a", {{"mean_error_psi", 90.0}, {"frames", 101.0}});
  CHECK(figure().at("outside") == true);
  CHECK(store.trend().code == 0);
  CHECK(store.trend({"--check"}).code == 1);
  store.add("rig/a", {{"frames", 100.0}});
  CHECK(figure().at("missing") == true);
  CHECK(store.trend({"--check"}).code == 1);
  store.add("rig/a", {{"mean_error_psi", 13.0}, {"frames", 100.0}}, "simulated", 9);
  const Told printed = Told::parse(store.trend({"--json"}).out).at("subjects").at(0);
  CHECK(printed.at("same_seeds_as_run") == 9);
  CHECK_FALSE(printed.at("figures").at(1).contains("ewma"));
  CHECK(printed.at("figures").at(1).at("slope_per_run").get<double>() == Approx(0.2916667));
}

TEST_CASE("trend: --check without any comparison is inconclusive") {
  StoreOfTrends store;
  store.add("rig/b", {{"mean_error_psi", 10.0}});
  CHECK(store.trend({"--check"}).code == 6);  // no baseline
  store.add_baseline("rig/a", "mean_error_psi");
  CHECK(store.trend({"--check"}).code == 6);  // the newest run is the baseline's own
  CHECK(store.trend({"--check", "--json"}).code == 6);
  CHECK(store.trend().code == 0);
  store.add("rig/a", {{"mean_error_psi", 10.0}, {"frames", 100.0}});
  CHECK(store.trend({"--check"}).code == 0);
  CHECK(store.trend({"--check", "--subject", "rig/b"}).code == 6);
  CHECK(store.trend({"--check", "--subject", "rig/a"}).code == 0);
}

TEST_CASE("trend: the JSON document has all members of a statistic") {
  StoreOfTrends store;
  store.add_baseline("rig/a", "mean_error_psi");
  const auto printed = [&] { return Told::parse(store.trend({"--json"}).out); };
  const auto error = [&] { return printed().at("subjects").at(0).at("figures").at(1); };
  CHECK_FALSE(error().contains("ewma"));
  CHECK_FALSE(error().contains("slope_per_run"));
  store.add("rig/a", {{"mean_error_psi", 12.0}, {"frames", 100.0}});
  const Told all = printed();
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
      "missing": false, "outside": false, "shifted": false, "outlier": false})"));
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
  const std::string page = store.folder.path("trend.html");
  CHECK(store.trend({"--html", page, "--json"}).code == 0);
  CHECK_THAT(read_file(page), Catch::Contains("rig/a"));
  const Told frames = all.at("subjects").at(0).at("figures").at(0);
  CHECK(frames.at("name") == "frames");
  CHECK(frames.at("baseline").at("constant") == true);
}

TEST_CASE("trend: selects subjects by sensor, subject or statistic, and rejects an empty selection") {
  StoreOfTrends store;
  const auto refused = [&](const std::vector<std::string>& more) {
    const Finished finished = store.trend(more);
    CAPTURE(more);
    check_refusal(finished, 2, "TB-TREND-NONE");
    CHECK(finished.out.empty());
  };
  using Names = std::vector<std::string>;
  const auto subjects = [&](Names more = {}) {
    more.emplace_back("--json");
    Names names;
    const Told printed = Told::parse(store.trend(more).out);
    for (const Told& subject : printed.at("subjects")) names.push_back(subject.at("subject"));
    return names;
  };
  refused({});
  const std::string one = "sensor/S-1/elam", ten = "sensor/S-10/elam";
  store.add(one, {{"mean_error_psi", 13.0}}, "hardware");
  store.add(one, {{"mean_error_psi", 13.5}}, "hardware");
  store.add(ten, {{"mean_error_psi", 2.5}}, "hardware");
  CHECK(subjects() == Names{one, ten});
  CHECK(subjects({"--sensor", "S-1"}) == Names{one});
  CHECK(subjects({"--subject", "sensor/S-10"}) == Names{ten});
  CHECK(subjects({"--subject", "sensor/", "--sensor", "S-10"}) == Names{ten});
  refused({"--sensor", "S-2"});
  refused({"--subject", "ensor"});
  refused({"--figure", "x"});
  store.store.void_run(3, "by hand", "K. Lee", kUtc);
  refused({"--sensor", "S-10"});
  CHECK(subjects() == Names{one});
  store.add("rig/a", {{"mean_error_psi", 1.0}});
  CHECK(subjects() == Names{"rig/a", one});
  CHECK(Told::parse(store.trend({"--json"}).out).at("origin") == "simulated");
  CHECK(Told::parse(store.trend({"--json", "--sensor", "S-1"}).out).at("origin") == "hardware");
}

// trend accept, runs merge and nightly on stores, and their refusals of incomplete ones.

namespace {

struct StoreOfFigures : StoreHere {
  // Run after run, with its own content, and this figure of the subject.
  void add(const std::string& subject, std::size_t count) {
    db::RunStore store = open();
    for (std::size_t i = 0; i < count; ++i) {
      db::RunRecord run = example_run();
      run.seed = ++seed_;
      store.replace_figures(store_example(store, run), subject, {{"error_psi", 0.25 * static_cast<double>(seed_)}});
    }
  }
  Finished accept(std::vector<std::string> runs, const std::vector<std::string>& more = {}) const {
    runs.insert(runs.begin(), {"trend", "accept", "--db", path, "--by", "K. Lee", "--reason", "as made"});
    runs.insert(runs.end(), more.begin(), more.end());
    return verb_here(bench::add_trend, runs);
  }

 private:
  std::int64_t seed_ = 0;
};

}  // namespace

TEST_CASE("trend accept: rejects invalid run ranges, and runs without values") {
  StoreOfFigures store;
  store.add("rig/a", 1);
  {
    db::RunStore open = store.open();
    store_example(open);  // run 2, without figures
  }
  for (const char* word :
       {"0", "-1", "1-", "1-0", "x", "1x", "1-2x", "1-2-3", "5-4", " 1", "1 ", "99999999999999999999"}) {
    INFO(word);
    check_refusal(store.accept({"--", word}), 2, "TB-USAGE", "RUNS");
  }
  for (const char* runs : {"2", "2-99"}) {
    const Finished refused = store.accept({runs});
    CHECK(refused.code == 2);
    CHECK_THAT(refused.err, Catch::Contains("[TB-BASELINE-NO-FIGURES]"));
    CHECK(refused.out.empty());
  }
  CHECK_THAT(store.accept({"99"}).err, Catch::Contains("[TB-STORE-NOT-FOUND]"));
  CHECK_THAT(store.accept({"1"}).err, Catch::Contains("[TB-BASELINE-SHORT]"));
  store.open().void_run(2, "by hand", "K. Lee", kUtc);
  CHECK_THAT(store.accept({"2"}).err, Catch::Contains("[TB-RUN-VOID]"));
  CHECK(store.accept({"2", "--void-too"}).code == 2);
  CHECK(store.printed<nlohmann::json>(bench::add_trend, {"trend", "baselines"}).at("baselines").empty());
}

TEST_CASE("trend accept: each subject gets its own runs of a range") {
  StoreOfFigures store;
  store.add("rig/a", 8);          // runs 1 to 8
  store.add("nightly/short", 7);  // 9 to 15
  const Finished refused = store.accept({"1-15"});
  CHECK_THAT(refused.err, Catch::Contains("[TB-BASELINE-SHORT]"));
  const auto alone = nlohmann::json::parse(store.accept({"1-15"}, {"--subject", "rig/", "--json"}).out).at("baselines");
  CHECK((alone.size() == 1 && alone.at(0).at("subject") == "rig/a"));
  store.add("nightly/short", 1);  // 16
  CHECK(store.accept({"1-8", "9-16", "3"}).code == 0);
  store.add("rig/a", 12);  // 17 to 28
  CHECK(store.accept({"1-8", "17-27"}).code == 0);
  const nlohmann::json printed = nlohmann::json::parse(store.accept({"1-8", "17-28"}, {"--json"}).out);
  CHECK(printed.at("store") == store.path);
  REQUIRE(printed.at("baselines").size() == 1);
  const nlohmann::json& one = printed.at("baselines").at(0);
  check_members(one, R"({"baseline": 5, "subject": "rig/a", "counted": 20})");
  CHECK(one.at("runs").size() == 20);
  CHECK(one.at("runs").at(8) == 17);
  const auto listed = store.printed<nlohmann::json>(bench::add_trend, {"trend", "baselines"});
  CHECK(listed.at("baselines").size() == 5);
  CHECK(listed.at("baselines").at(0).at("accepted_by") == "K. Lee");
  CHECK(listed.at("baselines").at(0).at("reason") == "as made");
}

TEST_CASE("runs merge: stores without a night give no night file, and the merged runs are reported") {
  StoreOfFigures store, other;
  store.add("rig/a", 2);
  other.add("rig/a", 1);
  const std::string all = store.folder.path("all.db");
  const auto merge = [&](const std::vector<std::string>& more) {
    return verb_here(bench::add_runs, joined({"runs", "merge", store.path, other.path, "--db", all}, more));
  };
  for (const char* file : {"--html", "--junit", "--metrics"}) {
    const std::string target = store.folder.path("night");
    check_refusal(merge({file, target}), 2, "TB-MERGE-NIGHT");
    CHECK_FALSE(std::filesystem::exists(target));
    std::filesystem::remove(all);
  }
  CHECK(merge({}).code == 0);
  const nlohmann::json printed = nlohmann::json::parse(merge({"--json"}).out);
  CHECK(printed.at("parts") == nlohmann::json({store.path, other.path}));
  CHECK(printed.at("nights").empty());
  CHECK(printed.at("there") == 3);
}

TEST_CASE("nightly: one part of a night needs its own store, and no page") {
  StoreOfFigures store;
  store.add("rig/a", 1);
  const std::string suite = store.folder.path("suite.toml");
  write_file(suite,
             "schema = 1\nname = \"s\"\n[[scenario]]\nname = \"a\"\nabout = \"b\"\n[[scenario]]\nname = \"c\"\n"
             "about = \"d\"\nseed = 5\n");
  const auto night = [&](const std::vector<std::string>& more) {
    return verb_here(bench::add_nightly, joined({"nightly", suite}, more));
  };
  const auto refused = [&](const std::vector<std::string>& more, const std::string& id) {
    const Finished finished = night(more);
    check_refusal(finished, 2, id);
    CHECK(finished.out.empty());
  };
  refused({"--shard", "1/2"}, "TB-USAGE");
  refused({"--shard", "1/2", "--db", store.path, "--html", "x.html"}, "TB-USAGE");
  refused({"--shard", "1/2", "--db", store.path}, "TB-SHARD-STORE");
  CHECK_THAT(night({"--list", "--only", "x"}).err, Catch::Contains("[TB-NIGHTLY-SCENARIO]"));
  const nlohmann::json listed = nlohmann::json::parse(night({"--list", "--json", "--seed", "9", "--seeds", "3"}).out);
  CHECK(listed.at("schema") == "tactbench.nightly.list");
  CHECK(listed.at("suite") == "s");
  REQUIRE(listed.at("scenarios").size() == 2);
  CHECK(listed.at("scenarios").at(0) == nlohmann::json::parse(R"({"name": "a", "about": "b", "seed": 1})"));
  CHECK(listed.at("scenarios").at(1) == nlohmann::json::parse(R"({"name": "c", "about": "d", "seed": 5})"));
}
