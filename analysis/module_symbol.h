// Loads parts of the program that are separate libraries, because their dependencies take long to load.
#pragma once

#include <string>

namespace tactbench::analysis {

// A symbol of the module, which is searched next to the program, in the build folder (tests are one folder deeper), and
// in the installation folder; it stays loaded. Null if the module does not exist, or a library that it needs is
// missing.
void* module_symbol(const std::string& module, const char* symbol);

}  // namespace tactbench::analysis
