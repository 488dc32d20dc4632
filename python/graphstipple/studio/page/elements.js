// Small makers of elements. In: tags, attributes, children. Out: elements that are not in the document yet.

const SVG = "http://www.w3.org/2000/svg";
const ICONS = {
    undo: ["M6 4 2.500 7.500 6 11", "M3 7.500h6.500a4 4 0 0 1 0 8H7"],
    redo: ["M12 4l3.500 3.500L12 11", "M15 7.500H8.500a4 4 0 0 0 0 8H11"],
    back: ["M4 3.500v4h4", "M4.300 7.300A5.500 5.500 0 1 1 4 11"],
    plus: ["M9 3.500v11", "M3.500 9h11"],
    minus: ["M3.500 9h11"],
};
const counter = { last: 0 };

/** A name that no other element of the document has, for id, for and aria-describedby. */
export function uniqueId(what) {
    counter.last += 1;
    return `graphstipple-${what}-${counter.last}`;
}

/** An element: `text` is its text, `on...` are listeners, true is an attribute without a value, false and null none. */
export function make(tag, attributes = {}, ...children) {
    const element = document.createElement(tag);
    for (const [name, value] of Object.entries(attributes)) {
        if (name === "text") {
            element.textContent = value;
        } else if (name.startsWith("on")) {
            element.addEventListener(name.slice(2), value);
        } else if (value !== false && value !== null && value !== undefined) {
            element.setAttribute(name, value === true ? "" : value);
        }
    }
    element.append(...children.filter((child) => child !== null && child !== undefined));
    return element;
}

/** One of the icons, in the colour of the text beside it. */
function icon(name) {
    const svg = document.createElementNS(SVG, "svg");
    svg.setAttribute("viewBox", "0 0 18 18");
    svg.setAttribute("class", "gs-icon");
    svg.setAttribute("aria-hidden", "true");
    for (const line of ICONS[name]) {
        const path = document.createElementNS(SVG, "path");
        path.setAttribute("d", line);
        svg.append(path);
    }
    return svg;
}

/** A button with words. `what` is its hook for tests (data-do). */
export function button(text, what, onclick, attributes = {}) {
    return make("button", { type: "button", class: "gs-button", "data-do": what, text, onclick, ...attributes });
}

/** A button with an icon, whose words are read out and shown as a tooltip. */
export function iconButton(name, label, what, onclick, attributes = {}) {
    const usual = { type: "button", class: "gs-button gs-icon-button", "data-do": what, title: label, "aria-label": label };
    return make("button", { ...usual, onclick, ...attributes }, icon(name));
}

/** A switch: a checkbox that says so. */
export function switchElement(attributes) {
    return make("input", { type: "checkbox", role: "switch", class: "gs-switch", ...attributes });
}

/** A section of the panel with its heading. */
export function section(heading, ...children) {
    const id = uniqueId("heading");
    return make("section", { class: "gs-section", "aria-labelledby": id }, make("h2", { id, text: heading }), ...children);
}

/** What can be folded: a summary and what is under it. */
export function folded(summary, isOpen, ...children) {
    return make("details", { class: "gs-folded", open: isOpen }, make("summary", {}, summary), ...children);
}

/** A place for one sentence to the user: show("...") says it at once, show("") takes it away. */
export function messagePlace() {
    const element = make("div", { class: "gs-message-place" });
    const show = (sentence) => {
        if (element.textContent === sentence) {
            return;
        }
        element.replaceChildren(...(sentence ? [make("p", { class: "gs-message", role: "alert", text: sentence })] : []));
    };
    return { element, show };
}

/** Buttons of which one is chosen: items are {value, content, attributes}; arrow keys choose, too. */
export function radioGroup(label, className, items, onchoose) {
    const buttons = new Map();
    const choose = (value) => {
        for (const [name, each] of buttons) {
            each.setAttribute("aria-checked", String(name === value));
            each.tabIndex = name === value ? 0 : -1;
        }
        if (!buttons.has(value) && buttons.size > 0) {
            buttons.values().next().value.tabIndex = 0;
        }
    };
    const step = (event, from) => {
        const by = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[event.key];
        if (by === undefined || event.ctrlKey || event.metaKey || event.altKey) {
            return;
        }
        event.preventDefault();
        const values = [...buttons.keys()];
        const next = values[(values.indexOf(from) + by + values.length) % values.length];
        buttons.get(next).focus();
        onchoose(next);
    };
    for (const { value, content, attributes } of items) {
        const onkeydown = (event) => step(event, value);
        const all = { type: "button", role: "radio", ...attributes, onclick: () => onchoose(value), onkeydown };
        buttons.set(value, make("button", all, ...content));
    }
    const element = make("div", { class: className, role: "radiogroup", "aria-label": label }, ...buttons.values());
    return { element, buttons, choose };
}

/** A select of [value, words, tooltip] with its label beside it. */
export function labelledSelect(label, choices, onchange, attributes = {}) {
    const id = uniqueId("select");
    const select = make("select", { id, onchange: () => onchange(select.value), ...attributes });
    for (const [value, words, title] of choices) {
        select.append(make("option", { value, text: words, title }));
    }
    return { element: make("div", { class: "gs-line" }, make("label", { for: id, text: label }), select), select };
}
