// report list and report verify of a store whose signed reports are known row by row.
#include <catch2/catch.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bench/cli/reports/report_sign.h"
#include "db/sqlite.h"
#include "tests/bench/cli/store_here.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

// Two runs; of the first two signed reports, of the second, which is hardware's, one.
struct SignedStore : OpenStoreHere {
  SignedStore() {
    store_example(store);
    db::RunRecord other = example_run();
    other.origin = "hardware";
    store_example(store, other);
    store.add_report({1, "1-0000000a", "h", "K. Lee", "2026-01-02T00:00:00Z", "", ""});
    store.add_report({1, "1-0000000b", "i", "M. Ito", "2026-01-03T00:00:00Z", "1-0000000a", "serial corrected"});
    store.add_report({2,
                      "2-0000000c",
                      "j",
                      "K. Lee",
                      "2026-01-04T00:00:00Z",
                      "",
                      "",
                      {{2, store.run(2).content_sha256}, {1, store.run(1).content_sha256}}});
  }
  Finished reports(std::vector<std::string> words) const {
    words.insert(words.begin(), "report");
    return say(bench::add_report, words);
  }
  // The file of a report where `report` puts it, and its hash in the notes of the run.
  std::string write_report_file(std::int64_t run, const std::string& name, const std::string& number) {
    std::filesystem::create_directories(folder.path("reports"));
    std::string file = folder.path("reports/" + name);
    const std::string text = "<p>" + name + "</p><title>" + number + ", signed</title>";
    write_file(file, text);
    store.add_note(run, "2026-01-05T00:00:00Z " + bench::report_file_note(number, db::sha256_hex(text)));
    return file;
  }
};

}  // namespace

TEST_CASE("report list: shows each signed report with run, signer, replaced report and reason") {
  SignedStore store;
  CHECK_THAT(store.reports({"list", "3"}).err, Catch::Contains("[TB-STORE-NOT-FOUND]"));
  const std::string file = store.write_report_file(2, "run-2-0000000c.pdf", "2-0000000c");
  const auto printed = nlohmann::json::parse(store.reports({"list", "--json"}).out).at("reports");
  REQUIRE(printed.size() == 3);
  CHECK(printed.at(1) == nlohmann::json{{"number", "1-0000000b"},
                                        {"run", 1},
                                        {"sensor", "S-1"},
                                        {"origin", "simulated"},
                                        {"signed", "2026-01-03T00:00:00Z"},
                                        {"by", "M. Ito"},
                                        {"replaces", "1-0000000a"},
                                        {"reason", "serial corrected"},
                                        {"sha256", "i"},
                                        {"void_evidence", nlohmann::json::array()},
                                        {"file", ""}});
  CHECK(printed.at(2).at("file") == file);
  CHECK(nlohmann::json::parse(store.reports({"list", "1", "--json"}).out).at("reports").size() == 2);
}

TEST_CASE("report verify: rejects text that is neither file nor number, and reports unsigned numbers") {
  SignedStore store;
  for (const char* word : {"what", "1-0000000", "1-0000000aa", "-0000000a", "a-0000000a", "1-0000000g", "1-0000000A",
                           "10000000a", "", "1-"}) {
    INFO(word);
    check_refusal(verb_here(bench::add_report, {"report", "verify", "--db", store.path, "--", word}), 2, "TB-USAGE",
                  "report verify");
  }
  CHECK(store.reports({"verify", "1234567890-09afaf90"}).code == 1);
  const auto printed = nlohmann::json::parse(store.reports({"verify", "1-ffffffff", "--json"}).out);
  CHECK(printed.at("signed") == false);
  CHECK(printed.at("files").at(0).at("state") == "unknown");
  CHECK_FALSE(printed.contains("run"));
}

