#include "bench/cli/words/meanings/meanings.h"

namespace tactbench::bench {

KeyMeanings bench_meanings() {
  KeyMeanings all = {
      {"schema", "Version of this file's format"},
      {"bench.id", "Name of the bench; one run a bench at a time, and stored runs are grouped by it"},
      {"bench.location", "Where it stands; for reports"},
      {"bench.origin", "Whether data come from a simulated rig or from hardware; the two are never mixed"},
      {"bench.simulator",
       "Of a simulated bench: the simulation runs inside this program, or in tactbench simulate or another program"},
      {"bench.rate", "How many times faster than real time an external simulator runs"},

      {"limits.command_psi", "No set-point above this is ever sent"},
      {"limits.trip_psi", "A pressure measured above this aborts the run, vents the chamber and latches a trip"},
      {"limits.safe_psi", "The chamber counts as vented when two witnesses read less than this"},
      {"limits.disagreement_psi", "Feedback and reference may differ by at most this much ..."},
      {"limits.disagreement_s", "... for this long; then the run is aborted and the chamber vented"},
      {"limits.vent_timeout_s", "Longest time that venting may take before the safe state counts as not verified"},
      {"limits.rate_psi_per_s", "The set-point never rises faster than this"},
      {"limits.step_psi", "The set-point never rises by more than this at once"},
      {"limits.stale_s", "Readings of pressure older than this refuse more load"},
      {"limits.contact_n", "From this force on the object counts as touching, and x and y must stand still"},
      {"limits.clear_z_mm", "x and y move only while z is at or below this position"},
      {"limits.force_n",
       "Largest force on each axis [x, y, z]; beyond it the stage stops, backs off and a trip is latched. "
       "Left out: [5, 5, 35]"},

      {"dead_man.enabled",
       "Starts a second process that vents and retracts when the program dies or hangs; a bench that is simulated "
       "inside the program needs none"},
      {"dead_man.timeout_ms", "It acts when the program has given no sign of life for this long"},
      {"dead_man.progress_ms", "It acts when the program's work has made no progress for this long"},
      {"dead_man.back_off_mm", "How far it moves z back after stopping the stage"},
      {"dead_man.blind", "What a run does when the dead-man cannot reach the module twice in a row: end, or only warn"},

      {"settling.band_psi", "A level counts as reached when the feedback is within this distance of the set-point ..."},
      {"settling.slope_psi_per_s", "... and the reference changes more slowly than this; the dwell begins then"},
      {"settling.poll_s", "Time between two readings of pressure while a level settles; all are stored"},
      {"settling.trace_s", "Time between two readings of pressure during the dwell; 0: each time the module is fed"},
      {"settling.landing_s", "Rest before the last step of a ramp, so that it overshoots as little as a small step"},
      {"settling.timeout_s", "A level that has not settled after this time is an error (TB-CHAMBER-TIMEOUT)"},

      {"module.profile", "Analog module in front of the regulator: name of a shipped profile, or a file of yours"},
      {"module.watchdog_ms", "The module sets its outputs to 0 V when it is not written to for this long"},
      {"module.dump_coil",
       "Number of the digital output that holds a dump valve closed (without power it opens); -1: no such valve"},
      {"input_module.profile",
       "Module that reads feedback and reference, where the first has no inputs: name of a shipped profile, or a file"},
      {"*.outputs", "Number of output words in the module's process image, as its terminals make them"},
      {"*.inputs", "Number of input words in the module's process image"},
      {"*.transport", "Modbus over the network (tcp) or over a serial line (rtu)"},
      {"*.serial_port", "Serial line, for transport = \"rtu\": a device, best a name in /dev/serial/by-id"},
      {"*.baud", "Speed of the serial line"},
      {"*.parity", "Parity of the serial line: none, even or odd"},
      {"*.stop_bits", "Stop bits of the serial line"},
      {"*.max_reply_delay_ms",
       "The latest that an answer can still come on a serial line; after an error the line rests for this long"},
      {"*.host", "Address of the instrument in the network"},
      {"*.port", "Port of the instrument in the network; 0 on a simulated bench: any free one"},
      {"*.unit", "Modbus unit number; without a host or serial_port of its own, a unit on the module's line"},
      {"*.response_timeout_ms", "Longest time to wait for an answer"},

      {"regulator.model", "Maker and model, stored with each run"},
      {"regulator.serial", "Serial number, stored with each run"},
      {"regulator.output_channel", "Output of the module that carries the set-point, counted from 0"},
      {"regulator.feedback_channel",
       "Input of the module that carries the regulator's monitor voltage, counted from 0"},
      {"regulator.span_v", "Lowest and highest voltage of set-point and monitor ..."},
      {"regulator.span_bar", "... and the pressures that they mean"},
      {"regulator.feed_interval_ms",
       "The set-point is written again and read back this often; at most 0.6 of the module's watchdog_ms"},

      {"reference.independent",
       "Whether a transducer or gauge of its own measures the pressure; without one the regulator's monitor stands in, "
       "and reports say \"not independently traceable\""},
      {"reference.certificate", "Number of the calibration certificate; \"\": none"},
      {"reference.calibrated", "Date of the calibration, as \"2026-01-31\""},
      {"reference.due", "Last day that the calibration holds; later runs have no verdict on errors"},
      {"reference.expanded_uncertainty_psi",
       "Expanded uncertainty U of the certificate (k = 2); a correction brings its own"},
      {"reference.drift_psi", "Largest change until the due date, by its history or data sheet"},
      {"reference.resolution_psi", "Smallest step that it shows; 0: that of the converter that reads it"},
      {"reference.model", "Maker and model, stored with each run"},
      {"reference.serial", "Serial number, stored with each run"},
      {"reference.channel", "Input of the module that reads it, counted from 0; not the regulator's"},
      {"reference.span_v", "Lowest and highest voltage of its output ..."},
      {"reference.span_psi", "... and the pressures that they mean"},
      {"reference.correction_file",
       "File with a correction, as tactbench devices calibrate-reference writes it; instead of [reference.correction]"},
      {"reference.gauge.span_psi", "Pressures that the values of raw_span mean"},
      {"reference.correction.reading_psi", "Readings of the certificate's table, rising"},
      {"reference.correction.correction_psi", "What is added at each of these readings; between them a straight line"},
      {"reference.correction.expanded_uncertainty_psi", "Expanded uncertainty of the corrected value at each reading"},
      {"reference.correction.coverage_factor", "Coverage factor k of these uncertainties"},

      {"environment.sensor[].quantity", "What the sensor measures; stored at the start and the end of each run"},
      {"environment.sensor[].model", "Maker and model, stored with each run"},
      {"environment.sensor[].serial", "Serial number, stored with each run"},
      {"environment.sensor[].span_c", "Temperatures that the values of raw_span mean"},
      {"environment.sensor[].span_bar", "Supply pressures that the values of raw_span mean"},

      {"*.function", "Modbus function that reads it: 3 holding registers, 4 input registers"},
      {"*.address", "Address of its first register, counted from 0"},
      {"*.spare",
       "Registers behind it that may be read too; RTU readings then change length, which shows a stale answer"},
      {"*.type", "How the registers hold the number"},
      {"*.word_order", "Which of two registers comes first"},
      {"*.raw_span", "Two values of the register, which the physical span below translates"}};
  for (const KeyMeanings& more : {instrument_meanings(), simulation_meanings()})
    all.insert(all.end(), more.begin(), more.end());
  return all;
}

}  // namespace tactbench::bench
