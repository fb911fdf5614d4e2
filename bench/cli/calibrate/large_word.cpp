#include "bench/cli/calibrate/large_word.h"

#include <array>
#include <map>
#include <stdexcept>
#include <string_view>

namespace tactbench::bench {

namespace {

using Letter = std::array<std::string_view, 5>;  // lines of equal length

const std::map<char, Letter>& letters() {
  static const std::map<char, Letter> all = {
      {'A', {" ### ", "#   #", "#####", "#   #", "#   #"}}, {'C', {" ####", "#    ", "#    ", "#    ", " ####"}},
      {'E', {"#####", "#    ", "#### ", "#    ", "#####"}}, {'F', {"#####", "#    ", "#### ", "#    ", "#    "}},
      {'I', {"###", " # ", " # ", " # ", "###"}},           {'L', {"#    ", "#    ", "#    ", "#    ", "#####"}},
      {'N', {"#   #", "##  #", "# # #", "#  ##", "#   #"}}, {'O', {" ### ", "#   #", "#   #", "#   #", " ### "}},
      {'P', {"#### ", "#   #", "#### ", "#    ", "#    "}}, {'S', {" ####", "#    ", " ### ", "    #", "#### "}},
      {'U', {"#   #", "#   #", "#   #", "#   #", " ### "}}, {'V', {"#   #", "#   #", "#   #", " # # ", "  #  "}}};
  return all;
}

}  // namespace

std::string large_word(const std::string& word, const std::string& margin) {
  std::string text;
  for (std::size_t row = 0; row < Letter().size(); ++row) {
    std::string line = margin;
    for (const char letter : word) {
      const auto found =
          letters().find(letter >= 'a' && letter <= 'z' ? static_cast<char>(letter - 'a' + 'A') : letter);
      if (found == letters().end()) throw std::invalid_argument("no large letter for '" + std::string(1, letter) + "'");
      if (line.size() > margin.size()) line += ' ';
      line += found->second.at(row);
    }
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + '\n';
  }
  return text;
}

}  // namespace tactbench::bench
