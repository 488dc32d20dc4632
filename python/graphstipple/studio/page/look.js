// Looks: everything that makes a drawing. In: a look and a change. Out: a new look; none is ever altered.

/** What looks are made of: rules of options, presets by name, settings of files, and the look of a page just opened. */
export function lookBook(ready, rules) {
    return {
        rules,
        presets: new Map(ready.presets.map((preset) => [preset.name, preset])),
        settings: new Map(ready.settings.map((setting) => [setting.name, setting])),
        formats: ready.formats,
        sources: ready.sources.map((source) => source.form),
    };
}

/** The look of a page just opened. */
export function freshLook(book) {
    const preset = book.presets.has("default") ? "default" : book.presets.keys().next().value;
    return { preset, options: {}, importance: "saliency", settings: {}, min_dot: null, suffix: book.formats[0].suffix };
}

/** The value that an option has without changes. */
export function presetValue(book, look, name) {
    const values = book.presets.get(look.preset)?.values ?? {};
    return name in values ? values[name] : book.rules.get(name).usual;
}

/** The value of an option. */
export function optionValue(book, look, name) {
    return name in look.options ? look.options[name] : presetValue(book, look, name);
}

/** A look with one option changed. */
export function withOption(book, look, name, value) {
    const options = { ...look.options };
    delete options[name];
    return { ...look, options: value === presetValue(book, look, name) ? options : { ...options, [name]: value } };
}

/** A look with one setting of the file changed; null takes it away. */
export function withSetting(look, name, value) {
    const settings = { ...look.settings };
    delete settings[name];
    return { ...look, settings: value === null || value === "" ? settings : { ...settings, [name]: value } };
}

/** Whether a format takes a setting; `min_dot` is a length on paper, as the width is. */
export function takesSetting(book, suffix, name) {
    return book.settings.get(name === "min_dot" ? "width" : name)?.formats.includes(suffix) ?? false;
}

/** The look as the desk is told: without settings that the chosen format does not take. */
export function tellable(book, look) {
    const settings = Object.entries(look.settings).filter(([name]) => takesSetting(book, look.suffix, name));
    const minDot = takesSetting(book, look.suffix, "min_dot") ? look.min_dot : null;
    return { ...look, settings: Object.fromEntries(settings), min_dot: minDot };
}

/** Whether two looks make the same drawing and file. */
export function isSameLook(one, other) {
    return one === other || canonical(one) === canonical(other);
}

/** A look as text in which the order of its changes does not count. */
function canonical(look) {
    const sorted = (changes) => Object.entries(changes).sort(([one], [other]) => (one < other ? -1 : 1));
    return JSON.stringify([look.preset, sorted(look.options), look.importance, sorted(look.settings), look.min_dot, look.suffix]);
}
