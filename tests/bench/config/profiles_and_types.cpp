#include <catch2/catch.hpp>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include "bench/common/build_info.h"
#include "bench/config/config.h"
#include "bench/config/config_laboratory.h"
#include "bench/config/config_profile.h"
#include "bench/config/operator_profile.h"
#include "devices/wire/modbus/modbus_value.h"
#include "sequences/toml/pressure_text.h"
#include "sequences/toml/strict_toml.h"
#include "tests/bench/config/bench_text.h"
#include "tests/support/process.h"
#include "tests/support/variable.h"

using bench::OperatorProfile;
using bench::ProfileKey;
using bench::read_module_profile;
using namespace tactbench::tests;
using namespace tactbench;
using tests::Variable;

namespace {

std::string error_of(const std::string& name) {
  try {
    (void)read_module_profile(name);
  } catch (const sequences::FileError& error) {
    return error.id() + " " + error.what() + " " + error.remedy();
  }
  return "none";
}

}  // namespace

TEST_CASE("module profiles: the addresses of the EK9000") {
  const auto profile = read_module_profile("beckhoff-ek9000");
  CHECK(profile.tcp);
  CHECK_FALSE(profile.rtu);
  CHECK(profile.inputs.address == 0x0000);
  CHECK(profile.outputs.address == 0x0800);
  CHECK(profile.outputs.function == 23);
  CHECK(profile.fail_safe.watchdog_address == 0x1120);
  CHECK(profile.fail_safe.fallbacks_address == 0x1021);
  CHECK(profile.fail_safe.layers.size() == 2);
}

TEST_CASE("module profiles: each shipped one is read, and has outputs or inputs") {
  const auto names = bench::shipped_profiles();
  CHECK(names.size() >= 7);
  for (const std::string& name : names) {
    INFO(name);
    const auto profile = read_module_profile(name);
    CHECK(profile.name == name);
    CHECK(profile.outputs.channels + profile.inputs.channels > 0);
  }
}

TEST_CASE("module profiles: ADAM, Moxa and Waveshare have the addresses of the manuals") {
  const auto adam = read_module_profile("advantech-adam-6024");
  CHECK(adam.outputs.address == 40011 - 40001);
  CHECK(adam.inputs.address + adam.inputs.status_offset == 40021 - 40001);
  const auto moxa = read_module_profile("moxa-iologik-e1241");
  CHECK(moxa.outputs.address == 41025 - 40001);
  CHECK(moxa.fail_safe.safe_mode_address == 0x1010);
  CHECK(moxa.fail_safe.safe_mode_clear_address == 0x1020);
  const auto waveshare = read_module_profile("waveshare-analog-output-8ch-b");
  CHECK_FALSE(waveshare.tcp);
  CHECK(waveshare.outputs.volts.raw(1.0) == 1000.0);  // 01 06 00 00 03 E8: 1 V
  CHECK(waveshare.fail_safe.layers.empty());
}

TEST_CASE("module profiles: an unknown name, an invalid function and an unknown key are reported") {
  CHECK_THAT(error_of("beckhof-ek9000"), Catch::Contains("TB-MODULE-PROFILE"));
  const tests::TemporaryFolder folder;
  const auto write = [&](const std::string& text) {
    const std::string path = folder.path() + "/mine.toml";
    std::ofstream(path) << "schema = 1\nmodel = \"mine\"\ntransport = \"any\"\n" << text;
    return path;
  };
  CHECK_THAT(error_of(write("[outputs]\nchannels = 1\nfunction = 15\n")), Catch::Contains("6, 16, 23"));
  CHECK_THAT(error_of(write("[outputs]\nchannels = 1\nadress = 3\n")), Catch::Contains("adress"));
  CHECK_THAT(error_of(write("[outputs]\nchannels = 1\nvolts_span = [2, 10]\n")), Catch::Contains("0 V"));
  CHECK_THAT(error_of(write("[outputs]\nchannels = 1\nfunction = 23\n")), Catch::Contains("23"));
  CHECK(error_of(write("[inputs]\nchannels = 1\n")) == "none");
}

