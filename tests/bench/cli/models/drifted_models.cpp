// What model show, model adjust and fit --check tell as JSON, of a table and the same table a constant higher.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "analysis/identify/stored/model_document.h"
#include "tests/bench/cli/play_table.h"
#include "tests/bench/cli/verb_here.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

std::string raised_table(double by, double factor = 1.0) {
  std::string text = "input,output\n";
  for (const PlaySample& sample : play_samples({0, 10, 0, 10, 5, 10, 0}))
    text += std::to_string(sample.input) + "," + std::to_string(by + factor * sample.output) + "\n";
  return text;
}

struct ModelOfTable {
  ModelOfTable() {
    write_file(table, raised_table(0.0));
    write_file(raised, raised_table(0.5));
    write_file(beyond, raised_table(0.5) + "12,14\n");
    REQUIRE(verb_here(bench::add_fit, {"fit", table, "--model", "preisach", "-q", "-o", model}).code == 0);
  }
  Finished say(std::vector<std::string> words) const { return verb_here(bench::add_model, std::move(words)); }
  TemporaryFolder folder;
  std::string table = folder.path("t.csv"), raised = folder.path("r.csv"), beyond = folder.path("b.csv"),
              model = folder.path("m.json"), child = folder.path("c.json");
};

}  // namespace

TEST_CASE("model show --json prints the model's document, and model export writes the same") {
  const ModelOfTable of;
  const std::string document = read_file(of.model);
  CHECK(of.say({"model", "show", of.model, "--json"}).out == document);
  REQUIRE(of.say({"model", "export", of.model, "-o", of.child}).code == 0);
  CHECK(read_file(of.child) == document);
}

TEST_CASE("model adjust: the zero, or zero and gain, in words and as JSON, and nothing without either") {
  const ModelOfTable of;
  const Finished neither = of.say({"model", "adjust", of.model, of.raised, "-o", of.child});
  CHECK(neither.code == 2);
  CHECK(neither.err ==
        "error: nothing to adjust is named [TB-USAGE]\n  at: model adjust\n  try: add --zero, or --gain\n");
  const nlohmann::json zero =
      nlohmann::json::parse(of.say({"model", "adjust", of.model, of.raised, "--zero", "-o", of.child, "--json"}).out);
  CHECK(zero.at("path") == of.child);
  CHECK(zero.at("parent_sha256").get<std::string>().size() == 64);
  CHECK(zero.at("parent_sha256") != zero.at("sha256"));
  REQUIRE(zero.at("drift").at("taxels").size() == 1);
  const nlohmann::json& taxel = zero.at("drift").at("taxels").at(0);
  CHECK(taxel.at("taxel") == 0);
  CHECK(taxel.at("zero").get<double>() == Approx(0.5).margin(0.01));
  CHECK(taxel.at("zero_with_gain").get<double>() == Approx(0.5).margin(0.1));
  CHECK(taxel.at("gain").get<double>() == Approx(1.0).margin(0.02));
  CHECK(taxel.at("as_is_fs").get<double>() > taxel.at("zeroed_fs").get<double>());
  CHECK(zero.at("drift").at("zeroed_fs") == taxel.at("zeroed_fs"));
  const Finished told = of.say({"model", "adjust", of.model, of.raised, "--zero", "-o", of.child});
  CHECK_THAT(told.out,
             Catch::StartsWith(of.child + ": ") && Catch::Contains("\n  mean residual on " + of.raised + ": ") &&
                 Catch::EndsWith("; parent " + zero.at("parent_sha256").get<std::string>().substr(0, 12) + "\n"));
  const auto percent = [](const nlohmann::json& share) { return fmt::format("{:.3f}", 100.0 * share.get<double>()); };
  const nlohmann::json& drift = zero.at("drift");
  CHECK_THAT(told.out, Catch::Contains(of.raised + ": " + percent(drift.at("as_is_fs")) + " % FS before, " +
                                       percent(drift.at("zeroed_fs")) + " after; "));
  const Finished gain = of.say({"model", "adjust", of.model, of.raised, "--gain", "-o", of.child});
  CHECK(gain.code == 0);
  CHECK_THAT(gain.out, Catch::Contains(" % FS before, " + percent(drift.at("adjusted_fs")) + " after; "));
  const Finished shown = of.say({"model", "show", of.child});
  CHECK_THAT(shown.out,
             Catch::Contains("\n  parent        " + zero.at("parent_sha256").get<std::string>().substr(0, 12) + ": "));
  const std::size_t parameters = analysis::load_model(of.child, nullptr).taxels.back().fit.model->parameters().size();
  REQUIRE(parameters > 24);
  CHECK_THAT(shown.out, Catch::EndsWith("\n  and " + std::to_string(parameters - 24) + " more (--json)\n"));
}

TEST_CASE("fit --check: a good model and a drifted one, what lies outside, in words and as JSON") {
  const ModelOfTable of;
  const auto check = [&](const std::string& table, const std::vector<std::string>& more = {}) {
    std::vector<std::string> words = {"fit", table, "--check", of.model};
    words.insert(words.end(), more.begin(), more.end());
    return verb_here(bench::add_fit, words);
  };
  const Finished good = check(of.table);
  CHECK(good.code == 0);
  CHECK_THAT(good.out, Catch::StartsWith("preisach of " + of.table + " on " + of.table + ": ") &&
                           Catch::Contains("\n  mean residual of 1 taxel, % FS: as it is ") &&
                           !Catch::Contains("outside the model's validity"));
  CHECK_THAT(check(of.beyond).out, Catch::Contains("\n  outside the model's validity: "));
  const nlohmann::json told = nlohmann::json::parse(check(of.beyond, {"--json"}).out);
  CHECK(told.at("outside_validity").size() == 1);
  CHECK(told.at("taxels").size() == 1);
  const nlohmann::json raised = nlohmann::json::parse(check(of.raised, {"--json"}).out);
  CHECK(raised.at("outside_validity").empty());
  CHECK(raised.at("as_is_fs").get<double>() > 10.0 * raised.at("zeroed_fs").get<double>());
  CHECK(raised.at("tolerance_fs").get<double>() > 0.0);
  const auto percent = [&](const char* name) { return fmt::format("{:.3f}", 100.0 * raised.at(name).get<double>()); };
  const std::string words = check(of.raised).out;
  CHECK_THAT(words, Catch::Contains("\n  mean residual of 1 taxel, % FS: as it is " + percent("as_is_fs") +
                                    ", re-zeroed " + percent("zeroed_fs") + ", with gain " + percent("adjusted_fs") +
                                    " (tolerance " + percent("tolerance_fs") + ")\n"));
  const nlohmann::json& taxel = raised.at("taxels").at(0);
  const auto with_u = [&](const char* name, const char* u) {
    return fmt::format("{:.5f} +- {:.5f}", taxel.at(name).get<double>(), taxel.at(u).get<double>());
  };
  CHECK_THAT(words, Catch::EndsWith(fmt::format("\n       0{:>24}{:>24}{:>10}\n", with_u("zero_with_gain", "zero_u"),
                                                with_u("gain", "gain_u"), percent("as_is_fs"))));
}
