// Answers of the page's server: the first events of a viewer, each path with data of the store, documents, and links.
#include <sys/wait.h>
#include <unistd.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bench/page/access.h"
#include "tests/bench/cli/verb_here.h"
#include "tests/bench/page/served_page.h"
#include "tests/support/endless_run.h"

using namespace tactbench;
using namespace tactbench::tests;
using nlohmann::json;

namespace {

// The data of that event, the n-th of its name.
json event_in(const std::string& text, const std::string& name, std::size_t number = 0) {
  const std::string mark = "event: " + name + "\ndata: ";
  std::size_t at = text.find(mark);
  for (std::size_t i = 0; i < number && at != std::string::npos; ++i) at = text.find(mark, at + 1);
  if (at == std::string::npos) return {};
  const std::size_t from = at + mark.size();
  return json::parse(text.substr(from, text.find("\n\n", from) - from));
}

std::size_t events_in_text(const std::string& text, const std::string& mark) {
  std::size_t count = 0;
  for (std::size_t at = text.find(mark); at != std::string::npos; at = text.find(mark, at + 1)) ++count;
  return count;
}

void store_page_run(const std::string& path) {
  db::RunStore store = db::RunStore::open(path, db::Durability::kNormal);
  (void)store_example(store);
}

}  // namespace

