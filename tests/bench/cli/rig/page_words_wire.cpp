// page: the address that it prints, as words and as JSON, and the port that it takes.
#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <csignal>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/support/paths.h"
#include "tests/support/process.h"

using namespace tactbench::tests;

namespace {

// `page` with these words until it has announced itself.
Finished announced_page(const std::string& words, const char* announced_in = "out") {
  const TemporaryFolder folder;
  const std::string announcement = folder.path(announced_in);
  write_file(announcement, "");
  const auto told = [&] {
    const std::string text = read_file(announcement);
    return text.ends_with("\n") && (!text.starts_with("{") || text.ends_with("\n}\n"));
  };
  Finished done =
      run_program("/bin/sh", {"-c", "exec '" + std::string(program_path()) + "' page " + words + " >out 2>err"},
                  folder.path(), {SIGTERM, told});
  done.out = read_file(folder.path("out"));
  done.err = read_file(folder.path("err"));
  return done;
}

int port_in_page_link(const std::string& link) {
  const std::size_t at = link.find("127.0.0.1:");
  REQUIRE(at != std::string::npos);
  return std::stoi(link.substr(at + 10));
}

// Holds a port of this machine, unless somebody else does.
class HeldPort {
 public:
  explicit HeldPort(std::uint16_t port) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    held_ =
        ::bind(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0 && ::listen(socket_, 1) == 0;
  }
  ~HeldPort() { ::close(socket_); }
  HeldPort(const HeldPort&) = delete;
  HeldPort& operator=(const HeldPort&) = delete;
  [[nodiscard]] bool held() const { return held_; }

 private:
  int socket_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  bool held_ = false;
};

}  // namespace

TEST_CASE("page: its address on a free port, for who reads alone and for who commands, and as JSON") {
  const Finished reads = announced_page("--port 0");
  CHECK(reads.err.empty());
  const std::string secrets = reads.out.substr(reads.out.find('#') + 1);
  CHECK(secrets.find('.') == std::string::npos);
  const Finished commands = announced_page("--port 0 --operator bob");
  CHECK_THAT(commands.out.substr(commands.out.find('#')), Catch::Contains("."));
  const nlohmann::json told = nlohmann::json::parse(announced_page("--port 0 --operator bob --json").out);
  CHECK(told.at("schema") == "tactbench.page");
  CHECK(told.at("operator") == "bob");
  const std::string link = told.at("link"), readers = told.at("readers_link");
  CHECK(told.at("port") == port_in_page_link(link));
  CHECK(told.at("port") != 0);
  CHECK(link.starts_with(readers + "."));
  CHECK(nlohmann::json::parse(announced_page("--port 0 --json").out).at("operator") == "");
}

TEST_CASE("page: beside a run its address goes to standard error, and nothing to standard output") {
  const Finished beside = announced_page("--port 0 --beside " + std::to_string(::getpid()), "err");
  CHECK(beside.out.empty());
}

TEST_CASE("page: another page's usual port is left to it, a port that was asked for is not") {
  const HeldPort usual(8765);
  if (!usual.held()) return;  // somebody else has it
  const Finished other = announced_page("");
  CHECK(port_in_page_link(other.out) != 8765);
  const TemporaryFolder folder;
  const Finished refused = call(folder, {"page", "--port", "8765"});
  CHECK(refused.code == 2);
  CHECK(refused.out.empty());
  CHECK_THAT(refused.err, Catch::Contains("[TB-PAGE-ADDRESS]") && Catch::Contains("8765"));
  CHECK(call(folder, {"page", "--listen", "192.0.2.1", "--tls", "none.pem", "none.key"}).code == 2);
}
