#include "devices/tactile/simulated_scanner.h"

#include <fmt/format.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <thread>
#include <utility>
#include <vector>

#include "devices/device.h"
#include "devices/wire/ends/end_activity.h"

namespace tactbench::devices {

class SimulatedScanner::Server {
 public:
  Server(std::string path, IdentityReport identity, TactilePort& port, const Clock& clock,
         SimulatedScannerFaults faults)
      : path_(std::move(path)), identity_(std::move(identity)), port_(port), clock_(clock), faults_(std::move(faults)) {
    if (identity_.columns > kScanColumns) {
      fail(fmt::format("a report holds {} columns, not {}", kScanColumns, identity_.columns));
    }
    [[maybe_unused]] const auto encodable = encode(identity_);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    if (path_.empty() || path_.size() >= sizeof address.sun_path) fail("the path is empty or too long");
    std::copy(path_.begin(), path_.end(), address.sun_path);
    listener_ = ::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    stop_ = ::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    if (listener_ < 0 || stop_ < 0) fail(std::strerror(errno));
    if (abandoned(address)) ::unlink(path_.c_str());
    if (::bind(listener_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 ||
        ::listen(listener_, 4) != 0) {
      fail(std::strerror(errno));
    }
    const std::size_t rows = identity_.rows;
    counts_.resize(rows * identity_.columns);
    status_.resize(rows);
    reports_.resize(rows);
    thread_ = work_.thread([this] { serve(); });
  }

  ~Server() {
    const std::uint64_t one = 1;
    [[maybe_unused]] const ssize_t written = ::write(stop_, &one, sizeof one);
    thread_.join();
    if (listener_ >= 0) ::unlink(path_.c_str());
    release();
  }
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

 private:
  [[noreturn]] void fail(const std::string& why) {
    release();
    throw Fault("TB-SIM-LISTEN", "simulated scanner", fmt::format("listening on {}: {}", path_, why),
                "Choose another path, in a folder that exists.");
  }

  // A socket file without a listener was left by a program that was killed.
  static bool abandoned(const sockaddr_un& address) {
    const int probe = ::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (probe < 0) return false;
    const int result = ::connect(probe, reinterpret_cast<const sockaddr*>(&address), sizeof address);
    const bool refused = result != 0 && errno == ECONNREFUSED;
    ::close(probe);
    return refused;
  }

  void release() {
    for (int* descriptor : {&client_, &listener_, &stop_}) {
      if (*descriptor >= 0) ::close(std::exchange(*descriptor, -1));
    }
  }

  void serve() {
    for (;;) {
      // One client at a time: the next waits in the listener's queue.
      pollfd descriptors[] = {{stop_, POLLIN, 0}, {client_ >= 0 ? client_ : listener_, POLLIN, 0}};
      if (work_.wait(descriptors) < 0) continue;
      if (descriptors[0].revents != 0) return;
      if (descriptors[1].revents == 0) continue;
      if (client_ < 0) {
        client_ = ::accept4(listener_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
      } else if (!attend()) {
        ::close(std::exchange(client_, -1));
      }
    }
  }

  // False: close the connection.
  bool attend() {
    std::uint8_t bytes[kScanReportBytes];
    const ssize_t got = ::recv(client_, bytes, sizeof bytes, 0);
    if (got < 0) return errno == EAGAIN;
    if (got == 0) return false;
    if (faults_.unplug_after_scans >= 0 && scans_ >= faults_.unplug_after_scans) {
      ::unlink(path_.c_str());
      ::close(std::exchange(listener_, -1));
      return false;
    }
    injected_ = faults_.inject ? faults_.inject() : InjectedFault::kNone;
    if (injected_ == InjectedFault::kUnplugged) return false;
    if (injected_ == InjectedFault::kSilent) return true;
    const auto command = decode_command(std::span(bytes, static_cast<std::size_t>(got)));
    if (!command) return true;  // a damaged command is ignored
    if (command->command == ScanCommand::kIdentify) {
      identity_.tag = command->tag;
      const auto report = encode(identity_);
      return ::send(client_, report.data(), report.size(), MSG_NOSIGNAL) >= 0 || errno == EAGAIN;
    }
    return scan(command->tag);
  }

  bool scan(std::uint16_t tag) {
    const long number = scans_++;
    if (faults_.silent_after_scans >= 0 && number >= faults_.silent_after_scans) return true;
    try {
      if (injected_ != InjectedFault::kStale) port_.scan(counts_, status_);
    } catch (...) {
      return true;  // physics failed: the scanner falls silent
    }
    const auto time =
        static_cast<std::uint32_t>(std::chrono::duration_cast<std::chrono::microseconds>(clock_.now()).count());
    const std::size_t columns = identity_.columns;
    const std::size_t middle = reports_.size() / 2;
    for (std::size_t row = 0; row < reports_.size(); ++row) {
      RowReport report{sequence_++, frame_, tag, static_cast<std::uint8_t>(row), status_[row], time, {}};
      std::copy_n(counts_.begin() + static_cast<std::ptrdiff_t>(row * columns), columns, report.samples.begin());
      reports_[row] = encode(report);
    }
    ++frame_;
    if (number == faults_.corrupt_scan || injected_ == InjectedFault::kCorrupt) reports_[middle][20] ^= 0x10U;
    const bool torn = number == faults_.drop_report_scan || injected_ == InjectedFault::kTorn;
    return send_rows(torn ? middle : reports_.size());
  }

  // All rows in one call, so that the reader wakes once a scan rather than once a row.
  bool send_rows(std::size_t left_out) {
    parts_.clear();
    for (std::size_t row = 0; row < reports_.size(); ++row) {
      if (row != left_out) parts_.push_back({reports_[row].data(), reports_[row].size()});
    }
    messages_.assign(parts_.size(), mmsghdr{});
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      messages_[i].msg_hdr.msg_iov = &parts_[i];
      messages_[i].msg_hdr.msg_iovlen = 1;
    }
    // A reader that does not read loses the newest reports, as in the kernel's ring of HID reports.
    const int sent = ::sendmmsg(client_, messages_.data(), static_cast<unsigned>(messages_.size()), MSG_NOSIGNAL);
    return sent >= 0 || errno == EAGAIN;
  }

  std::string path_;
  IdentityReport identity_;
  TactilePort& port_;
  const Clock& clock_;
  SimulatedScannerFaults faults_;
  InjectedFault injected_ = InjectedFault::kNone;  // of the command being answered
  int client_ = -1;
  int listener_ = -1;
  int stop_ = -1;
  long scans_ = 0;
  std::uint16_t sequence_ = 0;
  std::uint32_t frame_ = 0;
  std::vector<std::uint16_t> counts_;
  std::vector<std::uint8_t> status_;
  std::vector<std::array<std::uint8_t, kScanReportBytes>> reports_;
  std::vector<iovec> parts_;
  std::vector<mmsghdr> messages_;
  EndActivity work_;
  std::thread thread_;
};

SimulatedScanner::SimulatedScanner(std::string path, IdentityReport identity, TactilePort& port, const Clock& clock,
                                   SimulatedScannerFaults faults)
    : server_(std::make_unique<Server>(std::move(path), std::move(identity), port, clock, std::move(faults))) {}

SimulatedScanner::~SimulatedScanner() = default;

}  // namespace tactbench::devices
