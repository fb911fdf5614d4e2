// Requests that the page's server refuses, by raw sockets: the real server with a real store. access_rules.cpp has the
// rules.
#include <catch2/catch.hpp>
#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "tests/bench/page/served_page.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

// A page over a store with one run.
class GuardedPage : public WordsPage {
 public:
  explicit GuardedPage(const std::function<void(bench::PageOptions&)>& change = {})
      : WordsPage([&](bench::PageOptions& page) {
          db::RunStore store = db::RunStore::open(page.db);
          (void)begin_example(store);
          page.http.request_timeout = std::chrono::milliseconds(1500);
          if (change) change(page);
        }) {}
  // The whole answer to one request; `fields`: lines of the head.
  [[nodiscard]] std::string ask(const std::string& line, const std::string& token, const std::string& fields = {},
                                const std::string& body = {}) const {
    RawClient client(server->port());
    const std::string length = body.empty() ? "" : fmt::format("Content-Length: {}\r\n", body.size());
    (void)client.send(head(line, token, "Connection: close\r\n" + fields + length) + body);
    return client.read();
  }
  [[nodiscard]] const std::string& reads() const { return server->access().read_token; }
  [[nodiscard]] const std::string& commands() const { return server->access().command_token; }
};

constexpr const char* kJson = "Content-Type: application/json\r\nX-Tactbench: 1\r\n";
constexpr const char* kPause = R"({"word":"pause","run":1})";

}  // namespace

TEST_CASE("page: reading needs the token of the link in a header, and a request from its own name and page") {
  const GuardedPage page;
  for (const std::string& token : {page.reads(), page.commands()})
    CHECK(status_of(page.ask("GET /runs", token, "Sec-Fetch-Site: same-origin\r\n")) == 200);
  struct Row {
    int status;
    std::string line, token, fields;
  };
  const std::string read = page.reads();
  const std::vector<Row> rows = {
      {401, "GET /runs", "", ""},
      {401, "GET /events", "", ""},
      {401, "GET /runs", "0123456789abcdef0123456789abcdef", ""},
      {401, "GET /runs", read, fmt::format("Authorization: Bearer {}\r\n", read)},  // twice
      {401, "GET /runs?token=" + read, "", ""},
      {403, "GET /runs", read, "Origin: http://evil.example\r\n"},
      {403, "GET /runs", read, "Origin: null\r\n"},
      {403, "GET /runs", read, "Sec-Fetch-Site: cross-site\r\n"},
      {405, "DELETE /runs", read, ""},
      {404, "GET /nothing", read, ""},
      {404, "GET /../../etc/passwd", read, ""},
      {404, "GET /%2e%2e/%2e%2e/etc/passwd", read, ""},
      {404, "GET /document/../runs.db", "", ""},
      {404, "GET /document/0123456789abcdef0123456789abcdef", "", ""},
  };
  for (const Row& row : rows) {
    INFO(row.line << row.fields);
    const std::string answer = page.ask(row.line, row.token, row.fields);
    CHECK(status_of(answer) == row.status);
    for (const std::string& secret : {read, page.commands(), std::string("S-1")})  // the sensor of the store
      CHECK(answer.find(secret) == std::string::npos);
  }
}

TEST_CASE("page: commanding needs the token of the operator, and a same-origin JSON request of the page") {
  const GuardedPage page;
  const auto commanded = [&](const std::string& token, const std::string& fields, const std::string& body) {
    return status_of(page.ask("POST /command", token, fields, body));
  };
  CHECK(commanded(page.commands(), kJson, kPause) == 200);
  CHECK(commanded("", kJson, kPause) == 401);
  CHECK(commanded(page.reads(), kJson, kPause) == 401);
  CHECK(commanded(page.commands(), "Content-Type: text/plain\r\n", kPause) == 415);
  CHECK(commanded(page.commands(), "Content-Type: application/json\r\n", kPause) == 403);
  CHECK(commanded(page.commands(), kJson + std::string("Origin: http://evil.example\r\n"), kPause) == 403);
  CHECK(status_of(page.ask("GET /command?word=panic", page.commands())) == 405);
  for (const std::string& none : {std::string("pause"), std::string(R"(["pause"])"), std::string(2000, '['),
                                  std::string(R"({"word":7,"run":"x"})"), std::string(R"({"word":"reboot","run":1})")})
    CHECK(commanded(page.commands(), kJson, none) == 400);
  const GuardedPage without([](bench::PageOptions& options) { options.operator_name.clear(); });
  CHECK(without.commands().empty());
  CHECK(status_of(without.ask("POST /command", "", std::string("Authorization: Bearer \r\n") + kJson, kPause)) == 401);
}

TEST_CASE("page: a missing body and slowly sent requests do not block other requests") {
  const GuardedPage page;
  RawClient announced(page.server->port());
  REQUIRE(announced.send(page.head("POST /command", "", "Content-Length: 1000000\r\n")));
  CHECK(status_of(announced.read(5000)) == 413);
  std::vector<std::unique_ptr<RawClient>> slow;
  for (int i = 0; i < 20; ++i) {
    slow.push_back(std::make_unique<RawClient>(page.server->port()));
    REQUIRE(slow.back()->send("GET /runs HTTP/1.1\r\nHost: "));
  }
  CHECK(status_of(page.ask("GET /runs", page.reads())) == 200);
  for (const auto& one : slow) CHECK(one->closed(20'000));  // after 1.5 s here; one that drips does not hold on
  RawClient drips(page.server->port());
  bool kept = true;
  for (int i = 0; i < 200 && kept; ++i) kept = drips.send("G") && !drips.closed(20);
  CHECK_FALSE(kept);
}

TEST_CASE("page: every answer has the security headers, and the page loads nothing from other sites") {
  const GuardedPage page;
  for (const char* path : {"/", "/page.js", "/nothing", "/runs"}) {
    INFO(path);
    const std::string answer = page.ask(fmt::format("GET {}", path), page.reads());
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
    std::string body = body_of(page.ask(fmt::format("GET {}", file), ""));
    CHECK(body.size() > 200);
    const std::size_t names_svg = body.find("http://www.w3.org/2000/svg");  // a name, which nothing loads
    if (names_svg != std::string::npos) body.erase(names_svg, 26);
    CHECK_THAT(body, !Catch::Contains("http://") && !Catch::Contains("https://") && !Catch::Contains("innerHTML") &&
                         !Catch::Contains(" onclick=") && !Catch::Contains("eval("));
  }
}
