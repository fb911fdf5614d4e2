// Sensor types, limits, profiles and shipped files: each number and word as it is read, and what is said of wrong ones.
#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "bench/common/build_info.h"
#include "bench/config/config.h"
#include "bench/config/config_laboratory.h"
#include "bench/config/operator_profile.h"
#include "sequences/toml/pressure_text.h"
#include "tests/bench/config/bench_text.h"
#include "tests/support/process.h"
#include "tests/support/variable.h"

using namespace tactbench;
using namespace tactbench::tests;
using bench::ProfileKey;

namespace {

const std::string kSensorHead = "schema = 1\nname = \"s\"\n";
const std::string kSensorEnd = "full_scale = \"highest mean output of the run\"\n";
const std::string kLimitsHead = "schema = 1\nname = \"l\"\n";
const std::string kFourLimits =
    "mean_compensation_error_psi = 1.25\nworst_taxel_error_psi = 3\ndistance_of_mean_percent_fs = 1.5\nunfit_taxels = "
    "4\n";

template <class Work>
bool file_is_taken(const Work& work) {
  return file_refusal(work).id == "accepted";
}

}  // namespace

TEST_CASE("sensor types: values, defaults, ranges and overrides") {
  const bench::SensorType given =
      bench::parse_sensor_type(kSensorHead +
                                   "rows = 2\ncolumns = 3\npitch_mm = 1.5\ntaxel_area_mm2 = 2\norientation_deg = 90\n"
                                   "output_range_v = [0.5, 4.5]\n" +
                                   kSensorEnd,
                               "f");
  CHECK(given.name == "s");
  CHECK((given.rows == 2 && given.columns == 3));
  CHECK((given.pitch_mm == 1.5 && given.taxel_area_mm2 == 2.0 && given.orientation_deg == 90.0));
  CHECK((given.output_low_v == 0.5 && given.output_high_v == 4.5));
  CHECK(given.full_scale == "highest mean output of the run");
  const bench::SensorType usual = bench::parse_sensor_type(kSensorHead + "rows = 64\ncolumns = 1\n" + kSensorEnd, "f");
  CHECK((usual.pitch_mm == 2.54 && usual.orientation_deg == 0.0));
  CHECK(usual.taxel_area_mm2 == Approx(6.4516));
  CHECK((usual.output_low_v == 0.0 && usual.output_high_v == 5.0));
  CHECK(bench::parse_sensor_type(kSensorHead + "rows = 2\ncolumns = 3\npitch_mm = 3\n" + kSensorEnd, "f")
            .taxel_area_mm2 == 9.0);
  for (const char* line : {"rows = 0", "rows = 65", "columns = 65", "pitch_mm = 0.009", "pitch_mm = 101",
                           "taxel_area_mm2 = 10001", "orientation_deg = 361"}) {
    const std::string word = line, rows = word.starts_with("rows") ? "" : "rows = 2\n",
                      columns = word.starts_with("columns") ? "" : "columns = 3\n";
    INFO(line);
    CHECK_FALSE(file_is_taken(
        [&] { (void)bench::parse_sensor_type(kSensorHead + rows + columns + word + "\n" + kSensorEnd, "f"); }));
  }
  CHECK(bench::read_sensor_type(bench::find_config("sensor.toml"), {{"rows", "8"}, {"name", "mine"}}).rows == 8);
  CHECK(bench::read_sensor_type(bench::find_config("sensor.toml"), {{"rows", "8"}, {"name", "mine"}}).name == "mine");
}

TEST_CASE("limits: percentages become fractions, an mpe table is for a level or a span") {
  const analysis::Limits limits =
      bench::parse_limits(kLimitsHead + kFourLimits +
                              "rule = \"guarded\"\n[[mismatch]]\npressure_psi = 10\nstd_percent_fs = 5\n"
                              "[[mismatch]]\npressure_psi = 20\nstd_percent_fs = 4\n"
                              "[[mpe]]\nspan_psi = [4, 60]\nmpe_psi = 2.5\ntaxels_percent = 80\n",
                          "f");
  CHECK(limits.name == "l");
  CHECK(limits.rule == analysis::DecisionRule::kGuarded);
  CHECK(limits.mean_compensation_error_psi == 1.25);
  CHECK(limits.worst_taxel_error_psi == 3.0);
  CHECK(limits.distance_of_mean_fs == 0.015);
  CHECK(limits.unfit_taxels == 4.0);
  REQUIRE(limits.mismatch.size() == 2);
  CHECK((limits.mismatch[0].pressure_psi == 10.0 && limits.mismatch[0].std_fs == 0.05));
  CHECK((limits.mismatch[1].pressure_psi == 20.0 && limits.mismatch[1].std_fs == 0.04));
  REQUIRE(limits.mpe.size() == 1);
  CHECK((limits.mpe[0].mpe_psi == 2.5 && limits.mpe[0].share == 0.8));
  const auto mpe_taken = [](const std::string& row) {
    return file_is_taken([&] { (void)bench::parse_limits(kLimitsHead + kFourLimits + "[[mpe]]\n" + row, "f"); });
  };
  for (const char* row :
       {"mpe_psi = 2\n", "pressure_psi = 20\nspan_psi = [4, 60]\nmpe_psi = 2\n", "pressure_psi = 20\nmpe_psi = 0\n",
        "pressure_psi = 20\nmpe_psi = -1\n", "pressure_psi = 20\nmpe_psi = 2\ntaxels_percent = 101\n"})
    CHECK_FALSE(mpe_taken(row));
  CHECK(mpe_taken("pressure_psi = 20\nmpe_psi = 1e-6\n"));
}

