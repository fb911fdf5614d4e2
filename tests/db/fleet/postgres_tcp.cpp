// How long a server on the network may be silent, as the operating system was told.
#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "db/fleet/postgres.h"
#include "tests/db/fleet/scripted_postgres.h"

namespace tactbench::tests::postgres {

namespace {

// On a port of this machine, in a process of its own: answers the start of one connection.
class NetworkServer {
 public:
  NetworkServer() : door_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    REQUIRE(::bind(door_, reinterpret_cast<const sockaddr*>(&address), size) == 0);
    REQUIRE(::listen(door_, 1) == 0);
    REQUIRE(::getsockname(door_, reinterpret_cast<sockaddr*>(&address), &size) == 0);
    port_ = ntohs(address.sin_port);
    child_ = fork();
    REQUIRE(child_ >= 0);
    if (child_ > 0) return;
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    const int link = ::accept(door_, nullptr, nullptr);
    std::vector<char> start(4096);
    const std::string answer = started();
    if (::recv(link, start.data(), start.size(), 0) > 0) (void)::send(link, answer.data(), answer.size(), MSG_NOSIGNAL);
    for (;;) ::pause();
  }
  ~NetworkServer() {
    ::kill(child_, SIGKILL);
    int status = 0;
    waitpid(child_, &status, 0);
    ::close(door_);
  }
  NetworkServer(const NetworkServer&) = delete;
  NetworkServer& operator=(const NetworkServer&) = delete;

  [[nodiscard]] std::string conninfo() const {
    return "hostaddr=127.0.0.1 port=" + std::to_string(port_) +
           " dbname=tactile user=bench_a sslmode=disable gssencmode=disable";
  }
  // The descriptor of this process that is connected to the port.
  [[nodiscard]] int client() const {
    for (int file = 3; file < 1024; ++file) {
      sockaddr_in peer{};
      socklen_t size = sizeof peer;
      if (::getpeername(file, reinterpret_cast<sockaddr*>(&peer), &size) == 0 && peer.sin_family == AF_INET &&
          ntohs(peer.sin_port) == port_)
        return file;
    }
    return -1;
  }

 private:
  int door_ = -1, port_ = 0;
  pid_t child_ = -1;
};

int tcp_option(int socket, int option) {
  int value = -1;
  socklen_t size = sizeof value;
  return ::getsockopt(socket, IPPROTO_TCP, option, &value, &size) == 0 ? value : -1;
}

}  // namespace

TEST_CASE("fleet server: what is sent is given up when nobody acknowledges it for as long as silence may last") {
  if (!db::fleet::built_with_libpq()) return;
  const NetworkServer server;
  const db::fleet::Link link(server.conninfo(), std::chrono::seconds(7));
  const int client = server.client();
  REQUIRE(client >= 0);
  CHECK(tcp_option(client, TCP_USER_TIMEOUT) == 7000);
  CHECK(tcp_option(client, TCP_KEEPIDLE) == 20);
  CHECK(tcp_option(client, TCP_KEEPINTVL) == 10);
}

}  // namespace tactbench::tests::postgres
