/* Starts main() on qemu's mps2 boards; files and output by semihosting. Standard input is the file `input`. */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

extern void initialise_monitor_handles(void);
extern int main(void);
extern char stack_top[];

void reset(void) {
  initialise_monitor_handles();
  if (freopen("input", "r", stdin) == NULL) exit(2);
  exit(main());
}

void _init(void) {}
void _fini(void) {}

__attribute__((section(".vectors"), used)) static void (*const vectors[16])(void) = {(void (*)(void))stack_top, reset};
