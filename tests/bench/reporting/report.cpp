// What a report's input holds of runs and judgements, and what is charted of a sensor. On runs of one taxel that are
// stored by hand.

#include <fmt/format.h>
#include <qpdf/qpdf-c.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>
#include <catch2/catch.hpp>

#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include "analysis/identify/stored/model_document.h"
#include "analysis/report/report_facts.h"
#include "bench/common/build_info.h"
#include "bench/common/error.h"
#include "bench/config/config.h"
#include "bench/reporting/evaluation.h"
#include "bench/reporting/report_pdf.h"
#include "bench/reporting/study_roles.h"
#include "tests/bench/reporting/film_runs.h"
#include "tests/support/endless_run.h"
#include "tests/support/process.h"
#include "tests/support/text.h"
#include "tests/support/variable.h"

using namespace tactbench;
using namespace tactbench::bench;
using namespace tactbench::tests;

namespace {

bench::JudgementRecord judged_by(analysis::Runs& runs, const analysis::SensorModel& models,
                                 const std::vector<bench::NamedEvaluation>& evaluations,
                                 const std::vector<analysis::InstrumentNote>& notes = {}) {
  bench::JudgementRecord judged{{}, film_limits(100.0), {}};
  judged.evidence = bench::gather_evidence(runs, models, evaluations, judged.limits, false, notes);
  judged.judgement = judge(judged.evidence, judged.limits);
  return judged;
}

}  // namespace

TEST_CASE("report input: has the run, its evaluation, held-out runs with titles, and valid verdicts") {
  JudgedStore made(4);
  analysis::Runs runs(made.store);
  const analysis::SensorModel models = film_line_model();
  const auto evaluations = bench::evaluate_runs(runs, models, {3, 2}, {"warmer"});
  const analysis::ReportInput input =
      bench::report_input(runs, 1, models, evaluations, judged_by(runs, models, evaluations), {4});
  CHECK(input.run.run == 1);
  CHECK(input.evaluation.run == 1);
  CHECK(input.evaluation.mean_error_psi == evaluations[0].evaluation.mean_error_psi);
  REQUIRE(input.held_out.size() == 2);
  CHECK(input.held_out[0].title == "warmer");
  CHECK(input.held_out[0].run.run == 3);
  CHECK(input.held_out[0].evaluation.run == 3);
  CHECK(input.held_out[1].run.run == 2);
  CHECK(input.judgement.figures.size() == 8);
  CHECK(input.judgement.runs.size() == 2);
  CHECK(input.judgement.not_assessed.size() == 5);
  REQUIRE(input.further.size() == 1);
  CHECK(input.further[0].run == 4);
  CHECK(input.program_version == bench::build_info().version);
  CHECK(input.method.size() == 1);
  CHECK(input.frame_count == 26);
  CHECK_FALSE(input.uncertainty);
  const analysis::ReportInput bare = bench::report_input(runs, 2, {}, {}, {});
  CHECK(bare.run.run == 2);
  CHECK(bare.held_out.empty());
  CHECK(bare.evaluation.levels.empty());
}

TEST_CASE("report input: the laboratory is included, and its due dates withhold verdicts") {
  JudgedStore made(2);
  analysis::Runs runs(made.store);
  const analysis::SensorModel models = film_line_model();
  bench::ReportExtras extras;
  extras.unit = analysis::PressureUnit::kKilopascal;
  extras.laboratory.place = "hall 2";
  extras.laboratory.instruments = {{"R-1", "", "", "", "2026-02-01", ""}};
  const bench::JudgementRecord judged =
      judged_by(runs, models, bench::evaluate_runs(runs, models, {2}), extras.laboratory.instruments);
  // Of a run without evaluations, so that no other models are made.
  const analysis::ReportInput input = bench::report_input(runs, 1, models, {}, judged, {}, &extras);
  CHECK(input.unit == analysis::PressureUnit::kKilopascal);
  CHECK(input.laboratory.place == "hall 2");
  REQUIRE(input.judgement.figures.size() == 4);
  CHECK(input.judgement.figures[0].verdict == analysis::Verdict::kInconclusive);
  CHECK(input.judgement.figures[3].verdict == analysis::Verdict::kPass);
  CHECK(input.judgement.untraced->overdue_since == "2026-02-01");
  CHECK_FALSE(input.uncertainty);
  CHECK(input.evaluation.levels.empty());
}

