// Every number that the sections of a report print and draw, and that stand in its data, in sums as they were when
// recorded; with them how many there are, how many tags, and how many marks. Words may change.
#include <catch2/catch.hpp>
#include <memory>
#include <string>
#include <vector>

#include "analysis/models/linearised.h"
#include "analysis/models/preisach.h"
#include "analysis/report/data/section_data.h"
#include "analysis/report/sections/sections.h"
#include "tests/analysis/report/numbers_on_pages.h"
#include "tests/analysis/report/whole_report.h"

using namespace tactbench;
using namespace tactbench::analysis;
using namespace tactbench::analysis::pages_in_numbers;

namespace {

struct ReportSection {
  const char* name;
  html::Markup (*write)(const ReportInput&);
};
const std::vector<ReportSection> kSectionsOfReport{
    {"verdicts", verdict_section},  {"identification", identification_section},
    {"health", health_section},     {"raw", raw_section},
    {"loops", loops_section},       {"frames", frames_section},
    {"levels", levels_section},     {"model", model_section},
    {"held-out", held_out_section}, {"uncertainty", uncertainty_section},
    {"meaning", meaning_section},   {"models", models_section},
    {"as-found", as_found_section}, {"compensation", compensation_section},
    {"studies", studies_section},   {"objects", objects_section}};
struct SectionData {
  const char* name;
  std::string (*write)(const ReportInput&);
};
const std::vector<SectionData> kDataOfSections{{"identification data", identification_json},
                                               {"results data", results_json},
                                               {"uncertainty data", uncertainty_json},
                                               {"health data", health_json},
                                               {"behaviour data", behaviour_json},
                                               {"models data", models_json},
                                               {"compensation data", compensation_json},
                                               {"studies data", studies_json},
                                               {"objects data", objects_json}};

// Sections that need an evaluation are left out of a report without one.
std::vector<PrintedNumbers> printed_by(const ReportInput& input) {
  std::vector<PrintedNumbers> parts;
  const bool evaluated = !input.evaluation.levels.empty();
  for (const ReportSection& section : kSectionsOfReport) {
    const std::string name = section.name;
    const bool needs = name == "model" || name == "models" || name == "as-found" || name == "compensation" ||
                       name == "held-out" || name == "uncertainty";
    if (evaluated || !needs) parts.push_back(numbers_on(name, section.write(input).value));
  }
  for (const SectionData& data : kDataOfSections) parts.push_back(numbers_on(data.name, data.write(input)));
  return parts;
}
void check_printed(const ReportInput& input, const std::vector<PrintedNumbers>& was) {
  check_parts(printed_by(input), was);
}
// Models of another kind, in time; taxels of every state; no further runs.
ReportInput dynamic_report() {
  ReportInput input = example::example_input();
  input.unit = PressureUnit::kBar;
  input.held_out.clear();
  input.fit.model = "dynamic";
  SensorDynamics dynamics;
  dynamics.shared.creep_share = {0.0125, 0.0225, 0.0325};
  dynamics.shared.creep_s = {3.0, 54.8, 1000.0};
  dynamics.shared.creep_half = 7.25;
  dynamics.shared.lag_s = 1.75;
  dynamics.shared.lag_share = 0.125;
  dynamics.rate = {21, std::string(64, '4')};
  dynamics.creep = {22, std::string(64, '5')};
  dynamics.residual_shape = std::vector<double>(8, 1.125);
  input.fit.dynamics = dynamics;
  for (ModelTaxel& taxel : input.fit.taxels) {
    if (!taxel.fitted()) continue;
    const auto film = std::make_shared<PreisachModel>(0.0, 60.0, 0.0, std::vector<double>{1.5, 0.5, 1.0});
    taxel.fit.model = std::make_shared<LinearisedModel>(Divider{0.0, 0.125}, film);
    taxel.fit.at_bound = 0;
    taxel.creep_scale = 1.25;
    taxel.lag_share = 0.1;
    taxel.residual_psi = 0.375;
  }
  input.fit.taxels[3].status = TaxelStatus::kUnfit;
  input.fit.taxels[3].reason = "its outputs fall";
  input.fit.taxels[4].status = TaxelStatus::kStuck;
  input.fit.taxels[5].status = TaxelStatus::kConstant;
  input.fit.taxels[6].status = TaxelStatus::kUnfit;
  for (db::VerdictRecord& verdict : input.verdicts) verdict.verdict = "inconclusive";
  input.judgement.not_judged = "two runs are void";
  input.judgement.remarks = {"run 14 was left out", "run 15 is void"};
  return input;
}

}  // namespace

