// The card of the substitute NI-DAQmx library, new for each test; checks at the end that no task is left and nothing
// was misused.
#pragma once

#include <algorithm>
#include <catch2/catch.hpp>
#include <string>

#include "tests/devices/test_chamber.h"
#include "tests/support/fake_nidaqmx/fake_nidaqmx.h"

namespace tactbench::devices {

struct DaqmxCard {
  DaqmxCard() = default;
  ~DaqmxCard() {
    CHECK(card.tasks == 0);
    CHECK(card.misuse.empty());
  }
  DaqmxCard(const DaqmxCard&) = delete;
  DaqmxCard& operator=(const DaqmxCard&) = delete;
  [[nodiscard]] int called(const std::string& function) const {
    return static_cast<int>(std::count(card.calls.begin(), card.calls.end(), function));
  }
  // After so many calls of this function all later ones fail.
  void fail(const std::string& function, int code, int calls = 0) const {
    card.fail_function = function;
    card.fail_code = code;
    card.fail_call = calls + called(function);
  }
  tests::FakeDaqmx& card = tests::fake_daqmx() = tests::FakeDaqmx{};
  ManualClock clock;
};

}  // namespace tactbench::devices
