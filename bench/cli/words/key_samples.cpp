#include "bench/cli/words/key_samples.h"

#include <string>

#include "bench/config/config.h"
#include "bench/config/config_laboratory.h"
#include "bench/config/config_profile.h"
#include "bench/config/operator_profile.h"
#include "bench/nightly/suite.h"
#include "sequences/recipe.h"
#include "sequences/toml/strict_toml.h"

namespace tactbench::bench {
namespace {

constexpr const char* kName = "the reference of keys";  // stands for a file

// Everything that a bench may have; the alternatives exclude each other, so there are several.
constexpr const char* kBench = R"(schema = 1
[bench]
id = "bench"
origin = "simulated"
[limits]
force_n = [5, 5, 35]
[module]
profile = "beckhoff-ek9000"
[regulator]
serial = "1"
[reference]
model = "transducer"
serial = "2"
[stage]
[force]
[simulation]
faults = [{kind = "valve_stuck", at_s = 1, at_psi = 1, at_n = 1, value = 1}]
defect = [{kind = "swapped", row = 0, column = 0, other_row = 1, other_column = 1}]
)";
constexpr const char* kHardware = R"(schema = 1
[bench]
id = "bench"
origin = "hardware"
[module]
profile = "waveshare-analog-output-8ch-b"
transport = "rtu"
serial_port = "/dev/ttyUSB0"
[input_module]
profile = "waveshare-analog-input-8ch-b"
unit = 2
[regulator]
serial = "1"
[reference]
model = "gauge"
serial = "2"
[reference.gauge]
unit = 3
address = 0
[reference.correction]
reading_psi = [0]
correction_psi = [0]
expanded_uncertainty_psi = [0.1]
[[environment.sensor]]
quantity = "temperature_c"
unit = 4
address = 0
[[environment.sensor]]
quantity = "supply_bar"
transport = "rtu"
serial_port = "/dev/ttyUSB1"
address = 0
[scanner]
kind = "daqmx"
[stage]
port = "/dev/ttyUSB2"
[force]
kind = "daq"
calibration_file = "FT.cal"
[force.tool]
displacement_mm = [0, 0, 1]
rotation_deg = [0, 0, 0]
)";

void read_benches() {
  (void)parse_bench(kBench, kName, {});
  (void)parse_bench(kBench, kName,
                    {{"scanner.kind", "frame-source"}, {"force.kind", "digital"}, {"bench.simulator", "in-process"}});
  (void)parse_bench(kHardware, kName, {});
  (void)parse_bench(kHardware, kName, {{"bench.origin", "simulated"}, {"bench.simulator", "external"}});
  try {
    (void)parse_bench(kBench, kName, {{"reference.correction_file", "no such file"}});
  } catch (const sequences::FileError& error) {  // the key was read, which is all that is wanted
    if (error.id() != "TB-FILE-MISSING") throw;
  }
  (void)parse_bench(kHardware, kName,
                    {{"input_module.transport", "rtu"}, {"input_module.serial_port", "/dev/ttyUSB3"}});
}

constexpr const char* kSampleRecipe = R"(schema = 1
name = "recipe"
unit = "psi"
step = 1
[parameters.level]
low = 1
high = 60
default = 40
)";
constexpr const char* kSuspend = R"([[suspend]]
quantity = "supply_bar"
trip_below = 6
resume_above = 6.5
[[suspend]]
quantity = "temperature_c"
trip_above = 30
resume_below = 28
)";
constexpr const char* kPress = R"(schema = 1
name = "press"
kind = "press"
[press]
object = "ring"
forces_n = [2]
)";

void read_recipes() {
  const auto read = [](const std::string& text) {
    (void)sequences::parse_recipe(sequences::TomlDocument::from_text(text, kName));
  };
  read(std::string("turning_points = [0, \"$level\", 0]\nrest_restart_s = 60\n") + kSampleRecipe +
       "[conditioning]\ncycles = 1\npeak = 60\n" + kSuspend);
  read(std::string(kSampleRecipe).replace(std::string(kSampleRecipe).find("step = 1"), 8, "step = 1\nrepeats = 1") +
       "[conditioning]\ncycles = 1\npeak = \"$level\"\n[random]\nseed = 1\nreversals = 3\nlow = 0\nhigh = 60\n");
  read(std::string(kPress) + "positions_mm = [[20, 20]]\n");
  read(std::string(kPress) + "[press.grid]\nx = [10, 20, 5]\ny = [10, 20, 5]\n");
}