TEST_CASE("recorded: numbers of a whole report in kPa are those that were printed when recorded") {
  check_printed(whole_report(PressureUnit::kKilopascal), {{"verdicts", 14561.5400099, 152, 366, 20},
                                                          {"identification", 10248647.8570842, 156, 578, 3},
                                                          {"health", 126989.5794248, 1654, 256, 1},
                                                          {"raw", 628502.8956109, 3648, 1025, 5},
                                                          {"loops", 178836.8595287, 5036, 513, 2},
                                                          {"frames", 839262.9468673, 27941, 1116, 0},
                                                          {"levels", 99600.1641515, 1204, 1173, 7},
                                                          {"model", 974314.8801653, 10224, 1628, 24},
                                                          {"held-out", 21948.1685743, 99, 206, 0},
                                                          {"uncertainty", 340187.2849264, 3314, 2583, 31},
                                                          {"meaning", 1053.8930693, 5, 126, 1},
                                                          {"models", 589572.5893347, 28702, 2496, 28},
                                                          {"as-found", 78105.0342069, 1179, 1145, 6},
                                                          {"compensation", 434003.1443950, 21616, 1485, 0},
                                                          {"studies", 317618.1987228, 1374, 675, 4},
                                                          {"objects", 237472.2034010, 1162, 685, 36},
                                                          {"identification data", 41879177.2557377, 523, 609, 20},
                                                          {"results data", 923060.8432111, 54738, 5382, 146},
                                                          {"uncertainty data", 45942.0525751, 21720, 1901, 299},
                                                          {"health data", 1732.4895336, 778, 26, 3},
                                                          {"behaviour data", 54220.6875478, 1487, 218, 6},
                                                          {"models data", 97480.6745021, 8742, 584, 24},
                                                          {"compensation data", 175103.3250599, 7532, 681, 5},
                                                          {"studies data", 1526.9471089, 1095, 70, 0},
                                                          {"objects data", 5506.2276436, 1631, 122, 13}});
}

TEST_CASE("recorded: numbers of a whole report in psi are those that were printed when recorded") {
  check_printed(whole_report(PressureUnit::kPsi), {{"verdicts", 14317.4994356, 152, 366, 20},
                                                   {"identification", 10248183.4736188, 156, 578, 3},
                                                   {"health", 126989.5794248, 1654, 256, 1},
                                                   {"raw", 626767.8985812, 3648, 1025, 5},
                                                   {"loops", 179290.7513743, 5054, 522, 2},
                                                   {"frames", 827776.2924119, 27941, 1116, 0},
                                                   {"levels", 85413.6189040, 1204, 1173, 7},
                                                   {"model", 973219.9972545, 10224, 1628, 24},
                                                   {"held-out", 22080.5887921, 99, 206, 0},
                                                   {"uncertainty", 336349.0915639, 3314, 2583, 33},
                                                   {"meaning", 1053.8930693, 5, 126, 1},
                                                   {"models", 598491.8353743, 28774, 2532, 28},
                                                   {"as-found", 79387.7604941, 1179, 1145, 6},
                                                   {"compensation", 401714.8639594, 21616, 1485, 0},
                                                   {"studies", 318716.1489208, 1374, 675, 4},
                                                   {"objects", 237612.7608267, 1162, 685, 36},
                                                   {"identification data", 41879177.2557377, 523, 609, 20},
                                                   {"results data", 923060.8432111, 54738, 5382, 146},
                                                   {"uncertainty data", 45942.0525751, 21720, 1901, 299},
                                                   {"health data", 1732.4895336, 778, 26, 3},
                                                   {"behaviour data", 54220.6875478, 1487, 218, 6},
                                                   {"models data", 97480.6745021, 8742, 584, 24},
                                                   {"compensation data", 175103.3250599, 7532, 681, 5},
                                                   {"studies data", 1526.9471089, 1095, 70, 0},
                                                   {"objects data", 5506.2276436, 1631, 122, 13}});
}

