// The wires of the simulated rig through the shipped drivers, compared with a bare echo over loopback; and a run's
// steps compared with only their exchanges and only their stored rows.
#include <arpa/inet.h>
#include <benchmark/benchmark.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <functional>
#include <stdexcept>
#include <thread>

#include "bench/common/private_files.h"
#include "bench/common/process_time.h"
#include "bench/config/config.h"
#include "bench/config/config_profile.h"
#include "bench/rig/rig.h"
#include "bench/simulation/plant.h"
#include "devices/device.h"
#include "devices/pressure/analog_module.h"
#include "devices/pressure/simulated_module.h"
#include "devices/stage/simulated_chain.h"
#include "devices/wire/byte_stream.h"
#include "tests/benchmarks/speed/ratios.h"
#include "tests/benchmarks/study/simulated_run.h"

namespace tactbench::speed {
namespace {

using namespace bench;

double now_s() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

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
      while (::recv(server_, bytes, sizeof bytes, 0) > 0)
        if (::send(server_, bytes, sizeof bytes, MSG_NOSIGNAL) <= 0) return;
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
    if (::send(client_, bytes, sizeof bytes, MSG_NOSIGNAL) <= 0 || ::recv(client_, bytes, sizeof bytes, 0) <= 0)
      throw std::runtime_error("the echo broke");
  }

 private:
  int client_ = -1, server_ = -1;
  std::thread thread_;
};

void echo(benchmark::State& state) {
  const Echo echo;
  for (auto _ : state) echo.exchange();
}

using Exchange = std::function<void()>;

// On a separate rig; `prepare` returns the measured work.
void on_rig(benchmark::State& state, const std::vector<sequences::Override>& overrides, Exchange (*prepare)(Rig& rig)) {
  Rig rig(read_bench(find_config("simulated.toml"), overrides));
  rig.open();
  const Exchange exchange = prepare(rig);
  for (auto _ : state) exchange();
}

void modbus_rtu(benchmark::State& state) {
  Rig rig(read_bench(find_config("simulated.toml"), {}));
  rig.open();
  const devices::ModuleProfile profile = read_module_profile("waveshare-analog-input-8ch-b");
  devices::SteadyClock clock;
  devices::SimulatedModule line({{1, profile, {}}}, devices::SimulatedModule::Wire::kRtu, 0, *rig.plant(), clock);
  devices::ModbusEndpoint endpoint;
  endpoint.serial_port = line.serial_port();
  endpoint.baud = 115200;
  devices::AnalogModule module(profile, endpoint, devices::Nanoseconds(0), clock, devices::Origin::kSimulated);
  for (auto _ : state) module.refresh(devices::Nanoseconds(-1));
}

// From the hang-up of a simulated serial line to the fault in a reader that waits.
void hang_up_to_fault(benchmark::State& state) {
  for (auto _ : state) {
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
        fault_s = now_s();
      }
    });
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    const double start_s = now_s();
    chain.unplug();
    reader.join();
    state.SetIterationTime(fault_s - start_s);
  }
}

// One repeat of the descending sequence on the manual clock, from the first step to the last.
RunRequest one_repeat() { return descending_request(1, 1); }

struct Taken {
  double run_s = 0.0;
  std::vector<db::FrameRecord> frames;
};
Taken run_once() {
  const ScratchFolder folder("tactbench-speed");
  db::RunStore store = db::RunStore::open(folder.path() + "/runs.db", db::Durability::kNormal);
  RunRequest request = one_repeat();
  double first = 0.0, last = 0.0;
  request.on_step = [&](const sequences::Step&) {
    last = now_s();
    if (first == 0.0) first = last;
  };
  const std::int64_t run = carry_out(request, store).run;
  Taken taken{last - first, store.frames(run)};
  taken.frames.pop_back();  // the last step's end is not known
  return taken;
}
const std::vector<db::FrameRecord>& frames_taken() {
  static const std::vector<db::FrameRecord> frames = run_once().frames;
  return frames;
}

void per_step(benchmark::State& state) {
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(frames_taken().size()));
}

void sequence_run(benchmark::State& state) {
  for (auto _ : state) state.SetIterationTime(run_once().run_s);
  per_step(state);
}

