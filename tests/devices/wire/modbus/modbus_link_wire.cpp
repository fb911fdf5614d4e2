#include <array>
#include <atomic>
#include <catch2/catch.hpp>
#include <map>
#include <mutex>
#include <numeric>
#include <string>
#include <thread>

#include "devices/pressure/simulated_module.h"
#include "devices/wire/modbus/modbus_link.h"
#include "tests/devices/scripted_server.h"
#include "tests/devices/test_chamber.h"
#include "tests/devices/timeouts.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;

namespace {

// Long where an answer is to come, short where none will.
ModbusEndpoint at(int port, Nanoseconds timeout = kPatient) { return {"127.0.0.1", port, 1, timeout}; }

std::uint16_t read_one(ModbusLink& link, int address) {
  std::uint16_t value = 0;
  link.read_input_registers(address, std::span(&value, 1));
  return value;
}

struct ModbusModule {
  explicit ModbusModule(SimulatedModuleFaults faults = {})
      : server(module_profile("beckhoff-ek9000"), 0, chamber, clock, faults) {}
  ManualClock clock;
  TestChamber chamber{clock};
  SimulatedModule server;
};

}  // namespace

TEST_CASE("modbus link: silence costs one response timeout, and the fault names request and device") {
  ModbusModule module({.silent_after_requests = 1});
  ModbusLink link(at(module.server.port(), kShort), "module", module.clock);
  CHECK(read_one(link, 1) == 0);
  check_fault([&] { read_one(link, 1); }, "TB-MODBUS-TIMEOUT", "module", "0x0001");
  CHECK(module.clock.now() == kShort);
}

// Every kind of request, the module's register of the first output, and the plant behind it.
TEST_CASE("modbus link: a busy module is asked again until it answers, and the request is carried out once") {
  std::map<std::string, int> drives;  // of the module that was never busy
  for (const int times : {0, 1, 2, 7}) {
    for (const std::string kind : {"one", "several", "both", "reading"}) {
      INFO(kind << ", busy " << times << " times");
      std::atomic<int> left{0};
      ModbusModule module({.inject = [&] { return left-- > 0 ? InjectedFault::kBusy : InjectedFault::kNone; }});
      ModbusLink link(at(module.server.port()), "module", module.clock);
      const std::array<std::uint16_t, 1> outputs{0x4000};
      std::array<std::uint16_t, 1> input{};
      module.chamber.reference_volts = Volts(10.0);
      left = times;
      if (kind == "one") link.write_register(0x0800, outputs[0]);
      if (kind == "several") link.write_registers(0x0800, outputs);
      if (kind == "both") link.write_and_read_registers(0x0800, outputs, 1, input);
      if (kind == "reading") link.read_input_registers(1, input);
      CHECK(link.exchanges() == static_cast<std::uint64_t>(times) + 1);
      CHECK(module.chamber.drives == drives.emplace(kind, module.chamber.drives).first->second);
      if (kind != "reading") CHECK(module.chamber.output().value() == Approx(5.0).margin(0.001));
      if (kind == "both" || kind == "reading") CHECK(input[0] == 0x7FFF);
      CHECK((module.clock.now() > 0ms) == (times > 0));
      CHECK(module.clock.now() <= 500ms);
      CHECK_THAT(link.take_busy_report(), Catch::Contains(times > 0 ? "exception 6" : ""));
      CHECK(link.take_busy_report().empty());
    }
  }
}

TEST_CASE("modbus link: a module that stays busy is a fault after the set time, and nothing was written") {
  ModbusModule module({.inject = [] { return InjectedFault::kBusy; }});
  ModbusEndpoint endpoint = at(module.server.port());
  endpoint.busy_time = 300ms;
  ModbusLink link(endpoint, "module", module.clock);
  check_fault([&] { link.write_register(0x0800, 0x4000); }, "TB-MODBUS-BUSY", "module", "0x0800");
  CHECK(module.clock.now() >= 300ms);
  CHECK(module.clock.now() < 350ms);
  CHECK(module.chamber.drives == 0);
}

