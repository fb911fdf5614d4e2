// Loads parts of the program that are libraries of their own, because what they depend on takes long to load.
#pragma once

#include <string>

namespace tactbench::analysis {

// A symbol of the module, which is searched next to the program, where it was built (tests are one folder deeper), and
// where it is installed; it stays loaded. Null where there is no such module, or a library that it needs is missing.
void* module_symbol(const std::string& module, const char* symbol);

}  // namespace tactbench::analysis
