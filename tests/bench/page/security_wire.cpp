// What the page's server refuses, row by row, by raw sockets: the real server with a real store.
#include <catch2/catch.hpp>
#include <chrono>
#include <memory>
#include <nlohmann/json.hpp>
#include <thread>
#include <vector>

#include "bench/page/page_server.h"
#include "db/run_store.h"
#include "tests/bench/page/raw_http.h"
#include "tests/db/store_example.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::bench;
using namespace tactbench::tests;

namespace {

// A page over a store with one run.
class Page {
 public:
  explicit Page(const std::function<void(PageOptions&)>& change = {}) {
    db::RunStore store = db::RunStore::open(folder_.path("runs.db"));
    run = begin_example(store).run;
    PageOptions options;
    options.db = folder_.path("runs.db");
    options.operator_name = "bob";
    options.http.longest_request = std::chrono::milliseconds(1500);
    if (change) change(options);
    server_ = std::make_unique<PageServer>(options);
    thread_ = std::thread([this] { server_->serve([] { return false; }); });
  }
  ~Page() {
    server_->stop();
    thread_.join();
  }
  Page(const Page&) = delete;
  Page& operator=(const Page&) = delete;
  [[nodiscard]] std::uint16_t port() const { return server_->port(); }
  [[nodiscard]] const std::string& read_token() const { return server_->access().read_token; }
  [[nodiscard]] const std::string& command_token() const { return server_->access().command_token; }
  [[nodiscard]] std::string host() const { return fmt::format("127.0.0.1:{}", port()); }

  // The whole answer to one request; `fields`: lines of the head after Host.
  [[nodiscard]] std::string ask(const std::string& line, const std::string& fields = {}, const std::string& body = {},
                                std::string host_name = {}) const {
    if (host_name.empty()) host_name = host();
    RawClient client(port());
    const std::string length = body.empty() ? "" : fmt::format("Content-Length: {}\r\n", body.size());
    (void)client.send(fmt::format("{} HTTP/1.1\r\nHost: {}\r\nConnection: close\r\n{}{}\r\n{}", line, host_name, fields,
                                  length, body));
    return client.read();
  }
  [[nodiscard]] std::string reads() const { return fmt::format("Authorization: Bearer {}\r\n", read_token()); }
  [[nodiscard]] std::string commands() const { return fmt::format("Authorization: Bearer {}\r\n", command_token()); }

  std::int64_t run = 0;

 private:
  TemporaryFolder folder_;
  std::unique_ptr<PageServer> server_;
  std::thread thread_;
};

constexpr const char* kJson = "Content-Type: application/json\r\nX-Tactbench: 1\r\n";
constexpr const char* kPause = R"({"word":"pause","run":1})";

}  // namespace

TEST_CASE("page: who may read: the link's token, in a header, from this server's own name and page") {
  const Page page;
  CHECK(status_of(page.ask("GET /runs", page.reads())) == 200);
  CHECK(status_of(page.ask("GET /runs", page.commands())) == 200);
  struct Row {
    const char* name;
    std::string line, fields, host;
    int status;
  };
  const std::string wrong = "Authorization: Bearer 0123456789abcdef0123456789abcdef\r\n";
  const std::vector<Row> rows = {
      {"no token", "GET /runs", "", "", 401},
      {"no token for the stream", "GET /events", "", "", 401},
      {"wrong token", "GET /runs", wrong, "", 401},
      {"half a token", "GET /runs", "Authorization: Bearer " + page.read_token().substr(0, 16) + "\r\n", "", 401},
      {"a token of another kind", "GET /runs", "Authorization: Basic " + page.read_token() + "\r\n", "", 401},
      {"two tokens", "GET /runs", page.reads() + page.reads(), "", 401},
      {"token in the address", "GET /runs?token=" + page.read_token(), "", "", 401},
      {"foreign Host", "GET /runs", page.reads(), "evil.example:" + std::to_string(page.port()), 421},
      {"foreign Host for the page itself", "GET /", "", "evil.example", 421},
      {"Host without the port", "GET /runs", page.reads(), "127.0.0.1", 421},
      {"foreign Origin", "GET /runs", page.reads() + "Origin: http://evil.example\r\n", "", 403},
      {"Origin of another port", "GET /runs", page.reads() + "Origin: http://127.0.0.1:1\r\n", "", 403},
      {"Origin null", "GET /runs", page.reads() + "Origin: null\r\n", "", 403},
      {"another site", "GET /runs", page.reads() + "Sec-Fetch-Site: cross-site\r\n", "", 403},
      {"own site", "GET /runs", page.reads() + "Sec-Fetch-Site: same-origin\r\n", "", 200},
      {"another method", "POST /runs", page.reads(), "", 405},
      {"DELETE", "DELETE /runs", page.reads(), "", 405},
      {"no such place", "GET /nothing", page.reads(), "", 404},
      {"path traversal", "GET /../../etc/passwd", page.reads(), "", 404},
      {"encoded traversal", "GET /%2e%2e/%2e%2e/etc/passwd", page.reads(), "", 404},
      {"traversal in a document's name", "GET /document/../runs.db", "", "", 404},
      {"a guessed document", "GET /document/0123456789abcdef0123456789abcdef", "", "", 404},
      {"no HTTP", "nonsense", "", "", 400},
  };
  for (const Row& row : rows) {
    INFO(row.name);
    const std::string answer = page.ask(row.line, row.fields, {}, row.host);
    CHECK(status_of(answer) == row.status);
    if (row.status == 200) continue;
    CHECK(answer.find(page.read_token()) == std::string::npos);
    CHECK(answer.find(page.command_token()) == std::string::npos);
    CHECK(answer.find("S-1") == std::string::npos);  // the sensor of the store
  }
}

