// Driver of the ATI Digital F/T over any ByteStream (RS-485, 1 250 000 baud, 8 data bits, even parity, 1 stop bit as
// far as known): the stream is started and stopped around each reading. Not verified on hardware.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "devices/force/ati_matrix.h"
#include "devices/force/digital_record.h"
#include "devices/force/force_checks.h"
#include "devices/force/force_sensor.h"
#include "devices/force/options.h"
#include "devices/wire/byte_stream.h"

namespace tactbench::devices {

class DigitalFt final : public ForceSensor {
 public:
  // Stops a stream that may be running, reads the calibration and checks that the active gains and offsets are those of
  // the calibration. Writes no register. Throws Fault TB-FORCE-CALIBRATION, TB-FORCE-SERIAL, TB-FORCE-TIMEOUT,
  // TB-FORCE-PROTOCOL and the stream's.
  DigitalFt(std::unique_ptr<ByteStream> stream, DigitalFtOptions options, Clock& clock);
  // Damaged samples are discarded and counted as lost; reading resumes where two samples in a row have the right sum.
  // Samples carry no counter: a sensor that repeats itself is not detected. `raw` holds gauge counts G0 to G5.
  [[nodiscard]] ForceReading read(int records) override;
  ForceReading bias(int records) override;
  [[nodiscard]] SixAxes range() const override { return range_; }
  [[nodiscard]] std::string calibration_serial() const override { return calibration_.serial; }
  [[nodiscard]] std::uint64_t exchanges() const override { return exchanges_; }
  [[nodiscard]] Identity identity() const override;

 private:
  ForceReading measure(int records, const Wrench& bias);
  void stream_samples(int records, const Wrench& bias, Vector6& sum, ForceSpread& spread);
  [[nodiscard]] Vector6 gauges_of(const DigitalSample& sample) const;
  void stop();
  std::vector<std::uint8_t> read_registers(int address, int count);
  std::vector<std::uint8_t> answer(std::span<const std::uint8_t> request, std::size_t size, const std::string& asked);
  std::vector<std::uint8_t> receive(std::size_t size, const std::string& asked);
  [[nodiscard]] SixAxes scaled(const Vector6& gauges) const;
  [[noreturn]] void timed_out(const std::string& asked, const std::string& came, Nanoseconds nominal);
  std::unique_ptr<ByteStream> stream_;
  DigitalFtOptions options_;
  Clock& clock_;
  DigitalCalibration calibration_;
  Matrix6 matrix_;  // N and N*mm per gauge count
  SixAxes range_{};
  Wrench bias_;
  std::uint64_t exchanges_ = 0;
  std::uint64_t lost_ = 0;
};

}  // namespace tactbench::devices
