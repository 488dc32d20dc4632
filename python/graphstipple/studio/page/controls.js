// The options of a drawing. In: rules, and what to do on a change. Out: the part of the panel that shows and changes them.

import { button, folded, iconButton, make, messagePlace, section, switchElement, uniqueId } from "./elements.js";
import { optionValue, presetValue } from "./look.js";
import { numberParts } from "./number.js";
import { isAllowed, readValue } from "./rules.js";
import { allowedText, firstSentence, labelOf } from "./words.js";

const VALUE = "value";
const MOST_INKS = 15;
const COMMON_INKS = ["#000000", "#ff48b0", "#0078bf", "#ffe800", "#00a95c", "#f15060", "#ff6c2f", "#765ba7"];

/** All options in their groups. `act` has change(name, value, moving), setAllBack() and counted(name). */
export function optionsSection(book, mostNodes, act) {
    const rows = new Map();
    const context = { mostNodes, act };
    for (const rule of book.rules.values()) {
        rows.set(rule.name, optionRow(rule, context));
    }
    const message = messagePlace();
    const allBack = button("Set all back", "set-all-back", act.setAllBack, { hidden: true });
    const groups = groupsOf([...book.rules.values()]).map((group, index) => groupElement(group, rows, index < 2));
    const head = make("div", { class: "gs-all-back" }, allBack);
    const element = section("Options", message.element, head, ...groups.map((group) => group.element));
    const update = (look) => {
        for (const [name, row] of rows) {
            row.update(optionValue(book, look, name), presetValue(book, look, name), name in look.options);
        }
        const names = Object.keys(look.options);
        allBack.hidden = names.length === 0;
        allBack.textContent = `Set all back (${names.length})`;
        groups.forEach((group) => group.update(names));
    };
    return { element, update, message };
}

/** Rules by their groups in the order of the schema; those without an everyday option come last. */
function groupsOf(rules) {
    const groups = new Map();
    for (const rule of rules) {
        groups.set(rule.group, [...(groups.get(rule.group) ?? []), rule]);
    }
    const all = [...groups].map(([name, members]) => ({ name, members, isEveryday: members.some((rule) => rule.isEveryday) }));
    return [...all.filter((group) => group.isEveryday), ...all.filter((group) => !group.isEveryday)];
}

/** A group: what people turn every day first, the rest folded. */
function groupElement(group, rows, isOpen) {
    const membersBy = (isEveryday) => group.members.filter((rule) => rule.isEveryday === isEveryday);
    const elements = (isEveryday) => membersBy(isEveryday).map((rule) => rows.get(rule.name).element);
    const rest = elements(false);
    const more = group.isEveryday && rest.length > 0 ? [folded("More", false, ...rest)] : rest;
    const count = make("span", { class: "gs-changed-count" });
    const title = make("span", {}, make("span", { text: group.name }), count);
    const element = folded(title, isOpen && group.isEveryday, ...elements(true), ...more);
    element.classList.add("gs-group");
    const update = (names) => {
        const changed = group.members.filter((rule) => names.includes(rule.name)).length;
        count.textContent = changed > 0 ? ` ${changed} changed` : "";
    };
    return { element, update };
}

/** One option: its name, what it is set to, how it is set back, and a hint. */
function optionRow(rule, context) {
    const name = labelOf(rule.name);
    const hint = uniqueId("hint");
    const labels = { name, hint, unit: rule.unit, absent: rule.absent?.word ?? "" };
    const set = (value, moving) => context.act.change(rule.name, value, moving);
    const state = { usual: null };
    const back = iconButton("back", `Set back ${name}`, "set-back", () => set(state.usual, false));
    const dot = make("span", { class: "gs-dot", role: "img", "aria-label": "changed", hidden: true });
    const input = inputOf(rule, labels, context, set);
    const [first, rest] = firstSentence(rule.description);
    const unseen = rest ? make("span", { class: "gs-unseen", text: ` ${rest}` }) : null;
    const hintElement = make("p", { class: "gs-hint", id: hint, text: first }, unseen);
    const label = make("label", { for: input.labelled.id, text: name });
    const head = make("div", { class: "gs-row-head" }, dot, label, back, ...input.beside);
    const attributes = { class: "gs-row", "data-option": rule.name, title: rule.description };
    const element = make("div", attributes, head, ...input.under, hintElement);
    element.querySelector("input[type=range]")?.addEventListener("dblclick", () => set(state.usual, false));
    const update = (value, usual, isChanged) => {
        state.usual = usual;
        element.classList.toggle("gs-is-changed", isChanged);
        dot.hidden = !isChanged;
        back.hidden = !isChanged;
        input.show(value, usual);
    };
    return { element, update };
}

