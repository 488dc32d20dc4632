// The list of keys. In: nothing. Out: a button and the dialog that it opens.

import { button, make, uniqueId } from "./elements.js";

const KEYS = [
    ["Ctrl or Cmd + Z", "Undo"],
    ["Ctrl or Cmd + Shift + Z, Ctrl + Y", "Redo"],
    ["Ctrl or Cmd + V", "Open a photo from the clipboard"],
    ["+  −", "Zoom the stage in and out (or the wheel)"],
    ["0", "Fit the stage"],
    ["1", "One pixel of the photo to one of the screen"],
    ["Arrow keys", "Move the stage, a slider or the divider"],
    ["Page up, page down", "Move a slider by large steps"],
    ["Arrow keys, Space", "With the brush: move it (with Shift farther), and paint"],
    ["Escape", "Put the brush away"],
];

/** The button "Keys" and its dialog. */
export function keysHelp() {
    const id = uniqueId("keys");
    const close = button("Close", "keys-close", () => dialog.close());
    const rows = KEYS.map(([keys, what]) => make("div", {}, make("dt", { text: keys }), make("dd", { text: what })));
    const text = "The keys of the stage work while it has the focus. A double click on a slider sets it back.";
    const about = make("p", { class: "gs-hint", text });
    const heading = make("h2", { id, text: "Keys" });
    const dialog = make("dialog", { class: "gs-keys", "aria-labelledby": id }, heading, make("dl", {}, ...rows), about, close);
    dialog.addEventListener("click", (event) => {
        if (event.target === dialog) {
            dialog.close();
        }
    });
    return { button: button("Keys", "keys", () => dialog.showModal(), { "aria-haspopup": "dialog" }), dialog };
}
