/* Frames of a stored model, one a line of the input: seconds since the one before, then the volts of each taxel. */
#include <stdio.h>
#include <stdlib.h>

#include "analysis/compensate/compensator_c.h"

int main(int count, char** words) {
  tb_compensator* handle = NULL;
  char message[200];
  double seconds;
  size_t i;
  if (count != 2) return 2;
  if (tb_compensator_load(words[1], 0, &handle, message, sizeof message) != TB_COMPENSATOR_OK) {
    fprintf(stderr, "%s: %s\n", words[1], message);
    return 1;
  }
  size_t taxels = tb_compensator_taxels(handle);
  float* volts = malloc(3 * taxels * sizeof *volts);
  float *psi = volts + taxels, *uncertainty = psi + taxels;
  uint16_t* status = malloc(taxels * sizeof *status);
  tb_compensator_start(handle, 1, 70.0); /* unloaded; conditioned for 70 s just before */
  while (volts != NULL && status != NULL && scanf("%lf", &seconds) == 1) {
    for (i = 0; i < taxels; ++i)
      if (scanf("%f", &volts[i]) != 1) return 1;
    if (tb_compensator_frame(handle, volts, taxels, seconds, psi, uncertainty, status) != TB_COMPENSATOR_OK) return 1;
    for (i = 0; i < taxels; ++i) printf("%.2f %.2f %d ", psi[i], uncertainty[i], status[i]);
    printf("\n");
  }
  free(status);
  free(volts);
  tb_compensator_destroy(handle);
  return 0;
}