/** The inputs of an option by what it takes: {labelled, beside, under, show}. */
function inputOf(rule, labels, context, set) {
    if (rule.isSwitch) {
        return switchInput(labels, set);
    }
    if (rule.pattern) {
        const read = (text) => (rule.absent && text.trim() === "" ? null : readValue(rule, text));
        const placeholder = rule.absent?.meaning ?? "";
        return rule.isList ? listInput(rule, labels, read, set) : colorInput(labels, read, set, placeholder);
    }
    if (!rule.isNumber) {
        return wordsInput(rule, labels, set);
    }
    return rule.words.length > 0 ? mixedInput(rule, labels, context, set) : numberInput(rule, labels, context, set);
}

/** A switch. */
function switchInput(labels, set) {
    const labelled = switchElement({ id: uniqueId("switch"), "aria-describedby": labels.hint });
    labelled.addEventListener("change", () => set(labelled.checked, false));
    const show = (value) => {
        labelled.checked = value === true;
    };
    return { labelled, beside: [labelled], under: [], show };
}

/** One of some words. */
function wordsInput(rule, labels, set) {
    const labelled = make("select", { id: uniqueId("words"), "aria-describedby": labels.hint });
    labelled.append(...rule.words.map((word) => make("option", { value: word, text: word })));
    labelled.addEventListener("change", () => set(labelled.value, false));
    const show = (value) => {
        labelled.value = value;
    };
    return { labelled, beside: [labelled], under: [], show };
}

/** A colour: as text, and picked. `read` gives the value of a text or undefined. */
export function colorInput(labels, read, set, placeholder = "") {
    const invalidId = uniqueId("invalid");
    const described = { "aria-describedby": `${labels.hint} ${invalidId}`, placeholder };
    const attributes = { type: "text", class: "gs-color-text", id: uniqueId("color"), spellcheck: "false" };
    const labelled = make("input", { ...attributes, ...described });
    const invalid = make("p", { class: "gs-invalid", id: invalidId, "aria-live": "polite" });
    const picker = make("input", { type: "color", "aria-label": `${labels.name}, picked` });
    const typed = () => {
        const value = read(labelled.value);
        labelled.setAttribute("aria-invalid", String(value === undefined));
        invalid.textContent = value === undefined ? "Allowed: white, black, #rgb or #rrggbb." : "";
        if (value !== undefined) {
            set(value, false);
        }
    };
    labelled.addEventListener("change", typed);
    picker.addEventListener("input", () => set(picker.value, true));
    picker.addEventListener("change", () => set(picker.value, false));
    const show = (value) => {
        labelled.value = value ?? "";
        labelled.setAttribute("aria-invalid", "false");
        invalid.textContent = "";
        picker.value = sixDigits(value ?? "white");
    };
    return { labelled, beside: [picker, labelled], under: [invalid], show };
}

/** Colours with names, as text, and each picked; one more can be added. */
function listInput(rule, labels, read, set) {
    const invalidId = uniqueId("invalid");
    const attributes = { type: "text", class: "gs-list-text", id: uniqueId("list"), spellcheck: "false", autocomplete: "off" };
    const described = { placeholder: rule.absent?.meaning ?? "", "aria-describedby": `${labels.hint} ${invalidId}` };
    const labelled = make("input", { ...attributes, ...described });
    const invalid = make("p", { class: "gs-invalid", id: invalidId, "aria-live": "polite" });
    const swatches = make("div", { class: "gs-swatches" });
    const state = { items: [] };
    const typed = () => {
        const value = read(labelled.value);
        labelled.setAttribute("aria-invalid", String(value === undefined));
        invalid.textContent = value === undefined ? allowedText(rule) : "";
        if (value !== undefined) {
            set(value, false);
        }
    };
    labelled.addEventListener("change", typed);
    const pick = (index, color, moving) => {
        const name = state.items[index].includes("=") ? `${state.items[index].split("=")[0]}=` : "";
        set(state.items.with(index, `${name}${color}`).join(","), moving);
    };
    const swatch = (item, index) => {
        const color = item.split("=").at(-1);
        const picker = make("input", { type: "color", "aria-label": `${labels.name}, ${index + 1} of ${state.items.length}` });
        picker.value = sixDigits(color);
        picker.addEventListener("input", () => pick(index, picker.value, true));
        picker.addEventListener("change", () => pick(index, picker.value, false));
        return picker;
    };
    const add = () => set([...state.items, nextColor(state.items)].join(","), false);
    const more = iconButton("plus", `${labels.name}: one more`, "add-ink", add);
    const show = (value) => {
        labelled.value = value ?? "";
        labelled.setAttribute("aria-invalid", "false");
        invalid.textContent = "";
        const count = state.items.length;
        state.items = value ? value.split(",").map((item) => item.trim()) : [];
        const pickers = [...swatches.querySelectorAll("input")];
        if (count !== state.items.length) {
            swatches.replaceChildren(...state.items.map(swatch), more);
        } else {
            // What is being picked stays open.
            pickers.forEach((picker, index) => (picker.value = sixDigits(state.items[index].split("=").at(-1))));
        }
        more.disabled = state.items.length >= MOST_INKS;
    };
    swatches.append(more);
    return { labelled, beside: [], under: [labelled, swatches, invalid], show };
}

