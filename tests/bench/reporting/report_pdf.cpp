// PDF by programs that a test provides: which one is chosen, its arguments, and the error when it fails.
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include "bench/common/error.h"
#include "bench/reporting/report_pdf.h"
#include "tests/support/process.h"
#include "tests/support/variable.h"

using namespace tactbench::bench;
using namespace tactbench::tests;

namespace {

// Writes its date and words to `said` and a PDF to where its last word, or --print-to-pdf, says.
constexpr const char* kPrints =
    "#!/bin/sh\nprintf '%s\\n' \"$SOURCE_DATE_EPOCH\" \"$@\" >\"$SAID\"\nfor word in \"$@\"; do\n"
    "  case $word in --print-to-pdf=*) pdf=${word#*=} ;; esac\n  last=$word\ndone\n"
    "printf '%s' '%PDF-1.7 /CreationDate (D:19700101000000+00) /ModDate(D:19700101000000Z) /ModDate  x(D:1970' "
    ">\"${pdf:-$last}\"\n";

struct Programs {
  TemporaryFolder folder;
  Variable path{"PATH", "::" + folder.path("empty") + ":" + folder.path("bin")};
  Variable said{"SAID", folder.path("said")};
  PdfRequest request;

  Programs() {
    std::filesystem::create_directory(folder.path("bin"));
    request.html = "<p>page</p>";
    request.json = "{}";
    request.path = folder.path("out.pdf");
    request.date_utc = "2026-03-01T12:34:56Z";
  }
  void add(const std::string& name, const std::string& text) const {
    write_file(folder.path("bin/" + name), text);
    REQUIRE(chmod(folder.path("bin/" + name).c_str(), 0700) == 0);
  }
  [[nodiscard]] std::vector<std::string> words() const {
    std::istringstream lines(read_file(folder.path("said")));
    std::vector<std::string> found;
    for (std::string line; std::getline(lines, line);) found.push_back(line);
    return found;
  }
  // True where the PDF is refused.
  [[nodiscard]] bool refused() const {
    try {
      (void)write_pdf(request);
    } catch (const Error& error) {
      CHECK(error.id() == "TB-REPORT-PDF");
      CHECK(error.code() == ExitCode::kUsage);
      return true;
    }
    return false;
  }
};

}  // namespace

TEST_CASE("PDF by weasyprint: PDF/A with the data attached, dated as the report") {
  Programs programs;
  programs.add("weasyprint", kPrints);
  CHECK(write_pdf(programs.request) == programs.folder.path("bin/weasyprint"));
  const std::vector<std::string> words = programs.words();
  REQUIRE(words.size() == 7);
  CHECK(words[0] == "1772368496");  // 2026-03-01T12:34:56Z
  CHECK(words[1] == "--pdf-variant");
  CHECK(words[2] == "pdf/a-3b");
  CHECK(words[3] == "--attachment");
  CHECK(words[4].ends_with("/data.json"));
  CHECK(words[5].ends_with("/report.html"));
  CHECK(words[6].ends_with("/report.pdf"));
  CHECK_FALSE(std::filesystem::exists(words[6]));
  CHECK(read_file(programs.request.path) ==
        "%PDF-1.7 /CreationDate (D:20260301123456+00) /ModDate(D:20260301123456Z) /ModDate  x(D:1970");
  programs.request.date_utc = "2026-03-01";  // no time: a date that says nothing
  (void)write_pdf(programs.request);
  CHECK(programs.words()[0] == "946684800");  // 2000-01-01T00:00:00Z
}

TEST_CASE("PDF by a browser: preferred where both programs are installed, weasyprint on request") {
  Programs programs;
  programs.add("weasyprint", kPrints);
  programs.add("google-chrome", kPrints);
  CHECK(write_pdf(programs.request) == programs.folder.path("bin/google-chrome"));
  const std::vector<std::string> words = programs.words();
  REQUIRE(words.size() >= 9);
  CHECK(words[1] == "--headless");
  CHECK(words[7].starts_with("--print-to-pdf=/"));
  CHECK(words.back().starts_with("file:///"));
  CHECK(words.back().ends_with("/report.html"));
  CHECK(std::ranges::count(words, "--no-sandbox") == (geteuid() == 0 ? 1 : 0));
  programs.request.program = "weasyprint";
  CHECK(write_pdf(programs.request) == programs.folder.path("bin/weasyprint"));
  programs.request.program = "chromium";
  std::filesystem::remove(programs.folder.path("bin/google-chrome"));
  CHECK(programs.refused());
  programs.request.program.clear();
  std::filesystem::remove(programs.folder.path("bin/weasyprint"));
  CHECK(programs.refused());
}

TEST_CASE("PDF: a program that fails, writes nothing or no PDF is refused") {
  Programs programs;
  programs.add("weasyprint",
               "#!/bin/sh\nfor last in \"$@\"; do :; done\nprintf '%s' '%PDF-1.7' >\"$last\"\necho bad\nexit 3\n");
  CHECK(programs.refused());
  programs.add("weasyprint", "#!/bin/sh\nexit 0\n");
  CHECK(programs.refused());
  programs.add("weasyprint", "#!/bin/sh\nfor last in \"$@\"; do :; done\nprintf '%s' 'PDF-1.7' >\"$last\"\n");
  CHECK(programs.refused());
  programs.add("weasyprint", "#!/no/such/shell\n");
  CHECK(programs.refused());
  CHECK_FALSE(std::filesystem::exists(programs.request.path));
}
