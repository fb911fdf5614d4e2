#include "devices/wire/report_link.h"

#include <fmt/format.h>
#include <hidapi/hidapi.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <string_view>

#include "devices/device.h"
#include "devices/wire/wait.h"

namespace tactbench::devices {
namespace {

// hidapi speaks wchar_t; names of instruments are ASCII, anything else becomes '?'.
std::string narrow(const wchar_t* text) {
  std::string result;
  for (; text != nullptr && *text != L'\0'; ++text) result += *text < 128 ? static_cast<char>(*text) : '?';
  return result;
}

class HidLink final : public ReportLink {
 public:
  HidLink(hid_device* device, std::string description) : device_(device), description_(std::move(description)) {}
  ~HidLink() override { hid_close(device_); }
  HidLink(const HidLink&) = delete;
  HidLink& operator=(const HidLink&) = delete;

  void write(std::span<const std::uint8_t> report) override {
    int sent = -1;
    do {
      errno = 0;
      sent = hid_write(device_, report.data(), report.size());
    } while (sent < 0 && errno == EINTR);
    if (sent == static_cast<int>(report.size())) return;
    throw Fault(
        "TB-HID-WRITE", description_,
        fmt::format("sending a report of {} bytes to {}: {}", report.size(), description_, narrow(hid_error(device_))),
        "Plug the scanner in again and start again.");
  }

  std::size_t read(std::span<std::uint8_t> into, Nanoseconds timeout) override {
    const auto deadline = std::chrono::steady_clock::now() + timeout;
    auto left = timeout;
    for (;;) {
      errno = 0;
      const auto wait = std::chrono::ceil<std::chrono::milliseconds>(std::max(left, Nanoseconds(0)));
      const int got = hid_read_timeout(device_, into.data(), into.size(), static_cast<int>(wait.count()));
      if (got >= 0) return static_cast<std::size_t>(got);
      // hidapi does not retry an interrupted poll; a device that is gone leaves another errno, or none.
      if (errno != EINTR) lost();
      left = deadline - std::chrono::steady_clock::now();
    }
  }

  std::size_t drain() override {
    std::array<std::uint8_t, 1024> report{};
    std::size_t thrown = 0;
    while (thrown < kDrainLimit && read(report, Nanoseconds(0)) > 0) ++thrown;
    return thrown;
  }

  std::string description() const override { return description_; }

 private:
  static constexpr std::size_t kDrainLimit =
      10'000;  // the kernel keeps 63; bounds the wait for a sender that never stops

  [[noreturn]] void lost() const {
    throw Fault("TB-HID-LOST", description_,
                fmt::format("reading a report from {}: {}", description_, narrow(hid_error(device_))),
                "Plug the scanner in again and start again.");
  }

  hid_device* device_;
  std::string description_;
};

std::string devices_present() {
  std::string list;
  for (const HidInfo& info : list_hid_devices()) {
    list += fmt::format("{}{:04x}:{:04x} serial '{}' {}", list.empty() ? "" : ", ", info.vendor_id, info.product_id,
                        info.serial, info.product);
  }
  return list.empty() ? "none" : list;
}

}  // namespace

std::vector<HidInfo> list_hid_devices() {
  std::vector<HidInfo> list;
  hid_device_info* first = hid_enumerate(0, 0);
  for (const hid_device_info* info = first; info != nullptr; info = info->next) {
    list.push_back({info->vendor_id, info->product_id, narrow(info->serial_number), narrow(info->product_string),
                    info->path == nullptr ? "" : info->path});
  }
  hid_free_enumeration(first);
  return list;
}

std::unique_ptr<ReportLink> open_hid_link(const HidAddress& address) {
  const std::string name = fmt::format("HID device {:04x}:{:04x}{}", address.vendor_id, address.product_id,
                                       address.serial.empty() ? std::string() : " serial '" + address.serial + "'");
  const std::wstring serial(address.serial.begin(), address.serial.end());
  hid_device* device =
      hid_open(address.vendor_id, address.product_id, address.serial.empty() ? nullptr : serial.c_str());
  if (device == nullptr) {
    throw Fault(
        "TB-HID-OPEN", name,
        fmt::format("opening {}: {}; HID devices present: {}", name, narrow(hid_error(nullptr)), devices_present()),
        "Plug the scanner in, check ids and serial in the bench file, and check that a udev rule lets this "
        "user open it.");
  }
  return std::make_unique<HidLink>(device, name);
}

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
