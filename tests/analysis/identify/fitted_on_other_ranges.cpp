// Fits of each model and mode to data whose inputs begin at 5 and whose outputs begin at 0.7, on grids that are not
// even: what they came to when these were recorded, in sums. (fit_as_recorded.cpp has the paper's ranges, from 0 on.)
#include <algorithm>
#include <memory>
#include <utility>

#include "analysis/identify/identifier.h"
#include "analysis/models/elam_hysteresis.h"
#include "analysis/models/linearised.h"
#include "analysis/models/preisach.h"
#include "tests/analysis/compensate/recorded_streams.h"

using namespace tactbench::analysis;
using namespace recorded;

namespace {

const std::vector<double> kOtherGrid{5.0, 9.0, 17.0, 25.0, 36.0, 45.0, 55.0};

// On an uneven grid an ELAM with memory; on an even one a Preisach film behind a divider, whose inner loops are alike.
std::shared_ptr<const HysteresisModel> film_of_other_range(bool even) {
  if (even)
    return std::make_shared<LinearisedModel>(
        Divider{0.7, 0.1}, std::make_shared<PreisachModel>(
                               5.0, 55.0, 0.0, std::vector<double>{0.3, 0.5, 0.4, 0.2, 0.6, 0.5, 0.1, 0.9, 0.3, 0.8}));
  std::vector<double> up, down;
  for (const double at : kOtherGrid) {
    const double share = (at - 5.0) / 50.0;
    up.push_back(0.7 + 3.0 * share * (0.35 + 0.65 * share));
    down.push_back(0.7 + 3.0 * share * (1.7 - 0.7 * share));
  }
  const ElamModel elam{PatternCurve(kOtherGrid, up, 0.7, 3.7),
                       PatternCurve(kOtherGrid, down, 0.7, 3.7),
                       {0.6, 0.7, 0.004, 0.3, 0.4},
                       {true}};
  return std::make_shared<ElamHysteresis>(elam, true);
}

// Its outputs along a full sweep up and one down.
std::pair<PatternCurve, PatternCurve> patterns_of(const HysteresisModel& film, bool even) {
  std::vector<double> x = kOtherGrid, way, up, down;
  if (even)
    for (std::size_t i = 0; i < x.size(); ++i) x[i] = 5.0 + 50.0 * static_cast<double>(i) / 6.0;
  way = x;
  way.insert(way.end(), x.rbegin(), x.rend());
  const std::vector<double> y = predict(film, way);
  const auto half = static_cast<std::ptrdiff_t>(x.size());
  up.assign(y.begin(), y.begin() + half);
  down.assign(y.rbegin(), y.rbegin() + half);
  return {PatternCurve(x, up, 0.7, up.back()), PatternCurve(x, down, 0.7, up.back())};
}

// Between turns at the ends and inside, with some noise. `inside`: it begins at 20.
History other_way(Numbers& number, const HysteresisModel& film, const std::string& name, int turns, double noise,
                  bool inside = false) {
  const auto state = film.state();
  History history{name, {}, {}, {}, {}, {}};
  double at = inside ? 20.0 : 5.0;
  const auto add = [&](double x) {
    state->go(x);
    history.x.push_back(x);
    history.y.push_back(state->output_at(x) + noise * (2.0 * number() - 1.0));
  };
  add(at);
  bool up = true;
  for (int t = 0; t < turns; ++t, up = !up) {
    const double share = number();
    const double to = t % 8 == 2 ? 55.0 : t % 8 == 3 ? 5.0 : up ? at + (55.0 - at) * share : 5.0 + (at - 5.0) * share;
    const int steps = 3 + static_cast<int>(5.0 * number());
    for (int k = 1; k <= steps; ++k) add(k == steps ? to : at + (to - at) * k / steps);
    at = to;
  }
  history.branches = branches_along(history.x);
  return history;
}

FitData other_data(bool even, double noise) {
  Numbers number(even ? 3 : 4);
  const auto film = film_of_other_range(even);
  const auto [up, down] = patterns_of(*film, even);
  FitData data{{}, up, down, {}};
  for (const char* name : {"one", "two"})
    data.histories.push_back(other_way(number, *film, name, even ? 40 : 14, noise));
  data.histories.push_back(other_way(number, *film, "inside", 8, noise, true));
  return data;
}

void add_fit(Summed& summed, const std::string& name, const FitData& data, const IdentifyOptions& options) {
  const ModelFit fit = identify(name, data, options);
  summed.add(fit.j, fit.mean_error, fit.samples);
  summed.add(fit.max_error, fit.full_scale, static_cast<int>(fit.at_bound + 32 * fit.undetermined.size()));
  // What it says along the data, which parameters of any size come to.
  for (const History& history : data.histories)
    for (const bool free_run : {false, true})
      for (const double y : predict_history(*fit.model, history, free_run)) summed.add(y, 0.0, 0);
  const auto state = fit.model->state();
  for (const double x : {12.0, 33.0, 21.0, 48.0}) {
    summed.add(state->output_at(x), state->input_at(0.7 + 0.05 * x), 0);
    state->go(x);
  }
}

void check_fits(const std::string& name, const std::vector<IdentifyOptions>& modes, const std::vector<Sums>& was) {
  std::string lines;
  std::vector<Sums> now;
  for (const bool even : {false, true})
    for (const IdentifyOptions& options : modes) {
      Summed own(100000);
      add_fit(own, name, other_data(even, even ? 0.005 : 0.01), options);
      now.push_back(own.sums().front());
      check_sums(name, own, std::span(was).subspan(std::min(now.size() - 1, was.size())), lines, 1e-5);
    }
  INFO("now:\n" << lines);
  CHECK(now.size() == was.size());
}

}  // namespace

