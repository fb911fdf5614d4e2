// The keys of one kind of TOML file with all that is told of them: from the parsers (KeyRecorder) type, range and
// default, from meanings/ what each is for. Behind docs/reference-keys.md and the manual pages of section 5.
#pragma once

#include <string>
#include <vector>

#include "bench/cli/words/key_samples.h"
#include "sequences/toml/key_recorder.h"

namespace tactbench::bench {

struct KnownKey {
  sequences::KeyUse use;
  std::string unit;     // "" where there is none; "`unit`": the one that the file names
  std::string meaning;  // empty: meanings/ has no line for it, which check_meanings() finds
};

// The keys of a table together, tables in the order of their first key. Throws sequences::FileError when a parser
// refuses its sample.
std::vector<KnownKey> known_keys(const FileKind& kind);
// Throws std::logic_error for a key without a meaning and for a meaning without a key.
void check_meanings(const FileKind& kind);

// "scenario[]" of "scenario[].name"; "" of a key of no table.
std::string table_of(const std::string& key);

}  // namespace tactbench::bench
