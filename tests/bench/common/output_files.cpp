// Which kind of file may replace which, what is refused, modes of new files, names of open streams.

#include <fcntl.h>
#include <grp.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>
#include <catch2/catch.hpp>

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include "bench/common/error.h"
#include "bench/common/output_file.h"
#include "bench/common/private_files.h"
#include "bench/guard/trip.h"
#include "db/run_store.h"
#include "tests/bench/cli/verb_here.h"
#include "tests/bench/common/file_mode.h"
#include "tests/support/process.h"
#include "tests/support/refusal.h"
#include "tests/support/variable.h"

using namespace tactbench::bench;
using namespace tactbench::tests;
using namespace tactbench;

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

// The program's own folders and files when made by others, linked elsewhere or open to all.

namespace {

constexpr uid_t kNobody = 65534;
constexpr gid_t kSomeGroup = 54321;

template <class Work>
std::string refused_as(const Work& work) {
  const auto error = refusal_by(work);
  if (!error) return "not refused";
  return error->id();
}

template <class Work>
std::string folder_refusal(const Work& work) {
  const auto error = refusal_by(work);
  if (!error) return "not refused";
  CHECK(error->id() == "TB-FOLDER-UNSAFE");
  CHECK(error->code() == ExitCode::kUsage);
  return error->where();
}

// Opens and closes; true where it could be opened.
bool opens(const std::string& path, int flags) {
  const int file = open_private_file(path, flags);
  if (file < 0) {
    CHECK(errno == EPERM);
    return false;
  }
  close(file);
  return true;
}

}  // namespace

TEST_CASE("private files: a bench id becomes a unique file name within its folder") {
  CHECK(file_name("rig-1_left.b") == "rig-1_left.b");
  std::set<std::string> names;
  std::vector<std::string> ids = {std::string(48, 'x'), std::string(49, 'x'), std::string(2000, '/'),
                                  std::string("a\0b", 3)};
  for (const char* id :
       {"a b", "a_b", "a/b", "a\nb", "../../victim", "..", ".", "", "~", ".git", "r\xc3\xbcttler", "a b~"})
    ids.emplace_back(id);
  for (const std::string& id : ids) {
    const std::string name = file_name(id);
    INFO(id << " -> " << name);
    CHECK(names.insert(name).second);
    CHECK((file_name(name) == name || names.count(file_name(name)) == 0));  // a name is not another text's either
    CHECK(name.size() <= 48);
    CHECK(name.front() != '.');
    CHECK(name.find('/') == std::string::npos);
    CHECK_FALSE(name.empty());
  }
  const std::string trip = TripFile("../../victim").path();
  CHECK(std::filesystem::path(trip).parent_path() == state_folder());
}

TEST_CASE("private files: links, pipes and files of other users are not opened, and not truncated") {
  const TemporaryFolder folder;
  const std::string precious = folder.path("precious"), path = folder.path("log");
  const int flags = O_WRONLY | O_CREAT | O_TRUNC;
  write_file(precious, "kept");
  std::filesystem::create_symlink(precious, path);
  CHECK(open_private_file(path, flags) < 0);
  std::filesystem::remove(path);
  std::filesystem::create_hard_link(precious, path);
  CHECK(open_private_file(path, flags) < 0);
  std::filesystem::remove(path);
  REQUIRE(mkfifo(path.c_str(), 0600) == 0);
  CHECK(open_private_file(path, O_RDONLY) < 0);
  std::filesystem::remove(path);
  CHECK(read_file(precious) == "kept");
  write_file(path, "older and longer");
  const int file = open_private_file(path, flags);
  REQUIRE(file >= 0);
  CHECK(write(file, "new", 3) == 3);
  CHECK((fcntl(file, F_GETFD) & FD_CLOEXEC) != 0);
  close(file);
  CHECK(read_file(path) == "new");
  if (geteuid() != 0) return;
  REQUIRE(chown(path.c_str(), kNobody, kNobody) == 0);
  CHECK(open_private_file(path, flags) < 0);
  CHECK(read_file(path) == "new");
}

