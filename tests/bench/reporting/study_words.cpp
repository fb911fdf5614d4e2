// Further runs as typed after --studies: what is taken for a run with its role, and each refusal by the letter. The
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
  return fmt::format("{} {} | {} | {} | {}", static_cast<int>(error.code()), error.id(), error.what(), error.where(),
                     error.remedy());
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
    CHECK(taken_as({"1", word}) == fmt::format("2 TB-USAGE | '{}' is no run with a role | --studies | RUN, RUN:mount, "
                                               "RUN:0, RUN:90, RUN:180 or RUN:270",
                                               word));
  }
  for (const char* word : {"7", "7:90"})
    CHECK(taken_as({"1", word, "2", word}) ==
          fmt::format("2 TB-USAGE | '{}' is named twice | --studies | each run once: one counted twice would seem to "
                      "repeat itself",
                      word));
}

TEST_CASE("studies: without models of the report's own run there is nothing to hold them against") {
  RunsOfStudies runs;
  runs.add(kLoopWords);
  runs.add(kLoopWords);
  const std::string refusal =
      "2 TB-REPORT-STUDY | studies and earlier models need models of the report's own run | run 1 | fit it first: "
      "tactbench fit 1";
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
    CHECK(
        runs.refusal({word}) ==
        fmt::format("2 TB-REPORT-STUDY | run 1 is the report's own, which the others are held against | --studies {} | "
                    "name the further runs only",
                    word));
}

TEST_CASE("studies: a run of plain loops needs a role, and one that paces has none") {
  RunsOfStudies runs;
  runs.add(kLoopWords);
  const std::int64_t plain = runs.add(kLoopWords), without = runs.add("");
  CHECK(
      runs.refusal({"2"}) ==
      "2 TB-REPORT-STUDY | run 2 holds plain loops, whose purpose is not recorded | --studies 2 | 2:mount when the "
      "sensor was mounted anew, 2:90 when it was turned in the chamber by 90 degrees counter-clockwise; a run at "
      "another temperature is known by its thermometer's readings, 2 K or more from run 1's; to see models on another "
      "run: --held-out 2");
  CHECK(plain == 2);
  CHECK_THAT(runs.refusal({std::to_string(without)}), Catch::Contains("run 3 holds plain loops"));
  const std::string steps =
      "schema = 1\nname = \"a\"\nunit = \"psi\"\nturning_points = [0, 20, 0]\nstep = 10\nrepeats = 2\n";
  for (const char* pace : {"dwell_s = [1, 4]\n", "ramp_psi_per_s = [1, 4]\n", "frames_per_level = 3\ndwell_s = 4\n"}) {
    const std::int64_t run = runs.add(steps + pace);
    INFO(pace);
    CHECK(runs.refusal({fmt::format("{}:mount", run)}) ==
          fmt::format(
              "2 TB-REPORT-STUDY | run {0} goes at several rates or holds levels, by its own recipe: it is no run "
              "of a study of mounts | --studies {0}:mount | its recipe shows its purpose: --studies {0}",
              run));
  }
  const std::int64_t one = runs.add(steps + "dwell_s = [2]\nframes_per_level = 1\n");
  CHECK_THAT(runs.refusal({std::to_string(one)}), Catch::Contains("holds plain loops"));
}
