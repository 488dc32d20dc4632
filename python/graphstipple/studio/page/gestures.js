// Pointers and the wheel on the stage. In: events. Out: calls of `act`: zoomBy(factor, x, y), pan(dx, dy), brush(): null or
// {down, move, up, cancel, hover}, all with places in device pixels of the stage; down and move take [[place, pressure]...].

const WHEEL_LINE = 16;
const WHEEL_ZOOM = 0.0016;

/** Listens on the stage's element until the signal aborts. */
export function listenForGestures(element, act, signal) {
    const pointers = new Map();
    const painting = { id: null };
    const place = (event) => {
        const box = element.getBoundingClientRect();
        const ratio = act.pixelRatio();
        return [(event.clientX - box.left) * ratio, (event.clientY - box.top) * ratio];
    };
    const on = (name, listener, options = {}) => element.addEventListener(name, listener, { signal, ...options });
    const stopPainting = (isKept) => {
        if (painting.id !== null) {
            painting.id = null;
            act.brush()?.[isKept ? "up" : "cancel"]();
        }
    };
    on("wheel", (event) => {
        event.preventDefault();
        const lines = event.deltaMode === 0 ? event.deltaY : event.deltaY * WHEEL_LINE;
        const factor = Math.exp(-Math.max(-400, Math.min(400, lines)) * WHEEL_ZOOM * (event.ctrlKey ? 5 : 1));
        act.zoomBy(Math.min(2.5, Math.max(0.4, factor)), ...place(event));
    }, { passive: false });
    on("pointerdown", (event) => {
        if (event.target.closest("button, [role=slider]") || (event.pointerType === "mouse" && event.button > 1)) {
            return;
        }
        element.setPointerCapture(event.pointerId);
        pointers.set(event.pointerId, place(event));
        const brush = act.brush();
        if (pointers.size > 1) {
            stopPainting(false);
        } else if (brush && event.button === 0) {
            painting.id = event.pointerId;
            brush.down([[place(event), pressure(event)]]);
        }
    });
    on("pointermove", (event) => {
        if (painting.id === event.pointerId) {
            const events = event.getCoalescedEvents?.() ?? [];
            act.brush()?.move((events.length > 0 ? events : [event]).map((each) => [place(each), pressure(each)]));
        } else if (pointers.has(event.pointerId)) {
            moved(pointers, event.pointerId, place(event), act);
        }
        act.brush()?.hover(place(event));
    });
    const ended = (event, isKept) => {
        pointers.delete(event.pointerId);
        if (painting.id === event.pointerId) {
            stopPainting(isKept);
        }
    };
    on("pointerup", (event) => ended(event, true));
    on("pointercancel", (event) => ended(event, false));
    on("lostpointercapture", (event) => ended(event, true));
}

/** How hard a pen presses; a mouse and a finger always press fully. */
function pressure(event) {
    return event.pointerType === "pen" && event.pressure > 0 ? event.pressure : 1;
}

/** One finger pans, two pan and zoom. */
function moved(pointers, id, to, act) {
    const from = pointers.get(id);
    pointers.set(id, to);
    if (pointers.size === 1) {
        act.pan(to[0] - from[0], to[1] - from[1]);
        return;
    }
    const [, other] = [...pointers].find(([each]) => each !== id);
    const distance = (point) => Math.max(8, Math.hypot(point[0] - other[0], point[1] - other[1]));
    act.zoomBy(distance(to) / distance(from), (to[0] + other[0]) / 2, (to[1] + other[1]) / 2);
    act.pan((to[0] - from[0]) / 2, (to[1] - from[1]) / 2);
}
