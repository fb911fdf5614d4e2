// Driver of any scanner that speaks the frame-source protocol (frame_protocol.md) over TCP or a local socket. Not
// verified on hardware; verified against the simulated source and against the reference server in Python.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "devices/tactile/frame_protocol.h"
#include "devices/tactile/options.h"
#include "devices/tactile/tactile_array.h"
#include "devices/wire/byte_stream.h"

namespace tactbench::devices {

class FrameSource final : public TactileArray {
 public:
  // Connects and identifies the source. Throws Fault TB-SCANNER-LOST (no connection), TB-SCANNER-TIMEOUT,
  // TB-SCANNER-CORRUPT (the replies do not follow the protocol), TB-SCANNER-GEOMETRY, TB-SCANNER-SERIAL. To reconnect,
  // create a new object.
  FrameSource(FrameSourceOptions options, Clock& clock);
  // Also throws Fault TB-SCANNER-REFUSED (the source replied with an error; the message is the source's). After
  // TB-SCANNER-LOST and after damage to the stream every further read fails the same way. ScanSet's device time is the
  // low 32 bits.
  [[nodiscard]] ScanSet read(int scans) override;
  [[nodiscard]] int rows() const override { return options_.rows; }
  [[nodiscard]] int columns() const override { return options_.columns; }
  [[nodiscard]] Volts volts_per_count() const override { return Volts(described_.volts_per_count); }
  [[nodiscard]] std::uint64_t exchanges() const override { return exchanges_; }
  [[nodiscard]] Identity identity() const override;

 private:
  // Sends the request and returns the answer to it; answers to older requests are ignored.
  frame_protocol::Message exchange(const frame_protocol::Body& request, const std::string& asked);
  std::optional<frame_protocol::Message> next_message(Nanoseconds timeout);
  void identify();
  void read_scan(ScanSet& set, int index);
  [[noreturn]] void corrupt(const std::string& what) const;
  FrameSourceOptions options_;
  Clock& clock_;
  std::unique_ptr<ByteStream> stream_;
  frame_protocol::Parser parser_;
  frame_protocol::Description described_;
  std::optional<std::uint32_t> last_counter_;
  std::uint16_t next_tag_ = 1;
  std::uint64_t exchanges_ = 0;
};

}  // namespace tactbench::devices
