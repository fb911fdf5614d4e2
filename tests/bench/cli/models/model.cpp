// model show, diff and adjust and fit --check by answers that are worked out by hand from straight lines.

#include <fmt/format.h>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include <cstdint>
#include <memory>
#include <sstream>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "analysis/compensate/compensator.h"
#include "analysis/error.h"
#include "analysis/models/linearised.h"
#include "analysis/report/document/document.h"
#include "analysis/text_width.h"
#include "bench/cli/models/live.h"
#include "bench/cli/models/model_table.h"
#include "bench/cli/runs/source.h"
#include "tests/analysis/compensate/kinds.h"
#include "tests/bench/cli/models/known_model.h"
#include "tests/bench/cli/verb_here.h"
#include "tests/support/text.h"

using namespace tactbench;
using namespace tactbench::bench;
using namespace tactbench::tests;

namespace {

// Taxels 0 to 5, each a straight line whose fit left 0.5 % of its full scale of 8 V.
SensorModel six_lines() {
  SensorModel document = known_model(0.1, 0.0);
  document.columns = 6;
  document.sensor_serial.clear();
  document.validity.input = analysis::Range{0.0, 64.0};
  document.taxels.clear();
  for (int taxel = 0; taxel < 6; ++taxel) {
    ModelTaxel& own = document.taxels.emplace_back(taxel_with(taxel, {}));
    own.fit.model = straight_line();
    own.fit.full_scale = 8.0;
    own.fit.mean_error = 0.04;
  }
  return document;
}

// Outputs of taxel t lie `off` x (t + 1) above its line, and every other one `ripple` higher, the others lower.
std::string moved_table(double off, double ripple = 0.0, double gain = 1.0) {
  std::string text = "taxel,input,output\n";
  for (int taxel = 0; taxel < 6; ++taxel) {
    int number = 0;
    for (const double input : {0.0, 16.0, 32.0, 48.0, 64.0, 48.0, 32.0, 16.0, 0.0})
      text += fmt::format("{},{},{:.6f}\n", taxel, input,
                          gain * 0.125 * input + off * (taxel + 1) + (number++ % 2 == 0 ? ripple : -ripple));
  }
  return text;
}

const std::vector<std::string> kUnits = {"--input-unit", "N", "--output-unit", "V"};

struct FolderOfLines {
  explicit FolderOfLines(const std::string& table) {
    write_model(folder, "m.json", six_lines());
    write_file(folder.path("t.csv"), table);
  }
  Finished say(std::vector<std::string> words) const {
    words.insert(words.end(), kUnits.begin(), kUnits.end());
    return model_verb(folder, std::move(words));
  }
  TemporaryFolder folder;
};

}  // namespace

TEST_CASE("model check: gives the mean over the taxels, and the zero and gain of each taxel") {
  const FolderOfLines of(moved_table(0.08));  // 1 % of full scale for the first taxel to 6 % for the last
  well(of.say({"model", "check", "m.json", "t.csv"}));
  const nlohmann::json as_json = nlohmann::json::parse(of.say({"model", "check", "m.json", "t.csv", "--json"}).out);
  CHECK(as_json.at("schema") == "tactbench.model.check");
  CHECK(as_json.at("verdict") == "re-zero enough");
  CHECK(as_json.at("as_is_fs").get<double>() == Approx(0.035));
  CHECK(as_json.at("tolerance_fs").get<double>() == Approx(0.01));
  CHECK(as_json.at("zeroed_fs").get<double>() == Approx(0.0).margin(1e-9));
  CHECK(as_json.at("adjusted_fs").get<double>() == Approx(0.0).margin(1e-9));
  REQUIRE(as_json.at("taxels").size() == 6);
  for (int taxel = 0; taxel < 6; ++taxel) {
    const nlohmann::json& one = as_json.at("taxels").at(static_cast<std::size_t>(taxel));
    CHECK(one.at("taxel") == taxel);
    CHECK(one.at("zero").get<double>() == Approx(0.08 * (taxel + 1)));
    CHECK(one.at("zero_with_gain").get<double>() == Approx(0.08 * (taxel + 1)));
    CHECK(one.at("gain").get<double>() == Approx(1.0));
    CHECK(one.at("as_is_fs").get<double>() == Approx(0.01 * (taxel + 1)));
    for (const char* none : {"zero_u", "gain_u", "zeroed_fs", "adjusted_fs"})
      CHECK(one.at(none).get<double>() == Approx(0.0).margin(1e-9));
  }
}

