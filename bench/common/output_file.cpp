#include "bench/common/output_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <ostream>
#include <streambuf>
#include <string_view>
#include <utility>
#include <vector>

#include "analysis/json_io.h"
#include "bench/common/error.h"
#include "bench/common/private_files.h"

namespace tactbench::bench {
namespace {

namespace fs = std::filesystem;

constexpr const char* kStoreFile = "an SQLite database (a store, perhaps)";
constexpr const char* kStoreLog = "the log or the lock of an SQLite database";
constexpr const char* kReportDocument = "a tactbench.report document (JSON)";
constexpr const char* kUnknownFile = "a file that tactbench did not write";
constexpr std::size_t kLooked = 1U << 16;  // bytes: the header of a table has one column per taxel

struct Beginning {
  std::string_view bytes;
  const char* kind;
};
using namespace std::string_view_literals;
constexpr std::array kBeginnings = {
    Beginning{"SQLite format 3\0"sv, kStoreFile},
    Beginning{"\x37\x7f\x06\x82"sv, kStoreLog},
    Beginning{"\x37\x7f\x06\x83"sv, kStoreLog},
    Beginning{"\xd9\xd5\x05\xf9\x20\xa1\x63\xd7"sv, kStoreLog},
    Beginning{"%PDF-"sv, kPdfFile},
    Beginning{"\x89HDF\r\n\x1a\n"sv, "an HDF5 file"},
    Beginning{"<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n<meta http-equiv=\"Content-"
              "Security-Policy\""sv,
              kPageFile},
    Beginning{"<svg xmlns=\"http://www.w3.org/2000/svg\" role=\"img\" class=\"chart\""sv, kSvgFile},
    Beginning{"<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuite name="sv, "JUnit XML"},
    Beginning{"<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<dcc:digitalCalibrationCertificate "sv, kDccFile},
    Beginning{"# HELP tactbench_"sv, "metrics of tactbench"},
    Beginning{kScenarioLogHead, kScenarioLogFile},
    Beginning{"tactbench selfcheck, "sv, "a record of tactbench selfcheck"},
    Beginning{"# Written by `tactbench simulate`"sv, "a bench file of tactbench simulate"},
    Beginning{"# correction of "sv, "a correction of a reference"},
    Beginning{"# SIMULATED correction of "sv, "a correction of a reference"},
    Beginning{"# tactbench: frames of run "sv, kRunTable},
};

// {"schema":"tactbench.model",...} with any blanks between; empty: another document.
std::string schema_of(std::string_view text) {
  const auto take = [&](std::string_view word) {
    text.remove_prefix(std::min(text.find_first_not_of(" \t\r\n"), text.size()));
    const bool there = text.starts_with(word);
    if (there) text.remove_prefix(word.size());
    return there;
  };
  if (!take("{") || !take("\"schema\"") || !take(":") || !take("\"tactbench.")) return {};
  return "tactbench." + std::string(text.substr(0, std::min(text.find('"'), text.size())));
}

// The first line of a table; empty: none, for a table has several columns and no other characters than text.
std::string columns_of(std::string_view text) {
  const std::string_view line = text.substr(0, text.find('\n'));
  if (line.size() == text.size() || line.find_first_of(",;\t") == std::string_view::npos) return {};
  for (const char c : line)
    if (static_cast<unsigned char>(c) < 0x20 && c != '\t' && c != '\r') return {};
  return std::string(line);
}

std::string beginning_of(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  std::string text(kLooked, '\0');
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (stream.bad() || !stream.is_open()) {
    throw Error("TB-FILE-EXISTS", "the existing file cannot be read, so its kind is not known", path,
                "write to another name, or remove it");
  }
  text.resize(static_cast<std::size_t>(stream.gcount()));
  return text;
}

// "runs.db-wal" or "runs.db-lock" next to the database "runs.db": even an empty file may be in use.
bool belongs_to_store(const std::string& path) {
  for (const std::string_view ending : {"-wal", "-shm", "-journal", "-lock"}) {
    if (!path.ends_with(ending)) continue;
    const std::string database = path.substr(0, path.size() - ending.size());
    struct stat status {};  // a pipe, a device or a file of /proc may be waited for without end
    if (::stat(database.c_str(), &status) != 0 || !S_ISREG(status.st_mode) || status.st_size == 0) continue;
    std::ifstream stream(database, std::ios::binary);
    std::array<char, 16> head{};
    stream.read(head.data(), head.size());
    if (kind_of_file({head.data(), head.size()}) == kStoreFile) return true;
  }
  return false;
}

[[noreturn]] void cannot_write(const std::string& path, int error) {
  throw Error("TB-FILE-WRITE", fmt::format("cannot write the file: {}", std::strerror(error)), path);
}

// A stream buffer that writes into an open file and closes it.
class FileBuffer : public std::streambuf {
 public:
  FileBuffer(int file, std::string path) : file_(file), path_(std::move(path)), bytes_(kLooked) { empty(); }
  ~FileBuffer() override {
    if (file_ >= 0) ::close(file_);
  }
  FileBuffer(const FileBuffer&) = delete;
  FileBuffer& operator=(const FileBuffer&) = delete;
  // The bytes written in all.
  std::size_t end() {
    sync();
    if (::close(std::exchange(file_, -1)) != 0) cannot_write(path_, errno);
    return written_;
  }

