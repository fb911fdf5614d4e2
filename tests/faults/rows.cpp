// The matrix's rows and columns, and what is written of them.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>

#include "bench/simulation/plant.h"
#include "tests/faults/faulty_run.h"
#include "tests/support/paths.h"

namespace tactbench::tests {

using bench::FaultKind;
using bench::Rig;

const std::vector<Point>& points_of(Bench bench) {
  static const std::vector<Point> chamber = {Point::kOpening, Point::kBaseline, Point::kConditioning, Point::kRising,
                                             Point::kTurning, Point::kFalling,  Point::kLastBranch,   Point::kVent};
  static const std::vector<Point> press = {Point::kHoming,    Point::kApproach, Point::kPressing,
                                           Point::kReleasing, Point::kRetract,  Point::kRetreat};
  return bench == Bench::kChamber ? chamber : press;
}

const char* keyword_of(Point point) {
  static const char* const kWords[] = {"opening",         "baseline",        "conditioning",   "rising, 20 psi",
                                       "turning, 60 psi", "falling, 40 psi", "last branch",    "way out at 60 psi",
                                       "homing",          "approach",        "pressing, 15 N", "releasing, 30 N",
                                       "retract",         "way out at 30 N"};
  return kWords[static_cast<std::size_t>(point)];
}

Breakage breakage(FaultKind kind, std::optional<double> value, long times) {
  Breakage made;
  made.name = bench::fault_kind_names()[static_cast<std::size_t>(kind)];
  for (char& c : made.name) c = c == '_' ? ' ' : c;
  if (times == 1) made.name += ", once";
  made.plan.emplace();
  made.plan->kind = kind;
  made.plan->value = value;
  made.plan->times = times;
  made.strike = [=](Rig& rig, const std::string&) { rig.plant()->inject(kind, value, times); };
  return made;
}

Breakage together(const std::string& name, const std::vector<Breakage>& all) {
  Breakage made;
  made.name = name;
  made.strike = [all](Rig& rig, const std::string& store) {
    for (const Breakage& one : all) one.strike(rig, store);
  };
  made.beyond_reach = std::ranges::any_of(all, &Breakage::beyond_reach);
  return made;
}

Breakage on_bench(const std::string& what, const std::vector<sequences::Override>& settings, Breakage breakage) {
  breakage.name += ", " + what;
  breakage.bench = settings;
  return breakage;
}

void check_row(Bench bench, const Breakage& breakage, const std::vector<Point>& only) {
  std::vector<std::string> cells;
  for (const Point point : points_of(bench)) {
    const bool wanted = only.empty() || std::find(only.begin(), only.end(), point) != only.end();
    cells.push_back(wanted ? cell_of(bench, point, breakage) : "");
  }
  check_row(bench == Bench::kChamber ? "chamber" : "press", breakage.name, cells);
}

void check_row(const std::string& table, const std::string& name, const std::vector<std::string>& cells) {
  const std::string row = fmt::format("| {} | {} |", name, fmt::join(cells, " | "));
  std::string file = name;
  for (char& c : file) c = c == ' ' || c == ',' ? '-' : c;
  std::filesystem::create_directories(TACTBENCH_FAULT_ROWS);
  write_file(fmt::format("{}/{}.{}", TACTBENCH_FAULT_ROWS, table, file), row + "\n");
  const std::string kept = source_path("tests/faults/README.md");
  // A row that meets real time-outs may differ from machine to machine; what must hold in a cell is checked there.
  if (read_file(kept).find(row) == std::string::npos) {
    WARN("tests/faults/README.md, which says how it is written anew, has another row than\n" << row);
  }
}

}  // namespace tactbench::tests