TEST_CASE("model check: exit code 1 if no zero and gain correct the deviation, 0 if a gain does") {
  const FolderOfLines noisy(moved_table(0.0, 0.4));  // 5 % of full scale, now up, now down
  CHECK(noisy.say({"model", "check", "m.json", "t.csv"}).code == 1);
  CHECK(noisy.say({"model", "check", "m.json", "t.csv", "--json"}).code == 1);
  const FolderOfLines steeper(moved_table(0.0, 0.0, 1.25));
  const Finished gain = steeper.say({"model", "check", "m.json", "t.csv"});
  CHECK(gain.code == 0);
  CHECK(gain.out.find("validity") == std::string::npos);
}

TEST_CASE("model adjust: stores zero and gain of every taxel, and does not overwrite a file of another kind") {
  const FolderOfLines of(moved_table(0.08));
  const Finished zero = of.say({"model", "adjust", "m.json", "t.csv", "--zero", "-o", "c.json"});
  CHECK(zero.code == 0);
  const SensorModel parent = analysis::load_model(of.folder.path("m.json"), nullptr);
  const SensorModel child = analysis::load_model(of.folder.path("c.json"), nullptr);
  CHECK(child.parent_sha256 == analysis::sha256_of(parent));
  CHECK_FALSE(child.program_version.empty());
  for (int taxel = 0; taxel < 6; ++taxel) CHECK(child.taxel(taxel).zero == Approx(0.08 * (taxel + 1)));
  const Finished again = of.say({"model", "adjust", "m.json", "t.csv", "--zero", "-o", "c.json"});
  CHECK(again.code == 0);  // the same model's file
  write_file(of.folder.path("notes.csv"), "mine\n");
  const Finished kept = of.say({"model", "adjust", "none.json", "t.csv", "--zero", "-o", "notes.csv"});
  CHECK(kept.code == 2);  // before the model is looked for
  CHECK(kept.err.find("none.json") == std::string::npos);
  CHECK(read_file(of.folder.path("notes.csv")) == "mine\n");
  const Finished none = model_verb(of.folder, {"model", "export", "none.json", "-o", "x.json"});
  CHECK(none.code != 0);
  CHECK(model_verb(of.folder, {"model", "export", "m.json", "-o", "notes.csv"}).code == 2);
  const FolderOfLines steeper(moved_table(0.0, 0.0, 1.25));
  const nlohmann::json gain = nlohmann::json::parse(
      steeper.say({"model", "adjust", "m.json", "t.csv", "--gain", "-o", "c.json", "--json"}).out);
  CHECK(gain.at("schema") == "tactbench.model.adjust");
  CHECK(gain.at("sha256") == analysis::sha256_of(analysis::load_model(steeper.folder.path("c.json"), nullptr)));
  CHECK(analysis::load_model(steeper.folder.path("c.json"), nullptr).taxel(3).gain == Approx(1.25));
}

TEST_CASE("model show: --json prints the model document, and model export writes the same document") {
  const FolderOfLines of(moved_table(0.08));
  const std::string document = model_verb(of.folder, {"model", "show", "m.json", "--json"}).out;
  REQUIRE(model_verb(of.folder, {"model", "export", "m.json", "-o", "c.json"}).code == 0);
  CHECK(read_file(of.folder.path("c.json")) == document);
  SensorModel last_dead = known_model(0.1, 0.0);
  last_dead.taxels.resize(2);
  write_model(of.folder, "dead.json", last_dead);
  CHECK(model_verb(of.folder, {"model", "show", "dead.json"}).code == 0);
}

