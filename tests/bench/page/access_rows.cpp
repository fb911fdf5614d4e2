// Each refusal of the page with its status, its words and its place in the order.
#include "bench/page/access.h"

#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <map>
#include <string>

using namespace tactbench::bench;

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

// "status text", or "may".
std::string page_refused(PageNeeds needs, const std::string& method, const Fields& more) {
  const auto response = refusal(request_of(method, more), needs, access_of_two());
  if (!response) return "may";
  std::string text = fmt::format("{} {}", response->status, *response->body);
  for (const auto& [name, value] : response->fields) text += name + "=" + value;
  return text;
}

const std::string kOtherSite = "403 another site's page asks\n";
const Fields kPageFields = {{"content-type", "application/json"}, {"x-tactbench", "1"}};

Fields with_fields(Fields fields, const Fields& more) {
  for (const auto& [name, value] : more) fields[name] = value;
  return fields;
}

}  // namespace

TEST_CASE("page refusals: hosts, origins and sites, whatever is needed") {
  for (const PageNeeds needs : {PageNeeds::kNothing, PageNeeds::kRead, PageNeeds::kCommand}) {
    CHECK(page_refused(needs, "GET", {{"host", "c:1"}}) ==
          "421 this server has no such name: open the address that tactbench printed\n");
    CHECK(page_refused(needs, "GET", {{"origin", "http://b:2"}}) == kOtherSite);
    CHECK(page_refused(needs, "GET", {{"origin", "https://c:1"}}) == kOtherSite);
    CHECK(page_refused(needs, "GET", {{"origin", ""}}) == kOtherSite);
    CHECK(page_refused(needs, "GET", {{"origin", "https://c:1"}, {"host", "c:1"}}).starts_with("421"));
  }
  const Fields reads = {{"authorization", "Bearer read"}};
  CHECK(page_refused(PageNeeds::kRead, "GET", with_fields(reads, {{"origin", "https://a:1"}})) == "may");
  CHECK(page_refused(PageNeeds::kRead, "GET", with_fields(reads, {{"origin", "https://b:2"}})) == "may");
  for (const char* own : {"", "same-origin", "none"})
    CHECK(page_refused(PageNeeds::kRead, "GET", with_fields(reads, {{"sec-fetch-site", own}})) == "may");
  for (const char* other : {"cross-site", "same-site", "x"}) {
    CHECK(page_refused(PageNeeds::kRead, "GET", with_fields(reads, {{"sec-fetch-site", other}})) == kOtherSite);
    CHECK(page_refused(PageNeeds::kCommand, "GET", {{"sec-fetch-site", other}}) == kOtherSite);
    CHECK(page_refused(PageNeeds::kNothing, "GET", {{"sec-fetch-site", other}}) == "may");
  }
}

TEST_CASE("page refusals: the way of asking before the token, and which token opens what") {
  CHECK(page_refused(PageNeeds::kNothing, "GET", {}) == "may");
  CHECK(page_refused(PageNeeds::kNothing, "POST", {}) == "405 only GET here\n");
  CHECK(page_refused(PageNeeds::kRead, "POST", {}) == "405 only GET here\n");
  const std::string key = "401 open the whole link that tactbench printed: its end is the key\nWWW-Authenticate=Bearer";
  for (const char* token :
       {"", "read", "Bearer", "Bearer ", "bearer read", "Bearer rea", "Bearer reads", "Bearer x", "Bearer  read"})
    CHECK(page_refused(PageNeeds::kRead, "GET", {{"authorization", token}}) == key);
  CHECK(page_refused(PageNeeds::kRead, "GET", {{"authorization", "Bearer read"}}) == "may");
  CHECK(page_refused(PageNeeds::kRead, "GET", {{"authorization", "Bearer command"}}) == "may");
  const auto command = [](const Fields& more, const std::string& method = "POST") {
    return page_refused(PageNeeds::kCommand, method, with_fields(kPageFields, more));
  };
  CHECK(command({{"authorization", "Bearer command"}}) == "may");
  CHECK(command({}, "GET") == "405 a command is a POST\n");
  CHECK(command({{"content-type", "text/plain"}}) == "415 a command is JSON\n");
  CHECK(command({{"content-type", ""}, {"x-tactbench", ""}}) == "415 a command is JSON\n");
  CHECK(command({{"x-tactbench", "2"}}) == "403 not from the page\n");
  const std::string operators = "401 commands need the operator's link\nWWW-Authenticate=Bearer";
  CHECK(command({}) == operators);
  CHECK(command({{"authorization", "Bearer read"}}) == operators);
}

TEST_CASE("page refusals: no token commands where nobody may") {
  PageAccess access = access_of_two();
  const auto may = [&](const std::string& field) {
    return may_command(request_of("POST", {{"authorization", field}}), access);
  };
  CHECK(may("Bearer command"));
  CHECK_FALSE(may("Bearer read"));
  access.command_token.clear();
  CHECK_FALSE(may("Bearer "));
  CHECK_FALSE(may(""));
}