TEST_CASE("limits: kPa, bar and psi give the same values, bit for bit those of a recipe") {
  const double level = sequences::psi_per_unit("kPa") * 100.0;
  for (const char* typed : {"\"100 kPa\"", "\"100kPa\"", "\"1 bar\"", "14.503773773020922"}) {
    CAPTURE(typed);
    const analysis::Limits limits = bench::parse_limits(
        kLimitsHead + std::string("mean_compensation_error_psi = ") + typed + "\nworst_taxel_error_psi = " + typed +
            "\ndistance_of_mean_percent_fs = 1.5\nunfit_taxels = 4\n[[mismatch]]\npressure_psi = " + typed +
            "\nstd_percent_fs = 5\n[[mpe]]\nspan_psi = [\"0 kPa\", " + typed + "]\nmpe_psi = " + typed + "\n",
        "f");
    for (const double read : {limits.mean_compensation_error_psi, limits.worst_taxel_error_psi,
                              limits.mismatch.at(0).pressure_psi, limits.mpe.at(0).high_psi, limits.mpe.at(0).mpe_psi})
      CHECK(read == Approx(level).epsilon(1e-15));
  }
  for (const char* wrong : {"pressure_psi = \"100\"", "pressure_psi = \"100 mbar\"", "std_percent_fs = \"5 kPa\""}) {
    CAPTURE(wrong);
    const std::string other = wrong[0] == 'p' ? "\nstd_percent_fs = 5\n" : "\npressure_psi = 10\n";
    const auto refused = file_refusal([&] {
      (void)bench::parse_limits(kLimitsHead + kFourLimits + std::string("[[mismatch]]\n") + wrong + other, "f");
    });
    CHECK(refused.id == "TB-FILE-VALUE");
  }
}

TEST_CASE("laboratory: each field has its own key") {
  const std::vector<std::string> keys = {
      "laboratory", "address",   "place", "accreditation", "customer",       "customer_address",
      "order",      "condition", "cable", "mounting",      "medium",         "environment",
      "deviations", "remarks",   "city",  "postcode",      "signer_function"};
  std::string text = "schema = 1\nreceived = 2026-02-28\n";
  for (const std::string& key : keys) text += key + " = \"of " + key + "\"\n";
  text +=
      "[[instrument]]\nserial = \"1\"\ncertificate = \"2\"\ncalibrated_by = \"3\"\ncalibrated_on = 2026-01-04\n"
      "due = 2027-01-05\nnote = \"6\"\n";
  const analysis::Laboratory lab = bench::parse_laboratory(text, "f");
  const std::vector<const std::string*> fields = {
      &lab.laboratory, &lab.address,   &lab.place, &lab.accreditation, &lab.customer,       &lab.customer_address,
      &lab.order,      &lab.condition, &lab.cable, &lab.mounting,      &lab.medium,         &lab.environment,
      &lab.deviations, &lab.remarks,   &lab.city,  &lab.postcode,      &lab.signer_function};
  for (std::size_t i = 0; i < keys.size(); ++i) CHECK(*fields[i] == "of " + keys[i]);
  CHECK(lab.received == "2026-02-28");
  CHECK(bench::parse_laboratory("schema = 1\ncountry = \"DE\"\n", "f").country == "DE");
  REQUIRE(lab.instruments.size() == 1);
  const analysis::InstrumentNote& note = lab.instruments[0];
  CHECK((note.serial == "1" && note.certificate == "2" && note.calibrated_by == "3" && note.note == "6"));
  CHECK((note.calibrated_on == "2026-01-04" && note.due == "2027-01-05"));
  for (const char* wrong : {"laboratory = 5", "received = \"31.01.2026\"", "received = \"2026-13-01\"",
                            "country = \"de\"", "country = \"DEU\"", "[[instrument]]\nserial = \"\""})
    CHECK(file_refusal([&] { (void)bench::parse_laboratory("schema = 1\n" + std::string(wrong) + "\n", "f"); }).id ==
          "TB-FILE-VALUE");
}

