/* The frame compensator for C, and for languages that can call C (python/tactbench_compensator.py). Link or load
 * libtactbench_compensator.so.1; plain C99, no other header of the project.
 *
 * Frozen contract of ABI version 1:
 * - Functions and struct members are added at ends only, never changed or taken away; status bits likewise. The library
 *   takes any struct_size that it knows: fill structs with zeros, set struct_size = sizeof of your own, then the
 *   members. Zero (and a null array) means "default" where a member states one.
 * - Nothing is thrown, nothing is printed. Every function returns TB_COMPENSATOR_OK (0) or a negative code; what was
 *   refused in tb_compensator_create is in `message`. After a refusal the state is as before.
 * - All memory is taken in tb_compensator_create. No other function allocates, locks or calls the system.
 * - One handle belongs to one thread at a time; different handles are independent.
 * - tb_compensator_destroy(NULL) does nothing. A handle that was destroyed must not be used again, and not be destroyed
 *   again: set the variable to NULL, then a second call is harmless.
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
  TB_COMPENSATOR_NULL = -1,      /* a pointer that must not be null is */
  TB_COMPENSATOR_SIZE = -2,      /* a struct_size is below version 1's or above 64 kB, or a count is not the taxels' */
  TB_COMPENSATOR_VALUE = -3,     /* see the message */
  TB_COMPENSATOR_PRECISION = -4, /* a call for doubles with a float32 handle, or the reverse */
  TB_COMPENSATOR_MEMORY = -5
};

/* Status bits of a taxel in a frame. */
enum tb_compensator_status {
  TB_TAXEL_VALID = 1,        /* computed from this frame's sample, within the model's range and validity */
  TB_TAXEL_FLAT = 2,         /* much pressure hides behind little output here: see the uncertainty */
  TB_TAXEL_OUT_OF_RANGE = 4, /* outside the external loop: pressure clamped, not valid, no uncertainty */
  TB_TAXEL_DEAD = 8,         /* not usable by set-up: lowest pressure, uncertainty the whole span */
  TB_TAXEL_OUTSIDE = 16,     /* conditions outside the model's validity, as set by the caller: not valid */
  TB_TAXEL_UNKNOWN = 32,     /* history not known yet: midway between its extremes, see the uncertainty */
  TB_TAXEL_LOST = 64         /* no sample: the last pressure again, not valid */
};

enum tb_compensator_flags {
  TB_COMPENSATOR_DOUBLE = 1,        /* double results (else float32, the fast one) */
  TB_COMPENSATOR_START_AT_REST = 2, /* all taxels are unloaded at the start (else their history is unknown) */
  TB_COMPENSATOR_EXACT_OUTER = 4    /* as the model was identified: external branches follow the patterns */
};

enum tb_compensator_taxel_flags {
  TB_TAXEL_USABLE = 1, /* else dead, stuck, unfit: the other members are not read */
  TB_TAXEL_FALLING = 2 /* the output falls when the pressure rises; patterns are those of the negated output */
};

typedef struct tb_compensator tb_compensator;

typedef struct tb_compensator_setup {
  size_t struct_size;
  uint32_t flags;       /* tb_compensator_flags */
  uint32_t longest_gap; /* frames lost in a row after which histories are unknown; 0: 10 */
  size_t taxels;
  size_t knots;           /* of each pattern, at least 2 */
  const double* pressure; /* knots, strictly increasing; any unit, results have the same */
  double volts_per_count;
  double flat_pressure;  /* flat when 4 sigma of noise hide more than this; 0: 2 */
  double known_pressure; /* a history is known when its extremes are so close; 0: 0.5 */
  double tare_share;     /* of a taxel's span, the most that a tare may move; 0: 0.2 */
  /* Intervals of the taxels' residuals, at most 1000. 0, or a struct_size that ends before: no residuals are read. */
  size_t residual_levels;
} tb_compensator_setup;

typedef struct tb_compensator_taxel {
  size_t struct_size;      /* of this struct; also the step from one array element to the next */
  uint32_t flags;          /* tb_compensator_taxel_flags */
  uint32_t reserved;       /* 0 */
  const double* ascending; /* knots volts; made monotone where they are not; ends equal to those of descending */
  const double* descending;
  double alpha_d, beta_d, alpha_a1, alpha_a0, beta_a; /* ELAM, alpha_a1 in 1 / pressure */
  double noise_volts;                                 /* standard deviation of a sample */
  /* What the model leaves, rms, by residual_levels equal intervals of the pressures, rising and then falling: twice as
   * many numbers, none negative. Null, or a struct_size that ends before: not known, the uncertainty is noise alone. */
  const double* residual;
} tb_compensator_taxel;

TB_COMPENSATOR_API uint32_t tb_compensator_abi_version(void);

/* TB_COMPENSATOR_VALUE also for what single precision cannot go on with: pressures beyond 1e9 or less than 1e-9 apart,
 * a full output not within 1e-3 and 1e12 of the noise (at least a count's rounding), a zero beyond 1e12 counts. Copies
 * all that it needs. `message` (may be null) gets a text of at most message_size bytes with its final 0, empty when all
 * is well. */