TEST_CASE("modbus link: a request answered by exception 5, acknowledge, is repeated") {
  ScriptedServer server([](int number, int socket, const Bytes& request) {
    if (number > 2) return ScriptedServer::send(socket, ScriptedServer::answer(request, {7}));
    Bytes refusal(request.begin(), request.begin() + 8);
    refusal[5] = 3;
    refusal[7] |= 0x80U;
    refusal.push_back(5);
    ScriptedServer::send(socket, refusal);
  });
  ManualClock clock;
  ModbusLink link(at(server.port()), "module", clock);
  CHECK(read_one(link, 0) == 7);
  CHECK(link.exchanges() == 4);
}

TEST_CASE("modbus link: a module that is busy repeatedly is reported at each doubling of the count") {
  std::atomic<int> asked{0};
  ModbusModule module({.inject = [&] { return asked++ % 2 == 0 ? InjectedFault::kBusy : InjectedFault::kNone; }});
  ModbusLink link(at(module.server.port()), "module", module.clock);
  int news = 0;
  for (int i = 0; i < 64; ++i) {
    (void)read_one(link, 1);
    news += link.take_busy_report().empty() ? 0 : 1;
  }
  CHECK(news == 7);  // 1, 2, 4 ... 64
}

TEST_CASE("modbus link: after a lost reply, or one without its last byte, the next request gets its own answer") {
  for (const bool lost : {true, false}) {
    ScriptedServer server([lost](int number, int socket, const Bytes& request) {
      Bytes reply = ScriptedServer::answer(request, {static_cast<std::uint16_t>(100 + number)});
      if (number == 1 && lost) return;
      if (number == 1) reply.pop_back();
      ScriptedServer::send(socket, reply);
    });
    ManualClock clock;
    ModbusLink link(at(server.port(), kShort), "module", clock);
    CHECK(read_one(link, 0) == 100);
    CHECK(fault_id_of([&] { read_one(link, 1); }) == "TB-MODBUS-TIMEOUT");
    CHECK(read_one(link, 2) == 102);
    CHECK(read_one(link, 3) == 103);
  }
}

TEST_CASE("modbus link: a late reply is never used as the answer to a later request") {
  // The first answer is held back until the second request is there, and then sent before the second's own answer.
  Bytes held;
  int held_on = -1;
  ScriptedServer server([&](int number, int socket, const Bytes& request) {
    if (number == 0) {
      held = ScriptedServer::answer(request, {111});
      held_on = socket;
      return;
    }
    if (number == 1) ScriptedServer::send(held_on, held);
    ScriptedServer::send(socket, ScriptedServer::answer(request, {static_cast<std::uint16_t>(222 + number)}));
  });
  ManualClock clock;
  ModbusLink link(at(server.port(), kShort), "module", clock);
  CHECK(fault_id_of([&] { read_one(link, 0); }) == "TB-MODBUS-TIMEOUT");
  CHECK(read_one(link, 0) == 223);
  CHECK(read_one(link, 0) == 224);
}

TEST_CASE("modbus link: each of a thousand requests has its own transaction number, in both bytes") {
  std::array<std::atomic<bool>, 1 << 16> used{};
  ScriptedServer server([&](int, int socket, const Bytes& request) {
    const bool fresh = !used.at(request[0] * 256U + request[1]).exchange(true);
    ScriptedServer::send(socket, ScriptedServer::answer(request, {fresh ? std::uint16_t{1} : std::uint16_t{0}}));
  });
  ManualClock clock;
  ModbusLink link(at(server.port()), "module", clock);
  int fresh = 0;
  for (int i = 0; i < 1000; ++i) fresh += read_one(link, 0);
  CHECK(fresh == 1000);
}

TEST_CASE("modbus link: a reply that arrives in pieces is one reply") {
  ScriptedServer server([](int, int socket, const Bytes& request) {
    const Bytes reply = ScriptedServer::answer(request, {0x1234});
    for (const std::uint8_t byte : reply) {
      ScriptedServer::send(socket, {byte});
      std::this_thread::sleep_for(5ms);
    }
  });
  ManualClock clock;
  ModbusLink link(at(server.port()), "module", clock);
  CHECK(read_one(link, 0) == 0x1234);
  CHECK(read_one(link, 1) == 0x1234);
}

