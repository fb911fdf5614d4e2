// GPI's search from one start on few noisy samples of several films: the J at which it ended when recorded. Data
// were chosen for which last bits do not matter: moved by a billionth of their noise they end in the same place (of
// seed 6 they do not).
#include <algorithm>

#include "analysis/identify/identifier.h"
#include "analysis/models/gpi.h"
#include "analysis/models/preisach.h"
#include "tests/analysis/compensate/recorded_streams.h"

using namespace tactbench::analysis;
using namespace recorded;

namespace {

FitData few_samples(std::uint64_t seed) {
  Numbers number(seed);
  std::vector<double> weights;
  for (int k = 0; k < 10; ++k) weights.push_back(0.05 + number());
  const PreisachModel film(3.0, 47.0, 0.4, weights);
  const double noise = seed % 3 == 0 ? 0.0 : 0.15;
  FitData data;
  const auto state = film.state();
  History history{"way", {}, {}, {}, {}, {}};
  double at = 3.0;
  for (int turn = 0; turn < 10; ++turn) {
    const double share = number();
    const double to = turn == 0       ? 47.0
                      : turn == 1     ? 3.0
                      : turn % 2 == 0 ? at + (47.0 - at) * share
                                      : at + (3.0 - at) * share;
    for (int k = turn == 0 ? 0 : 1; k <= 3; ++k) {
      const double x = at + (to - at) * k / 3.0;
      state->go(x);
      history.x.push_back(x);
      history.y.push_back(state->output_at(x) + noise * (number() - 0.5));
    }
    at = to;
  }
  history.branches = branches_along(history.x);
  data.histories.push_back(std::move(history));
  std::vector<double> x, up, down;
  for (int k = 0; k <= 4; ++k) x.push_back(3.0 + 11.0 * k);
  std::vector<double> way = x;
  way.insert(way.end(), x.rbegin(), x.rend());
  const std::vector<double> y = predict(film, way);
  up.assign(y.begin(), y.begin() + 5);
  down.assign(y.rbegin(), y.rbegin() + 5);
  data.ascending = PatternCurve(x, up, 0.4, up.back());
  data.descending = PatternCurve(x, down, 0.4, up.back());
  return data;
}

struct RecordedSearch {
  std::uint64_t seed;
  double j, mean_error;
  std::size_t undetermined;
};

const std::vector<RecordedSearch> kSearches{
    {1, 0.2460804485, 0.06793267161, 1},  {2, 0.3054920244, 0.07570452244, 3},   {3, 0.6579385286, 0.1074675667, 2},
    {4, 0.1689924154, 0.05959823849, 1},  {5, 0.1472286332, 0.051531838, 1},     {7, 0.4981814795, 0.0955421757, 2},
    {8, 0.4118841789, 0.07516421672, 1},  {9, 0.2916072692, 0.05507109403, 2},   {10, 0.5175736187, 0.10455998, 2},
    {11, 0.1715793979, 0.06029821323, 1}, {12, 0.4631048699, 0.100032365, 1},    {13, 0.2053104391, 0.06549674152, 5},
    {14, 0.2632838194, 0.07654250651, 6}, {15, 0.6419691033, 0.09455111104, 2},  {16, 0.2810406728, 0.07526264533, 0},
    {17, 0.1167964887, 0.04281233632, 2}, {18, 0.3688920624, 0.0835933744, 2},   {19, 0.7043449529, 0.1013990697, 2},
    {20, 0.2799350347, 0.06848112651, 2}, {21, 0.21511876, 0.0377923376, 6},     {22, 0.3857053717, 0.09684095564, 1},
    {23, 0.4067454584, 0.09297216725, 1}, {24, 0.2030676884, 0.06055543323, 1},  {25, 0.2670348767, 0.07469065136, 1},
    {26, 0.4931633038, 0.1081816873, 1},  {27, 0.2974891438, 0.06172881231, 2},  {28, 0.3341130674, 0.08622054965, 1},
    {29, 0.1820252574, 0.06146369801, 2}, {30, 0.04175588988, 0.0266319184, 4},  {31, 0.03951539046, 0.02940288858, 2},
    {32, 0.1510604973, 0.05431416267, 2}, {33, 0.06939346132, 0.03351800539, 1}, {34, 0.09568147898, 0.0460794358, 1},
    {35, 0.3883217323, 0.07677072645, 1}, {36, 0.1874003545, 0.05621212716, 1},  {37, 0.2553946828, 0.06445111198, 2},
    {38, 0.6353474204, 0.1234655695, 5},  {39, 0.01876961741, 0.01687705669, 1}, {40, 0.07126301304, 0.03630432143, 5}};

}  // namespace

TEST_CASE("recorded: GPI's search from one start ends with the J that it had when recorded") {
  for (const RecordedSearch& was : kSearches) {
    CAPTURE(was.seed);
    const ModelFit fit = identify("gpi", few_samples(was.seed), {.starts = 1});
    CHECK(fit.j == Approx(was.j).epsilon(1e-6));
    CHECK(fit.mean_error == Approx(was.mean_error).epsilon(1e-3));
    CHECK(fit.undetermined.size() == was.undetermined);
    CHECK(fit.starts == 1);
    CHECK(fit.samples == 30);
  }
}