// What the run did on its wires, at the times of its trace: commands, polls of feedback and reference, frames.
void sequence_exchanges(benchmark::State& state) {
  const std::vector<db::FrameRecord>& frames = frames_taken();
  for (auto _ : state) {
    Rig rig(one_repeat().bench);
    rig.open();
    const devices::Nanoseconds begun =
        rig.clock().now() - devices::Nanoseconds(frames.front().time_ns - frames.front().since_command_ns);
    const auto wait_until = [&](std::int64_t time_ns) {
      rig.clock().wait_until(begun + devices::Nanoseconds(time_ns));
    };
    const double start_s = now_s();
    for (const db::FrameRecord& frame : frames) {
      const std::int64_t command_ns = frame.time_ns - frame.since_command_ns;
      bool commanded = false;
      for (const db::TracePoint& point : frame.trace) {
        const std::int64_t time_ns = frame.time_ns - seconds(static_cast<double>(point.before_frame_s)).count();
        if (!commanded && time_ns > command_ns) {
          wait_until(command_ns);
          (void)rig.source().command(devices::Psi(frame.setpoint_psi));
          commanded = true;
        }
        wait_until(time_ns);
        rig.source().keep_alive();
        (void)rig.source().feedback();
        (void)rig.reference().read();
      }
      wait_until(frame.time_ns);
      (void)rig.array().read(frame.scans);
    }
    state.SetIterationTime(now_s() - start_s);
  }
  per_step(state);
}

void sequence_store(benchmark::State& state) {
  for (auto _ : state) {
    const ScratchFolder folder("tactbench-speed");
    db::RunStore store = db::RunStore::open(folder.path() + "/runs.db", db::Durability::kNormal);
    const RunRequest request = one_repeat();
    store.add_sensor(request.sensor);
    db::RunRecord run;
    run.uuid = db::new_uuid();
    run.origin = "simulated";
    run.state = "prepared";
    run.sensor_serial = request.sensor.serial;
    run.sequences = {{0, "descending", "", "", 1, static_cast<int>(frames_taken().size())}};
    const std::int64_t number = store.begin_run(run), branch = store.begin_branch(number, {});
    std::vector<db::FrameRecord> frames = frames_taken();
    const double start_s = now_s();
    for (db::FrameRecord& frame : frames) {
      frame.branch = branch;
      store.append_frame(number, frame);
    }
    state.SetIterationTime(now_s() - start_s);
  }
  per_step(state);
}

const bool registered = [] {
  const auto timed = [](const std::string& name, auto act) {
    return benchmark::RegisterBenchmark(name.c_str(), act)->Unit(benchmark::kMicrosecond);
  };
  const auto wire = [&](const std::string& name, auto act) {
    timed("wires/" + name, act)->UseRealTime();
    if (name != "echo") declare({{"wires_" + name + "_over_echo", "wires/" + name, {"wires/echo"}}});
  };
  const auto plain = [&](const std::string& name, Exchange (*prepare)(Rig& rig),
                         const std::vector<sequences::Override>& overrides = {}) {
    wire(name, [=](benchmark::State& state) { on_rig(state, overrides, prepare); });
  };
  wire("echo", echo);
  plain("modbus_tcp_read", [](Rig& rig) -> Exchange {
    const ModuleConfig& module = rig.config().module;
    auto own = std::make_shared<devices::AnalogModule>(module.profile, module.endpoint, devices::Nanoseconds(0),
                                                       rig.clock(), devices::Origin::kSimulated);
    return [own] { own->refresh(devices::Nanoseconds(-1)); };
  });
  plain("modbus_tcp_command",
        [](Rig& rig) -> Exchange { return [&rig] { (void)rig.source().command(devices::Psi(0.0)); }; });
  plain("hid_scan_256_taxels", [](Rig& rig) -> Exchange { return [&rig] { (void)rig.array().read(1); }; });
  plain("frame_source_scan_256_taxels", [](Rig& rig) -> Exchange { return [&rig] { (void)rig.array().read(1); }; },
        {{"scanner.kind", "frame-source"}});
  plain("zaber_query", [](Rig& rig) -> Exchange {
    rig.stage()->arm();
    return [&rig] { (void)rig.stage()->state(devices::Axis::kX); };
  });
  plain("net_ft_record", [](Rig& rig) -> Exchange { return [&net = rig.open_force()] { (void)net.read(1); }; });
  plain("net_ft_50_records", [](Rig& rig) -> Exchange { return [&net = rig.open_force()] { (void)net.read(50); }; });
  wire("modbus_rtu_read", modbus_rtu);
  timed("wires/disconnect_to_fault", hang_up_to_fault)->UseManualTime()->Iterations(20);
  timed("sequence/run", sequence_run)->UseManualTime()->Iterations(1);
  timed("sequence/exchanges_only", sequence_exchanges)->UseManualTime()->Iterations(1);
  timed("sequence/store_only", sequence_store)->UseManualTime()->Iterations(1);
  return declare(
      {{"sequence_over_exchanges_and_store", "sequence/run", {"sequence/exchanges_only", "sequence/store_only"}}});
}();

}  // namespace
}  // namespace tactbench::speed
