#include "devices/wire/ends/loopback.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "devices/device.h"

namespace tactbench::devices {

BoundSocket bind_loopback(int type, int port, const std::string& device) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  auto* general = reinterpret_cast<sockaddr*>(&address);
  const int socket = ::socket(AF_INET, type | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  const int one = 1;
  // A page's port is free again at once after a restart, although old connections linger.
  const bool ready = socket >= 0 && port >= 0 && port <= 65535 &&
                     (type != SOCK_STREAM || ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &one, sizeof one) == 0) &&
                     ::bind(socket, general, size) == 0 && (type != SOCK_STREAM || ::listen(socket, 8) == 0) &&
                     ::getsockname(socket, general, &size) == 0;
  if (ready) return {socket, ntohs(address.sin_port)};
  const int error = errno;
  if (socket >= 0) ::close(socket);
  throw Fault("TB-SIM-LISTEN", device, fmt::format("listening on 127.0.0.1:{}: {}", port, std::strerror(error)),
              "Choose another port, or 0 to let the system choose.");
}

}  // namespace tactbench::devices
