// Codec of the serial pressure controller.
#include "devices/pressure/controller_lines.h"

#include <catch2/catch.hpp>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

using namespace tactbench::devices;

TEST_CASE("controller lines: each request as bytes, and back") {
  const std::vector<std::tuple<char, ControllerRequest, int, std::string>> rows = {
      {'A', {}, 2, "A\r"},
      {'A', {ControllerAct::kSetpoint, 12.34}, 2, "AS12.34\r"},
      {'C', {ControllerAct::kSetpoint, 0.0}, 2, "CS0.00\r"},
      {'A', {ControllerAct::kSetpoint, 60.0}, 0, "AS60\r"},
      {'A', {ControllerAct::kExhaust}, 2, "AE\r"},
      {'Z', {ControllerAct::kCancel}, 2, "ZC\r"}};
  for (const auto& [unit, request, decimals, bytes] : rows) {
    INFO(bytes);
    CHECK(encode_request(unit, request, decimals) == bytes);
    const auto back = decode_request(std::string_view(bytes).substr(0, bytes.size() - 1), unit);
    REQUIRE(back);
    CHECK(back->act == request.act);
    CHECK(back->setpoint == request.setpoint);
    CHECK_FALSE(decode_request(std::string_view(bytes).substr(0, bytes.size() - 1), unit == 'B' ? 'D' : 'B'));
  }
  CHECK(decode_request("AS 5.5", 'A')->setpoint == 5.5);
  for (const char* line : {"", "AS", "AS ", "ASx", "AS1.2.3", "AX", "AEE", "ASnan", "ASinf"}) {
    INFO(line);
    CHECK_FALSE(decode_request(line, 'A'));
  }
}

TEST_CASE("controller lines: an answer has pressure, set-point and status, other text is not an answer") {
  struct Row {
    const char* line;
    ControllerFields fields;
    std::optional<std::tuple<double, double, std::vector<std::string>>> frame;
    bool refused = false;
  };
  using Words = std::vector<std::string>;
  const std::vector<Row> rows = {
      {"A +012.34 +012.30", {}, {{12.34, 12.30, Words{}}}},
      {"A -000.05 +000.00 EXH", {}, {{-0.05, 0.0, Words{"EXH"}}}},
      {"A   012.34  0.00  HLD POV", {}, {{12.34, 0.0, Words{"HLD", "POV"}}}},
      {"A +012.34 +023.4 +000.1 +000.2 12.34 Air OVR", {1, 5}, {{12.34, 12.34, Words{"Air", "OVR"}}}},
      {"A +1 +2 +3", {3, 1}, {{3.0, 1.0, Words{}}}},
      {"?", {}, std::nullopt, true},
      {"A ?", {}, std::nullopt, true},
      {"B +012.34 +012.30", {}, std::nullopt},
      {"A +012.34", {}, std::nullopt},
      {"A +012.34 +01", {2, 3}, std::nullopt},
      {"A +01#.34 +012.30", {}, std::nullopt},
      {"A +012.34 ----", {}, std::nullopt},
      {"A nan +012.30", {}, std::nullopt},
      {"AB +012.34 +012.30", {}, std::nullopt},
      {"", {}, std::nullopt}};
  for (const Row& row : rows) {
    INFO(row.line);
    const ControllerAnswer answer = decode_answer(row.line, 'A', row.fields);
    CHECK(answer.refused == row.refused);
    REQUIRE(answer.frame.has_value() == row.frame.has_value());
    if (!row.frame) continue;
    CHECK(answer.frame->pressure == std::get<0>(*row.frame));
    CHECK(answer.frame->setpoint == std::get<1>(*row.frame));
    CHECK(answer.frame->status == std::get<2>(*row.frame));
  }
}

TEST_CASE("controller lines: an answer of the simulated controller is read back to the last decimal") {
  for (const int decimals : {0, 1, 2}) {
    const std::string line = encode_answer('K', {-3.0, 60.0, {"EXH"}}, decimals);
    REQUIRE(line.back() == '\r');
    const auto frame = decode_answer(std::string_view(line).substr(0, line.size() - 1), 'K', {}).frame;
    REQUIRE(frame);
    CHECK(frame->pressure == -3.0);
    CHECK(frame->setpoint == 60.0);
    CHECK(frame->has("EXH"));
    CHECK_FALSE(frame->has("HLD"));
  }
  CHECK(encode_answer('A', {12.344, 0.5, {}}, 2) == "A +012.34 +000.50\r");
}