TEST_CASE("sensor trend: values come from the models in use for a run, grouped by its recipes") {
  FilmStore made;
  FilmRun two;
  two.levels = kFilmInnerLoop;
  two.sequences = {"up"};
  REQUIRE(made.add(two) == 1);
  analysis::Runs runs(made.store);
  const analysis::SensorModel elam = bench::fit_run(made.store, runs.dataset(1));
  CHECK(elam.fit == 1);
  const analysis::Evaluation own = analysis::evaluate(runs.dataset(1), elam);
  db::RunRecord run = made.store.run(1);
  run.sequences.push_back({1, "down", "", "", 1, 1});
  CHECK(bench::record_sensor_trend(made.store, run, elam, own) == "sensor/S-1/up+down");
  CHECK(made.store.figures_of(1, "sensor/S-1/up+down").at("mean_error_psi") == own.mean_error_psi);
  run.sensor_serial.clear();
  CHECK(bench::record_sensor_trend(made.store, run, elam, own).empty());
  const auto subjects = [&] { return made.store.subjects_of(1); };
  CHECK(subjects() == std::vector<std::string>{"sensor/S-1/up+down"});
  bench::record_fit_trend(made.store, elam, own);
  CHECK(subjects() == std::vector<std::string>{"sensor/S-1/up", "sensor/S-1/up+down"});
  made.store.replace_figures(1, "sensor/S-1/up", {});
  analysis::SensorModel other = film_line_model();
  other.fit = analysis::store_fit(made.store, other, "1", "2026-03-01T02:00:00Z");
  bench::record_fit_trend(made.store, other, own);
  CHECK(made.store.figures_of(1, "sensor/S-1/up").empty());
  const analysis::SensorModel dynamic = bench::fit_run_dynamic(made.store, runs, 1);
  CHECK(dynamic.content_sha256 == made.store.run(1).content_sha256);
  CHECK(dynamic.program_version == bench::build_info().version);
  const analysis::Evaluation of_dynamic = analysis::evaluate(runs.dataset(1), dynamic);
  bench::record_fit_trend(made.store, dynamic, of_dynamic);
  CHECK(made.store.figures_of(1, "sensor/S-1/up/dynamic").at("mean_error_psi") == of_dynamic.mean_error_psi);
}

// PDF by programs that a test provides: which one is chosen, the words that it is started with, dates digit by digit,
// the error when it fails, and processes that it leaves behind.

namespace {

// Programs in the folder bin, which print the file `pdf` of the folder.
struct PdfByScript {
  TemporaryFolder folder;
  Variable path{"PATH", "::" + folder.path("empty") + ":" + folder.path("bin")};
  Variable here{"HERE", folder.path()};
  PdfRequest request;

  PdfByScript() {
    std::filesystem::create_directory(folder.path("bin"));
    write_file(folder.path("pdf"), "%PDF-");
    request.html = "<title>1-ab</title><p>page</p>";
    request.run_uuid = "u-1";
    request.path = folder.path("out.pdf");
    request.date_utc = "2026-03-01T12:34:56Z";
  }
  void write(const std::string& name, const std::string& text) const {
    write_file(folder.path("bin/" + name), text);
    REQUIRE(::chmod(folder.path("bin/" + name).c_str(), 0700) == 0);
  }
  void add(const std::string& name, const std::string& more = {}) const {
    write(name,
          "#!/bin/sh\nPATH=/usr/bin:/bin\nprintf '%s\\n' \"$SOURCE_DATE_EPOCH\" \"$@\" >\"$HERE/said\"\n"
          "for word in \"$@\"; do\n  case $word in --print-to-pdf=*) pdf=${word#*=} ;; esac\n  last=$word\ndone\n" +
              more + "cp \"$HERE/pdf\" \"${pdf:-$last}\"\n");
  }
  void remove(const std::string& name) const { std::filesystem::remove(folder.path("bin/" + name)); }
  // The name of the program that made it; "" where the PDF is refused.
  [[nodiscard]] std::string made_by() const {
    try {
      return std::filesystem::path(write_pdf(request)).filename();
    } catch (const Error& error) {
      CHECK(error.id() == "TB-REPORT-PDF");
      CHECK(error.code() == ExitCode::kUsage);
      return {};
    }
  }
  // The text after the dates are set.
  [[nodiscard]] std::string dated(const std::string& text) const {
    write_file(folder.path("pdf"), "%PDF-" + text);
    (void)write_pdf(request);
    return read_file(request.path).substr(5);
  }
  [[nodiscard]] std::vector<std::string> said() const { return lines_of(read_file(folder.path("said"))); }
};

}  // namespace

