#include "bench/run/control/client_words.h"

#include <fmt/format.h>

#include <charconv>

#include "bench/common/for_people.h"

namespace tactbench::bench {

namespace {

Command command_of(std::string_view text) {
  for (const Command command : {Command::kPause, Command::kResume, Command::kStop, Command::kAbort, Command::kPanic}) {
    if (text == to_string(command)) return command;
  }
  return Command::kStatus;
}

std::string with_behalf(std::string words, const std::string& behalf) {
  if (!behalf.empty()) words += "\n" + one_line(behalf, kLongestBehalf);
  return words;
}

std::string_view word_at(std::string_view& rest) {
  const std::size_t end = rest.find(' ');
  const std::string_view word = rest.substr(0, end);
  rest = end == std::string_view::npos ? std::string_view() : rest.substr(end + 1);
  return word;
}

}  // namespace

ClientWords read_words(std::string_view packet) {
  ClientWords read;
  const std::size_t line_end = packet.find('\n');
  std::string_view rest = packet.substr(0, line_end);
  if (line_end != std::string_view::npos) read.behalf = one_line(packet.substr(line_end + 1), kLongestBehalf);
  const std::string_view word = word_at(rest);
  if (word == "follow") {
    read.word = ClientWord::kFollow;
  } else if (word == "answer") {
    read.word = ClientWord::kAnswer;
    const std::string_view number = word_at(rest);
    int question = 0;
    const auto [end, failed] = std::from_chars(number.data(), number.data() + number.size(), question);
    if (failed == std::errc() && end == number.data() + number.size()) read.question = question;
    read.text = one_line(rest, kLongestReply);
  } else {
    read.command = command_of(word);
  }
  return read;
}

std::string command_words(Command command, const std::string& behalf) {
  return with_behalf(to_string(command), behalf);
}

std::string answer_words(int question, const std::string& text, const std::string& behalf) {
  return with_behalf(fmt::format("answer {} {}", question, one_line(text, kLongestReply)), behalf);
}

}  // namespace tactbench::bench
