#include "bench/selfcheck/selfcheck.h"

#include <fmt/format.h>

#include <CLI/Version.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <functional>
#include <memory>
#include <nlohmann/json_fwd.hpp>

#include "analysis/identify/fit_models.h"
#include "analysis/models/elam.h"
#include "analysis/models/gpi.h"
#include "bench/common/utc.h"
#include "bench/config/config.h"
#include "bench/reporting/evaluation.h"
#include "bench/reporting/verification.h"
#include "bench/run/characterize.h"
#include "db/run_store.h"
#include "devices/library_versions.h"
#include "sequences/library_versions.h"

namespace tactbench::bench {

namespace {

using namespace analysis;

struct Answer {
  bool pass = false;
  std::string found;
};

SelfcheckLine checked(const std::string& area, const std::string& what, const std::string& expected,
                      const std::function<Answer()>& check) {
  SelfcheckLine line{area, what, expected, {}, false};
  try {
    const Answer answer = check();
    line.found = answer.found;
    line.pass = answer.pass;
  } catch (const std::exception& error) {
    line.found = fmt::format("could not be checked: {}", error.what());
  }
  return line;
}

constexpr double kSpanPsi = 60.0, kTopV = 3.49;

double largest_difference(const std::vector<double>& a, std::span<const double> b) {
  double worst = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) worst = std::max(worst, std::abs(a[i] - b[i]));
  return worst;
}

Answer within(double found, double limit, const char* unit) {
  return {found <= limit, fmt::format("within {:.2g} {}", found, unit)};
}

// In steps of 2 psi.
std::vector<double> walk_along(const std::vector<double>& turns) {
  std::vector<double> inputs{turns.front()};
  for (const double turn : turns)
    while (inputs.back() != turn) inputs.push_back(inputs.back() + (turn > inputs.back() ? 2.0 : -2.0));
  return inputs;
}

// The model's outputs along both sequences of Table 1, and its external loop as patterns.
FitData data_made_by(const HysteresisModel& model) {
  const std::vector<double> y = predict(model, walk_along({0, 60, 0}));
  std::vector<double> grid;
  for (int i = 0; i <= 30; ++i) grid.push_back(2.0 * i);
  const std::vector<double> up(y.begin(), y.begin() + 31);
  std::vector<double> down(y.rbegin(), y.rbegin() + 31);
  down.front() = up.front();
  FitData data{{}, PatternCurve(grid, up, up.front(), up.back()), PatternCurve(grid, down, up.front(), up.back())};
  if (const auto* elam = dynamic_cast<const ElamHysteresis*>(&model)) {
    data.ascending = elam->elam().ascending;
    data.descending = elam->elam().descending;
  } else if (model.name() == GpiModel::kName) {  // it does not end where it starts: its own loop would move its origin
    const std::vector<double> ends{0.0, kSpanPsi}, volts{0.0, kTopV};
    data.ascending = data.descending = PatternCurve(ends, volts, 0.0, kTopV);
  }
  for (const std::vector<double>& turns :
       {std::vector<double>{0, 60, 0, 50, 0, 40, 0, 30, 0, 20, 0, 10, 0},
        {0, 60, 10, 60, 0, 60, 20, 60, 0, 60, 30, 60, 0, 60, 40, 60, 0, 60, 50, 60, 0}}) {
    const std::vector<double> levels = walk_along(turns);
    data.histories.push_back({"known", levels, predict(model, levels), branches_along(levels), {}, {}});
  }
  return data;
}

constexpr const char* kShortRecipe =
    "schema = 1\nname = \"selfcheck\"\nunit = \"psi\"\nturning_points = [0, 60, 20, 60, 0, 30, 0]\nstep = 5\n"
    "repeats = 2\n[conditioning]\ncycles = 1\npeak = 60\n";

RunResult short_run(db::RunStore& store) {
  RunRequest request;
  request.bench = read_bench(find_config("simulated.toml"), {}, {1, 1});
  request.recipes = {sequences::parse_recipe(sequences::TomlDocument::from_text(kShortRecipe, "selfcheck.toml"))};
  const SensorType type = request.sensor_type = read_sensor_type(find_config("sensor.toml"));
  request.sensor = {"SELFCHECK", type.name, type.text, db::sha256_hex(type.text), SimulationConfig().scanner_serial,
                    "",          utc_now()};
  store.add_sensor(request.sensor);
  request.operator_name = "selfcheck";
  request.check_seating = false;  // a new sensor has no earlier seating to compare with
  Progress progress(Progress::Mode::kQuiet);
  RunResult result = characterize(request, store, progress);
  if (result.error) throw *result.error;
  return result;
}

}  // namespace

