// Which kind of file may replace which, what is refused, modes of new files, names of open streams.
#include <fcntl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cstdio>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "bench/common/error.h"
#include "bench/common/output_file.h"
#include "db/run_store.h"
#include "tests/bench/cli/verb_here.h"
#include "tests/bench/common/file_mode.h"
#include "tests/support/process.h"
#include "tests/support/refusal.h"

using namespace tactbench;
using namespace tactbench::bench;
using namespace tactbench::tests;

namespace {

constexpr const char* kTable = "x,y\n1,2\n";
constexpr const char* kModel = "{\n \"schema\": \"tactbench.model\",\n \"version\": 1}\n";

std::string error_of(const std::string& path, const std::string& text, bool replace = false) {
  try {
    write_output(path, text, replace);
  } catch (const Error& error) {
    CHECK(error.code() == ExitCode::kUsage);
    CHECK(error.where() == path);
    CHECK_FALSE(error.remedy().empty());
    return error.id();
  }
  return {};
}

}  // namespace

TEST_CASE("output: a file is replaced by its own kind, by another kind on request, and a store never") {
  const TemporaryFolder folder;
  const std::string path = folder.path("out/m.json"), notes = folder.path("notes.txt");
  CHECK(error_of(path, kModel).empty());
  CHECK(read_file(path) == kModel);
  const std::string second = std::string(kModel) + " ";
  CHECK(error_of(path, second).empty());
  CHECK(read_file(path) == second);
  CHECK(error_of(path, kTable) == "TB-FILE-EXISTS");
  write_file(notes, "my notes\n");
  CHECK(error_of(notes, kModel) == "TB-FILE-EXISTS");
  CHECK(error_of(notes, "other notes\n") == "TB-FILE-EXISTS");  // of no kind is not of one kind
  CHECK(read_file(notes) == "my notes\n");
  CHECK(error_of(notes, kModel, true).empty());
  CHECK(read_file(notes) == kModel);
  write_file(notes, "");
  CHECK(error_of(notes, kTable).empty());

  const std::string store = folder.path("runs.db");
  db::RunStore::open(store);
  const std::string before = read_file(store);
  std::filesystem::create_symlink("runs.db", folder.path("link.json"));
  std::filesystem::create_symlink("link.json", folder.path("further.json"));
  for (const bool replace : {false, true})
    for (const char* name : {"runs.db", "link.json", "further.json", "runs.db-wal", "runs.db-shm", "runs.db-journal"}) {
      INFO(name);
      CHECK(error_of(folder.path(name), kModel, replace) == "TB-FILE-STORE");
    }
  CHECK(read_file(store) == before);
  CHECK(std::filesystem::is_symlink(folder.path("link.json")));
  CHECK_FALSE(std::filesystem::exists(folder.path("runs.db-wal")));
  CHECK(std::distance(std::filesystem::directory_iterator(folder.path()), std::filesystem::directory_iterator()) == 5);
}

TEST_CASE("output: a link is kept and its target is replaced") {
  const TemporaryFolder folder;
  write_file(folder.path("real.json"), kModel);
  std::filesystem::create_symlink("real.json", folder.path("link.json"));
  const std::string second = std::string(kModel) + " ";
  CHECK(error_of(folder.path("link.json"), second).empty());
  CHECK(std::filesystem::is_symlink(folder.path("link.json")));
  CHECK(read_file(folder.path("real.json")) == second);
}

TEST_CASE("output: devices and pipes are written to, not replaced") {
  const TemporaryFolder folder;
  CHECK(error_of("/dev/null", kModel).empty());
  CHECK(std::filesystem::is_character_file("/dev/null"));
  CHECK(error_of("/dev/full", kModel) == "TB-FILE-WRITE");
  const std::string pipe = folder.path("pipe");
  REQUIRE(mkfifo(pipe.c_str(), 0600) == 0);
  const pid_t child = fork();
  REQUIRE(child >= 0);
  if (child == 0) _exit(read_file(pipe) == kModel ? 0 : 1);
  CHECK(error_of(pipe, kModel).empty());
  int status = 0;
  REQUIRE(waitpid(child, &status, 0) == child);
  CHECK(WEXITSTATUS(status) == 0);
  CHECK(std::filesystem::is_fifo(pipe));
}

