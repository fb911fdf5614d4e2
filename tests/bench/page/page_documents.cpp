// Pages that other programs write for the page's frame: their words, at most two at a time, what failed, and how many
// are kept. By scripts in the place of the program.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include "bench/page/documents.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::bench;
using namespace tactbench::tests;

namespace {

// A program that writes what it was asked into its last word. It waits for the file `go` where the first one is `wait`,
// and notes each of its starts in `begun`.
struct ScriptedDocuments {
  explicit ScriptedDocuments(const std::string& more = {}) {
    write_file(program, "#!/bin/sh\ncd '" + folder.path() +
                            "'\nfor last in \"$@\"; do :; done\necho x >>begun\n"
                            "if [ \"$1\" = wait ]; then while [ ! -e go ]; do sleep 0.02; done; fi\n" +
                            more + "printf '%s\\n' \"$NO_COLOR\" \"$@\" >\"$last\"\n");
    std::filesystem::permissions(program, std::filesystem::perms::owner_all);
  }
  // Until that many are ready, at the latest after 20 s.
  void wait_for(std::size_t count) {
    for (int i = 0; i < 2000 && ready.size() < count; ++i) {
      documents.look();
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    REQUIRE(ready.size() == count);
  }
  void make(const std::vector<std::string>& words, const std::string& output = "-o") {
    documents.make(words, output, [this](const Document& made) { ready.push_back(made); });
  }
  [[nodiscard]] std::size_t begun() const {
    return std::filesystem::exists(folder.path("begun")) ? read_file(folder.path("begun")).size() / 2 : 0;
  }
  TemporaryFolder folder;
  std::string program = folder.path("program");
  std::vector<Document> ready;
  Documents documents{folder.path("runs.db"), program};
};

}  // namespace

TEST_CASE("page documents: are made by the requested command with store and file, each with its own secret name") {
  ScriptedDocuments made;
  CHECK_FALSE(made.documents.busy());
  made.make({"report", "5"});
  made.make({"trend", "--subject=nightly/"}, "--html");
  made.wait_for(2);
  CHECK_FALSE(made.documents.busy());
  for (const Document& one : made.ready) {
    CHECK(one.error.empty());
    CHECK(one.id.size() == 32);
  }
  CHECK(made.ready[0].id != made.ready[1].id);
  std::vector<std::string> texts = {*made.documents.text(made.ready[0].id), *made.documents.text(made.ready[1].id)};
  if (texts[0].find("trend") != std::string::npos) std::swap(texts[0], texts[1]);
  const std::string db = made.folder.path("runs.db");
  CHECK_THAT(texts[0], Catch::StartsWith("1\nreport\n5\n--db\n" + db + "\n-o\n/") && Catch::EndsWith(".html\n"));
  CHECK_THAT(texts[1], Catch::StartsWith("1\ntrend\n--subject=nightly/\n--db\n" + db + "\n--html\n/"));
  const std::string id = made.ready[0].id;
  for (const std::string& none :
       std::vector<std::string>{"", "0", std::string(32, '0'), "../" + id, id + ".html", id + "\n"})
    CHECK_FALSE(made.documents.text(none));
}

TEST_CASE("page documents: two are made at a time, six wait, and a ninth is refused") {
  ScriptedDocuments made;
  for (int i = 0; i < 8; ++i) made.make({"wait"});
  CHECK(made.ready.empty());
  for (int i = 0; i < 2000 && made.begun() < 2; ++i) {
    made.documents.look();
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  made.documents.look();
  CHECK(made.begun() == 2);
  CHECK(made.documents.busy());
  made.make({"more"});
  REQUIRE(made.ready.size() == 1);
  CHECK(made.ready[0].id.empty());
  write_file(made.folder.path("go"), "");
  made.wait_for(9);
  CHECK(made.begun() == 8);
  for (std::size_t i = 1; i < 9; ++i) CHECK(made.ready[i].error.empty());
}

TEST_CASE("page documents: if none is written, the output of the program is reported, escaped and truncated") {
  ScriptedDocuments silent("exit 0\n"), speaks("printf 'error: \\033[2J no run 5\\n' >&2; exit 2\n"),
      long_talk("printf '%05000d' 7; exit 1\n");
  silent.make({"x"});
  speaks.make({"x"});
  long_talk.make({"x"});
  silent.wait_for(1);
  speaks.wait_for(1);
  long_talk.wait_for(1);
  CHECK_FALSE(silent.ready[0].error.empty());
  CHECK_THAT(speaks.ready[0].error, Catch::Contains("no run 5") && !Catch::Contains("\x1b"));
  CHECK(long_talk.ready[0].error.size() == 2000);
  for (const ScriptedDocuments* one : {&silent, &speaks, &long_talk}) CHECK(one->ready[0].id.empty());
  ScriptedDocuments missing;
  std::filesystem::remove(missing.program);
  missing.make({"x"});
  missing.wait_for(1);
  CHECK_FALSE(missing.ready[0].error.empty());
}

TEST_CASE("page documents: the newest twelve files are kept unchanged, a too large file is refused") {
  ScriptedDocuments made;
  const std::string file = made.folder.path("night.html");
  std::vector<std::string> ids;
  for (int i = 0; i < 13; ++i) {
    write_file(file, fmt::format("page {}", i));
    const Document kept = made.documents.keep(file);
    CHECK(kept.error.empty());
    ids.push_back(kept.id);
  }
  write_file(file, "later");
  CHECK_FALSE(made.documents.text(ids[0]));
  for (int i = 1; i < 13; ++i)
    CHECK(made.documents.text(ids[static_cast<std::size_t>(i)]) == fmt::format("page {}", i));
  made.make({"a"});  // one more
  made.wait_for(1);
  CHECK_FALSE(made.documents.text(ids[1]));
  CHECK(made.documents.text(ids[2]));
  const Document none = made.documents.keep(made.folder.path("none"));
  CHECK(none.id.empty());
  std::filesystem::resize_file(file, 32U << 20U);
  CHECK(made.documents.text(made.documents.keep(file).id).value_or("").size() == 32U << 20U);
  std::filesystem::resize_file(file, (32U << 20U) + 1);
  CHECK_FALSE(made.documents.text(made.documents.keep(file).id));
}
