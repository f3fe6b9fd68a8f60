// What messages hold besides samples, packed into words: a few hundred bytes each instead of some thirty objects.
import type { Contact, Live, Vec3, Vehicle } from '../types';

export type State = Pick<Live, 'flags' | 'lost' | 'contacts' | 'vehicle' | 'inputs' | 'aim'>;

const kFirstWords = 1024;

// Reads words one after another.
class Words {
  constructor(
    private readonly integers: Uint32Array,
    private readonly floats: Float32Array,
    private at: number,
  ) {}
  integer(): number {
    return this.integers[this.at++]!;
  }
  float(): number {
    return this.floats[this.at++]!;
  }
  vec3(): Vec3 {
    return [this.float(), this.float(), this.float()];
  }
}

export class States {
  count = 0;
  private length = 0; // words in use
  private integers = new Uint32Array(kFirstWords);
  private floats = new Float32Array(this.integers.buffer); // the same memory
  private offsets = new Uint32Array(64); // of each state, in words

  get bytes(): number {
    return this.integers.byteLength + this.offsets.byteLength;
  }

  add(state: State): void {
    if (this.count === this.offsets.length) this.offsets = resized(this.offsets, 2 * this.count);
    this.offsets[this.count++] = this.length;
    this.integer(state.flags);
    this.integer(state.lost);
    this.integer(state.contacts.length);
    for (const contact of state.contacts) {
      this.integer(contact.object);
      this.integer(contact.material);
      for (const vector of [contact.point, contact.normal, contact.force, contact.slip]) this.vec3(vector);
      this.float(contact.normal_N);
      this.float(contact.tangential_N);
      this.float(contact.penetration_m);
    }
    this.integer(state.vehicle === null ? 0 : 1);
    if (state.vehicle !== null) this.addVehicle(state.vehicle);
    this.integer(state.inputs.length);
    for (const input of state.inputs) {
      this.float(input.value);
      this.integer(input.presses);
      this.integer(input.releases);
    }
    this.integer(state.aim.present ? 1 : 0);
    this.vec3(state.aim.tip);
    this.vec3(state.aim.axis);
  }

  get(index: number): State {
    const words = new Words(this.integers, this.floats, this.offsets[index]!);
    const flags = words.integer();
    const lost = words.integer();
    const contacts = Array.from({ length: words.integer() }, (): Contact => ({
      object: words.integer(),
      material: words.integer(),
      point: words.vec3(),
      normal: words.vec3(),
      force: words.vec3(),
      slip: words.vec3(),
      normal_N: words.float(),
      tangential_N: words.float(),
      penetration_m: words.float(),
    }));
    const vehicle = words.integer() !== 0 ? readVehicle(words) : null;
    const inputs = Array.from({ length: words.integer() }, () => ({
      value: words.float(),
      presses: words.integer(),
      releases: words.integer(),
    }));
    const aim = { present: words.integer() !== 0, tip: words.vec3(), axis: words.vec3() };
    return { flags, lost, contacts, vehicle, inputs, aim };
  }

  // Gives back the memory that is not used; nothing is added any more.
  trim(): void {
    this.resize(this.length);
    this.offsets = resized(this.offsets, this.count);
  }

  private addVehicle(vehicle: Vehicle): void {
    this.vec3(vehicle.position);
    this.float(vehicle.heading);
    this.float(vehicle.speed_m_s);
    this.integer(vehicle.sliding ? 1 : 0);
    this.integer(vehicle.laps);
    this.integer(vehicle.hits);
    this.float(vehicle.lap_s);
    this.float(vehicle.last_lap_s);
    this.float(vehicle.best_lap_s);
  }

  private integer(value: number): void {
    this.reserve();
    this.integers[this.length++] = value;
  }

  private float(value: number): void {
    this.reserve();
    this.floats[this.length++] = value;
  }

  private vec3(value: Vec3): void {
    for (const component of value) this.float(component);
  }

  private reserve(): void {
    if (this.length === this.integers.length) this.resize(2 * this.length);
  }

  private resize(words: number): void {
    this.integers = resized(this.integers, words);
    this.floats = new Float32Array(this.integers.buffer);
  }
}

function readVehicle(words: Words): Vehicle {
  return {
    position: words.vec3(),
    heading: words.float(),
    speed_m_s: words.float(),
    sliding: words.integer() !== 0,
    laps: words.integer(),
    hits: words.integer(),
    lap_s: words.float(),
    last_lap_s: words.float(),
    best_lap_s: words.float(),
  };
}

function resized(array: Uint32Array<ArrayBuffer>, length: number): Uint32Array<ArrayBuffer> {
  const result = new Uint32Array(length);
  result.set(array.subarray(0, Math.min(length, array.length)));
  return result;
}
