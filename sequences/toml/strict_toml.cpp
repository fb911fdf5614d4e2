// Common part of a TomlDocument and its TomlTables. Used by strict_toml*.cpp alone.
#include "sequences/toml/strict_toml.h"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <numeric>
#include <optional>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "sequences/toml/pressure_text.h"

namespace tactbench::sequences {

struct TomlDocument::Node {
  toml::table table;
  std::vector<Setting> settings = {};
  std::map<std::string, double> parameters = {};
  std::set<std::string> parameters_used = {};
  std::string typed_prefix = {};                  // of the keys that were set
  std::map<std::string, std::string> typed = {};  // by key: what was typed in another unit
};

// "a number", "text" and so on, for error texts.
const char* kind_of(const toml::node& node);

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
    if (node != nullptr && node->source().begin.line == 0) {
      return fmt::format("--set {}{} (over {})", owner->typed_prefix, dotted, file);
    }
    const toml::node* shown = node != nullptr ? node : table;
    if (shown == nullptr || shown->source().begin.line == 0) return file + ", " + dotted;
    return fmt::format("{}:{}:{}, {}", file, shown->source().begin.line, shown->source().begin.column, dotted);
  }
  // "130.534 (typed: 9bar)" of a key that was set in another unit, else the number alone.
  [[nodiscard]] std::string as_typed(const std::string& key, double value) const {
    const auto found = owner->typed.find(path.empty() ? key : path + "." + key);
    return found == owner->typed.end() ? fmt::format("{:g}", value)
                                       : fmt::format("{:g} (typed: {})", value, found->second);
  }
  // A number, or the parameter that "$name" refers to; none for anything else. Throws for an undeclared parameter.
  [[nodiscard]] std::optional<double> number_of(const toml::node& node, const std::string& key) const;
  // Records a value read, for TomlDocument::settings(); `node` null: the default.
  void note(const toml::node* node, const std::string& key, const std::string& value) const {
    const std::string dotted = path.empty() ? key : path + "." + key;
    for (const Setting& known : owner->settings) {
      if (known.key == dotted) return;
    }
    const auto line = node == nullptr ? 0 : node->source().begin.line;
    owner->settings.push_back({dotted, value,
                               node == nullptr ? "default"
                               : line == 0     ? "--set"
                                               : fmt::format("{}:{}", file, line)});
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

// toml++ bounds the depth of arrays but not that of dotted keys: one of 200,000 parts would overflow the stack.
constexpr std::size_t kMaxLineBytes = 16384;
constexpr std::size_t kLargestFile = 16'000'000;  // bytes

void check_lines(const std::string& text, const std::string& name) {
  std::size_t line = 1;
  for (std::size_t at = 0; at < text.size(); ++line) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    if (end - at > kMaxLineBytes) {
      throw FileError("TB-FILE-SYNTAX", fmt::format("a line of {} characters", end - at),
                      fmt::format("{}:{}", name, line),
                      fmt::format("break it: a line may have {} characters", kMaxLineBytes));
    }
    at = end + 1;
  }
}

toml::table parse(const std::string& text, const std::string& name) {
  check_lines(text, name);
  try {
    return toml::parse(text, name);
  } catch (const toml::parse_error& error) {
    const auto& at = error.source().begin;
    throw FileError("TB-FILE-SYNTAX", fmt::format("not valid TOML: {}", error.description()),
                    fmt::format("{}:{}:{}", name, at.line, at.column),
                    "a quantity is a plain number with its unit in the key (dwell_s = 2.0); text needs quotes");
  }
}

}  // namespace

std::string FileError::shown(std::string message) {
  for (std::size_t at = 0; (at = message.find('\0', at)) != std::string::npos;) message.replace(at, 1, "\\x00");
  return message;
}

TomlDocument TomlDocument::from_file(const std::string& path) {
  namespace fs = std::filesystem;
  const auto refuse = [&](const std::string& message, const std::string& remedy) {
    throw FileError("TB-FILE-MISSING", message, path, remedy);
  };
  std::error_code unknown;
  const fs::file_status status = fs::status(path, unknown);
  const bool found = !unknown && status.type() != fs::file_type::not_found;
  if (found && status.type() != fs::file_type::regular) {
    refuse(fmt::format("'{}' is not a regular file", path), "name a file: devices, folders and pipes are not read");
  }
  // Files of /proc and /sys also have size 0; reading some of them blocks forever.
  if (found && fs::file_size(path, unknown) == 0)
    refuse(fmt::format("'{}' is empty", path), "check that it is the right file");
  std::ifstream stream;
  if (found) stream.open(path, std::ios::binary);
  if (!found || !stream) {
    refuse(fmt::format("cannot read the file '{}'", path),
           "check the name; 'tactbench init' writes files to start from");
  }
  std::string text;
  std::vector<char> block(std::size_t{1} << 16);
  while (stream.read(block.data(), static_cast<std::streamsize>(block.size())), stream.gcount() > 0) {
    text.append(block.data(), static_cast<std::size_t>(stream.gcount()));
    if (text.size() > kLargestFile) {
      refuse(fmt::format("'{}' is longer than {} bytes", path, kLargestFile), "check that it is the right file");
    }
  }
  if (stream.bad()) refuse(fmt::format("reading the file '{}' failed", path), "check the disk and the file");
  return from_text(text, path);
}

