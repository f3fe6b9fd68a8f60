// The connection to omni monitor: asks for its version, opens the WebSocket, and opens it again when it was lost.
import { kKind, kMagic } from './contract';
import { decode } from './decode';
import { kProtocol } from './types';
import type { BinaryMessage, Request, TextMessage } from './types';

export type LinkState =
  | { kind: 'connecting'; text: string }
  | { kind: 'open'; text: string }
  | { kind: 'lost'; text: string; since_ms: number } // performance.now(); it tries again
  | { kind: 'refused'; text: string } // no further attempt: the person must do something
  | { kind: 'old'; text: string }; // the page must be loaded again

export interface LinkEvents {
  state(state: LinkState): void;
  text(message: TextMessage): void;
  binary(message: BinaryMessage): void;
  garbled(why: string): void; // a message that is not one
}

const kTokenKey = 'omni.token';
const kTokenInHash = /(?:^#|&)token=([0-9a-fA-F]+)/;
const kCodeInHash = /(?:^#|&)code=([0-9a-fA-F]+)/;
const kRetryFirst_ms = 500;
const kRetryLast_ms = 5000;
const kAnswer_ms = 15_000; // for /hello
const kBehind_bytes = 1 << 20; // not yet sent: aims are dropped, as newer ones follow
const kCloseForbidden = 4003;
const kTypes = new Set(['hello', 'status', 'setup', 'scene', 'notice', 'answer']);

// For reloads of this tab.
function keepToken(token: string): void {
  try {
    sessionStorage.setItem(kTokenKey, token);
  } catch {
    // no storage: a reload then needs the printed address again
  }
}

function keptToken(): string {
  try {
    return sessionStorage.getItem(kTokenKey) ?? '';
  } catch {
    return '';
  }
}

// The token is in the address as #token=HEX once; or #code=HEX, which is good once for it. Both are taken out of the
// address bar, where they would end up in pictures of the screen and bookmarks.
function takeKey(): { token: string; code: string } {
  const token = kTokenInHash.exec(location.hash)?.[1];
  const code = kCodeInHash.exec(location.hash)?.[1];
  if (token !== undefined) keepToken(token);
  if (token !== undefined || code !== undefined) history.replaceState(null, '', location.pathname + location.search);
  return { token: token ?? keptToken(), code: code ?? '' };
}

// Throws RangeError, like decode.
function parse(text: string): TextMessage {
  let message: unknown;
  try {
    message = JSON.parse(text);
  } catch {
    throw new RangeError('text message that is not JSON');
  }
  const type = typeof message === 'object' && message !== null && 'type' in message ? message.type : undefined;
  if (typeof type !== 'string' || !kTypes.has(type)) throw new RangeError('text message of unknown type');
  return message as TextMessage;
}

export class Link {
  private token: string;
  private code: string; // "": none, or used
  private socket: WebSocket | null = null;
  private attempt = 0; // counts up: answers to an older attempt are ignored
  private retry_ms = kRetryFirst_ms;
  private timer = 0;
  private lost_ms = NaN;

  constructor(private readonly events: LinkEvents) {
    ({ token: this.token, code: this.code } = takeKey());
    // Another address of the same page, pasted into this tab, changes only the hash.
    addEventListener('hashchange', () => {
      if (!kTokenInHash.test(location.hash) && !kCodeInHash.test(location.hash)) return;
      ({ token: this.token, code: this.code } = takeKey());
      this.restart();
    });
    addEventListener('online', () => {
      if (this.socket === null && this.timer !== 0) this.restart();
    });
  }

  start(): void {
    this.restart();
  }

  get open(): boolean {
    return this.socket?.readyState === WebSocket.OPEN;
  }

  // false: not sent. Aims may be dropped; a newer one follows.
  send(request: Request): boolean {
    if (this.socket === null || !this.open) return false;
    if (request.type === 'aim' && this.socket.bufferedAmount > kBehind_bytes) return false;
    this.socket.send(JSON.stringify(request));
    return true;
  }

  // A file for the service: one binary message.
  drop(name: string, bytes: ArrayBuffer): boolean {
    if (this.socket === null || !this.open) return false;
    const text = new TextEncoder().encode(name);
    const head = new DataView(new ArrayBuffer(12));
    head.setUint32(0, kMagic, true);
    head.setUint16(4, kKind.drop, true);
    head.setUint16(6, kProtocol, true);
    head.setUint32(8, text.byteLength, true);
    const message = new Uint8Array(12 + text.byteLength + bytes.byteLength);
    message.set(new Uint8Array(head.buffer), 0);
    message.set(text, 12);
    message.set(new Uint8Array(bytes), 12 + text.byteLength);
    this.socket.send(message);
    return true;
  }

  private restart(): void {
    clearTimeout(this.timer);
    this.timer = 0;
    this.retry_ms = kRetryFirst_ms;
    this.close();
    this.events.state({ kind: 'connecting', text: 'connecting' });
    void this.connect();
  }

  private close(): void {
    const socket = this.socket;
    this.socket = null;
    socket?.close();
  }

  private async connect(): Promise<void> {
    const attempt = ++this.attempt;
    if (this.code !== '') await this.redeem();
    if (attempt !== this.attempt) return;
    if (this.token === '') {
      this.refuse('This address has no key. Open the address that omni printed: it ends in #token= and the key.');
      return;
    }
    let answer: { protocol?: unknown } | null = null;
    try {
      const response = await fetch('/hello', {
        headers: { Authorization: `Bearer ${this.token}` },
        cache: 'no-store',
        signal: AbortSignal.timeout(kAnswer_ms),
      });
      const text = await response.text();
      if (attempt !== this.attempt) return;
      if (response.status === 401 || response.status === 403) {
        this.refuse(text.trim() || 'The key of this page is not the right one. Open the address that omni printed.');
        return;
      }
      if (!response.ok) {
        this.lose(text.trim() || `the service answered with HTTP status ${response.status}`);
        return;
      }
      answer = JSON.parse(text) as { protocol?: unknown };
    } catch {
      if (attempt === this.attempt) this.lose('omni does not answer: is it still running in its terminal?');
      return;
    }
    if (answer === null || answer.protocol !== kProtocol) {
      this.events.state({ kind: 'old', text: 'This page is older than the service: reload it.' });
      return;
    }
    this.openSocket(attempt);
  }

  // The code for the token. One that was used before changes nothing: a reload has the token already.
  private async redeem(): Promise<void> {
    const code = this.code;
    this.code = '';
    try {
      const headers = { Authorization: `Code ${code}` };
      const response = await fetch('/hello', { headers, cache: 'no-store', signal: AbortSignal.timeout(kAnswer_ms) });
      const { token } = (response.ok ? await response.json() : {}) as { token?: unknown };
      if (typeof token !== 'string') return;
      this.token = token;
      keepToken(token);
    } catch {
      // no answer: the token of before, if there is one, is tried
    }
  }

  private openSocket(attempt: number): void {
    const socket = new WebSocket(`ws://${location.host}/live`, ['omni-page', `token.${this.token}`]);
    socket.binaryType = 'arraybuffer';
    this.socket = socket;
    socket.addEventListener('open', () => {
      if (attempt !== this.attempt) return;
      this.lost_ms = NaN;
      this.events.state({ kind: 'open', text: 'connected' });
    });
    socket.addEventListener('message', (event: MessageEvent<unknown>) => {
      if (attempt === this.attempt) this.receive(event.data);
    });
    socket.addEventListener('close', (event) => {
      if (attempt !== this.attempt) return;
      this.socket = null;
      const reason = event.code >= 4000 && event.code <= 4999 ? event.reason : '';
      if (event.code === kCloseForbidden) {
        this.refuse(reason || 'omni refuses this page. Open the address that omni printed.');
      } else {
        this.lose(reason);
      }
    });
  }

  private receive(data: unknown): void {
    this.retry_ms = kRetryFirst_ms;
    let text: TextMessage | null = null;
    let binary: BinaryMessage | null = null;
    try {
      if (typeof data === 'string') text = parse(data);
      else if (data instanceof ArrayBuffer) binary = decode(data);
    } catch (error) {
      if (!(error instanceof RangeError)) throw error;
      this.events.garbled(error.message);
    }
    if (text !== null) this.events.text(text);
    if (binary !== null) this.events.binary(binary);
  }

  private refuse(text: string): void {
    this.close();
    this.events.state({ kind: 'refused', text });
  }

  private lose(text: string): void {
    this.close();
    if (Number.isNaN(this.lost_ms)) this.lost_ms = performance.now();
    this.events.state({ kind: 'lost', text, since_ms: this.lost_ms });
    this.timer = window.setTimeout(() => {
      this.timer = 0;
      void this.connect();
    }, this.retry_ms);
    this.retry_ms = Math.min(kRetryLast_ms, this.retry_ms * 2);
  }
}
