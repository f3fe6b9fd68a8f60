// Lets the page draw and answer while a file is being made: after 10 ms of work it gives way once. By a message to
// itself, not by a timer: the timers of a hidden tab fire only once a second.
const kWork_ms = 10;

export class Pace {
  private since_ms = performance.now();

  async rest(): Promise<void> {
    if (performance.now() - this.since_ms < kWork_ms) return;
    await new Promise<void>((resolve) => {
      const { port1, port2 } = new MessageChannel();
      port1.onmessage = () => {
        port1.close();
        resolve();
      };
      port2.postMessage(null);
    });
    this.since_ms = performance.now();
  }
}