TEST_CASE("report verify: reports a file as unchanged, changed, of an earlier report, or missing") {
  SignedStore store;
  // The states of the files of a report, and the exit code.
  const auto states = [&](const std::string& named) {
    const Finished verified = store.reports({"verify", named, "--json"});
    std::string text = std::to_string(verified.code);
    const nlohmann::json printed = nlohmann::json::parse(verified.out);
    for (const auto& file : printed.at("files")) text += " " + file.at("state").get<std::string>();
    return text;
  };
  CHECK(store.reports({"verify", "1-0000000a"}).code == 6);
  const std::string page = store.write_report_file(2, "run-2-0000000c.html", "2-0000000c");
  CHECK(states("2-0000000c") == "0 unchanged");
  CHECK(states(page) == "0 unchanged");
  const std::string copy = store.write_report_file(2, "run-2-0000000c.json", "2-0000000c");
  CHECK(states("2-0000000c") == "0 unchanged unchanged");
  write_file(page, read_file(page) + " ");
  CHECK(states("2-0000000c") == "1 changed unchanged");
  // Signed by a program that kept no hash of the file.
  const std::string old = store.folder.path("old");
  write_file(old, "1-0000000a, signed");
  CHECK(store.reports({"verify", old}).code == 6);
  const std::string letter = store.folder.path("letter");
  write_file(letter, "dear diary");
  CHECK(store.reports({"verify", letter}).code == 6);
  const auto printed = nlohmann::json::parse(store.reports({"verify", page, "--json"}).out);
  CHECK(printed.at("files").at(0) ==
        nlohmann::json{{"file", page}, {"sha256", db::sha256_hex(read_file(page))}, {"state", "changed"}});
  CHECK(printed.at("replaced_by") == "");
  CHECK(nlohmann::json::parse(store.reports({"verify", old, "--json"}).out).at("replaced_because") ==
        "serial corrected");
}

TEST_CASE("report verify: a void run or a changed store outranks an unchanged file") {
  SignedStore store;
  const std::string page = store.write_report_file(2, "run-2-0000000c.html", "2-0000000c");
  store.store.void_run(2, "gauge closed", "K. Lee", kUtc);
  CHECK(store.reports({"verify", page}).code == 1);
  db::sqlite::Connection(store.path, db::sqlite::Access::kReadWrite)
      .execute(
          "UPDATE frames SET status = 9 WHERE frame / 1000000000 = 2; UPDATE reports SET approved_by = 'B' WHERE run "
          "= 2");
  CHECK(store.reports({"verify", page}).code == 1);
}

TEST_CASE("report verify: after voiding a run used as evidence, void names the signed reports and verify fails them") {
  SignedStore store;
  const std::string page = store.write_report_file(2, "run-2-0000000c.html", "2-0000000c");
  const auto evidence = [&](const std::string& in) {
    return nlohmann::json::parse(verb_here(bench::add_report, {"report", "verify", page, "--json", "--db", in}).out)
        .at("evidence")
        .at("state");
  };
  CHECK(evidence(store.path) == "holds");
  const auto voided =
      store.printed<nlohmann::json>(bench::add_runs, {"runs", "void", "1", "--reason", "gauge closed", "--by", "me"});
  CHECK(voided.at("signed_reports") == nlohmann::json{"1-0000000b", "2-0000000c"});
  CHECK(store.reports({"verify", page}).code == 1);
  CHECK(evidence(store.path) == "fallen");
  CHECK(nlohmann::json::parse(store.reports({"list", "2", "--json"}).out)
            .at("reports")
            .at(0)
            .at("void_evidence")
            .size() == 1);
  // A copy without the run on which it was judged cannot be checked.
  const std::string copy = store.folder.path("copy.db");
  db::RunStore::open(copy).copy_runs_from(store.store, {2});
  CHECK(evidence(copy) == "unknown");
}

TEST_CASE("report signing: the hash of a report file is stored once, and only for signed reports") {
  SignedStore store;
  bench::Session session;
  session.db = store.path;
  const std::string file = store.folder.path("r.html");
  write_file(file, "page");
  const auto notes = [&] { return store.store.run(1).notes; };
  const std::string before = notes();
  bench::record_signed_file(file, "1-ffffffff", 1, session);
  bench::record_signed_file(file + ".none", "1-0000000a", 1, session);
  CHECK(notes() == before);
  bench::record_signed_file(file, "1-0000000a", 1, session);
  const std::string kept = notes();
  CHECK(kept != before);
  bench::record_signed_file(file, "1-0000000a", 1, session);
  CHECK(notes() == kept);
}
