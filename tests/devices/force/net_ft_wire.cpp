#include "devices/force/net_ft.h"

#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <mutex>

#include "devices/force/simulated_net_ft.h"
#include "devices/wire/ends/stream_end.h"
#include "tests/devices/test_chamber.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;

namespace {

// The n-th wrench requested (from 0) is the base and n steps on Fx.
class SteppedLoad final : public ForcePort {
 public:
  Wrench wrench() override {
    const std::lock_guard lock(mutex_);
    Wrench wrench = base_;
    wrench.force_n[0] += step * asked++;
    return wrench;
  }
  void force(std::size_t axis, double newtons) {
    const std::lock_guard lock(mutex_);
    base_.force_n[axis] = newtons;
  }
  std::atomic<double> step = 0.0;
  std::atomic<int> asked = 0;

 private:
  std::mutex mutex_;
  Wrench base_{{1.0, -2.0, 3.0}, {10.0, -20.0, 30.0}};
};

struct NetFtRig {
  explicit NetFtRig(SimulatedNetFtFaults faults = {}, Nanoseconds reply_timeout = 20s)
      : server({0, 0, page(), faults}, load) {
    options.host = "127.0.0.1";
    options.port = server.rdt_port();
    options.http_port = server.http_port();
    options.reply_timeout = reply_timeout;
    options.page_timeout = 20s;
    options.origin = Origin::kSimulated;
    sensor = std::make_unique<NetFt>(options, clock);
  }
  static NetFtPage page() {
    NetFtPage page;
    page.product = "simulated Net F/T";
    page.calibration_serial = "FT99901";
    page.firmware = "1.0";
    page.range = SixAxes{25, 25, 35, 250, 250, 250};
    return page;
  }
  ManualClock clock;
  SteppedLoad load;
  SimulatedNetFt server;
  NetFtOptions options;
  std::unique_ptr<NetFt> sensor;
};

}  // namespace

TEST_CASE("Net F/T: a reading is the mean of the requested records, and includes their raw counts") {
  NetFtRig rig;
  rig.load.step = 0.5;
  rig.clock.wait_until(7s);
  const auto reading = rig.sensor->read(5);
  CHECK(reading.records == 5);
  CHECK(reading.wrench.force_n[0] == Approx(2.0));
  CHECK(reading.wrench.force_n[1] == Approx(-2.0));
  CHECK(reading.wrench.force_n[2] == Approx(3.0));
  CHECK(reading.wrench.torque_nmm == std::array<double, 3>{10.0, -20.0, 30.0});
  CHECK(reading.raw == SixAxes{2e6, -2e6, 3e6, 10e6, -20e6, 30e6});
  CHECK(reading.time == 7s);
  CHECK(reading.status == 0);
  CHECK(rig.clock.now() == 7s);
  CHECK(rig.load.asked == 5);  // nothing flows unasked
  CHECK(rig.sensor->exchanges() == 1);
  CHECK(rig.sensor->range() == SixAxes{25, 25, 35, 250, 250, 250});
  CHECK(rig.sensor->calibration_serial() == "FT99901");
  CHECK(rig.sensor->identity().firmware == "1.0");
}

TEST_CASE("Net F/T: a load beyond the set share of the range is a fault, and the next reading succeeds") {
  NetFtRig rig;
  rig.load.force(2, -35.1);
  check_fault([&] { (void)rig.sensor->read(3); }, "TB-FORCE-OVERLOAD", {}, "-35.1 N");
  rig.load.force(2, -34.9);
  CHECK(rig.sensor->read(3).records == 3);
  rig.options.overload_share = 0.5;
  NetFt careful(rig.options, rig.clock);
  CHECK(fault_id_of([&] { (void)careful.read(3); }) == "TB-FORCE-OVERLOAD");
}

TEST_CASE("Net F/T: a host name, a port without a listener and a port in use are faults") {
  NetFtRig rig;
  rig.options.host = "sensor.example";
  CHECK(fault_id_of([&] { NetFt(rig.options, rig.clock); }) == "TB-HTTP-OPEN");
  rig.options.host = "127.0.0.1";
  const auto nobody = bind_loopback(SOCK_DGRAM, 0, "test");
  ::close(nobody.socket);
  rig.options.port = nobody.port;
  NetFt sensor(rig.options, rig.clock);
  CHECK(fault_id_of([&] { (void)sensor.read(1); }) == "TB-UDP-LOST");
  CHECK(fault_id_of([&] {
          SimulatedNetFt({rig.server.rdt_port(), 0, NetFtRig::page(), {}}, rig.load);
        }) == "TB-SIM-LISTEN");
}