TEST_CASE("PDF by weasyprint: of the page alone, dated as the report") {
  PdfByScript made;
  made.add("weasyprint");
  CHECK(write_pdf(made.request) == made.folder.path("bin/weasyprint"));
  const std::vector<std::string> words = made.said();
  REQUIRE(words.size() == 3);
  const std::string folder = std::filesystem::path(words[2]).parent_path();
  CHECK(words == std::vector<std::string>{"1772368496", folder + "/report.html", folder + "/report.pdf"});
  CHECK_FALSE(std::filesystem::exists(folder));
}

TEST_CASE("PDF dates: only complete dates close behind the two date keys are replaced") {
  PdfByScript made;
  made.add("weasyprint");
  const std::string old = "(D:19700101000000", now = "(D:20260301123456";
  CHECK(made.dated("/ModDate" + old) == "/ModDate" + now);
  CHECK(made.dated("/ModDate  " + old) == "/ModDate  " + now);
  CHECK(made.dated("/ModDate   " + old) == "/ModDate   " + old);
  CHECK(made.dated("/CreationDate  " + old + ")") == "/CreationDate  " + now + ")");
  CHECK(made.dated("/CreationDate   " + old + ")") == "/CreationDate   " + old + ")");
  CHECK(made.dated("/ModDate(D:1970010100000") == "/ModDate(D:1970010100000");
  CHECK(made.dated("/ModDate x/ModDate" + old + "/ModDate" + old) == "/ModDate x/ModDate" + now + "/ModDate" + now);
  CHECK(made.dated("/OtherDate" + old + " none") == "/OtherDate" + old + " none");
}

TEST_CASE("PDF dates: the date of the document is used, an incomplete one gives a fixed date") {
  PdfByScript made;
  made.add("weasyprint");
  const std::string old = "/ModDate(D:19700101000000)";
  const auto both = [&](const char* utc) {
    made.request.date_utc = utc;
    const std::string text = made.dated(old);
    return made.said().at(0) + " " + text.substr(11, 14);
  };
  CHECK(both("2009-09-09T09:09:09Z") == "1252487349 20090909090909");
  CHECK(both("2000-01-02T03:04:05Z") == "946782245 20000102030405");
  CHECK(both("1999-12-31T23:59:59") == "946684799 19991231235959");  // the shortest
  CHECK(both("1999-12-31T23:59:5") == "946684800 20000101000000");
  CHECK(both("") == "946684800 20000101000000");
  // More digits and fewer: the document keeps its length.
  CHECK(both("1999-12-31T23:59:59.125Z") == "946684799 19991231235959");
  CHECK(read_file(made.request.path).size() == 5 + old.size());
  CHECK(both("1999-12-31 about noon") == "946598400 19991231000000");
}

TEST_CASE("PDF by a browser: options, private profile and temporary folder, which is removed afterwards") {
  PdfByScript made;
  made.add("chromium-browser", "folder=${last#file://}\ncp \"$folder\" \"$HERE/page\"\n");
  CHECK(write_pdf(made.request) == made.folder.path("bin/chromium-browser"));
  const std::vector<std::string> words = made.said();
  const std::string& last = words.back();
  REQUIRE(last.starts_with("file:///"));
  const std::string folder = last.substr(7, last.size() - 7 - std::string("/report.html").size());
  std::vector<std::string> expected = {"1772368496",
                                       "--headless",
                                       "--disable-gpu",
                                       "--no-first-run",
                                       "--disable-dev-shm-usage",
                                       "--no-pdf-header-footer",
                                       "--user-data-dir=" + folder + "/profile",
                                       "--print-to-pdf=" + folder + "/report.pdf"};
  if (::geteuid() == 0) expected.emplace_back("--no-sandbox");
  expected.push_back("file://" + folder + "/report.html");
  CHECK(words == expected);
  CHECK(read_file(made.folder.path("page")) == "<title>1-ab, run u-1</title><p>page</p>");
  CHECK_FALSE(std::filesystem::exists(folder));
}

