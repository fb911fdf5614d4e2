#include "bench/page/http/message.h"

#include <fmt/format.h>
#include <openssl/err.h>
#include <openssl/x509err.h>

#include <algorithm>
#include <boost/asio/ssl.hpp>
#include <boost/asio/write.hpp>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "bench/common/error.h"

namespace tactbench::bench {

namespace {

int digit_of(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

}  // namespace

std::string lower_case(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

std::string url_decoded(const std::string& text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const int high = text[i] == '%' && i + 2 < text.size() ? digit_of(text[i + 1]) : -1;
    const int low = high >= 0 ? digit_of(text[i + 2]) : -1;
    if (low >= 0) {
      out += static_cast<char>(16 * high + low);
      i += 2;
    } else {
      out += text[i] == '+' ? ' ' : text[i];
    }
  }
  return out;
}

void read_target(const std::string& target, HttpRequest& request) {
  const std::size_t question = target.find('?');
  request.path = target.substr(0, question);
  if (question == std::string::npos) return;
  for (std::size_t at = question + 1; at <= target.size();) {
    const std::size_t end = std::min(target.find('&', at), target.size());
    const std::string pair = target.substr(at, end - at);
    const std::size_t equals = std::min(pair.find('='), pair.size());
    if (!pair.empty())
      request.query[url_decoded(pair.substr(0, equals))] = url_decoded(pair.substr(std::min(equals + 1, pair.size())));
    at = end + 1;
  }
}

namespace {

using boost::asio::ip::tcp;
using boost::system::error_code;

auto completion_of(Wire::Done done) {
  return [done = std::move(done)](const error_code& error, std::size_t bytes) { done(!error, bytes); };
}

template <class Stream>
class StreamWire : public Wire {
 public:
  template <class... Parts>
  explicit StreamWire(Parts&&... parts) : stream_(std::forward<Parts>(parts)...) {}
  void open(Done done) override { done(true, 0); }
  void read(char* bytes, std::size_t size, Done done) override {
    stream_.async_read_some(boost::asio::buffer(bytes, size), completion_of(std::move(done)));
  }
  void write(const std::vector<boost::asio::const_buffer>& buffers, Done done) override {
    boost::asio::async_write(stream_, buffers, completion_of(std::move(done)));
  }
  tcp::socket& socket() override {
    if constexpr (std::is_same_v<Stream, tcp::socket>) {
      return stream_;
    } else {
      return stream_.next_layer();
    }
  }

 protected:
  Stream stream_;
};

using Tls = boost::asio::ssl::stream<tcp::socket>;

class TlsWire final : public StreamWire<Tls> {
 public:
  TlsWire(tcp::socket socket, boost::asio::ssl::context& context) : StreamWire(std::move(socket), context) {}
  void open(Done done) override {
    stream_.async_handshake(Tls::server, [done = std::move(done)](const error_code& error) { done(!error, 0); });
  }
};

}  // namespace

std::unique_ptr<Wire> plain_wire(tcp::socket socket) {
  return std::make_unique<StreamWire<tcp::socket>>(std::move(socket));
}

std::unique_ptr<Wire> encrypted_wire(tcp::socket socket, boost::asio::ssl::context& context) {
  return std::make_unique<TlsWire>(std::move(socket), context);
}

namespace {

[[noreturn]] void refuse_for_tls(const std::string& file, const std::string& why, const std::string& remedy) {
  throw Error("TB-PAGE-CERTIFICATE", "cannot be used for TLS: " + why, file, remedy);
}

constexpr std::size_t kLongestPem = 1'000'000;

// OpenSSL's messages name its own parts ("no start line"), and it has no message for a file that cannot be opened.
std::string pem_in(const std::string& file, const char* what) {
  std::error_code unknown;
  if (std::filesystem::is_directory(file, unknown))
    refuse_for_tls(file, "it is a folder", fmt::format("name the file with the {}", what));
  std::ifstream stream(file, std::ios::binary);
  const int number = errno;
  if (!stream)
    refuse_for_tls(file, fmt::format("it cannot be read: {}", std::strerror(number)),
                   number == EACCES
                       ? fmt::format("give the user who starts the page the right to read it (ls -l {})", file)
                       : fmt::format("check the name: --tls takes the {} as a file in PEM", what));
  std::string text(kLongestPem + 1, '\0');
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(stream.gcount()));
  if (text.size() > kLongestPem)
    refuse_for_tls(file, "it is longer than 1 MB", fmt::format("check the name: it is not a {} in PEM", what));
  if (text.find("-----BEGIN ") == std::string::npos)
    refuse_for_tls(file, "it is not in PEM: it has no line -----BEGIN",
                   fmt::format("of a {} in DER: openssl x509 or pkey -inform DER -in {} -out NAME.pem", what, file));
  return text;
}

std::string reason_of(const error_code& error) {
  const char* const reason = ERR_reason_error_string(static_cast<unsigned long>(error.value()));
  return reason != nullptr ? reason : error.message();
}

}  // namespace

std::unique_ptr<boost::asio::ssl::context> tls_context(const std::string& certificate, const std::string& key) {
  using boost::asio::ssl::context;
  auto made = std::make_unique<context>(context::tls_server);
  made->set_options(context::default_workarounds | context::no_sslv2 | context::no_sslv3 | context::no_tlsv1 |
                    context::no_tlsv1_1);
  const std::string chain = pem_in(certificate, "certificate"), secret = pem_in(key, "private key");
  if (chain.find("-----BEGIN CERTIFICATE") == std::string::npos)
    refuse_for_tls(certificate, "it holds no certificate", "--tls CERTIFICATE KEY: the certificate comes first");
  if (secret.find("PRIVATE KEY-----") == std::string::npos)
    refuse_for_tls(key, "it holds no private key", "--tls CERTIFICATE KEY: the private key comes second");
  // Without this OpenSSL would ask at the terminal.
  made->set_password_callback([](std::size_t, context::password_purpose) { return std::string(); });
  if (secret.find("ENCRYPTED") != std::string::npos)
    refuse_for_tls(key, "the private key has a passphrase",
                   fmt::format("remove it, in a file that only you can read: openssl pkey -in {} -out NAME.key", key));
  error_code error;
  made->use_certificate_chain(boost::asio::buffer(chain), error);
  if (error)
    refuse_for_tls(certificate, reason_of(error),
                   fmt::format("see its contents: openssl x509 -in {} -noout -text", certificate));
  made->use_private_key(boost::asio::buffer(secret), context::pem, error);
  if (error)
    refuse_for_tls(key,
                   ERR_GET_REASON(static_cast<unsigned long>(error.value())) == X509_R_KEY_VALUES_MISMATCH
                       ? fmt::format("the private key does not belong to the certificate {}", certificate)
                       : reason_of(error),
                   fmt::format("the two belong together when these print the same: openssl x509 -in {} -noout -pubkey, "
                               "openssl pkey -in {} -pubout",
                               certificate, key));
  return made;
}

}  // namespace tactbench::bench