TEST_CASE("operator profile: keys, environment variables, comma-separated names, units") {
  const std::vector<std::pair<ProfileKey, std::string>> words = {
      {ProfileKey::kBench, "bench"},   {ProfileKey::kDb, "db"},       {ProfileKey::kOperator, "operator"},
      {ProfileKey::kRecipe, "recipe"}, {ProfileKey::kUnits, "units"}, {ProfileKey::kLimits, "limits"},
      {ProfileKey::kLab, "lab"},       {ProfileKey::kFleet, "fleet"}};
  for (const auto& [key, word] : words) {
    CHECK(bench::to_string(key) == word);
    const bool has = key == ProfileKey::kBench || key == ProfileKey::kDb || key == ProfileKey::kFleet;
    std::string upper = word;
    std::ranges::transform(upper, upper.begin(), [](char c) { return static_cast<char>(c - 'a' + 'A'); });
    CHECK(bench::variable_of(key) == (has ? "TACTBENCH_" + upper : ""));
  }
  const auto recipes = [](const std::string& text) {
    return bench::parse_operator_profile("recipe = \"" + text + "\"\n", "f").at(ProfileKey::kRecipe).values;
  };
  using Names = std::vector<std::string>;
  CHECK(recipes("a") == Names{"a"});
  CHECK(recipes("a,b,c") == Names{"a", "b", "c"});
  CHECK(recipes(" \\t\\r\\na b \\t\\r\\n,b ") == Names{"a b", "b"});
  for (const char* empty : {"a,", ",a", "a,,b", "a, \\t\\r\\n,b", ","})
    CHECK_FALSE(file_is_taken([&] { (void)recipes(empty); }));
  for (const char* unit : {"kPa", "bar", "psi"})
    CHECK(bench::parse_operator_profile("units = \"" + std::string(unit) + "\"\n", "f").at(ProfileKey::kUnits).values ==
          Names{unit});
  CHECK_FALSE(file_is_taken([] { (void)bench::parse_operator_profile("units = \"mbar\"\n", "f"); }));
  const TemporaryFolder folder;
  const std::string path = folder.path("tactbench.toml");
  {
    const Variable fleet("TACTBENCH_FLEET", "f1"), other("TACTBENCH_OPERATOR", "nobody");
    const bench::OperatorProfile profile = bench::read_operator_profile(path);
    REQUIRE(profile.size() == 1);
    CHECK(profile.at(ProfileKey::kFleet).values == Names{"f1"});
  }
  std::filesystem::create_symlink("own", folder.path("own"));
  CHECK_FALSE(file_is_taken([&] { (void)bench::read_operator_profile(folder.path("own")); }));
}

TEST_CASE("shipped files: the search path, and an unknown name") {
  const TemporaryFolder folder;
  for (const char* name : {"sequences", "bench/config"}) std::filesystem::create_directories(folder.path(name));
  for (const char* name :
       {"sequences/ring.toml", "sequences/ascending.toml", "sequences/notes.txt", "bench/config/b.toml"})
    write_file(folder.path(name), "schema = 1\n");
  {
    const Variable empty("TACTBENCH_SHARE", "");
    CHECK(bench::share_folder() == bench::build_info().source_folder);
  }
  const Variable share("TACTBENCH_SHARE", folder.path());
  CHECK(bench::share_folder() == folder.path());
  CHECK(bench::shipped_files("sequences") == std::vector<std::string>{"ascending.toml", "ring.toml"});
  CHECK(bench::shipped_files("none").empty());
  CHECK(bench::find_recipe("ring") == folder.path() + "/sequences/ring.toml");
  CHECK(bench::find_recipe("ring.toml") == folder.path() + "/sequences/ring.toml");
  CHECK(bench::find_config("b.toml") == folder.path() + "/bench/config/b.toml");
  CHECK(bench::find_recipe("./none") == "./none");  // a path is nobody's shipped name
  CHECK(bench::find_recipe(folder.path("sequences/ring.toml")) == folder.path("sequences/ring.toml"));
  for (const char* name : {"rinq", ""})
    CHECK(file_refusal([&] { (void)bench::find_recipe(name); }).id == "TB-FILE-MISSING");
  CHECK(file_refusal([] { (void)bench::find_config("something-else"); }).id == "TB-FILE-MISSING");
  write_file(folder.path("here.toml"), "");
  const std::string before = std::filesystem::current_path();
  std::filesystem::current_path(folder.path());
  CHECK(bench::find_recipe("here.toml") == "here.toml");
  std::filesystem::current_path(before);
}
