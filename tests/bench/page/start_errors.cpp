// Why the page cannot begin: addresses that are none, and files that hold no certificate or no key.
#include <catch2/catch.hpp>

#include "bench/common/error.h"
#include "bench/page/http/http_server.h"
#include "bench/page/http/message.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::bench;
using namespace tactbench::tests;

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
