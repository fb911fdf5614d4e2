// Facts that the fleet gets about a run, and runs that are copied back one by one.
#include "bench/fleet/facts.h"

#include <catch2/catch.hpp>
#include <functional>
#include <nlohmann/json.hpp>
#include <set>

#include "db/fleet/runs.h"
#include "tests/db/store_example.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::tests;
using db::RunStore;

namespace {

// Run 2 is judged by the second fit of run 1.
void store_judged(RunStore& store) {
  const std::int64_t first = store_example(store), second = store_example(store);
  db::FitRecord fit;
  fit.run = first;
  fit.model = "elam";
  fit.created_utc = "2026-01-01T00:00:00Z";
  (void)store.add_fit(fit);
  fit.created_utc = "2026-01-02T00:00:00Z";
  db::VerdictRecord verdict;
  verdict.verdict = "pass";
  store.replace_verdicts(second, store.add_fit(fit), {verdict});
  store.replace_figures(second, "sensor", {{"error_psi", 0.5}});
}

std::string said(const RunStore& store, std::int64_t run) { return bench::said_sha256(store, store.run(run)); }

}  // namespace

TEST_CASE("fleet facts: the same run has the same hash in each store, and every change of its facts changes the hash") {
  const TemporaryFolder folder;
  RunStore store = RunStore::open(folder.path("a.db")), other = RunStore::open(folder.path("b.db"));
  store_judged(store);
  store_example(other);
  (void)other.copy_runs_from(store, {1, 2});
  CHECK(said(other, 2) == said(store, 1));
  CHECK(said(other, 3) == said(store, 2));
  std::set<std::string> seen = {said(store, 1)};
  const auto changes = [&](const std::function<void()>& change) {
    change();
    CHECK(seen.insert(said(store, 1)).second);
  };
  changes([&] { store.set_tags(1, {"good"}, {}); });
  changes([&] { store.add_note(1, "the door was open"); });
  changes([&] { store.replace_figures(1, "sensor", {{"error_psi", 0.25}}); });
  changes([&] {
    db::FitRecord fit;
    fit.run = 1;
    fit.model = "mpi";
    (void)store.add_fit(fit);
  });
  changes([&] {
    db::VerdictRecord verdict;
    verdict.verdict = "fail";
    store.replace_verdicts(1, 1, {verdict});
  });
  changes([&] { store.void_run(1, "gauge closed", "me", "2026-01-03T00:00:00Z"); });
}

TEST_CASE("fleet facts: the JSON document names the runs that it rests on") {
  const TemporaryFolder folder;
  RunStore store = RunStore::open(folder.path("a.db"));
  store_judged(store);
  const nlohmann::json facts = nlohmann::json::parse(bench::facts_of(store, store.run(2)));
  CHECK(facts.at("uuid") == store.run(2).uuid);
  CHECK(facts.at("frames") == store.frame_count(2));
  CHECK(facts.at("rests_on") == std::vector<std::string>{store.run(1).uuid});
  CHECK(facts.at("figures").at("sensor").at("error_psi") == 0.5);
  CHECK(facts.at("verdicts").at(0).at("models_of") == store.run(1).uuid);
  CHECK(facts.at("verdicts").at(0).at("fit") == 1);
}

TEST_CASE("fleet facts: runs that are fetched one by one keep the models of their verdicts, under new numbers") {
  const TemporaryFolder folder;
  RunStore store = RunStore::open(folder.path("a.db"));
  store_judged(store);
  RunStore back = RunStore::open(folder.path("back.db"));
  std::vector<bench::ModelsOfVerdicts> models;
  for (const std::int64_t run : {1, 2}) {
    const std::string path = folder.path("body-" + std::to_string(run));
    db::fleet::unpack_run(db::fleet::pack_run(store, run, folder.path(".")), path);
    back.number_next_run(206 + run);
    CHECK(back.copy_runs_from(RunStore::open_read_only(path), {1}) == std::vector<std::int64_t>{206 + run});
    models.push_back(bench::models_of_verdicts(nlohmann::json::parse(bench::facts_of(store, store.run(run)))));
  }
  CHECK(back.verdicts(208).front().model_run == 0);
  for (const std::int64_t run : {1, 2})
    bench::link_verdicts(back, 206 + run, models[static_cast<std::size_t>(run - 1)]);
  CHECK(back.verdicts(208).front().model_run == 207);
  CHECK(back.verdicts(208).front().fit == back.fits(207).at(1).fit);
  CHECK((back.check_seals(207).empty() && back.check_seals(208).empty()));
  for (const char* facts : {"3", "{}", R"({"verdicts": [{"models_of": 3}]})"})
    CHECK_THROWS_AS(bench::models_of_verdicts(nlohmann::json::parse(facts)), nlohmann::json::exception);
}