TEST_CASE("page: who may command: the operator's token, by the page's own kind of request") {
  const Page page;
  struct Row {
    const char* name;
    std::string line, fields, body;
    int status;
  };
  const std::vector<Row> rows = {
      {"as the page does; no run is live", "POST /command", page.commands() + kJson, kPause, 200},
      {"no token", "POST /command", kJson, kPause, 401},
      {"a reader's token", "POST /command", page.reads() + kJson, kPause, 401},
      {"a form", "POST /command", page.commands() + "Content-Type: application/x-www-form-urlencoded\r\n", "word=pause",
       415},
      {"a form that looks like JSON", "POST /command", page.commands() + "Content-Type: text/plain\r\n", kPause, 415},
      {"without the page's own field", "POST /command", page.commands() + "Content-Type: application/json\r\n", kPause,
       403},
      {"foreign Origin", "POST /command", page.commands() + kJson + "Origin: http://evil.example\r\n", kPause, 403},
      {"another site", "POST /command", page.commands() + kJson + "Sec-Fetch-Site: same-site\r\n", kPause, 403},
      {"by GET", "GET /command", page.commands() + kJson, "", 405},
      {"by GET with a query", "GET /command?word=panic", page.commands(), "", 405},
      {"no JSON", "POST /command", page.commands() + kJson, "pause", 400},
      {"JSON of another shape", "POST /command", page.commands() + kJson, R"(["pause"])", 400},
      {"members of other types", "POST /command", page.commands() + kJson, R"({"word":7,"run":"x"})", 400},
      {"no word", "POST /command", page.commands() + kJson, R"({"word":"reboot","run":1})", 400},
      {"deeply nested", "POST /command", page.commands() + kJson, std::string(2000, '['), 400},
  };
  for (const Row& row : rows) {
    INFO(row.name);
    CHECK(status_of(page.ask(row.line, row.fields, row.body)) == row.status);
  }
  const Page without([](PageOptions& options) { options.operator_name.clear(); });
  CHECK(without.command_token().empty());
  CHECK(status_of(without.ask("POST /command", std::string("Authorization: Bearer \r\n") + kJson, kPause)) == 401);
  CHECK(status_of(without.ask("GET /runs", "Authorization: Bearer \r\n")) == 401);
}