 private:
  int_type overflow(int_type character) override {
    sync();
    if (!traits_type::eq_int_type(character, traits_type::eof())) sputc(traits_type::to_char_type(character));
    return traits_type::not_eof(character);
  }
  int sync() override {
    for (const char* at = pbase(); at < pptr();) {
      const ssize_t count = ::write(file_, at, static_cast<std::size_t>(pptr() - at));
      if (count < 0 && errno == EINTR) continue;
      if (count < 0) cannot_write(path_, errno);
      at += count;
      written_ += static_cast<std::size_t>(count);
    }
    empty();
    return 0;
  }
  void empty() { setp(bytes_.data(), bytes_.data() + bytes_.size()); }
  int file_;
  std::string path_;
  std::vector<char> bytes_;
  std::size_t written_ = 0;
};

std::size_t write_into(int file, const std::string& path, const WriteOutput& write) {
  if (file < 0) cannot_write(path, errno);
  FileBuffer buffer(file, path);
  std::ostream stream(&buffer);
  stream.exceptions(std::ios::badbit);  // the buffer's own errors come out as they are
  write(stream);
  return buffer.end();
}

// The open file behind a name such as /dev/stdout: opening it again would write from its start.
std::optional<int> named_descriptor(const std::string& path) {
  if (path == "/dev/stdout") return STDOUT_FILENO;
  if (path == "/dev/stderr") return STDERR_FILENO;
  for (const std::string_view folder : {"/dev/fd/", "/proc/self/fd/"}) {
    if (!path.starts_with(folder)) continue;
    int number = -1;
    const char* end = path.data() + path.size();
    const auto [last, fault] = std::from_chars(path.data() + folder.size(), end, number);
    if (fault == std::errc() && last == end) return number;
  }
  return std::nullopt;
}

struct HalfFile {
  std::string name;    // has the permissions of the file that it will replace
  std::string target;  // where a link at its path leads to
};

std::pair<HalfFile, int> open_half_file(const std::string& path) {
  std::error_code failed;
  if (fs::path(path).has_parent_path()) fs::create_directories(fs::path(path).parent_path(), failed);
  const fs::path link_end = fs::canonical(path, failed);
  HalfFile half{{}, failed ? path : link_end.string()};
  half.name = fmt::format("{}.partial-{}", half.target, getpid());
  ::unlink(half.name.c_str());  // left by an earlier process of this number
  const int file = ::open(half.name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0666);
  if (file < 0) cannot_write(path, errno);
  if (struct stat before{}; ::stat(half.target.c_str(), &before) == 0) (void)::fchmod(file, before.st_mode & 0777);
  return {half, file};
}

std::size_t replace_file(const std::string& path, const WriteOutput& write) {
  const auto [half, file] = open_half_file(path);
  try {
    const std::size_t bytes = write_into(file, path, write);
    if (::rename(half.name.c_str(), half.target.c_str()) != 0) cannot_write(path, errno);
    return bytes;
  } catch (...) {
    ::unlink(half.name.c_str());
    throw;
  }
}

}  // namespace

std::string kind_of_file(const std::string& beginning) {
  const std::string_view text = beginning;
  for (const Beginning& known : kBeginnings)
    if (text.starts_with(known.bytes)) return known.kind;
  const std::string schema = schema_of(text);
  if (!schema.empty()) return fmt::format("a {} document (JSON)", schema);
  const std::string columns = columns_of(text);
  return columns.empty() ? kUnknownFile : fmt::format("a table (CSV) with the columns {}", columns);
}

void check_output(const std::string& path, const std::string& kind, bool replace) {
  struct stat status {};
  const bool there = ::stat(path.c_str(), &status) == 0;
  const bool store = belongs_to_store(path);
  if (!store && (!there || !S_ISREG(status.st_mode) || status.st_size == 0)) return;
  const std::string found = store ? kStoreLog : kind_of_file(beginning_of(path));
  if (found == kStoreFile || found == kStoreLog) {
    throw Error("TB-FILE-STORE", fmt::format("the file is {} and is never overwritten", found), path);
  }
  if (named_descriptor(path)) return;  // the user chose the redirection
  if (found == kPageFile || found == kReportDocument) {
    if (const std::string number = signed_report_number_in(file_text(path)); !number.empty())
      throw Error("TB-REPORT-SIGNED", fmt::format("the file holds the signed report {}", number), path);
  }
  if (replace || (found == kind && found != kUnknownFile)) return;
  constexpr std::size_t kShown = 120;
  const auto shown = [](const std::string& text) {
    return text.size() <= kShown ? text : text.substr(0, kShown) + "...";
  };
  throw Error("TB-FILE-EXISTS", fmt::format("the existing file is {}; {} would replace it", shown(found), shown(kind)),
              path);
}

std::size_t write_output(const std::string& path, const std::string& kind, const WriteOutput& write, bool replace) {
  check_output(path, kind, replace);
  if (const auto descriptor = named_descriptor(path)) {
    std::fflush(stdout);
    return write_into(::fcntl(*descriptor, F_DUPFD_CLOEXEC, 0), path, write);
  }
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0 || S_ISREG(status.st_mode) || S_ISDIR(status.st_mode)) {
    return replace_file(path, write);
  }
  return write_into(::open(path.c_str(), O_WRONLY | O_CLOEXEC | O_NOCTTY), path, write);
}

