// Who may read and who may command, and what a request's target says.
#include "bench/page/access.h"

#include <catch2/catch.hpp>
#include <set>

#include "bench/page/frames.h"
#include "bench/page/responses.h"

using namespace tactbench::bench;

TEST_CASE("page access: tokens are of 128 bits and never the same") {
  std::set<std::string> seen;
  for (int i = 0; i < 200; ++i) seen.insert(new_token());
  CHECK(seen.size() == 200);
  for (const std::string& token : seen) CHECK(token.size() == 32);
}

TEST_CASE("page access: an empty token opens nothing, whatever is configured") {
  PageAccess access;
  access.hosts = {"127.0.0.1:1"};
  access.read_token = new_token();
  HttpRequest request;
  request.method = "GET";
  request.fields = {{"host", "127.0.0.1:1"}, {"authorization", "Bearer "}};
  CHECK(refusal(request, PageNeeds::kRead, access)->status == 401);
  CHECK_FALSE(may_command(request, access));
  request.fields["authorization"] = "Bearer " + access.read_token;
  CHECK_FALSE(refusal(request, PageNeeds::kRead, access));
  CHECK_FALSE(may_command(request, access));
  request.fields["host"] = "LOCALHOST:1";
  CHECK(refusal(request, PageNeeds::kRead, access)->status == 421);
  access.hosts.emplace_back("localhost:1");
  CHECK_FALSE(refusal(request, PageNeeds::kRead, access));
}

TEST_CASE("page access: a target's path stays as it was sent, its query is decoded") {
  HttpRequest request;
  read_target("/make/sensor?serial=S%20%3C1%3E+a&&run=7&empty=&%zz=1", request);
  CHECK(request.path == "/make/sensor");
  CHECK(request.query.at("serial") == "S <1> a");
  CHECK(request.query.at("empty").empty());
  CHECK(request.query.at("%zz") == "1");
  CHECK(number_in(request, "run") == 7);
  CHECK(number_in(request, "serial", -1) == -1);
  CHECK(number_in(request, "missing", 4) == 4);
  CHECK(needs_of("/make/sensor") == PageNeeds::kRead);
  CHECK(needs_of("/command") == PageNeeds::kCommand);
  CHECK(needs_of("/") == PageNeeds::kNothing);
  for (const char* none : {"", "/make", "/make/other", "/events/", "//", "/page.js/x", "/%2e"}) {
    INFO(none);
    CHECK_FALSE(needs_of(none));
  }
}
