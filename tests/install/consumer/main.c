#include <stdio.h>

#include "analysis/compensate/compensator_c.h"

int main(void) {
  printf("%u %u\n", tb_compensator_abi_version(), TB_COMPENSATOR_ABI_VERSION);
  return 0;
}
