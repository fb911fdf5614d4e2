#include "devices/tactile/frame_source.h"

#include <fmt/format.h>

#include <array>
#include <chrono>
#include <utility>

#include "devices/device.h"
#include "devices/wire/byte_stream.h"
#include "devices/wire/wait.h"

namespace tactbench::devices {
namespace {

namespace protocol = frame_protocol;
constexpr const char* kSourceDevice = "tactile scanner";
constexpr int kMostStale = 10'000;  // bounds the wait for a source that never stops sending

// Runs `talk`; a lost stream becomes TB-SCANNER-LOST.
template <class Talk>
auto with_source(Talk&& talk) {
  try {
    return talk();
  } catch (const Fault& fault) {
    if (!fault.id().starts_with("TB-SERIAL-")) throw;
    const bool slow = fault.id() == "TB-SERIAL-TIMEOUT";
    throw Fault(slow ? "TB-SCANNER-TIMEOUT" : "TB-SCANNER-LOST", kSourceDevice,
                fmt::format("the frame source {}: {}", slow ? "takes no bytes" : "is gone", fault.what()),
                fault.remedy());
  }
}

}  // namespace

FrameSource::FrameSource(FrameSourceOptions options, Clock& clock) : options_(std::move(options)), clock_(clock) {
  stream_ = with_source([this] { return open_stream(options_.address, options_.connect_timeout); });
  with_source([this] { identify(); });
}

void FrameSource::identify() {
  const auto answer = exchange(protocol::Identify{}, "its identity");
  const auto* description = std::get_if<protocol::Description>(&answer.body);
  if (description == nullptr) corrupt("its reply to the request for its identity is of another kind");
  described_ = *description;
  if (described_.version != protocol::kVersion) {
    corrupt(fmt::format("it speaks version {} of the protocol, not {}", described_.version, protocol::kVersion));
  }
  if (options_.rows == 0) options_.rows = described_.rows;
  if (options_.columns == 0) options_.columns = described_.columns;
  if (described_.rows != options_.rows || described_.columns != options_.columns) {
    throw Fault("TB-SCANNER-GEOMETRY", kSourceDevice,
                fmt::format("{} x {} taxels are expected, {} reports {} x {}", options_.rows, options_.columns,
                            stream_->description(), described_.rows, described_.columns),
                "Correct rows and columns in the sensor file, and under [scanner] of the bench file, where a frame "
                "source needs none; or connect the right scanner.");
  }
  if (!options_.expected_serial.empty() && described_.serial != options_.expected_serial) {
    throw Fault("TB-SCANNER-SERIAL", kSourceDevice,
                fmt::format("scanner '{}' is configured, '{}' answers on {}", options_.expected_serial,
                            described_.serial, stream_->description()),
                "Connect the right scanner, or correct its serial in the bench file.");
  }
}

void FrameSource::corrupt(const std::string& what) const {
  throw Fault("TB-SCANNER-CORRUPT", kSourceDevice, fmt::format("frame source {}: {}", stream_->description(), what),
              "Reconnect; if it recurs, check the source against frame_protocol.md.");
}

std::optional<protocol::Message> FrameSource::next_message(Nanoseconds timeout) {
  const auto end = std::chrono::steady_clock::now() + timeout;  // waiting on a wire takes real time
  std::array<std::uint8_t, 16384> bytes{};
  for (;;) {
    if (const auto packet = parser_.next()) {
      auto message = protocol::decode(*packet);
      if (!message) {
        corrupt(fmt::format("a message of type 0x{:02x} with {} bytes is not in the protocol", packet->type,
                            packet->payload.size()));
      }
      return message;
    }
    if (!parser_.broken().empty()) corrupt(fmt::format("the stream of messages is damaged ({})", parser_.broken()));
    const Nanoseconds left = timeout > Nanoseconds(0) ? left_until(end) : Nanoseconds(0);
    const std::size_t got = stream_->read(bytes, left);
    if (got == 0) return std::nullopt;
    parser_.feed(std::span(bytes).first(got));
  }
}

protocol::Message FrameSource::exchange(const protocol::Body& request, const std::string& asked) {
  for (int stale = 0; stale < kMostStale && next_message(Nanoseconds(0)); ++stale) {
  }
  if (next_tag_ == 0) ++next_tag_;  // tag 0 means damage
  const std::uint16_t tag = next_tag_++;
  stream_->write(protocol::encode({tag, request}));
  ++exchanges_;
  const auto end = std::chrono::steady_clock::now() + options_.frame_timeout;
  for (bool late = false; !late;) {
    // One look after the deadline: a program that was not given the processor may find an answer that came in time.
    const Nanoseconds left = left_until(end);
    late = left == Nanoseconds(0);
    auto answer = next_message(left);
    if (!answer) break;
    // An error with tag 0 is about a request that the source could not read.
    const auto* error = std::get_if<protocol::Error>(&answer->body);
    if (error != nullptr && (answer->tag == tag || answer->tag == 0)) {
      throw Fault("TB-SCANNER-REFUSED", kSourceDevice,
                  fmt::format("asking {} {}: error {} '{}'", stream_->description(), asked,
                              static_cast<int>(error->code), error->text),
                  "Check the messages of the source's own program.");
    }
    if (answer->tag == tag) return *std::move(answer);
  }
  clock_.reply_lost(options_.frame_timeout);
  throw Fault("TB-SCANNER-TIMEOUT", kSourceDevice,
              fmt::format("asking {} {}: no answer within {:g} ms", stream_->description(), asked,
                          in_milliseconds(options_.frame_timeout)),
              "Check the source's program and the network, then start again.");
}

ScanSet FrameSource::read(int scans) {
  ScanSet set;
  set.rows = options_.rows;
  set.columns = options_.columns;
  set.scans = scans;
  set.time = clock_.now();
  with_source([&] {
    for (int index = 0; index < scans; ++index) read_scan(set, index);
  });
  return set;
}

void FrameSource::read_scan(ScanSet& set, int index) {
  const auto answer = exchange(protocol::Scan{}, fmt::format("for scan {}", index));
  const auto* frame = std::get_if<protocol::Frame>(&answer.body);
  if (frame == nullptr) corrupt("its reply to the request for a scan is of another kind");
  if (frame->rows != set.rows || frame->columns != set.columns) {
    corrupt(fmt::format("a frame of {} x {} taxels came, the array has {} x {}", frame->rows, frame->columns, set.rows,
                        set.columns));
  }
  if (last_counter_) {
    const std::uint32_t ahead = frame->counter - *last_counter_;  // modulo 2^32
    if (ahead == 0 || ahead > 0x7FFF'FFFFU) {
      corrupt(fmt::format("on a request for a fresh frame it sent frame {} after frame {}: it came twice, or is old",
                          frame->counter, *last_counter_));
    }
  }
  last_counter_ = frame->counter;
  set.counts.insert(set.counts.end(), frame->counts.begin(), frame->counts.end());
  set.frame_counters.push_back(frame->counter);
  if (index == 0) set.device_time_us = static_cast<std::uint32_t>(frame->device_time_us & 0xFFFF'FFFFU);
  set.status = static_cast<std::uint8_t>(set.status | frame->status);
}

Identity FrameSource::identity() const {
  return {"tactile scanner", described_.model, described_.serial, described_.firmware, options_.origin};
}

}  // namespace tactbench::devices