TEST_CASE("private files: without a home folder, trips are stored in a folder that no other user made") {
  const TemporaryFolder folder;
  const Variable home("HOME", std::nullopt), state("XDG_STATE_HOME", std::nullopt), temporary("TMPDIR", folder.path());
  const std::string base = folder.path("tactbench-state-" + std::to_string(geteuid()));
  write_file(folder.path("precious"), "kept");
  std::filesystem::create_directory(base);
  REQUIRE(chmod(base.c_str(), 0777) == 0);
  CHECK(refused_as([] { (void)state_folder("/no/machine"); }) == "TB-FOLDER-UNSAFE");
  REQUIRE(chmod(base.c_str(), 0700) == 0);
  std::filesystem::create_directory_symlink(folder.path(), base + "/tactbench");
  CHECK(refused_as([] { (void)state_folder("/no/machine"); }) == "TB-FOLDER-UNSAFE");
  std::filesystem::remove(base + "/tactbench");
  REQUIRE(state_folder("/no/machine") == base + "/tactbench");
  CHECK(mode_of(base + "/tactbench") == 0700);
  const Variable there("XDG_STATE_HOME", base);
  const TripFile trip("rig");
  std::filesystem::create_symlink(folder.path("precious"), trip.log_path());
  REQUIRE(trip.store({"TB-CHAMBER-TRIP", "67 psi", 1, {}}));
  CHECK(refused_as([&] { trip.reset(*trip.read(), "P"); }) == "TB-FILE-WRITE");
  CHECK(trip.read());
  CHECK(read_file(folder.path("precious")) == "kept");
}

TEST_CASE("private files: trips for all users are stored only in a folder of root that one group may write to") {
  const TemporaryFolder folder;
  const Variable state("XDG_STATE_HOME", std::nullopt), home("HOME", folder.path());
  const std::string machine = folder.path("machine");
  CHECK(state_folder(machine) == folder.path(".local/state/tactbench"));
  std::filesystem::create_directory(machine);
  REQUIRE(chmod(machine.c_str(), 0700) == 0);
  CHECK(refused_as([&] { (void)state_folder(machine); }) == "TB-FOLDER-UNSAFE");
  if (geteuid() != 0) return;
  const auto give = [&](uid_t user, mode_t mode) {
    REQUIRE(chown(machine.c_str(), user, kSomeGroup) == 0);
    REQUIRE(chmod(machine.c_str(), mode) == 0);
  };
  give(kNobody, 02770);
  CHECK(refused_as([&] { (void)state_folder(machine); }) == "TB-FOLDER-UNSAFE");
  give(0, 02777);
  CHECK(refused_as([&] { (void)state_folder(machine); }) == "TB-FOLDER-UNSAFE");
  give(0, 02770);
  CHECK(state_folder(machine) == machine);
  std::filesystem::create_directory_symlink(machine, folder.path("link"));
  CHECK(refused_as([&] { (void)state_folder(folder.path("link")); }) == "TB-FOLDER-UNSAFE");
  // One member writes, another reads and continues to write; a non-member gets an error.
  REQUIRE(chmod(folder.path().c_str(), 0755) == 0);
  const std::string path = machine + "/rig.log";
  const auto as_member = [&](uid_t user, gid_t group, const std::function<bool()>& work) {
    const pid_t child = fork();
    if (child == 0) {
      const bool became = setgroups(1, &group) == 0 && setgid(60000) == 0 && setuid(user) == 0;
      _exit(became && work() ? 0 : 1);
    }
    int status = -1;
    waitpid(child, &status, 0);
    return status == 0;
  };
  for (const uid_t user : {60001, 60002}) {
    CHECK(as_member(user, kSomeGroup, [&] {
      const int file = open_private_file(path, O_WRONLY | O_CREAT | O_APPEND);
      return state_folder(machine) == machine && file >= 0 && write(file, "x", 1) == 1;
    }));
  }
  CHECK(read_file(path) == "xx");
  CHECK(as_member(60003, 60004, [&] { return refused_as([&] { (void)state_folder(machine); }) == "TB-STATE-DENIED"; }));
}