TEST_CASE("page: a request too long in bytes or in time is refused, and others are served meanwhile") {
  const Page page;
  CHECK(status_of(page.ask("GET /runs", page.reads() + "X-Long: " + std::string(9000, 'x') + "\r\n")) == 431);
  CHECK(status_of(page.ask("GET /" + std::string(20'000, 'x'), page.reads())) == 431);
  CHECK(status_of(page.ask("POST /command", page.commands() + kJson, std::string(5000, ' '))) == 413);
  RawClient announced(page.port());  // a body that never comes
  REQUIRE(announced.send(
      fmt::format("POST /command HTTP/1.1\r\nHost: {}\r\nContent-Length: 1000000\r\n\r\n", page.host())));
  CHECK(status_of(announced.read(5000)) == 413);
  std::vector<std::unique_ptr<RawClient>> slow;
  for (int i = 0; i < 20; ++i) {
    slow.push_back(std::make_unique<RawClient>(page.port()));
    REQUIRE(slow.back()->send("GET /runs HTTP/1.1\r\nHost: "));
  }
  CHECK(status_of(page.ask("GET /runs", page.reads())) == 200);
  for (const auto& one : slow) CHECK(one->closed(20'000));  // after 1.5 s here; one that drips does not hold on
  RawClient drips(page.port());
  bool kept = true;
  for (int i = 0; i < 200 && kept; ++i) {
    kept = drips.send("G");
    kept = kept && !drips.closed(20);
  }
  CHECK_FALSE(kept);
}

TEST_CASE("page: more viewers or connections than are allowed are sent away, and a place becomes free again") {
  const Page page([](PageOptions& options) { options.http.most_viewers = 3; });
  const std::string open = fmt::format("GET /events HTTP/1.1\r\nHost: {}\r\n{}\r\n", page.host(), page.reads());
  std::vector<std::unique_ptr<RawClient>> viewers;
  for (int i = 0; i < 3; ++i) {
    viewers.push_back(std::make_unique<RawClient>(page.port()));
    REQUIRE(viewers.back()->send(open));
    CHECK_THAT(viewers.back()->read(20'000, "event: state"), Catch::StartsWith("HTTP/1.1 200 "));
  }
  RawClient fourth(page.port());
  REQUIRE(fourth.send(open));
  const std::string refused = fourth.read(20'000);
  CHECK(status_of(refused) == 503);
  CHECK_THAT(refused, Catch::Contains("Retry-After: 10\r\n"));
  viewers.pop_back();
  bool free = false;
  for (int i = 0; i < 100 && !free; ++i) {
    RawClient again(page.port());
    (void)again.send(open);
    free = status_of(again.read(20'000, "\n\n")) == 200;
  }
  CHECK(free);
  CHECK(status_of(page.ask("GET /runs", page.reads())) == 200);
}

TEST_CASE("page: every answer carries the fields that keep it to itself, and the page loads from nowhere else") {
  const Page page;
  for (const std::string& path :
       {std::string("/"), std::string("/page.js"), std::string("/nothing"), std::string("/runs")}) {
    INFO(path);
    const std::string answer = page.ask("GET " + path, page.reads());
    for (const char* field :
         {"Content-Security-Policy: default-src 'none';", "frame-ancestors 'none'", "X-Content-Type-Options: nosniff",
          "Referrer-Policy: no-referrer", "Cache-Control: no-store", "Cross-Origin-Resource-Policy: same-origin"})
      CHECK_THAT(answer, Catch::Contains(field));
    CHECK_THAT(answer, !Catch::Contains("Access-Control-Allow") && !Catch::Contains("Set-Cookie") &&
                           !Catch::Contains("unsafe-"));
  }
  for (const char* file : {"/", "/page.css", "/page.js", "/link.js", "/draw.js", "/now.js", "/panels.js", "/seen.js",
                           "/store.js", "/icon.svg"}) {
    INFO(file);
    const std::string answer = page.ask(fmt::format("GET {}", file));
    CHECK(status_of(answer) == 200);
    std::string body = body_of(answer);
    CHECK(body.size() > 200);
    const std::size_t names_svg = body.find("http://www.w3.org/2000/svg");  // a name, which nothing loads
    if (names_svg != std::string::npos) body.erase(names_svg, 26);
    CHECK_THAT(body, !Catch::Contains("http://") && !Catch::Contains("https://") && !Catch::Contains("innerHTML") &&
                         !Catch::Contains(" onclick=") && !Catch::Contains("eval("));
  }
}

TEST_CASE("page: it listens on loopback alone unless told otherwise, and its link opens it") {
  const Page page;
  CHECK(page.read_token().size() == 32);
  CHECK(page.read_token() != page.command_token());
  CHECK(page.read_token().find_first_not_of("0123456789abcdef") == std::string::npos);
  RawClient keeps(page.port());  // two requests on one connection
  const std::string get = fmt::format("GET /runs HTTP/1.1\r\nHost: localhost:{}\r\n{}\r\n", page.port(), page.reads());
  REQUIRE(keeps.send(get + get));
  const std::string both = keeps.read(20'000);  // until the idle connection is closed
  CHECK(both.find("HTTP/1.1 200", both.find("HTTP/1.1 200") + 1) != std::string::npos);
  const nlohmann::json runs = nlohmann::json::parse(body_of(page.ask("GET /runs", page.reads())));
  REQUIRE(runs["runs"].size() == 1);
  CHECK(runs["runs"][0]["run"] == page.run);
}