TEST_CASE("model export --format c: a folder of ELAM, replaced only when asked, of a count that is known") {
  const FolderOfLines of(moved_table(0.08));
  write_file(of.folder.path("e.json"), analysis::to_text(synthetic::sensor_of(synthetic::kinds().front())));
  const auto exported = [&](std::vector<std::string> more) {
    std::vector<std::string> words = {"model",   "export", "e.json", "--format", "c", "-o", of.folder.path("robot"),
                                      "--scans", "2"};
    words.insert(words.end(), more.begin(), more.end());
    return model_verb(of.folder, std::move(words));
  };
  check_refusal(exported({}), 2, "TB-MODEL-FIXED", "");
  const std::vector<std::string> count = {"--per-count", "8e-5"};
  REQUIRE(exported(count).code == 0);
  CHECK_FALSE(read_file(of.folder.path("robot/robot.ino")).empty());
  const Finished again = exported(count);
  CHECK(again.code == 2);
  CHECK_THAT(again.err, Catch::Contains("TB-FILE-EXISTS"));
  CHECK(exported({"--per-count", "8e-5", "--replace"}).code == 0);
  check_refusal(model_verb(of.folder, {"model", "export", "m.json", "--format", "c", "-o", of.folder.path("no"),
                                       "--per-count", "8e-5"}),
                2, "TB-MODEL-FIXED", "");
  write_file(of.folder.path("v.csv"), "output\n0.2\n0.2\n");
  const auto read_by = [&](const char* taxel) {
    return model_verb(of.folder, {"compensate", "e.json", "v.csv", "--as", "fixed", "--taxel", taxel, "--scans", "2",
                                  "--per-count", "8e-5"});
  };
  CHECK(read_by("0").code == 0);
  check_refusal(read_by("mean"), 2, "TB-MODEL-TAXEL", "--taxel");
}

TEST_CASE("model adjust: needs --zero or --gain, and model check reports samples outside the validity range") {
  const FolderOfLines of(moved_table(0.08) + "0,70,8.8\n");
  check_refusal(of.say({"model", "adjust", "m.json", "t.csv", "-o", "c.json"}), 2, "TB-USAGE", "model adjust");
  const nlohmann::json printed = nlohmann::json::parse(of.say({"model", "check", "m.json", "t.csv", "--json"}).out);
  CHECK(printed.at("outside_validity").size() == 1);
}

