/* Rows of vectors.csv from frames of counts, words of 16 bits, on standard input: the first of the unloaded sensor, some of them lost. */
#include <stdio.h>

#include "tb_model.h"

static tb_state state;
static uint16_t counts[TB_TAXELS], pressures[TB_TAXELS], status[TB_TAXELS];

static void put(const uint16_t* words) {
  uint32_t i;
  for (i = 0; i < TB_TAXELS; ++i) printf(",%u", (unsigned)words[i]);
}

int main(void) {
  uint32_t row;
  if (!tb_init(&state)) return 1;
  for (row = 0; fread(counts, sizeof counts, 1, stdin) == 1; ++row) {
    const int lost = row % 50 == 30 || (row % 400 > 380 && row % 400 < 395);
    if (row == 0)
      (void)tb_tare(&state, counts);
    else if (lost)
      tb_lost_frame(&state, pressures, status);
    else
      tb_frame(&state, counts, pressures, status);
    printf(row == 0 ? "tare" : lost ? "lost" : "frame");
    put(counts);
    put(pressures);
    put(status);
    putchar('\n');
  }
  return 0;
}
