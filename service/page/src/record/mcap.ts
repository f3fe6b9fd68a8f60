// An MCAP file (https://mcap.dev/spec) of JSON messages: chunks without compression, indexed, with checksums.
import { McapWriter } from '@mcap/core';
import type { Schema } from './schemas';

export class McapFile {
  private readonly pieces: Blob[] = [];
  private position = 0n;
  private readonly writer = new McapWriter({
    writable: {
      write: async (bytes) => {
        this.pieces.push(new Blob([bytes as Uint8Array<ArrayBuffer>])); // a copy
        this.position += BigInt(bytes.length);
      },
      position: () => this.position,
    },
  });
  private readonly channels = new Map<string, { id: number; count: number }>(); // by topic
  private readonly utf8 = new TextEncoder();

  static async open(library: string, topics: readonly [topic: string, schema: Schema][]): Promise<McapFile> {
    const file = new McapFile();
    const { writer, utf8 } = file;
    await writer.start({ profile: '', library });
    for (const [topic, schema] of topics) {
      const data = utf8.encode(JSON.stringify(schema));
      const schemaId = await writer.registerSchema({ name: schema.title, encoding: 'jsonschema', data });
      const id = await writer.registerChannel({ topic, schemaId, messageEncoding: 'json', metadata: new Map() });
      file.channels.set(topic, { id, count: 0 });
    }
    return file;
  }

  // One after another: each waits for the one before.
  message(topic: string, time_ns: bigint, json: string): Promise<void> {
    const channel = this.channels.get(topic)!;
    const message = { logTime: time_ns, publishTime: time_ns, data: this.utf8.encode(json) };
    return this.writer.addMessage({ ...message, channelId: channel.id, sequence: channel.count++ });
  }

  async end(): Promise<Blob> {
    await this.writer.end();
    return new Blob(this.pieces, { type: 'application/octet-stream' });
  }
}
