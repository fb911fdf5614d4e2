// Which kind of file may replace which.
#include "bench/common/output_file.h"

#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>
#include <catch2/catch.hpp>

#include <filesystem>

#include "bench/common/error.h"
#include "bench/common/signed_number.h"
#include "db/run_store.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::bench;
using namespace tactbench::tests;

namespace {

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

TEST_CASE("a file is replaced by its own kind, by another kind on request, and a store never") {
  const TemporaryFolder folder;
  const std::string path = folder.path("out/m.json"), notes = folder.path("notes.txt");
  CHECK(error_of(path, kModel).empty());
  CHECK(read_file(path) == kModel);
  const std::string second = std::string(kModel) + " ";
  CHECK(error_of(path, second).empty());
  CHECK(read_file(path) == second);
  CHECK(error_of(path, "x,y\n1,2\n") == "TB-FILE-EXISTS");
  write_file(notes, "my notes\n");
  CHECK(error_of(notes, kModel) == "TB-FILE-EXISTS");
  CHECK(error_of(notes, "other notes\n") == "TB-FILE-EXISTS");  // of no kind is not of one kind
  CHECK(read_file(notes) == "my notes\n");
  CHECK(error_of(notes, kModel, true).empty());
  CHECK(read_file(notes) == kModel);
  write_file(notes, "");
  CHECK(error_of(notes, "x,y\n1,2\n").empty());

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

TEST_CASE("a link is kept, and its target is replaced") {
  const TemporaryFolder folder;
  write_file(folder.path("real.json"), kModel);
  std::filesystem::create_symlink("real.json", folder.path("link.json"));
  const std::string second = std::string(kModel) + " ";
  CHECK(error_of(folder.path("link.json"), second).empty());
  CHECK(std::filesystem::is_symlink(folder.path("link.json")));
  CHECK(read_file(folder.path("real.json")) == second);
}

TEST_CASE("devices and pipes are written into") {
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

TEST_CASE("a store's lock and a signed report are never overwritten by any kind of file") {
  const TemporaryFolder folder;
  (void)db::RunStore::open(folder.path("runs.db"));
  write_file(folder.path("runs.db-lock"), "");
  CHECK(error_of(folder.path("runs.db-lock"), kModel, true) == "TB-FILE-STORE");
  CHECK(error_of(folder.path("other.db-lock"), kModel).empty());  // beside no store
  REQUIRE(mkfifo(folder.path("pipe").c_str(), 0600) == 0);
  CHECK(error_of(folder.path("pipe-lock"), kModel).empty());  // a pipe is no store, and is not waited for
  const std::string data =
      R"({"schema":"tactbench.report","number":"1-0a","identification":{"approvals":[{"number":"1-0a"}]}})";
  const std::string head =
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n<meta "
      "http-equiv=\"Content-Security-Policy\"";
  const auto page = [&](const std::string& inside) {
    return head + "/><script type=\"application/json\" id=\"report-data\">" + inside + "</script>";
  };
  std::string unsigned_data = data;
  unsigned_data.replace(data.rfind("1-0a"), 4, "1-0b");  // an earlier report of the run was signed
  CHECK(signed_number_in(data) == "1-0a");
  CHECK(signed_number_in(page(data)) == "1-0a");
  CHECK(signed_number_in(page(unsigned_data)).empty());
  CHECK(signed_number_in(page("{")).empty());
  CHECK(signed_number_in(head).empty());
  const std::string html = folder.path("run.html"), json = folder.path("run.json");
  write_file(html, page(unsigned_data));
  CHECK(error_of(html, page(data)).empty());
  CHECK(error_of(html, page(unsigned_data)) == "TB-REPORT-SIGNED");
  CHECK(error_of(html, page(unsigned_data), true) == "TB-REPORT-SIGNED");
  write_file(json, data);
  CHECK(error_of(json, kModel, true) == "TB-REPORT-SIGNED");
  CHECK(read_file(html) == page(data));
}
