// Writes MCAP files (https://mcap.dev/spec): chunks without compression, indexed, with checksums. Everything is given
// to `sink` piece by piece, in the order of the file; a piece is only valid during the call.
import { Bytes } from './bytes';
import { crc32 } from './crc32';

const kMagic = Uint8Array.of(0x89, 0x4d, 0x43, 0x41, 0x50, 0x30, 0x0d, 0x0a); // "\x89MCAP0\r\n"
const kChunkBytes = 1 << 20;
const Op = {
  header: 0x01,
  footer: 0x02,
  schema: 0x03,
  channel: 0x04,
  message: 0x05,
  chunk: 0x06,
  messageIndex: 0x07,
  chunkIndex: 0x08,
  statistics: 0x0b,
  summaryOffset: 0x0e,
  dataEnd: 0x0f,
} as const;

interface Span {
  start_ns: bigint; // of the earliest message
  end_ns: bigint;
}

interface ChunkEntry extends Span {
  offset: number; // in the file
  length: number; // of the whole record
  size: number; // of the messages in it
  indexes: [channel: number, offset: number][]; // of its message indexes
  indexLength: number;
}

function including(span: Span | null, time_ns: bigint): Span {
  if (span === null) return { start_ns: time_ns, end_ns: time_ns };
  if (time_ns < span.start_ns) span.start_ns = time_ns;
  if (time_ns > span.end_ns) span.end_ns = time_ns;
  return span;
}

export class McapWriter {
  private position = 0; // in the file
  private crc = 0; // of the section that is being written
  private readonly out = new Bytes();
  private readonly chunk = new Bytes(); // messages that are not yet written
  private chunkSpan: Span | null = null;
  private index = new Map<number, [time_ns: bigint, offset: number][]>(); // of `chunk`, by channel
  private fileSpan: Span | null = null;
  private readonly schemas = new Bytes(); // the records, for the summary
  private schemaCount = 0;
  private readonly channels = new Bytes();
  private readonly counts: number[] = []; // messages of channel i + 1
  private readonly chunks: ChunkEntry[] = [];

  constructor(
    library: string,
    private readonly sink: (bytes: Uint8Array<ArrayBuffer>) => void,
  ) {
    this.out.raw(kMagic);
    this.out.record(Op.header, () => {
      this.out.string(''); // profile
      this.out.string(library);
    });
    this.flush();
  }

  // A JSON schema; returns its id.
  schema(name: string, jsonSchema: object): number {
    const id = ++this.schemaCount;
    const before = this.schemas.length;
    this.schemas.record(Op.schema, () => {
      this.schemas.u16(id);
      this.schemas.string(name);
      this.schemas.string('jsonschema');
      this.schemas.string(JSON.stringify(jsonSchema));
    });
    this.out.raw(this.schemas.written.subarray(before));
    this.flush();
    return id;
  }

  // A channel of JSON messages; returns its id.
  channel(topic: string, schema: number): number {
    const id = this.counts.push(0);
    const before = this.channels.length;
    this.channels.record(Op.channel, () => {
      this.channels.u16(id);
      this.channels.u16(schema);
      this.channels.string(topic);
      this.channels.string('json');
      this.channels.prefixed(() => undefined); // no metadata
    });
    this.out.raw(this.channels.written.subarray(before));
    this.flush();
    return id;
  }

  message(channel: number, time_ns: bigint, json: string): void {
    const entries = this.index.get(channel) ?? [];
    if (entries.length === 0) this.index.set(channel, entries);
    entries.push([time_ns, this.chunk.length]);
    this.chunk.record(Op.message, () => {
      this.chunk.u16(channel);
      this.chunk.u32(this.counts[channel - 1]!++); // sequence
      this.chunk.u64(time_ns); // log time
      this.chunk.u64(time_ns); // publish time
      this.chunk.utf8(json);
    });
    this.chunkSpan = including(this.chunkSpan, time_ns);
    this.fileSpan = including(this.fileSpan, time_ns);
    if (this.chunk.length >= kChunkBytes) this.writeChunk();
  }