TEST_CASE("modbus link: a server that dies is a connection fault, and costs no time") {
  ModbusModule module({.dead_after_requests = 1});
  ModbusLink link(at(module.server.port()), "module", module.clock);
  CHECK(read_one(link, 1) == 0);
  for (int i = 0; i < 2; ++i) CHECK(fault_id_of([&] { read_one(link, 1); }) == "TB-MODBUS-CONNECT");
  CHECK(module.clock.now() == 0ns);  // a refusal costs no time
}

namespace {

// Gives the same answer, behind the request's own header, to each request, and keeps the last one.
class CannedModule {
 public:
  explicit CannedModule(Bytes answer) : answer_(std::move(answer)) {}
  [[nodiscard]] Bytes asked() {
    const std::lock_guard lock(mutex_);
    return request_;
  }
  template <class Act>
  std::string fault(Act&& act) {
    const auto fault = fault_of([&] { act(link); });
    if (fault) CHECK(fault->device() == "device");
    return fault ? fault->id() : "none";
  }

 private:
  void serve(int socket, const Bytes& request) {
    const std::lock_guard lock(mutex_);
    request_ = request;
    Bytes reply{request[0],
                request[1],
                0,
                0,
                static_cast<std::uint8_t>(answer_.size() >> 8U),
                static_cast<std::uint8_t>(answer_.size() & 0xFFU)};
    reply.insert(reply.end(), answer_.begin(), answer_.end());
    ScriptedServer::send(socket, reply);
  }
  std::mutex mutex_;
  const Bytes answer_;
  Bytes request_;
  ManualClock clock_;
  ScriptedServer server_{[this](int, int socket, const Bytes& request) { serve(socket, request); }};

 public:
  ModbusLink link{{"127.0.0.1", server_.port(), 1, kPatient}, "device", clock_};
};

constexpr std::array<std::uint16_t, 3> kThree{0x0102, 0x0304, 0xFFFE};
}  // namespace

TEST_CASE("modbus frames: the request of each function has the expected bytes") {
  const auto sent = [&](const Bytes& answer, auto&& act) {
    CannedModule module(answer);
    CHECK(module.fault(act) == "none");
    return module.asked();
  };
  std::array<std::uint16_t, 2> two{};
  CHECK(sent({1, 4, 4, 1, 2, 3, 4}, [&](ModbusLink& link) { link.read_input_registers(0x1234, two); }) ==
        Bytes{0, 1, 0, 0, 0, 6, 1, 4, 0x12, 0x34, 0, 2});
  CHECK(two == std::array<std::uint16_t, 2>{0x0102, 0x0304});
  CHECK(sent({1, 3, 4, 5, 6, 7, 8}, [&](ModbusLink& link) { link.read_holding_registers(0xFFFE, two); }) ==
        Bytes{0, 1, 0, 0, 0, 6, 1, 3, 0xFF, 0xFE, 0, 2});
  CHECK(two == std::array<std::uint16_t, 2>{0x0506, 0x0708});
  CHECK(sent({1, 5, 1, 2, 0xFF, 0}, [](ModbusLink& link) { link.write_coil(0x0102, true); }) ==
        Bytes{0, 1, 0, 0, 0, 6, 1, 5, 1, 2, 0xFF, 0});
  CHECK(sent({1, 5, 1, 2, 0, 0}, [](ModbusLink& link) { link.write_coil(0x0102, false); }) ==
        Bytes{0, 1, 0, 0, 0, 6, 1, 5, 1, 2, 0, 0});
  CHECK(sent({1, 6, 1, 2, 0xAB, 0xCD}, [](ModbusLink& link) { link.write_register(0x0102, 0xABCD); }) ==
        Bytes{0, 1, 0, 0, 0, 6, 1, 6, 1, 2, 0xAB, 0xCD});
  CHECK(sent({1, 16, 1, 2, 0, 3}, [](ModbusLink& link) { link.write_registers(0x0102, kThree); }) ==
        Bytes{0, 1, 0, 0, 0, 13, 1, 16, 1, 2, 0, 3, 6, 1, 2, 3, 4, 0xFF, 0xFE});
  CHECK(sent({1, 23, 4, 9, 8, 7, 6}, [&](ModbusLink& link) {
          link.write_and_read_registers(0x0102, kThree, 0x0304, two);
        }) == Bytes{0, 1, 0, 0, 0, 17, 1, 23, 3, 4, 0, 2, 1, 2, 0, 3, 6, 1, 2, 3, 4, 0xFF, 0xFE});
  CHECK(two == std::array<std::uint16_t, 2>{0x0908, 0x0706});
}

