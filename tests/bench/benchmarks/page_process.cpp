// `benchmark page`: the page's process, with a script in its place; and the events of a stream.
#include <sys/stat.h>

#include <catch2/catch.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "bench/benchmarks/page.h"
#include "bench/benchmarks/page_viewers.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::bench;
using tests::TemporaryFolder;

namespace {

std::string page_script(const TemporaryFolder& folder, const std::string& text) {
  const std::string file = folder.path("the page");
  tests::write_file(file, "#!/bin/sh\n" + text + "\n");
  ::chmod(file.c_str(), 0700);
  return file;
}

}  // namespace

TEST_CASE("benchmark page: the page's process tells its port and the readers' token, and what it takes is read") {
  const TemporaryFolder folder;
  const std::string script = page_script(folder, R"(echo "$*" > ")" + folder.path("words") + R"("
i=0; while [ $i -lt 100000 ]; do i=$((i + 1)); done
echo '{"port": 4711,'
sleep 0.05
echo '"readers_link": "http://127.0.0.1:4711/#a-token"}'
exec sleep 60)");
  const PageProcess page(folder.path("a.db"), folder.path(), script);
  CHECK(page.port() == 4711);
  CHECK(page.token() == "a-token");
  CHECK(tests::read_file(folder.path("words")) == "page --db " + folder.path("a.db") + " --port 0 --json\n");
  CHECK(page.processor_s() > 0.01);
  CHECK(page.processor_s() < 20.0);
  CHECK(page.resident_mb() > 0.2);
  CHECK(page.resident_mb() < 500.0);
}

TEST_CASE("benchmark page: a page that does not start is an error that says what it said") {
  const TemporaryFolder folder;
  CHECK_THROWS_WITH(PageProcess("a.db", folder.path(), page_script(folder, "echo no store; echo of this name >&2")),
                    "the page does not start: no store\nof this name\n");
  CHECK_THROWS_WITH(PageProcess("a.db", folder.path(), page_script(folder, "echo '{\"port\": 0}'; exit 1")),
                    "the page does not start: {\"port\": 0}\n");
  CHECK_THROWS_WITH(PageProcess("a.db", folder.path(), page_script(folder, "echo '[4711]'")),
                    "the page does not start: [4711]\n");
}

TEST_CASE("benchmark page: a page that tells its port and ends at once has started") {
  const TemporaryFolder folder;
  const PageProcess page("a.db", folder.path(),
                         page_script(folder, "echo '{\"port\": 81, \"readers_link\": \"x#y\"}'"));
  CHECK(page.port() == 81);
  CHECK(page.token() == "y");
}

TEST_CASE("benchmark page: the events of a stream, each with its empty line, the last one as far as it came") {
  using Events = std::vector<std::string_view>;
  CHECK(events_of("").empty());
  CHECK(events_of("event: a\ndata: 1\n\n") == Events{"event: a\ndata: 1\n\n"});
  CHECK(events_of("a\n\nbc\nd\n\ne\nf") == Events{"a\n\n", "bc\nd\n\n", "e\nf"});
  CHECK(events_of("a\n\n\n\nb\n") == Events{"a\n\n", "\n\n", "b\n"});
}
