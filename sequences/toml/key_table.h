// Tables that declare the keys of TOML files. Each row describes a key: name, type, unit, range, default, meaning, and
// the variable that receives its value. read_keys() reads a table of the file by these rows; add_facts() gives the same
// rows as text, for the reference of keys and the comments in the files that `tactbench init` writes. The default is
// the value of the variable at the time when the row is made.
#pragma once

#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <type_traits>
#include <vector>

#include "sequences/toml/strict_toml.h"

namespace tactbench::sequences {

// Unit of a number in the file: the variable is set to number * times / per.
struct Unit {
  const char* name;  // "1": a pure number or a count
  double times = 1.0, per = 1.0;
};
inline constexpr Unit kOne{"1"}, kMilliseconds{"ms", 1.0, 1000.0}, kPercent{"%", 1.0, 100.0};

struct Range {  // both ends allowed
  double low = -std::numeric_limits<double>::infinity(), high = std::numeric_limits<double>::infinity();
  bool or_zero = false;  // 0 is allowed, too
};

struct KeyFacts {
  std::string key;   // dotted; [] for each element of a list of tables, NAME for a name that the file chooses
  std::string type;  // "number", "whole number", "text", "one of", ...
  std::string unit = "-";
  std::string range;     // "0 to 1", or the choices of "one of"; empty: any
  std::string standard;  // the default as TOML, or "required"; empty: no default
  std::string meaning;
};

struct Key {
  enum class Presence { kDefault, kRequired, kOptional };
  KeyFacts facts;
  // Reads the key into its variable; `required`: the variable's value is not used as a default.
  std::function<void(const TomlTable& table, bool required)> read;
  Presence presence = Presence::kDefault;
};
using KeyTable = std::vector<Key>;

// Row by row; throws FileError as TomlTable does.
void read_keys(const TomlTable& table, const KeyTable& keys);
// For the last rows of a table: also refuses keys that were not read.
void read_whole(const TomlTable& table, const KeyTable& keys);

// Appends the rows of the file's table `path` ("" at the top, "sensor[]", "press.grid"). If the key exists already,
// from another variant of the same table, the differences are added to it.
void add_facts(std::vector<KeyFacts>& all, const std::string& path, const KeyTable& keys);

// Functions that make rows: key::number("dwell_s", recipe.dwell_s, {"s"}, {0.0, 86400.0}, "Time from ...").
namespace key {

namespace detail {
template <typename Variable>
constexpr bool is_time = std::is_same_v<Variable, std::chrono::nanoseconds>;

// The variable's value in the file's unit.
template <typename Variable>
double in_file(const Variable& variable, const Unit& unit) {
  double value = 0.0;
  if constexpr (is_time<Variable>)
    value = std::chrono::duration<double>(variable).count();
  else if constexpr (std::is_arithmetic_v<Variable>)
    value = static_cast<double>(variable);
  else
    value = variable.value();  // of devices/units.h
  return value * unit.per / unit.times;
}

template <typename Variable>
void assign(Variable& variable, double in_file, const Unit& unit) {
  const double value = in_file * unit.times / unit.per;
  if constexpr (is_time<Variable>)
    variable = std::chrono::nanoseconds(static_cast<std::int64_t>(std::llround(value * 1e9)));
  else if constexpr (std::is_arithmetic_v<Variable>)
    variable = static_cast<Variable>(value);
  else
    variable = Variable(value);
}

Key number(const char* name, double standard, const Unit& unit, const Range& range, const char* meaning,
           std::function<void(double)> take);
Key whole(const char* name, long standard, const Unit& unit, const Range& range, const char* meaning,
          std::function<void(long)> take);
Key span(const char* name, std::pair<double, double> standard, const Unit& unit, const char* meaning,
         std::function<void(double, double)> take);
Key word(const char* name, std::size_t standard, const std::vector<std::string>& words, const char* meaning,
         std::function<void(std::size_t)> take);
}  // namespace detail

// A whole number if the variable is an integer.
template <typename Variable>
Key number(const char* name, Variable& variable, const Unit& unit, const Range& range, const char* meaning) {
  if constexpr (std::is_integral_v<Variable>)
    return detail::whole(name, static_cast<long>(variable), unit, range, meaning,
                         [&variable](long value) { variable = static_cast<Variable>(value); });
  else
    return detail::number(name, detail::in_file(variable, unit), unit, range, meaning,
                          [&variable, unit](double value) { detail::assign(variable, value, unit); });
}

// [low, high] with low < high.
template <typename Variable>
Key span(const char* name, Variable& low, Variable& high, const Unit& unit, const char* meaning) {
  return detail::span(name, {detail::in_file(low, unit), detail::in_file(high, unit)}, unit, meaning,
                      [&low, &high, unit](double from, double to) {
                        detail::assign(low, from, unit);
                        detail::assign(high, to, unit);
                      });
}

// One of `words`. An enumeration gets the value at the word's index, a char gets the word's letter.
template <typename Variable>
Key word(const char* name, Variable& variable, const std::vector<std::string>& words, const char* meaning) {
  std::size_t standard = 0;
  if constexpr (std::is_enum_v<Variable>)
    standard = static_cast<std::size_t>(variable);
  else
    while (standard + 1 < words.size() && words[standard] != std::string(1, variable)) ++standard;
  return detail::word(name, standard, words, meaning, [&variable, words](std::size_t place) {
    if constexpr (std::is_enum_v<Variable>)
      variable = static_cast<Variable>(place);
    else
      variable = words[place].front();
  });
}
// True for the word `yes`, false for the others.
Key word(const char* name, bool& variable, const std::vector<std::string>& words, const char* yes, const char* meaning);
// The word itself; if the key has a default, the variable's value must be one of the words.
Key word(const char* name, std::string& variable, const std::vector<std::string>& words, const char* meaning);

Key flag(const char* name, bool& variable, const char* meaning);
Key text(const char* name, std::string& variable, const char* meaning);
Key name(const char* name, std::string& variable, const char* meaning);  // required, neither empty nor blank
Key texts(const char* name, std::vector<std::string>& variable, const char* meaning);
Key numbers(const char* name, std::vector<double>& variable, const Unit& unit, const char* meaning);  // required
// A number, or a list of numbers; the default is the variable's first number.
Key numbers_or_one(const char* name, std::vector<double>& variable, const Unit& unit, const char* meaning);
Key schema();  // version 1 of a file's format; required

// A key that no function above reads.
Key made(KeyFacts facts, std::function<void(const TomlTable&)> read);

Key required(Key key);
Key optional(Key key);                                // if absent, the variable keeps its value
Key described(Key key, const std::string& standard);  // a default that depends on other keys, in words

}  // namespace key

}  // namespace tactbench::sequences
