#include "bench/reporting/report_pdf.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <qpdf/qpdf-c.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <memory>
#include <optional>
#include <sstream>
#include <system_error>
#include <utility>
#include <vector>

#include "bench/common/child_process.h"
#include "bench/common/error.h"
#include "bench/common/output_file.h"
#include "bench/common/private_files.h"

namespace tactbench::bench {
namespace {

namespace fs = std::filesystem;

constexpr auto kPdfDeadline = std::chrono::seconds(120);

[[noreturn]] void pdf_failed(const std::string& what, const std::string& where, const std::string& remedy) {
  throw Error("TB-REPORT-PDF", what, where, remedy);
}

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
  pdf_failed(fmt::format("no program that converts HTML to PDF is installed{}{}", wanted.empty() ? "" : ": ", wanted),
             "--format pdf",
             "apt-get install chromium (or weasyprint), or write --format html and print it from a browser");
}

std::vector<std::string> arguments_of(const PdfProgram& program, const fs::path& folder) {
  const std::string html = (folder / "report.html").string(), pdf = (folder / "report.pdf").string();
  if (!program.browser) return {program.path, html, pdf};
  std::vector<std::string> arguments = {program.path,
                                        "--headless",
                                        "--disable-gpu",
                                        "--no-first-run",
                                        "--disable-dev-shm-usage",
                                        "--no-pdf-header-footer",
                                        "--user-data-dir=" + (folder / "profile").string(),
                                        "--print-to-pdf=" + pdf};
  if (::geteuid() == 0) arguments.emplace_back("--no-sandbox");  // the sandbox refuses root
  arguments.push_back("file://" + html);
  return arguments;
}

std::string digits_of(const std::string& utc) {
  if (utc.size() < 19) return "20000101000000";
  std::string digits;
  for (const char c : utc)
    if (c >= '0' && c <= '9') digits += c;
  digits.resize(14, '0');
  return digits;
}

// The date of the document, for programs that ask the environment for one.
std::string date_variable(const std::string& utc) {
  const std::string digits = digits_of(utc);
  const auto number = [&](std::size_t from, std::size_t count) { return std::stoi(digits.substr(from, count)); };
  std::tm time{};
  time.tm_year = number(0, 4) - 1900;
  time.tm_mon = number(4, 2) - 1;
  time.tm_mday = number(6, 2);
  time.tm_hour = number(8, 2);
  time.tm_min = number(10, 2);
  time.tm_sec = number(12, 2);
  return fmt::format("SOURCE_DATE_EPOCH={}", ::timegm(&time));
}

// True when it ended by itself with 0. At the deadline its whole group is killed.
bool run_to_end(std::vector<std::string> arguments, const std::string& log, const std::string& utc) {
  const int output = ::open(log.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600);
  if (output < 0) return false;
  ChildStart start;
  start.arguments = std::move(arguments);
  start.environment = environment_with({date_variable(utc)});
  start.output = output;
  try {
    ChildProgram program(std::move(start));
    const std::optional<int> status = program.ended_by(std::chrono::steady_clock::now() + kPdfDeadline);
    program.kill_group();  // and processes that it left behind
    return status && WIFEXITED(*status) && WEXITSTATUS(*status) == 0;
  } catch (const std::system_error&) {
    return false;
  }
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
  const ScratchFolder scratch("tactbench-pdf");
  const fs::path folder = scratch.path();
  std::string html = request.html;
  if (const auto at = html.find("</title>"); at != std::string::npos) html.insert(at, ", run " + request.run_uuid);
  write_whole(folder / "report.html", html);
  const bool done = run_to_end(arguments_of(program, folder), folder / "log", request.date_utc);
  std::string pdf = file_text(folder / "report.pdf");
  if (!done || pdf.compare(0, 5, "%PDF-") != 0) {
    std::string output = file_text(folder / "log");
    if (output.size() > 500) output = output.substr(output.size() - 500);
    pdf_failed(fmt::format("{} made no PDF: {}", program.path, output.empty() ? "it printed nothing" : output),
               "--format pdf", "print the HTML (--format html) from a browser, or use the other program (--pdf-with)");
  }
  for (const char* field : {"/CreationDate", "/ModDate"}) set_pdf_date(pdf, field, request.date_utc);
  write_output(request.path, request.attachments.empty() ? pdf : with_attachments(pdf, request.attachments),
               request.replace);
  return program.path;
}

// By the C interface of qpdf: clang 16 does not compile the C++ one's headers as C++20.

namespace {

class Pdf {
 public:
  explicit Pdf(const std::string& bytes) : data_(qpdf_init()) {
    qpdf_silence_errors(data());
    qpdf_set_suppress_warnings(data(), QPDF_TRUE);
    (void)qpdf_read_memory(data(), "report", bytes.data(), bytes.size(), nullptr);
    check();
  }
  [[nodiscard]] qpdf_data data() const { return data_.get(); }

