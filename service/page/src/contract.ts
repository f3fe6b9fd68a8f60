// Printed by build/release/bin/page_contract from the service's tables (service/monitor/page/channels.cc,
// bit_names.cc, firmware/wire/names.cc); the test PageContract.IsUpToDate compares. A name that is not here is
// an error of the compiler.
export type ChannelName =
  | 'tip_x_m'
  | 'tip_y_m'
  | 'tip_z_m'
  | 'gap_m'
  | 'q_w'
  | 'q_x'
  | 'q_y'
  | 'q_z'
  | 'velocity_x_m_s'
  | 'velocity_y_m_s'
  | 'velocity_z_m_s'
  | 'force_x_N'
  | 'force_y_N'
  | 'force_z_N'
  | 'gate'
  | 'current_x_A'
  | 'current_y_A'
  | 'current_z_A'
  | 'measured_x_A'
  | 'measured_y_A'
  | 'measured_z_A'
  | 'coil_x_C'
  | 'coil_y_C'
  | 'coil_z_C'
  | 'supply_V'
  | 'sigma_m'
  | 'cov_xx_m2'
  | 'cov_xy_m2'
  | 'cov_xz_m2'
  | 'cov_yy_m2'
  | 'cov_yz_m2'
  | 'cov_zz_m2'
  | 'fit_chi2'
  | 'fit_dof'
  | 'model_error'
  | 'field_T'
  | 'ambient_x_T'
  | 'ambient_y_T'
  | 'ambient_z_T'
  | 'stray_T'
  | 'tick_us'
  | 'latency_us'
  | 'contacts'
  | 'tick_faults'
  | 'device_faults'
  | 'tool_limits'
  | 'sensors_left_out'
  | 'flags';
export type FlagName =
  | 'pose_valid'
  | 'tracked'
  | 'contact'
  | 'joystick'
  | 'aligned'
  | 'pushed'
  | 'saturated'
  | 'warm'
  | 'out_of_reach'
  | 'device_fault'
  | 'stiffness_limited'
  | 'holding'
  | 'softened'
  | 'waits';
// Of the channel "tick_faults".
export const kTickFault = {
  device: 1,
  tracking: 2,
  time: 4,
  not_finite: 8,
  commands_stale: 16,
} as const;
// Of the channel "tool_limits".
export const kToolLimit = {
  tilted: 1,
  coarse: 2,
  few_readings: 4,
  sensor_saturated: 8,
  contradicted: 16,
  repeated: 32,
  frozen: 64,
} as const;
// Of the channel "device_faults".
export type DeviceFaultName =
  | 'not armed'
  | 'host silent'
  | 'over temperature'
  | 'over current'
  | 'driver fault'
  | 'supply low'
  | 'supply high'
  | 'power limit'
  | 'coil open'
  | 'coil short'
  | 'current off its model'
  | 'current sensor'
  | 'Hall sensor'
  | 'Hall sensor stuck'
  | 'Hall sensor jump'
  | 'fan stands'
  | 'emergency stop'
  | 'self-test'
  | 'watchdog'
  | 'internal';
