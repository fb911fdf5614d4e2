// Models of a taxel compared, in the report: errors, panels along the sequence, parameters, by hand.
#include <catch2/catch.hpp>
#include <string>

#include "analysis/report/sections/sections.h"
#include "tests/analysis/report/sections/printed.h"

using namespace tactbench;
using namespace tactbench::analysis;
using namespace tactbench::analysis::printed;

namespace {

ComparedModel compared_by_hand(const char* name, double error) {
  ComparedModel model;
  model.model = name;
  model.model_v = {0.1, 1.2, 2.0};
  model.j_v2 = 0.12344;
  model.mean_error_v = error;
  model.max_error_v = 0.23444;
  model.mean_running_v = 0.34444;
  model.max_running_v = 0.45444;
  model.operations_per_sample = 9;
  return model;
}

// The mean taxel and one other along one sequence.
ReportInput compared() {
  ReportInput input;
  input.unit = PressureUnit::kPsi;
  ComparedTaxel mean{{kMeanTaxel, "mean taxel"}, 2.5, {}};
  mean.sequences = {{"up", {0.0, 30.0, 60.0}, {0.0, 1.0, 2.5}, {}}};
  for (const char* name : {"gpi", "mpi", "poly", "elam"})
    mean.sequences[0].models.push_back(compared_by_hand(name, 0.05124));
  mean.sequences[0].models[1].model_v = {0.0, 1.1, 2.4};
  ComparedTaxel other = mean;
  other.taxel = {7, "worst taxel"};
  input.more.models.taxels = {mean, other};
  return input;
}

}  // namespace

TEST_CASE("models compared by hand: errors as shares of 2.5 V, the least error marked, sizes") {
  ReportInput input = compared();
  std::vector<ComparedModel>& models = input.more.models.taxels[0].sequences[0].models;
  models[2].mean_error_v = 0.04124;
  models[0].parameters = {{"a0", 2.0, "y", 0.0, 9.0}, {"a2", 1.0, "1", -9.0, 9.0, true}, {"b", 3.0, "1", 0.0, 9.0}};
  const std::string page = models_section(input).value;
  const std::string head = page.substr(0, page.find("<h3>The worst taxel</h3>"));
  const auto errors = [](const char* title, const char* mean, const char* share) {
    return std::string("<tr><th scope=\"row\">up</th><td>") + title + "</td>" +
           numbers({"0.1234", mean, share, "0.2344", "9.38", "13.78", "18.18"}) + "</tr>";
  };
  check_once(head, errors("GPI", "0.0512", "2.05"));
  check_once(head, errors("MPI", "0.0512", "2.05"));
  check_once(head, errors("POLY (least mean error)", "0.0412", "1.65"));
  check_once(head, errors("ELAM", "0.0512", "2.05"));
  // Of models alike the first is the best.
  CHECK(count(page.substr(head.size()), "GPI (least mean error)") == 1);
  CHECK(count(page.substr(head.size()), "(least mean error)") == 1);
  check_once(page, "<th scope=\"row\">GPI</th>" + numbers({"2", "9"}) +
                       "<td>exponentials of the envelopes; 5 play operators</td></tr>");
  check_once(page, "<th scope=\"row\">MPI</th>" + numbers({"0", "9"}) + "<td>11 play operators</td></tr>");
  check_once(page, "<th scope=\"row\">POLY</th>" + numbers({"0", "9"}) + "<td>the ends of the external loop</td></tr>");
  check_once(page, "<th scope=\"row\">ELAM</th>" + numbers({"0", "9"}) + "<td>two pattern curves");
  CHECK(count(page, "FS is 2.500 V") == 2);
  check_once(page, "ELAM has parameters of this sequence, as the others have.");
  input.more.models.taxels.clear();
  check_once(models_section(input).value, "<p>not available</p>");
}

