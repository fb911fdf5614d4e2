/* Frames of counts from standard input, words of 16 bits, the first of the unloaded sensor. Prints a hash of all readings.
 * -DALL: each pressure before it. -DCOST: instructions a taxel of tb_frame(), in the mean and of the worst frame, by SysTick under
 * qemu's -icount shift=0, where an instruction takes 1 ns and a tick of the boards' 25 MHz 40. */
#include <stdio.h>

#include "tb_model.h"

static tb_state state;
static uint16_t counts[TB_TAXELS], pressures[TB_TAXELS], status[TB_TAXELS];

#ifdef COST
#define CONTROL (*(volatile uint32_t*)0xE000E010)
#define RELOAD (*(volatile uint32_t*)0xE000E014)
#define CURRENT (*(volatile uint32_t*)0xE000E018)
static uint32_t begin(void) {
  CURRENT = 0;
  return CURRENT;
}
static uint32_t since(uint32_t before) { return (before - CURRENT) & 0xFFFFFFU; }
#endif

int main(void) {
  uint32_t frames = 0, hash = TB_HASH_START;
#ifdef COST
  uint32_t most = 0, sum = 0, itself;
  RELOAD = 0xFFFFFFU;
  CONTROL = 5;
  itself = begin();
  itself = since(itself);
#endif
  if (!tb_init(&state) || fread(counts, sizeof counts, 1, stdin) != 1) return 1;
  (void)tb_tare(&state, counts);
  for (; fread(counts, sizeof counts, 1, stdin) == 1; ++frames) {
#ifdef COST
    uint32_t ticks = begin();
    tb_frame(&state, counts, pressures, status);
    ticks = since(ticks) - itself;
    sum += ticks;
    if (ticks > most) most = ticks;
#else
    tb_frame(&state, counts, pressures, status);
#endif
    hash = tb_hash(tb_hash(hash, pressures, TB_TAXELS), status, TB_TAXELS);
#ifdef ALL
    {
      uint32_t i;
      for (i = 0; i < TB_TAXELS; ++i) printf("%u\n", (unsigned)pressures[i]);
    }
#endif
  }
#ifdef COST
  printf("%lu %lu ", (unsigned long)(sum / frames * 40 / TB_TAXELS), (unsigned long)(most * 40 / TB_TAXELS));
#endif
  printf("%lu frames, hash %08lx\n", (unsigned long)frames, (unsigned long)hash);
  return 0;
}
