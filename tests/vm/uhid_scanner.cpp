#include "tests/vm/uhid_scanner.h"

#include <fcntl.h>
#include <linux/uhid.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <string>
#include <utility>

namespace tactbench::tests {
namespace {

using namespace devices;

constexpr int kSide = 16;

// Vendor page; bytes. Input reports 1 and 3 of 63 bytes after the id, output report 2 of 7 bytes after it.
constexpr std::uint8_t kDescriptor[] = {0x06, 0x00, 0xFF, 0x09, 0x01, 0xA1, 0x01, 0x15, 0x00, 0x26, 0xFF,
                                        0x00, 0x75, 0x08, 0x85, 0x01, 0x95, 63,   0x09, 0x02, 0x81, 0x02,  //
                                        0x85, 0x03, 0x95, 63,   0x09, 0x03, 0x81, 0x02,                    //
                                        0x85, 0x02, 0x95, 7,    0x09, 0x04, 0x91, 0x02,                    //
                                        0xC0};

bool put(int device, const uhid_event& event) { return ::write(device, &event, sizeof event) == sizeof event; }

[[noreturn]] void fail(const char* what) {
  throw std::runtime_error(std::string("uhid: ") + what + ": " + std::strerror(errno));
}

}  // namespace

UhidScanner::UhidScanner(const char* serial)
    : identity_{0, kSide, kSide, 1.0e-4F, serial, "1.2"},
      device_(::open("/dev/uhid", O_RDWR | O_CLOEXEC)),
      stop_(::eventfd(0, EFD_CLOEXEC)) {
  if (device_ < 0 || stop_ < 0) fail("opening /dev/uhid");
  create();
  thread_ = std::thread([this] { serve(); });
}

UhidScanner::~UhidScanner() {
  const std::uint64_t one = 1;
  [[maybe_unused]] const ssize_t written = ::write(stop_, &one, sizeof one);
  thread_.join();
  unplug();
  ::close(device_);
  ::close(stop_);
}

void UhidScanner::create() {
  uhid_event event{};
  event.type = UHID_CREATE2;
  auto& request = event.u.create2;
  std::strcpy(reinterpret_cast<char*>(request.name), "tactbench test scanner");
  std::copy(identity_.serial.begin(), identity_.serial.end(), request.uniq);
  std::copy(std::begin(kDescriptor), std::end(kDescriptor), request.rd_data);
  request.rd_size = sizeof kDescriptor;
  request.bus = 0x03;  // USB
  request.vendor = kVendor;
  request.product = kProduct;
  if (!put(device_, event)) fail("UHID_CREATE2");
  plugged_ = true;
}

void UhidScanner::at_next_scan(Mishap mishap) { mishap_ = std::move(mishap); }

void UhidScanner::send(const Report& report) {
  uhid_event event{};
  event.type = UHID_INPUT2;
  event.u.input2.size = static_cast<std::uint16_t>(report.size());
  std::copy(report.begin(), report.end(), event.u.input2.data);
  put(device_, event);
}

void UhidScanner::unplug() {
  if (!plugged_.exchange(false)) return;
  uhid_event event{};
  event.type = UHID_DESTROY;
  unplugged_at_ = std::chrono::steady_clock::now();
  put(device_, event);
}

void UhidScanner::serve() {
  for (;;) {
    pollfd descriptors[] = {{stop_, POLLIN, 0}, {device_, POLLIN, 0}};
    if (::poll(descriptors, 2, -1) < 0) continue;
    if (descriptors[0].revents != 0) return;
    uhid_event event{};
    if (::read(device_, &event, sizeof event) <= 0 || event.type != UHID_OUTPUT) continue;
    answer(std::span(event.u.output.data, event.u.output.size));
  }
}

void UhidScanner::answer(std::span<const std::uint8_t> output) {
  const auto command = decode_command(output);
  if (!command) return;
  std::vector<Report> reports;
  if (command->command == ScanCommand::kIdentify) {
    identity_.tag = command->tag;
    reports.push_back(encode(identity_));
  } else {
    const long scan = scans_++;
    for (std::size_t row = 0; row < kSide; ++row) {
      RowReport report{sequence_++,
                       static_cast<std::uint32_t>(scan),
                       command->tag,
                       static_cast<std::uint8_t>(row),
                       0,
                       static_cast<std::uint32_t>(1000 * scan),
                       {}};
      for (std::size_t i = 0; i < kSide; ++i) report.samples[i] = sample(scan, row * kSide + i);
      reports.push_back(encode(report));
    }
    if (const Mishap mishap = std::exchange(mishap_, nullptr)) mishap(*this, reports);
  }
  for (const Report& report : reports) send(report);
}

}  // namespace tactbench::tests
