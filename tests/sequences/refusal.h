// Checks how a file is rejected: the error's id, its place, and the number or word that it names.
#pragma once

#include <catch2/catch.hpp>

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "sequences/recipe.h"
#include "sequences/toml/strict_toml.h"

namespace tactbench::sequences {

struct Refusal {
  std::string body, id, place, fact = {};  // the place to its end
};

inline std::optional<FileError> refusal_by(const std::function<void()>& act) {
  try {
    act();
  } catch (const FileError& error) {
    CHECK_FALSE(error.remedy().empty());
    return error;
  }
  return std::nullopt;
}

inline void check_refusal(const std::function<void()>& act, const Refusal& wanted) {
  INFO(wanted.body);
  const auto error = refusal_by(act);
  REQUIRE(error);
  CHECK(error->id() == wanted.id);
  CHECK_THAT(error->where(), Catch::EndsWith(wanted.place));
  CHECK_THAT(error->what(), Catch::Contains(wanted.fact));
}

inline void check_refusals(const std::vector<Refusal>& all, const std::function<void(const std::string&)>& read) {
  for (const Refusal& one : all) check_refusal([&] { read(one.body); }, one);
}

// The result of `read` for the root of each text.
template <class Read>
void check_refused_reading(Read read, const std::vector<Refusal>& all) {
  check_refusals(all, [&](const std::string& text) { (void)read(TomlDocument::from_text(text, "t").root()); });
}

// A document's record of each requested key.
inline std::string noted(const TomlDocument& document) {
  std::string all;
  for (const Setting& setting : document.settings())
    all += setting.key + "=" + setting.value + " " + setting.origin + "\n";
  return all;
}

// The key that is refused, without its file and line.
inline std::string key_refused(const std::function<void()>& act, const std::string& fact = {}) {
  const auto error = refusal_by(act);
  if (!error) return "accepted";
  CHECK_THAT(error->what(), Catch::Contains(fact));
  return error->where().substr(error->where().find(' ') + 1);
}

// Builds recipes from the part of their text that a test needs.

// Lines 1 to 5 are those before `press`, which follows in [press]; `root` comes before that.
inline Recipe press_of(const std::string& press, const std::string& root = {}) {
  return parse_recipe(TomlDocument::from_text(
      "schema = 1\nname = \"t\"\nkind = \"press\"\n" + root + "[press]\nobject = \"ring\"\n" + press, "p.toml"));
}

inline Recipe recipe_of(const std::string& body) {
  return parse_recipe(TomlDocument::from_text("schema = 1\nname = \"t\"\nunit = \"psi\"\n" + body, "test.toml"));
}

}  // namespace tactbench::sequences
