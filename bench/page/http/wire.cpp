#include "bench/page/http/wire.h"

#include <boost/asio/ssl.hpp>
#include <boost/asio/write.hpp>

#include "bench/common/error.h"

namespace tactbench::bench {

namespace {

using boost::asio::ip::tcp;
using boost::system::error_code;

auto told(Wire::Done done) {
  return [done = std::move(done)](const error_code& error, std::size_t bytes) { done(!error, bytes); };
}

template <class Stream>
class StreamWire : public Wire {
 public:
  template <class... Parts>
  explicit StreamWire(Parts&&... parts) : stream_(std::forward<Parts>(parts)...) {}
  void open(Done done) override { done(true, 0); }
  void read(char* bytes, std::size_t size, Done done) override {
    stream_.async_read_some(boost::asio::buffer(bytes, size), told(std::move(done)));
  }
  void write(const std::vector<boost::asio::const_buffer>& buffers, Done done) override {
    boost::asio::async_write(stream_, buffers, told(std::move(done)));
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

std::unique_ptr<boost::asio::ssl::context> tls_context(const std::string& certificate, const std::string& key) {
  using boost::asio::ssl::context;
  auto made = std::make_unique<context>(context::tls_server);
  made->set_options(context::default_workarounds | context::no_sslv2 | context::no_sslv3 | context::no_tlsv1 |
                    context::no_tlsv1_1);
  const auto refuse = [](const std::string& file, const error_code& error) {
    throw Error(ExitCode::kUsage, "TB-PAGE-CERTIFICATE", "cannot be used for TLS: " + error.message(), file,
                "name a certificate and its private key, both in PEM, that belong together");
  };
  error_code error;
  made->use_certificate_chain_file(certificate, error);
  if (error) refuse(certificate, error);
  made->use_private_key_file(key, context::pem, error);
  if (error) refuse(key, error);
  return made;
}

}  // namespace tactbench::bench
