// Where detail is wanted. In: sources of importance. Out: the part of the panel that chooses one, with the tools of the brush.

import { button, labelledSelect, make, messagePlace, section, switchElement, uniqueId } from "./elements.js";
import { numberParts } from "./number.js";

const CONSTANT = "constant";
const RULE = {
    name: CONSTANT,
    words: [],
    usual: 0.5,
    unit: "",
    isNumber: true,
    isWhole: false,
    isOpen: true,
    low: 0,
    high: 1,
    absent: null,
};

/** The section "Importance". `act`: choose(source, moving), brush(kind or null), brushChanged(), overlay(), clear(), download(). */
export function importanceSection(sources, act) {
    const tools = { kind: null, size: 0.08, strength: 0.7, isOverlay: false };
    const source = labelledSelect("Source", choicesOf(sources), (value) => {
        act.choose(value === CONSTANT ? `${CONSTANT}:${RULE.usual}` : value, false);
    }, { "data-do": "importance" });
    const painted = source.select.querySelector("option[value=painted]");
    const hint = uniqueId("hint");
    const about = make("p", { class: "gs-hint", id: hint });
    const labels = { name: "Importance everywhere, slider", hint, unit: "", absent: "" };
    const constant = numberParts(RULE, labels, 1, (value, moving) => act.choose(`${CONSTANT}:${value}`, moving));
    const constantLabel = make("label", { for: constant.field.id, text: "Importance everywhere" });
    const constantHead = make("div", { class: "gs-row-head" }, constantLabel, constant.field);
    const constantRow = make("div", { class: "gs-row", "data-option": CONSTANT }, constantHead, constant.slider, constant.invalid);
    const message = messagePlace();
    const brush = brushTools(tools, act);
    const element = section("Importance", message.element, source.element, about, constantRow, ...brush.elements);
    const update = (importance, hasStrokes) => {
        const kind = importance.split(":")[0];
        source.select.value = kind;
        painted.disabled = !hasStrokes && kind !== "painted";
        about.textContent = choicesOf(sources).find(([value]) => value === kind)?.[2] ?? "";
        constantRow.hidden = kind !== CONSTANT;
        if (kind === CONSTANT) {
            constant.show(Number(importance.split(":")[1]));
        }
        brush.update(hasStrokes);
    };
    return { element, update, message, tools, setBrush: brush.setKind, setOverlay: brush.setOverlay };
}

/** What can be chosen: the named sources, a constant, and the painted map instead of a path. */
function choicesOf(sources) {
    const named = sources.filter(({ form }) => !form.includes(" "));
    const choices = named.map(({ form, description }) => [form.split(":")[0], form.split(":")[0], description]);
    return [...choices, ["painted", "painted", "what is painted: more or less detail than elsewhere"]];
}

/** Buttons and sliders of the brush. */
function brushTools(tools, act) {
    const kinds = [["more", "More"], ["less", "Less"], ["erase", "Erase"]];
    const buttons = new Map();
    const setKind = (kind) => {
        tools.kind = kind;
        buttons.forEach((each, name) => each.setAttribute("aria-pressed", String(name === kind)));
        act.brush(kind);
    };
    for (const [kind, label] of kinds) {
        const onclick = () => setKind(tools.kind === kind ? null : kind);
        buttons.set(kind, button(label, `paint-${kind}`, onclick, { "aria-pressed": "false" }));
    }
    const overlay = switchElement({ id: uniqueId("switch"), "data-do": "overlay" });
    const setOverlay = (isOn) => {
        overlay.checked = isOn;
        tools.isOverlay = isOn;
        act.overlay();
    };
    overlay.addEventListener("change", () => setOverlay(overlay.checked));
    const clear = button("Clear", "paint-clear", act.clear);
    const download = button("Download map", "paint-download", act.download);
    const size = percentSlider("Brush size", 1, 40, tools.size, (value) => (tools.size = value), act.brushChanged);
    const strength = percentSlider("Strength", 5, 100, tools.strength, (value) => (tools.strength = value), act.brushChanged);
    const group = { class: "gs-buttons gs-segments", role: "group", "aria-label": "Brush" };
    const kindsElement = make("div", group, ...buttons.values());
    const about = "Paint on the stage where more or less detail is wanted. The same button again puts the brush away.";
    const hint = make("p", { class: "gs-hint", text: about });
    const overlayLine = make("div", { class: "gs-line" }, make("label", { for: overlay.id, text: "Show overlay" }), overlay);
    const elements = [
        make("h3", { text: "Paint" }),
        kindsElement,
        hint,
        size,
        strength,
        overlayLine,
        make("div", { class: "gs-buttons" }, clear, download),
    ];
    const update = (hasStrokes) => {
        clear.disabled = !hasStrokes;
        download.disabled = !hasStrokes;
    };
    return { elements, update, setKind, setOverlay };
}

/** A slider in per cent for a fraction. */
function percentSlider(label, low, high, start, set, onset) {
    const id = uniqueId("percent");
    const output = make("output", { for: id, text: `${Math.round(start * 100)} %` });
    const attributes = { type: "range", id, min: low, max: high, step: 1, value: Math.round(start * 100) };
    const slider = make("input", attributes);
    const show = () => {
        output.textContent = `${slider.value} %`;
        slider.style.setProperty("--at", `${(slider.valueAsNumber - low) / (high - low) * 100}%`);
        set(slider.valueAsNumber / 100);
        onset();
    };
    slider.addEventListener("input", show);
    slider.style.setProperty("--at", `${(start * 100 - low) / (high - low) * 100}%`);
    return make("div", { class: "gs-line gs-percent" }, make("label", { for: id, text: label }), slider, output);
}
