// The page in a separate process next to a run: if it is frozen or killed during the run, the run ends as without it,
// to the last bit; and the page that a run starts ends by itself.
#include <catch2/catch.hpp>
#include <csignal>
#include <iterator>
#include <nlohmann/json.hpp>
#include <sstream>

#include "bench/run/control/control_client.h"
#include "tests/bench/page/served_page.h"
#include "tests/support/endless_run.h"

using namespace tactbench;
using namespace tactbench::tests;
using nlohmann::json;

namespace {

// Some 60 s of process time.
constexpr const char* kRecipe =
    "schema = 1\nname = \"short\"\nunit = \"psi\"\nturning_points = [0, 20, 0]\nstep = 5\nrepeats = 3\n"
    "[conditioning]\ncycles = 1\npeak = 20\n";

struct Folder {
  Folder() {
    (void)call(folder, {"init"});
    (void)call(folder, {"sensors", "add", "S-1", "--type", "sensor.toml"});
    write_file(folder.path("short.toml"), kRecipe);
  }
  [[nodiscard]] std::vector<std::string> run_arguments(const std::string& db, const std::string& rate) const {
    const std::string line = "run short.toml --bench bench.toml --sensor S-1 --operator t --seed 5 -q --db " + db +
                             " --rate " + rate + fmt::format(" --set bench.id=\"page-{}\"", getpid());
    std::istringstream words(line);
    return {std::istream_iterator<std::string>(words), {}};
  }
  [[nodiscard]] std::string hash(const std::string& db) const {
    const Finished shown = call(folder, {"runs", "show", "1", "--json", "--db", db});
    INFO(shown.err);
    REQUIRE(shown.code == 0);
    const json run = json::parse(shown.out);
    CHECK(run["outcome"] == "completed");
    return run["content_sha256"];
  }
  // With a shell for its folder; what it says goes to `log`.
  [[nodiscard]] std::unique_ptr<ChildProcess> start(const std::vector<std::string>& words,
                                                    const std::string& log) const {
    write_file(folder.path(log), "");
    std::string line = fmt::format("cd '{}' && exec '{}'", folder.path(), program_path());
    for (const std::string& word : words) line += fmt::format(" '{}'", word);
    return std::make_unique<ChildProcess>(std::vector<std::string>{"/bin/sh", "-c", line + " >" + log + " 2>&1"});
  }
  TemporaryFolder folder;
};

struct Link {
  std::uint16_t port = 0;
  std::string token;
};

Link link_in(const std::string& text) {
  const std::size_t at = text.find("http://127.0.0.1:");
  if (at == std::string::npos || text.find('\n', at) == std::string::npos) return {};
  const std::size_t hash = text.find('#', at);
  return {static_cast<std::uint16_t>(std::stoi(text.substr(at + 17))), text.substr(hash + 1, 32)};
}

std::string get_events(const Link& link) {
  return fmt::format("GET /events HTTP/1.1\r\nHost: 127.0.0.1:{}\r\nAuthorization: Bearer {}\r\n\r\n", link.port,
                     link.token);
}

}  // namespace

TEST_CASE("page next to a run: stopping or killing the page during a run does not change the content of the run") {
  Folder here;
  (void)call(here.folder, {"sensors", "add", "S-1", "--type", "sensor.toml", "--db", "alone.db"});
  REQUIRE(here.start(here.run_arguments("alone.db", "1000"), "alone")->wait() == 0);
  const std::string alone = here.hash("alone.db");
  for (const int number : {SIGSTOP, SIGKILL}) {
    INFO("signal " << number);
    const std::string db = fmt::format("seen-{}.db", number);
    (void)call(here.folder, {"sensors", "add", "S-1", "--type", "sensor.toml", "--db", db});
    const auto page = here.start({"page", "--db", db, "--port", "0", "--operator", "bob"}, "page");
    Link link;
    REQUIRE(comes_true([&] { return (link = link_in(read_file(here.folder.path("page")))).port != 0; }));
    RawClient viewer(link.port);
    REQUIRE(viewer.send(get_events(link)));
    const auto run = here.start(here.run_arguments(db, "20"), "run");
    REQUIRE(viewer.read(60'000, "event: picture").find("event: picture") != std::string::npos);
    REQUIRE(viewer.read(60'000, "\"live\":true").find("\"live\":true") != std::string::npos);
    page->signal(number);
    CHECK(run->wait() == 0);
    CHECK(here.hash(db) == alone);
  }
}

TEST_CASE("page next to a run: started by the run it shows the run, and ends after it when nobody is viewing") {
  Folder here;
  std::vector<std::string> words = here.run_arguments("runs.db", "20");
  words.emplace_back("--page");
  const auto run = here.start(words, "run");
  Link link;
  REQUIRE(comes_true([&] { return (link = link_in(read_file(here.folder.path("run")))).port != 0; }));
  // The page can be there before the run is; each answer ends its connection, so that none is waited for in vain.
  CHECK(comes_true([&] {
    RawClient asks(link.port);
    return asks.send(fmt::format("GET /runs HTTP/1.1\r\nHost: 127.0.0.1:{}\r\nAuthorization: Bearer {}\r\n"
                                 "Connection: close\r\n\r\n",
                                 link.port, link.token)) &&
           asks.read(60'000, "\"lives\":true").find("\"lives\":true") != std::string::npos;
  }));
  CHECK(run->wait() == 0);
  CHECK(comes_true([&] { return !RawClient(link.port).send("x"); }));
}
