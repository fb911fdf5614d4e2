#include "bench/cli/report_pdf.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string_view>
#include <thread>
#include <vector>

#include "bench/cli/session.h"

extern char** environ;

namespace tactbench::bench {

namespace {

namespace fs = std::filesystem;

constexpr auto kPdfDeadline = std::chrono::seconds(120);

[[noreturn]] void pdf_failed(const std::string& what, const std::string& where, const std::string& remedy) {
  throw Error(ExitCode::kUsage, "TB-REPORT-PDF", what, where, remedy);
}

// A folder that goes with it.
class PdfFolder {
 public:
  PdfFolder() {
    std::string name = (fs::temp_directory_path() / "tactbench-pdf-XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) pdf_failed("cannot make a folder", name, "check space and permissions");
    path_ = name;
  }
  ~PdfFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  PdfFolder(const PdfFolder&) = delete;
  PdfFolder& operator=(const PdfFolder&) = delete;
  [[nodiscard]] std::string file(const char* name) const { return (path_ / name).string(); }

 private:
  fs::path path_;
};

std::string in_path(const std::string& program) {
  const char* path = std::getenv("PATH");
  std::istringstream folders(path == nullptr ? "" : path);
  for (std::string folder; std::getline(folders, folder, ':');) {
    std::string candidate = (fs::path(folder) / program).string();
    if (!folder.empty() && ::access(candidate.c_str(), X_OK) == 0) return candidate;
  }
  return {};
}

struct PdfProgram {
  std::string path;
  bool browser = true;
};

PdfProgram find_pdf_program(const std::string& wanted) {
  if (wanted != "weasyprint") {
    for (const char* name : {"chromium", "chromium-browser", "google-chrome", "google-chrome-stable"}) {
      if (const std::string path = in_path(name); !path.empty()) return {path, true};
    }
  }
  if (wanted != "chromium") {
    if (const std::string path = in_path("weasyprint"); !path.empty()) return {path, false};
  }
  pdf_failed(fmt::format("no program that prints HTML as PDF is installed{}{}", wanted.empty() ? "" : ": ", wanted),
             "--format pdf",
             "apt-get install chromium (or weasyprint), or write --format html and print it from a browser");
}

std::vector<std::string> words_of(const PdfProgram& program, const PdfFolder& folder) {
  const std::string html = folder.file("report.html"), pdf = folder.file("report.pdf");
  if (!program.browser) {
    return {program.path, "--pdf-variant", "pdf/a-3b", "--attachment", folder.file("data.json"), html, pdf};
  }
  std::vector<std::string> words = {program.path,
                                    "--headless",
                                    "--disable-gpu",
                                    "--no-first-run",
                                    "--disable-dev-shm-usage",
                                    "--no-pdf-header-footer",
                                    "--user-data-dir=" + folder.file("profile"),
                                    "--print-to-pdf=" + pdf};
  if (::geteuid() == 0) words.emplace_back("--no-sandbox");  // the sandbox refuses root
  words.push_back("file://" + html);
  return words;
}

std::string text_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

std::string digits_of(const std::string& utc) {
  if (utc.size() < 19) return "20000101000000";
  std::string digits;
  for (const char c : utc)
    if (c >= '0' && c <= '9') digits += c;
  digits.resize(14, '0');
  return digits;
}

// Our environment, with the date of the document for programs that ask for one.
std::vector<std::string> environment_at(const std::string& utc) {
  std::vector<std::string> entries;
  for (char** entry = environ; *entry != nullptr; ++entry)
    if (std::string_view(*entry).rfind("SOURCE_DATE_EPOCH=", 0) != 0) entries.emplace_back(*entry);
  const std::string digits = digits_of(utc);
  const auto number = [&](std::size_t from, std::size_t count) { return std::stoi(digits.substr(from, count)); };
  std::tm time{};
  time.tm_year = number(0, 4) - 1900;
  time.tm_mon = number(4, 2) - 1;
  time.tm_mday = number(6, 2);
  time.tm_hour = number(8, 2);
  time.tm_min = number(10, 2);
  time.tm_sec = number(12, 2);
  entries.push_back(fmt::format("SOURCE_DATE_EPOCH={}", ::timegm(&time)));
  return entries;
}

std::vector<char*> pointers_to(std::vector<std::string>& words) {
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  return pointers;
}

// True when it ended by itself with 0. A process group of its own: at the deadline all of it goes.
bool run_to_end(std::vector<std::string> words, const std::string& log, const std::string& utc) {
  std::vector<std::string> environment = environment_at(utc);
  const std::vector<char*> pointers = pointers_to(words), variables = pointers_to(environment);
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, log.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0600);
  posix_spawn_file_actions_adddup2(&files, STDOUT_FILENO, STDERR_FILENO);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setpgroup(&attributes, 0);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  pid_t child = -1;
  const int failed = posix_spawn(&child, pointers.front(), &files, &attributes, pointers.data(), variables.data());
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&files);
  if (failed != 0) return false;
  const auto deadline = std::chrono::steady_clock::now() + kPdfDeadline;
  int status = 0;
  while (::waitpid(child, &status, WNOHANG) == 0) {
    if (std::chrono::steady_clock::now() > deadline) {
      ::kill(-child, SIGKILL);
      ::waitpid(child, &status, 0);
      return false;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  ::kill(-child, SIGKILL);  // what it may have left behind
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

// "D:20240506070809+00'00'" where `field` has a date of the clock; digits only change, so that offsets hold.
void set_pdf_date(std::string& pdf, const std::string& field, const std::string& utc) {
  const std::string digits = digits_of(utc);
  for (std::size_t at = pdf.find(field); at != std::string::npos; at = pdf.find(field, at + 1)) {
    const std::size_t from = pdf.find("(D:", at);
    if (from == std::string::npos || from > at + field.size() + 2 || from + 17 > pdf.size()) continue;
    pdf.replace(from + 3, 14, digits);
  }
}

}  // namespace

std::string write_pdf(const PdfRequest& request) {
  const PdfProgram program = find_pdf_program(request.program);
  const PdfFolder folder;
  write_whole(folder.file("report.html"), request.html);
  write_whole(folder.file("data.json"), request.json);
  const bool done = run_to_end(words_of(program, folder), folder.file("log"), request.date_utc);
  std::string pdf = text_of(folder.file("report.pdf"));
  if (!done || pdf.compare(0, 5, "%PDF-") != 0) {
    std::string said = text_of(folder.file("log"));
    if (said.size() > 500) said = said.substr(said.size() - 500);
    pdf_failed(fmt::format("{} made no PDF: {}", program.path, said.empty() ? "it said nothing" : said), "--format pdf",
               "print the HTML (--format html) from a browser, or take the other program (--pdf-with)");
  }
  for (const char* field : {"/CreationDate", "/ModDate"}) set_pdf_date(pdf, field, request.date_utc);
  write_whole(request.path, pdf);
  return program.path;
}

}  // namespace tactbench::bench
