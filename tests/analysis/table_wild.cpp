// Samples that no sensor can have between its neighbours, and good data that look like them.
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <utility>

#include "analysis/table.h"

using namespace tactbench::analysis;

namespace {

constexpr std::size_t kSamples = 200;

// Two sweeps of 0 to 40 and back, outputs of 0 to 2.
TableSeries sweeps() {
  TableSeries series;
  for (std::size_t i = 0; i < kSamples; ++i) {
    const double share = std::abs(std::fmod(static_cast<double>(i) / 50.0, 2.0) - 1.0);
    series.input.push_back(40.0 * share);
    series.output.push_back(2.0 * share);
  }
  return series;
}

// Rests at 0 but for presses of `length` samples from 100 on.
TableSeries presses(std::size_t length, double input, double output) {
  TableSeries series;
  for (std::size_t i = 0; i < kSamples; ++i) {
    const bool pressed = i >= 100 && i < 100 + length;
    series.input.push_back((pressed ? input : 0.0) + 0.01 * static_cast<double>(i % 3));
    series.output.push_back((pressed ? output : 0.0) + 0.001 * static_cast<double>(i % 5));
  }
  return series;
}

std::vector<std::size_t> places(const TableSeries& series) {
  std::vector<std::size_t> found;
  for (const WildSample& wild : wild_samples(series)) found.push_back(wild.place);
  return found;
}

}  // namespace

TEST_CASE("wild samples: up to three in a row beyond three spans, of outputs or of inputs, wherever they stand") {
  using Values = std::vector<double> TableSeries::*;
  for (const Values values : {&TableSeries::output, &TableSeries::input}) {
    for (const double value : {83886.07, -83886.07, 1e308, 300.0, -250.0})
      for (const std::size_t first : {std::size_t{0}, std::size_t{77}, kSamples - 3})
        for (std::size_t length = 1; length <= 3; ++length) {
          TableSeries series = sweeps();
          std::vector<std::size_t> put;
          for (std::size_t i = first; i < first + length; ++i) {
            (series.*values)[i] = value;
            put.push_back(i);
          }
          INFO(value << " at " << first << ", " << length);
          if (first == kSamples - 3 && length < 3) continue;
          CHECK(places(series) == put);
        }
  }
  TableSeries seldom = sweeps();  // one row in twenty-five
  for (std::size_t i = 10; i < kSamples; i += 25) seldom.output[i] = 65535.0;
  CHECK(places(seldom).size() == 8);
}

TEST_CASE("wild samples: steps, short presses, jumps of the zero, noise and converters' limits are none") {
  using Change = std::function<void(TableSeries&)>;
  const std::vector<std::pair<const char*, Change>> good = {
      {"as it is", [](TableSeries&) {}},
      {"the output's zero jumps and stays",
       [](TableSeries& s) {
         for (std::size_t i = 120; i < kSamples; ++i) s.output[i] += 20.0;
       }},
      {"one output at the end of the converter, 2.5 times the span", [](TableSeries& s) { s.output[60] = 5.0; }},
      {"a square wave",
       [](TableSeries& s) {
         for (std::size_t i = 0; i < kSamples; ++i) s.output[i] = 0.05 * (s.input[i] = i / 20 % 2 == 0 ? 0.0 : 40.0);
       }},
      {"constant", [](TableSeries& s) { std::ranges::fill(s.output, 1.0); }},
      {"a short recording, which tells no span", [](TableSeries& s) {
         s.input.resize(19);
         s.output.resize(19);
         s.output[9] = 1e6;
       }}};
  for (const auto& [what, change] : good) {
    TableSeries series = sweeps();
    change(series);
    INFO(what);
    CHECK(places(series).empty());
  }
  for (const std::size_t length : {1U, 2U, 3U, 10U}) CHECK(places(presses(length, 40.0, 2.0)).empty());
  CHECK(places(presses(2, 0.0, 2.0)).size() == 2);  // the input rests
  CHECK(places(presses(10, 0.0, 2.0)).empty());     // goes on for longer than a fault of one row
}
