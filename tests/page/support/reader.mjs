// A WebSocket that only reads, without a browser: what 5 or 20 open pages are to the server.
import { randomBytes } from 'node:crypto';
import { connect } from 'node:net';

export class Reader {
  // `address`: as omni prints it.
  static open(address) {
    const reader = new Reader();
    const { hostname, port, host, hash } = new URL(address);
    reader.bytes = 0;
    reader.socket = connect(Number(port), hostname);
    reader.socket.on('data', (data) => {
      reader.bytes += data.length;
    });
    const token = hash.replace('#token=', '');
    reader.socket.write(
      `GET /live HTTP/1.1\r\nHost: ${host}\r\nConnection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n` +
        `Sec-WebSocket-Key: ${randomBytes(16).toString('base64')}\r\nOrigin: http://${host}\r\n` +
        `Sec-WebSocket-Protocol: omni-page, token.${token}\r\n\r\n`,
    );
    return reader;
  }

  // A text message; at most 125 bytes, or 65,535.
  send(text) {
    const payload = Buffer.from(text);
    const head = payload.length < 126 ? Buffer.from([0x81, 0x80 | payload.length]) : Buffer.alloc(4);
    if (payload.length >= 126) {
      head[0] = 0x81;
      head[1] = 0x80 | 126;
      head.writeUInt16BE(payload.length, 2);
    }
    this.socket.write(Buffer.concat([head, Buffer.alloc(4), payload])); // masked with zeros
  }

  close() {
    this.socket.destroy();
  }
}