TEST_CASE("private files: a new scratch folder removes the folders of killed processes, and nothing else") {
  const TemporaryFolder folder;
  const Variable temporary("TMPDIR", folder.path());
  int ends[2];
  REQUIRE(pipe(ends) == 0);
  const pid_t owner = fork();
  if (owner == 0) {
    alarm(60);
    const ScratchFolder own("tactbench-x");
    write_file(own.path() + "/store", "x");
    if (write(ends[1], own.path().c_str(), own.path().size()) < 0) _exit(1);
    for (;;) pause();
  }
  char told[4096];
  const ssize_t size = read(ends[0], told, sizeof told);
  for (const int end : ends) close(end);
  REQUIRE(size > 0);
  const std::string left(told, static_cast<std::size_t>(size));
  // Not of this program, or of an earlier one that locked nothing.
  const std::vector<std::string> others = {"tactbench-x.shared", "tactbench-xy.abcde", "tactbench-x-abcdef",
                                           "tactbench-x.longer-one", "precious"};
  for (const std::string& name : others) {
    std::filesystem::create_directory(folder.path(name));
    REQUIRE(chmod(folder.path(name).c_str(), name == others.front() ? 0755 : 0700) == 0);
    write_file(folder.path(name) + "/file", "kept");
  }
  std::filesystem::create_directory_symlink(folder.path("precious"), folder.path("tactbench-x.linked"));
  write_file(folder.path("tactbench-x.a-file"), "kept");
  { const ScratchFolder next("tactbench-x"); }
  CHECK(read_file(left + "/store") == "x");  // its owner lives
  REQUIRE(kill(owner, SIGKILL) == 0);
  REQUIRE(waitpid(owner, nullptr, 0) == owner);
  { const ScratchFolder another("tactbench-y"); }
  CHECK(std::filesystem::exists(left));
  const ScratchFolder next("tactbench-x");
  CHECK_FALSE(std::filesystem::exists(left));
  CHECK(std::filesystem::exists(next.path()));
  for (const std::string& name : others) CHECK(read_file(folder.path(name) + "/file") == "kept");
  CHECK(std::filesystem::is_symlink(folder.path("tactbench-x.linked")));
  CHECK(read_file(folder.path("tactbench-x.a-file")) == "kept");
}

TEST_CASE("private files: a scratch folder has an unpredictable name, is closed to others, and is removed") {
  const TemporaryFolder folder;
  const Variable temporary("TMPDIR", folder.path());
  std::string one, other;
  {
    const ScratchFolder first("tactbench-x"), second("tactbench-x");
    one = first.path();
    other = second.path();
    CHECK(one != other);
    CHECK(mode_of(one) == 0700);
    write_file(one + "/file", "x");
  }
  CHECK_FALSE(std::filesystem::exists(one));
  CHECK(std::filesystem::is_empty(folder.path()));
}

TEST_CASE("private file names: which characters are kept, and how others are replaced") {
  for (const std::string& stays : {std::string("azAZ09.-_"), std::string(48, 'x')}) CHECK(file_name(stays) == stays);
  CHECK(file_name("a b") == "a_b~c8687a08aa5d6ed20443");  // the text's SHA-256
  CHECK_THAT(file_name("@`[{/:a"), Catch::StartsWith("______a~"));
  CHECK_THAT(file_name("0123456789012345678901234 "), Catch::StartsWith("012345678901234567890123~"));
}

