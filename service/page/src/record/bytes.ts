// Bytes of a file that is being made: little endian, lengths before contents as MCAP has them.
export class Bytes {
  length = 0;
  private bytes = new Uint8Array(1 << 16);
  private view = new DataView(this.bytes.buffer);
  private readonly encoder = new TextEncoder();

  get written(): Uint8Array<ArrayBuffer> {
    return this.bytes.subarray(0, this.length);
  }
  clear(): void {
    this.length = 0;
  }

  u8(value: number): void {
    this.view.setUint8(this.grow(1), value);
  }
  u16(value: number): void {
    this.view.setUint16(this.grow(2), value, true);
  }
  u32(value: number): void {
    this.view.setUint32(this.grow(4), value, true);
  }
  u64(value: number | bigint): void {
    const at = this.grow(8);
    this.view.setBigUint64(at, BigInt(value), true);
  }
  raw(bytes: Uint8Array): void {
    const at = this.grow(bytes.length);
    this.bytes.set(bytes, at);
  }
  utf8(text: string): void {
    const at = this.grow(3 * text.length); // at most
    this.length = at + this.encoder.encodeInto(text, this.bytes.subarray(at)).written;
  }
  // What is written by `content`, after its length in bytes: strings, maps, arrays.
  prefixed(content: () => void): void {
    const at = this.grow(4);
    content();
    this.view.setUint32(at, this.length - at - 4, true);
  }
  string(text: string): void {
    this.prefixed(() => this.utf8(text));
  }
  record(op: number, content: () => void): void {
    this.u8(op);
    const at = this.grow(8);
    content();
    this.view.setBigUint64(at, BigInt(this.length - at - 8), true);
  }

  private grow(n: number): number {
    const at = this.length;
    this.length += n;
    if (this.length > this.bytes.length) {
      const longer = new Uint8Array(2 * this.length);
      longer.set(this.bytes);
      this.bytes = longer;
      this.view = new DataView(longer.buffer);
    }
    return at;
  }
}
