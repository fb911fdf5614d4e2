// A Net F/T that answers each request with the records that a test gives, and the driver connected to it.
#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "devices/force/net_ft.h"
#include "devices/force/rdt_record.h"
#include "devices/wire/ends/end_activity.h"
#include "devices/wire/ends/stream_end.h"
#include "tests/devices/test_chamber.h"
#include "tests/devices/timeouts.h"

namespace tactbench::devices {

// Answers each request with the records of `script`, called with the number of the request (from 0) and its count.
class ScriptedSensor {
 public:
  using Script = std::function<std::vector<RdtRecord>(int number, std::uint32_t count)>;
  explicit ScriptedSensor(Script script)
      : script_(std::move(script)), bound_(bind_loopback(SOCK_DGRAM, 0, "test")), stop_(::eventfd(0, 0)) {
    thread_ = work_.thread([this] { serve(); });
  }
  ~ScriptedSensor() {
    const std::uint64_t one = 1;
    [[maybe_unused]] const ssize_t written = ::write(stop_, &one, sizeof one);
    thread_.join();
    ::close(stop_);
    ::close(bound_.socket);
  }
  ScriptedSensor(const ScriptedSensor&) = delete;
  ScriptedSensor& operator=(const ScriptedSensor&) = delete;
  [[nodiscard]] int port() const { return bound_.port; }
  // The port that each request came from.
  [[nodiscard]] std::vector<int> ports() const {
    const std::lock_guard lock(mutex_);
    return ports_;
  }
  // How many records each request has asked for.
  [[nodiscard]] std::vector<std::uint32_t> asked() const {
    const std::lock_guard lock(mutex_);
    return asked_;
  }

 private:
  void serve() {
    for (int number = 0;;) {
      std::vector<pollfd> watched{{stop_, POLLIN, 0}, {bound_.socket, POLLIN, 0}};
      if (work_.wait(watched) < 0) continue;
      if (watched[0].revents != 0) return;
      std::array<std::uint8_t, 64> bytes{};
      sockaddr_in client{};
      socklen_t size = sizeof client;
      auto* const address = reinterpret_cast<sockaddr*>(&client);
      const ssize_t got = ::recvfrom(bound_.socket, bytes.data(), bytes.size(), 0, address, &size);
      const auto request =
          decode_rdt_request(std::span(bytes).first(static_cast<std::size_t>(std::max(got, ssize_t{0}))));
      if (!request) continue;
      {
        const std::lock_guard lock(mutex_);
        asked_.push_back(request->count);
        ports_.push_back(ntohs(client.sin_port));
      }
      for (const RdtRecord& record : script_(number++, request->count)) {
        const auto encoded = encode(record);
        std::vector<std::uint8_t> datagram(encoded.begin(), encoded.end());
        if (record.status == kShort) datagram.pop_back();
        if (record.status == kLonger) datagram.push_back(0);
        ::sendto(bound_.socket, datagram.data(), datagram.size(), 0, address, size);
      }
    }
  }

 public:
  static constexpr std::uint32_t kShort = 0xFFFFFFFF;   // a status that stands for a torn datagram
  static constexpr std::uint32_t kLonger = 0xFFFFFFFE;  // and one for a datagram with a byte too many

 private:
  Script script_;
  BoundSocket bound_;
  int stop_;
  mutable std::mutex mutex_;
  std::vector<std::uint32_t> asked_;
  std::vector<int> ports_;
  EndActivity work_;
  std::thread thread_;
};

// A sensor that has sent `sample` samples so far, the counts of Fx alike.
inline RdtRecord record_of(std::uint32_t sequence, std::uint32_t sample, std::uint32_t status = 0) {
  return {sequence, sample, status, {static_cast<std::int32_t>(sample & 0xFFFFU), 0, 0, 0, 0, 0}};
}

struct ScriptedBench {
  explicit ScriptedBench(ScriptedSensor::Script script, Nanoseconds reply_timeout = kPatient)
      : server(std::move(script)) {
    NetFtPage page;
    page.product = "scripted";
    page.range = SixAxes{25, 25, 35, 250, 250, 250};
    options.page_file = folder.path("page.xml");
    std::ofstream(options.page_file) << format_netft_page(page);
    options.host = "127.0.0.1";
    options.port = server.port();
    options.reply_timeout = reply_timeout;
    sensor = std::make_unique<NetFt>(options, clock);
  }
  TemporaryFolder folder;
  ScriptedSensor server;
  NetFtOptions options;
  ManualClock clock;
  std::unique_ptr<NetFt> sensor;
};

}  // namespace tactbench::devices
