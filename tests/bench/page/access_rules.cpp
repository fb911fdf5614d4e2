// Each refusal of the page with its status and its place in the order; every place with its right, every file with its
// type, and what a target says.

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "bench/common/error.h"
#include "bench/page/access.h"
#include "bench/page/assets.h"
#include "bench/page/http/http_server.h"
#include "bench/page/http/message.h"
#include "bench/page/responses.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::bench;
using namespace tactbench::tests;

namespace {

using Fields = std::map<std::string, std::string>;

PageAccess access_of_two() {
  PageAccess access;
  access.read_token = "read";
  access.command_token = "command";
  access.hosts = {"a:1", "b:2"};
  access.scheme = "https";
  return access;
}

HttpRequest request_of(const std::string& method, const Fields& more) {
  HttpRequest request;
  request.method = method;
  request.fields = {{"host", "b:2"}};
  for (const auto& [name, value] : more) request.fields[name] = value;
  return request;
}

// The status; 0: it may.
int page_refused(PageNeeds needs, const std::string& method, const Fields& more) {
  const auto response = refusal(request_of(method, more), needs, access_of_two());
  return response ? response->status : 0;
}

constexpr int kMay = 0, kOtherSite = 403;
const Fields kPageFields = {{"content-type", "application/json"}, {"x-tactbench", "1"}};

Fields with_fields(Fields fields, const Fields& more) {
  for (const auto& [name, value] : more) fields[name] = value;
  return fields;
}

std::string fields_text(const HttpResponse& response) {
  std::string text;
  for (const auto& [name, value] : response.fields) text += name + ": " + value + "\n";
  return text;
}

}  // namespace

TEST_CASE("page access: another host, origin or site is refused, whatever right is needed") {
  for (const PageNeeds needs : {PageNeeds::kNothing, PageNeeds::kRead, PageNeeds::kCommand}) {
    CHECK(page_refused(needs, "GET", {{"host", "c:1"}}) == 421);
    CHECK(page_refused(needs, "GET", {{"origin", "http://b:2"}}) == kOtherSite);
    CHECK(page_refused(needs, "GET", {{"origin", "https://c:1"}}) == kOtherSite);
    CHECK(page_refused(needs, "GET", {{"origin", ""}}) == kOtherSite);
    CHECK(page_refused(needs, "GET", {{"origin", "https://c:1"}, {"host", "c:1"}}) == 421);
  }
  const Fields reads = {{"authorization", "Bearer read"}};
  CHECK(page_refused(PageNeeds::kRead, "GET", with_fields(reads, {{"origin", "https://a:1"}})) == kMay);
  CHECK(page_refused(PageNeeds::kRead, "GET", with_fields(reads, {{"origin", "https://b:2"}})) == kMay);
  for (const char* own : {"", "same-origin", "none"})
    CHECK(page_refused(PageNeeds::kRead, "GET", with_fields(reads, {{"sec-fetch-site", own}})) == kMay);
  for (const char* other : {"cross-site", "same-site", "x"}) {
    CHECK(page_refused(PageNeeds::kRead, "GET", with_fields(reads, {{"sec-fetch-site", other}})) == kOtherSite);
    CHECK(page_refused(PageNeeds::kCommand, "GET", {{"sec-fetch-site", other}}) == kOtherSite);
    CHECK(page_refused(PageNeeds::kNothing, "GET", {{"sec-fetch-site", other}}) == kMay);
  }
}

TEST_CASE("page hosts: are compared in lower case, without the default port of the scheme") {
  using Hosts = std::vector<std::string>;
  CHECK(hosts_of({"127.0.0.1", "Bench.Upper"}, 8765, "https") == Hosts{"127.0.0.1:8765", "bench.upper:8765"});
  CHECK(hosts_of({"Rig"}, 443, "https") == Hosts{"rig:443", "rig"});
  CHECK(hosts_of({"Rig", "[FE80::1]"}, 80, "http") == Hosts{"rig:80", "rig", "[fe80::1]:80", "[fe80::1]"});
  CHECK(hosts_of({"rig"}, 80, "https") == Hosts{"rig:80"});
  CHECK(hosts_of({"rig"}, 443, "http") == Hosts{"rig:443"});
  CHECK(page_refused(PageNeeds::kRead, "GET",
                     {{"authorization", "Bearer read"}, {"host", "B:2"}, {"origin", "https://B:2"}}) == kMay);
}