TEST_CASE("model diff: a model without divider is compared as one with 0, creep and lag only if both have them") {
  const TemporaryFolder folder;
  // The mean difference, the largest one and its taxel.
  const auto difference = [&](const std::string& first, const std::string& second, const std::string& name) {
    const auto printed = nlohmann::json::parse(model_verb(folder, {"model", "diff", first, second, "--json"}).out);
    for (const auto& one : printed.at("parameters"))
      if (one.at("name") == name)
        return std::tuple(one.at("mean").get<double>(), one.at("largest").get<double>(), one.at("taxel").get<int>());
    return std::tuple(0.0, 0.0, -9);  // not among them
  };
  const auto check = [&](const std::string& first, const std::string& second, const std::string& name, double mean,
                         double largest, int taxel) {
    INFO(name);
    const auto [found_mean, found_largest, found_taxel] = difference(first, second, name);
    CHECK(found_mean == Approx(mean));
    CHECK(found_largest == Approx(largest));
    CHECK(found_taxel == taxel);
  };
  SensorModel plain = known_model(0.1, 0.0), divided = known_model(0.1, 0.0);
  for (ModelTaxel& taxel : divided.taxels) {
    if (taxel.fit.model == nullptr) continue;
    analysis::Divider divider;
    divider.per_amplitude = taxel.taxel == 2 ? 0.25 : 0.125;
    const analysis::MpiParameters own = {0.1, -0.001, 0.0, 3.0, taxel.taxel < 0 ? 5.0 : 0.7};
    taxel.fit.model =
        std::make_unique<analysis::LinearisedModel>(divider, std::make_shared<analysis::MpiModel>(own, 0.0, 60.0, 0.0));
  }
  write_model(folder, "plain.json", plain);
  write_model(folder, "divided.json", divided);
  check("plain.json", "divided.json", "c", 0.5 / 3.0, 0.25, 2);
  check("plain.json", "divided.json", "a1", 0.0, 0.0, 0);
  check("divided.json", "plain.json", "c", -0.5 / 3.0, -0.25, 2);
  SensorModel early = known_model(0.1, 0.0), late = known_model(0.1, 0.0);
  for (SensorModel* model : {&early, &late}) model->dynamics.emplace();
  late.taxels[0].creep_scale = 1.5;
  late.taxels[2].lag_share = 0.25;
  late.taxels[2].gain = 1.25;
  write_model(folder, "early.json", early);
  write_model(folder, "late.json", late);
  check("early.json", "late.json", "gain", 0.25 / 3.0, 0.25, 2);
  check("early.json", "late.json", "creep_scale", 0.5 / 3.0, 0.5, 0);
  check("early.json", "late.json", "lag_share", 0.25 / 3.0, 0.25, 2);
  CHECK(std::get<2>(difference("early.json", "plain.json", "creep_scale")) == -9);
  CHECK(std::get<2>(difference("plain.json", "early.json", "lag_share")) == -9);
  // A taxel that only one of them could fit, or has.
  SensorModel fewer = known_model(0.1, 0.0);
  fewer.taxels[0].status = analysis::TaxelStatus::kDead;
  fewer.taxels[0].fit.model.reset();
  fewer.taxels.erase(fewer.taxels.begin() + 2);
  write_model(folder, "fewer.json", fewer);
  const auto first_alone = [&](const std::string& first, const std::string& second) {
    const Finished printed = model_verb(folder, {"model", "diff", first, second, "--json"});
    CHECK(printed.code == 1);
    return nlohmann::json::parse(printed.out).at("taxels_of_first_alone");
  };
  CHECK(first_alone("plain.json", "fewer.json") == 2);
  CHECK(first_alone("fewer.json", "plain.json") == 0);
}

TEST_CASE("model diff: parameters of inputs in different units are not compared") {
  const TemporaryFolder folder;
  SensorModel pressures = known_model(0.04, 0.25);
  pressures.input_unit = "psi";
  write_model(folder, "psi.json", pressures);
  write_model(folder, "n.json", known_model(0.1, 0.0));
  const nlohmann::json printed =
      nlohmann::json::parse(model_verb(folder, {"model", "diff", "n.json", "psi.json", "--json"}).out);
  CHECK((printed["parameters"][2]["unit"] == "V/N" && printed["parameters"][2]["unit_of_second"] == "V/psi"));
  CHECK((printed["parameters"][2]["mean"].is_null() && printed["parameters"][2]["largest"].is_null()));
  CHECK(printed["parameters"][0]["mean"].get<double>() == Approx(0.25 / 3.0));
}

// The models of a run that `runs show` lists, of a store whose models are known.

namespace {

// Runs 1 and 3 have models, run 2 none.
struct StoreOfModels : OpenStoreHere {
  StoreOfModels() {
    for (int run = 0; run < 3; ++run) (void)store_example(store);
    add(1, "elam", 3);
    add(1, "dynamic", 5);
    add(3, "a long name of a model", 0);
    add(3, "gpi", 0);
  }
  void add(std::int64_t run, const std::string& model, int fitted) {
    (void)store.add_fit({0, run, model, true, fitted, "{}", "", "0.9.1", kUtc});
  }
};

}  // namespace

