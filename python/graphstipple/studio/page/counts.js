// What was counted of the drawing. In: messages "drawn", "size", "progress". Out: a line of numbers, warnings, a thin line.

import { make } from "./elements.js";
import { fileSize, groupedNumber, secondsText } from "./words.js";

const COUNTS = [
    ["stipples", "dots"],
    ["regions", "shapes"],
    ["nodes", "nodes"],
    ["coordinates", "points"],
    ["bytes", "file"],
    ["seconds", "time"],
];
const PATIENCE_MS = 150;

/** The line under the stage. */
export function countsLine() {
    const values = new Map(COUNTS.map(([name]) => [name, make("dd", { "data-count": name, text: "–" })]));
    const entries = COUNTS.map(([name, label]) => make("div", {}, make("dt", { text: label }), values.get(name)));
    const list = make("dl", { class: "gs-counts", "aria-live": "polite", "aria-label": "Counts" }, ...entries);
    const warnings = make("ul", { class: "gs-warnings", hidden: true, "aria-label": "Warnings" });
    const set = (name, text) => {
        if (values.get(name).textContent !== text) {
            values.get(name).textContent = text;
        }
    };
    const show = (stats, seconds, sentences) => {
        for (const name of ["stipples", "regions", "nodes", "coordinates"]) {
            set(name, typeof stats[name] === "number" ? groupedNumber(stats[name]) : "–");
        }
        set("seconds", secondsText(seconds));
        warnings.replaceChildren(...sentences.map((text) => make("li", { text })));
        warnings.hidden = sentences.length === 0;
    };
    const clear = () => {
        COUNTS.forEach(([name]) => set(name, "–"));
        warnings.hidden = true;
    };
    const showSize = (bytes) => set("bytes", bytes === null ? "–" : fileSize(bytes));
    const setMoving = (isMoving) => list.setAttribute("aria-live", isMoving ? "off" : "polite");
    return { elements: [list, warnings], show, clear, setMoving, showSize };
}

/** A thin line that shows how far the drawing is; it comes after a moment only. */
export function progressLine() {
    const bar = make("span");
    const words = make("span", { class: "gs-progress-words" });
    const attributes = { class: "gs-progress", role: "progressbar", "aria-label": "Drawing", hidden: true };
    const element = make("div", { ...attributes, "aria-valuemin": "0", "aria-valuemax": "100" }, bar);
    const state = { timer: 0 };
    const begin = () => {
        if (state.timer === 0 && element.hidden) {
            state.timer = setTimeout(() => {
                element.hidden = false;
                words.textContent = "Drawing …";
            }, PATIENCE_MS);
        }
    };
    const set = (stage, fraction) => {
        bar.style.width = `${Math.round(fraction * 100)}%`;
        element.setAttribute("aria-valuenow", String(Math.round(fraction * 100)));
        element.setAttribute("aria-valuetext", stage);
    };
    const end = () => {
        clearTimeout(state.timer);
        state.timer = 0;
        element.hidden = true;
        words.textContent = "";
        bar.style.width = "0";
    };
    return { element, words, begin, set, end };
}
