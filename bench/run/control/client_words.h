// Requests of a client of the control socket, one packet of text each: a command word with its arguments, and on a
// second line the person on whose behalf the client asks. `follow`: sends the run's status repeatedly. `answer ID
// TEXT`: answers the question with that number. All other words are commands (control.h).
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "bench/run/control/control.h"

namespace tactbench::bench {

inline constexpr std::size_t kLongestWords = 2048;  // bytes of a packet; what is longer is cut
inline constexpr std::size_t kLongestReply = 300;   // columns of an answer's text
inline constexpr std::size_t kLongestBehalf = 120;  // columns of the name for whom a client asks

enum class ClientWord { kCommand, kFollow, kAnswer };

struct ClientWords {
  ClientWord word = ClientWord::kCommand;
  Command command = Command::kStatus;  // of kCommand; an unknown word asks for the status
  int question = 0;                    // of kAnswer; 0: not a number, which no question has
  std::string text;                    // of kAnswer, one line
  std::string behalf;                  // "bob on the page, from 127.0.0.1"; empty: the client itself asks
};

ClientWords read_words(std::string_view packet);
std::string command_words(Command command, const std::string& behalf);
std::string answer_words(int question, const std::string& text, const std::string& behalf);

}  // namespace tactbench::bench
