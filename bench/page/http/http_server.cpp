#include "bench/page/http/http_server.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/post.hpp>
#include <list>

#include "bench/common/error.h"
#include "bench/page/http/connection.h"

namespace tactbench::bench {

using boost::asio::ip::tcp;
using boost::system::error_code;

struct HttpServer::Server {
  Server(const HttpOptions& options, Handler handler, Rank rank)
      : host{options, std::move(handler), std::move(rank)}, acceptor(context) {
    if (!options.certificate.empty()) tls = tls_context(options.certificate, options.key);
    listen();
  }

  void listen() {
    const HttpOptions& options = host.options;
    error_code error;
    const auto address = boost::asio::ip::make_address(options.address, error);
    const tcp::endpoint place(address, options.port);
    if (!error) acceptor.open(place.protocol(), error);
    if (!error) acceptor.set_option(tcp::acceptor::reuse_address(true), error);
    if (!error) acceptor.bind(place, error);
    if (!error) acceptor.listen(16, error);
    if (!error) return;
    throw Error("TB-PAGE-ADDRESS",
                fmt::format("cannot listen on {} port {}: {}", options.address, options.port, error.message()),
                fmt::format("--listen {} --port {}", options.address, options.port));
  }

  void accept() {
    acceptor.async_accept([this](const error_code& error, tcp::socket socket) {
      if (!acceptor.is_open()) return;
      if (error) return accept_later();
      take(std::move(socket));
      accept();
    });
  }

  // If there are no free descriptors, the server can only wait.
  void accept_later() {
    auto timer = std::make_shared<boost::asio::steady_timer>(context, std::chrono::milliseconds(50));
    timer->async_wait([this, timer](const error_code& error) {
      if (!error && acceptor.is_open()) accept();
    });
  }

  void take(tcp::socket socket) {
    connections.remove_if([](const std::weak_ptr<Connection>& one) { return rank_of(one) < 0; });
    if (connections.size() >= host.options.max_connections) {
      const auto least = std::ranges::min_element(connections, {}, rank_of);  // among equal ranks the oldest
      if (rank_of(*least) >= kNeverEvicted) return;
      least->lock()->close();
      connections.erase(least);
    }
    auto made = std::make_shared<Connection>(
        host, tls ? encrypted_wire(std::move(socket), *tls) : plain_wire(std::move(socket)), context);
    connections.push_back(made);
    made->start();
  }

  static int rank_of(const std::weak_ptr<Connection>& one) {
    const auto connection = one.lock();
    return connection ? connection->rank() : -1;
  }

  void each(const std::function<void(Connection&)>& act) {
    for (const std::weak_ptr<Connection>& one : connections)
      if (const auto connection = one.lock()) act(*connection);
  }

  void end() {
    error_code ignored;
    acceptor.close(ignored);
    each([](Connection& connection) { connection.close(); });
    context.stop();
  }

  // Connections end with the context, which has to find these two.
  ConnectionHost host;
  std::unique_ptr<boost::asio::ssl::context> tls;
  boost::asio::io_context context{1};
  tcp::acceptor acceptor;
  std::list<std::weak_ptr<Connection>> connections;
};

namespace {

struct Ticking : std::enable_shared_from_this<Ticking> {
  Ticking(boost::asio::io_context& context, std::chrono::milliseconds every, std::function<void()> what)
      : timer(context), period(every), act(std::move(what)) {}
  void next() {
    timer.expires_after(period);
    timer.async_wait([self = shared_from_this()](const error_code& error) {
      if (error) return;
      self->act();
      self->next();
    });
  }
  boost::asio::steady_timer timer;
  std::chrono::milliseconds period;
  std::function<void()> act;
};

struct WatchedDescriptor : std::enable_shared_from_this<WatchedDescriptor> {
  WatchedDescriptor(boost::asio::io_context& context, int descriptor, std::function<void()> what)
      : stream(context, ::dup(descriptor)), act(std::move(what)) {}
  void next() {
    stream.async_wait(boost::asio::posix::stream_descriptor::wait_read,
                      [weak = weak_from_this()](const error_code& error) {
                        const auto self = weak.lock();
                        if (error || !self) return;
                        self->act();
                        self->next();
                      });
  }
  boost::asio::posix::stream_descriptor stream;
  std::function<void()> act;
};

}  // namespace

HttpServer::HttpServer(const HttpOptions& options, Handler handler, Rank rank)
    : server_(std::make_unique<Server>(options, std::move(handler), std::move(rank))) {
  server_->accept();
}

HttpServer::~HttpServer() { server_->end(); }

std::uint16_t HttpServer::port() const { return server_->acceptor.local_endpoint().port(); }
void HttpServer::run() { server_->context.run(); }
void HttpServer::stop() {
  boost::asio::post(server_->context, [server = server_.get()] { server->end(); });
}
std::size_t HttpServer::viewers() const { return server_->host.viewers; }
std::uint64_t HttpServer::skipped() const { return server_->host.skipped; }

void HttpServer::publish(int kind, const SharedText& event) {
  server_->each([&](Connection& connection) { connection.offer(kind, event); });
}

void HttpServer::every(std::chrono::milliseconds period, std::function<void()> act) {
  std::make_shared<Ticking>(server_->context, period, std::move(act))->next();
}

std::shared_ptr<void> HttpServer::watch(int descriptor, std::function<void()> act) {
  auto made = std::make_shared<WatchedDescriptor>(server_->context, descriptor, std::move(act));
  made->next();
  return made;
}

}  // namespace tactbench::bench
