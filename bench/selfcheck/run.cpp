#include <fmt/format.h>

#include "bench/common/utc.h"
#include "bench/config/config.h"
#include "bench/reporting/evaluation.h"
#include "bench/reporting/verification.h"
#include "bench/run/characterize.h"
#include "bench/selfcheck/selfcheck.h"

namespace tactbench::bench {

namespace {

constexpr const char* kShortRecipe =
    "schema = 1\nname = \"selfcheck\"\nunit = \"psi\"\nturning_points = [0, 60, 20, 60, 0, 30, 0]\nstep = 5\n"
    "repeats = 2\n[conditioning]\ncycles = 1\npeak = 60\n";

RunResult short_run(db::RunStore& store) {
  RunRequest request;
  request.bench = read_bench(find_config("simulated.toml"), {}, {1, 1});
  request.recipes = {sequences::parse_recipe(sequences::TomlDocument::from_text(kShortRecipe, "selfcheck.toml"))};
  request.sensor_type = read_sensor_type(find_config("sensor.toml"));
  const SensorType& type = request.sensor_type;
  request.sensor = {"SELFCHECK", type.name, type.text, db::sha256_hex(type.text), SimulationConfig().scanner_serial,
                    "",          utc_now()};
  if (!store.sensor("SELFCHECK")) store.add_sensor(request.sensor);
  request.operator_name = "selfcheck";
  request.check_seating = false;  // a new sensor has no earlier seating to compare with
  Progress progress(Progress::Mode::kQuiet);
  RunResult result = characterize(request, store, progress);
  if (result.error) throw *result.error;
  return result;
}

}  // namespace

SelfcheckLines check_simulated_run(const std::string& folder) {
  SelfcheckLines lines;
  std::int64_t run = 0;
  std::string hash;
  const std::string path = folder + "/run.db";
  lines.push_back(selfchecked("run", "0-60-20-60-0-30-0 psi twice on the simulated rig: Modbus TCP and HID reports",
                              "completed, 106 frames, safe state verified", [&]() -> SelfcheckAnswer {
                                db::RunStore store = db::RunStore::open(path, db::Durability::kNormal);
                                const RunResult result = short_run(store);
                                run = result.run;
                                hash = result.content_sha256;
                                return {result.outcome == db::Outcome::kCompleted && result.frames == 106 &&
                                            result.safe == db::SafeState::kVerified,
                                        fmt::format("{}, {} frames, safe state {}", db::to_string(result.outcome),
                                                    result.frames, db::to_string(result.safe))};
                              }));
  lines.push_back(selfchecked("run", "its 256 taxels fitted and stored, then verified from the raw frames",
                              "content as stored, fit equal", [&]() -> SelfcheckAnswer {
                                db::RunStore store = db::RunStore::open(path, db::Durability::kNormal);
                                (void)fit_run(store, analysis::load_dataset(store, run));
                                const RunVerification verified = verify_run(store, run);
                                const bool good = verified.content.holds() && verified.first_difference.empty() &&
                                                  verified.results.size() == 1 && verified.results.front().recomputed;
                                return {good, good ? fmt::format("content as stored, fit equal; {}",
                                                                 verified.results.front().compared)
                                                   : verified.first_difference};
                              }));
  lines.push_back(
      selfchecked("run", "the same run again, in another store", "the same content hash", [&]() -> SelfcheckAnswer {
        db::RunStore store = db::RunStore::open(folder + "/again.db", db::Durability::kNormal);
        const std::string again = short_run(store).content_sha256;
        return {again == hash && !again.empty(),
                again == hash ? fmt::format("the same: {}", hash.substr(0, 16))
                              : fmt::format("{} and {}", hash.substr(0, 16), again.substr(0, 16))};
      }));
  return lines;
}

}  // namespace tactbench::bench