TEST_CASE("runs show: lists each model of the run with its number, kind and number of fitted taxels") {
  const StoreOfModels of;
  const auto models = [&](const char* run) {
    return nlohmann::json::parse(of.say(bench::add_runs, {"runs", "show", run, "--json"}).out).at("models");
  };
  REQUIRE(models("1").size() == 2);
  const nlohmann::json second = models("1").at(1);
  CHECK((second.at("model") == "1:2" && second.at("kind") == "dynamic" && second.at("fitted_taxels") == 5));
  CHECK(models("2").empty());
  CHECK(models("3").size() == 2);
  check_refusal(of.say(bench::add_model, {"model", "show", "2"}), 6, "TB-ANALYSIS-NO-FIT");
}

// The rows of models: which are left out and which errors end the fit, and a row as JSON.

namespace {

analysis::Histories histories_of(const std::vector<double>& turns) {
  const TemporaryFolder folder;
  std::string text = "input,output\n";
  for (const PlaySample& sample : play_samples(turns))
    text += std::to_string(sample.input) + "," + std::to_string(sample.output) + "\n";
  write_file(folder.path("t.csv"), text);
  Session session;
  session.quiet = true;
  return read_source(folder.path("t.csv"), {}, session);
}

analysis::ModelTaxel fitted_taxel(int number) {
  analysis::ModelTaxel taxel = taxel_with(number, {0.1, 0.0, 0.0, 3.0, 5.0});
  taxel.fit.samples = 7;
  taxel.fit.starts = 3;
  return taxel;
}

// The data on which models are scored: tables need only its validity.
analysis::Histories one_taxel() {
  analysis::Histories histories;
  analysis::TaxelHistories& taxel = histories.taxels.emplace_back();
  taxel.score.push_back({"up", {0.0, 30.0, 60.0}, {0.0, 1.0, 2.0}, {}});
  taxel.fit = taxel.score;
  return histories;
}

// Taxels 0 and 2, a dead one between them, and the mean taxel.
ModelRow row_of_array() {
  ModelRow row;
  row.label = "mpi";
  row.crossed = {0.5, 0.3, 5};
  row.document.model = "mpi";
  row.document.taxels.push_back(fitted_taxel(0));
  row.document.taxels.emplace_back();
  row.document.taxels.back().status = analysis::TaxelStatus::kDead;
  row.document.taxels.push_back(fitted_taxel(2));
  row.document.taxels.push_back(fitted_taxel(analysis::kMeanTaxel));
  analysis::ModelScore score;
  score.count = 2;
  score.full_scale = 2.0;
  score.taxels.direct = {0.3, 0.2, 6};
  score.taxels.free_running = {0.6, 0.3, 6};
  score.taxels.compensated = {3.0, 1.5, 6};
  score.taxels.raw = {6.0, 2.25, 6};
  score.taxels.by_hold = {{0.1, 1.0, {1.0, 0.5, 2}}, {1.0, 10.0, {2.0, 1.5, 4}}};
  score.taxels.by_rate = {{1.0, 2.0, {1.0, 0.5, 2}}};
  score.mean.compensated = {0.6, 0.4, 3};
  score.mean.raw = {1.5, 0.75, 3};
  row.scores.push_back(score);
  return row;
}

}  // namespace

