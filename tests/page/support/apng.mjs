// Still pictures of one size -> one animated PNG (https://wiki.mozilla.org/APNG_Specification): the image data of each
// further picture becomes a frame. Every picture is a PNG as Chromium writes it.
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

// `pictures`: buffers. Repeats for ever.
export function animate(pictures, frame_ms) {
  const header = chunks(pictures[0]).find(({ type }) => type === 'IHDR').data;
  const control = Buffer.alloc(8);
  control.writeUInt32BE(pictures.length, 0);
  const out = [kSignature, chunk('IHDR', header), chunk('acTL', control)];
  let sequence = 0;
  pictures.forEach((picture, i) => {
    const frame = Buffer.alloc(26);
    frame.writeUInt32BE(sequence++, 0);
    header.copy(frame, 4, 0, 8); // width, height
    frame.writeUInt16BE(frame_ms, 20);
    frame.writeUInt16BE(1000, 22);
    out.push(chunk('fcTL', frame));
    for (const { type, data } of chunks(picture)) {
      if (type !== 'IDAT') continue;
      if (i === 0) {
        out.push(chunk('IDAT', data));
        continue;
      }
      const number = Buffer.alloc(4);
      number.writeUInt32BE(sequence++, 0);
      out.push(chunk('fdAT', Buffer.concat([number, data])));
    }
  });
  out.push(chunk('IEND', Buffer.alloc(0)));
  return Buffer.concat(out);
}
