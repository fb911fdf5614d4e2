// Where a woven program learns which mutant it is: a file, not the environment, which a test may change.
#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include "tests/mutants/random_parts/woven.h"

namespace tactbench::mutants {

Control* control = nullptr;

// A process that may not write the file (it has given up root's rights) still learns its number.
Control* open_control() {
  static Control alone{};
  const int file = open(TACTBENCH_MUTANT_CONTROL, O_RDWR | O_CLOEXEC);
  const int readable = file >= 0 ? file : open(TACTBENCH_MUTANT_CONTROL, O_RDONLY | O_CLOEXEC);
  const int rights = file >= 0 ? PROT_READ | PROT_WRITE : PROT_READ;
  void* const shared = readable < 0 ? MAP_FAILED
                                    : mmap(nullptr, sizeof(Control), rights | PROT_WRITE,
                                           file >= 0 ? MAP_SHARED : MAP_PRIVATE, readable, 0);
  if (readable >= 0) close(readable);
  control = shared == MAP_FAILED ? &alone : static_cast<Control*>(shared);
  return control;
}

}  // namespace tactbench::mutants