TEST_CASE("output: a signed report is never overwritten by any kind of file") {
  const TemporaryFolder folder;
  REQUIRE(mkfifo(folder.path("pipe").c_str(), 0600) == 0);
  CHECK(error_of(folder.path("pipe-lock"), kModel).empty());  // a pipe is no store, and is not waited for
  const std::string data =
      R"({"schema":"tactbench.report","number":"1-0a","identification":{"approvals":[{"number":"1-0a"}]}})";
  const std::string html = folder.path("run.html"), json = folder.path("run.json");
  const std::string page =
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n<meta "
      "http-equiv=\"Content-Security-Policy\"/><script type=\"application/json\" id=\"report-data\">" +
      data + "</script>";
  write_file(html, page);
  write_file(json, data);
  for (const bool replace : {false, true})
    for (const std::string& path : {html, json}) CHECK(error_of(path, kModel, replace) == "TB-REPORT-SIGNED");
  CHECK(read_file(html) == page);
}

TEST_CASE("output: a store and its companion files are rejected by name, names next to a non-store are accepted") {
  const TemporaryFolder folder;
  const std::string store = folder.path("runs.db");
  (void)db::RunStore::open(store);
  CHECK(error_of(store, kTable) == "TB-FILE-STORE");
  for (const char* ending : {"-wal", "-shm", "-journal", "-lock"})
    CHECK(error_of(store + ending, kTable) == "TB-FILE-STORE");
  CHECK(error_of(store + "-lock-wal", kTable).empty());
  write_file(folder.path("empty.db"), "");
  write_file(folder.path("notes.db"), "SQLite format 4, they said");
  std::filesystem::create_directory(folder.path("folder.db"));
  for (const char* name : {"empty.db-wal", "notes.db-wal", "folder.db-lock", "none.db-lock"})
    CHECK(error_of(folder.path(name), kTable).empty());
  write_file(folder.path("log"), "\x37\x7f\x06\x82 and more");
  CHECK(error_of(folder.path("log"), kTable, true) == "TB-FILE-STORE");
}

TEST_CASE("output: a file that cannot be written is an error") {
  const TemporaryFolder folder;
  const std::string here = folder.path("here"), file = folder.path("f");
  std::filesystem::create_directory(here);
  CHECK(error_of(here, kTable) == "TB-FILE-WRITE");
  CHECK(std::distance(std::filesystem::directory_iterator(folder.path()), {}) == 1);  // no temporary file remains
  write_file(file, kTable);
  CHECK(error_of(file + "/g", kTable) == "TB-FILE-WRITE");
  CHECK(error_of("/dev/full", kTable) == "TB-FILE-WRITE");
  CHECK(refusal_by([&] { write_whole(file + "/g", "x"); }).value().id() == "TB-FILE-WRITE");
  CHECK(refusal_by([&] { write_whole(here, "x"); }).value().id() == "TB-FILE-WRITE");
  CHECK(error_of("/dev/fd/1x", kTable) == "TB-FILE-WRITE");
  CHECK(error_of("/proc/self/fd/", kTable) == "TB-FILE-WRITE");
}

TEST_CASE("output: new files get the mode by the umask, replaced files keep their mode") {
  const TemporaryFolder folder;
  const mode_t before = umask(0);
  write_output(folder.path("a"), kTable, false);
  umask(before);
  CHECK(mode_of(folder.path("a")) == 0666);
  REQUIRE(chmod(folder.path("a").c_str(), 04751) == 0);
  write_output(folder.path("a"), "x,y\n3,4\n", false);
  CHECK(mode_of(folder.path("a")) == 0751);
}

