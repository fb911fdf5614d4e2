#include <fmt/format.h>
#include <toml++/toml.h>

#include <cmath>
#include <optional>

#include "sequences/toml/pressure_text.h"
#include "sequences/toml/strict_toml.h"
#include "sequences/toml/strict_toml_view.h"

namespace tactbench::sequences {

std::optional<double> TomlTable::View::number_of(const toml::node& node, const std::string& key) const {
  if (node.is_number()) return node.value<double>();
  const std::string name = node.is_string() ? node.value_or(std::string()) : std::string();
  if (!name.starts_with('$')) return key.ends_with("_psi") ? typed_pressure_psi(name) : std::nullopt;
  TomlDocument::Node& document = *owner;
  const auto found = document.parameters.find(name.substr(1));
  if (found == document.parameters.end()) {
    std::vector<std::string> known;
    for (const auto& [parameter, value] : document.parameters) known.push_back("$" + parameter);
    const std::string near = nearest_word(name, known);
    throw FileError("TB-FILE-KEY", fmt::format("there is no parameter '{}'", name.substr(1)), place(&node, key),
                    near.empty() ? fmt::format("declare it: [parameters.{}]", name.substr(1))
                                 : fmt::format("did you mean '{}'?", near));
  }
  document.parameters_used.insert(found->first);
  return found->second;
}

double TomlTable::number(const std::string& key) const {
  const toml::node* node = view_->find(key);
  if (node == nullptr) {
    throw FileError("TB-FILE-KEY", fmt::format("'{}' is missing", key), view_->place(nullptr, key),
                    fmt::format("add {} = <number>", key));
  }
  const std::optional<double> value = view_->number_of(*node, key);
  if (!value) {
    fail(key, fmt::format("'{}' must be a number, it is {}", key, kind_of(*node)),
         key.ends_with("_psi") ? "write the number alone, in psi, or a text with its unit: \"100 kPa\""
                               : "write the number alone; its unit is in the key");
  }
  if (!std::isfinite(*value)) fail(key, fmt::format("'{}' must be finite", key), "write a finite number");
  view_->note(node, key, fmt::format("{}", *value));
  return *value;
}

double TomlTable::number(const std::string& key, double fallback) const {
  if (has(key)) return number(key);
  view_->note(nullptr, key, fmt::format("{}", fallback));
  return fallback;
}

double TomlTable::number_in(const std::string& key, std::optional<double> fallback, double low, double high) const {
  const double value = fallback ? number(key, *fallback) : number(key);
  check_range(key, value, low, high);
  return value;
}

void TomlTable::check_range(const std::string& key, double value, double low, double high) const {
  if (value >= low && value <= high) return;
  fail(key, fmt::format("'{}' is {}, outside {:g} to {:g}", key, view_->as_typed(key, value), low, high),
       fmt::format("use {:g} to {:g}", low, high));
}

double TomlTable::zero_or_in(const std::string& key, std::optional<double> fallback, double low, double high) const {
  const double value = fallback ? number(key, *fallback) : number(key);
  if (value != 0.0 && (value < low || value > high)) {
    fail(key, fmt::format("'{}' is {}, neither 0 nor {:g} to {:g}", key, view_->as_typed(key, value), low, high),
         fmt::format("use 0 for none, or {:g} to {:g}", low, high));
  }
  return value;
}

long TomlTable::integer(const std::string& key, long low, long high) const {
  const double value = number(key);
  if (value != std::floor(value) || value < static_cast<double>(low) || value > static_cast<double>(high)) {
    fail(key, fmt::format("'{}' is {:g}, not a whole number from {} to {}", key, value, low, high),
         fmt::format("use a whole number from {} to {}", low, high));
  }
  return static_cast<long>(value);
}

long TomlTable::integer(const std::string& key, long fallback, long low, long high) const {
  if (has(key)) return integer(key, low, high);
  view_->note(nullptr, key, fmt::format("{}", fallback));
  return fallback;
}

std::vector<double> TomlTable::numbers(const std::string& key) const {
  const toml::node* node = view_->find(key);
  const toml::array* array = node == nullptr ? nullptr : node->as_array();
  if (array == nullptr) {
    fail(key, fmt::format("'{}' must be a list of numbers", key), fmt::format("write {} = [0, 60, 0]", key));
  }
  std::vector<double> values;
  for (const toml::node& element : *array) {
    const std::optional<double> value = view_->number_of(element, key);
    if (!value || !std::isfinite(*value)) {
      fail(key, fmt::format("element {} of '{}' is not a finite number", values.size() + 1, key), "use numbers only");
    }
    values.push_back(*value);
  }
  view_->note(node, key, fmt::format("[{}]", fmt::join(values, ", ")));
  return values;
}

std::pair<double, double> TomlTable::span(const std::string& key, std::pair<double, double> fallback) const {
  if (!has(key)) {
    view_->note(nullptr, key, fmt::format("[{}, {}]", fallback.first, fallback.second));
    return fallback;
  }
  const std::vector<double> values = numbers(key);
  if (values.size() != 2 || values[0] >= values[1]) {
    fail(key, fmt::format("'{}' must be [low, high] with low < high", key), fmt::format("write {} = [0, 10]", key));
  }
  return {values[0], values[1]};
}

std::vector<double> TomlTable::numbers_or_one(const std::string& key, double fallback) const {
  const toml::node* node = view_->find(key);
  if (node != nullptr && node->is_array()) {
    std::vector<double> values = numbers(key);
    if (values.empty()) fail(key, fmt::format("'{}' is an empty list", key), "write a number or several");
    return values;
  }
  return {number(key, fallback)};
}

std::vector<std::vector<double>> TomlTable::number_lists(const std::string& key, std::size_t size) const {
  const toml::node* node = view_->find(key);
  const toml::array* array = node == nullptr ? nullptr : node->as_array();
  std::vector<std::vector<double>> lists;
  for (std::size_t i = 0; array != nullptr && i < array->size(); ++i) {
    const toml::array* inner = array->get(i)->as_array();
    std::vector<double> values;
    for (std::size_t j = 0; inner != nullptr && j < inner->size(); ++j) {
      const std::optional<double> value = view_->number_of(*inner->get(j), key);
      if (value && std::isfinite(*value)) values.push_back(*value);
    }
    if (inner == nullptr || inner->size() != size || values.size() != size) {
      fail(key, fmt::format("element {} of '{}' is not a list of {} numbers", i + 1, key, size),
           "write lists in a list");
    }
    lists.push_back(std::move(values));
  }
  if (lists.empty()) {
    fail(key, fmt::format("'{}' must be a list of lists of {} numbers", key, size), "write lists in a list");
  }
  view_->note(node, key, fmt::format("{} lists of {}", lists.size(), size));
  return lists;
}

}  // namespace tactbench::sequences