TEST_CASE("recorded: numbers of a report on dynamic models in bar are those that were printed when recorded") {
  check_printed(dynamic_report(), {{"verdicts", 448.2544673, 50, 164, 12},
                                   {"identification", 9540018.3365644, 135, 571, 3},
                                   {"health", 126989.5794248, 1654, 256, 1},
                                   {"raw", 621618.7851158, 3648, 1025, 5},
                                   {"loops", 163226.4401030, 5036, 513, 2},
                                   {"frames", 820418.0989465, 27941, 1116, 0},
                                   {"levels", 67119.3892406, 1204, 1173, 7},
                                   {"model", 3421586.2738851, 2460, 936, 10},
                                   {"held-out", 8689.0989446, 29, 112, 1},
                                   {"uncertainty", 4.7326733, 2, 4, 0},
                                   {"meaning", 169.3366337, 3, 128, 3},
                                   {"models", 4.7326733, 2, 4, 1},
                                   {"as-found", 48856.5749099, 743, 1122, 113},
                                   {"compensation", 4.7326733, 2, 4, 1},
                                   {"studies", 41.0891089, 10, 18, 4},
                                   {"objects", 4.7326733, 2, 4, 1},
                                   {"identification data", 8584798.4036535, 142, 166, 5},
                                   {"results data", 3887687.8628224, 53495, 4361, 131},
                                   {"uncertainty data", 0.0000000, 0, 2, 1},
                                   {"health data", 1732.4895336, 778, 26, 3},
                                   {"behaviour data", 54220.6875478, 1487, 218, 6},
                                   {"models data", 0.0000000, 0, 0, 0},
                                   {"compensation data", 9.0668317, 14, 29, 1},
                                   {"studies data", 0.0000000, 0, 8, 0},
                                   {"objects data", 0.0000000, 0, 0, 0}});
}

TEST_CASE("recorded: numbers of a report on a run without models are those that were printed when recorded") {
  ReportInput input = example::example_input();
  input.fit = {};
  input.evaluation = {};
  input.held_out.clear();
  input.verdicts.clear();
  check_printed(input, {{"verdicts", -2697.3267327, 19, 24, 3},
                        {"identification", 7941354.1878416, 120, 567, 5},
                        {"health", 126989.5794248, 1654, 256, 1},
                        {"raw", 619073.2632396, 3645, 1015, 5},
                        {"loops", 4.7326733, 2, 4, 1},
                        {"frames", 4.7326733, 2, 4, 1},
                        {"levels", 4.7326733, 2, 4, 1},
                        {"meaning", 169.3366337, 3, 128, 3},
                        {"studies", 41.0891089, 10, 18, 4},
                        {"objects", 4.7326733, 2, 4, 1},
                        {"identification data", 6693165.2848416, 127, 166, 5},
                        {"results data", -1.7623762, 25, 48, 0},
                        {"uncertainty data", 0.0000000, 0, 2, 1},
                        {"health data", 1732.4895336, 778, 26, 3},
                        {"behaviour data", 54220.6875478, 1487, 218, 6},
                        {"models data", 0.0000000, 0, 0, 0},
                        {"compensation data", 9.0668317, 14, 29, 1},
                        {"studies data", 0.0000000, 0, 8, 0},
                        {"objects data", 0.0000000, 0, 0, 0}});
  check_printed(ReportInput(), {{"verdicts", 4.7326733, 2, 4, 0},
                                {"identification", -2680.1188119, 20, 366, 8},
                                {"health", 4.7326733, 2, 4, 1},
                                {"raw", 4.7326733, 2, 4, 1},
                                {"loops", 4.7326733, 2, 4, 1},
                                {"frames", 4.7326733, 2, 4, 1},
                                {"levels", 4.7326733, 2, 4, 1},
                                {"meaning", 212.1980198, 4, 128, 3},
                                {"studies", 41.0891089, 10, 18, 4},
                                {"objects", 4.7326733, 2, 4, 1},
                                {"identification data", 1721.0297030, 12, 76, 3},
                                {"results data", -1.7623762, 25, 48, 0},
                                {"uncertainty data", 0.0000000, 0, 2, 1},
                                {"health data", 5.5153465, 3, 9, 0},
                                {"behaviour data", 0.0000000, 3, 13, 0},
                                {"models data", 0.0000000, 0, 0, 0},
                                {"compensation data", 9.0668317, 14, 29, 1},
                                {"studies data", 0.0000000, 0, 8, 0},
                                {"objects data", 0.0000000, 0, 0, 0}});
}
