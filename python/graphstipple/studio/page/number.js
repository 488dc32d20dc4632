// A number with its slider and its field. In: a rule. Out: both elements; `onvalue(value, moving)` tells of changes.

import { make, uniqueId } from "./elements.js";
import { scaleOf } from "./scale.js";
import { isAllowed } from "./rules.js";
import { allowedText, plainNumber } from "./words.js";

const POSITIONS = 1000;
const TYPED_MS = 700;
const STEPS_OF_KEYS = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1, PageUp: 10, PageDown: -10 };

/** The slider and the field of a rule; `labels` are {name, hint}: the name, and the id of what describes it. */
export function numberParts(rule, labels, mostNodes, onvalue) {
    const scale = scaleOf(rule, mostNodes);
    const invalidId = uniqueId("invalid");
    const state = { value: null, isInvalid: false, timer: 0 };
    const invalid = make("p", { class: "gs-invalid", id: invalidId, "aria-live": "polite" });
    const field = make("input", {
        type: "number",
        id: uniqueId("field"),
        step: rule.isWhole ? "1" : "any",
        inputmode: rule.isWhole ? "numeric" : "decimal",
        "aria-describedby": `${labels.hint} ${invalidId}`,
    });
    const slider = scale && makeSlider(scale, labels, state, onvalue);
    const showInvalid = (isInvalid) => {
        state.isInvalid = isInvalid;
        field.setAttribute("aria-invalid", String(isInvalid));
        invalid.textContent = isInvalid ? allowedText(rule) : "";
    };
    const typed = (isMoving) => {
        clearTimeout(state.timer);
        if (field.value === "" && !field.validity.badInput) {
            showInvalid(false);
            return isMoving ? undefined : leftEmpty();
        }
        const value = field.validity.badInput ? NaN : field.valueAsNumber;
        showInvalid(!isAllowed(rule, value));
        if (state.isInvalid) {
            return undefined;
        }
        if (isMoving) {
            state.timer = setTimeout(() => field.isConnected && typed(false), TYPED_MS);
        }
        return onvalue(value, isMoving);
    };
    const leftEmpty = () => (rule.absent && rule.words.length === 0 ? onvalue(null, false) : show(state.value));
    const show = (value) => {
        if (state.isInvalid && value === state.value && document.activeElement === field) {
            return;
        }
        state.value = value;
        showInvalid(false);
        if (typeof value === "number" && (field.value === "" || field.valueAsNumber !== value)) {
            field.value = plainNumber(value);
        } else if (typeof value !== "number") {
            field.value = "";
            field.placeholder = value === null ? rule.absent?.word ?? "" : "";
        }
        slider?.show(value);
    };
    field.addEventListener("input", () => typed(true));
    field.addEventListener("change", () => typed(false));
    return { field, slider: slider?.element ?? null, invalid, show, scale };
}

/** The slider of a scale. Keys step by a hundredth of it, a held key is one change. */
function makeSlider(scale, labels, state, onvalue) {
    const element = make("input", {
        type: "range",
        min: 0,
        max: POSITIONS,
        step: 1,
        value: Math.round(POSITIONS / 3),
        "aria-label": labels.name,
        "aria-describedby": labels.hint,
    });
    const read = () => scale.value(element.valueAsNumber / POSITIONS);
    const held = { is: false };
    const show = (value) => {
        const isNumber = typeof value === "number";
        if (isNumber && read() !== value) {
            element.value = Math.round(scale.position(value) * POSITIONS);
        }
        element.style.setProperty("--at", `${element.valueAsNumber / POSITIONS * 100}%`);
        element.classList.toggle("gs-dimmed", !isNumber);
        const text = isNumber ? plainNumber(value) : String(value ?? labels.absent);
        element.setAttribute("aria-valuetext", labels.unit && isNumber ? `${text} ${labels.unit}` : text);
    };
    element.addEventListener("input", () => onvalue(read(), true));
    element.addEventListener("change", () => onvalue(read(), false));
    element.addEventListener("keydown", (event) => {
        const steps = STEPS_OF_KEYS[event.key];
        if (steps === undefined || event.ctrlKey || event.metaKey || event.altKey) {
            return;
        }
        event.preventDefault();
        held.is = event.repeat;
        onvalue(scale.next(typeof state.value === "number" ? state.value : read(), steps), event.repeat);
    });
    element.addEventListener("keyup", () => {
        if (held.is && typeof state.value === "number") {
            held.is = false;
            onvalue(state.value, false);
        }
    });
    return { element, show };
}