TEST_CASE("output: names of standard output and error are written to, a store behind a descriptor is rejected") {
  std::string err;
  const std::string out = printed_by([&] {
    Captured captured(stderr);
    std::fputs("before\n", stdout);  // still in the buffer
    write_output("/dev/stdout", "to output\n", false);
    write_output("/dev/stderr", "to error\n", false);
    err = captured.text();
  });
  CHECK(out == "before\nto output\n");
  CHECK(err == "to error\n");
  const TemporaryFolder folder;
  const std::string store = folder.path("runs.db");
  (void)db::RunStore::open(store);
  const int file = open(store.c_str(), O_WRONLY | O_CLOEXEC);
  REQUIRE(file >= 0);
  CHECK(error_of("/dev/fd/" + std::to_string(file), kTable) == "TB-FILE-STORE");
  close(file);
}

TEST_CASE("signed reports: a number counts if an approval in the same document names it") {
  const auto number_in = [](const std::string& approvals, const std::string& more = R"("number":"7-1",)") {
    return signed_report_number_in("{" + more + R"("identification":)" + approvals + "}");
  };
  CHECK(number_in(R"({"approvals":[{"number":"7-1"}]})") == "7-1");
  CHECK(number_in(R"({"approvals":[3,{"number":"7-0"},{"number":"7-1"}]})") == "7-1");
  CHECK(number_in(R"({"approvals":[{"number":"7-0"}]})").empty());
  CHECK(number_in(R"({"approvals":[]})").empty());
  CHECK(number_in(R"({"approvals":[{}]})").empty());
  CHECK(number_in("{}").empty());
  CHECK(number_in("[]").empty());
  CHECK(number_in("7").empty());
  CHECK(number_in(R"({"approvals":[{"number":"7-1"}]})", "").empty());
  for (const char* other :
       {"", "[]", "{", "7", R"({"number":"7-1"})", R"(<p id="report-data">{"number":"7-1"}</script>)"})
    CHECK(signed_report_number_in(other).empty());
  const std::string data = R"({"number":"7-1","identification":{"approvals":[{"number":"7-1"}]}})";
  CHECK(signed_report_number_in("<p id=\"report-data\">" + data + "</script></p>") == "7-1");
  CHECK(signed_report_number_in("<p id=\"report-data\">" + data).empty());  // cut short
  CHECK(signed_report_number_in("<p id=\"other-data\">" + data + "</script>").empty());
}

// The whole table of beginnings by which files are known, and names that are open files already.

TEST_CASE("file kind: each signature in the table is a separate kind, and is not recognised without its last byte") {
  const std::string other = kind_of_file("my notes\n");
  const std::vector<std::vector<std::string>> kinds = {
      {std::string("SQLite format 3\0", 16)},
      {"\x37\x7f\x06\x82", "\x37\x7f\x06\x83", "\xd9\xd5\x05\xf9\x20\xa1\x63\xd7"},
      {"%PDF-"},
      {"\x89HDF\r\n\x1a\n"},
      {"<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n<meta "
       "http-equiv=\"Content-Security-Policy\""},
      {"<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuite name="},
      {"# HELP tactbench_"},
      {"# Talk of tactbench nightly, scenario "},
      {"tactbench selfcheck, "},
      {"# Written by `tactbench simulate`"},
      {"# correction of ", "# SIMULATED correction of "},
      {"# tactbench: frames of run "},
  };
  std::set<std::string> seen = {other};
  for (const std::vector<std::string>& beginnings : kinds) {
    const std::string kind = kind_of_file(beginnings.front());
    INFO(kind);
    CHECK(seen.insert(kind).second);
    for (const std::string& beginning : beginnings) {
      CHECK(kind_of_file(beginning + "\x01more\n") == kind);
      CHECK(kind_of_file(beginning.substr(0, beginning.size() - 1)) == other);
      CHECK(kind_of_file(" " + beginning) == other);
    }
  }
}