TEST_CASE("model table: a row as JSON has the shown taxel, its parameters and its scores") {
  const analysis::Histories histories = one_taxel();
  const nlohmann::ordered_json row = model_row_json(row_of_array(), {{"run 2", &histories, {}}});
  CHECK(row["model"] == "mpi");
  CHECK(row["fit"] == 0);
  const auto& shown = row["shown_taxel"];
  check_members(shown, R"({"taxel": -1, "j": 2.5, "samples": 7, "starts": 3, "operations_per_sample": 56})");
  CHECK(shown["cross_validated"]["mean"].get<double>() == Approx(0.1));
  CHECK(shown["cross_validated"]["max"] == 0.3);
  REQUIRE(shown["parameters"].size() == 5);
  CHECK(shown["parameters"][4]["name"] == "tau");
  CHECK(shown["parameters"][4]["at_bound"] == true);
  CHECK(shown["parameters"][3]["at_bound"] == false);
  const auto& score = row["scores"][0];
  check_members(score, R"({"on": "run 2", "taxels": 2, "full_scale": 2.0})");
  CHECK(score["all"]["direct"]["mean"].get<double>() == Approx(0.05));
  CHECK(score["all"]["free_running"]["mean"].get<double>() == Approx(0.1));
  CHECK(score["all"]["free_running"]["max"] == 0.3);
  CHECK(score["outside_validity"].empty());
  CHECK(score["all"]["by_hold_s"][1]["low"] == 1.0);
  CHECK(score["all"]["by_hold_s"][1]["compensated"]["mean"] == 0.5);
  CHECK(score["mean_taxel"]["raw"]["max"] == 0.75);
  ModelRow alone = row_of_array();
  alone.crossed = {};
  CHECK_FALSE(model_row_json(alone, {{"run 2", &histories, {}}})["shown_taxel"].contains("cross_validated"));
}

TEST_CASE(
    "model table: a model that the data do not support is left out if another one fits, other errors are thrown") {
  const analysis::Histories loops = histories_of({0, 10, 0, 10, 5, 10, 0});
  std::vector<ModelRefusal> refusals;
  std::vector<std::string> begun;
  const auto begin = [&](const std::string& model) { begun.push_back(model); };
  const std::vector<ModelRow> rows = model_rows({"nonsense", "monotone"}, loops, {}, {}, {}, &refusals, begin);
  REQUIRE(rows.size() == 1);
  CHECK(rows[0].label == "monotone");
  CHECK_FALSE(rows[0].document.program_version.empty());
  REQUIRE(refusals.size() == 1);
  CHECK(refusals[0].model == "nonsense");
  CHECK(begun == std::vector<std::string>{"nonsense", "monotone"});
  const auto id = [&](const std::vector<std::string>& models, const std::vector<std::string>& sequences,
                      std::vector<ModelRefusal>* left_out) -> std::string {
    try {
      (void)model_rows(models, loops, sequences, {}, {}, left_out);
    } catch (const analysis::AnalysisError& error) {
      return error.id();
    }
    return "";
  };
  CHECK(id({"monotone", "nonsense"}, {}, &refusals).empty());  // the last, and there is a row
  CHECK(id({"nonsense"}, {}, &refusals) == "TB-ANALYSIS-MODEL");
  CHECK(id({"nonsense", "monotone"}, {}, nullptr) == "TB-ANALYSIS-MODEL");
  const std::string other = id({"monotone", "poly"}, {"none"}, &refusals);
  CHECK_FALSE(other.empty());
  CHECK((other != "TB-ANALYSIS-MODEL" && other != "TB-ANALYSIS-NO-LOOP"));
}

TEST_CASE("model table: fits the width of the terminal, however large the numbers are") {
  const analysis::Histories histories = one_taxel();
  for (const double factor : {1.0, 1e3, 1e20, 1e300}) {
    ModelRow row = row_of_array();
    analysis::ModelScore& score = row.scores.front();
    for (analysis::ErrorSum* error : {&score.taxels.direct, &score.taxels.free_running, &score.taxels.compensated,
                                      &score.mean.compensated, &row.crossed}) {
      error->sum *= factor;
      error->max *= factor;
    }
    analysis::doc::Document out = fits_document({row}, true);
    out.add(scores_document({row}, {{"run 2", &histories, {}}}, "N", {}, true));
    for (const std::size_t width : {80U, 120U}) {
      for (const std::string& line : lines_of(to_text(out, {}, width))) CHECK(analysis::display_width(line) <= width);
    }
  }
}

