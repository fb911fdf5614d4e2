// Every key of every TOML file that the program reads, as its own parsers ask for it: docs/reference-keys.md.
#pragma once

#include <string>

namespace tactbench::bench {

// Markdown. The keys come from reading files in which all parts stand (KeyRecorder), so that they are those which the
// parsers know. Throws sequences::FileError when such a file is not accepted, which a test would find.
std::string key_reference();

}  // namespace tactbench::bench