TEST_CASE(
    "page access: method is checked before token, the read token may not command, the command token may also read") {
  CHECK(page_refused(PageNeeds::kNothing, "GET", {}) == kMay);
  CHECK(page_refused(PageNeeds::kNothing, "POST", {}) == 405);
  CHECK(page_refused(PageNeeds::kRead, "POST", {}) == 405);
  for (const char* token :
       {"", "read", "Bearer", "Bearer ", "bearer read", "Bearer rea", "Bearer reads", "Bearer x", "Bearer  read"})
    CHECK(page_refused(PageNeeds::kRead, "GET", {{"authorization", token}}) == 401);
  CHECK(page_refused(PageNeeds::kRead, "GET", {{"authorization", "Bearer read"}}) == kMay);
  CHECK(page_refused(PageNeeds::kRead, "GET", {{"authorization", "Bearer command"}}) == kMay);
  const auto command = [](const Fields& more, const std::string& method = "POST") {
    return page_refused(PageNeeds::kCommand, method, with_fields(kPageFields, more));
  };
  CHECK(command({{"authorization", "Bearer command"}}) == kMay);
  CHECK(command({}, "GET") == 405);
  CHECK(command({{"content-type", "text/plain"}}) == 415);
  CHECK(command({{"content-type", ""}, {"x-tactbench", ""}}) == 415);
  CHECK(command({{"x-tactbench", "2"}}) == 403);
  CHECK(command({}) == 401);
  CHECK(command({{"authorization", "Bearer read"}}) == 401);
}

TEST_CASE("page access: tokens have 128 bits and are unique, and an empty token opens nothing") {
  std::set<std::string> seen;
  for (int i = 0; i < 200; ++i) seen.insert(new_token());
  CHECK(seen.size() == 200);
  for (const std::string& token : seen) CHECK(token.size() == 32);
  PageAccess access = access_of_two();
  const auto may = [&](const std::string& field) {
    return may_command(request_of("POST", {{"authorization", field}}), access);
  };
  CHECK(may("Bearer command"));
  CHECK_FALSE(may("Bearer read"));
  access.command_token.clear();
  for (const char* none : {"Bearer ", ""}) CHECK_FALSE(may(none));
  HttpRequest request = request_of("GET", {{"authorization", "Bearer read"}, {"host", "A:1"}});
  CHECK_FALSE(refusal(request, PageNeeds::kRead, access));
}

TEST_CASE("page responses: each file of the page has its media type and its text") {
  for (const char* name : {"page.html", "page.css", "page.js", "link.js", "draw.js", "now.js", "panels.js", "seen.js",
                           "store.js", "icon.svg"}) {
    INFO(name);
    const std::string path = name == std::string("page.html") ? "/" : std::string("/") + name;
    const auto file = page_asset(path);
    REQUIRE(file);
    CHECK(file->status == 200);
    CHECK_FALSE(file->body->empty());
    CHECK(*file->body == asset(name));
    CHECK_FALSE(file->stream);
    CHECK(needs_of(path) == PageNeeds::kNothing);
  }
  for (const auto& [path, type] : {std::pair("/", "text/html"),
                                   {"/page.css", "text/css"},
                                   {"/page.js", "text/javascript"},
                                   {"/icon.svg", "image/svg+xml"}})
    CHECK_THAT(page_asset(path)->type, Catch::StartsWith(type));
  for (const char* none :
       {"", "/page.css/", "page.js", "/make", "/make/other", "/events/", "//", "/%2e", "/document", "/commands"}) {
    INFO(none);
    CHECK_FALSE(page_asset(none));
    CHECK_FALSE(needs_of(none));
  }
}

TEST_CASE("page responses: which paths need a right, documents need only their secret name") {
  for (const char* read : {"/events", "/loop", "/runs", "/sensors", "/make/report", "/make/compare", "/make/sensor",
                           "/make/nights", "/make/night"}) {
    INFO(read);
    CHECK(needs_of(read) == PageNeeds::kRead);
    CHECK_FALSE(page_asset(read));
  }
  CHECK(needs_of("/command") == PageNeeds::kCommand);
  CHECK(needs_of("/document/12ab") == PageNeeds::kNothing);
}

TEST_CASE("page responses: a document is sandboxed, without scripts") {
  const HttpResponse document = document_response("<p>a</p>");
  CHECK(document.status == 200);
  CHECK(document.type == "text/html; charset=utf-8");
  CHECK(*document.body == "<p>a</p>");
  CHECK_THAT(fields_text(guarded(document)),
             Catch::Contains("default-src 'none'") && Catch::Contains("sandbox") && !Catch::Contains("script-src"));
}

TEST_CASE("page responses: format of JSON answers and events") {
  const HttpResponse json = json_response(418, {{"b", 1}, {"a", "x"}});
  CHECK(json.status == 418);
  CHECK(json.type == "application/json");
  CHECK(nlohmann::ordered_json::parse(*json.body).dump() == "{\"b\":1,\"a\":\"x\"}");
  CHECK(*event_text("news", {{"n", 3}}) == "event: news\ndata: {\"n\":3}\n\n");
}

TEST_CASE("page responses: query numbers are whole numbers, anything else gives the default") {
  HttpRequest request;
  request.query = {{"a", "12"}, {"b", "-3"}, {"c", "12x"}, {"d", ""}, {"e", "9223372036854775808"}, {"f", " 1"}};
  CHECK(number_in(request, "a", 5) == 12);
  CHECK(number_in(request, "b", 5) == -3);
  for (const char* none : {"c", "d", "e", "f", "g"}) CHECK(number_in(request, none, 5) == 5);
  CHECK(number_in(request, "g") == 0);
}

