#include "devices/wire/ends/page_server.h"

#include <fmt/format.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <utility>

#include "devices/wire/ends/stream_end.h"

namespace tactbench::devices {
namespace {

constexpr std::size_t kMostClients = 8;
constexpr std::size_t kLargestRequest = 8192;

}  // namespace

PageServer::PageServer(int port, std::string path, std::string body, const std::string& device)
    : path_(std::move(path)), body_(std::move(body)) {
  const BoundSocket bound = bind_loopback(SOCK_STREAM, port, device);
  listener_ = bound.socket;
  port_ = bound.port;
}

PageServer::~PageServer() {
  for (const Client& client : clients_) ::close(client.socket);
  ::close(listener_);
}

void PageServer::add_to(std::vector<pollfd>& descriptors) const {
  descriptors.push_back({listener_, POLLIN, 0});
  for (const Client& client : clients_) descriptors.push_back({client.socket, POLLIN, 0});
}

void PageServer::serve() {
  for (Client& client : clients_) {
    if (!attend(client)) ::close(std::exchange(client.socket, -1));
  }
  std::erase_if(clients_, [](const Client& client) { return client.socket < 0; });
  const int socket = ::accept4(listener_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
  if (socket < 0) return;
  if (clients_.size() == kMostClients) {  // the longest silent one is dropped
    ::close(clients_.front().socket);
    clients_.erase(clients_.begin());
  }
  clients_.push_back({socket, ""});
}

bool PageServer::attend(Client& client) const {
  std::array<char, 2048> part{};
  const ssize_t got = ::recv(client.socket, part.data(), part.size(), 0);
  if (got < 0) return errno == EAGAIN || errno == EINTR;
  if (got == 0) return false;
  client.request.append(part.data(), static_cast<std::size_t>(got));
  if (client.request.find("\r\n\r\n") == std::string::npos) return client.request.size() < kLargestRequest;
  // A query ("?index=0") asks for the same page: there is one configuration.
  const std::string asked = client.request.substr(0, client.request.find_first_of("?\r\n"));
  const bool known = asked == "GET " + path_ || asked.starts_with("GET " + path_ + " ");
  const std::string body = known ? body_ : "no such page\n";
  const std::string answer =
      fmt::format("HTTP/1.0 {}\r\nContent-Type: {}\r\nContent-Length: {}\r\nConnection: close\r\n\r\n{}",
                  known ? "200 OK" : "404 Not Found", known ? "text/xml" : "text/plain", body.size(), body);
  // A page of a few kilobytes fits an empty send buffer; a client that does not read it loses it.
  [[maybe_unused]] const ssize_t sent = ::send(client.socket, answer.data(), answer.size(), MSG_NOSIGNAL);
  return false;
}

}  // namespace tactbench::devices
