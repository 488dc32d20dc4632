// The look in the address of the page. In: a look, or the text after #. Out: the other one.

import { freshLook, presetValue } from "./look.js";
import { readValue, writeValue } from "./rules.js";

/** What of a look differs from a fresh one, as the text after #. */
export function lookToText(book, look) {
    const fresh = freshLook(book);
    const entries = look.preset === fresh.preset ? [] : [["preset", look.preset]];
    for (const [name, value] of Object.entries(look.options)) {
        entries.push([name, writeValue(book.rules.get(name), value)]);
    }
    entries.push(...(look.importance === fresh.importance ? [] : [["importance", look.importance]]));
    entries.push(...Object.entries(look.settings).map(([name, value]) => [`file.${name}`, String(value)]));
    entries.push(...(look.min_dot === null ? [] : [["min_dot", look.min_dot]]));
    entries.push(...(look.suffix === fresh.suffix ? [] : [["suffix", look.suffix]]));
    return entries.map(([name, value]) => `${name}=${encoded(value)}`).join("&");
}

/** The look that a text after # means; what it does not know, it leaves out. */
export function textToLook(book, text) {
    const entries = text.replace(/^#/, "").split("&").map(pair).filter(([name]) => name !== "");
    const preset = entries.findLast(([name, value]) => name === "preset" && book.presets.has(value));
    const look = { ...freshLook(book), ...(preset ? { preset: preset[1] } : {}) };
    for (const [name, value] of entries) {
        takeEntry(book, look, name, value);
    }
    return look;
}

/** Puts one entry of an address into a new look. */
function takeEntry(book, look, name, text) {
    const setting = name.startsWith("file.") ? book.settings.get(name.slice(5)) : undefined;
    if (book.rules.has(name)) {
        const value = readValue(book.rules.get(name), text);
        if (value !== undefined && value !== presetValue(book, look, name)) {
            look.options[name] = value;
        }
    } else if (setting !== undefined) {
        const value = settingFromText(setting, text);
        if (value !== null) {
            look.settings[setting.name] = value;
        }
    } else if (name === "importance" && isSource(book, text)) {
        look.importance = text;
    } else if (name === "min_dot" && text !== "") {
        look.min_dot = text;
    } else if (name === "suffix" && book.formats.some((format) => format.suffix === text)) {
        look.suffix = text;
    }
}

/** The value of a setting as the desk takes it, or null if the text says none. */
export function settingFromText(setting, text) {
    const word = text.trim();
    if (setting.kind === "switch") {
        return word === "true" ? true : null;
    }
    if (setting.kind === "number") {
        return word !== "" && Number.isFinite(Number(word)) ? Number(word) : word || null;
    }
    return word || null;
}

/** Whether an importance can be had by this name. */
function isSource(book, text) {
    const [kind, value] = text.split(":");
    const isConstant = value !== undefined && book.sources.includes(`${kind}:V`) && Number(value) > 0 && Number(value) <= 1;
    return text === "painted" || isConstant || (book.sources.includes(text) && !text.includes(" "));
}

/** A value that may stand in an address and still be read. */
function encoded(value) {
    return encodeURIComponent(value).replaceAll("%3A", ":").replaceAll("%2C", ",").replaceAll("%2F", "/");
}

/** The name and the value of "name=value"; what cannot be decoded has no name. */
function pair(entry) {
    const at = entry.indexOf("=");
    try {
        return at < 0 ? ["", ""] : [decodeURIComponent(entry.slice(0, at)), decodeURIComponent(entry.slice(at + 1))];
    } catch {
        return ["", ""];
    }
}
