// MODEL of the command line as a run or a fit of a store: which fit stands for a run, and what its run adds to it.
#include <catch2/catch.hpp>
#include <string>

#include "analysis/error.h"
#include "analysis/identify/dynamic/dynamic_fit.h"
#include "analysis/identify/stored/model_document.h"
#include "tests/analysis/support/straight_array.h"
#include "tests/db/store_example.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace straight_array;

namespace {

SensorModel fit_of_stored_run(std::int64_t run) {
  SensorModel fit = straight_fit();
  fit.model = kElamFit;
  fit.run = run;
  fit.source = "run " + std::to_string(run);
  fit.pressure_psi = {0.0, 60.0};
  fit.input_unit = "psi";
  fit.output_unit = "V";
  return fit;
}

std::string refused_model(const std::string& model, const db::RunStore& store, const std::string& remedy) {
  try {
    (void)load_model(model, &store);
  } catch (const AnalysisError& error) {
    CHECK(error.remedy() == remedy);
    return error.id() + " " + error.what();
  }
  return {};
}

}  // namespace

TEST_CASE("MODEL as a run of the store: its standing fit, with the run's sequences, scans and content") {
  const tests::TemporaryFolder folder;
  db::RunStore store = db::RunStore::open(folder.path("s.db"));
  const std::int64_t run = tests::store_example(store);
  CHECK_FALSE(standing_fit(store, run));
  CHECK(refused_model("1", store, "make one: tactbench fit 1") == "TB-ANALYSIS-NO-FIT run 1 has no stored fit");
  CHECK_THROWS_WITH(load_fit(store, run), "run 1 has no stored fit");
  CHECK(store_fit(store, fit_of_stored_run(run), "9.9", tests::kUtc, "commit abc") == 1);
  const SensorModel first = load_model("1", &store);
  CHECK((first.run == 1 && first.fit == 1 && first.program_version == "9.9" && first.scans == 2));
  CHECK(first.sequences == std::vector<std::string>{"up", "down"});
  CHECK(first.content_sha256 == store.run(run).content_sha256);
  CHECK(first.content_sha256.size() == 64);
  CHECK(load_model("1:1", &store).sequences == first.sequences);
  // What the document says of its sequences stays.
  SensorModel part = fit_of_stored_run(run);
  part.all_sequences = false;
  part.sequences = {"down"};
  part.scans = 7;
  part.content_sha256 = "abc";
  CHECK(store_fit(store, part, "9.9", tests::kUtc, "") == 2);
  const SensorModel second = load_model("1:2", &store);
  CHECK((second.fit == 2 && second.run == 1 && second.scans == 7 && second.content_sha256 == "abc"));
  CHECK(second.sequences == std::vector<std::string>{"down"});
  CHECK_FALSE(second.all_sequences);
  CHECK(load_model("1", &store).fit == 1);  // a part does not stand for the run
  const std::string remedy = "tactbench runs show RUN lists its fits";
  CHECK(refused_model("1:x", store, remedy) == "TB-MODEL-OPEN run 1 has no fit \"x\"");
  CHECK(refused_model("1:", store, remedy) == "TB-MODEL-OPEN run 1 has no fit \"\"");
  CHECK(refused_model("2:1", store, remedy) == "TB-MODEL-OPEN run 2 has no fit \"1\"");
  CHECK(refused_model("1:2x", store, remedy) == "TB-MODEL-OPEN run 1 has no fit \"2x\"");
  CHECK_THROWS_AS(load_model("1:3", &store), db::StoreError);
}

TEST_CASE("the fit that stands for a run: the later one of elam and dynamic, else the last of any") {
  const tests::TemporaryFolder folder;
  db::RunStore store = db::RunStore::open(folder.path("s.db"));
  const std::int64_t run = tests::store_example(store);
  const auto stands = [&] {
    const auto record = standing_fit(store, run);
    return record ? record->fit : 0;
  };
  const auto add = [&](const std::string& model) {
    db::FitRecord record;
    record.run = run;
    record.model = model;
    record.options_json = record.summary_json = record.patterns_json = "{}";
    record.program_version = "9.9";
    record.created_utc = tests::kUtc;
    return store.add_fit(record, {});
  };
  CHECK(add("gpi") == 1);
  CHECK(stands() == 1);
  CHECK(add("mpi") == 2);
  CHECK(stands() == 2);
  CHECK(add(kDynamicModel) == 3);
  CHECK(stands() == 3);
  CHECK(add("gpi") == 4);
  CHECK(stands() == 3);
  CHECK(add(kElamFit) == 5);
  CHECK(stands() == 5);
  CHECK(add(kDynamicModel) == 6);
  CHECK(stands() == 6);
}

TEST_CASE(
    "a fit that a store holds as a document: made of its run, refused with the store's path where it is damaged") {
  const tests::TemporaryFolder folder;
  db::RunStore store = db::RunStore::open(folder.path("s.db"));
  const std::int64_t run = tests::store_example(store);
  db::FitRecord record;
  record.run = run;
  record.model = "gpi";
  record.options_json = record.summary_json = record.patterns_json = "{}";
  record.program_version = "9.9";
  record.created_utc = tests::kUtc;
  store.add_fit(record, {});
  try {
    (void)load_fit(store, run);
    FAIL_CHECK("read");
  } catch (const AnalysisError& error) {
    CHECK(error.id() == "TB-MODEL-STORED");
    CHECK(error.remedy() == "fit the run again: tactbench fit 1; tactbench db check lists what else is damaged");
    CHECK_THAT(error.what(), Catch::StartsWith("fit 1 of " + folder.path("s.db") + " is no model: "));
  }
  // Of a whole run's ELAM rows are looked for.
  record.model = kElamFit;
  store.add_fit(record, {});
  CHECK_THROWS_WITH(load_fit(store, run), Catch::StartsWith("the stored fit of run 1 cannot be read: "));
}