TomlDocument TomlDocument::from_text(const std::string& text, const std::string& name) {
  TomlDocument document;
  document.text_ = text;
  document.name_ = name;
  document.node_ = std::make_shared<Node>(Node{parse(text, name)});
  return document;
}

void TomlDocument::set(const Override& override_value, const std::string& prefix) {
  const std::string where = "--set " + prefix + override_value.key + "=" + override_value.value;
  node_->typed_prefix = prefix;
  node_->typed.erase(override_value.key);  // of an earlier setting
  if (!override_value.typed.empty() && override_value.typed != override_value.value)
    node_->typed[override_value.key] = override_value.typed;
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
                      "write the key as in the file, table.key");
    }
  }
  if (rest.empty()) throw FileError("TB-FILE-VALUE", "an empty key", where, "write --set table.key=value");
  table->insert_or_assign(rest, *holder.get("v"));
}

void TomlDocument::remove(const std::string& key) { node_->table.erase(key); }

void TomlDocument::define(const std::string& name, double value) { node_->parameters[name] = value; }
bool TomlDocument::uses(const std::string& name) const { return node_->parameters_used.contains(name); }

std::string TomlDocument::to_text() const {
  std::ostringstream stream;
  stream << node_->table << '\n';
  return stream.str();
}

TomlTable TomlDocument::root() const {
  auto view = std::make_shared<TomlTable::View>();
  view->owner = node_;
  view->table = &node_->table;
  view->file = name_;
  return TomlTable(std::move(view));
}

const std::vector<Setting>& TomlDocument::settings() const { return node_->settings; }

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

bool TomlTable::has(const std::string& key) const { return view_->find(key) != nullptr; }

std::vector<std::string> TomlTable::keys() const {
  std::vector<std::string> names;
  if (view_->table == nullptr) return names;
  for (const auto& [key, node] : *view_->table) names.emplace_back(key.str());
  return names;
}

void TomlTable::fail(const std::string& key, const std::string& message, const std::string& remedy) const {
  throw FileError("TB-FILE-VALUE", message, view_->place(view_->find(key), key), remedy);
}

bool TomlTable::boolean(const std::string& key, bool fallback) const {
  const toml::node* node = view_->find(key);
  if (node != nullptr && !node->is_boolean()) {
    fail(key, fmt::format("'{}' must be true or false", key), "write true or false");
  }
  const bool value = node == nullptr ? fallback : node->value_or(fallback);
  view_->note(node, key, value ? "true" : "false");
  return value;
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
  std::string value = node->value_or(std::string());
  view_->note(node, key, fmt::format("\"{}\"", value));
  return value;
}

std::string TomlTable::text(const std::string& key, const std::string& fallback) const {
  if (has(key)) return text(key);
  view_->note(nullptr, key, fmt::format("\"{}\"", fallback));
  return fallback;
}

std::string TomlTable::name(const std::string& key) const {
  std::string value = text(key);
  if (value.find_first_not_of(" \t\r\n") == std::string::npos)
    fail(key, fmt::format("'{}' is empty", key), "give a short name");
  return value;
}

std::string TomlTable::date_text(const std::string& key) const {
  const toml::node* node = view_->find(key);
  const auto* const date = node == nullptr ? nullptr : node->as_date();
  if (date == nullptr) return text(key, "");
  const toml::date day = date->get();
  std::string value = fmt::format("{:04}-{:02}-{:02}", int{day.year}, int{day.month}, int{day.day});
  view_->note(node, key, fmt::format("\"{}\"", value));
  return value;
}

std::vector<std::string> TomlTable::texts(const std::string& key) const {
  const toml::node* node = view_->find(key);
  const toml::array* array = node == nullptr ? nullptr : node->as_array();
  std::vector<std::string> values;
  if (node != nullptr && array == nullptr)
    fail(key, fmt::format("'{}' must be a list of texts, it is {}", key, kind_of(*node)), "write [\"...\", \"...\"]");
  for (std::size_t i = 0; array != nullptr && i < array->size(); ++i) {
    const auto* text = array->get(i)->as_string();
    if (text == nullptr)
      fail(key, fmt::format("element {} of '{}' is {}, not a text", i + 1, key, kind_of(*array->get(i))),
           "put it in double quotes");
    values.push_back(text->get());
  }
  view_->note(node, key, fmt::format("[{}]", fmt::join(values, ", ")));
  return values;
}

std::string TomlTable::word(const std::string& key, const std::vector<std::string>& words) const {
  std::string value = text(key);
  if (std::find(words.begin(), words.end(), value) != words.end()) return value;
  const std::string near = nearest_word(value, words);
  fail(key, fmt::format("'{}' is \"{}\", which is not one of {}", key, value, fmt::join(words, ", ")),
       near.empty() ? "use one of the words" : fmt::format("did you mean \"{}\"?", near));
}

std::string TomlTable::word(const std::string& key, const std::string& fallback,
                            const std::vector<std::string>& words) const {
  return has(key) ? word(key, words) : text(key, fallback);
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
