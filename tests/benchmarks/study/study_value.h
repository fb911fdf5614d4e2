// A figure of a study, printed as a line FIGURE <name> <value> <unit>.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace tactbench::bench {

struct Figure {
  std::string name;
  double value = 0.0;
  std::string unit;
};

// Figures of one study: their names begin with its own.
class FigureList {
 public:
  explicit FigureList(std::string study) : study_(std::move(study)) {}
  void add(const std::string& name, double value, const std::string& unit) {
    figures_.push_back({study_ + "_" + name, value, unit});
  }
  // The figure, and its goal after it as <name>_goal_at_most.
  void add_at_most(const std::string& name, double value, double goal, const std::string& unit) {
    add(name, value, unit);
    add(name + "_goal_at_most", goal, unit);
  }
  [[nodiscard]] std::vector<Figure> take() { return std::move(figures_); }

 private:
  std::string study_;
  std::vector<Figure> figures_;
};

}  // namespace tactbench::bench
