// Which of Preisach's weights a recording leaves open.
#include <catch2/catch.hpp>
#include <memory>
#include <string>
#include <vector>

#include "analysis/identify/identifier.h"
#include "analysis/models/linearised.h"
#include "analysis/models/preisach.h"

using namespace tactbench::analysis;

TEST_CASE("Preisach's weights are open where no branch turns further inside than a hundredth of the range") {
  const auto open = [](const std::vector<double>& inputs) {
    const LinearisedModel film(
        Divider{0.7, 0.1}, std::make_shared<PreisachModel>(
                               5.0, 55.0, 0.0, std::vector<double>{0.3, 0.5, 0.4, 0.2, 0.6, 0.5, 0.1, 0.9, 0.3, 0.8}));
    std::vector<double> x, way;
    for (int i = 0; i <= 6; ++i) x.push_back(5.0 + 50.0 * i / 6.0);
    way = x;
    way.insert(way.end(), x.rbegin(), x.rend());
    const std::vector<double> y = predict(film, way), up(y.begin(), y.begin() + 7), down(y.rbegin(), y.rbegin() + 7);
    History history{"way", inputs, predict(film, inputs), branches_along(inputs), {}, {}};
    const ModelFit fit = identify(
        "preisach", {{history}, PatternCurve(x, up, 0.7, up.back()), PatternCurve(x, down, 0.7, up.back()), {}},
        {.cells = 4});
    return fit.undetermined == std::vector<std::string>{"w"};
  };
  CHECK(open({5, 20, 40, 55, 40, 20, 5, 30, 55}));
  CHECK(open({5, 20, 40, 54.5, 40, 20, 5.5, 30, 55}));
  CHECK(open({20, 40, 55, 40, 20, 5}));  // where a recording begins is no turn
  CHECK_FALSE(open({5, 20, 40, 54.4, 40, 20, 5, 30, 55}));
  CHECK_FALSE(open({5, 20, 40, 55, 40, 20, 5.6, 30, 55}));
}
