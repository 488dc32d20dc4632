// The way to the server: messages over a WebSocket, opened again and again, and photos by POST. In: nothing. Out: a transport.

const WAITS_MS = [500, 1000, 2000];
const LONG_WAIT_MS = 5000;
const REFUSED = 4000;
const TAKEN = 4001;
const TAKEN_WAIT_MS = 300;
const ENDED = "The studio has ended or cannot be reached.";
const LOST = `${ENDED} Start it again with the same --port; this page goes on by itself once it is let in.`;
const ANEW = "The studio was started anew: open the address that it prints, then this page goes on.";
const STORED_ID = "graphstipple-page";

/** The transport of this page. */
export function openSocket() {
    const state = { id: pageId(), socket: null, tries: 0, timer: 0, isClosed: false, wasTaken: false };
    const transport = { keepsAddress: true, onmessage: null, onstate: null, send, upload, close };
    const scheme = location.protocol === "https:" ? "wss:" : "ws:";
    const tell = (name, sentence = "") => transport.onstate?.(name, sentence);

    function send(message) {
        if (state.socket?.readyState === WebSocket.OPEN) {
            state.socket.send(JSON.stringify(message));
        }
    }

    async function upload(kind, name, blob) {
        const address = `/${kind}?page=${encodeURIComponent(state.id)}&name=${encodeURIComponent(name)}`;
        const answer = await fetch(address, { method: "POST", body: blob }).catch(() => null);
        if (answer === null) {
            throw new Error(LOST);
        }
        const said = await answer.json().catch(() => null);
        if (answer.status !== 202) {
            throw new Error(said?.sentence ?? `The studio did not take ${name} (status ${answer.status}).`);
        }
    }

    function connect() {
        const socket = new WebSocket(`${scheme}//${location.host}/socket?page=${encodeURIComponent(state.id)}`);
        socket.binaryType = "arraybuffer";
        state.socket = socket;
        socket.onmessage = ({ data }) => {
            state.tries = 0;
            state.wasTaken = false;
            if (typeof data === "string") {
                transport.onmessage?.(JSON.parse(data), null);
            } else {
                transport.onmessage?.(...unframed(data));
            }
        };
        socket.onclose = ({ code, reason }) => {
            if (state.isClosed) {
                return;
            }
            if (code === TAKEN) {
                state.id = state.wasTaken ? newPageId() : state.id;
                state.timer = setTimeout(connect, state.wasTaken ? 0 : TAKEN_WAIT_MS);
                state.wasTaken = true;
            } else if (code === REFUSED) {
                tell("refused", reason || ANEW);
                later(LONG_WAIT_MS);
            } else {
                tell("lost", LOST);
                later(WAITS_MS[Math.min(state.tries, WAITS_MS.length - 1)]);
            }
        };
    }

    function later(wait) {
        state.tries += 1;
        clearTimeout(state.timer);
        state.timer = setTimeout(tryAgain, wait);
    }

    async function tryAgain() {
        const answer = await fetch("/alive", { cache: "no-store" }).catch(() => null);
        if (state.isClosed) {
            return;
        }
        if (answer?.ok) {
            connect();
            return;
        }
        tell(answer?.status === 403 ? "refused" : "lost", answer?.status === 403 ? ANEW : LOST);
        later(WAITS_MS[Math.min(state.tries, WAITS_MS.length - 1)]);
    }

    function close() {
        state.isClosed = true;
        clearTimeout(state.timer);
        state.socket?.close();
    }

    queueMicrotask(connect);
    return transport;
}

/** The name of this page at the server, which a reload keeps. */
function pageId() {
    return sessionStorage.getItem(STORED_ID) ?? newPageId();
}

/** Another name, for a tab that was made from one that goes on. */
function newPageId() {
    const id = crypto.randomUUID();
    sessionStorage.setItem(STORED_ID, id);
    return id;
}

/** The message and the bytes of a binary frame. */
function unframed(data) {
    const length = new DataView(data).getUint32(0, true);
    const header = new TextDecoder().decode(new Uint8Array(data, 4, length));
    return [JSON.parse(header), new Uint8Array(data, 4 + length)];
}