  // Completes the file; nothing is added any more.
  end(): void {
    this.writeChunk();
    const { out } = this;
    out.record(Op.dataEnd, () => out.u32(this.crc));
    this.flush();
    this.crc = 0;
    const summaryStart = this.position;
    const groups = [
      this.group(Op.schema, () => out.raw(this.schemas.written)),
      this.group(Op.channel, () => out.raw(this.channels.written)),
      this.group(Op.statistics, () => this.writeStatistics()),
      this.group(Op.chunkIndex, () => this.chunks.forEach((chunk) => this.writeChunkIndex(chunk))),
    ];
    const offsetsStart = this.position;
    for (const { op, start, length } of groups) {
      if (length === 0) continue;
      out.record(Op.summaryOffset, () => {
        out.u8(op);
        out.u64(start);
        out.u64(length);
      });
    }
    out.u8(Op.footer);
    out.u64(20); // its length, which the checksum covers too
    out.u64(summaryStart);
    out.u64(offsetsStart);
    out.u32(crc32(out.written, this.crc));
    out.raw(kMagic);
    this.flush();
  }

  private writeChunk(): void {
    const span = this.chunkSpan;
    if (span === null) return;
    const { out, chunk } = this;
    const offset = this.position;
    out.record(Op.chunk, () => {
      out.u64(span.start_ns);
      out.u64(span.end_ns);
      out.u64(chunk.length);
      out.u32(crc32(chunk.written));
      out.string(''); // compression
      out.u64(chunk.length);
      out.raw(chunk.written);
    });
    const { length } = out;
    const indexes: ChunkEntry['indexes'] = [];
    for (const [channel, entries] of this.index) {
      indexes.push([channel, offset + out.length]);
      out.record(Op.messageIndex, () => {
        out.u16(channel);
        out.prefixed(() => {
          for (const [time_ns, at] of entries) {
            out.u64(time_ns);
            out.u64(at);
          }
        });
      });
    }
    this.chunks.push({ ...span, offset, length, size: chunk.length, indexes, indexLength: out.length - length });
    this.flush();
    chunk.clear();
    this.chunkSpan = null;
    this.index = new Map();
  }

  private writeStatistics(): void {
    const { out } = this;
    out.record(Op.statistics, () => {
      out.u64(this.counts.reduce((sum, count) => sum + count, 0));
      out.u16(this.schemaCount);
      out.u32(this.counts.length); // channels
      out.u32(0); // attachments
      out.u32(0); // metadata
      out.u32(this.chunks.length);
      out.u64(this.fileSpan?.start_ns ?? 0n);
      out.u64(this.fileSpan?.end_ns ?? 0n);
      out.prefixed(() => {
        this.counts.forEach((count, i) => {
          out.u16(i + 1);
          out.u64(count);
        });
      });
    });
  }

  private writeChunkIndex(chunk: ChunkEntry): void {
    const { out } = this;
    out.record(Op.chunkIndex, () => {
      out.u64(chunk.start_ns);
      out.u64(chunk.end_ns);
      out.u64(chunk.offset);
      out.u64(chunk.length);
      out.prefixed(() => {
        for (const [channel, offset] of chunk.indexes) {
          out.u16(channel);
          out.u64(offset);
        }
      });
      out.u64(chunk.indexLength);
      out.string(''); // compression
      out.u64(chunk.size); // compressed
      out.u64(chunk.size);
    });
  }

  // Records of one kind in the summary.
  private group(op: number, write: () => void): { op: number; start: number; length: number } {
    const start = this.position;
    write();
    this.flush();
    return { op, start, length: this.position - start };
  }

  private flush(): void {
    const { written } = this.out;
    this.crc = crc32(written, this.crc);
    this.position += written.length;
    this.sink(written);
    this.out.clear();
  }
}
