#include "devices/wire/packet_link.h"

#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

#include "devices/device.h"
#include "devices/wire/wait.h"

namespace tactbench::devices {
namespace {

constexpr std::size_t kPacketBytes = 576;  // the largest report in use (513 bytes) and some
constexpr std::size_t kBatch = 32;

class PacketLink final : public ReportLink {
 public:
  PacketLink(int socket, std::string path) : socket_(socket), path_(std::move(path)) {
    for (std::size_t i = 0; i < kBatch; ++i) {
      parts_[i] = {packets_[i].data(), packets_[i].size()};
      messages_[i].msg_hdr.msg_iov = &parts_[i];
      messages_[i].msg_hdr.msg_iovlen = 1;
    }
  }
  ~PacketLink() override { ::close(socket_); }
  PacketLink(const PacketLink&) = delete;
  PacketLink& operator=(const PacketLink&) = delete;

  void write(std::span<const std::uint8_t> report) override {
    const ssize_t sent = ::send(socket_, report.data(), report.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    if (sent == static_cast<ssize_t>(report.size())) return;
    throw Fault(
        "TB-HID-WRITE", description(),
        fmt::format("sending a report of {} bytes to {}: {}", report.size(), description(), std::strerror(errno)),
        "Check that the scanner is plugged in and that its program runs.");
  }

  std::size_t read(std::span<std::uint8_t> into, Nanoseconds timeout) override {
    if (next_ == filled_) fetch();
    if (next_ == filled_ && timeout > Nanoseconds(0)) {
      (void)wait_for(socket_, POLLIN, timeout);
      fetch();
    }
    if (next_ == filled_) return 0;
    const std::size_t index = next_++;
    const std::size_t size = std::min<std::size_t>(messages_[index].msg_len, into.size());
    std::copy_n(packets_[index].begin(), size, into.begin());
    return size;
  }

  std::size_t drain() override {
    std::size_t thrown = 0;
    do {
      thrown += filled_ - next_;
      next_ = filled_;
      fetch();
    } while (next_ != filled_ && thrown < kDrainLimit);
    return thrown;
  }

  std::string description() const override { return "packet socket " + path_; }

 private:
  static constexpr std::size_t kDrainLimit = 100'000;  // bounds the wait for a sender that never stops

  // Takes all waiting packets, up to a batch, in one call: a scan is 16 packets.
  void fetch() {
    if (gone_) lost("closed by the other side");
    next_ = filled_ = 0;
    const int count = ::recvmmsg(socket_, messages_.data(), kBatch, MSG_DONTWAIT, nullptr);
    if (count < 0) {
      if (errno == EAGAIN) return;
      gone_ = true;
      lost(std::strerror(errno));
    }
    // At the end of the stream every further message "arrives" with length 0; no report is empty.
    while (filled_ < static_cast<std::size_t>(count) && messages_[filled_].msg_len > 0) ++filled_;
    gone_ = filled_ < static_cast<std::size_t>(count);
    if (gone_ && filled_ == 0) lost("closed by the other side");
  }

  [[noreturn]] void lost(const char* why) const {
    throw Fault("TB-HID-LOST", description(), fmt::format("reading a report from {}: {}", description(), why),
                "Plug the scanner in again (or start its program) and start again.");
  }

  int socket_;
  std::string path_;
  bool gone_ = false;
  std::size_t next_ = 0;
  std::size_t filled_ = 0;
  std::array<std::array<std::uint8_t, kPacketBytes>, kBatch> packets_{};
  std::array<iovec, kBatch> parts_{};
  std::array<mmsghdr, kBatch> messages_{};
};

[[noreturn]] void fail_open_packets(const std::string& path, const char* why) {
  throw Fault("TB-HID-OPEN", "packet socket " + path, fmt::format("opening the packet socket {}: {}", path, why),
              "Check that the simulated scanner runs and that the path in the bench file is its own.");
}

}  // namespace

std::unique_ptr<ReportLink> open_packet_link(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.empty() || path.size() >= sizeof address.sun_path) fail_open_packets(path, "the path is empty or too long");
  std::copy(path.begin(), path.end(), address.sun_path);
  const int socket = ::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (socket < 0) fail_open_packets(path, std::strerror(errno));
  // Non-blocking: a listener whose queue is full refuses at once (EAGAIN) instead of blocking.
  if (::connect(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    const int error = errno;
    ::close(socket);
    fail_open_packets(path, std::strerror(error));
  }
  return std::make_unique<PacketLink>(socket, path);
}

}  // namespace tactbench::devices