void write_output(const std::string& path, const std::string& text, bool replace) {
  (void)write_output(
      path, kind_of_file(text), [&](std::ostream& stream) { stream << text; }, replace);
}

void write_whole(const std::string& path, const std::string& text) {
  std::error_code failed;
  if (fs::path(path).has_parent_path()) fs::create_directories(fs::path(path).parent_path(), failed);
  const std::string partial = path + ".partial";
  std::ofstream stream(partial, std::ios::binary);
  stream << text;
  stream.close();
  if (!stream.fail()) fs::rename(partial, path, failed);
  if (stream.fail() || failed) {
    throw Error("TB-FILE-WRITE", "cannot write the file", path);
  }
}

std::string signed_report_number_in(const std::string& text) {
  std::string data = text;
  if (!text.starts_with('{')) {  // a page: its data are inside
    const std::string open = "id=\"report-data\">";
    const std::size_t from = text.find(open);
    if (from == std::string::npos) return {};
    const std::size_t begin = from + open.size(), end = text.find("</script>", begin);
    data = end == std::string::npos ? std::string() : text.substr(begin, end - begin);
  }
  const nlohmann::ordered_json json = analysis::try_ordered_json(data);
  if (!json.is_object() || !json.contains("number") || !json.contains("identification")) return {};
  std::string number = json.value("number", "");
  const nlohmann::ordered_json& identification = json["identification"];
  if (!identification.is_object() || !identification.contains("approvals")) return {};
  for (const auto& approval : identification["approvals"])
    if (approval.is_object() && approval.value("number", "") == number) return number;
  return {};
}

}  // namespace tactbench::bench
