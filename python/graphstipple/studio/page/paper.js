// Format, sizes on paper and other settings of the file. In: formats and settings. Out: the part of the panel that sets them.

import { folded, labelledSelect, make, section, switchElement, uniqueId } from "./elements.js";
import { colorInput } from "./controls.js";
import { settingFromText } from "./address.js";
import { takesSetting } from "./look.js";
import { labelOf, lengthText } from "./words.js";

const FIRST = ["width", "margin", "page", "min_dot", "dpi"];
const LONG = 20;
const MIN_DOT = {
    name: "min_dot",
    label: "Least dot radius",
    description: "Least radius of a dot on paper, such as 0.3mm: smaller ones grow where there is room, else they go",
    default: "none",
    kind: "length",
    words: null,
};

/** The section "Paper and file". `act` has setFormat(suffix), setSetting(name, value, moving), setMinDot(text). */
export function paperSection(book, act) {
    const formats = book.formats.map(({ suffix, name, description }) => [suffix, `${name} (.${suffix})`, description]);
    const format = labelledSelect("Format", formats, act.setFormat, { "data-do": "format" });
    const settings = [MIN_DOT, ...book.settings.values()].sort((one, other) => rank(one) - rank(other));
    const rows = settings.map((setting) => settingRow(setting, act));
    const isFirst = (row) => FIRST.includes(row.name);
    const rest = folded("More", false, ...rows.filter((row) => !isFirst(row)).map((row) => row.element));
    const sizes = make("p", { class: "gs-sizes" });
    const about = make("p", { class: "gs-hint" });
    const first = rows.filter(isFirst).map((row) => row.element);
    const element = section("Paper and file", format.element, about, ...first, sizes, rest);
    const update = (look) => {
        format.select.value = look.suffix;
        about.textContent = book.formats.find((each) => each.suffix === look.suffix)?.description ?? "";
        for (const row of rows) {
            row.element.hidden = !takesSetting(book, look.suffix, row.name);
            row.show(row.name === "min_dot" ? look.min_dot : look.settings[row.name] ?? null);
        }
        rest.hidden = rows.every((row) => isFirst(row) || row.element.hidden);
    };
    return { element, update, showSheet: (sheet) => (sizes.textContent = sheet ? sheetText(sheet) : "") };
}

/** Whether a setting is typed, so that what stands without it may be too long for its field. */
function isTyped(setting) {
    return setting.kind !== "switch" && !(setting.kind === "words" && setting.words);
}

/** What a setting is without being set, if that fits its field. */
function shortDefault(setting) {
    return setting.default.length > LONG ? "" : setting.default;
}

/** The sizes of a sheet in words. */
function sheetText({ page, drawing, unit }) {
    const size = ([width, height]) => `${lengthText(width)} × ${lengthText(height)} ${unit}`;
    return `On paper ${size(page)}, drawing ${size(drawing)}`;
}

/** Where a setting stands: sizes first, in the order in which they are thought of. */
function rank(setting) {
    const at = FIRST.indexOf(setting.name);
    return at < 0 ? FIRST.length : at;
}

/** One setting: its name and what it is set to. */
function settingRow(setting, act) {
    const hint = uniqueId("hint");
    const name = setting.label ?? labelOf(setting.name);
    const isMinDot = setting.name === "min_dot";
    const set = (value, moving) => (isMinDot ? act.setMinDot(value) : act.setSetting(setting.name, value, moving));
    const input = settingInput(setting, { name, hint }, set);
    const head = make("div", { class: "gs-row-head" }, make("label", { for: input.labelled.id, text: name }), ...input.beside);
    const usual = isTyped(setting) && setting.default.length > LONG ? `. Without: ${setting.default}` : "";
    const hintElement = make("p", { class: "gs-hint", id: hint, text: `${setting.description}${usual}` });
    const attributes = { class: "gs-row", "data-setting": setting.name, title: setting.description };
    const element = make("div", attributes, head, ...input.under, hintElement);
    const show = (value) => {
        element.classList.toggle("gs-is-changed", value !== null);
        input.show(value);
    };
    return { name: setting.name, element, show };
}

/** The inputs of a setting by its kind; null is a setting that is not set. */
function settingInput(setting, labels, set) {
    if (setting.kind === "color") {
        return colorInput(labels, (text) => text.trim() || null, set, shortDefault(setting));
    }
    if (setting.kind === "switch") {
        const labelled = switchElement({ id: uniqueId("switch"), "aria-describedby": labels.hint });
        labelled.addEventListener("change", () => set(labelled.checked ? true : null, false));
        const show = (value) => {
            labelled.checked = value === true;
        };
        return { labelled, beside: [labelled], under: [], show };
    }
    const labelled = isTyped(setting) ? textField(setting, labels) : wordsSelect(setting, labels);
    labelled.addEventListener("change", () => set(settingFromText(setting, labelled.value), false));
    const show = (value) => {
        labelled.value = value ?? "";
    };
    return { labelled, beside: [labelled], under: [], show };
}

/** A select of words; the first is what a file has without any. */
function wordsSelect(setting, labels) {
    const words = setting.words.filter((word) => word !== setting.default);
    const choices = [["", setting.default], ...words.map((word) => [word, word])];
    const options = choices.map(([value, text]) => make("option", { value, text }));
    return make("select", { id: uniqueId("words"), "aria-describedby": labels.hint }, ...options);
}

/** A field for a length or another text. */
function textField(setting, labels) {
    const mode = setting.kind === "number" ? { inputmode: "numeric" } : {};
    const plain = { type: "text", id: uniqueId("text"), spellcheck: "false", autocomplete: "off" };
    return make("input", { ...plain, ...mode, placeholder: shortDefault(setting), "aria-describedby": labels.hint });
}