TEST_CASE("modbus frames: discrete inputs are packed eight to a byte, lowest first") {
  for (const int count : {1, 7, 8, 9, 16, 17}) {
    INFO(count << " inputs");
    const int bytes = count <= 8 ? 1 : count <= 16 ? 2 : 3;
    Bytes answer{1, 2, static_cast<std::uint8_t>(bytes)};
    for (int i = 0; i < bytes; ++i) answer.push_back(i == 0 ? 0xA5 : i == 1 ? 0x81 : 0x01);
    CannedModule module(answer);
    std::vector<bool> inputs;
    CHECK(module.fault([&](ModbusLink& link) { inputs = link.read_discrete_inputs(0x0102, count); }) == "none");
    const std::vector<bool> all{true,  false, true,  false, false, true,  false, true, true,
                                false, false, false, false, false, false, true,  true};
    CHECK(inputs == std::vector<bool>(all.begin(), all.begin() + count));
    CHECK(module.asked() == Bytes{0, 1, 0, 0, 0, 6, 1, 2, 1, 2, 0, static_cast<std::uint8_t>(count)});
    Bytes longer = answer;
    longer.push_back(0);
    longer[2] = static_cast<std::uint8_t>(longer[2] + 1);
    CannedModule too_much(longer);
    CHECK(too_much.fault([&](ModbusLink& link) { (void)link.read_discrete_inputs(0x0102, count); }) ==
          "TB-MODBUS-PROTOCOL");
  }
}

TEST_CASE("modbus frames: a request as large as the largest frame is sent, a larger or empty one is refused") {
  std::vector<std::uint16_t> words(126);
  std::iota(words.begin(), words.end(), std::uint16_t{0x0100});
  const auto reading = [](int function, std::size_t count) {
    Bytes answer{1, static_cast<std::uint8_t>(function), static_cast<std::uint8_t>(2 * count)};
    for (std::size_t i = 0; i < count; ++i) {
      answer.push_back(static_cast<std::uint8_t>(i));
      answer.push_back(static_cast<std::uint8_t>(0xFF - i));
    }
    return answer;
  };
  const auto outcome = [](const Bytes& answer, auto&& act) {
    CannedModule module(answer);
    const std::string fault = module.fault(act);
    CHECK(module.asked().empty() == (fault != "none"));
    CHECK(module.link.exchanges() == (fault == "none" ? 1 : 0));
    return fault;
  };
  const std::string beyond = "TB-MODBUS-PROTOCOL";
  const auto first = [&](std::size_t count) { return std::span(words).first(count); };
  for (const int function : {3, 4}) {
    const auto read = [&](std::size_t count) {
      return outcome(reading(function, count), [&](ModbusLink& link) {
        function == 3 ? link.read_holding_registers(7, first(count)) : link.read_input_registers(7, first(count));
      });
    };
    CHECK(read(1) == "none");
    CHECK(read(125) == "none");
    CHECK(words[124] == (124U << 8U | (0xFFU - 124U)));
    CHECK(read(126) == beyond);
    CHECK(read(0) == beyond);
  }
  const auto write = [&](std::size_t count) {
    return outcome({1, 16, 0, 7, 0, static_cast<std::uint8_t>(count)},
                   [&](ModbusLink& link) { link.write_registers(7, first(count)); });
  };
  CHECK(write(1) == "none");
  CHECK(write(123) == "none");
  CHECK(write(124) == beyond);
  CHECK(write(0) == beyond);
  const auto both = [&](std::size_t written, std::size_t read) {
    std::vector<std::uint16_t> into(read);
    return outcome(reading(23, read),
                   [&](ModbusLink& link) { link.write_and_read_registers(7, first(written), 9, into); });
  };
  CHECK(both(1, 1) == "none");
  CHECK(both(121, 125) == "none");
  CHECK(both(122, 1) == beyond);
  CHECK(both(1, 126) == beyond);
  CHECK(both(0, 1) == beyond);
  CHECK(both(1, 0) == beyond);
  const auto bits = [&](int count) {
    Bytes answer{1, 2, static_cast<std::uint8_t>((count + 7) / 8)};
    answer.resize(3 + static_cast<std::size_t>(count + 7) / 8);
    return outcome(answer, [&](ModbusLink& link) { (void)link.read_discrete_inputs(7, count); });
  };
  CHECK(bits(1) == "none");
  CHECK(bits(2000) == "none");
  CHECK(bits(2001) == beyond);
  CHECK(bits(0) == beyond);
}

