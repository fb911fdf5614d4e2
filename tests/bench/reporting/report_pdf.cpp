// PDF by programs that a test provides: which one is chosen, the words that it is started with, dates digit by digit,
// the error when it fails, and processes that it leaves behind.
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include "bench/common/error.h"
#include "bench/reporting/report_pdf.h"
#include "tests/support/endless_run.h"
#include "tests/support/process.h"
#include "tests/support/variable.h"

using namespace tactbench::bench;
using namespace tactbench::tests;

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
  [[nodiscard]] std::vector<std::string> said() const {
    std::istringstream lines(read_file(folder.path("said")));
    std::vector<std::string> found;
    for (std::string line; std::getline(lines, line);) found.push_back(line);
    return found;
  }
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