void read_suites() {
  (void)parse_suite(R"(schema = 1
name = "suite"
[[scenario]]
name = "one"
about = "all keys"
held_out = ["random-reversal"]
held_out_2 = ["random-reversal"]
[scenario.taxels]
dead = [1]
[scenario.verdicts]
overall = "pass"
[scenario.figures]
frames = [1, 2]
)",
                    kName);
}

}  // namespace

const std::vector<FileKind>& file_kinds() {
  static const std::vector<FileKind> list = {
      {"Bench file",
       "bench.toml: a rig, its instruments and its limits. `tactbench init` and `tactbench init --rig` write ones with "
       "remarks to start from. `--set KEY=VALUE` changes a value for a run.",
       "tactbench-bench", "bench.toml, a rig and its limits", bench_meanings(), kName, read_benches},
      {"Recipe",
       "What a run does. How-to: [write a recipe](how-to-write-a-recipe.md). `--set recipe.KEY=VALUE` changes a value "
       "for a "
       "run.",
       "tactbench-recipe", "recipes, which say what a run measures", recipe_meanings(), kName, read_recipes},
      {"Sensor type", "sensor.toml: the kind of array, for `tactbench sensors add --type`.", "tactbench-sensor",
       "sensor.toml, a type of sensor", sensor_meanings(), kName,
       [] {
         (void)parse_sensor_type(
             "schema = 1\nname = \"type\"\nrows = 16\ncolumns = 16\nfull_scale = \"highest mean output of the run\"\n",
             kName);
       }},
      {"Limits", "limits.toml: what passes. How-to: [judge by your limits](how-to-judge-by-your-limits.md).",
       "tactbench-limits", "limits.toml, the limits that verdicts are by", limits_meanings(), kName,
       [] {
         (void)parse_limits(
             "schema = 1\nname = \"limits\"\nmean_compensation_error_psi = 1\nworst_taxel_error_psi = "
             "1\ndistance_of_mean_percent_fs = 1\n"
             "unfit_taxels = 0\n[[mismatch]]\npressure_psi = 10\nstd_percent_fs = 1\n"
             "[[mpe]]\npressure_psi = 10\nmpe_psi = 1\n[[mpe]]\nspan_psi = [4, 60]\nmpe_psi = 1\n",
             kName);
       }},
      {"Laboratory", "lab.toml: facts for reports that no instrument knows, for `tactbench report --lab`.",
       "tactbench-lab", "lab.toml, facts for reports", laboratory_meanings(), kName,
       [] { (void)parse_laboratory("schema = 1\n[[instrument]]\nserial = \"1\"\n", kName); }},
      {"Operator's profile", "tactbench.toml in the working folder: what need not be typed.", "tactbench.toml",
       "what need not be typed with every command", operator_meanings(), kName,
       [] {
         (void)parse_operator_profile(
             "bench = \"b\"\ndb = \"d\"\noperator = \"o\"\nrecipe = \"r\"\nlimits = \"l\"\nfleet = \"f\"\n", kName);
       }},
      {"Nightly suite",
       "What `tactbench nightly FILE` carries out. How-to: [a night in CI](how-to-run-a-night-in-ci.md).",
       "tactbench-nightly", "suites of simulated runs for every night", suite_meanings(), kName, read_suites},
      {"Module profile", "An analog module behind Modbus; `[module] profile` names a shipped one, or a file.",
       "tactbench-module", "profiles of analog modules", profile_meanings(), "",
       [] {
         for (const std::string& profile : shipped_profiles()) (void)read_module_profile(profile);
       }},
  };
  return list;
}

}  // namespace tactbench::bench
