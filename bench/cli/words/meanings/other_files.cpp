#include "bench/cli/words/meanings/meanings.h"

namespace tactbench::bench {

KeyMeanings sensor_meanings() {
  return {{"schema", "Version of this file's format"},
          {"name", "Name of the sensor type; on reports"},
          {"rows", "Rows of the array"},
          {"columns", "Columns of the array"},
          {"pitch_mm", "Distance of two neighbouring taxels"},
          {"taxel_area_mm2", "Effective area of one taxel, for forces"},
          {"orientation_deg", "Direction of row 0 against the bench's x axis"},
          {"output_range_v", "Lowest and highest voltage that the array can give"},
          {"full_scale", "What 100 % of full scale is, in figures that are given as a share of it"}};
}

KeyMeanings limits_meanings() {
  return {
      {"schema", "Version of this file's format"},
      {"name", "Name of these limits; on reports"},
      {"rule",
       "Decision rule (ILAC-G8:09/2019). simple: value <= limit; guarded: value <= limit - U; four-way: pass, "
       "conditional pass, conditional fail, fail; report-only: no verdict; default: four-way where U is known, else "
       "simple"},
      {"mean_compensation_error_psi", "Largest mean error |estimate - reference| over all fitted taxels and frames"},
      {"worst_taxel_error_psi", "Largest mean error of the worst taxel"},
      {"distance_of_mean_percent_fs", "Largest mean distance of the array's mean pressure between rise and fall"},
      {"unfit_taxels", "Largest number of dead, stuck, saturated or not modelled taxels"},
      {"mismatch[].pressure_psi", "Level at which the taxels are compared; it must be a level of the judged run"},
      {"mismatch[].std_percent_fs", "Largest standard deviation of the compensated pressure over the taxels there"},
      {"mpe[].pressure_psi", "Level for which the maximum permissible error counts; or span_psi"},
      {"mpe[].span_psi", "Lowest and highest pressure between which it counts; or pressure_psi"},
      {"mpe[].mpe_psi", "Maximum permissible error: |error| + U of one reading must stay within it"},
      {"mpe[].taxels_percent", "Share of the taxels that must stay within it"}};
}

KeyMeanings laboratory_meanings() {
  return {{"schema", "Version of this file's format"},
          {"laboratory", "Name of the laboratory"},
          {"address", "Address of the laboratory"},
          {"place", "Where the calibration was made, if elsewhere"},
          {"accreditation",
           "Number of the accreditation; only with one, and on real data, a report may call itself a certificate"},
          {"customer", "Name of the customer"},
          {"customer_address", "Address of the customer"},
          {"order", "Number of the order, the customer's or your own; a run's own --order precedes it"},
          {"received", "Date on which the sensor came"},
          {"condition", "Condition of the sensor when it came"},
          {"cable", "Cable between sensor and scanner: type, length, serial number"},
          {"mounting", "What lies on the sensor and below it"},
          {"medium", "What the pressure is made with, and its state"},
          {"environment", "Temperature and humidity, where no instrument of the bench measured them"},
          {"deviations", "Deviations from the method, beside those that the run recorded itself"},
          {"remarks", "Remarks of the laboratory, printed on the report"},
          {"instrument[].serial", "Serial number of the instrument that the other keys speak of"},
          {"instrument[].certificate", "Number of its calibration certificate"},
          {"instrument[].calibrated_by", "Who calibrated it"},
          {"instrument[].calibrated_on", "Date of the calibration"},
          {"instrument[].due", "Last day that the calibration holds; of two due dates the earlier one counts"},
          {"instrument[].note", "Remark on it"}};
}

KeyMeanings operator_meanings() {
  return {{"schema", "Version of this file's format"},
          {"bench", "Bench file, where no --bench is typed"},
          {"db", "Store, where no --db is typed"},
          {"operator", "Your name, where no --operator is typed"},
          {"recipe", "Recipe, where none is typed; several with commas between them"},
          {"limits", "Limits file by which calibrate judges, and fit with held-out runs"},
          {"fleet", "Database of the fleet, where a verb needs one and TACTBENCH_FLEET is not set"}};
}

KeyMeanings suite_meanings() {
  return {
      {"schema", "Version of this file's format"},
      {"name", "Name of the suite"},
      {"scenario[].name", "Name of the scenario: small letters, digits and hyphens; also a file's name"},
      {"scenario[].about", "What it shows, in a sentence"},
      {"scenario[].bench", "Bench file, which must be simulated"},
      {"scenario[].recipes", "Recipes of the run; none: descending and ascending"},
      {"scenario[].set", "Overrides of bench file and recipes, as --set of tactbench run"},
      {"scenario[].held_out", "A further run of the same sensor with these overrides, on which the models are judged"},
      {"scenario[].held_out_2", "One more such run; the worst verdict counts"},
      {"scenario[].void_held_out", "Declare the first held-out run void before anything is judged"},
      {"scenario[].own_run", "Hold the figures of the fit's own run against the limits: no verdict on the sensor"},
      {"scenario[].fits", "Whether the run is fitted and judged; false for recipes without a loop"},
      {"scenario[].limits", "Limits file of the verdicts"},
      {"scenario[].seed", "Seed of noise and faults"},
      {"scenario[].sensor_seed", "Seed of the array"},
      {"scenario[].outcome", "Expected end of the last run"},
      {"scenario[].error", "Expected error of the last run, as TB-...; \"\": none"},
      {"scenario[].safe", "Expected safe state after the last run"},
      {"scenario[].taxels.NAME",
       "Taxels (row x columns + column) expected as dead, stuck, saturated or not modelled: exactly these"},
      {"scenario[].verdicts.NAME", "Expected verdict of a criterion; overall: of all together"},
      {"scenario[].figures.NAME", "Lowest and highest value expected of a figure"}};
}

KeyMeanings profile_meanings() {
  return {
      {"schema", "Version of this file's format"},
      {"model", "Maker and model, printed and stored with each run"},
      {"transport", "Which Modbus it speaks: over the network, over a serial line, or either"},
      {"max_reply_delay_ms", "The latest that an answer can still come on a serial line"},
      {"outputs.function", "Modbus function that writes: 6 one register, 16 several, 23 several and reads the inputs"},
      {"outputs.address", "Register of output 0, counted from 0; one register an output"},
      {"outputs.channels", "Number of outputs"},
      {"outputs.readback_function", "Function that reads the outputs back after each write; 0: it cannot"},
      {"outputs.dead_band_counts", "What is read back may differ from what was written by this much"},
      {"outputs.deadline_ms", "For this long after a write it may differ by more; 0: never"},
      {"outputs.raw_span", "Two values of the register ..."},
      {"outputs.volts_span", "... and the voltages that they mean; 0 V must lie between"},
      {"inputs.function", "Modbus function that reads: 3 holding registers, 4 input registers"},
      {"inputs.address", "Register of input 0, counted from 0"},
      {"inputs.channels", "Number of inputs"},
      {"inputs.spare",
       "Registers behind the last input that may be read too; RTU readings then change length, which shows a stale "
       "answer"},
      {"inputs.type", "How the registers hold the number"},
      {"inputs.word_order", "Which of two registers comes first"},
      {"inputs.status_offset", "Registers from address to one status word an input; -1: none"},
      {"inputs.raw_span", "Two values of the register ..."},
      {"inputs.volts_span", "... and the voltages that they mean; 0 V must lie between"},
      {"fail_safe.watchdog_address", "First of the watchdog's registers, as Beckhoff lays them out; -1: none"},
      {"fail_safe.fallbacks_address", "Register that counts how often the watchdog acted; -1: none"},
      {"fail_safe.safe_mode_address", "First of the discrete inputs that tell an output's safe mode (Moxa); -1: none"},
      {"fail_safe.safe_mode_clear_address", "First of the coils that end the safe mode (Moxa); -1: none"},
      {"fail_safe.layer[].text", "What the module does by itself when writes stop; printed before each run"}};
}

}  // namespace tactbench::bench
