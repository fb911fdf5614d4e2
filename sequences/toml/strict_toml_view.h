// Common part of a TomlDocument and its TomlTables. Used by strict_toml*.cpp alone.
#pragma once

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "sequences/toml/strict_toml.h"

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

}  // namespace tactbench::sequences