TEST_CASE("PDF: prefers a browser to weasyprint, by order of names, or uses the requested program if present") {
  PdfByScript made;
  for (const char* name : {"weasyprint", "google-chrome-stable", "google-chrome", "chromium-browser"}) made.add(name);
  CHECK(made.made_by() == "chromium-browser");
  made.add("chromium");
  CHECK(made.made_by() == "chromium");
  made.request.program = "weasyprint";
  CHECK(made.made_by() == "weasyprint");
  made.request.program.clear();
  for (const char* name : {"chromium", "chromium-browser", "google-chrome"}) made.remove(name);
  CHECK(made.made_by() == "google-chrome-stable");
  made.remove("google-chrome-stable");
  CHECK(made.made_by() == "weasyprint");
  made.request.program = "chromium";
  CHECK(made.made_by().empty());
  made.request.program.clear();
  made.remove("weasyprint");
  CHECK(made.made_by().empty());
}

TEST_CASE("PDF: a program that fails, is killed, or writes no PDF is an error") {
  PdfByScript made;
  const std::string to_last = "#!/bin/sh\nfor last in \"$@\"; do :; done\nprintf '%s' ";
  for (const std::string& script : {to_last + "'%PDF-1.7' >\"$last\"\nexit 3\n", std::string("#!/bin/sh\nexit 0\n"),
                                    to_last + "'PDF-1.7' >\"$last\"\n", std::string("#!/no/such/shell\n"),
                                    to_last + "'%PDF-1.7' >\"$last\"\nkill -9 $$\n"}) {
    INFO(script);
    made.write("weasyprint", script);
    CHECK(made.made_by().empty());
    CHECK_FALSE(std::filesystem::exists(made.request.path));
  }
}

TEST_CASE("PDF: a file of another kind is overwritten on request only") {
  PdfByScript made;
  made.add("weasyprint");
  write_file(made.request.path, "diary");
  CHECK_THROWS_AS(write_pdf(made.request), Error);
  made.request.replace = true;
  (void)write_pdf(made.request);
  CHECK(read_file(made.request.path) == "%PDF-");
}

TEST_CASE("PDF: processes left running by the program are ended") {
  PdfByScript made;
  made.add("weasyprint", "sleep 600 &\nprintf %s $! >\"$HERE/left\"\n");
  (void)made.dated("x");
  const std::string left = read_file(made.folder.path("left"));
  const bool ended = process_ends(left);
  CHECK(ended);
  if (!ended) ::kill(static_cast<pid_t>(std::stol(left)), SIGKILL);
}

// Files attached to a PDF: found by a PDF's reader, byte for byte, with what they are to it; the same bytes each time.

namespace {

// One empty page; `names`: of the catalogue.
std::string small_pdf(const std::string& names) {
  return "%PDF-1.4\n1 0 obj <</Type/Catalog/Pages 2 0 R" + names +
         ">> endobj\n2 0 obj <</Type/Pages/Kids[3 0 R]/Count 1>> endobj\n3 0 obj <</Type/Page/Parent 2 0 R/MediaBox[0 "
         "0 9 9]>> endobj\ntrailer <</Size 4/Root 1 0 R/Info<</Title(1-2ccd46bc, signed)>>>>\n%%EOF\n";
}

struct ReadPdf {
  explicit ReadPdf(const std::string& bytes) {
    qpdf_silence_errors(data);
    (void)qpdf_read_memory(data, "test", bytes.data(), bytes.size(), nullptr);
    REQUIRE(qpdf_has_error(data) == QPDF_FALSE);
  }
  ~ReadPdf() { qpdf_cleanup(&data); }
  ReadPdf(const ReadPdf&) = delete;
  ReadPdf& operator=(const ReadPdf&) = delete;
  [[nodiscard]] qpdf_oh at(qpdf_oh from, const std::vector<std::string>& keys) const {
    for (const std::string& key : keys) from = qpdf_oh_get_key(data, from, key.c_str());
    return from;
  }
  [[nodiscard]] std::string text(qpdf_oh from, const char* key) const {
    const qpdf_oh value = qpdf_oh_get_key(data, from, key);
    return qpdf_oh_is_name(data, value) == QPDF_TRUE ? qpdf_oh_get_name(data, value)
                                                     : qpdf_oh_get_utf8_value(data, value);
  }
  [[nodiscard]] std::string content(qpdf_oh file) const {
    unsigned char* bytes = nullptr;
    std::size_t size = 0;
    QPDF_BOOL filtered = QPDF_FALSE;
    (void)qpdf_oh_get_stream_data(data, at(file, {"/EF", "/F"}), qpdf_dl_generalized, &filtered, &bytes, &size);
    std::string text(reinterpret_cast<const char*>(bytes), size);
    std::free(bytes);
    return text;
  }
  qpdf_data data = qpdf_init();
};

}  // namespace