TEST_CASE("models compared by hand: panels of the mean taxel in pairs, residuals of all step by step of another") {
  ReportInput input = compared();
  std::string page = models_section(input).value;
  const std::vector<double> x = {0.0, 30.0, 60.0};
  const auto of = [](double model, double measured) { return 1000.0 * (model - measured); };
  const std::vector<double> most = {of(0.1, 0.0), of(1.2, 1.0), of(2.0, 2.5)},
                            mpi = {of(0.0, 0.0), of(1.1, 1.0), of(2.4, 2.5)};
  check_along(page, {.title = "Output measured and by the model against pressure: MPI, mean taxel, sequence up",
                     .x_label = "gauge pressure",
                     .y_label = "output in V",
                     .series = {{"measured", x, {0.0, 1.0, 2.5}, 0}, {"MPI", x, {0.0, 1.1, 2.4}, 1}},
                     .width = 335,
                     .height = 225});
  check_along(page, {.title = "Lack of fit, model minus measured: MPI, mean taxel, sequence up",
                     .x_label = "gauge pressure",
                     .y_label = "residual in mV",
                     .series = {{"model minus measured", x, mpi, 2, true}},
                     .width = 335,
                     .height = 140});
  LineChart steps{.title = "Residuals of the four models, model minus measured, step by step: worst taxel, sequence up",
                  .x_label = "step",
                  .y_label = "residual in mV",
                  .series = {{"GPI", {0.0, 1.0, 2.0}, most, 1},
                             {"MPI", {0.0, 1.0, 2.0}, mpi, 2},
                             {"POLY", {0.0, 1.0, 2.0}, most, 3},
                             {"ELAM", {0.0, 1.0, 2.0}, most, 0}},
                  .width = 335,
                  .height = 340};
  check_once(page, line_chart(steps).value);
  CHECK(count(page, ": mean error 2.05 % FS, maximum 9.38 % FS.</figcaption>") == 5);
  CHECK(count(page, "<div class=\"keep\">") == 3);  // two pairs of the mean taxel, one of the other
  CHECK(count(page, "<h4>Sequence up</h4>") == 2);
  check_none(page, "<tr><td></td>");  // no model has a parameter
  // A model that failed has its style, and no line; of three models the last stands alone.
  ComparedSequence& other = input.more.models.taxels[1].sequences[0];
  other.models[1] = {};
  other.models[1].model = "mpi";
  other.models[1].failed = "no play";
  steps.series.erase(steps.series.begin() + 1);
  input.more.models.taxels[0].sequences[0].models.erase(input.more.models.taxels[0].sequences[0].models.begin());
  page = models_section(input).value;
  check_once(page, line_chart(steps).value);
  CHECK(count(page, "<div class=\"keep\">") == 3);
  check_once(page, "<td>MPI</td><td colspan=\"7\">not available: no play</td>");
}

TEST_CASE("models compared by hand: parameters with four decimals, small ones with a power of ten, marks at bounds") {
  ReportInput input = compared();
  input.more.models.taxels.resize(1);
  std::vector<ComparedModel>& models = input.more.models.taxels[0].sequences[0].models;
  models[0].parameters = {{"a", 0.0009994, "y", -9.0, 9.0}, {"b", -0.00012344, "1", -9.0, 9.0}};
  models[1].parameters = {{"c", 0.001, "y", -9.0, 9.0}};
  models[2].parameters = {{"d", 0.0, "y", -9.0, 9.0}, {"e", 9.0, "1", -9.0, 9.0}, {"f", 12.34567, "1", 0.0, 99.0}};
  models[3].parameters = {{"g", -0.5, "y", -9.0, 9.0}};
  const std::string page = models_section(input).value;
  check_once(page,
             "<tr><td>a</td><td class=\"n\">9.994e-04</td><td>c</td><td class=\"n\">0.0010</td><td>d</td><td "
             "class=\"n\">0.0000</td><td>g</td><td class=\"n\">−0.5000</td></tr>");
  check_once(page,
             "<tr><td>b</td><td class=\"n\">−1.234e-04</td><td></td><td></td><td>e (bound)</td><td "
             "class=\"n\">9.0000</td><td></td><td></td></tr>");
  check_once(page,
             "<tr><td></td><td></td><td></td><td></td><td>f</td><td class=\"n\">12.3457</td><td></td><td></td></tr>");
}