SelfcheckLines check_models() {
  SelfcheckLines lines;
  for (const ModelKind& kind : model_kinds()) {
    if (kind.known == nullptr) continue;
    const KnownModel known = kind.known();
    const HysteresisModel& model = *known.model;
    const std::string name = kind.name;
    const std::vector<double> inputs(kKnownInputs.begin(), kKnownInputs.end());
    lines.push_back(checked(
        "model", name + ": outputs at 0, 30, 60, 30, 10, 40 psi", "equal to those of another program, within 1e-12 V",
        [&] { return within(largest_difference(predict(model, inputs), known.volts), 1e-12, "V"); }));
    const std::vector<double> way = walk_along({0, 44, 6, 38, 12, 54, 2, 26, 16, 60}), volts = predict(model, way);
    lines.push_back(
        checked("model", name + ": its inverse along other turns", "the same outputs again, within 1e-9 V",
                [&] { return within(largest_difference(predict(model, invert(model, volts)), volts), 1e-9, "V"); }));
    lines.push_back(
        checked("model", name + ": a fit to its outputs along Table 1", "the same outputs there, within 1e-6 V", [&] {
          return within(largest_difference(predict(*identify(name, data_made_by(model)).model, way), volts), 1e-6, "V");
        }));
  }
  return lines;
}

SelfcheckLines check_run(const std::string& folder) {
  SelfcheckLines lines;
  const std::string path = folder + "/run.db";
  RunResult run;
  lines.push_back(checked("run", "a run of the simulated rig, 0-60-20-60-0-30-0 psi twice",
                          "completed, 106 frames, safe state verified", [&]() -> Answer {
                            db::RunStore store = db::RunStore::open(path, db::Durability::kNormal);
                            run = short_run(store);
                            return {run.outcome == db::Outcome::kCompleted && run.frames == 106 &&
                                        run.safe == db::SafeState::kVerified,
                                    fmt::format("{}, {} frames, safe state {}", db::to_string(run.outcome), run.frames,
                                                db::to_string(run.safe))};
                          }));
  lines.push_back(
      checked("run", "its 256 taxels fitted, then verified from the raw frames", "as stored", [&]() -> Answer {
        db::RunStore store = db::RunStore::open(path, db::Durability::kNormal);
        (void)fit_run(store, load_dataset(store, run.run));
        const RunVerification verified = verify_run(store, run.run);
        const bool good = verified.content.holds() && verified.first_difference.empty() &&
                          verified.results.size() == 1 && verified.results.front().recomputed;
        return {good, good ? "as stored, " + verified.results.front().compared : verified.first_difference};
      }));
  lines.push_back(checked("run", "the same run again, in another store", "the same content hash", [&]() -> Answer {
    db::RunStore store = db::RunStore::open(folder + "/again.db", db::Durability::kNormal);
    const bool same = short_run(store).content_sha256 == run.content_sha256 && !run.content_sha256.empty();
    return {same, same ? "the same content hash" : "another content hash"};
  }));
  return lines;
}

std::vector<std::pair<std::string, std::string>> library_versions() {
  std::vector<std::pair<std::string, std::string>> versions = db::library_versions();
  for (auto& version : devices::library_versions()) versions.push_back(std::move(version));
  for (auto& version : sequences::library_versions()) versions.push_back(std::move(version));
  versions.emplace_back("fmt",
                        fmt::format("{}.{}.{}", FMT_VERSION / 10000, FMT_VERSION / 100 % 100, FMT_VERSION % 100));
  versions.emplace_back("CLI11", CLI11_VERSION);
  versions.emplace_back("nlohmann-json", fmt::format("{}.{}.{}", NLOHMANN_JSON_VERSION_MAJOR,
                                                     NLOHMANN_JSON_VERSION_MINOR, NLOHMANN_JSON_VERSION_PATCH));
  std::ranges::sort(versions);
  return versions;
}

}  // namespace tactbench::bench
