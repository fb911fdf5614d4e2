#include "devices/stage/zaber_line.h"
#include "devices/wire/wait.h"

#include <algorithm>
#include <thread>
#include <utility>
#include <vector>

namespace tactbench::devices {
namespace {

constexpr Nanoseconds kDeviceSilence = std::chrono::milliseconds(12);  // devices drop half a frame after 10
// 255 is not used: without message ids it is the last byte of a negative value.
constexpr std::uint8_t kLastId = 254;

Nanoseconds real_time() { return std::chrono::steady_clock::now().time_since_epoch(); }

}  // namespace

ZaberLine::ZaberLine(std::unique_ptr<ByteStream> stream, Nanoseconds reply_timeout, Nanoseconds silence,
                     Listener others)
    : stream_(std::move(stream)), reply_timeout_(reply_timeout), others_(std::move(others)), parser_(silence) {}

void ZaberLine::settle() {
  std::this_thread::sleep_for(kDeviceSilence);
  stream_->discard();
}

std::uint8_t ZaberLine::new_id() {
  do {
    last_id_ = last_id_ == kLastId ? 1 : static_cast<std::uint8_t>(last_id_ + 1);
  } while (held_[last_id_]);
  return last_id_;
}

void ZaberLine::write(const ZaberFrame& frame) { stream_->write(encode(frame)); }

std::uint8_t ZaberLine::send(std::uint8_t device, ZaberCommand command, std::int32_t data) {
  const std::uint8_t id = new_id();
  write({device, command, data, id});
  held_[id] = true;
  return id;
}

void ZaberLine::send_without_id(std::uint8_t device, ZaberCommand command, std::int32_t data) {
  write({device, command, data, 0});
}

std::optional<ZaberFrame> ZaberLine::ask(std::uint8_t device, ZaberCommand command, std::int32_t data) {
  const std::uint8_t id = new_id();
  write({device, command, data, id});
  return await([&](const ZaberFrame& frame) { return frame.device == device && frame.id == id; }, reply_timeout_);
}

std::optional<ZaberFrame> ZaberLine::ask_without_id(std::uint8_t device, ZaberCommand command, std::int32_t data) {
  send_without_id(device, command, data);
  return await(
      [&](const ZaberFrame& frame) {
        // A returned setting carries its own number.
        const bool returned =
            command == ZaberCommand::kReturnSetting && static_cast<std::int32_t>(frame.command) == data;
        return frame.device == device && frame.id == 0 &&
               (frame.command == command || returned || frame.command == ZaberCommand::kError);
      },
      reply_timeout_);
}

void ZaberLine::renumber(int devices, Nanoseconds timeout) {
  send_without_id(0, ZaberCommand::kRenumber, 0);
  int answered = 0;
  (void)await(
      [&](const ZaberFrame& frame) { return frame.command == ZaberCommand::kRenumber && ++answered == devices; },
      timeout);
}

std::optional<ZaberFrame> ZaberLine::await(const std::function<bool(const ZaberFrame&)>& wanted, Nanoseconds timeout) {
  const RealTime deadline = std::chrono::steady_clock::now() + timeout;
  std::optional<ZaberFrame> reply;
  std::array<std::uint8_t, 256> bytes{};
  std::vector<ZaberBytes> frames;
  for (bool late = false; !reply && !late;) {
    // One look after the deadline: a program that was not given the processor may find a reply that came in time.
    const Nanoseconds left = left_until(deadline);
    const std::size_t got = stream_->read(bytes, left);
    parser_.add(std::span(bytes).first(got), real_time(), frames);
    for (const ZaberBytes& one : std::exchange(frames, {})) {
      const ZaberFrame frame = decode(one);
      if (!reply && wanted(frame)) {
        reply = frame;
      } else {
        others_(frame);
      }
    }
    late = got == 0 || left == Nanoseconds(0);
  }
  return reply;
}

}  // namespace tactbench::devices