TEST_CASE("files attached to a PDF are read back, by name and as its associated data, in either order") {
  const PdfAttachment json{"report.json", "application/json", "all data", "{\"a\":1}\n"};
  const PdfAttachment xml{"certificate.xml", "application/xml", "ärgerlich",
                          std::string(70000, 'x') + std::string(1, '\0')};
  for (const char* names : {"", "/Names<</Dests<<>>>>"}) {
    const std::string made = with_attachments(small_pdf(names), {json, xml});
    CHECK(made == with_attachments(small_pdf(names), {xml, json}));
    CHECK(made.substr(0, 8) == "%PDF-1.7");
    CHECK(made.find("1-2ccd46bc, signed") != std::string::npos);  // signed_report_in() looks for it
    const ReadPdf pdf(made);
    const qpdf_oh root = qpdf_get_root(pdf.data), tree = pdf.at(root, {"/Names", "/EmbeddedFiles", "/Names"}),
                  associated = pdf.at(root, {"/AF"});
    CHECK((qpdf_oh_has_key(pdf.data, pdf.at(root, {"/Names"}), "/Dests") == QPDF_TRUE) == (*names != '\0'));
    REQUIRE(qpdf_oh_get_array_n_items(pdf.data, tree) == 4);
    REQUIRE(qpdf_oh_get_array_n_items(pdf.data, associated) == 2);
    int at = 0;
    for (const PdfAttachment* own : {&xml, &json}) {  // a name tree rises
      CHECK(qpdf_oh_get_utf8_value(pdf.data, qpdf_oh_get_array_item(pdf.data, tree, 2 * at)) == own->name);
      const qpdf_oh file = qpdf_oh_get_array_item(pdf.data, associated, at++);
      CHECK(pdf.text(file, "/UF") == own->name);
      CHECK(pdf.text(file, "/Desc") == own->description);
      CHECK(pdf.text(file, "/AFRelationship") == "/Data");
      const qpdf_oh facts = qpdf_oh_get_dict(pdf.data, pdf.at(file, {"/EF", "/F"}));
      CHECK(pdf.text(facts, "/Subtype") == "/" + own->mime);
      CHECK(pdf.content(file) == own->bytes);
    }
  }
  CHECK_THROWS_AS(with_attachments("%PDF-1.4\ndear diary", {json}), Error);
}

// The method in words: sweeps, levels, waiting times, conditioning, from the recipe and what was set.

namespace {

db::RunRecord run_of(const std::string& recipe_toml, const std::string& overrides = "[]") {
  db::RunRecord run;
  run.overrides_json = overrides;
  run.sequences = {{0, "a", recipe_toml, "", 1, 1}};
  return run;
}

std::string shipped_text(const std::string& recipe) { return tests::read_file(find_recipe(recipe)); }

}  // namespace

TEST_CASE("method text: states the settings of the recipe and its overrides") {
  const std::string toml = shipped_text("descending");
  REQUIRE(method_descriptions(run_of(toml)).size() == 1);
  const std::string set = method_descriptions(run_of(toml, R"([{"key":"recipe.dwell_s","value":"2.5"},)"
                                                           R"({"key":"recipe.repeats","value":"1"}])"))
                              .front();
  CHECK_THAT(set, Catch::StartsWith("1 ") && Catch::Contains("2.5 s"));
  CHECK(method_descriptions(run_of("no recipe")) == std::vector<std::string>{""});
}
