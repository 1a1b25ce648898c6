/**
 * The websocket to the server: what it says, that it is silent, and that it comes back.
 *
 * After a loss it connects again by itself; nobody takes control or engages by itself.
 */

const FIRST_WAIT = 500; // before it connects again [ms]
const LONGEST_WAIT = 8000;
const LOOK = 200; // whether there is news [ms]
const SILENT = 5; // looks without any; not a time, which would pass while this page is busy
const REASONS = {
  4400: "the server did not understand this page: reload it",
  4408: "this page was too slow for the server",
  4429: "too many pages are open",
};

export class Connection extends EventTarget {
  /**
   * Events: each `type` of the server's messages, with the message as `detail`; "picture" with an
   * ArrayBuffer; "open"; "lost" with words; "silent" with true or false.
   */
  constructor() {
    super();
    /** @type {WebSocket | null} */
    this.socket = null;
    this.wait = FIRST_WAIT;
    this.quiet = -Infinity; // looks without telemetry; before the run has begun there is none
    this.silent = false;
    this.over = false; // the run has ended: there is nothing to come back to
    setInterval(() => this.#watch(), LOOK);
  }

  open() {
    const address = new URL("ws", document.baseURI);
    address.protocol = address.protocol.replace("http", "ws");
    const socket = new WebSocket(address);
    socket.binaryType = "arraybuffer";
    socket.onopen = () => {
      this.wait = FIRST_WAIT;
      this.quiet = -Infinity;
      this.#tell("open");
    };
    socket.onmessage = (message) => this.#receive(message.data);
    socket.onclose = (closed) => this.#lose(closed.code);
    this.socket = socket;
  }

  get online() {
    return this.socket?.readyState === WebSocket.OPEN;
  }

  /**
   * Say something, if anybody listens.
   * @param {object} message
   */
  send(message) {
    if (this.online) this.socket?.send(JSON.stringify(message));
  }

  /** @param {string | ArrayBuffer} data */
  #receive(data) {
    if (typeof data !== "string") {
      this.#tell("picture", data);
      return;
    }
    const message = JSON.parse(data);
    if (message.type === "telemetry") this.quiet = 0;
    if (message.type === "ended") this.over = true;
    this.#tell(message.type, message);
  }

  /** @param {number} code */
  #lose(code) {
    this.socket = null;
    const wait = this.wait;
    this.wait = Math.min(2 * this.wait, LONGEST_WAIT);
    if (!this.over) setTimeout(() => this.open(), wait);
    const next = this.over ? "the run is over" : `connecting again in ${(wait / 1000).toFixed(1)} s`;
    this.#tell("lost", REASONS[code] ? `${REASONS[code]}; ${next}` : next);
  }

  #watch() {
    this.quiet += 1;
    const silent = this.online && this.quiet > SILENT;
    if (silent !== this.silent) {
      this.silent = silent;
      this.#tell("silent", silent);
    }
  }

  /**
   * @param {string} type
   * @param {unknown} [detail]
   */
  #tell(type, detail) {
    this.dispatchEvent(new CustomEvent(type, { detail }));
  }
}
