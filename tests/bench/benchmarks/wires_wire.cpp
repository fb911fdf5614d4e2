// `tactbench benchmark wires`: which wires it takes, in which order, and each against the echo on loopback.
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "bench/benchmarks/figure.h"
#include "bench/benchmarks/wires.h"
#include "tests/bench/benchmarks/counted_time.h"

using namespace tactbench::bench;

TEST_CASE("benchmark wires: microseconds of each wire and its ratio to an echo on loopback") {
  const std::vector<Figure> figures = benchmark_wires(4);
  const std::vector<std::string> wires{"modbus_tcp_read",
                                       "modbus_tcp_command_and_readback",
                                       "hid_reports_scan_256_taxels",
                                       "zaber_pty_question",
                                       "net_ft_1_record",
                                       "net_ft_50_records",
                                       "frame_source_scan_256_taxels",
                                       "modbus_rtu_read_with_frame_gap"};
  REQUIRE(figures.size() == 2 + 2 * wires.size());
  CHECK((figures.front().name == "floor_tcp_echo" && figures.front().unit == "us"));
  const double floor = figures.front().value;
  CHECK(floor > 0.1);
  for (std::size_t i = 0; i < wires.size(); ++i) {
    INFO(wires[i]);
    const Figure &own = figures[1 + 2 * i], &ratio = figures[2 + 2 * i];
    CHECK((own.name == wires[i] && own.unit == "us"));
    CHECK((ratio.name == wires[i] + "_vs_floor" && ratio.unit == "x"));
    CHECK(own.value > 1.0);
    CHECK(own.value < 20e6);
    CHECK(ratio.value == own.value / floor);
  }
  // At 115 200 baud the pause between two frames alone is 1.75 ms.
  CHECK(figures[15].value > 1750.0);
  CHECK((figures.back().name == "serial_hang_up_to_fault" && figures.back().unit == "us"));
  CHECK(figures.back().value > 0.0);
  CHECK(figures.back().value < 20e6);
}

TEST_CASE("benchmark wires: medians of the exchanges asked for, of a fifth of them and one more, and of 21 hang-ups") {
  const std::ptrdiff_t descriptors = tactbench::tests::descriptors_left_open();
  const std::vector<Figure> figures = [] {
    const tactbench::tests::CountedTime time;
    return benchmark_wires(11);
  }();
  CHECK(tactbench::tests::descriptors_left_open() == descriptors);
  tactbench::tests::ActsInOrder act;
  const double floor = 1e6 * act.median_of(11);
  REQUIRE(figures.size() == 18);
  CHECK(figures[0].value == Approx(floor).epsilon(1e-9));
  const std::vector<int> exchanges{11, 11, 11, 11, 11, 3, 11, 3};
  for (std::size_t i = 0; i < exchanges.size(); ++i) {
    INFO(figures[1 + 2 * i].name);
    const double median = 1e6 * act.median_of(exchanges[i]);
    CHECK(figures[1 + 2 * i].value == Approx(median).epsilon(1e-9));
    CHECK(figures[2 + 2 * i].value == Approx(median / floor).epsilon(1e-9));
  }
  CHECK(figures[17].value == Approx(1e6 * act.median_of(21)).epsilon(1e-9));
}
