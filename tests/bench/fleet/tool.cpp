// Programs of others: found in PATH, run to their end, what they print read.
#include "bench/fleet/tool.h"

#include <catch2/catch.hpp>
#include <filesystem>

#include "bench/common/error.h"
#include "tests/support/process.h"
#include "tests/support/variable.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

void write_tool(const std::string& path, bool executable) {
  write_file(path, "#!/bin/sh\n");
  std::filesystem::permissions(path, std::filesystem::perms::owner_exec,
                               executable ? std::filesystem::perm_options::add : std::filesystem::perm_options::remove);
}

}  // namespace

TEST_CASE("a program is found in the first folder of PATH that has an executable file of its name") {
  const TemporaryFolder folder;
  for (const char* name : {"a", "b", "c"}) std::filesystem::create_directories(folder.path(name));
  write_tool(folder.path("b/tb-tool"), true);
  write_tool(folder.path("c/tb-tool"), true);
  std::filesystem::create_directories(folder.path("a/tb-tool"));  // a folder is no program
  const Variable path("PATH",
                      folder.path("none") + ":" + folder.path("a") + ":" + folder.path("b") + ":" + folder.path("c"));
  CHECK(bench::find_program("tb-tool") == folder.path("b/tb-tool"));
  write_tool(folder.path("b/tb-tool"), false);
  // Root may execute no file without a mode to do so either.
  CHECK(bench::find_program("tb-tool") == folder.path("c/tb-tool"));
  std::filesystem::remove(folder.path("c/tb-tool"));
  CHECK_FALSE(bench::find_program("tb-tool"));
  CHECK_FALSE(bench::find_program("sh"));
}

TEST_CASE("without PATH programs are looked for in /usr/bin and /bin, and an empty part of it is this folder") {
  {
    const Variable none("PATH", std::nullopt);
    CHECK(bench::find_program("env") == "/usr/bin/env");
  }
  const Variable here("PATH", "/nowhere::/usr/bin");
  CHECK(bench::find_program("env") == "/usr/bin/env");
  CHECK_FALSE(bench::find_program("no-such-program"));
}

TEST_CASE("a tool's exit code and both its outputs are told, in the order written") {
  const bench::ToolResult said =
      bench::run_tool({"/bin/sh", "-c", "echo one; echo two >&2; printf three; exit 3"}, 60.0);
  CHECK(said.code == 3);
  CHECK(said.said == "one\ntwo\nthree");
  const bench::ToolResult killed = bench::run_tool({"/bin/sh", "-c", "echo x; kill -TERM $$"}, 60.0);
  CHECK(killed.code == 128 + 15);
  CHECK(killed.said == "x\n");
  const bench::ToolResult well = bench::run_tool({"/bin/true"}, 60.0);
  CHECK(well.code == 0);
  CHECK(well.said.empty());
}

TEST_CASE("a tool that does not end in its time is killed with what it started, and what it said is told") {
  const bench::ToolResult late = bench::run_tool({"/bin/sh", "-c", "echo begun; sleep 600; echo ended"}, 1.0);
  CHECK(late.code == 124);
  CHECK((late.said == "begun\n" || late.said.empty()));  // nothing on a machine that took a second to start it
}

TEST_CASE("a tool that cannot be started is refused by name") {
  try {
    (void)bench::run_tool({"/no/such/tool", "x"}, 60.0);
    FAIL("it was started");
  } catch (const bench::Error& error) {
    CHECK(error.id() == "TB-FLEET-TOOL");
    CHECK(error.code() == bench::ExitCode::kInternal);
    CHECK(error.where() == "/no/such/tool");
    CHECK(std::string(error.what()) == "it could not be started: No such file or directory");
    CHECK(error.remedy() == "check the program, and the limits of processes and memory");
  }
}

TEST_CASE("a word for the shell stands between single quotes, and a quote within it comes through") {
  CHECK(bench::shell_word("") == "''");
  CHECK(bench::shell_word("a b$c") == "'a b$c'");
  CHECK(bench::shell_word("it's") == "'it'\\''s'");
  CHECK(bench::run_tool({"/bin/sh", "-c", "printf %s " + bench::shell_word("'a' \"b\" \\ $HOME")}, 60.0).said ==
        "'a' \"b\" \\ $HOME");
}
