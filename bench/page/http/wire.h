// Byte stream of a client's connection, plain or TLS, as the Connection reads and writes it.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>  // before asio, which forgets it
#include <vector>

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/context.hpp>

namespace tactbench::bench {

class Wire {
 public:
  using Done = std::function<void(bool ok, std::size_t bytes)>;
  virtual ~Wire() = default;
  virtual void open(Done done) = 0;  // TLS: shakes hands
  virtual void read(char* bytes, std::size_t size, Done done) = 0;
  virtual void write(const std::vector<boost::asio::const_buffer>& buffers, Done done) = 0;  // all of them
  virtual boost::asio::ip::tcp::socket& socket() = 0;
};

std::unique_ptr<Wire> plain_wire(boost::asio::ip::tcp::socket socket);
std::unique_ptr<Wire> encrypted_wire(boost::asio::ip::tcp::socket socket, boost::asio::ssl::context& context);

// Throws Error TB-PAGE-CERTIFICATE.
std::unique_ptr<boost::asio::ssl::context> tls_context(const std::string& certificate, const std::string& key);

}  // namespace tactbench::bench
