// Further runs as typed after --studies: what is taken for a run with its role, and each refusal. The
// runs are stored by hand, without frames.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "analysis/report/runs.h"
#include "bench/common/error.h"
#include "bench/reporting/report_results.h"
#include "db/run_store.h"
#include "tests/support/process.h"

using namespace tactbench;

namespace {

using StudyWords = std::vector<std::string>;

std::string error_in_words(const bench::Error& error) {
  return fmt::format("{} {} at {}", static_cast<int>(error.code()), error.id(), error.where());
}

std::string taken_as(const StudyWords& words) {
  try {
    std::string text;
    for (const bench::StudyRun& study : bench::study_runs_of(words))
      text += fmt::format("{}({}) ", study.run, study.role);
    return text;
  } catch (const bench::Error& error) {
    return error_in_words(error);
  }
}

constexpr const char* kLoopWords =
    "schema = 1\nname = \"a\"\nunit = \"psi\"\nturning_points = [0, 20, 0]\nstep = 10\ndwell_s = 2\n";

class RunsOfStudies {
 public:
  RunsOfStudies() { store_.add_sensor({"S-1", "synthetic", "", db::sha256_hex(""), "SC-1", "", ""}); }
  std::int64_t add(const std::string& recipe) {
    db::RunRecord run;
    run.uuid = db::new_uuid();
    run.origin = "hardware";
    run.state = "prepared";
    run.sensor_serial = "S-1";
    run.sequences = {{0, "a", recipe, "", 1, 5}};
    return store_.begin_run(run);
  }
  // "" where nothing is refused.
  [[nodiscard]] std::string refusal(const StudyWords& studies, bool models = true,
                                    const std::string& previous = "") const {
    analysis::Runs runs(store_);
    analysis::ReportInput input;
    input.run = store_.run(1);
    input.fit.run = 1;
    if (models) input.fit.taxels.resize(1);
    bench::ReportExtras extras;
    extras.studies = studies;
    extras.previous = previous;
    try {
      bench::add_results(input, runs, extras);
    } catch (const bench::Error& error) {
      return error_in_words(error);
    }
    CHECK(input.more.contacts.empty());
    return {};
  }

 private:
  tests::TemporaryFolder folder_;
  db::RunStore store_ = db::RunStore::open(folder_.path("studies.db"), db::Durability::kNormal);
};

}  // namespace

TEST_CASE("studies as typed: runs, and the five roles") {
  CHECK(taken_as({}).empty());
  CHECK(taken_as({"7", "8:mount", "9:0", "10:90", "11:180", "12:270"}) == "7() 8(mount) 9(0) 10(90) 11(180) 12(270) ");
  CHECK(taken_as({"7", "7:mount", "7:0"}) == "7() 7(mount) 7(0) ");  // one run in several roles
  for (const char* word :
       {"", "x", ":mount", "7x", "7 ", " 7", "7:", "7:45", "7:mounted", "7:mount:", "7.0:90", "99999999999999999999"}) {
    INFO(word);
    CHECK(taken_as({"1", word}) == "2 TB-USAGE at --studies");
  }
  for (const char* word : {"7", "7:90"}) CHECK(taken_as({"1", word, "2", word}) == "2 TB-USAGE at --studies");
}

TEST_CASE("studies: without models of the report's own run there is nothing to hold them against") {
  RunsOfStudies runs;
  runs.add(kLoopWords);
  runs.add(kLoopWords);
  const std::string refusal = "2 TB-REPORT-STUDY at run 1";
  CHECK(runs.refusal({}, false).empty());
  CHECK(runs.refusal({"2"}, false) == refusal);
  CHECK(runs.refusal({}, false, "2:1") == refusal);
  CHECK(runs.refusal({}, true, "2:1") == refusal);  // models, and no full loop that they were evaluated on
  CHECK(runs.refusal({}).empty());
}

TEST_CASE("studies: the report's own run is counted in any case, and is no study") {
  RunsOfStudies runs;
  runs.add(kLoopWords);
  CHECK(runs.refusal({"1:0"}).empty());
  for (const char* word : {"1", "1:90", "1:mount"})
    CHECK(runs.refusal({word}) == fmt::format("2 TB-REPORT-STUDY at --studies {}", word));
}

TEST_CASE("studies: a run of plain loops needs a role, and one that paces has none") {
  RunsOfStudies runs;
  runs.add(kLoopWords);
  const std::int64_t plain = runs.add(kLoopWords), without = runs.add("");
  CHECK(runs.refusal({"2"}) == "2 TB-REPORT-STUDY at --studies 2");
  CHECK(plain == 2);
  CHECK_FALSE(runs.refusal({std::to_string(without)}).empty());
  const std::string steps =
      "schema = 1\nname = \"a\"\nunit = \"psi\"\nturning_points = [0, 20, 0]\nstep = 10\nrepeats = 2\n";
  for (const char* pace : {"dwell_s = [1, 4]\n", "ramp_psi_per_s = [1, 4]\n", "frames_per_level = 3\ndwell_s = 4\n"}) {
    const std::int64_t run = runs.add(steps + pace);
    INFO(pace);
    CHECK(runs.refusal({fmt::format("{}:mount", run)}) == fmt::format("2 TB-REPORT-STUDY at --studies {}:mount", run));
  }
  const std::int64_t one = runs.add(steps + "dwell_s = [2]\nframes_per_level = 1\n");
  CHECK_FALSE(runs.refusal({std::to_string(one)}).empty());
}
