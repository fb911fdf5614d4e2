// Models of tables of several taxels and sequences, their residuals, scores and cross-validation: all figures in sums,
// as they were when recorded.
#include <algorithm>

#include "analysis/identify/residuals.h"
#include "analysis/identify/sensor_model.h"
#include "analysis/models/elam_hysteresis.h"
#include "analysis/statistics/scoring/model_score.h"
#include "tests/analysis/compensate/recorded_streams.h"

using namespace tactbench::analysis;
using namespace recorded;

namespace {

// Inputs from 4 to 52, outputs from 0.3 V; taxel 3 does not move.
std::vector<TableSeries> table_of_four_taxels() {
  std::vector<double> x, up, down;
  for (int i = 0; i <= 8; ++i) {
    const double share = i / 8.0;
    x.push_back(4.0 + 48.0 * share);
    up.push_back(0.3 + 2.5 * share * (0.4 + 0.6 * share));
    down.push_back(0.3 + 2.5 * share * (1.6 - 0.6 * share));
  }
  const ElamHysteresis film(
      {PatternCurve(x, up, 0.3, 2.8), PatternCurve(x, down, 0.3, 2.8), {0.5, 0.6, 0.003, 0.4, 0.3}, {true}}, true);
  Numbers number(8);
  std::vector<TableSeries> all;
  for (int taxel = 0; taxel < 4; ++taxel)
    for (const char* sequence : {"loops", "steps"}) {
      TableSeries own{sequence, taxel, {}, {}};
      const auto state = film.state();
      Numbers way(sequence[0] == 'l' ? 21 : 22);
      double at = 4.0;
      for (int turn = 0; turn < 15; ++turn) {
        const double share = way();
        const double to = turn % 6 == 0   ? 52.0
                          : turn % 6 == 1 ? 4.0
                          : turn % 2 == 0 ? at + (52.0 - at) * share
                                          : at + (4.0 - at) * share;
        for (int k = turn == 0 ? 0 : 1; k <= 7; ++k) {
          const double input = at + (to - at) * k / 7.0;
          state->go(input);
          own.input.push_back(input);
          const double noise = 0.004 * (2.0 * number() - 1.0);
          own.output.push_back(taxel == 3 ? 1.0 : state->output_at(input) * (1.0 + 0.2 * taxel) + noise);
        }
        at = to;
      }
      all.push_back(std::move(own));
    }
  return all;
}

void add_errors(Summed& summed, const ErrorSum& errors) {
  summed.add(errors.sum, errors.max, static_cast<int>(errors.samples));
}

Summed figures_of(const std::string& name, const IdentifyOptions& options, const std::vector<std::string>& sequences) {
  HistoriesOptions gathered;
  gathered.fitted = sequences;
  const Histories histories = histories_of(table_of_four_taxels(), "t", gathered);
  Summed summed(100000);
  const SensorModel model = fit_models(name, histories, sequences, options, 1);
  for (const ModelTaxel& taxel : model.taxels) {
    summed.add(taxel.noise, taxel.loop_low, static_cast<int>(taxel.status));
    summed.add(taxel.fit.j, taxel.fit.mean_error, taxel.fit.samples);
    summed.add(taxel.fit.full_scale, taxel.residual_psi, static_cast<int>(taxel.fit.at_bound));
    for (const double psi : residual_by_level(taxel)) summed.add(psi, 0.0, 0);
  }
  for (const TaxelHistories& taxel : histories.taxels) summed.add(taxel.turn, taxel.noise, taxel.usable() ? 1 : 0);
  summed.add(model.validity.input->low, model.validity.input->high, static_cast<int>(histories.warnings.size()));
  const Histories all = histories_of(table_of_four_taxels(), "t", HistoriesOptions());
  for (const std::vector<std::string>& scored : {std::vector<std::string>{}, {"steps"}}) {
    const ModelScore score = score_model(model, all, scored, 1);
    for (const Score* const one : {&score.taxels})
      for (const ErrorSum* const errors : {&one->direct, &one->free_running, &one->compensated, &one->raw})
        add_errors(summed, *errors);
  }
  add_errors(summed, cross_validate(name, fit_data_of(histories.taxels[1], sequences), options, 3));
  return summed;
}

void check_figures(const std::string& name, const IdentifyOptions& options, const std::vector<Sums>& was) {
  std::string lines;
  std::size_t at = 0;
  for (const std::vector<std::string>& sequences : {std::vector<std::string>{}, {"loops"}}) {
    const Summed now = figures_of(name, options, sequences);
    check_sums(sequences.empty() ? "all" : "loops", now, std::span(was).subspan(std::min(at, was.size())), lines, 1e-5);
    ++at;
  }
  INFO("now:\n" << lines);
  CHECK(was.size() == at);
}

}  // namespace

TEST_CASE("recorded: models of a table, their residuals, scores and cross-validation are what they were") {
  check_figures("elam", {}, {{5919.7894746, 143.3118709, 378383}, {5949.7774848, 143.4803659, 355115}});
  check_figures("elam", {.exact_outer = true, .memory = true},
                {{5694.4030929, 141.2703446, 378383}, {5695.9049761, 138.9229084, 355115}});
  check_figures("poly", {.free_run = true}, {{5956.7048825, 142.9109836, 378383}, {6078.8471865, 144.0324473, 355115}});
  check_figures("mpi", {}, {{5882.8125112, 140.5654717, 378383}, {5992.4327141, 142.2803084, 355115}});
  check_figures("preisach", {.cells = 6}, {{5710.2326527, 138.0744465, 378383}, {5779.0196682, 140.3665658, 355115}});
}
