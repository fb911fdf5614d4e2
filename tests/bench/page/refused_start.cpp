// Why the page cannot begin: addresses that are none, and files that hold no certificate or no key.
#include <catch2/catch.hpp>
#include <filesystem>

#include "bench/common/error.h"
#include "bench/page/http/http_server.h"
#include "bench/page/http/wire.h"
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
    return error.where() + ": " + error.what() + " | " + error.remedy();
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

TEST_CASE("page: an address that is none, or another machine's, or a taken port is refused by its words") {
  HttpOptions options;
  options.address = "not-an-address";
  options.port = 8123;
  const Error none = refusal_to_listen(options);
  CHECK(none.id() == "TB-PAGE-ADDRESS");
  CHECK(none.code() == ExitCode::kUsage);
  CHECK_THAT(none.what(), Catch::StartsWith("cannot listen on not-an-address port 8123: "));
  CHECK(none.where() == "--listen not-an-address --port 8123");
  CHECK(none.remedy() == "name an address of this machine, and another port; --port 0 takes a free one");
  options.address = "192.0.2.1";  // of documents, no machine's
  CHECK_THAT(refusal_to_listen(options).what(),
             Catch::StartsWith("cannot listen on 192.0.2.1 port 8123: Cannot assign requested address"));
  HttpOptions free;
  const HttpServer first(free, [](const HttpRequest&, const Reply&) {});
  free.port = first.port();
  CHECK(free.port != 0);
  CHECK_THAT(refusal_to_listen(free).what(), Catch::Contains("Address already in use"));
}

TEST_CASE("page: each file that cannot be used for TLS is refused with its reason and what to do") {
  const TemporaryFolder folder;
  const auto write = [&](const char* name, const std::string& text) {
    write_file(folder.path(name), text);
    return folder.path(name);
  };
  const std::string certificate = write("c", "-----BEGIN CERTIFICATE-----\nAAAA\n-----END CERTIFICATE-----\n");
  const std::string key = write("k", "-----BEGIN PRIVATE KEY-----\nAAAA\n-----END PRIVATE KEY-----\n");
  const std::string start = ": cannot be used for TLS: ", place = folder.path();
  CHECK(tls_refusal(place, key) == place + start + "it is a folder | name the file with the certificate");
  CHECK(tls_refusal(certificate, place) == place + start + "it is a folder | name the file with the private key");
  CHECK(tls_refusal(place + "/none", key) ==
        place + "/none" + start +
            "it cannot be read: No such file or directory | check the name: --tls takes the certificate as a file in "
            "PEM");
  CHECK(tls_refusal(certificate, place + "/none") ==
        place + "/none" + start +
            "it cannot be read: No such file or directory | check the name: --tls takes the private key as a file in "
            "PEM");
  const std::string plain = write("d", "0");
  CHECK(tls_refusal(plain, key) == plain + start +
                                       "it is not in PEM: it has no line -----BEGIN | of a certificate in DER: "
                                       "openssl x509 or pkey -inform DER -in " +
                                       plain + " -out NAME.pem");
  CHECK(tls_refusal(key, key) ==
        key + start + "it holds no certificate | --tls CERTIFICATE KEY: the certificate comes first");
  CHECK(tls_refusal(certificate, certificate) ==
        certificate + start + "it holds no private key | --tls CERTIFICATE KEY: the private key comes second");
  const std::string locked =
      write("e", "-----BEGIN ENCRYPTED PRIVATE KEY-----\nAAAA\n-----END ENCRYPTED PRIVATE KEY-----\n");
  CHECK(tls_refusal(certificate, locked) ==
        locked + start +
            "the private key has a passphrase | take it off, in a file that only you read: openssl pkey -in " + locked +
            " -out NAME.key");
  const std::string damaged = tls_refusal(certificate, key);
  CHECK_THAT(damaged, Catch::StartsWith(certificate + start));
  CHECK_THAT(damaged, Catch::EndsWith(" | see what it holds: openssl x509 -in " + certificate + " -noout -text"));
}
