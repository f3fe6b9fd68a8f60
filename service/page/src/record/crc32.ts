// CRC-32 (ISO-HDLC, as in zip and MCAP), four bytes at a time: kTables[k][b] is the byte b followed by k zero bytes.
const kTables = tables();

function tables(): Uint32Array[] {
  const result = [0, 1, 2, 3].map(() => new Uint32Array(256));
  for (let b = 0; b < 256; ++b) {
    let crc = b;
    for (let bit = 0; bit < 8; ++bit) crc = crc & 1 ? (crc >>> 1) ^ 0xedb88320 : crc >>> 1;
    result[0]![b] = crc;
  }
  for (let k = 1; k < 4; ++k) {
    for (let b = 0; b < 256; ++b) {
      const crc = result[k - 1]![b]!;
      result[k]![b] = (crc >>> 8) ^ result[0]![crc & 0xff]!;
    }
  }
  return result;
}

// `before`: the CRC of the bytes before these, so that crc32(b, crc32(a)) is that of a and b together.
export function crc32(bytes: Uint8Array, before = 0): number {
  const [t0, t1, t2, t3] = kTables as [Uint32Array, Uint32Array, Uint32Array, Uint32Array];
  const whole = bytes.length & ~3;
  let crc = ~before;
  let i = 0;
  for (; i < whole; i += 4) {
    crc ^= bytes[i]! | (bytes[i + 1]! << 8) | (bytes[i + 2]! << 16) | (bytes[i + 3]! << 24);
    crc = t3[crc & 0xff]! ^ t2[(crc >>> 8) & 0xff]! ^ t1[(crc >>> 16) & 0xff]! ^ t0[crc >>> 24]!;
  }
  for (; i < bytes.length; ++i) crc = (crc >>> 8) ^ t0[(crc ^ bytes[i]!) & 0xff]!;
  return ~crc >>> 0;
}
