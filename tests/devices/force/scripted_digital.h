// An in-memory line with a Digital F/T at its end: records every byte that the driver sends, and sets what comes back.
#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "devices/force/digital_ft.h"
#include "devices/force/digital_record.h"

using Bytes = std::vector<std::uint8_t>;

namespace tactbench::devices {

// An invented calibration of a Digital F/T: a force count is four gauge counts, axis by axis, gauges crossed so that a
// wrong order shows.

inline DigitalCalibration invented_digital() {
  DigitalCalibration calibration;
  calibration.serial = "FT99902";
  calibration.part_number = "SI-25-0.25";
  calibration.date = "2020/02/30";
  for (std::size_t row = 0; row < 6; ++row) calibration.matrix[row][(row + 1) % 6] = row < 3 ? 4.0F : -8.0F;
  calibration.range = {25.0F, 25.0F, 35.0F, 0.25F, 0.25F, 0.25F};
  calibration.counts_per_force = 1000;        // 0.004 N a gauge count
  calibration.counts_per_torque = 1'000'000;  // -0.008 N*mm a gauge count
  for (std::size_t i = 0; i < 12; ++i) calibration.gains_and_offsets[i] = static_cast<std::uint16_t>(1000 + i);
  return calibration;
}

}  // namespace tactbench::devices

namespace tactbench::tests {

using namespace devices;

inline constexpr std::uint8_t kUnit = 10;

// The bytes on the line, and the scripted sensor at its end.
struct Line {
  std::vector<Bytes> written;
  std::deque<std::uint8_t> coming;
  std::map<int, std::uint16_t> registers;
  Bytes stream;               // what follows the answer to a start
  std::size_t chunk = 1024;   // most bytes of one read
  bool deaf = false;          // to a jam
  bool torn = false;          // an empty line is a lost one
  bool endless = false;       // a byte comes whenever one is asked for
  std::size_t slow_read = 0;  // the read with this number takes `held_up`
  Nanoseconds held_up{0};
  std::vector<Nanoseconds> waits;  // the longest that each read would have waited
  std::function<Bytes(const Bytes& request, Bytes answer)> change = [](const Bytes&, Bytes answer) { return answer; };

  void load(const DigitalCalibration& calibration) {
    for (int i = 0; i < 12; ++i) registers[i] = calibration.gains_and_offsets[static_cast<std::size_t>(i)];
    const auto bytes = encode(calibration);
    for (std::size_t i = 0; i < bytes.size(); i += 2) {
      registers[0x00E3 + static_cast<int>(i / 2)] = static_cast<std::uint16_t>(bytes[i] << 8 | bytes[i + 1]);
    }
  }
  [[nodiscard]] Bytes answer(const Bytes& request) const {
    if (request[1] == 0x46) return rtu_frame(Bytes{kUnit, 0x46, 1});
    Bytes body{kUnit, 3, static_cast<std::uint8_t>(2 * request[5])};
    for (int i = 0; i < request[5]; ++i) {
      const std::uint16_t value = registers.at((request[2] << 8 | request[3]) + i);
      body.push_back(static_cast<std::uint8_t>(value >> 8U));
      body.push_back(static_cast<std::uint8_t>(value & 0xFFU));
    }
    return rtu_frame(body);
  }
};

class LineStream final : public ByteStream {
 public:
  explicit LineStream(Line& line) : line_(line) {}
  void write(std::span<const std::uint8_t> bytes) override {
    const Bytes request(bytes.begin(), bytes.end());
    line_.written.push_back(request);
    if (std::ranges::all_of(request, [](std::uint8_t byte) { return byte == 0xFF; })) {
      if (line_.deaf) return;
      line_.coming.clear();
      line_.endless = false;
      return;
    }
    const Bytes answer = line_.change(request, line_.answer(request));
    line_.coming.insert(line_.coming.end(), answer.begin(), answer.end());
    if (request[1] == 0x46) line_.coming.insert(line_.coming.end(), line_.stream.begin(), line_.stream.end());
  }
  std::size_t read(std::span<std::uint8_t> into, Nanoseconds timeout) override {
    if (line_.waits.size() < 100'000) line_.waits.push_back(timeout);
    if (line_.waits.size() == line_.slow_read) std::this_thread::sleep_for(line_.held_up);
    if (line_.endless) line_.coming.push_back(0x41);
    if (line_.torn && line_.coming.empty()) throw Fault("TB-SERIAL-LOST", "port", "it is gone", "Plug it in.");
    const std::size_t size = std::min({into.size(), line_.coming.size(), line_.chunk});
    std::copy_n(line_.coming.begin(), size, into.begin());
    line_.coming.erase(line_.coming.begin(), line_.coming.begin() + static_cast<std::ptrdiff_t>(size));
    return size;
  }
  std::size_t discard() override {
    const std::size_t size = line_.coming.size();
    line_.coming.clear();
    return size;
  }
  [[nodiscard]] std::string description() const override { return "port A"; }
  [[nodiscard]] int descriptor() const override { return -1; }

 private:
  Line& line_;
};

// Of N: 0.004 G1, 0.004 G2, 0.004 G3; of N*mm: -0.008 G4, -0.008 G5, -0.008 G0; ranges wide enough for full gauges.
inline DigitalCalibration wide() {
  DigitalCalibration calibration = invented_digital();
  calibration.range = {500.0F, 500.0F, 500.0F, 0.5F, 0.5F, 0.5F};
  return calibration;
}

struct Script {
  explicit Script(const DigitalCalibration& calibration = wide()) { line.load(calibration); }
  DigitalFt open() { return {std::make_unique<LineStream>(line), options, clock}; }
  void say(const std::array<std::int16_t, 6>& gauges, bool error = false) {
    const auto bytes = encode(DigitalSample{gauges, error});
    line.stream.insert(line.stream.end(), bytes.begin(), bytes.end());
  }
  [[nodiscard]] long jams() const { return std::ranges::count(line.written, Bytes(14, 0xFF)); }
  Line line;
  DigitalFtOptions options;
  ManualClock clock;
};

}  // namespace tactbench::tests