// A compensated frame as `live` sums it up and writes it, of frames that are known number by number.

namespace {

struct FrameByHand {
  std::vector<float> psi, uncertainty;
  std::vector<std::uint16_t> status;
  [[nodiscard]] LiveFrame frame() const { return {7, 1.5, psi, uncertainty, status, 123.4}; }
};

}  // namespace

TEST_CASE("live: a frame is summarised over the taxels that are not dead, the first of equal maxima is the highest") {
  const FrameByHand of = {{99.0F, -4.0F, 2.0F, 8.0F, 8.0F, 6.0F},
                          {0.5F, 0.25F, 0.125F, 0.5F, 0.5F, 0.5F},
                          {analysis::kTaxelDead, analysis::kTaxelFlat, analysis::kTaxelValid,
                           analysis::kTaxelUnknown | analysis::kTaxelOutOfRange, analysis::kTaxelLost,
                           analysis::kTaxelOutside | analysis::kTaxelFlat}};
  const FrameSummary sum = summed(of.frame());
  CHECK(sum.mean_psi == 4.0);
  CHECK(sum.highest_psi == 8.0);
  CHECK(sum.highest == 3);
  CHECK((sum.flags.flat == 2 && sum.flags.unknown == 1 && sum.flags.out_of_range == 1 && sum.flags.dead == 1));
  CHECK((sum.flags.lost == 1 && sum.flags.outside == 1));
  CHECK(frame_rows(of.frame()) ==
        "7,1.500000,0,99.0000,0.5000,8\n7,1.500000,1,-4.0000,0.2500,2\n7,1.500000,2,2.0000,0.1250,1\n"
        "7,1.500000,3,8.0000,0.5000,36\n7,1.500000,4,8.0000,0.5000,64\n7,1.500000,5,6.0000,0.5000,18\n");
  const FrameByHand negative = {{-3.0F, -1.0F}, {0.5F, 0.5F}, {1, 1}};
  CHECK(summed(negative.frame()).highest_psi == -1.0);
  CHECK(summed(negative.frame()).highest == 1);
  const FrameByHand below = {{-1.0F, -3.0F}, {0.5F, 0.5F}, {1, 1}};
  CHECK(summed(below.frame()).highest_psi == -1.0);
  CHECK(summed(below.frame()).mean_psi == -2.0);
  const FrameByHand dead = {{5.0F}, {0.5F}, {analysis::kTaxelDead}};
  CHECK(summed(dead.frame()).mean_psi == 0.0);
  CHECK(summed(dead.frame()).highest_psi == 0.0);
  CHECK(summed(dead.frame()).highest == 0);
}

TEST_CASE("live: the JSON document has the summary and the last frame") {
  LiveSummary summary;
  summary.frames = 1;
  summary.lost = 2;
  summary.other_scanner = true;
  summary.outside = {"scanner A (fitted on B)"};
  summary.median_us = 10.4;
  summary.p99_us = 20.6;
  summary.worst_us = 30.0;
  summary.compensation_median_us = 4.25;
  FrameSummary last;
  last.mean_psi = 1.5;
  last.highest_psi = 2.5;
  last.flags = {1, 2, 3, 4, 5, 6};
  CHECK(live_json(summary, last) == nlohmann::ordered_json::parse(R"text({
    "other_scanner": true, "outside_validity": ["scanner A (fitted on B)"], "frames": 1, "lost_frames": 2,
    "latency_us": {"median": 10.4, "p99": 20.6, "worst": 30.0, "compensation_median": 4.25},
    "last_frame": {"mean_psi": 1.5, "highest_psi": 2.5, "flat": 1, "unknown": 2, "out_of_range": 3, "dead": 4,
                   "outside_validity": 6, "lost": 5}})text"));
}
