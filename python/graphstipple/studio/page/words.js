// Words and numbers as people read them. In: names, numbers, rules of options. Out: text.

const grouped = new Intl.NumberFormat("en", { maximumFractionDigits: 0 });

/** The label of an option or setting: "tone_tolerance" is "Tone tolerance", "dpi" is "DPI". */
export function labelOf(name) {
    const last = name.split(".").at(-1);
    return last.length <= 3 ? last.toUpperCase() : last[0].toUpperCase() + last.slice(1).replaceAll("_", " ");
}

/** A text in two: its first sentence and the rest. */
export function firstSentence(text) {
    const end = text.search(/\.\s/);
    return end < 0 ? [text, ""] : [text.slice(0, end + 1), text.slice(end + 2)];
}

/** A whole number with its thousands marked. */
export function groupedNumber(value) {
    return grouped.format(value);
}

/** A number as short as it can be said. */
export function plainNumber(value) {
    return Number.isInteger(value) ? String(value) : String(Number(value.toPrecision(12)));
}

/** A size of a file. */
export function fileSize(bytes) {
    if (bytes < 1000) {
        return `${bytes} B`;
    }
    const [value, unit] = bytes < 999_500 ? [bytes / 1000, "kB"] : [bytes / 1_000_000, "MB"];
    return `${value < 99.95 ? value.toFixed(1) : Math.round(value)} ${unit}`;
}

/** A duration in seconds. */
export function secondsText(seconds) {
    return `${seconds < 10 ? seconds.toFixed(2) : seconds.toFixed(1)} s`;
}

/** A length on paper, at most a tenth of its unit exact. */
export function lengthText(length) {
    return plainNumber(Math.round(length * 10) / 10);
}

/** What an option takes, in a sentence. */
export function allowedText(rule) {
    const words = [...rule.words, ...(rule.absent ? [rule.absent.word] : [])];
    if (rule.isList) {
        return "Allowed: colours with commas between them, each #rgb, #rrggbb, white or black, or name=colour with a name of a-z, 0-9 and -.";
    }
    if (!rule.isNumber) {
        return rule.pattern ? "Allowed: white, black, #rgb or #rrggbb." : `Allowed: ${words.join(", ")}.`;
    }
    const low = `${rule.isOpen ? "above " : ""}${rule.low >= 10_000 ? groupedNumber(rule.low) : plainNumber(rule.low)}`;
    const high = rule.high >= 10_000 ? groupedNumber(rule.high) : plainNumber(rule.high);
    const range = `${rule.isWhole ? "a whole number, " : ""}${low} to ${high}${rule.unit ? ` ${rule.unit}` : ""}`;
    return `Allowed: ${[...words, range].join(", ")}.`;
}
