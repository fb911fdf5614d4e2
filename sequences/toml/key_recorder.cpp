#include "sequences/toml/key_recorder.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace tactbench::sequences {
namespace {

thread_local KeyRecorder* recorder = nullptr;
thread_local int depth = 0;  // of readings within readings

// "scenario[3].name" as "scenario[].name".
std::string without_numbers(const std::string& path) {
  std::string plain;
  bool inside = false;
  for (const char c : path) {
    if (c == ']') inside = false;
    if (!inside) plain += c;
    if (c == '[') inside = true;
  }
  return plain;
}

void add_once(std::vector<std::string>& list, const std::string& text) {
  if (!text.empty() && std::ranges::find(list, text) == list.end()) list.push_back(text);
}

}  // namespace

KeyRecorder::KeyRecorder(std::string file) : file_(std::move(file)) {
  if (recorder != nullptr) throw std::logic_error("two recorders of keys on one thread");
  recorder = this;
}

KeyRecorder::~KeyRecorder() { recorder = nullptr; }

KeyRecorder::Reading::Reading(const std::string& file, const std::string& path, const std::string& key,
                              const char* type, const std::string& range, const std::string* standard,
                              bool asked_only) {
  if (recorder != nullptr && depth == 0 && recorder->listens(file)) {
    const bool chosen = std::ranges::find(recorder->chosen_, without_numbers(path)) != recorder->chosen_.end();
    recorder->add(path.empty() ? key : path + "." + (chosen ? "NAME" : key), type, range, standard, asked_only);
  }
  ++depth;
}

KeyRecorder::Reading::~Reading() { --depth; }

void KeyRecorder::chosen_names(const std::string& file, const std::string& path) {
  if (recorder != nullptr && recorder->listens(file)) add_once(recorder->chosen_, without_numbers(path));
}

void KeyRecorder::add(std::string key, const char* type, const std::string& range, const std::string* standard,
                      bool asked_only) {
  key = without_numbers(key);
  // Below a chosen name: "parameters.dwell_s.low" as "parameters.NAME.low".
  for (const std::string& path : chosen_) {
    if (!key.starts_with(path + ".") || key.starts_with(path + ".NAME")) continue;
    const std::size_t end = key.find('.', path.size() + 1);
    key.replace(0, std::min(end, key.size()), path + ".NAME");
  }
  auto known = std::ranges::find(keys_, key, &KeyUse::key);
  if (known == keys_.end()) {
    known = keys_.insert(keys_.end(), KeyUse());
    known->key = key;
  }
  if (known->type.empty()) known->type = type;
  add_once(known->ranges, range);
  if (standard != nullptr && asked_ != key) add_once(known->defaults, *standard);
  asked_ = asked_only ? key : std::string();
  if (asked_only || standard != nullptr) known->required = false;
}

}  // namespace tactbench::sequences
