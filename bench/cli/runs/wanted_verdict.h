// Parser and filter of the option --verdict of `runs list`.
#pragma once

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "analysis/judgement/verdict.h"
#include "bench/common/error.h"
#include "sequences/toml/strict_toml.h"

namespace tactbench::bench {

// Parses --verdict, in the words of the column: "conditional pass" or conditional-pass; with a leading "simulated" only
// simulated runs; none or "-" for runs without a verdict.
class WantedVerdict {
 public:
  explicit WantedVerdict(const std::string& typed) : any_(typed.empty()) {
    if (any_) return;
    std::string word = typed == "-" ? kNone : typed;
    std::ranges::replace(word, '-', ' ');
    simulated_ = word.starts_with(kSimulated);
    if (simulated_) word.erase(0, kSimulated.size());
    verdict_ = analysis::verdict_from(word);
    const std::vector<std::string> known = words();
    if (std::ranges::find(known, word) != known.end()) return;
    const std::string near = sequences::nearest_word(word, known);
    throw Error("TB-USAGE", fmt::format("there is no verdict '{}'", typed), "--verdict",
                fmt::format("{}one of: {}", near.empty() ? "" : fmt::format("did you mean '{}'? ", near),
                            fmt::join(known, ", ")));
  }

  [[nodiscard]] bool fits(std::optional<analysis::Verdict> verdict, const std::string& origin) const {
    return any_ || (verdict == verdict_ && (!simulated_ || origin == "simulated"));
  }

  static std::vector<std::string> words() {
    std::vector<std::string> all = analysis::verdict_words();
    all.emplace_back(kNone);
    return all;
  }
  // For --help and completion, where a blank would split the word.
  static std::string type_name() {
    std::string text = fmt::format("TEXT:{{{}}}", fmt::join(words(), ","));
    std::ranges::replace(text, ' ', '-');
    return text;
  }

 private:
  static constexpr const char* kNone = "none";
  static constexpr std::string_view kSimulated = "simulated ";
  bool any_ = false, simulated_ = false;
  std::optional<analysis::Verdict> verdict_;
};

}  // namespace tactbench::bench
