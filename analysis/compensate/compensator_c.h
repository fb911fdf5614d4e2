/* The compensator for C, and for languages that can call C (python/tactbench_compensator.py). Link or load
 * libtactbench_compensator.so.1; plain C99, no other header of the project.
 *
 * - Nothing is thrown, nothing is printed. Every function returns TB_COMPENSATOR_OK (0) or a negative code. After a
 *   refusal the state is as before.
 * - All memory is taken while loading. A frame of ELAM or the dynamic model neither allocates nor calls the system.
 * - One handle belongs to one thread at a time; different handles are independent.
 * - tb_compensator_destroy(NULL) does nothing.
 */
#ifndef TACTBENCH_COMPENSATOR_C_H
#define TACTBENCH_COMPENSATOR_C_H

#include <stddef.h> /* NOLINT(modernize-deprecated-headers): C reads this */
#include <stdint.h> /* NOLINT(modernize-deprecated-headers) */

/* NOLINTBEGIN(readability-identifier-naming,modernize-*): C's names */
#if defined(__GNUC__)
#define TB_COMPENSATOR_API __attribute__((visibility("default")))
#else
#define TB_COMPENSATOR_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

#define TB_COMPENSATOR_ABI_VERSION 1U

enum tb_compensator_code {
  TB_COMPENSATOR_OK = 0,
  TB_COMPENSATOR_NULL = -1,  /* a pointer that must not be null is */
  TB_COMPENSATOR_SIZE = -2,  /* a count is not the taxels' */
  TB_COMPENSATOR_VALUE = -3, /* a document, see the message; or a time that is negative or infinite */
  TB_COMPENSATOR_TIME = -4,  /* the model undoes lag and creep, and the time since the frame before is NaN */
  TB_COMPENSATOR_MEMORY = -5,
  TB_COMPENSATOR_FILE = -6 /* cannot be read */
};

/* Status bits of a taxel in a frame. */
enum tb_compensator_status {
  TB_TAXEL_VALID = 1,        /* computed from this frame's sample, within the model's range and validity */
  TB_TAXEL_FLAT = 2,         /* much pressure hides behind little output here: see the uncertainty */
  TB_TAXEL_OUT_OF_RANGE = 4, /* an output that the taxel cannot give: the loop's end, or the last pressure again.
                                Not valid, its uncertainty means nothing */
  TB_TAXEL_DEAD = 8,         /* without a model: lowest pressure, uncertainty the whole span */
  TB_TAXEL_OUTSIDE = 16,     /* conditions outside the model's validity, as set by the caller: not valid */
  TB_TAXEL_UNKNOWN = 32,     /* history not known yet: midway between its extremes, see the uncertainty */
  TB_TAXEL_LOST = 64         /* no sample: the last pressure again, not valid */
};

typedef struct tb_compensator tb_compensator;

TB_COMPENSATOR_API uint32_t tb_compensator_abi_version(void);

/* The model in `file`, which `tactbench fit -o` or `tactbench model export` wrote, or its text: any model of a whole
 * array. Its histories are unknown until it is told otherwise. scans: how many are averaged into a frame that is given;
 * 0: as many as in those that were fitted; fewer have more noise. `message` (may be null) gets a text of at most
 * message_size bytes with its final 0, empty when all is well. */
TB_COMPENSATOR_API int tb_compensator_load(const char* file, unsigned scans, tb_compensator** handle, char* message,
                                           size_t message_size);
TB_COMPENSATOR_API int tb_compensator_parse(const char* text, unsigned scans, tb_compensator** handle, char* message,
                                            size_t message_size);
TB_COMPENSATOR_API void tb_compensator_destroy(tb_compensator* handle);
TB_COMPENSATOR_API size_t tb_compensator_taxels(const tb_compensator* handle); /* 0 for null */

/* One frame of `count` taxels in the output's unit of the model (volts), row by row, `seconds` after the one before;
 * the first after a start has none before. Arrays of as many; uncertainty (standard) and status may be null. An output
 * that is not a finite number marks its taxel TB_TAXEL_LOST. */
TB_COMPENSATOR_API int tb_compensator_frame(tb_compensator* handle, const float* outputs, size_t count, double seconds,
                                            float* pressure, float* uncertainty, uint16_t* status);
/* A frame was lost: the next one is taken as it comes, and after ten losses in a row histories are unknown. */
TB_COMPENSATOR_API int tb_compensator_lost_frame(tb_compensator* handle, double seconds);

/* All taxels are unloaded and at rest (at_rest not 0), or anywhere. worked_seconds: for how long the pressure went over
 * its range just before; 0: the film rested. Only models that undo creep look at it. */
TB_COMPENSATOR_API int tb_compensator_start(tb_compensator* handle, int at_rest, double worked_seconds);
/* `outputs` is the unloaded sensor: becomes the zero, all at rest. *refused (may be null): taxels that were off by more
 * than a fifth of their span; they keep their zero and start unknown. */
TB_COMPENSATOR_API int tb_compensator_tare(tb_compensator* handle, const float* outputs, size_t count, size_t* refused);
TB_COMPENSATOR_API int tb_compensator_set_outside_validity(tb_compensator* handle, int outside);

#ifdef __cplusplus
}
#endif

/* NOLINTEND(readability-identifier-naming,modernize-*) */
#endif
