// Options with defaults from the environment or the operator's profile (bench/config/operator_profile.h), declared in
// the same way for all verbs.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bench/config/operator_profile.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace tactbench::bench {

class ProfileOptions {
 public:
  ProfileOptions() = default;
  explicit ProfileOptions(std::string file) : file_(std::move(file)) {}  // another file than tactbench.toml
  // Declares an option (or a positional argument) whose default is the value of `key`. If there is one, the option is
  // not required; its help names the sources of the default. `value` must outlive the parsing.
  CLI::Option* add(CLI::App& verb, const std::string& names, ProfileKey key, std::string& value,
                   const std::string& about);
  CLI::Option* add(CLI::App& verb, const std::string& names, ProfileKey key, std::vector<std::string>& values,
                   const std::string& about);
  // The option --operator, required.
  CLI::Option* add_operator(CLI::App& verb, std::string& value);

  // The values of the working folder and the environment, read once. Throws sequences::FileError.
  [[nodiscard]] const OperatorProfile& values() const;
  // For --help, and for commands that end a run: an unreadable profile counts as none.
  void tolerate_unreadable() { tolerant_ = true; }

 private:
  struct Declared {
    const CLI::App* verb;
    CLI::Option* option;
    ProfileKey key;
    std::function<void(const ProfileValue&)> take;
  };
  CLI::Option* declare(CLI::App& verb, CLI::Option* option, ProfileKey key,
                       std::function<void(const ProfileValue&)> take);
  void fill_in(const CLI::App& verb);

  std::string file_ = kProfileFile;
  std::vector<Declared> declared_;
  mutable std::optional<OperatorProfile> values_;
  bool tolerant_ = false;
};

}  // namespace tactbench::bench