/** A colour that is not among some yet: those of common printing inks first. */
function nextColor(items) {
    const colors = items.map((item) => sixDigits(item.split("=").at(-1)));
    const free = COMMON_INKS.find((color) => !colors.includes(color));
    const greys = Array.from({ length: MOST_INKS + 1 }, (_, index) => `#${(32 + 8 * index).toString(16).repeat(3)}`);
    return free ?? greys.find((color) => !colors.includes(color));
}

/** A colour as a color input takes it. */
function sixDigits(color) {
    const named = { white: "#ffffff", black: "#000000" }[color] ?? color;
    const long = /^#[0-9a-f]{3}$/i.test(named) ? `#${[...named.slice(1)].map((digit) => digit + digit).join("")}` : named;
    return /^#[0-9a-f]{6}$/i.test(long) ? long.toLowerCase() : "#ffffff";
}

/** A number; if it may be absent, with a checkbox of the word for that. */
function numberInput(rule, labels, context, set) {
    const parts = numberParts(rule, labels, context.mostNodes, set);
    const unit = rule.unit ? make("span", { class: "gs-unit", text: shortUnit(rule.unit), title: rule.unit }) : null;
    const state = { last: null };
    const absent = rule.absent && make("input", { type: "checkbox", "aria-label": `${labels.name}: ${rule.absent.word}` });
    absent?.addEventListener("change", () => set(absent.checked ? null : startValue(rule, parts, context, state.last), false));
    const absentLabel = absent && make("label", { class: "gs-absent", title: rule.absent.meaning }, absent, rule.absent.word);
    const goOn = () => set((parts.field.valueAsNumber || 0) + 1, false);
    const next = parts.scale ? null : button("Next", "next", goOn, { "aria-label": `Next ${labels.name}` });
    const show = (value, usual) => {
        state.last = [value, state.last, usual].find((each) => typeof each === "number") ?? null;
        if (absent) {
            absent.checked = value === null;
        }
        parts.show(value);
    };
    return { labelled: parts.field, beside: [absentLabel, parts.field, unit, next], under: [parts.slider, parts.invalid], show };
}

/** A number or a word: a select of the words, and "value" that shows the number. */
function mixedInput(rule, labels, context, set) {
    const parts = numberParts(rule, { ...labels, name: `${labels.name}, value` }, context.mostNodes, set);
    parts.field.setAttribute("aria-label", `${labels.name}, value`);
    const labelled = make("select", { id: uniqueId("words"), "aria-describedby": labels.hint });
    const absent = rule.absent ? [make("option", { value: "", text: rule.absent.word, title: rule.absent.meaning })] : [];
    labelled.append(...absent, ...rule.words.map((word) => make("option", { value: `=${word}`, text: word })));
    labelled.append(make("option", { value: VALUE, text: "value" }));
    const state = { last: null };
    labelled.addEventListener("change", () => {
        const word = labelled.value === "" ? null : labelled.value.slice(1);
        set(labelled.value === VALUE ? startValue(rule, parts, context, state.last) : word, false);
    });
    const show = (value, usual) => {
        const isNumber = typeof value === "number";
        state.last = [value, state.last, usual].find((each) => typeof each === "number") ?? null;
        labelled.value = isNumber ? VALUE : value === null ? "" : `=${value}`;
        parts.field.hidden = !isNumber;
        parts.slider.hidden = !isNumber;
        parts.show(value);
    };
    return { labelled, beside: [labelled, parts.field], under: [parts.slider, parts.invalid], show };
}

/** The number to begin with where there was a word: the last one, what the word means, what was counted, or a third along. */
function startValue(rule, parts, context, last) {
    const meaning = rule.absent?.meaning ? Number(rule.absent.meaning) : NaN;
    const candidates = [last, rule.usual, meaning, context.act.counted(rule.name)];
    return candidates.find((value) => typeof value === "number" && isAllowed(rule, value)) ?? parts.scale.value(1 / 3);
}

/** A unit that fits beside a field. */
function shortUnit(unit) {
    return { pixels: "px", "nodes per pixel": "/px", "per pixel": "/px" }[unit] ?? unit;
}
