// A client of the frame-source protocol that sends and expects what a test specifies.
#pragma once

#include <catch2/catch.hpp>

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "devices/tactile/frame_protocol.h"
#include "devices/tactile/simulated_scanner.h"
#include "devices/wire/byte_stream.h"
#include "tests/devices/fault_of.h"
#include "tests/devices/timeouts.h"

namespace tactbench::devices::frame_protocol {

class FrameClient {
 public:
  explicit FrameClient(const std::string& address) : stream_(open_stream(address, kPatient)) {}

  void send(std::uint16_t tag, const Body& body) { send_bytes(encode({tag, body})); }
  void send_bytes(const std::vector<std::uint8_t>& bytes) { stream_->write(bytes); }

  // The next message; empty when the source has closed.
  std::optional<Message> next() {
    for (;;) {
      if (const auto packet = parser_.next()) {
        const auto message = decode(*packet);
        REQUIRE(message);
        return message;
      }
      REQUIRE(parser_.broken().empty());
      std::uint8_t bytes[4096];
      std::size_t got = 0;
      if (fault_id_of([&] { got = stream_->read(bytes, kPatient); }) == "TB-SERIAL-LOST") return std::nullopt;
      REQUIRE(got > 0);
      parser_.feed(std::span(bytes, got));
    }
  }

  // Exactly the next `size` bytes, of whatever; fewer when the source has closed.
  std::vector<std::uint8_t> raw(std::size_t size) {
    std::vector<std::uint8_t> bytes(size);
    std::size_t came = 0, got = 0;
    while (came < size) {
      const auto rest = std::span(bytes).subspan(came);
      if (fault_id_of([&] { got = stream_->read(rest, kPatient); }) == "TB-SERIAL-LOST" || got == 0) break;
      came += got;
    }
    bytes.resize(came);
    return bytes;
  }
  // Whether bytes are there already.
  bool waits() {
    std::uint8_t byte = 0;
    return stream_->read(std::span(&byte, 1), Nanoseconds(0)) > 0;
  }

  template <class Answer>
  Answer expect(std::uint16_t tag) {
    const auto message = next();
    REQUIRE(message);
    CHECK(message->tag == tag);
    REQUIRE(std::holds_alternative<Answer>(message->body));
    return std::get<Answer>(message->body);
  }

  // An error with tag 0 or nothing, then the end.
  void expect_close() {
    auto message = next();
    if (message) {
      CHECK(message->tag == 0);
      const auto* error = std::get_if<Error>(&message->body);
      REQUIRE(error != nullptr);
      CHECK(error->code == ErrorCode::kDamaged);
      message = next();
    }
    CHECK_FALSE(message);
  }

 private:
  std::unique_ptr<ByteStream> stream_;
  Parser parser_;
};

}  // namespace tactbench::devices::frame_protocol

namespace tactbench::devices {

// Physics of an array whose counts and status encode the scan and the taxel.

// Taxel i of scan n has 100 n + i counts, row r the status r of scan n plus 16 n.
class CountedArray final : public TactilePort {
 public:
  void scan(std::span<std::uint16_t> counts, std::span<std::uint8_t> status) override {
    const int number = scans++;
    if (number == broken_scan) throw std::runtime_error("no physics");
    for (std::size_t i = 0; i < counts.size(); ++i)
      counts[i] = static_cast<std::uint16_t>(100 * number + static_cast<int>(i));
    for (std::size_t row = 0; row < status.size(); ++row)
      status[row] = static_cast<std::uint8_t>(16 * number + static_cast<int>(row));
  }
  std::atomic<int> scans{0};
  std::atomic<int> broken_scan{-1};
};

}  // namespace tactbench::devices
