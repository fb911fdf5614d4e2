#include "bench/cli/own_copy.h"

#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "bench/cli/session.h"
#include "bench/common/output_file.h"

namespace tactbench::bench {

void write_own_copy(const OwnCopy& copy, const Session& session) {
  constexpr const char* kAllowed = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_";
  const std::string path = copy.to.ends_with(".toml") ? copy.to : copy.to + ".toml";
  const std::string name = std::filesystem::path(path).stem();
  if (name.empty() || name.find_first_not_of(kAllowed) != std::string::npos)
    throw Error("TB-USAGE", fmt::format("'{}' is not a valid name of {}", copy.to, copy.what), copy.verb + " --copy",
                "use letters, digits, - and _");
  const std::string line = fmt::format("\nname = \"{}\"", copy.from);
  const std::size_t at = copy.text.find(line);
  if (at == std::string::npos)
    throw Error("TB-USAGE", fmt::format("the name of '{}' is not found in its file", copy.from), copy.verb + " --copy",
                "start from a shipped one");
  const std::string text =
      copy.text.substr(0, at) + fmt::format("\nname = \"{}\"", name) + copy.text.substr(at + line.size());
  // A copy begins as its original does, so the kind of the file would not protect it.
  if (std::filesystem::exists(path) && !session.replace)
    throw Error("TB-FILE-EXISTS", fmt::format("'{}' exists already", path), path,
                "give another name, or --replace to overwrite it");
  write_output(path, text, session.replace);
  if (session.json) return print_json(copy.verb + ".copy", {{"name", name}, {"from", copy.from}, {"path", path}});
  tty::print("{}: '{}', a copy of '{}'\n\nNext:  edit it, then\n       tactbench {} {}\n", path, name,
             one_line(copy.from), copy.verb, path);
}

}  // namespace tactbench::bench
