// HTTP requests and responses as plain structs, without types of the HTTP library.
#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/context.hpp>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <utility>  // before asio, which does not include it
#include <vector>

namespace tactbench::bench {

struct HttpRequest {
  std::string method, path;                   // path: without the query, as sent
  std::map<std::string, std::string> query;   // decoded
  std::map<std::string, std::string> fields;  // names in lower case; the values of a repeated name are joined by ", "
  std::string body;
  std::string from;  // the client's address

  [[nodiscard]] std::string field(const std::string& name) const {
    const auto found = fields.find(name);
    return found == fields.end() ? std::string() : found->second;
  }
  [[nodiscard]] bool has(const std::string& name) const { return fields.contains(name); }
};

using SharedText = std::shared_ptr<const std::string>;

struct HttpResponse {
  int status = 200;
  std::string type = "text/plain; charset=utf-8";
  SharedText body = {};  // null: empty
  std::vector<std::pair<std::string, std::string>> fields = {};
  bool stream = false;  // the body, then the events of HttpServer::publish() until the client disconnects
};

inline HttpResponse text_response(int status, std::string text) {
  return {.status = status, .body = std::make_shared<const std::string>(std::move(text))};
}

// To be called exactly once, immediately or later, on the server's thread.
using Reply = std::function<void(HttpResponse)>;

// Names of header fields and hosts are case-insensitive: "Host" -> "host".
std::string lower_case(std::string text);
// "a%20b" -> "a b"; a broken escape stays as it is.
std::string url_decoded(const std::string& text);
// Path and query of a request's target.
void read_target(const std::string& target, HttpRequest& request);

// Byte stream of a client's connection, plain or TLS, as the Connection reads and writes it.
class Wire {
 public:
  using Done = std::function<void(bool ok, std::size_t bytes)>;
  virtual ~Wire() = default;
  virtual void open(Done done) = 0;  // TLS: performs the handshake
  virtual void read(char* bytes, std::size_t size, Done done) = 0;
  virtual void write(const std::vector<boost::asio::const_buffer>& buffers, Done done) = 0;  // writes all of them
  virtual boost::asio::ip::tcp::socket& socket() = 0;
};

std::unique_ptr<Wire> plain_wire(boost::asio::ip::tcp::socket socket);
std::unique_ptr<Wire> encrypted_wire(boost::asio::ip::tcp::socket socket, boost::asio::ssl::context& context);

// Throws Error TB-PAGE-CERTIFICATE.
std::unique_ptr<boost::asio::ssl::context> tls_context(const std::string& certificate, const std::string& key);

}  // namespace tactbench::bench
