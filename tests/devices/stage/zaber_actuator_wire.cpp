// The Zaber stage joins the table of actuator laws, on a pseudo-terminal and over TCP.
#include <atomic>
#include <cmath>

#include "tests/devices/actuator_contract.h"
#include "tests/devices/stage/zaber_rig.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;

namespace {

class ZaberBed final : public ActuatorBed {
 public:
  ZaberBed(const BedOptions& options, const std::string& listen)
      : rig_(chain_options(listen), faults(), stage_options(options)) {}

  ZaberStage& actuator() override { return rig_.stage; }
  ManualClock& clock() override { return rig_.clock; }
  [[nodiscard]] std::string faults_begin_with() const override { return "TB-STAGE"; }
  void make_ready() override { rig_.arm_and_home(); }
  std::vector<Act> commands() override {
    Stage& stage = rig_.stage;
    return {[&] { stage.home(Axis::kX); },
            [&] { stage.start_move_to(Axis::kX, Millimetres(1.0), std::nullopt); },
            [&] { stage.start_move_by(Axis::kX, Millimetres(1.0), std::nullopt); },
            [&] { stage.start_speed(Axis::kX, MillimetresPerSecond(1.0)); },
            [&] { (void)stage.wait(Axis::kX); },
            [&] { (void)stage.stop(Axis::kX); },
            [&] { (void)stage.state(Axis::kX); }};
  }
  // z goes from 0 to 50 mm at 8 mm/s at most.
  std::vector<Act> forbidden() override {
    std::vector<Act> all;
    for (const double target : {-0.001, 50.001, 1e9, std::nan(""), HUGE_VAL, -HUGE_VAL}) {
      all.emplace_back([this, target] { rig_.stage.start_move_to(Axis::kZ, Millimetres(target), {}); });
      all.emplace_back([this, target] { rig_.stage.start_move_by(Axis::kZ, Millimetres(target), {}); });
    }
    for (const double speed : {0.0, -1.0, 8.001, 1e-9, std::nan(""), HUGE_VAL})
      all.emplace_back(
          [this, speed] { rig_.stage.start_move_to(Axis::kZ, Millimetres(1.0), MillimetresPerSecond(speed)); });
    for (const double speed : {0.0, 8.001, -8.001, std::nan(""), -HUGE_VAL})
      all.emplace_back([this, speed] { rig_.stage.start_speed(Axis::kZ, MillimetresPerSecond(speed)); });
    return all;
  }
  // To the end of z that is further away.
  void load() override {
    const bool near = rig_.chain.position(Axis::kZ) < Millimetres(25.0);
    rig_.stage.start_move_to(Axis::kZ, Millimetres(near ? 50.0 : 0.0), MillimetresPerSecond(1.0));
  }
  [[nodiscard]] bool make_safe() noexcept override { return rig_.stage.halt(); }
  bool is_in_safe_state() override {
    const auto places = [&] { return rig_.chain.places(rig_.clock.now()); };
    const auto before = places();
    rig_.clock.wait_until(rig_.clock.now() + 100ms);
    return places() == before;
  }
  [[nodiscard]] std::uint64_t received() const override { return rig_.chain.bytes_received(); }
  [[nodiscard]] std::uint64_t driven() const override { return rig_.count(kMoving); }
  void fall_silent() override { silent_ = true; }
  void break_wire() override { rig_.chain.unplug(); }
  void mend_wire() override { rig_.chain.plug_in(); }
  [[nodiscard]] int questions() const override { return 2; }
  [[nodiscard]] int questions_to_make_safe() const override { return 2 * kAxes; }

 private:
  static SimulatedChainOptions chain_options(const std::string& listen) {
    SimulatedChainOptions options;
    options.listen = listen;
    return options;
  }
  SimulatedChainFaults faults() {
    SimulatedChainFaults faults;
    faults.inject = [this] { return silent_ ? InjectedFault::kSilent : InjectedFault::kNone; };
    return faults;
  }
  static ZaberStageOptions stage_options(const BedOptions& bed) {
    ZaberStageOptions options = paper_stage();
    options.reply_timeout = bed.reply_timeout;
    options.halt_timeout = bed.safe_timeout;
    return options;
  }

  std::atomic<bool> silent_{false};
  ZaberRig<> rig_;
};

const JoinsActuatorLaws<ZaberStage, ZaberBed> kTerminal("Zaber stage on a pseudo-terminal", std::string()),
    kTcp("Zaber stage over TCP", std::string("tcp:0"));

}  // namespace
