// What a client sends over the control socket, read and written.
#include "bench/run/control/client_words.h"

#include <catch2/catch.hpp>
#include <string>

#include "bench/run/control/peer.h"
#include "bench/run/control/run_status.h"

using namespace tactbench::bench;

TEST_CASE("client words: what is written is read again, with whom it is for") {
  const ClientWords pause = read_words(command_words(Command::kPause, "bob of 127.0.0.1"));
  CHECK(pause.word == ClientWord::kCommand);
  CHECK(pause.command == Command::kPause);
  CHECK(pause.behalf == "bob of 127.0.0.1");
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

TEST_CASE("client words: texts are cut to their columns, and words end at the first blank") {
  const std::string long_text(1000, 'x');
  const std::string cut_behalf = std::string(kLongestBehalf - 1, 'x') + "\u2026";
  const std::string cut_reply = std::string(kLongestReply - 1, 'x') + "\u2026";
  CHECK(command_words(Command::kStop, "") == "stop");
  CHECK(command_words(Command::kStop, "ann") == "stop\nann");
  CHECK(command_words(Command::kStop, long_text) == "stop\n" + cut_behalf);
  CHECK(answer_words(12, "a b", "") == "answer 12 a b");
  CHECK(answer_words(12, long_text, "ann") == "answer 12 " + cut_reply + "\nann");
  CHECK(read_words("stop now").command == Command::kStop);
  CHECK(read_words("stop\n" + long_text).behalf == cut_behalf);
  CHECK(read_words("stop\n").behalf.empty());
  CHECK(read_words("follow me\nann").word == ClientWord::kFollow);
  CHECK(read_words("follow me\nann").behalf == "ann");
  const ClientWords read = read_words("answer 12  two blanks\nann");
  CHECK(
      (read.word == ClientWord::kAnswer && read.question == 12 && read.text == " two blanks" && read.behalf == "ann"));
  CHECK(read_words("answer 12 " + long_text).text == cut_reply);
  CHECK(read_words("answer -3 x").question == -3);
}

TEST_CASE("peers: their names from the user database, or their numbers") {
  CHECK(peer_text({812, 0, false}) == "root (pid 812)");
  CHECK(peer_text({812, 3999999999U, false}) == "user 3999999999 (pid 812)");
  CHECK_FALSE(peer_of(-1));
}
