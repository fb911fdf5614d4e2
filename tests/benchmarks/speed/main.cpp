// Speed of the program's parts; --benchmark_filter=REGEX chooses.
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "tests/benchmarks/speed/ratios.h"

namespace {

class FigureReporter : public benchmark::ConsoleReporter {
 public:
  FigureReporter() : ConsoleReporter(OO_Tabular) {}
  void ReportRuns(const std::vector<Run>& runs) override {
    ConsoleReporter::ReportRuns(runs);
    for (const Run& run : runs) {
      if (run.run_type != Run::RT_Iteration || run.error_occurred) continue;
      std::string name = run.run_name.function_name;
      if (!run.run_name.args.empty()) name += "/" + run.run_name.args;
      const double unit = benchmark::GetTimeUnitMultiplier(run.time_unit);  // of a second
      const bool wall = !run.run_name.time_type.empty();
      double seconds = (wall ? run.GetAdjustedRealTime() : run.GetAdjustedCPUTime()) / unit;
      for (const auto& [counter, value] : run.counters) {
        if (counter == "items_per_second") seconds = 1.0 / value;
        const std::size_t bracket = counter.find(" [");
        if (bracket != std::string::npos)
          counters_[name + "_" + counter.substr(0, bracket)] = {value, counter.substr(bracket + 2)};
      }
      const auto [best, first] =
          times_.try_emplace(name, Time{seconds, unit, benchmark::GetTimeUnitString(run.time_unit)});
      if (!first) best->second.seconds = std::min(best->second.seconds, seconds);
    }
  }
  void Finalize() override {
    ConsoleReporter::Finalize();
    for (const auto& [name, time] : times_) print(name, time.seconds * time.per_second, time.unit);
    for (const auto& [name, value] : counters_)
      print(name, value.first, value.second.substr(0, value.second.size() - 1));
    for (const tactbench::speed::Quotient& quotient : tactbench::speed::quotients()) {
      double by = 0.0;
      bool all = times_.contains(quotient.of);
      for (const std::string& name : quotient.by) {
        all = all && times_.contains(name);
        if (all) by += times_.at(name).seconds;
      }
      if (!all) continue;
      print(quotient.name, times_.at(quotient.of).seconds / by, "x");
      if (quotient.at_most > 0.0) print(quotient.name + "_goal_at_most", quotient.at_most, "x");
      if (quotient.at_least > 0.0) print(quotient.name + "_goal_at_least", quotient.at_least, "x");
    }
  }

 private:
  struct Time {
    double seconds = 0.0, per_second = 1.0;
    std::string unit;
  };
  static void print(const std::string& name, double value, const std::string& unit) {
    fmt::print("FIGURE {} {:.3f} {}\n", name, value, unit);
  }
  std::map<std::string, Time> times_;
  std::map<std::string, std::pair<double, std::string>> counters_;
};

}  // namespace

int main(int count, char** words) {
  // The best of five repetitions, in turn, so that a slow spell of the machine falls on all; options of the caller win.
  std::string repetitions = "--benchmark_repetitions=5", in_turn = "--benchmark_enable_random_interleaving=true";
  std::vector<char*> all{words[0], repetitions.data(), in_turn.data()};
  all.insert(all.end(), words + 1, words + count);
  int length = static_cast<int>(all.size());
  benchmark::Initialize(&length, all.data());
  if (benchmark::ReportUnrecognizedArguments(length, all.data())) return 2;
  FigureReporter reporter;
  benchmark::RunSpecifiedBenchmarks(&reporter);
}
