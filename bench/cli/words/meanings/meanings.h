// What each key of the TOML files is for, one line a key: the only source of it for docs/reference-keys.md and for the
// manual pages of section 5 (key_reference.h, key_manual.h). A key without a line, or a line without a key, is an error
// there, so that parsers and meanings cannot drift apart.
#pragma once

#include <vector>

namespace tactbench::bench {

struct KeyMeaning {
  const char* key;   // dotted, as KeyUse::key; "*.baud" stands for this key in every table that has no line of its own
  const char* text;  // begins with a capital letter, without a full stop at its end
};
using KeyMeanings = std::vector<KeyMeaning>;

KeyMeanings bench_meanings();  // with those of [simulation]
KeyMeanings recipe_meanings();
KeyMeanings suite_meanings();
KeyMeanings profile_meanings();     // module profiles
KeyMeanings sensor_meanings();      // sensor.toml
KeyMeanings limits_meanings();      // limits.toml
KeyMeanings laboratory_meanings();  // lab.toml
KeyMeanings operator_meanings();    // tactbench.toml

// Of bench_meanings() alone.
KeyMeanings instrument_meanings();
KeyMeanings simulation_meanings();

}  // namespace tactbench::bench
