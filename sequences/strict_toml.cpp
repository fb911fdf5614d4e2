#include "sequences/strict_toml.h"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <fstream>
#include <iterator>
#include <numeric>
#include <set>

namespace tactbench::sequences {

struct TomlDocument::Node {
  toml::table table;
};

struct TomlTable::View {
  std::shared_ptr<TomlDocument::Node> owner;
  const toml::table* table = nullptr;  // null: the table is absent
  std::string file, path;
  std::set<std::string> asked;

  const toml::node* find(const std::string& key) {
    asked.insert(key);
    return table == nullptr ? nullptr : table->get(key);
  }
  [[nodiscard]] std::string place(const toml::node* node, const std::string& key) const {
    const std::string dotted = path.empty() ? key : path + "." + key;
    if (node != nullptr && node->source().begin.line == 0) return fmt::format("--set {} (over {})", dotted, file);
    const toml::node* shown = node != nullptr ? node : table;
    if (shown == nullptr || shown->source().begin.line == 0) return file + ", " + dotted;
    return fmt::format("{}:{}:{}, {}", file, shown->source().begin.line, shown->source().begin.column, dotted);
  }
};

namespace {
char lower(char c) { return static_cast<char>(std::tolower(static_cast<unsigned char>(c))); }
}  // namespace

std::string nearest_word(const std::string& word, const std::vector<std::string>& known) {
  std::string best;
  std::size_t best_distance = std::max<std::size_t>(2, word.size() / 3) + 1;
  for (const std::string& candidate : known) {
    std::vector<std::size_t> row(candidate.size() + 1);
    std::iota(row.begin(), row.end(), 0U);
    for (std::size_t i = 1; i <= word.size(); ++i) {
      std::size_t diagonal = row[0];
      row[0] = i;
      for (std::size_t j = 1; j <= candidate.size(); ++j) {
        const std::size_t changed = diagonal + (lower(word[i - 1]) == lower(candidate[j - 1]) ? 0 : 1);
        diagonal = row[j];
        row[j] = std::min({row[j] + 1, row[j - 1] + 1, changed});
      }
    }
    if (row.back() < best_distance) {
      best_distance = row.back();
      best = candidate;
    }
  }
  return best;
}

namespace {

toml::table parse(const std::string& text, const std::string& name) {
  try {
    return toml::parse(text, name);
  } catch (const toml::parse_error& error) {
    const auto& at = error.source().begin;
    throw FileError("TB-FILE-SYNTAX", fmt::format("not valid TOML: {}", error.description()),
                    fmt::format("{}:{}:{}", name, at.line, at.column),
                    "a quantity is a plain number with its unit in the key (dwell_s = 2.0); text needs quotes");
  }
}

const char* kind_of(const toml::node& node) {
  switch (node.type()) {
    case toml::node_type::table:
      return "a table";
    case toml::node_type::array:
      return "a list";
    case toml::node_type::string:
      return "text";
    case toml::node_type::integer:
      return "a whole number";
    case toml::node_type::floating_point:
      return "a number";
    case toml::node_type::boolean:
      return "true or false";
    default:
      return "a date or time";
  }
}

}  // namespace

TomlDocument TomlDocument::from_file(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  if (!stream) {
    throw FileError("TB-FILE-MISSING", fmt::format("cannot read the file '{}'", path), path,
                    "check the name; 'tactbench init' writes files to start from");
  }
  return from_text(std::string(std::istreambuf_iterator<char>(stream), {}), path);
}

TomlDocument TomlDocument::from_text(const std::string& text, const std::string& name) {
  TomlDocument document;
  document.text_ = text;
  document.name_ = name;
  document.node_ = std::make_shared<Node>(Node{parse(text, name)});
  return document;
}

void TomlDocument::set(const Override& override_value) {
  const std::string where = "--set " + override_value.key + "=" + override_value.value;
  toml::table holder;
  try {
    holder = toml::parse("v = " + override_value.value, where);
  } catch (const toml::parse_error&) {
    holder.insert_or_assign("v", override_value.value);
  }
  toml::table* table = &node_->table;
  std::string rest = override_value.key;
  for (std::size_t dot = rest.find('.'); dot != std::string::npos; dot = rest.find('.')) {
    const std::string head = rest.substr(0, dot);
    rest.erase(0, dot + 1);
    if (!table->contains(head)) table->insert_or_assign(head, toml::table{});
    table = table->get(head)->as_table();
    if (table == nullptr) {
      throw FileError("TB-FILE-VALUE", fmt::format("'{}' is not a table", head), where,
                      "write the key as it stands in the file, table.key");
    }
  }
  if (rest.empty()) throw FileError("TB-FILE-VALUE", "an empty key", where, "write --set table.key=value");
  table->insert_or_assign(rest, *holder.get("v"));
}

TomlTable TomlDocument::root() const {
  auto view = std::make_shared<TomlTable::View>();
  view->owner = node_;
  view->table = &node_->table;
  view->file = name_;
  return TomlTable(std::move(view));
}

bool TomlTable::has(const std::string& key) const { return view_->find(key) != nullptr; }

void TomlTable::fail(const std::string& key, const std::string& message, const std::string& remedy) const {
  throw FileError("TB-FILE-VALUE", message, view_->place(view_->find(key), key), remedy);
}

double TomlTable::number(const std::string& key) const {
  const toml::node* node = view_->find(key);
  if (node == nullptr) {
    throw FileError("TB-FILE-KEY", fmt::format("'{}' is missing", key), view_->place(nullptr, key),
                    fmt::format("add {} = <number>", key));
  }
  const auto value = node->value<double>();
  if (!node->is_number() || !value) {
    fail(key, fmt::format("'{}' must be a number, it is {}", key, kind_of(*node)),
         "write the number alone; its unit is in the key");
  }
  if (!std::isfinite(*value)) fail(key, fmt::format("'{}' must be finite", key), "write a finite number");
  return *value;
}

double TomlTable::number(const std::string& key, double fallback) const { return has(key) ? number(key) : fallback; }

double TomlTable::number_in(const std::string& key, double fallback, double low, double high) const {
  const double value = number(key, fallback);
  if (value < low || value > high) {
    fail(key, fmt::format("'{}' is {:g}, outside {:g} to {:g}", key, value, low, high),
         fmt::format("use {:g} to {:g}", low, high));
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
  return has(key) ? integer(key, low, high) : fallback;
}

bool TomlTable::boolean(const std::string& key, bool fallback) const {
  const toml::node* node = view_->find(key);
  if (node == nullptr) return fallback;
  if (!node->is_boolean()) fail(key, fmt::format("'{}' must be true or false", key), "write true or false");
  return node->value_or(fallback);
}

std::string TomlTable::text(const std::string& key) const {
  const toml::node* node = view_->find(key);
  if (node == nullptr) {
    throw FileError("TB-FILE-KEY", fmt::format("'{}' is missing", key), view_->place(nullptr, key),
                    fmt::format("add {} = \"...\"", key));
  }
  if (!node->is_string()) {
    fail(key, fmt::format("'{}' must be text, it is {}", key, kind_of(*node)), "put it in double quotes");
  }
  return node->value_or(std::string());
}

std::string TomlTable::text(const std::string& key, const std::string& fallback) const {
  return has(key) ? text(key) : fallback;
}

std::string TomlTable::word(const std::string& key, const std::vector<std::string>& words) const {
  std::string value = text(key);
  if (std::find(words.begin(), words.end(), value) != words.end()) return value;
  const std::string near = nearest_word(value, words);
  fail(key, fmt::format("'{}' is \"{}\", which is not one of {}", key, value, fmt::join(words, ", ")),
       near.empty() ? "use one of the words" : fmt::format("did you mean \"{}\"?", near));
}

std::vector<double> TomlTable::numbers(const std::string& key) const {
  const toml::node* node = view_->find(key);
  const toml::array* array = node == nullptr ? nullptr : node->as_array();
  if (array == nullptr) {
    fail(key, fmt::format("'{}' must be a list of numbers", key), fmt::format("write {} = [0, 60, 0]", key));
  }
  std::vector<double> values;
  for (const toml::node& element : *array) {
    const auto value = element.value<double>();
    if (!element.is_number() || !value || !std::isfinite(*value)) {
      fail(key, fmt::format("element {} of '{}' is not a finite number", values.size() + 1, key), "use numbers only");
    }
    values.push_back(*value);
  }
  return values;
}

std::pair<double, double> TomlTable::span(const std::string& key, std::pair<double, double> fallback) const {
  if (!has(key)) return fallback;
  const std::vector<double> values = numbers(key);
  if (values.size() != 2 || values[0] >= values[1]) {
    fail(key, fmt::format("'{}' must be [low, high] with low < high", key), fmt::format("write {} = [0, 10]", key));
  }
  return {values[0], values[1]};
}

TomlTable TomlTable::table(const std::string& key) const {
  const toml::node* node = view_->find(key);
  if (node != nullptr && !node->is_table()) {
    fail(key, fmt::format("'{}' must be a table", key), fmt::format("write [{}] on a line of its own", key));
  }
  auto view = std::make_shared<View>();
  view->owner = view_->owner;
  view->table = node == nullptr ? nullptr : node->as_table();
  view->file = view_->file;
  view->path = view_->path.empty() ? key : view_->path + "." + key;
  return TomlTable(std::move(view));
}

std::vector<TomlTable> TomlTable::tables(const std::string& key) const {
  std::vector<TomlTable> result;
  const toml::node* node = view_->find(key);
  if (node == nullptr) return result;
  const toml::array* array = node->as_array();
  if (array == nullptr || !array->is_array_of_tables()) {
    fail(key, fmt::format("'{}' must be a list of tables", key), fmt::format("write [[{}]] before each", key));
  }
  for (std::size_t i = 0; i < array->size(); ++i) {
    auto view = std::make_shared<View>();
    view->owner = view_->owner;
    view->table = array->get(i)->as_table();
    view->file = view_->file;
    view->path = fmt::format("{}{}[{}]", view_->path.empty() ? "" : view_->path + ".", key, i);
    result.push_back(TomlTable(std::move(view)));
  }
  return result;
}

void TomlTable::finish() const {
  if (view_->table == nullptr) return;
  for (const auto& [key, node] : *view_->table) {
    const std::string name(key.str());
    if (view_->asked.contains(name)) continue;
    const std::vector<std::string> known(view_->asked.begin(), view_->asked.end());
    const std::string near = nearest_word(name, known);
    throw FileError("TB-FILE-KEY", fmt::format("unknown key '{}'", name), view_->place(&node, name),
                    near.empty() ? fmt::format("known keys here: {}", fmt::join(known, ", "))
                                 : fmt::format("did you mean '{}'?", near));
  }
}

}  // namespace tactbench::sequences