TEST_CASE("module profiles: defaults, and values that are rejected") {
  const tests::TemporaryFolder folder;
  const std::string path = folder.path("mine.toml");
  const auto told = [&](const std::string& text) {
    std::ofstream(path) << "schema = 1\nmodel = \"mine\"\ntransport = \"any\"\n" << text;
    return error_of(path);
  };
  REQUIRE(told("[outputs]\nchannels = 1\n[inputs]\nchannels = 2\n") == "none");
  const auto profile = read_module_profile(path);
  CHECK(profile.tcp);
  CHECK(profile.rtu);
  CHECK(profile.max_reply_delay == std::chrono::seconds(1));
  CHECK(profile.outputs.function == 16);
  CHECK(profile.outputs.address == 0);
  CHECK(profile.outputs.readback == 3);
  CHECK(profile.outputs.volts.raw(10.0) == 32767.0);
  CHECK(profile.outputs.volts.raw(0.0) == 0.0);
  CHECK(profile.inputs.function == 4);
  CHECK(profile.inputs.address == 0);
  CHECK(profile.fail_safe.watchdog_address == -1);
  CHECK(profile.fail_safe.fallbacks_address == -1);
  CHECK(profile.fail_safe.safe_mode_address == -1);
  CHECK(profile.fail_safe.safe_mode_clear_address == -1);
  const std::string outputs = "[outputs]\nchannels = 1\n", inputs = "[inputs]\nchannels = 1\n";
  for (const std::string& wrong :
       {outputs + "readback_function = 6", inputs + "function = 16", outputs + "volts_span = [-10, 0]",
        outputs + "volts_span = [0.1, 10]", outputs + "raw_span = [-1, 100]", outputs + "raw_span = [0, 65536]",
        std::string("[outputs]\nchannels = 121"), std::string("[inputs]\nchannels = 61"), inputs + "spare = 9",
        outputs + "address = 65536", outputs + "deadline_ms = 0.5", "max_reply_delay_ms = 60001\n" + outputs}) {
    INFO(wrong);
    CHECK(told(wrong + "\n") != "none");
  }
  CHECK(told(outputs + "volts_span = [-10, 10]\nraw_span = [0, 65535]\n") == "none");
  CHECK(told(inputs + "raw_span = [-32768, 32767]\nvolts_span = [-10, 10]\n") == "none");
  REQUIRE(told("max_reply_delay_ms = 20\n" + outputs + "deadline_ms = 30\n") == "none");
  CHECK(read_module_profile(path).max_reply_delay == std::chrono::milliseconds(20));
  CHECK(read_module_profile(path).outputs.deadline == std::chrono::milliseconds(30));
}

// tactbench.toml and the environment: what they give, which precedes, and what is refused.

namespace {

OperatorProfile profile_of(const std::string& text) {
  const tests::TemporaryFolder folder;
  tests::write_file(folder.path("tactbench.toml"), text);
  return bench::read_operator_profile(folder.path("tactbench.toml"));
}

void check_refused(const std::string& text, const std::string& id, const std::string& where) {
  try {
    static_cast<void>(profile_of(text));
    FAIL("was taken: " << text);
  } catch (const sequences::FileError& error) {
    CAPTURE(error.what(), error.remedy(), error.where());
    CHECK(error.id() == id);
    CHECK(error.where().find(where) != std::string::npos);
  }
}

}  // namespace

TEST_CASE("operator profile: each value has its line, recipe holds one name or several") {
  const OperatorProfile profile =
      profile_of("bench = \"rig.toml\"\n\noperator = \"A. Person\"\nrecipe = \"descending, ascending\"\n");
  REQUIRE(profile.size() == 3);
  CHECK(profile.at(ProfileKey::kBench).values == std::vector<std::string>{"rig.toml"});
  CHECK(profile.at(ProfileKey::kBench).origin.ends_with("tactbench.toml:1"));
  CHECK(profile.at(ProfileKey::kOperator).values == std::vector<std::string>{"A. Person"});
  CHECK(profile.at(ProfileKey::kOperator).origin.ends_with("tactbench.toml:3"));
  CHECK(profile.at(ProfileKey::kRecipe).values == std::vector<std::string>{"descending", "ascending"});
  CHECK(profile_of("recipe = \"ring\"\n").at(ProfileKey::kRecipe).values == std::vector<std::string>{"ring"});
}

TEST_CASE("operator profile: the environment outranks the file for each key, a blank variable is ignored") {
  const Variable bench("TACTBENCH_BENCH", "other.toml"), db("TACTBENCH_DB", " ");
  const OperatorProfile profile = profile_of("bench = \"rig.toml\"\ndb = \"mine.db\"\nlimits = \"l.toml\"\n");
  CHECK(profile.at(ProfileKey::kBench).values == std::vector<std::string>{"other.toml"});
  CHECK(profile.at(ProfileKey::kBench).origin == "TACTBENCH_BENCH");
  CHECK(profile.at(ProfileKey::kDb).values == std::vector<std::string>{"mine.db"});
  CHECK(profile.at(ProfileKey::kDb).origin.ends_with("tactbench.toml:2"));
  CHECK(profile.at(ProfileKey::kLimits).values == std::vector<std::string>{"l.toml"});
}

TEST_CASE("operator profile: an unknown key is reported with its line, a blank or invalid value is rejected") {
  check_refused("bench = \"a\"\noperater = \"me\"\n", "TB-FILE-KEY", "tactbench.toml:2");
  check_refused("[run]\nbench = \"a\"\n", "TB-FILE-KEY", "tactbench.toml:1");
  check_refused("operator = \" \"\n", "TB-FILE-VALUE", "tactbench.toml:1");
  check_refused("db = 7\n", "TB-FILE-VALUE", "tactbench.toml:1");
  check_refused("recipe = [\"ring\"]\n", "TB-FILE-VALUE", "tactbench.toml:1");
  check_refused("recipe = \"ring, \"\n", "TB-FILE-VALUE", "tactbench.toml:1");
  check_refused("bench = \n", "TB-FILE-SYNTAX", "tactbench.toml:1");
}

// Sensor types, limits, profiles and shipped files: each number and word as it is read, and what is said of wrong ones.

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
