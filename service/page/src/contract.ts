// Printed by build/release/bin/page_contract from the service's tables (service/monitor/page/channels.cc,
// bit_names.cc, page_layout.h, firmware/wire/names.cc); the test PageContract.IsUpToDate compares. A name that
// is not here is an error of the compiler.
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
// Binary messages, field after field: a number; an array [element, number of elements: the product of what
// follows, none: to the end]; an object; objects [how many, object].
export const kMagic = 1196445007;
export const kKind = {
  live: 1,
  shape: 2,
  surface: 3,
  file: 4,
  drop: 16,
} as const;
export const kLayout = {
  head: {
    magic: 'u32',
    kind: 'u16',
    version: 'u16',
  },
  live: {
    magic: 'u32',
    kind: 'u16',
    version: 'u16',
    count: 'u32',
    channels: 'u32',
    flags: 'u32',
    lost: 'u32',
    t_s: 'f64',
    contact_count: 'u32',
    has_vehicle: 'u32',
    contacts: [4, {
      object: 'u32',
      material: 'u32',
      point: ['f32', 3],
      normal: ['f32', 3],
      force: ['f32', 3],
      slip: ['f32', 3],
      normal_N: 'f32',
      tangential_N: 'f32',
      penetration_m: 'f32',
    }],
    vehicle: {
      sliding: 'u32',
      laps: 'u32',
      hits: 'u32',
      position: ['f32', 3],
      heading: 'f32',
      speed_m_s: 'f32',
      lap_s: 'f32',
      last_lap_s: 'f32',
      best_lap_s: 'f32',
    },
    inputs: [9, {
      value: 'f32',
      presses: 'u32',
      releases: 'u32',
    }],
    aim: {
      present: 'u32',
      tip: ['f32', 3],
      axis: ['f32', 3],
    },
    zero: 'u32',
    times_s: ['f64', 'count'],
    samples: ['f32', 'count', 'channels'],
  },
  shape: {
    magic: 'u32',
    kind: 'u16',
    version: 'u16',
    scene: 'u32',
    part: 'u32',
    vertex_count: 'u32',
    triangle_count: 'u32',
    coloured: 'u32',
    colour: ['f32', 3],
    roughness: 'f32',
    positions: ['f32', 'vertex_count', 3],
    normals: ['f32', 'vertex_count', 3],
    triangles: ['u32', 'triangle_count', 3],
    colours: ['u8', 'coloured', 'vertex_count', 4],
  },
  surface: {
    magic: 'u32',
    kind: 'u16',
    version: 'u16',
    scene: 'u32',
    object: 'u32',
    vertex_count: 'u32',
    triangle_count: 'u32',
    rotation: ['f32', 4],
    translation: ['f32', 3],
    largest_displacement_m: 'f32',
    positions: ['f32', 'vertex_count', 3],
    triangles: ['u32', 'triangle_count', 3],
  },
  file: {
    magic: 'u32',
    kind: 'u16',
    version: 'u16',
    number: 'u32',
    name_bytes: 'u32',
    name: ['u8', 'name_bytes'],
    bytes: ['u8'],
  },
  drop: {
    magic: 'u32',
    kind: 'u16',
    version: 'u16',
    name_bytes: 'u32',
    name: ['u8', 'name_bytes'],
    bytes: ['u8'],
  },
} as const;
