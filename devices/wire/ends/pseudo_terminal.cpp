#include "devices/wire/ends/pseudo_terminal.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <stdlib.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

#include "devices/device.h"

namespace tactbench::devices {

PseudoTerminal::PseudoTerminal() {
  master_ = ::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  std::array<char, 128> name{};
  termios settings{};
  const bool named = master_ >= 0 && ::grantpt(master_) == 0 && ::unlockpt(master_) == 0 &&
                     ::ptsname_r(master_, name.data(), name.size()) == 0;
  // Without an open slave the master reports a hang-up until the first client comes.
  if (named) slave_ = ::open(name.data(), O_RDWR | O_NOCTTY | O_CLOEXEC);
  bool raw = slave_ >= 0 && ::tcgetattr(slave_, &settings) == 0;
  if (raw) {
    ::cfmakeraw(&settings);
    raw = ::tcsetattr(slave_, TCSANOW, &settings) == 0;
  }
  if (!raw) {
    const int error = errno;
    close_both();
    throw Fault("TB-SIM-LISTEN", "pseudo-terminal", fmt::format("making a pseudo-terminal: {}", std::strerror(error)),
                "Check that /dev/pts is mounted and that the system has pseudo-terminals left.");
  }
  path_ = name.data();
}

void PseudoTerminal::hang_up() {
  if (master_ >= 0) ::close(std::exchange(master_, -1));
}

void PseudoTerminal::close_both() {
  for (int* descriptor : {&slave_, &master_}) {
    if (*descriptor >= 0) ::close(std::exchange(*descriptor, -1));
  }
}

}  // namespace tactbench::devices
