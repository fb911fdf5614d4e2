// Shared by the simulated module's TCP and RTU servers: units, execution of requests, faults. libmodbus builds the
// answers. Used only by simulated_module*.cpp.
#pragma once

#include <modbus.h>

#include <cstdint>
#include <memory>
#include <span>
#include <thread>
#include <vector>

#include "devices/pressure/module_registers.h"
#include "devices/wire/ends/end_activity.h"

namespace tactbench::devices {

// A big-endian word of a Modbus frame.
inline std::size_t word_at(std::span<const std::uint8_t> bytes, std::size_t at) {
  return static_cast<std::size_t>(bytes[at]) << 8U | bytes[at + 1];
}

class SimulatedModule::Server {
 public:
  Server(std::vector<SimulatedUnit> units, ChamberPort& chamber, const Clock& clock, SimulatedModuleFaults faults);
  virtual ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;
  [[nodiscard]] virtual int port() const { return 0; }
  [[nodiscard]] virtual std::string serial_port() const { return {}; }

 protected:
  enum class Answer { kSent, kNone, kBroken, kDie };
  // One request of client number `client`, answered on `descriptor`: `frame` is header, unit, PDU, trailer.
  Answer answer(int client, int descriptor, std::span<const std::uint8_t> frame, std::size_t header,
                std::size_t trailer);
  [[noreturn]] void fail_to_listen(const std::string& what, int error);
  void start() {
    thread_ = work_.thread([this] { serve(); });
  }
  void stop();  // must be called by the destructor of the class that has serve()
  void connected();
  void disconnected(int client);

  modbus_t* modbus_ = nullptr;
  int stop_ = -1;  // readable: end
  EndActivity work_;

 private:
  virtual void serve() = 0;
  Refusal carry_out(ModuleRegisters& registers, int client, std::span<const std::uint8_t> pdu);
  Refusal read(ModuleRegisters& registers, int client, int function, int address, std::size_t count);
  Refusal write(ModuleRegisters& registers, int client, int address, std::span<const std::uint8_t> bytes);
  // The bytes that modbus_reply would send, to be corrupted.
  std::vector<std::uint8_t> catch_reply(std::span<const std::uint8_t> frame, Refusal refusal);
  int reply(std::span<const std::uint8_t> frame, Refusal refusal);
  Refusal read_bits(const ModuleRegisters& registers, int address, std::size_t count);
  std::vector<std::unique_ptr<ModuleRegisters>> units_;
  SimulatedModuleFaults faults_;
  modbus_mapping_t* mapping_ = nullptr;
  long requests_ = 0;
  InjectedFault injected_ = InjectedFault::kNone;  // of the request being answered
  int late_client_ = -1;
  std::vector<std::uint8_t> late_;
  std::thread thread_;
};

}  // namespace tactbench::devices
