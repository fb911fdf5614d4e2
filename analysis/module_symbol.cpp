#include "analysis/module_symbol.h"

#include <dlfcn.h>

#include <filesystem>

namespace tactbench::analysis {

void* module_symbol(const std::string& module, const char* symbol) {
  std::error_code none;
  const auto own = std::filesystem::read_symlink("/proc/self/exe", none).parent_path();
  for (const char* folder : {".", "..", "../lib/tactbench/modules"}) {
    if (void* library = dlopen((own / folder / module).c_str(), RTLD_NOW | RTLD_LOCAL)) return dlsym(library, symbol);
  }
  return nullptr;
}

}  // namespace tactbench::analysis
