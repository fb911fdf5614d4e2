#include "bench/nightly/followed_units.h"

#include <cctype>
#include <string>

namespace tactbench::bench {

namespace {

constexpr const char* kPsiWord = "psi";

// Where psi stands in a name as a word of its own; npos: nowhere.
std::size_t place_of_psi(const std::string& name) {
  for (std::size_t at = name.find(kPsiWord); at != std::string::npos; at = name.find(kPsiWord, at + 1)) {
    const std::size_t end = at + 3;
    if ((at == 0 || name[at - 1] == '_') && (end == name.size() || name[end] == '_')) return at;
  }
  return std::string::npos;
}

void scale(FollowedFigure& figure, double factor) {
  for (double& value : figure.values) value *= factor;
  analysis::FigureChart& chart = figure.chart;
  if (chart.band) {
    for (double* value : {&chart.band->mean, &chart.band->low, &chart.band->high}) *value *= factor;
    if (!chart.logarithmic) chart.band->deviation *= factor;
  }
  chart.level *= factor;
  if (chart.slope) *chart.slope *= factor;
}

}  // namespace

Followed in_unit(Followed followed, analysis::PressureUnit unit) {
  if (unit == analysis::PressureUnit::kPsi) return followed;
  std::string symbol = unit.symbol();
  for (char& letter : symbol) letter = static_cast<char>(std::tolower(static_cast<unsigned char>(letter)));
  for (FollowedFigure& figure : followed.figures) {
    const std::size_t at = place_of_psi(figure.name);
    if (at == std::string::npos) continue;
    const bool per = at >= 4 && figure.name.compare(at - 4, 4, "per_") == 0;
    scale(figure, per ? unit.per(1.0) : unit.of(1.0));
    figure.name.replace(at, 3, symbol);
  }
  return followed;
}

}  // namespace tactbench::bench
