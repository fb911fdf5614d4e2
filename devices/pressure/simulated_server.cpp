#include "devices/pressure/simulated_server.h"

#include <fmt/format.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>

#include "devices/device.h"

namespace tactbench::devices {
namespace {

constexpr int kRegisters = 65536;  // the whole map: profiles put theirs anywhere

}  // namespace

SimulatedModule::Server::Server(std::vector<SimulatedUnit> units, ChamberPort& chamber, const Clock& clock,
                                SimulatedModuleFaults faults)
    : stop_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)),
      faults_(std::move(faults)),
      mapping_(modbus_mapping_new(kRegisters, kRegisters, kRegisters, kRegisters)) {
  for (SimulatedUnit& unit : units)
    units_.push_back(std::make_unique<ModuleRegisters>(std::move(unit), chamber, clock));
}

SimulatedModule::Server::~Server() {
  if (stop_ >= 0) ::close(stop_);
  modbus_mapping_free(mapping_);
  if (modbus_ == nullptr) return;
  modbus_set_socket(modbus_, -1);
  modbus_free(modbus_);
}

void SimulatedModule::Server::stop() {
  const std::uint64_t one = 1;
  [[maybe_unused]] const ssize_t written = ::write(stop_, &one, sizeof one);
  if (thread_.joinable()) thread_.join();
}

void SimulatedModule::Server::fail_to_listen(const std::string& what, int error) {
  throw Fault("TB-SIM-LISTEN", "simulated module", fmt::format("{}: {}", what, std::strerror(error)),
              "Choose another port, or 0 to let the system choose.");
}

void SimulatedModule::Server::connected() {
  for (const auto& unit : units_) unit->connected();
}

void SimulatedModule::Server::disconnected(int client) {
  for (const auto& unit : units_) unit->disconnected(client);
}

SimulatedModule::Server::Answer SimulatedModule::Server::answer(int client, int descriptor,
                                                                std::span<const std::uint8_t> frame, std::size_t header,
                                                                std::size_t trailer) {
  const int asked = frame[header];
  const auto unit = std::find_if(units_.begin(), units_.end(), [&](const auto& candidate) {
    return candidate->unit() == 0 || candidate->unit() == asked;
  });
  if (unit == units_.end()) return Answer::kNone;
  const long number = requests_++;
  if (faults_.dead_after_requests >= 0 && number >= faults_.dead_after_requests) return Answer::kDie;
  if (faults_.silent_after_requests >= 0 && number >= faults_.silent_after_requests) return Answer::kNone;
  injected_ = faults_.inject ? faults_.inject() : InjectedFault::kNone;
  if (injected_ == InjectedFault::kUnplugged) return Answer::kBroken;
  if (injected_ == InjectedFault::kSilent) return Answer::kNone;
  Refusal refusal = injected_ == InjectedFault::kBusy ? Refusal::kBusy : Refusal::kFailure;
  try {
    for (const auto& each : units_) each->turn();
    if (injected_ != InjectedFault::kRefused && injected_ != InjectedFault::kBusy) {
      refusal = carry_out(**unit, client, frame.subspan(header + 1, frame.size() - header - 1 - trailer));
    }
  } catch (...) {
    // The port failed: the client sees a failed device.
  }
  if (late_client_ == client && !late_.empty()) {
    if (::write(descriptor, late_.data(), late_.size()) < 0) return Answer::kBroken;
    late_.clear();
  }
  if (injected_ == InjectedFault::kLate || injected_ == InjectedFault::kCorrupt) {
    std::vector<std::uint8_t> bytes = catch_reply(frame, refusal);
    if (injected_ == InjectedFault::kLate) {
      late_client_ = client;
      late_ = std::move(bytes);
      return Answer::kNone;
    }
    if (bytes.size() > header + 1)
      bytes[header + 1] ^= 0x10U;  // the function code: also detected on TCP, which has no Modbus checksum
    return ::write(descriptor, bytes.data(), bytes.size()) >= 0 ? Answer::kSent : Answer::kBroken;
  }
  modbus_set_socket(modbus_, descriptor);
  return reply(frame, refusal) >= 0 ? Answer::kSent : Answer::kBroken;
}

int SimulatedModule::Server::reply(std::span<const std::uint8_t> frame, Refusal refusal) {
  return refusal == Refusal::kNone ? modbus_reply(modbus_, frame.data(), static_cast<int>(frame.size()), mapping_)
                                   : modbus_reply_exception(modbus_, frame.data(), static_cast<unsigned>(refusal));
}

