/* The compensator for C, and for languages that can call C (python/tactbench_compensator.py). Link or load
 * libtactbench_compensator.so.1; plain C99, no other header of the project.
 *
 * - Nothing is thrown, nothing is printed. Every function returns TB_COMPENSATOR_OK (0) or a negative code. After an
 * error the state is unchanged.
 * - With ELAM, Preisach's model and the dynamic model (the default of `tactbench fit`) all memory is allocated while
 * loading: compensating a frame neither allocates nor calls the system. With other models a frame may allocate.
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
  TB_COMPENSATOR_NULL = -1,  /* a pointer is null that must not be */
  TB_COMPENSATOR_SIZE = -2,  /* a count differs from the number of taxels */
  TB_COMPENSATOR_VALUE = -3, /* an invalid document, see the message; or a negative or infinite time */
  TB_COMPENSATOR_TIME = -4,  /* the model compensates lag and creep, and the time since the previous frame is NaN */
  TB_COMPENSATOR_MEMORY = -5,
  TB_COMPENSATOR_FILE = -6 /* cannot be read */
};

/* Status bits of a taxel in a frame. */
enum tb_compensator_status {
  TB_TAXEL_VALID = 1,        /* computed from this frame's sample, within the model's range and validity */
  TB_TAXEL_FLAT = 2,         /* small slope: a small output change means much pressure, see the uncertainty */
  TB_TAXEL_OUT_OF_RANGE = 4, /* an impossible output: pressure of the loop's end, or the last pressure repeated. Not
                                valid, its uncertainty is meaningless */
  TB_TAXEL_DEAD = 8,         /* without a model: lowest pressure, uncertainty the whole span */
  TB_TAXEL_OUTSIDE = 16,     /* conditions outside the model's validity, as set by the caller: not valid */
  TB_TAXEL_UNKNOWN = 32,     /* history not known yet: pressure midway between its extremes, see the uncertainty */
  TB_TAXEL_LOST = 64         /* no sample: the last pressure repeated, not valid */
};

typedef struct tb_compensator tb_compensator;

TB_COMPENSATOR_API uint32_t tb_compensator_abi_version(void);

/* Loads the model in `file`, written by `tactbench fit -o` or `tactbench model export`, or from its text: any model of
 * a whole array. The histories are unknown until a function below sets them. scans: number averaged in each frame
 * passed in; 0: as in the fitted frames; fewer scans have more noise. `message` (may be null) gets a text of at most
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