TEST_CASE("recorded: ELAM's fits on another range come to what they came to") {
  check_fits("elam",
             {{},
              {.free_run = true},
              {.exact_outer = true},
              {.memory = true},
              {.splits = 3},
              {.free_run = true, .exact_outer = true, .memory = true, .splits = 2}},
             {{1016.5951587, 198.1297978, 170},
              {1014.2084472, 198.3790103, 170},
              {1017.0949286, 198.1386474, 170},
              {1012.4132765, 198.7564002, 170},
              {1016.0525682, 198.8363624, 170},
              {1012.4292714, 198.6927383, 170},
              {2730.8951579, 211.9485228, 421},
              {2725.3406178, 212.6587675, 421},
              {2735.7431070, 210.1943879, 421},
              {2726.8101027, 212.7588801, 421},
              {2724.1017035, 211.3989308, 421},
              {2729.3249928, 212.2200286, 421}});
}

TEST_CASE("recorded: fits of POLY, MPI and monotone curves on another range come to what they came to") {
  check_fits("poly", {{}, {.free_run = true}, {.linearise = true}},
             {{1018.2601638, 195.2944097, 175},
              {1014.2813245, 196.9329453, 175},
              {1018.2601638, 195.2944097, 175},
              {2732.6713779, 210.1242599, 428},
              {2724.7123419, 212.4170691, 428},
              {2732.6713779, 210.1242599, 428}});
  check_fits("mpi", {{}, {.linearise = true}},
             {{1015.8879990, 199.0739798, 175},
              {1015.8879990, 199.0739798, 175},
              {2724.0766294, 215.3715688, 428},
              {2724.0766294, 215.3715688, 428}});
  check_fits("monotone", {{}}, {{1024.9327751, 181.0189348, 175}, {2755.8015848, 190.0185772, 428}});
}

TEST_CASE("recorded: Preisach's fits on another range come to what they came to") {
  check_fits("preisach", {{.cells = 4}, {.cells = 6, .by_input = true}, {.cells = 5, .linearise = true}},
             {{1015.9747421, 200.4837296, 175},
              {1016.1104306, 199.3588091, 175},
              {1015.6643026, 198.2183636, 175},
              {2724.1385317, 212.9167488, 428},
              {2724.9124456, 214.2980462, 428},
              {2722.6918467, 212.6917425, 428}});
}

TEST_CASE("Preisach's weights are open where no branch turns further inside than a hundredth of the range") {
  const auto open = [](const std::vector<double>& inputs) {
    const auto film = film_of_other_range(true);
    const auto [up, down] = patterns_of(*film, true);
    History history{"way", inputs, predict(*film, inputs), branches_along(inputs), {}, {}};
    const ModelFit fit = identify("preisach", {{history}, up, down, {}}, {.cells = 4});
    return fit.undetermined == std::vector<std::string>{"w"};
  };
  CHECK(open({5, 20, 40, 55, 40, 20, 5, 30, 55}));
  CHECK(open({5, 20, 40, 54.5, 40, 20, 5.5, 30, 55}));
  CHECK(open({20, 40, 55, 40, 20, 5}));  // where a recording begins is no turn
  CHECK_FALSE(open({5, 20, 40, 54.4, 40, 20, 5, 30, 55}));
  CHECK_FALSE(open({5, 20, 40, 55, 40, 20, 5.6, 30, 55}));
}
