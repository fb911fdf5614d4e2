// What a client sends over the control socket, read and written.
#include "bench/run/control/client_words.h"

#include <catch2/catch.hpp>
#include <string>

using namespace tactbench::bench;

TEST_CASE("client words: what is written is read again, with whom it is for") {
  const ClientWords pause = read_words(command_words(Command::kPause, "bob on the page, from 127.0.0.1"));
  CHECK(pause.word == ClientWord::kCommand);
  CHECK(pause.command == Command::kPause);
  CHECK(pause.behalf == "bob on the page, from 127.0.0.1");
  const ClientWords answer = read_words(answer_words(3, "mounted, 2 Nm", ""));
  CHECK(answer.word == ClientWord::kAnswer);
  CHECK(answer.question == 3);
  CHECK(answer.text == "mounted, 2 Nm");
  CHECK(answer.behalf.empty());
  CHECK(read_words(answer_words(3, "", "bob")).text.empty());
  CHECK(read_words("follow").word == ClientWord::kFollow);
  for (const Command command : {Command::kStatus, Command::kResume, Command::kStop, Command::kAbort, Command::kPanic})
    CHECK(read_words(to_string(command)).command == command);
}

TEST_CASE("client words: what is no word asks for the status, and no text breaks the line") {
  for (const char* text : {"", " ", "halt", "pausee", "PAUSE", "\npause", "answers 1"}) {
    INFO(text);
    CHECK(read_words(text).word == ClientWord::kCommand);
    CHECK(read_words(text).command == Command::kStatus);
  }
  for (const char* text : {"answer", "answer ", "answer x", "answer 3x yes", "answer 99999999999 yes"})
    CHECK(read_words(text).question == 0);
  const ClientWords read = read_words(answer_words(1, "yes\nabort\x1b[31m", "bob\nroot"));
  CHECK(read.word == ClientWord::kAnswer);
  CHECK(read.text.find('\n') == std::string::npos);
  CHECK(read.text.find('\x1b') == std::string::npos);
  CHECK(read.behalf.find('\n') == std::string::npos);
  CHECK(read.behalf.starts_with("bob"));
  CHECK(command_words(Command::kStop, std::string(5000, 'x')).size() < 500);
}
