// The divider between photo and drawing. In: drags and keys. Out: the share of the stage, 0 to 1, that shows the photo.

import { make } from "./elements.js";

const STEPS_OF_ARROWS = { ArrowRight: 0.02, ArrowUp: 0.02, ArrowLeft: -0.02, ArrowDown: -0.02 };
const STEPS_OF_WIPE = { ...STEPS_OF_ARROWS, PageUp: 0.1, PageDown: -0.1, Home: -1, End: 1 };

/** A handle that is dragged or moved by keys; `onmove` is called after each move. */
export function wipeHandle(onmove) {
    const element = make("div", {
        class: "gs-wipe",
        role: "slider",
        tabindex: "0",
        "aria-label": "Divider between photo and drawing",
        "aria-orientation": "horizontal",
        "aria-valuemin": "0",
        "aria-valuemax": "100",
        hidden: true,
    }, make("span", { class: "gs-wipe-grip" }));
    const handle = { element, share: 0.5 };
    const set = (share) => {
        handle.share = Math.min(1, Math.max(0, share));
        const percent = Math.round(handle.share * 100);
        element.style.left = `${handle.share * 100}%`;
        element.setAttribute("aria-valuenow", String(percent));
        element.setAttribute("aria-valuetext", `${percent} % photo, ${100 - percent} % drawing`);
        onmove();
    };
    element.addEventListener("pointerdown", (event) => {
        event.stopPropagation();
        element.setPointerCapture(event.pointerId);
    });
    element.addEventListener("pointermove", (event) => {
        if (element.hasPointerCapture(event.pointerId)) {
            const box = element.parentElement.getBoundingClientRect();
            set((event.clientX - box.left) / box.width);
        }
    });
    element.addEventListener("keydown", (event) => {
        const by = STEPS_OF_WIPE[event.key];
        if (by !== undefined && !event.ctrlKey && !event.metaKey && !event.altKey) {
            event.preventDefault();
            event.stopPropagation();
            set(handle.share + by);
        }
    });
    element.style.left = "50%";
    element.setAttribute("aria-valuenow", "50");
    element.setAttribute("aria-valuetext", "50 % photo, 50 % drawing");
    return handle;
}
