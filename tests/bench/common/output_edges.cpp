// Files that are written on request: what they refuse, modes of new files, names of open streams.
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "bench/common/error.h"
#include "bench/common/output_file.h"
#include "bench/common/shard.h"
#include "bench/common/signed_number.h"
#include "db/run_store.h"
#include "tests/bench/cli/verb_here.h"
#include "tests/bench/common/file_mode.h"
#include "tests/support/refusal.h"

using namespace tactbench;
using namespace tactbench::bench;
using namespace tactbench::tests;

namespace {

template <class Work>
std::string output_refusal(const Work& work) {
  const auto error = refusal_by(work);
  if (!error) return "not refused";
  CHECK(error->code() == ExitCode::kUsage);
  return error->id() + " at " + error->where();
}

std::string refusal_at(const std::string& path, const std::string& text = "x,y\n1,2\n", bool replace = false) {
  return output_refusal([&] { write_output(path, text, replace); });
}

}  // namespace

TEST_CASE("output: a store and what belongs to one are refused by name, whatever stands beside what is none") {
  const TemporaryFolder folder;
  const std::string store = folder.path("runs.db");
  (void)db::RunStore::open(store);
  CHECK(refusal_at(store) == "TB-FILE-STORE at " + store);
  for (const char* ending : {"-wal", "-shm", "-journal", "-lock"})
    CHECK(refusal_at(store + ending) == "TB-FILE-STORE at " + store + ending);
  CHECK(refusal_at(store + "-lock-wal") == "not refused");
  write_file(folder.path("empty.db"), "");
  write_file(folder.path("notes.db"), "SQLite format 4, they said");
  std::filesystem::create_directory(folder.path("folder.db"));
  for (const char* name : {"empty.db-wal", "notes.db-wal", "folder.db-lock", "none.db-lock"})
    CHECK(refusal_at(folder.path(name)) == "not refused");
  write_file(folder.path("log"), "\x37\x7f\x06\x82 and more");
  CHECK(refusal_at(folder.path("log"), "x,y\n1,2\n", true).starts_with("TB-FILE-STORE"));
}

TEST_CASE("output: a file that cannot be written") {
  const TemporaryFolder folder;
  const std::string here = folder.path("here"), file = folder.path("f");
  std::filesystem::create_directory(here);
  CHECK(refusal_at(here) == "TB-FILE-WRITE at " + here);
  CHECK(std::distance(std::filesystem::directory_iterator(folder.path()), {}) == 1);  // no temporary file remains
  write_file(file, "x,y\n1,2\n");
  CHECK(refusal_at(file + "/g") == "TB-FILE-WRITE at " + file + "/g");
  CHECK(refusal_at("/dev/full") == "TB-FILE-WRITE at /dev/full");
  CHECK(output_refusal([&] { write_whole(file + "/g", "x"); }) == "TB-FILE-WRITE at " + file + "/g");
  CHECK(output_refusal([&] { write_whole(here, "x"); }) == "TB-FILE-WRITE at " + here);
  CHECK(refusal_at("/dev/fd/1x").starts_with("TB-FILE-WRITE"));
  CHECK(refusal_at("/proc/self/fd/").starts_with("TB-FILE-WRITE"));
}

TEST_CASE("output: new files have the mode that the process gives, replaced ones theirs") {
  const TemporaryFolder folder;
  const mode_t before = umask(0);
  write_output(folder.path("a"), "x,y\n1,2\n", false);
  umask(before);
  CHECK(mode_of(folder.path("a")) == 0666);
  REQUIRE(chmod(folder.path("a").c_str(), 04751) == 0);
  write_output(folder.path("a"), "x,y\n3,4\n", false);
  CHECK(mode_of(folder.path("a")) == 0751);
}

TEST_CASE("output: the names of standard output and error, and a store behind one of them") {
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
  CHECK(refusal_at("/dev/fd/" + std::to_string(file)).starts_with("TB-FILE-STORE"));
  close(file);
}

TEST_CASE("signed reports: a number counts where an approval of the same document names it") {
  const auto number_in = [](const std::string& approvals, const std::string& more = R"("number":"7-1",)") {
    return signed_number_in("{" + more + R"("identification":)" + approvals + "}");
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
    CHECK(signed_number_in(other).empty());
  const std::string data = R"({"number":"7-1","identification":{"approvals":[{"number":"7-1"}]}})";
  CHECK(signed_number_in("<p id=\"report-data\">" + data + "</script></p>") == "7-1");
  CHECK(signed_number_in("<p id=\"report-data\">" + data).empty());  // cut short
  CHECK(signed_number_in("<p id=\"other-data\">" + data + "</script>").empty());
}
