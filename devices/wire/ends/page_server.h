// Serves one page over HTTP on loopback, for a simulated instrument with a web server. Polled by its owner's thread,
// never blocks, answers every other path with 404.
#pragma once

#include <poll.h>

#include <string>
#include <vector>

namespace tactbench::devices {

class PageServer {
 public:
  // Listens on 127.0.0.1; port 0 lets the system choose. Throws Fault TB-SIM-LISTEN.
  PageServer(int port, std::string path, std::string body, const std::string& device);
  ~PageServer();
  PageServer(const PageServer&) = delete;
  PageServer& operator=(const PageServer&) = delete;
  [[nodiscard]] int port() const { return port_; }
  // Appends the descriptors to poll; after the poll, serve() serves the ready clients.
  void add_to(std::vector<pollfd>& descriptors) const;
  void serve();

 private:
  struct Client {
    int socket = -1;
    std::string request;
  };
  [[nodiscard]] bool attend(Client& client) const;  // false: the client is finished
  std::string path_;
  std::string body_;
  int listener_ = -1;
  int port_ = 0;
  std::vector<Client> clients_;
};

}  // namespace tactbench::devices
