#include "devices/wire/http_get.h"

#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <optional>
#include <string_view>

#include "devices/device.h"
#include "devices/wire/ip_address.h"
#include "devices/wire/wait.h"

namespace tactbench::devices {
namespace {

class Exchange {
 public:
  Exchange(const HttpPage& page, const std::string& device, Clock& clock)
      : page_(page), device_(device), clock_(clock), end_(std::chrono::steady_clock::now() + page.timeout) {}
  ~Exchange() {
    if (socket_ >= 0) ::close(socket_);
  }
  Exchange(const Exchange&) = delete;
  Exchange& operator=(const Exchange&) = delete;

  void connect() {
    const auto address = numeric_address(page_.host, page_.port);
    if (!address) fail("TB-HTTP-OPEN", "no address in numbers or no port");
    socket_ = ::socket(address->family(), SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (socket_ < 0) fail("TB-HTTP-OPEN", std::strerror(errno));
    if (::connect(socket_, address->get(), address->size) == 0) return;
    int error = errno;
    if (error == EINPROGRESS) {
      wait(POLLOUT, "TB-HTTP-OPEN", "no connection");
      socklen_t size = sizeof error;
      if (::getsockopt(socket_, SOL_SOCKET, SO_ERROR, &error, &size) != 0) error = errno;
    }
    if (error != 0) fail("TB-HTTP-OPEN", std::strerror(error));
  }

  void send(std::string_view request) {
    while (!request.empty()) {
      const ssize_t sent = ::send(socket_, request.data(), request.size(), MSG_NOSIGNAL);
      if (sent > 0) {
        request.remove_prefix(static_cast<std::size_t>(sent));
      } else if (errno == EAGAIN) {
        wait(POLLOUT, "TB-HTTP-TIMEOUT", "the request is not accepted");
      } else if (errno != EINTR) {
        fail("TB-HTTP-ANSWER", std::strerror(errno));
      }
    }
  }

  // Reads until the other side closes, or until `complete` returns true for the text so far.
  template <class Complete>
  std::string receive(Complete&& complete) {
    std::string text;
    std::array<char, 4096> part{};
    while (!complete(text)) {
      const ssize_t got = ::recv(socket_, part.data(), part.size(), 0);
      if (got == 0) return text;
      if (got > 0) {
        text.append(part.data(), static_cast<std::size_t>(got));
        if (text.size() > page_.largest) fail("TB-HTTP-ANSWER", fmt::format("more than {} bytes", page_.largest));
        // The deadline holds for a server that never stops sending, too.
        if (left_until(end_) > Nanoseconds(0) || complete(text)) continue;
        expire("TB-HTTP-TIMEOUT", "the answer does not end");
      } else if (errno == EAGAIN) {
        wait(POLLIN, "TB-HTTP-TIMEOUT", fmt::format("{} bytes came, not all", text.size()));
      } else if (errno != EINTR) {
        fail("TB-HTTP-ANSWER", std::strerror(errno));
      }
    }
    return text;
  }

  [[noreturn]] void fail(const char* id, const std::string& what) const {
    throw Fault(id, device_,
                fmt::format("reading http://{}:{}{} of {}: {}", page_.host, page_.port, page_.path, device_, what),
                "Open that address in a browser; check power, network cable, address and port in the bench file.");
  }

 private:
  void wait(short events, const char* id, const std::string& what) {
    if (wait_for(socket_, events, left_until(end_)) == 0) expire(id, what);
  }

  [[noreturn]] void expire(const char* id, const std::string& what) {
    clock_.reply_lost(page_.timeout);
    fail(id, fmt::format("{} within {:g} s", what, std::chrono::duration<double>(page_.timeout).count()));
  }

  const HttpPage& page_;
  const std::string& device_;
  Clock& clock_;
  std::chrono::steady_clock::time_point end_;
  int socket_ = -1;
};

constexpr std::string_view kHeaderEnd = "\r\n\r\n";

// The value of Content-Length, where the headers are complete and name it.
std::optional<std::size_t> content_length(std::string_view text) {
  const auto end = text.find(kHeaderEnd);
  if (end == std::string_view::npos) return std::nullopt;
  std::string headers(text.substr(0, end + 2));
  std::transform(headers.begin(), headers.end(), headers.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  constexpr std::string_view kName = "\r\ncontent-length:";
  const auto at = headers.find(kName);
  if (at == std::string::npos) return std::nullopt;
  const char* digits = headers.data() + headers.find_first_not_of(' ', at + kName.size());
  std::size_t length = 0;
  const auto [stop, error] = std::from_chars(digits, headers.data() + headers.size(), length);
  return error == std::errc() ? std::optional(length) : std::nullopt;
}

}  // namespace

std::string http_get(const HttpPage& page, const std::string& device, Clock& clock) {
  Exchange exchange(page, device, clock);
  exchange.connect();
  exchange.send(fmt::format("GET {} HTTP/1.0\r\nHost: {}\r\nConnection: close\r\n\r\n", page.path, page.host));
  const std::string text = exchange.receive([](const std::string& so_far) {
    const auto length = content_length(so_far);
    return length && so_far.size() - so_far.find(kHeaderEnd) - kHeaderEnd.size() >= *length;
  });
  const std::string status = text.substr(0, std::min(text.find("\r\n"), std::size_t{80}));
  if (!text.starts_with("HTTP/1.") || text.find(kHeaderEnd) == std::string::npos) {
    exchange.fail("TB-HTTP-ANSWER", fmt::format("{} bytes that are not an HTTP answer came", text.size()));
  }
  if (text.substr(8, 4) != " 200") {
    exchange.fail("TB-HTTP-ANSWER", fmt::format("the answer is '{}'", status));
  }
  std::string body = text.substr(text.find(kHeaderEnd) + kHeaderEnd.size());
  const auto length = content_length(text);
  if (length && body.size() < *length) {
    exchange.fail("TB-HTTP-ANSWER", fmt::format("{} of {} bytes came", body.size(), *length));
  }
  return body;
}

}  // namespace tactbench::devices