TEST_CASE("private folders: access rights of others are removed, or the folder is rejected") {
  const TemporaryFolder folder;
  const std::string path = folder.path("own");
  make_private_folder(path);
  CHECK(mode_of(path) == 0700);
  CHECK(folder_refusal([&] { check_private_folder(path); }) == "not refused");
  const std::string link = folder.path("link");
  std::filesystem::create_directory_symlink(path, link);
  CHECK(folder_refusal([&] { make_private_folder(link); }) == link);
  for (const mode_t mode : {0701, 0704, 0710, 0740, 01755}) {
    INFO(std::oct << mode);
    REQUIRE(chmod(path.c_str(), mode) == 0);
    CHECK(folder_refusal([&] { check_private_folder(path); }) == path);
    CHECK(folder_refusal([&] { make_private_folder(path); }) == "not refused");
    CHECK(mode_of(path) == 0700);
  }
  for (const mode_t mode : {0720, 0702, 01777}) {
    REQUIRE(chmod(path.c_str(), mode) == 0);
    CHECK(folder_refusal([&] { make_private_folder(path); }) == path);
    CHECK(mode_of(path) == mode);
  }
  // One that its owner may not write to is closed all the same.
  for (const mode_t mode : {0500, 0700, 0000}) {
    REQUIRE(chmod(path.c_str(), mode) == 0);
    CHECK(folder_refusal([&] { make_private_folder(path); }) == "not refused");
    CHECK(mode_of(path) == mode);
  }
  const std::string none = folder.path("none");
  CHECK(folder_refusal([&] { check_private_folder(none); }) == none);
  write_file(folder.path("file"), "");
  CHECK(folder_refusal([&] { check_private_folder(folder.path("file")); }) == folder.path("file"));
  const std::string inside = folder.path("file") + "/own";
  CHECK(folder_refusal([&] { make_private_folder(inside); }) == inside);
  if (geteuid() != 0) return;
  REQUIRE(chown(path.c_str(), kNobody, kNobody) == 0);
  CHECK(folder_refusal([&] { make_private_folder(path); }) == path);
}

TEST_CASE(
    "own files: which files of other users are trusted, which mode new files get, no truncation unless requested") {
  const TemporaryFolder folder;
  const std::string path = folder.path("file");
  const int make = O_WRONLY | O_CREAT;
  REQUIRE(opens(path, make));
  CHECK(mode_of(path) == 0600);
  write_file(path, "kept");
  REQUIRE(opens(path, make));
  CHECK(read_file(path) == "kept");
  REQUIRE(opens(path, make | O_TRUNC));
  CHECK(read_file(path).empty());
  CHECK(open_private_file(folder.path("none"), O_RDONLY) == -1);
  CHECK(errno == ENOENT);
  std::filesystem::create_directory(folder.path("folder"));
  CHECK_FALSE(opens(folder.path("folder"), O_RDONLY));
  if (geteuid() != 0) return;
  const std::string shared = folder.path("shared"), inside = shared + "/file", other = shared + "/other";
  std::filesystem::create_directory(shared);
  write_file(other, "theirs");
  REQUIRE(chown(other.c_str(), kNobody, kSomeGroup) == 0);
  REQUIRE(chmod(other.c_str(), 0640) == 0);
  struct Row {
    uid_t user;
    mode_t mode;
    bool trusted;
  };
  for (const Row& row : {Row{0, 02770, true}, Row{0, 02775, true}, Row{0, 0770, false}, Row{0, 02750, false},
                         Row{0, 02772, false}, Row{kNobody, 02770, false}}) {
    INFO(row.user << " " << std::oct << row.mode);
    REQUIRE(chown(shared.c_str(), row.user, kSomeGroup) == 0);
    REQUIRE(chmod(shared.c_str(), row.mode) == 0);
    std::filesystem::remove(inside);
    REQUIRE(opens(inside, make));
    CHECK(mode_of(inside) == (row.trusted ? 0660 : 0600));
    CHECK(opens(other, O_RDONLY) == row.trusted);
    CHECK(opens(other, O_WRONLY | O_TRUNC) == row.trusted);
    CHECK(mode_of(other) == 0640);  // another member's file keeps its mode
    CHECK(read_file(other) == (row.trusted ? "" : "theirs"));
    write_file(other, "theirs");
  }
}
