// The page's answers: every place with its right, every file with its type, every field, and what a target says.
#include "bench/page/responses.h"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "bench/page/assets.h"

using namespace tactbench::bench;

namespace {

std::string fields_text(const HttpResponse& response) {
  std::string text;
  for (const auto& [name, value] : response.fields) text += name + ": " + value + "\n";
  return text;
}

}  // namespace

TEST_CASE("page responses: each of the page's own files, its type and its text") {
  for (const char* name : {"page.html", "page.css", "page.js", "link.js", "draw.js", "now.js", "panels.js", "seen.js",
                           "store.js", "icon.svg"}) {
    INFO(name);
    const std::string path = name == std::string("page.html") ? "/" : std::string("/") + name;
    const auto file = own_file(path);
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
    CHECK_THAT(own_file(path)->type, Catch::StartsWith(type));
  for (const char* none : {"", "/page.html", "/page.css/", "page.js", "/make", "/make/other", "/events/", "//", "/%2e",
                           "/document", "/commands"}) {
    INFO(none);
    CHECK_FALSE(own_file(none));
    CHECK_FALSE(needs_of(none));
  }
}

TEST_CASE("page responses: each place that needs a right, and documents whose names are the secret") {
  for (const char* read : {"/events", "/loop", "/runs", "/sensors", "/nights", "/make/report", "/make/compare",
                           "/make/sensor", "/make/nights", "/make/night"}) {
    INFO(read);
    CHECK(needs_of(read) == PageNeeds::kRead);
    CHECK_FALSE(own_file(read));
  }
  CHECK(needs_of("/command") == PageNeeds::kCommand);
  CHECK(needs_of("/document/12ab") == PageNeeds::kNothing);
}

TEST_CASE("page responses: a document is kept in a sandbox, without scripts") {
  const HttpResponse document = document_response("<p>a</p>");
  CHECK(document.status == 200);
  CHECK(document.type == "text/html; charset=utf-8");
  CHECK(*document.body == "<p>a</p>");
  CHECK_THAT(fields_text(guarded(document)),
             Catch::Contains("default-src 'none'") && Catch::Contains("sandbox") && !Catch::Contains("script-src"));
}

TEST_CASE("page responses: JSON and events") {
  const HttpResponse json = json_response(418, {{"b", 1}, {"a", "x"}});
  CHECK(json.status == 418);
  CHECK(json.type == "application/json");
  CHECK(nlohmann::ordered_json::parse(*json.body).dump() == "{\"b\":1,\"a\":\"x\"}");
  CHECK(*event_text("news", {{"n", 3}}) == "event: news\ndata: {\"n\":3}\n\n");
}

TEST_CASE("page responses: numbers of a query are whole ones and nothing else") {
  HttpRequest request;
  request.query = {{"a", "12"}, {"b", "-3"}, {"c", "12x"}, {"d", ""}, {"e", "9223372036854775808"}, {"f", " 1"}};
  CHECK(number_in(request, "a", 5) == 12);
  CHECK(number_in(request, "b", 5) == -3);
  for (const char* none : {"c", "d", "e", "f", "g"}) CHECK(number_in(request, none, 5) == 5);
  CHECK(number_in(request, "g") == 0);
}

TEST_CASE("page targets: escapes of both cases at all places, broken ones as they are") {
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

TEST_CASE("page targets: a query's pairs, with and without values, the last one of a name") {
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
