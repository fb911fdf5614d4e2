// The host's part of vm_serial: the simulated Zaber chain behind QEMU's emulated USB adapter, pulled and plugged in
// when the guest asks. Run: vm_chain QEMU ARGUMENTS..., in the folder of the sockets.
// QEMU detaches the adapter when its socket closes, and attaches it when it has connected again, which it tries once a
// second. (Deleting the device by QEMU's monitor instead crashes QEMU 7.2 when a byte comes for it at that moment.)
#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <exception>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "devices/stage/simulated_chain.h"
#include "devices/wire/ends/stream_end.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;

namespace {

class Host {
 public:
  // Serves the guest until QEMU ends.
  void serve(int qemu) {
    for (;;) {
      pollfd descriptors[] = {{qemu, POLLIN, 0}, {control_.descriptor(), POLLIN, 0}};
      if (::poll(descriptors, 2, -1) < 0) continue;
      if (descriptors[0].revents != 0) return;
      std::array<std::uint8_t, 256> part{};
      const std::size_t got = control_.receive(part);
      for (const auto byte : std::span(part).first(got)) {
        if (byte != '\n') {
          line_ += static_cast<char>(byte);
          continue;
        }
        const std::string answer = fmt::format("{:.6f}\n", obey(std::exchange(line_, {})));
        control_.send(std::vector<std::uint8_t>(answer.begin(), answer.end()));
      }
    }
  }

 private:
  double obey(const std::string& order) {
    if (order == "unplug") {
      std::this_thread::sleep_for(100ms);  // meanwhile the guest goes to sleep in poll()
      unplugged_at_ = std::chrono::steady_clock::now();
      chain_.unplug();
      return 0.0;
    }
    if (order == "lost") {  // milliseconds from the pull until the guest has said that it saw it
      return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - unplugged_at_).count();
    }
    if (order == "plug") {
      chain_.plug_in();
      return 0.0;
    }
    if (order == "mark") return static_cast<double>(marked_ = chain_.requests().size());
    if (order == "moves") {  // instructions that move an axis, since the mark
      const auto requests = chain_.requests();
      return static_cast<double>(
          std::count_if(requests.begin() + static_cast<std::ptrdiff_t>(marked_), requests.end(), moves));
    }
    if (order == "z") return chain_.position(Axis::kZ).value();
    throw std::runtime_error("the guest asked for '" + order + "'");
  }

  static bool moves(const ZaberFrame& frame) {
    using enum ZaberCommand;
    return frame.command == kHome || frame.command == kMoveAbsolute || frame.command == kMoveRelative ||
           frame.command == kConstantSpeed || frame.command == kMoveToStoredPosition;
  }

  static SimulatedChainOptions options() {
    SimulatedChainOptions options;
    options.listen = "unix:chain.sock";
    options.free_running = true;
    for (ChainDeviceOptions& device : options.devices) device.stands_at = Millimetres(0.05);
    return options;
  }

  SteadyClock clock_;
  SimulatedChain chain_{options(), clock_};
  StreamEnd control_{"unix:control.sock"};
  std::chrono::steady_clock::time_point unplugged_at_;
  std::size_t marked_ = 0;
  std::string line_;
};

}  // namespace

int main(int, char** arguments) try {
  Host host;  // listens before QEMU connects
  const pid_t child = ::fork();
  if (child == 0) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    ::execvp(arguments[1], arguments + 1);
    std::perror(arguments[1]);
    ::_exit(127);
  }
  const int qemu = child > 0 ? static_cast<int>(::syscall(SYS_pidfd_open, child, 0)) : -1;
  if (qemu < 0) throw std::runtime_error("QEMU cannot be started");
  host.serve(qemu);
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 1;
} catch (const std::exception& error) {
  fmt::print(stderr, "vm_chain: {}\n", error.what());
  return 1;
}
