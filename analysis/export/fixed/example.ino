/* Frames of counts to pressures. With Arduino: a sketch that prints the highest pressure of each frame. As a C program,
 * cc -std=c99 -O2 -x c: checks the rows of vectors.csv, from standard input. */
#include "tb_model.h"

static tb_state state;
static uint16_t counts[TB_TAXELS], pressures[TB_TAXELS], status[TB_TAXELS];

#ifdef ARDUINO

/* To be replaced by your scanner's: the taxel's count, 0 to 65535. Here one input of 10 bits. */
static uint16_t count_of(uint32_t taxel) {
  (void)taxel;
  return (uint16_t)((uint16_t)analogRead(A0) << 6);
}

static void read_frame(void) {
  uint32_t i;
  for (i = 0; i < TB_TAXELS; ++i) counts[i] = count_of(i);
}

void setup() {
  Serial.begin(115200);
  if (!tb_init(&state)) {
    Serial.println("the tables are damaged");
    while (1) {
    }
  }
  read_frame(); /* unloaded */
  Serial.println((unsigned long)tb_tare(&state, counts));
}

void loop() { /* as often as the model was exported for */
  uint32_t i, highest = 0;
  read_frame();
  tb_frame(&state, counts, pressures, status);
  for (i = 1; i < TB_TAXELS; ++i)
    if ((status[i] & TB_VALID) && pressures[i] > pressures[highest]) highest = i;
  Serial.print((unsigned long)highest);
  Serial.print(' ');
  Serial.println(TB_LOWEST + TB_PER_COUNT * pressures[highest], 3);
}

#else

#include <stdio.h>
#include <string.h>

/* 1: TB_TAXELS numbers, each after a comma. */
static int read_row(unsigned* numbers) {
  uint32_t i;
  for (i = 0; i < TB_TAXELS; ++i)
    if (scanf(",%u", &numbers[i]) != 1) return 0;
  return 1;
}

int main(void) {
  static unsigned own[TB_TAXELS], expected[TB_TAXELS], states[TB_TAXELS];
  char event[8];
  unsigned long samples = 0, differ = 0;
  uint32_t i;
  if (!tb_init(&state)) {
    printf("the tables are damaged\n");
    return 1;
  }
  while (scanf(" %7[a-z]", event) == 1) {
    if (!read_row(own) || !read_row(expected) || !read_row(states)) {
      printf("the vectors end within a row\n");
      return 1;
    }
    for (i = 0; i < TB_TAXELS; ++i) counts[i] = (uint16_t)own[i];
    if (strcmp(event, "tare") == 0) {
      (void)tb_tare(&state, counts);
      continue;
    }
    if (strcmp(event, "lost") == 0)
      tb_lost_frame(&state, pressures, status);
    else
      tb_frame(&state, counts, pressures, status);
    for (i = 0; i < TB_TAXELS; ++i, ++samples)
      if (pressures[i] != expected[i] || status[i] != states[i]) ++differ;
  }
  printf("%lu readings, %lu differ\n", samples, differ);
  return samples > 0 && differ == 0 ? 0 : 1;
}

#endif