TEST_CASE("file kind: a JSON document is recognised by its schema after white space, a table by its first line") {
  const std::string other = kind_of_file("my notes\n");
  const std::string document = kind_of_file("{\"schema\":\"tactbench.x\",\"version\":1}");
  CHECK_THAT(document, Catch::Contains("tactbench.x "));
  CHECK(kind_of_file(" \t\r\n{ \t\r\n\"schema\" \t\r\n: \t\r\n\"tactbench.x\"") == document);
  CHECK(kind_of_file("{\"schema\":\"tactbench.y\"}") != document);
  CHECK_THAT(kind_of_file("a;b\nx"), Catch::EndsWith(" a;b"));
  CHECK_THAT(kind_of_file("a b,\x7f\xc3\n\x01"), Catch::EndsWith(" a b,\x7f\xc3"));
  CHECK_THAT(kind_of_file("a\tb\n"), Catch::EndsWith(" a\tb"));
  for (const char* none :
       {"", "{", "{\"schema\":\"theirs\"}", "<!DOCTYPE html><html>", "\"schema\":\"tactbench.x\"", "{:\"tactbench.x\"",
        "{\"schema\"\"tactbench.x\"", "{\"schema\":\"tactbenchx\"", "{\"schema\":tactbench.x",
        "{\v\"schema\":\"tactbench.x\"", "a,b", "a b\n", "\na,b\n", "a,\x1f\n", "a,\x0b\n", "\n"})
    CHECK(kind_of_file(none) == other);
}

TEST_CASE("output: a descriptor name is written to at its current position, whatever the file contains") {
  const TemporaryFolder folder;
  for (const char* form : {"/dev/fd/", "/proc/self/fd/"}) {
    INFO(form);
    write_file(folder.path("f"), "my notes\nmore\n");
    const int file = ::open(folder.path("f").c_str(), O_WRONLY | O_CLOEXEC);
    REQUIRE(file >= 0);
    CHECK(::lseek(file, 3, SEEK_SET) == 3);
    write_output(form + std::to_string(file), "NO", false);
    CHECK(read_file(folder.path("f")) == "my NOtes\nmore\n");
    write_output(form + std::to_string(file), "T", false);  // behind what was written
    CHECK(read_file(folder.path("f")) == "my NOTes\nmore\n");
    ::close(file);
    try {
      write_output(form + std::to_string(file), "x", false);
      FAIL("it is closed");
    } catch (const Error& error) {
      CHECK(error.id() == "TB-FILE-WRITE");
    }
  }
}

TEST_CASE("output: text of any length is written, and the number of bytes is returned") {
  const TemporaryFolder folder;
  for (const std::size_t size : {0U, 1U, 65'535U, 65'536U, 65'537U, 200'000U}) {
    std::string text(size, 'x');
    for (std::size_t i = 0; i < size; i += 1000) text[i] = static_cast<char>('a' + i / 1000 % 26);
    const std::string path = folder.path(std::to_string(size));
    CHECK(write_output(
              path, "k", [&](std::ostream& stream) { stream << text; }, false) == size);
    CHECK(read_file(path) == text);
    CHECK(write_output(
              path, "k",
              [&](std::ostream& stream) {
                for (const char c : text) stream.put(c);
              },
              true) == size);
    CHECK(read_file(path) == text);
  }
}

TEST_CASE("output: a whole file is written with its folders, or not at all") {
  const TemporaryFolder folder;
  write_whole(folder.path("a/b/c"), "one");
  write_whole(folder.path("a/b/c"), "two");
  CHECK(read_file(folder.path("a/b/c")) == "two");
  CHECK_THROWS_AS(write_whole(folder.path("a/b"), "x"), Error);
  CHECK(read_file(folder.path("a/b/c")) == "two");
  CHECK_THROWS_AS(write_whole(folder.path("a/b/c/d"), "x"), Error);
}
