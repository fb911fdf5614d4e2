// Prints a word in block letters that can be read from a distance.
#pragma once

#include <string>

namespace tactbench::bench {

// `word` in five lines of block letters, each line after `margin` and with a line end, without trailing blanks. Letters
// A C E F I L N O P S U V in either case; throws std::invalid_argument for any other.
std::string large_word(const std::string& word, const std::string& margin);

}  // namespace tactbench::bench
