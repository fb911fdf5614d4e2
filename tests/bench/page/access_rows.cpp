// Each refusal of the page with its status and its place in the order.
#include "bench/page/access.h"

#include <catch2/catch.hpp>
#include <map>
#include <set>
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

}  // namespace

TEST_CASE("page refusals: hosts, origins and sites, whatever is needed") {
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

TEST_CASE("page refusals: the way of asking before the token, and which token opens what") {
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

TEST_CASE("page access: tokens are of 128 bits and never the same, and an empty one opens nothing") {
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