TB_COMPENSATOR_API int tb_compensator_create(const tb_compensator_setup* setup, const tb_compensator_taxel* taxels,
                                             tb_compensator** handle, char* message, size_t message_size);
TB_COMPENSATOR_API void tb_compensator_destroy(tb_compensator* handle);
TB_COMPENSATOR_API size_t tb_compensator_taxels(const tb_compensator* handle); /* 0 for null */

/* One frame of `count` taxels; arrays of as many. uncertainty (standard) and status may be null. */
TB_COMPENSATOR_API int tb_compensator_counts(tb_compensator* handle, const uint16_t* counts, size_t count,
                                             float* pressure, float* uncertainty, uint16_t* status);
TB_COMPENSATOR_API int tb_compensator_counts_double(tb_compensator* handle, const uint16_t* counts, size_t count,
                                                    double* pressure, double* uncertainty, uint16_t* status);
/* The same from volts; a voltage that is not a finite number, or beyond 1e12 counts, marks its taxel TB_TAXEL_LOST and
 * leaves its state alone. */
TB_COMPENSATOR_API int tb_compensator_volts(tb_compensator* handle, const float* volts, size_t count, float* pressure,
                                            float* uncertainty, uint16_t* status);
TB_COMPENSATOR_API int tb_compensator_volts_double(tb_compensator* handle, const double* volts, size_t count,
                                                   double* pressure, double* uncertainty, uint16_t* status);
/* A frame was lost: the next one is taken as it comes, and after longest_gap losses in a row histories are unknown. */
TB_COMPENSATOR_API int tb_compensator_lost_frame(tb_compensator* handle);

TB_COMPENSATOR_API int tb_compensator_reset(tb_compensator* handle);         /* all at rest, unloaded */
TB_COMPENSATOR_API int tb_compensator_reset_unknown(tb_compensator* handle); /* from anywhere */
/* `counts` is the unloaded sensor: becomes the zero, all at rest. *refused (may be null): taxels that were too far off;
 * they keep their zero and start unknown. */
TB_COMPENSATOR_API int tb_compensator_tare(tb_compensator* handle, const uint16_t* counts, size_t count,
                                           size_t* refused);
TB_COMPENSATOR_API int tb_compensator_set_outside_validity(tb_compensator* handle, int outside);

/* The dynamic Preisach model: Preisach on the linearised output, creep and lag undone. The handle works with all the
 * functions above, and is to be told the time between frames. Added in version 1; found by its symbols. */
typedef struct tb_dynamic_setup {
  size_t struct_size;
  uint32_t flags;       /* tb_compensator_flags; TB_COMPENSATOR_EXACT_OUTER has no meaning here */
  uint32_t longest_gap; /* as tb_compensator_setup's */
  size_t taxels;
  size_t intervals; /* n: of the pressure range in each table, 1 to 100 */
  double pressure_low, pressure_high;
  double volts_per_count;
  double flat_pressure, known_pressure, tare_share; /* as tb_compensator_setup's */
  double creep_seconds[3], creep_share[3];          /* shares 0: no creep; then seconds may be 0 */
  double creep_half;                                /* pressure at which creep is half of its most; 0: 10 */
  double lag_seconds;                               /* 0: 1 */
  double top_share; /* of the full output: what a turn may lie below the top and set the gain; 0: 0.02, below 0: off */
  const double* residual; /* 2 n: what the model leaves, rms, by interval, rising and then falling; null: not known */
  /* Seconds for which the pressure went over its range just before a start; 0: it rested for long. A struct_size that
   * ends before this member means 0. */
  double worked_seconds;
} tb_dynamic_setup;

typedef struct tb_dynamic_taxel {
  size_t struct_size;   /* of this struct; also the step from one array element to the next */
  uint32_t flags;       /* tb_compensator_taxel_flags */
  uint32_t reserved;    /* 0 */
  double zero_volts;    /* output without load; of a falling sensor the negated one, as the table */
  double per_amplitude; /* 1 / the divider's highest output in volts; 0: the output is taken as it is */
  /* (n + 1) (n + 2) / 2 linearised volts: the rise from grid point j to i at i (i + 1) / 2 + j. */
  const double* everett;
  double creep_scale;    /* of this taxel over the array's; 0: 1 (without creep set the shares 0) */
  double lag_share;      /* of the pressure that comes late */
  double noise_volts;    /* standard deviation of a sample */
  double residual_scale; /* of `residual`; 0: 1 */
} tb_dynamic_taxel;

TB_COMPENSATOR_API int tb_compensator_create_dynamic(const tb_dynamic_setup* setup, const tb_dynamic_taxel* taxels,
                                                     tb_compensator** handle, char* message, size_t message_size);
/* Seconds from one frame to the next, from now on; before the first call creep and lag rest. May change with each
 * frame. A handle of tb_compensator_create takes and ignores it. TB_COMPENSATOR_VALUE: negative or not finite. */
TB_COMPENSATOR_API int tb_compensator_set_interval(tb_compensator* handle, double seconds);

#ifdef __cplusplus
}
#endif

/* NOLINTEND(readability-identifier-naming,modernize-*) */
#endif
