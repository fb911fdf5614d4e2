#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <set>

#include "sequences/toml/strict_toml.h"
#include "sequences/toml/strict_toml_view.h"

namespace tactbench::sequences {

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
