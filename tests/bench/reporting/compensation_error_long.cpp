// What docs/compensation-error.md says of the dynamic compensator, on a sensor of each specimen that nothing was chosen
// on.
#include <catch2/catch.hpp>
#include <map>

#include "tests/benchmarks/study/compensation_error.h"
#include "tests/support/process.h"

using namespace tactbench::tests;

TEST_CASE(
    "the dynamic compensator errs less than ELAM's stream, and twice the uncertainty of each holds most samples") {
  const TemporaryFolder folder;
  std::map<std::string, double> figures;
  for (const tactbench::bench::Figure& figure : tactbench::bench::benchmark_compensation_error(
           {tactbench::bench::SpecimenKind::kPaper, tactbench::bench::SpecimenKind::kHarsh}, {71, 72, 73},
           folder.path()))
    figures[figure.name.substr(figure.name.find('_') + 1)] = figure.value;

  const auto hold = [&](const std::string& condition, double share_of_elam) {
    const double error = figures.at(condition), elam = figures.at(condition + "_elam_stream");
    const double within = figures.at(condition + "_within_2_u");
    INFO(condition << ": " << error << " psi, ELAM's stream " << elam << " psi, within 2 u " << within << " %");
    CHECK(error < share_of_elam * elam);
    CHECK(within > 90.0);
    CHECK(within < 98.5);
    const double of_elam = figures.at(condition + "_elam_stream_within_2_u");
    const double of_one_run = figures.at(condition + "_one_run_within_2_u");
    INFO("ELAM's stream " << of_elam << " %, the dynamic model of one run " << of_one_run << " %, which errs by "
                          << figures.at(condition + "_one_run") << " psi");
    // On the harsh specimen a fast run's creep is not in the fitted data.
    const bool harsh = condition.starts_with("harsh"), fast = condition.ends_with("0.2_s");
    CHECK(of_elam > (harsh ? (fast ? 50.0 : 80.0) : 90.0));
    CHECK(of_elam < 99.7);
    CHECK(of_one_run > (harsh && fast ? 70.0 : 85.0));
    CHECK(figures.at(condition + "_one_run") < (harsh ? 0.8 : 0.95) * elam);
  };
  for (const char* const condition : {"random_1", "random_2", "dwell_0.2_s", "dwell_10_s"}) hold(condition, 0.35);
  for (const char* const condition : {"remounted", "remounted_random"}) hold(condition, 0.75);
  for (const char* const condition : {"harsh_random_1", "harsh_random_2", "harsh_dwell_0.2_s"}) hold(condition, 0.3);
  for (const char* const condition : {"harsh_dwell_10_s", "harsh_remounted", "harsh_remounted_random"})
    hold(condition, 0.7);
}