TEST_CASE("page server: a viewer gets its rights, the state and the picture at once, and the state each second") {
  WordsPage page([](bench::PageOptions& options) { store_page_run(options.db); });
  REQUIRE(comes_true([&] {  // it has looked into the store
    RawClient looks(page.server->port());
    (void)looks.send(page.head("GET /events", page.server->access().read_token));
    return looks.read(100, "event: picture").find("event: picture") != std::string::npos;
  }));
  RawClient reader(page.server->port()), commander(page.server->port());
  REQUIRE(reader.send(page.head("GET /events", page.server->access().read_token)));
  REQUIRE(commander.send(page.head("GET /events", page.server->access().command_token)));
  const std::string first = reader.read(20'000, "event: picture");
  CHECK(event_in(first, "hello") == json({{"operator", ""}, {"commands", true}, {"night", false}}));
  CHECK(event_in(first, "state")["live"] == false);
  CHECK(event_in(first, "state")["view"]["run"] == 1);
  CHECK(event_in(reader.read(20'000, "\n\nevent: state"), "picture")["run"] == 1);
  CHECK(event_in(commander.read(20'000, "event: state"), "hello")["operator"] == "bob");
  const auto begun = std::chrono::steady_clock::now();
  CHECK(comes_true([&] { return events_in_text(reader.read(50, "never"), "event: state") >= 4; }));
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  CHECK(seconds > 1.5);  // nothing is new: three more at a second each, the first of them at any time
  WordsPage without([](bench::PageOptions& options) {
    options.operator_name.clear();
    options.night = "night.html";
  });
  RawClient other(without.server->port());
  REQUIRE(other.send(without.head("GET /events", without.server->access().read_token)));
  const std::string hello = other.read(20'000, "event: state");
  CHECK(event_in(hello, "hello") == json({{"operator", ""}, {"commands", false}, {"night", true}}));
  CHECK(hello.find("event: picture") == std::string::npos);
}

TEST_CASE("page server: paths that read the store answer 503 without a store") {
  WordsPage page;
  for (const char* path : {"/runs", "/sensors", "/loop?run=1", "/make/report?run=1"})
    CHECK(page.data_of(path, 503).contains("error"));
  store_page_run(page.options.db);
  CHECK(page.data_of("/runs")["runs"][0]["run"] == 1);
  CHECK(page.data_of("/sensors")["sensors"][0]["serial"] == "S-1");
  const json loop = page.data_of("/loop?run=1");
  CHECK(loop["taxel"] == -1);
  CHECK(loop["last"] == 3);
  CHECK(loop["x"].size() == 2);  // without the void branch
  const json whole = page.data_of("/loop?run=1&taxel=4"), rest = page.data_of("/loop?run=1&taxel=4&after=2");
  CHECK(rest["last"] == 3);
  CHECK((rest["x"] == json::array({whole["x"].back()}) && rest["y"] == json::array({whole["y"].back()})));
  CHECK_THAT(page.data_of("/loop?run=9", 500)["error"].get<std::string>(), Catch::Contains("9"));
}

TEST_CASE("page server: documents that cannot be made are errors, a nightly page is kept") {
  WordsPage page([](bench::PageOptions& options) { store_page_run(options.db); });
  for (const char* none : {"/make/sensor", "/make/sensor?serial=S-9", "/make/night"})
    CHECK(page.data_of(none, 404).contains("error"));
  for (const auto& [path, run] : {std::pair("/make/report?run=9", "9"),
                                  {"/make/report", "0"},
                                  {"/make/compare?run=1&with=8", "8"},
                                  {"/make/compare?run=7&with=1", "7"}})
    CHECK_THAT(page.data_of(path, 500)["error"].get<std::string>(), Catch::Contains(run));
  CHECK(status_of(page.get("/document/0123")) == 404);
  CHECK(status_of(page.get("/nowhere")) == 404);
  WordsPage night([](bench::PageOptions& options) {
    store_page_run(options.db);
    options.night = options.db + ".html";
    write_file(options.night, "<p>night</p>");
  });
  const std::string path = night.data_of("/make/night")["path"];
  CHECK_THAT(path, Catch::StartsWith("/document/"));
  const std::string document = night.get(path);
  CHECK(body_of(document) == "<p>night</p>");
  CHECK_THAT(document, Catch::Contains("\r\nContent-Type: text/html; charset=utf-8\r\n") &&
                           Catch::Contains("sandbox allow-popups"));
}

TEST_CASE("page server: links contain the tokens, and its own names are accepted as hosts") {
  WordsPage page([](bench::PageOptions& options) { options.names = {"rig"}; });
  const bench::PageAccess& access = page.server->access();
  const std::string place = fmt::format("http://127.0.0.1:{}/#{}", page.server->port(), access.read_token);
  CHECK(page.server->readers_link() == place);
  CHECK(page.server->link() == place + "." + access.command_token);
  const auto asks = [](const WordsPage& of, const std::string& host) {
    RawClient client(of.server->port());
    (void)client.send(
        fmt::format("GET / HTTP/1.1\r\nHost: {}:{}\r\nConnection: close\r\n\r\n", host, of.server->port()));
    return status_of(client.read());
  };
  for (const char* name : {"127.0.0.1", "localhost", "[::1]", "rig", "RIG"}) CHECK(asks(page, name) == 200);
  CHECK(asks(page, "other") == 421);
  const WordsPage everywhere([](bench::PageOptions& options) {
    options.http.address = "0.0.0.0";
    options.operator_name.clear();
  });
  CHECK(everywhere.server->access().command_token.empty());
  std::vector<std::string> addresses = bench::own_addresses(false), places;
  addresses.insert(addresses.begin(), "127.0.0.1");
  for (const std::string& address : addresses) {
    CHECK(asks(everywhere, address) == 200);
    places.push_back(
        fmt::format("http://{}:{}/#{}", address, everywhere.server->port(), everywhere.server->access().read_token));
  }
  CHECK(everywhere.server->links() == places);
  CHECK(asks(everywhere, "192.0.2.200") == 421);  // of documents, no machine's
}

TEST_CASE("page server: ends on request, or after the process next to it has ended and nobody is viewing") {
  bench::PageOptions options;
  bench::PageServer server(options);
  int asked = 0;
  server.serve([&] { return ++asked == 2; });
  CHECK(asked == 2);
  const pid_t ended = ::fork();
  if (ended == 0) ::_exit(0);
  ::waitpid(ended, nullptr, 0);
  options.run_process = ended;
  bench::PageServer beside(options);
  asked = 0;
  beside.serve([&] {
    ++asked;
    return asked > 100;
  });
  CHECK(asked == 1);
  options.run_process = ::getpid();
  bench::PageServer lives(options);
  asked = 0;
  lives.serve([&] { return ++asked == 3; });
  CHECK(asked == 3);
}

TEST_CASE("page server: a command without a live run is refused, and logged with the sender") {
  Captured noted(stderr);
  WordsPage page([](bench::PageOptions& options) { store_page_run(options.db); });
  const json answer = page.command({{"word", "pause"}, {"run", 1}});
  page.stop();
  CHECK(answer["taken"] == false);
  CHECK_THAT(noted.text(), Catch::StartsWith("bob") && Catch::Contains("{\"run\":1,\"word\":\"pause\"}"));
}
