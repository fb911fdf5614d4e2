#include "bench/benchmarks/wires.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <functional>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

#include "analysis/statistics/numbers/moments.h"
#include "bench/config/config.h"
#include "bench/config/config_profile.h"
#include "bench/rig/rig.h"
#include "bench/simulation/plant.h"
#include "devices/fault.h"
#include "devices/pressure/analog_module.h"
#include "devices/pressure/simulated_module.h"
#include "devices/stage/simulated_chain.h"
#include "devices/wire/serial_link.h"

namespace tactbench::bench {

namespace {

// The median of `times` acts, after a tenth as many that warm up.
double warm_median(int times, const std::function<void()>& act) {
  for (int i = 0; i < times / 10 + 1; ++i) act();
  return median_microseconds(times, act);
}

// The lower bound for any driver on loopback: twelve bytes there and back between two threads.
class Echo {
 public:
  Echo() {
    const int listener = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    client_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    const bool joined = ::bind(listener, reinterpret_cast<const sockaddr*>(&address), size) == 0 &&
                        ::listen(listener, 1) == 0 &&
                        ::getsockname(listener, reinterpret_cast<sockaddr*>(&address), &size) == 0 &&
                        ::connect(client_, reinterpret_cast<const sockaddr*>(&address), size) == 0;
    server_ = joined ? ::accept(listener, nullptr, nullptr) : -1;
    ::close(listener);
    if (server_ < 0) throw std::runtime_error("no echo on loopback");
    const int one = 1;
    ::setsockopt(client_, IPPROTO_TCP, TCP_NODELAY, &one, sizeof one);
    ::setsockopt(server_, IPPROTO_TCP, TCP_NODELAY, &one, sizeof one);
    thread_ = std::thread([this] {
      char bytes[12];
      while (::recv(server_, bytes, sizeof bytes, 0) > 0) {
        if (::send(server_, bytes, sizeof bytes, MSG_NOSIGNAL) <= 0) return;
      }
    });
  }
  ~Echo() {
    ::shutdown(client_, SHUT_RDWR);
    thread_.join();
    ::close(client_);
    ::close(server_);
  }
  Echo(const Echo&) = delete;
  Echo& operator=(const Echo&) = delete;
  void exchange() const {
    char bytes[12] = {};
    if (::send(client_, bytes, sizeof bytes, MSG_NOSIGNAL) <= 0 || ::recv(client_, bytes, sizeof bytes, 0) <= 0) {
      throw std::runtime_error("the echo broke");
    }
  }

 private:
  int client_ = -1, server_ = -1;
  std::thread thread_;
};

BenchConfig config_with(const std::vector<sequences::Override>& overrides) {
  return read_bench(find_config("simulated.toml"), overrides);
}

// From the hang-up of a simulated serial line to the fault in a reader that waits: median of `times`.
double hang_up_to_fault_microseconds(int times) {
  std::vector<double> taken;
  for (int i = 0; i < times; ++i) {
    const devices::SteadyClock clock;
    devices::SimulatedChain chain({}, clock);
    devices::SerialAddress address;
    address.port = chain.address();
    const auto stream = devices::open_serial(address);
    double fault_s = 0.0;
    std::thread reader([&] {
      try {
        std::uint8_t byte = 0;
        (void)stream->read(std::span(&byte, 1), std::chrono::seconds(20));
      } catch (const devices::Fault&) {
        fault_s = now_s(By::kWall);
      }
    });
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    const double start_s = now_s(By::kWall);
    chain.unplug();
    reader.join();
    taken.push_back(1e6 * (fault_s - start_s));
  }
  return analysis::quantile_of(std::move(taken), 0.5);
}

}  // namespace

std::vector<Figure> benchmark_wires(int exchanges) {
  std::vector<Figure> figures;
  const Echo echo;
  const double floor = warm_median(exchanges, [&] { echo.exchange(); });
  figures.push_back({"floor_tcp_echo", floor, "us"});
  const auto add = [&](const std::string& name, int times, const std::function<void()>& act) {
    const double value = warm_median(times, act);
    figures.push_back({name, value, "us"});
    figures.push_back({name + "_vs_floor", value / floor, "x"});
  };
  Rig rig(config_with({}));
  rig.open();
  add("modbus_tcp_read", exchanges, [&] { rig.module().refresh(devices::Nanoseconds(-1)); });
  add("modbus_tcp_command_and_readback", exchanges, [&] { (void)rig.source().command(devices::Psi(0.0)); });
  add("hid_reports_scan_256_taxels", exchanges, [&] { (void)rig.array().read(1); });
  rig.stage()->arm();
  add("zaber_pty_question", exchanges, [&] { (void)rig.stage()->state(devices::Axis::kX); });
  devices::ForceSensor& net = rig.open_force();
  add("net_ft_1_record", exchanges, [&] { (void)net.read(1); });
  add("net_ft_50_records", exchanges / 5 + 1, [&] { (void)net.read(50); });
  Rig other(config_with({{"scanner.kind", "frame-source"}}));
  other.open();
  add("frame_source_scan_256_taxels", exchanges, [&] { (void)other.array().read(1); });
  devices::ModbusEndpoint endpoint;
  const devices::ModuleProfile profile = read_module_profile("waveshare-analog-input-8ch-b");
  devices::SteadyClock clock;
  devices::SimulatedModule line({{1, profile, {}}}, devices::SimulatedModule::Wire::kRtu, 0, *rig.plant(), clock);
  endpoint.serial_port = line.serial_port();
  endpoint.baud = 115200;
  devices::AnalogModule rtu(profile, endpoint, devices::Nanoseconds(0), clock, devices::Origin::kSimulated);
  add("modbus_rtu_read_with_frame_gap", exchanges / 5 + 1, [&] { rtu.refresh(devices::Nanoseconds(-1)); });
  figures.push_back({"serial_hang_up_to_fault", hang_up_to_fault_microseconds(21), "us"});
  return figures;
}

}  // namespace tactbench::bench