TEST_CASE("modbus frames: each damaged byte of an acknowledgement is a fault") {
  const struct {
    Bytes answer;
    std::function<void(ModbusLink&)> act;
  } cases[] = {{{1, 5, 1, 2, 0xFF, 0}, [](ModbusLink& link) { link.write_coil(0x0102, true); }},
               {{1, 6, 1, 2, 3, 4}, [](ModbusLink& link) { link.write_register(0x0102, 0x0304); }},
               {{1, 16, 1, 2, 0, 3}, [](ModbusLink& link) { link.write_registers(0x0102, kThree); }}};
  for (const auto& [answer, act] : cases) {
    for (std::size_t i = 0; i < answer.size(); ++i) {
      INFO("function " << int{answer[1]} << ", byte " << i);
      Bytes damaged = answer;
      damaged[i] = static_cast<std::uint8_t>(damaged[i] ^ 2U);
      CannedModule module(damaged);
      const std::string id = module.fault(act);
      if (i == 1) CHECK_THAT(id, Catch::StartsWith("TB-MODBUS-"));  // libmodbus expects another length
      if (i != 1) CHECK(id == "TB-MODBUS-PROTOCOL");
      CHECK(module.link.exchanges() == 1);
    }
  }
}

TEST_CASE("modbus frames: an answer with another function, unit, length or count is a protocol fault") {
  std::array<std::uint16_t, 2> two{};
  for (const Bytes& answer : {Bytes{1, 3, 4, 1, 2, 3, 4}, Bytes{2, 4, 4, 1, 2, 3, 4}, Bytes{1, 4, 2, 1, 2},
                              Bytes{1, 4, 6, 1, 2, 3, 4, 5, 6}}) {
    CannedModule module(answer);
    CHECK(module.fault([&](ModbusLink& link) { link.read_input_registers(1, two); }) == "TB-MODBUS-PROTOCOL");
  }
}

TEST_CASE("modbus frames: an exception states its number, and counts only for the function requested") {
  std::array<std::uint16_t, 1> one{};
  const auto read = [&](ModbusLink& link) { link.read_holding_registers(0x10, one); };
  for (const std::uint8_t code :
       {std::uint8_t{1}, std::uint8_t{2}, std::uint8_t{3}, std::uint8_t{4}, std::uint8_t{7}}) {
    CannedModule module({1, 0x83, code});
    for (int i = 0; i < 2; ++i) {
      check_fault([&] { read(module.link); }, "TB-MODBUS-EXCEPTION", "device", "exception " + std::to_string(code));
      // The connection is kept: the second request is the second of its transactions.
      CHECK(module.asked()[1] == i + 1);
    }
  }
  CannedModule other({1, 0x84, 2});
  CHECK(other.fault(read) == "TB-MODBUS-PROTOCOL");
}

TEST_CASE("modbus frames: each byte of transaction and protocol id is checked") {
  for (const std::size_t damaged : {0, 1, 2, 3}) {
    INFO("byte " << damaged);
    ScriptedServer server([&](int number, int socket, const Bytes& request) {
      Bytes reply = ScriptedServer::answer(request, {42});
      if (number == 0) reply[damaged] = static_cast<std::uint8_t>(reply[damaged] + 1);
      ScriptedServer::send(socket, reply);
    });
    ManualClock clock;
    ModbusLink link({"127.0.0.1", server.port(), 1, kPatient}, "device", clock);
    std::array<std::uint16_t, 1> one{};
    CHECK(fault_id_of([&] { link.read_input_registers(0, one); }) == "TB-MODBUS-PROTOCOL");
    link.read_input_registers(0, one);
    CHECK(one[0] == 42);
  }
}
