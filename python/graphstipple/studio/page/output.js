// Taking the drawing along. In: the format, the command and the Python lines of the drawing. Out: the buttons that save and copy.

import { button, folded, make, messagePlace } from "./elements.js";

const TOLD_MS = 2500;

/** The foot of the panel; `save()` asks for the file. */
export function outputPart(save) {
    const download = button("Download", "download", save, { class: "gs-button gs-primary", disabled: true });
    const told = make("span", { class: "gs-told", role: "status" });
    const command = copyable("Copy as command line", "copy-command", told);
    const python = copyable("Copy as Python", "copy-python", told);
    const message = messagePlace();
    const texts = folded("Show the text", false, command.text, python.text);
    const copies = make("div", { class: "gs-buttons" }, command.button, python.button, told);
    const attributes = { class: "gs-output", "aria-label": "Download and copy" };
    const element = make("section", attributes, message.element, download, copies, texts);
    const setTexts = (words) => {
        command.set(words?.command ?? "");
        python.set(words?.python ?? "");
        texts.hidden = !words;
    };
    setTexts(null);
    return { element, message, download, setTexts };
}

/** A button that copies a text, and the text itself. */
function copyable(label, what, told) {
    const text = make("pre", { class: "gs-text" });
    const copy = async () => {
        told.textContent = "";
        const isCopied = await copyText(text.textContent, element);
        told.textContent = isCopied ? "Copied" : "Copying is not allowed here: select the text below.";
        setTimeout(() => (told.textContent = ""), TOLD_MS);
    };
    const element = button(label, what, copy);
    const set = (words) => {
        text.textContent = words;
        element.disabled = words === "";
    };
    return { button: element, text, set };
}

/** Copies a text; where the clipboard is out of reach, from a field that is selected. */
async function copyText(text, beside) {
    try {
        await navigator.clipboard.writeText(text);
        return true;
    } catch {
        const field = make("textarea", { class: "gs-unseen", "aria-hidden": "true", tabindex: "-1" });
        field.value = text;
        beside.after(field);
        field.select();
        const isCopied = document.execCommand("copy");
        field.remove();
        beside.focus();
        return isCopied;
    }
}

/** Saves bytes under a name. */
export function saveFile(name, mime, bytes) {
    const url = URL.createObjectURL(new Blob([bytes], { type: mime }));
    const link = make("a", { href: url, download: name, hidden: true });
    document.body.append(link);
    link.click();
    link.remove();
    setTimeout(() => URL.revokeObjectURL(url), 60_000);
}
