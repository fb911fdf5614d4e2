// The page over TLS: a certificate with its key serves, one with another's key is refused, and bytes that are no TLS
// get nothing. Certificates are made here.
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/ssl.h>
#include <openssl/x509.h>

#include <catch2/catch.hpp>
#include <cstdio>
#include <memory>
#include <string>
#include <thread>

#include "bench/page/http/http_server.h"
#include "bench/page/http/message.h"
#include "tests/bench/page/raw_http.h"
#include "tests/support/process.h"
#include "tests/support/refusal.h"

using namespace tactbench::bench;
using namespace tactbench::tests;

namespace {

// A key, and a certificate that it has signed for itself, as files.
class MadeCertificate {
 public:
  explicit MadeCertificate(const TemporaryFolder& folder, const std::string& name)
      : certificate(folder.path(name + ".pem")), key(folder.path(name + ".key")) {
    const std::unique_ptr<EVP_PKEY, decltype(&EVP_PKEY_free)> pair(EVP_EC_gen("P-256"), &EVP_PKEY_free);
    const std::unique_ptr<X509, decltype(&X509_free)> own(X509_new(), &X509_free);
    X509_gmtime_adj(X509_getm_notBefore(own.get()), -3600);
    X509_gmtime_adj(X509_getm_notAfter(own.get()), 3600);
    X509_set_pubkey(own.get(), pair.get());
    REQUIRE(X509_sign(own.get(), pair.get(), EVP_sha256()) > 0);
    const auto write = [](const std::string& path, const auto& put) {
      const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "w"), &std::fclose);
      REQUIRE(file);
      REQUIRE(put(file.get()) == 1);
    };
    write(certificate, [&](std::FILE* file) { return PEM_write_X509(file, own.get()); });
    write(key, [&](std::FILE* file) {
      return PEM_write_PrivateKey(file, pair.get(), nullptr, nullptr, 0, nullptr, nullptr);
    });
  }
  std::string certificate, key;
};

// The answer to a client over TLS of at most that version; empty: no handshake.
std::string asked_over_tls(std::uint16_t port, const std::string& request, int version = TLS1_3_VERSION) {
  const std::unique_ptr<SSL_CTX, decltype(&SSL_CTX_free)> context(SSL_CTX_new(TLS_client_method()), &SSL_CTX_free);
  SSL_CTX_set_security_level(context.get(), 0);
  SSL_CTX_set_min_proto_version(context.get(), TLS1_VERSION);
  SSL_CTX_set_max_proto_version(context.get(), version);
  const std::unique_ptr<SSL, decltype(&SSL_free)> talk(SSL_new(context.get()), &SSL_free);
  const RawClient client(port);
  SSL_set_fd(talk.get(), client.descriptor());
  if (SSL_connect(talk.get()) != 1) return {};
  SSL_write(talk.get(), request.data(), static_cast<int>(request.size()));
  std::string got;
  char bytes[4096];
  for (int size = 1; size > 0;) {
    size = SSL_read(talk.get(), bytes, sizeof bytes);
    if (size > 0) got.append(bytes, static_cast<std::size_t>(size));
  }
  return got;
}

}  // namespace

TEST_CASE("page over TLS: answers of any length by TLS 1.2 and 1.3, and no answer without TLS") {
  const TemporaryFolder folder;
  const MadeCertificate made(folder, "a");
  HttpOptions options;
  options.certificate = made.certificate;
  options.key = made.key;
  HttpServer server(options, [](const HttpRequest& request, const Reply& reply) {
    reply(text_response(200, request.path + " from " + request.from + std::string(50'000, 'x')));
  });
  std::thread thread([&] { server.run(); });
  const std::string get = "GET /a HTTP/1.1\r\nConnection: close\r\n\r\n";
  for (const int version : {TLS1_2_VERSION, TLS1_3_VERSION}) {
    const std::string answer = asked_over_tls(server.port(), get, version);
    CHECK_THAT(answer, Catch::StartsWith("HTTP/1.1 200 OK\r\n"));
    CHECK(body_of(answer) == "/a from 127.0.0.1" + std::string(50'000, 'x'));
  }
  CHECK(asked_over_tls(server.port(), get, TLS1_1_VERSION).empty());
  const MadeCertificate other(folder, "b");
  const auto error = refusal_by([&] { (void)tls_context(made.certificate, other.key); });
  REQUIRE(error);
  CHECK((error->id() == "TB-PAGE-CERTIFICATE" && error->where() == other.key));
  RawClient plain(server.port());
  REQUIRE(plain.send(get));
  CHECK(plain.read().find("HTTP") == std::string::npos);
  server.stop();
  thread.join();
}
