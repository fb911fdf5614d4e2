// All that an HDF5 file of a run is told, in order.
#include <catch2/catch.hpp>
#include <string>

#include "bench/cli/export/run_export.h"
#include "tests/bench/cli/export/told_file.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

constexpr const char* kAllOfTheRun = R"told(
/@schema 'tactbench.run'
/@version 2
/@run 1
/@uuid '01234567-89ab-4def-8123-456789abcdef'
/@origin 'simulated'
/@state 'ended'
/@outcome 'completed'
/@reason 'all steps done'
/@safe_state 'verified'
/@operator 'N. Nobody'
/@purpose 'to see'
/@sensor 'S-1'
/@sensor_type_sha256 'd60f7974aef41ca213ce364c4258ab570c045206ca952fd0592f53f6f15f9398'
/@scanner 'SC-7'
/@bench 'bench-a'
/@bench_sha256 '09874923863e91e8fe19c839ee5033472461653e86a334686ef2e811254eff21'
/@seed 7
/@sensor_seed -8
/@started_utc '2024-05-01T09:00:00Z'
/@ended_utc '2026-01-01T00:00:00Z'
/@host 'host-a'
/@time_zone 'CET'
/@program_version '0.1.0'
/@git_commit '0123abc'
/@git_dirty 1
/@build_id 'Release, GNU'
/@content_sha256 'HASH'
/@void 0
/@void_reason ''
/@void_by ''
/@void_utc ''
/@tags 'lot=A7 night'
/@rest_s nan real
group /configuration
text /configuration/bench_toml bench file
text /configuration/sensor_toml sensor file
text /configuration/overrides_json [{"key":"a","value":"1"}]
text /configuration/notes the door was open
group /recipes
group /recipes/0
/recipes/0@name 'up'
/recipes/0@sha256 'ra'
/recipes/0@repeats 2
/recipes/0@frames_per_repeat 3
text /recipes/0/toml recipe a
group /recipes/1
/recipes/1@name 'down'
/recipes/1@sha256 'rb'
/recipes/1@repeats 1
/recipes/1@frames_per_repeat 4
text /recipes/1/toml recipe b
group /devices
group /devices/0
/devices/0@role 'regulator'
/devices/0@model 'R-1'
/devices/0@serial '0001'
/devices/0@firmware '1.0'
/devices/0@origin 'simulated'
/devices/0@certificate ''
/devices/0@calibrated_by ''
/devices/0@calibrated ''
/devices/0@due ''
/devices/0@overdue 0
/devices/0@uncertainty ''
/devices/0@remarks ''
text /devices/0/calibration_json {"span":1}
group /devices/1
/devices/1@role 'tactile scanner'
/devices/1@model 'T-1'
/devices/1@serial 'SC-7'
/devices/1@firmware '2.0'
/devices/1@origin 'simulated'
/devices/1@certificate ''
/devices/1@calibrated_by ''
/devices/1@calibrated ''
/devices/1@due ''
/devices/1@overdue 0
/devices/1@uncertainty ''
/devices/1@remarks ''
text /devices/1/calibration_json {"volts_per_count":0.1}
group /frames
axis /frames/frame 0..2
integers /frames/branch [] 0, 1
axes /frames/branch frame
/frames/branch@long_name 'row of /branches'
integers /frames/step [] 0, 1
axes /frames/step frame
reals /frames/setpoint_psi [psi] () 0, 2
axes /frames/setpoint_psi frame
reals /frames/feedback_psi [psi] () 0.1, 2.1
axes /frames/feedback_psi frame
reals /frames/reference_psi [psi] () 0.3333333333333333, 0.25
axes /frames/reference_psi frame
integers /frames/setpoint_counts [count] 100, 101
axes /frames/setpoint_counts frame
integers /frames/feedback_counts [count] -200, -201
axes /frames/feedback_counts frame
integers /frames/reference_counts [count] 300, 301
axes /frames/reference_counts frame
integers /frames/time_ns [ns] 2000000000000, 2000000000001
axes /frames/time_ns frame
integers /frames/since_command_ns [ns] 2000000001, 21
axes /frames/since_command_ns frame
integers /frames/in_band_ns [ns] 1500000002, 22
axes /frames/in_band_ns frame
integers /frames/device_time_us [us] 5000000000003, 23
axes /frames/device_time_us frame
integers /frames/status [] 4, 5
axes /frames/status frame
integers /frames/exchanges [] 11, 12
axes /frames/exchanges frame
texts /frames/flags dwell | late
axes /frames/flags frame
axis /frames/scan 0..1
axis /frames/row 0..3
axis /frames/column 0..2
counts /frames/counts [count] (2x1x3x2) 1, 2, 3, 4, 5, 6, 11, 12, 13, 14, 15, 65535
axes /frames/counts frame, scan, row, column
/frames/counts@volts_per_count 0.1 real
reals /frames/target_n [N] () nan, 6.1
axes /frames/target_n frame
reals /frames/force_start_n [N] () nan, 6.3
axes /frames/force_start_n frame
axis /frames/component fx_n, fy_n, fz_n, tx_nmm, ty_nmm, tz_nmm
axis /frames/direction x, y, z
reals /frames/wrench [] (2x6) nan, nan, nan, nan, nan, nan, 0.1, 0.2, -6.2, 1.5, 2.5, 3.5
axes /frames/wrench frame, component
reals /frames/wrench_raw [] (2x6) nan, nan, nan, nan, nan, nan, 11, 12, 13, 14, 15, 16.5
axis /frames/channel 0..6
axes /frames/wrench_raw frame, channel
reals /frames/place_mm [mm] (2x3) nan, nan, nan, 20.1, 30.2, 41.3
axes /frames/place_mm frame, direction
group /trace
axis /trace/poll 0..3
integers /trace/frame [] 0, 1, 1
axes /trace/frame poll
/trace/frame@long_name 'row of /frames'
reals /trace/before_frame_s [s] () 1.5, 0.5, 0.25
axes /trace/before_frame_s poll
reals /trace/setpoint_psi [psi] () 2, 3, 4
axes /trace/setpoint_psi poll
reals /trace/feedback_psi [psi] () 2.25, 3.25, 4.25
axes /trace/feedback_psi poll
reals /trace/reference_psi [psi] () 2.5, 3.5, 4.5
axes /trace/reference_psi poll
group /branches
axis /branches/branch 0..2
integers /branches/sequence [] 1, 0
axes /branches/sequence branch
integers /branches/repeat [] 0, 1
axes /branches/repeat branch
integers /branches/ordinal [] 0, 2
axes /branches/ordinal branch
integers /branches/attempt [] 0, 3
axes /branches/attempt branch
integers /branches/void [] 1, 0
axes /branches/void branch
texts /branches/void_reason scanner lost | 
axes /branches/void_reason branch
reals /branches/from_psi [psi] () 0.1, 60
axes /branches/from_psi branch
reals /branches/to_psi [psi] () 60, 0.5
axes /branches/to_psi branch
reals /branches/from_n [N] () 2.1, nan
axes /branches/from_n branch
reals /branches/to_n [N] () 30.3, nan
axes /branches/to_n branch
group /events
axis /events/event 0..1
integers /events/time_ns [ns] 6
axes /events/time_ns event
texts /events/kind fault
axes /events/kind event
texts /events/id TB-SCANNER-SILENT
axes /events/id event
texts /events/detail no report
axes /events/detail event
group /checks
axis /checks/check 0..1
integers /checks/time_ns [ns] 4
axes /checks/time_ns check
texts /checks/kind seating
axes /checks/kind check
texts /checks/verdict pass
axes /checks/verdict check
texts /checks/detail_json {"rows":3}
axes /checks/detail_json check
group /verdicts
axis /verdicts/judgement 0..1
texts /verdicts/criterion unfit_taxels
axes /verdicts/criterion judgement
texts /verdicts/scope array
axes /verdicts/scope judgement
reals /verdicts/value [] () 1
axes /verdicts/value judgement
reals /verdicts/limit [] () 1.5
axes /verdicts/limit judgement
texts /verdicts/unit taxels
axes /verdicts/unit judgement
texts /verdicts/rule simple
axes /verdicts/rule judgement
texts /verdicts/verdict pass
axes /verdicts/verdict judgement
texts /verdicts/limits_sha256 sha
axes /verdicts/limits_sha256 judgement
group /series
group /series/0
/series/0@sequence 0
/series/0@taxel 3
axis /series/0/sample 0..2
reals /series/0/input [] () 0.5, 1.5
reals /series/0/output [] () 2.5, 3.5
axes /series/0/input sample
axes /series/0/output sample
group /series/1
/series/1@sequence 1
/series/1@taxel 2
axis /series/1/sample 0..1
reals /series/1/input [] () 0.25
reals /series/1/output [] () 4.5
axes /series/1/input sample
axes /series/1/output sample
/@NX_class 'NXroot'
/@default 'entry'
group /entry
/entry@NX_class 'NXentry'
/entry@default 'data'
/entry@origin 'simulated'
text /entry/title SIMULATED DATA: run 1 of sensor S-1: to see
text /entry/entry_identifier_uuid 01234567-89ab-4def-8123-456789abcdef
text /entry/start_time 2024-05-01T09:00:00Z
text /entry/end_time 2026-01-01T00:00:00Z
text /entry/program_name tactbench
/entry/program_name@version '0.1.0'
group /entry/user
/entry/user@NX_class 'NXuser'
text /entry/user/name N. Nobody
group /entry/sample
/entry/sample@NX_class 'NXsample'
text /entry/sample/name S-1
group /entry/instrument
/entry/instrument@NX_class 'NXinstrument'
text /entry/instrument/name bench-a
group /entry/instrument/regulator_0
/entry/instrument/regulator_0@NX_class 'NXsensor'
text /entry/instrument/regulator_0/name regulator
text /entry/instrument/regulator_0/model R-1
text /entry/instrument/regulator_0/serial_number 0001
/entry/instrument/regulator_0@origin 'simulated'
text /entry/instrument/regulator_0/measurement pressure
link /entry/instrument/regulator_0/value = /frames/feedback_psi
group /entry/instrument/tactile_scanner_1
/entry/instrument/tactile_scanner_1@NX_class 'NXsensor'
text /entry/instrument/tactile_scanner_1/name tactile scanner
text /entry/instrument/tactile_scanner_1/model T-1
text /entry/instrument/tactile_scanner_1/serial_number SC-7
/entry/instrument/tactile_scanner_1@origin 'simulated'
text /entry/instrument/tactile_scanner_1/measurement voltage
link /entry/instrument/tactile_scanner_1/value = /frames/counts
/frames@NX_class 'NXdata'
/frames@signal 'counts'
/frames@axes frame, scan, row, column
/frames@target '/frames'
link /entry/data = /frames
)told";

}  // namespace

TEST_CASE("HDF5: every group, column, axis, unit and attribute of a run, by the letter") {
  const TemporaryFolder folder;
  db::RunStore store = db::RunStore::open(folder.path("runs.db"), db::Durability::kNormal);
  const db::RunRecord run = store.run(store_known_run(store));
  ToldFile file;
  bench::put_run(file, store, run);
  std::string expected = kAllOfTheRun;
  expected.replace(expected.find("HASH"), 4, run.content_sha256);
  CHECK("\n" + file.text() == expected);
}
