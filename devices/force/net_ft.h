// Driver of the ATI Net F/T (and related sensors) over RDT: each reading requests a number of records over UDP; the
// scale of the counts comes from the sensor's page netftapi2.xml. Not verified on hardware.
#pragma once

#include <optional>
#include <string>

#include "devices/force/force_checks.h"
#include "devices/force/force_sensor.h"
#include "devices/force/netft_xml.h"
#include "devices/force/options.h"
#include "devices/force/rdt_record.h"
#include "devices/wire/udp_link.h"

namespace tactbench::devices {

class NetFt final : public ForceSensor {
 public:
  // Reads the page, requests no record. Throws Fault TB-FORCE-CALIBRATION, TB-FORCE-SERIAL, TB-HTTP-*, TB-UDP-OPEN.
  NetFt(NetFtOptions options, Clock& clock);
  // Requests up to 100 records at a time. Missing records are requested again twice, from another local port, so that
  // late ones are never mistaken for replies. Each request is bounded by three times (reply timeout + the records'
  // time). A tripped threshold monitor is not an error; it is shown in the reading's status.
  [[nodiscard]] ForceReading read(int records) override;
  // The bias is kept in this driver, not in the sensor, so that raw counts stay what the sensor measures.
  ForceReading bias(int records) override;
  [[nodiscard]] SixAxes range() const override { return range_; }
  [[nodiscard]] std::string calibration_serial() const override { return page_.calibration_serial; }
  [[nodiscard]] std::uint64_t exchanges() const override { return exchanges_; }
  [[nodiscard]] Identity identity() const override;
  [[nodiscard]] const NetFtPage& page() const { return page_; }

 private:
  struct Sum {
    Wrench bias;  // subtracted before a record's load is checked
    SixAxes counts{};
    int records = 0;
    std::uint32_t status = 0;
    ForceSpread spread;
  };
  ForceReading measure(int records, const Wrench& bias);
  void request(int records, Sum& sum);
  int gather(int records, Sum& sum, Nanoseconds limit);
  void take(const RdtRecord& record, Sum& sum) const;
  [[noreturn]] void stalled(std::uint32_t sample);
  [[nodiscard]] SixAxes scaled(const SixAxes& counts) const;
  NetFtOptions options_;
  Clock& clock_;
  NetFtPage page_;
  SixAxes range_{};
  UdpLink link_;
  Wrench bias_;
  std::optional<std::uint32_t> newest_;  // F/T sequence of the last record used
  bool settled_ = true;                  // the last request received all its records
  std::uint64_t exchanges_ = 0;
  std::uint64_t lost_ = 0;
  std::uint64_t reordered_ = 0;
};

}  // namespace tactbench::devices
