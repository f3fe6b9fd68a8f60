// Still pictures of one size -> one animated PNG (https://wiki.mozilla.org/APNG_Specification). Of each further picture
// only the pixels that change are kept, the others are transparent; colours are rounded to 6 bits, so that the noise of
// smooth surfaces is no change. Every picture is a PNG as Chromium writes it: 8 bits, RGB or RGBA, not interlaced.
import { deflateSync, inflateSync } from 'node:zlib';
import { load } from './setup.mjs';

const kSignature = Buffer.from([0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a]);

const { crc32 } = await load('record/crc32.ts');

function chunk(type, data) {
  const named = Buffer.concat([Buffer.from(type, 'latin1'), data]);
  const out = Buffer.alloc(named.length + 8);
  out.writeUInt32BE(data.length, 0);
  named.copy(out, 4);
  out.writeUInt32BE(crc32(named), named.length + 4);
  return out;
}

function chunks(png) {
  const found = [];
  for (let at = kSignature.length; at < png.length; ) {
    const length = png.readUInt32BE(at);
    found.push({ type: png.toString('latin1', at + 4, at + 8), data: png.subarray(at + 8, at + 8 + length) });
    at += 12 + length;
  }
  return found;
}

function paeth(a, b, c) {
  const p = a + b - c;
  const [pa, pb, pc] = [Math.abs(p - a), Math.abs(p - b), Math.abs(p - c)];
  return pa <= pb && pa <= pc ? a : pb <= pc ? b : c;
}

// RGB, three bytes a pixel, rounded to 6 bits.
function decode(png) {
  const parts = chunks(png);
  const header = parts.find(({ type }) => type === 'IHDR').data;
  const [width, height, depth, colour] = [header.readUInt32BE(0), header.readUInt32BE(4), header[8], header[9]];
  if (depth !== 8 || (colour !== 2 && colour !== 6) || header[12] !== 0) throw new Error('not a PNG of Chromium');
  const channels = colour === 6 ? 4 : 3;
  const data = inflateSync(Buffer.concat(parts.filter(({ type }) => type === 'IDAT').map((part) => part.data)));
  const stride = width * channels;
  const line = new Uint8Array(stride);
  const pixels = new Uint8Array(3 * width * height);
  for (let y = 0; y < height; ++y) {
    const filter = data[y * (stride + 1)];
    const above = line.slice();
    for (let i = 0; i < stride; ++i) {
      const left = i < channels ? 0 : line[i - channels];
      const up = y === 0 ? 0 : above[i];
      const upLeft = i < channels || y === 0 ? 0 : above[i - channels];
      const guess = [0, left, up, (left + up) >> 1, paeth(left, up, upLeft)][filter];
      line[i] = data[y * (stride + 1) + 1 + i] + guess;
    }
    for (let x = 0; x < width; ++x) {
      for (let k = 0; k < 3; ++k) pixels[3 * (y * width + x) + k] = line[x * channels + k] & 0xfc;
    }
  }
  return { width, height, pixels };
}

// RGBA; transparent where it equals `before`.
function encode({ width, height, pixels }, before) {
  const out = Buffer.alloc(height * (4 * width + 1));
  for (let y = 0; y < height; ++y) {
    for (let x = 0; x < width; ++x) {
      const from = 3 * (y * width + x);
      if (before && [0, 1, 2].every((k) => before.pixels[from + k] === pixels[from + k])) continue;
      const to = y * (4 * width + 1) + 1 + 4 * x;
      for (let k = 0; k < 3; ++k) out[to + k] = pixels[from + k];
      out[to + 3] = 255;
    }
  }
  return deflateSync(out, { level: 9 });
}

// `pictures`: buffers. Repeats for ever.
export function animate(pictures, frame_ms) {
  const header = Buffer.alloc(13);
  const control = Buffer.alloc(8);
  control.writeUInt32BE(pictures.length, 0);
  const frames = [];
  let sequence = 0;
  let before;
  for (const picture of pictures) {
    const now = decode(picture);
    const frame = Buffer.alloc(26);
    frame.writeUInt32BE(sequence++, 0);
    frame.writeUInt32BE(now.width, 4);
    frame.writeUInt32BE(now.height, 8);
    frame.writeUInt16BE(frame_ms, 20);
    frame.writeUInt16BE(1000, 22);
    frame[25] = before ? 1 : 0; // over the picture before; the first one replaces
    frames.push(chunk('fcTL', frame));
    if (before) {
      const number = Buffer.alloc(4);
      number.writeUInt32BE(sequence++, 0);
      frames.push(chunk('fdAT', Buffer.concat([number, encode(now, before)])));
    } else {
      header.writeUInt32BE(now.width, 0);
      header.writeUInt32BE(now.height, 4);
      header.set([8, 6, 0, 0, 0], 8);
      frames.push(chunk('IDAT', encode(now)));
    }
    before = now;
  }
  return Buffer.concat([
    kSignature, chunk('IHDR', header), chunk('acTL', control), ...frames, chunk('IEND', Buffer.alloc(0)),
  ]);
}