std::vector<std::uint8_t> SimulatedModule::Server::catch_reply(std::span<const std::uint8_t> frame, Refusal refusal) {
  std::array<int, 2> ends{};
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, ends.data()) != 0) return {};
  modbus_set_socket(modbus_, ends[0]);
  reply(frame, refusal);
  std::vector<std::uint8_t> bytes(MODBUS_MAX_ADU_LENGTH);
  const ssize_t got = ::read(ends[1], bytes.data(), bytes.size());
  bytes.resize(got > 0 ? static_cast<std::size_t>(got) : 0);
  for (const int end : ends) ::close(end);
  return bytes;
}

// Carries out the request and leaves the values to be answered in the mapping, from which libmodbus answers.
Refusal SimulatedModule::Server::carry_out(ModuleRegisters& registers, int client, std::span<const std::uint8_t> pdu) {
  const int function = pdu[0];
  if (function != 2 && function != 3 && function != 4 && function != 5 && function != 6 && function != 16 &&
      function != 23) {
    return Refusal::kFunction;
  }
  if (pdu.size() < 5) return Refusal::kValue;
  const int address = static_cast<int>(word_at(pdu, 1));
  const std::size_t count = function == 6 ? 1 : word_at(pdu, 3);
  switch (function) {
    case 2:
      if (pdu.size() != 5 || count < 1 || count > MODBUS_MAX_READ_BITS) return Refusal::kValue;
      return read_bits(registers, address, count);
    case 3:
    case 4:
      if (pdu.size() != 5 || count < 1 || count > MODBUS_MAX_READ_REGISTERS) return Refusal::kValue;
      return read(registers, client, function, address, count);
    case 5:
      if (pdu.size() != 5 || (count != 0xFF00 && count != 0)) return Refusal::kValue;
      return registers.write_bit(address, count != 0);
    case 6:
      return pdu.size() == 5 ? write(registers, client, address, pdu.subspan(3)) : Refusal::kValue;
    case 16:
      if (count < 1 || count > MODBUS_MAX_WRITE_REGISTERS || pdu.size() != 6 + 2 * count || pdu[5] != 2 * count) {
        return Refusal::kValue;
      }
      return write(registers, client, address, pdu.subspan(6));
    default: {
      if (pdu.size() < 10 || count < 1 || count > MODBUS_MAX_WR_READ_REGISTERS) return Refusal::kValue;
      const std::size_t written = word_at(pdu, 7);
      if (written < 1 || written > MODBUS_MAX_WR_WRITE_REGISTERS || pdu.size() != 10 + 2 * written ||
          pdu[9] != 2 * written) {
        return Refusal::kValue;
      }
      Refusal refusal = registers.check_read(3, address, count);
      if (refusal == Refusal::kNone) {
        refusal = write(registers, client, static_cast<int>(word_at(pdu, 5)), pdu.subspan(10));
      }
      return refusal == Refusal::kNone ? read(registers, client, 3, address, count) : refusal;
    }
  }
}

Refusal SimulatedModule::Server::read(ModuleRegisters& registers, int client, int function, int address,
                                      std::size_t count) {
  if (injected_ == InjectedFault::kStale) return Refusal::kNone;  // the mapping holds the values read before
  std::uint16_t values[MODBUS_MAX_READ_REGISTERS];
  const Refusal refusal = registers.read(client, function, address, std::span(values, count));
  std::uint16_t* table = function == 4 ? mapping_->tab_input_registers : mapping_->tab_registers;
  if (refusal == Refusal::kNone) std::copy_n(values, count, table + address);
  return refusal;
}

Refusal SimulatedModule::Server::read_bits(const ModuleRegisters& registers, int address, std::size_t count) {
  if (injected_ == InjectedFault::kStale) return Refusal::kNone;
  std::vector<std::uint8_t> bits(count);
  const Refusal refusal = registers.read_bits(address, bits);
  if (refusal == Refusal::kNone) std::copy(bits.begin(), bits.end(), mapping_->tab_input_bits + address);
  return refusal;
}

Refusal SimulatedModule::Server::write(ModuleRegisters& registers, int client, int address,
                                       std::span<const std::uint8_t> bytes) {
  std::uint16_t values[MODBUS_MAX_WRITE_REGISTERS];
  const std::size_t count = bytes.size() / 2;
  for (std::size_t i = 0; i < count; ++i) values[i] = static_cast<std::uint16_t>(word_at(bytes, 2 * i));
  return registers.write(client, address, std::span(values, count));
}

}  // namespace tactbench::devices
