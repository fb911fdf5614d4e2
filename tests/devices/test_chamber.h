// Physics for the device tests' simulated ends: a chamber that follows its voltage at once, an array that counts its
// scans; a fault's parts, a folder for sockets.
#pragma once

#include <catch2/catch.hpp>

#include <atomic>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <string>

#include "bench/config/config_profile.h"
#include "devices/clock.h"
#include "devices/force/force_sensor.h"
#include "devices/pressure/chamber_port.h"
#include "devices/tactile/simulated_scanner.h"
#include "devices/tactile/tactile_array.h"
#include "tests/devices/fault_of.h"
#include "tests/support/process.h"

namespace tactbench::devices {

class TestChamber final : public ChamberPort {
 public:
  explicit TestChamber(const Clock& clock) : clock_(clock) {}
  void drive(Volts command, Nanoseconds hold_until, Volts fallback) override {
    ++drives;
    command_ = command;
    hold_until_ = hold_until;
    fallback_ = fallback;
  }
  void dump(bool open) override { dumping = open; }
  Volts feedback() override { return output(); }
  Volts reference() override { return reference_volts; }
  [[nodiscard]] Volts output() const { return clock_.now() < hold_until_.load() ? command_ : fallback_; }
  std::atomic<Volts> reference_volts{Volts(0.0)};
  std::atomic<int> drives{0};  // orders given to the output terminal
  std::atomic<bool> dumping{false};

 private:
  const Clock& clock_;
  std::atomic<Volts> command_{Volts(0.0)};
  std::atomic<Nanoseconds> hold_until_{Nanoseconds(0)};
  std::atomic<Volts> fallback_{Volts(0.0)};
};

// Sample of taxel i in scan n (from 0): 256 n + i, modulo 2^16.
class TestArray final : public TactilePort {
 public:
  void scan(std::span<std::uint16_t> counts, std::span<std::uint8_t> status) override {
    for (std::size_t i = 0; i < counts.size(); ++i) counts[i] = sample(scans, i);
    for (std::size_t row = 0; row < status.size(); ++row) status[row] = row == 3 ? kStatusNotSettled : 0;
    ++scans;
    scans.notify_all();
  }
  static std::uint16_t sample(int scan, std::size_t taxel) {
    return static_cast<std::uint16_t>((256U * static_cast<unsigned>(scan) + taxel) & 0xFFFFU);
  }
  std::atomic<int> scans{0};
};

// Gives what `load` says at the n-th request (from 0).
class NumberedLoad final : public ForcePort {
 public:
  explicit NumberedLoad(std::function<Wrench(int)> load) : load_(std::move(load)) {}
  Wrench wrench() override { return load_(asked++); }
  std::atomic<int> asked{0};

 private:
  std::function<Wrench(int)> load_;
};

// The scan of that number is whole, at `index` of what was read.
inline void check_scan(const ScanSet& set, int index, int scan) {
  const std::size_t taxels = static_cast<std::size_t>(set.rows) * static_cast<std::size_t>(set.columns);
  for (std::size_t i = 0; i < taxels; ++i) {
    const auto got = set.counts[static_cast<std::size_t>(index) * taxels + i];
    if (got != TestArray::sample(scan, i)) FAIL("scan " << index << " taxel " << i << ": " << got);
  }
}

inline ModuleProfile module_profile(const std::string& name) { return bench::read_module_profile(name); }

using tests::TemporaryFolder;

}  // namespace tactbench::devices