  [[nodiscard]] qpdf_oh name(const std::string& word) const { return qpdf_oh_new_name(data(), ("/" + word).c_str()); }
  [[nodiscard]] qpdf_oh text(const std::string& arguments) const {
    return qpdf_oh_new_unicode_string(data(), arguments.c_str());
  }
  [[nodiscard]] qpdf_oh dictionary(const std::vector<std::pair<const char*, qpdf_oh>>& entries) const {
    const qpdf_oh made = qpdf_oh_new_dictionary(data());
    for (const auto& [key, value] : entries) qpdf_oh_replace_key(data(), made, key, value);
    return made;
  }

  [[nodiscard]] qpdf_oh file(const PdfAttachment& own) const {
    const qpdf_oh stream = qpdf_oh_new_stream(data());
    qpdf_oh_replace_stream_data(data(), stream, reinterpret_cast<const unsigned char*>(own.bytes.data()),
                                own.bytes.size(), qpdf_oh_new_null(data()), qpdf_oh_new_null(data()));
    const qpdf_oh facts = qpdf_oh_get_dict(data(), stream);
    qpdf_oh_replace_key(data(), facts, "/Type", name("EmbeddedFile"));
    qpdf_oh_replace_key(data(), facts, "/Subtype", name(own.mime));
    const auto size = static_cast<long long>(own.bytes.size());
    qpdf_oh_replace_key(data(), facts, "/Params", dictionary({{"/Size", qpdf_oh_new_integer(data(), size)}}));
    return qpdf_make_indirect_object(data(), dictionary({{"/Type", name("Filespec")},
                                                         {"/F", text(own.name)},
                                                         {"/UF", text(own.name)},
                                                         {"/Desc", text(own.description)},
                                                         {"/AFRelationship", name("Data")},
                                                         {"/EF", dictionary({{"/F", stream}, {"/UF", stream}})}}));
  }

  [[nodiscard]] std::string written() const {
    (void)qpdf_init_write_memory(data());
    qpdf_set_deterministic_ID(data(), QPDF_TRUE);
    qpdf_set_minimum_pdf_version(data(), "1.7");
    qpdf_set_object_stream_mode(data(), qpdf_o_disable);  // its title is found without a PDF's reader
    (void)qpdf_write(data());
    check();
    return {reinterpret_cast<const char*>(qpdf_get_buffer(data())), qpdf_get_buffer_length(data())};
  }

  void check() const {
    if (qpdf_has_error(data()) == QPDF_FALSE) return;
    throw Error(
        "TB-REPORT-PDF",
        fmt::format("the data cannot be attached: {}", qpdf_get_error_full_text(data(), qpdf_get_error(data()))),
        "--format pdf", "use the other program (--pdf-with)");
  }

 private:
  struct Cleanup {
    void operator()(qpdf_data data) const { qpdf_cleanup(&data); }
  };
  std::unique_ptr<_qpdf_data, Cleanup> data_;
};

}  // namespace

std::string with_attachments(const std::string& pdf, std::vector<PdfAttachment> attachments) {
  const Pdf document(pdf);
  const qpdf_data data = document.data();
  std::ranges::sort(attachments, {}, &PdfAttachment::name);  // as a name tree requires
  const qpdf_oh tree = qpdf_oh_new_array(data), associated = qpdf_oh_new_array(data), root = qpdf_get_root(data);
  for (const PdfAttachment& own : attachments) {
    const qpdf_oh file = document.file(own);
    qpdf_oh_append_item(data, tree, document.text(own.name));
    qpdf_oh_append_item(data, tree, file);
    qpdf_oh_append_item(data, associated, file);
  }
  qpdf_oh names = qpdf_oh_get_key(data, root, "/Names");
  if (qpdf_oh_is_dictionary(data, names) == QPDF_FALSE) names = document.dictionary({});
  qpdf_oh_replace_key(data, names, "/EmbeddedFiles", document.dictionary({{"/Names", tree}}));
  qpdf_oh_replace_key(data, root, "/Names", names);
  qpdf_oh_replace_key(data, root, "/AF", associated);
  document.check();
  return document.written();
}

}  // namespace tactbench::bench