TEST_CASE("page targets: percent escapes are decoded in upper and lower case, invalid ones are kept") {
  CHECK(url_decoded("%41%4a%4Ab%7e") == "AJJb~");
  CHECK(url_decoded("%00") == std::string(1, '\0'));
  CHECK(url_decoded("%09%90%aF%Fa%fF") == "\x09\x90\xaf\xfa\xff");
  for (const char* broken : {"%", "%4", "a%4", "%g1", "%1g", "%/0", "%:0", "%0@", "%0G", "%0`", "%0g", "x%%"})
    CHECK(url_decoded(broken) == broken);
  CHECK(url_decoded("%%41") == "%A");
  CHECK(url_decoded("a+b") == "a b");
  CHECK(url_decoded("%2B") == "+");
  CHECK(lower_case("Host-X9_\xC4") == "host-x9_\xC4");
}

TEST_CASE("page targets: query pairs with and without values, the last one of equal names counts") {
  const auto query_of = [](const std::string& target) {
    HttpRequest request;
    read_target(target, request);
    std::string text = request.path;
    for (const auto& [name, value] : request.query) text += " " + name + "=" + value;
    return text;
  };
  CHECK(query_of("/a?") == "/a");
  CHECK(query_of("?x=1") == " x=1");
  CHECK(query_of("/a?x") == "/a x=");
  CHECK(query_of("/a?x=1&x=2&y=S%20%3C1%3E+a&") == "/a x=2 y=S <1> a");
  CHECK(query_of("/a?x=1=2?y") == "/a x=1=2?y");
  CHECK(query_of("/%41?=7") == "/%41 =7");
  CHECK(query_of("/a?b%3d=%26") == "/a b==&");
}

// Why the page cannot begin: addresses that are none, and files that hold no certificate or no key.

namespace {

std::string tls_refusal(const std::string& certificate, const std::string& key) {
  try {
    (void)tls_context(certificate, key);
  } catch (const Error& error) {
    CHECK(error.id() == "TB-PAGE-CERTIFICATE");
    CHECK(error.code() == ExitCode::kUsage);
    return error.where();
  }
  return "taken";
}

Error refusal_to_listen(const HttpOptions& options) {
  try {
    const HttpServer server(options, [](const HttpRequest&, const Reply&) {});
  } catch (const Error& error) {
    return error;
  }
  FAIL("it listens");
  throw 0;
}

}  // namespace

TEST_CASE("page: an invalid address, an address of another machine and a port in use are rejected") {
  HttpOptions options;
  options.address = "not-an-address";
  options.port = 8123;
  const Error none = refusal_to_listen(options);
  CHECK(none.id() == "TB-PAGE-ADDRESS");
  CHECK(none.code() == ExitCode::kUsage);
  CHECK(none.where() == "--listen not-an-address --port 8123");
  options.address = "192.0.2.1";  // of documents, no machine's
  CHECK(refusal_to_listen(options).id() == "TB-PAGE-ADDRESS");
  HttpOptions free;
  const HttpServer first(free, [](const HttpRequest&, const Reply&) {});
  free.port = first.port();
  CHECK(free.port != 0);
  CHECK(refusal_to_listen(free).id() == "TB-PAGE-ADDRESS");
}

TEST_CASE("page: an unusable certificate or key is rejected, and the error names the file") {
  const TemporaryFolder folder;
  const auto write = [&](const char* name, const std::string& text) {
    write_file(folder.path(name), text);
    return folder.path(name);
  };
  const std::string certificate = write("c", "-----BEGIN CERTIFICATE-----\nAAAA\n-----END CERTIFICATE-----\n");
  const std::string key = write("k", "-----BEGIN PRIVATE KEY-----\nAAAA\n-----END PRIVATE KEY-----\n");
  const std::string place = folder.path(), plain = write("d", "0");
  const std::string locked =
      write("e", "-----BEGIN ENCRYPTED PRIVATE KEY-----\nAAAA\n-----END ENCRYPTED PRIVATE KEY-----\n");
  // Each pair, and the file of it that is refused.
  const std::vector<std::array<std::string, 3>> pairs = {{place, key, place},
                                                         {certificate, place, place},
                                                         {place + "/none", key, place + "/none"},
                                                         {"/dev/zero", key, "/dev/zero"},
                                                         {certificate, place + "/none", place + "/none"},
                                                         {plain, key, plain},
                                                         {key, key, key},
                                                         {certificate, certificate, certificate},
                                                         {certificate, locked, locked},
                                                         {certificate, key, certificate}};
  for (const auto& [first, second, refused] : pairs) {
    INFO(first << " " << second);
    CHECK(tls_refusal(first, second) == refused);
  }
}
