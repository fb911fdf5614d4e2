// Parts of the program that lie in libraries of their own, because what they depend on takes long to load.
#pragma once

#include <string>

namespace tactbench::analysis {

// The symbol of the module, which is sought beside the program, where it was built (tests lie a folder deeper), and
// where it is installed, and stays loaded. Null where there is no such module, or a library that it needs is not there.
void* module_symbol(const std::string& module, const char* symbol);

}  // namespace tactbench::analysis
